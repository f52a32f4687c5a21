use super::*;

/// One cycle of a two-port memory: a read and a write, each if given.
fn step(ram: &mut Ram1R1W<u32>, read: Option<u32>, write: Option<(u32, u32)>) -> bool {
    if let Some(addr) = read {
        ram.read(addr);
    }
    if let Some((addr, data)) = write {
        ram.write(addr, data);
    }
    ram.clock()
}

#[test]
fn reads_are_pipelined() {
    let mut ram = Ram1RW::<u32>::new(8, 32, 3);
    for addr in 0..8 {
        ram.write(addr, addr * 10);
        ram.clock();
    }
    let mut seen = vec![];
    for cycle in 0..12 {
        if cycle < 8 {
            ram.read(cycle);
        }
        ram.clock();
        if ram.q().valid {
            seen.push((cycle, ram.q().data));
        }
    }
    let expected: Vec<(u32, u32)> = (0..8).map(|k| (k + 2, k * 10)).collect();
    assert_eq!(seen, expected);
    assert_eq!((ram.info().reads, ram.info().writes), (8, 8));
}

#[test]
#[cfg(debug_assertions)]
fn a_forbidden_read_during_write_is_reported() {
    let mut ram = Ram1R1W::<u32>::new(4, 32, 1, ReadDuringWrite::Forbidden);
    step(&mut ram, None, Some((0, 1)));
    assert!(step(&mut ram, Some(0), Some((0, 2))));
    assert_eq!(ram.take_fault(), Some(FaultKind::ReadDuringWrite(0)));
}

#[test]
fn misuse_is_reported() {
    let mut ram = Ram1R1W::<u32>::new(4, 32, 1, ReadDuringWrite::New);
    ram.write(1, 0);
    ram.read(1);
    assert!(step(&mut ram, Some(1), None));
    assert_eq!(ram.take_fault(), Some(FaultKind::PortUsedTwice("read")));
    let mut user = WritePort::default();
    user.write(2, 0);
    ram.pass_write(user);
    assert!(step(&mut ram, None, Some((1, 0))));
    assert_eq!(ram.take_fault(), Some(FaultKind::PortUsedTwice("write")));
    assert!(step(&mut ram, None, Some((4, 0))));
    assert_eq!(ram.take_fault(), Some(FaultKind::Address { addr: 4, words: 4 }));
    assert!(!step(&mut ram, None, None));
    let mut single = Ram1RW::<u32>::new(4, 32, 1);
    single.write(0, 0);
    let mut user = Port::default();
    user.read(0);
    single.pass(user);
    assert!(single.clock());
    assert_eq!(single.take_fault(), Some(FaultKind::PortUsedTwice("only")));
}

#[test]
#[cfg(debug_assertions)]
fn reading_an_unwritten_word_is_reported() {
    let mut ram = Ram1R1W::<u32>::new(4, 32, 1, ReadDuringWrite::New);
    assert!(step(&mut ram, Some(2), None));
    assert_eq!(ram.take_fault(), Some(FaultKind::Unwritten(2)));
}

/// A word of three bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
struct Small {
    flag: bool,
    #[width(2)]
    number: u32,
}

#[test]
fn words_of_few_bits_are_packed_and_keep_to_themselves() {
    const WORDS: u32 = 100;
    let word = |k: u32| Small { flag: k.is_multiple_of(3), number: k % 4 };
    let mut ram = Ram1R1W::<Small>::new(WORDS, (), 1, ReadDuringWrite::New);
    assert!(matches!(ram.core.words, Cells::Packed(_)));
    assert!(matches!(Ram1RW::<u32>::new(WORDS, 5, 1).core.words, Cells::Values(_)));
    // In an order in which each has neighbours that are written before and after it.
    for k in (0..WORDS).map(|k| k * 37 % WORDS) {
        ram.write(k, word(k + 1));
        assert!(!ram.clock());
        ram.write(k, word(k));
        assert!(!ram.clock());
    }
    for k in 0..WORDS {
        ram.read(k);
        assert!(!ram.clock());
        assert_eq!(ram.q(), Read { valid: true, data: word(k) }, "word {k}");
    }
    ram.read(WORDS);
    assert!(ram.clock());
    let fault = Some(FaultKind::Address { addr: WORDS, words: WORDS.into() });
    assert_eq!(ram.take_fault(), fault);
}

/// A word of two bits is packed.
#[test]
fn room_for_words_changes_none_of_them() {
    for bits in [2, 32] {
        let mut ram = Ram1R1W::<u32>::new(5000, bits, 1, ReadDuringWrite::New);
        ram.reserve().unwrap();
        for (addr, data) in [(0, 1), (4999, 3), (2000, 2)] {
            step(&mut ram, None, Some((addr, data)));
        }
        let mut words = vec![];
        [0, 4999, 2000, 1].iter().for_each(|addr| ram.peek(*addr, &mut words));
        assert_eq!(words, [1, 3, 2, 0]);
    }
}
