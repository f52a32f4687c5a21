use super::*;
use crate::chains::config::Shape;
use crate::test_util::{Pattern, Source, contents, edge, holding, pattern, screen, shape, traffic};
use pellucid_sim::{ReadDuringWrite, Sim, StreamMonitor};
use proptest::prelude::*;

/// Walks over `words`, which are sent in the cycles of `starts`; gives the bits with the cycles in which they
/// were taken.
fn walk(words: &[u64], starts: &Pattern, ready: &Pattern) -> Vec<(u64, u32)> {
    let cfg = Config::new(screen(64, 64), Shape { bitmap: true, ..shape() });
    let mut sim = Sim::<BitWalk>::new(cfg);
    let mut memory = holding(words, WORD_BITS, ReadDuringWrite::Forbidden);
    let before = traffic(&mut memory);
    let mut source = Source::new(0..words.len() as u32, starts.clone());
    let mut monitor = StreamMonitor::new("bit", "BitWalk", "test");
    let (mut bits, mut takes, mut taken) = (vec![], false, 0);
    for cycle in 0.. {
        assert!(cycle < 100_000, "the walk does not end: {bits:?}");
        let moore = sim.moore();
        let bit = moore.bit.with(ready.at(cycle));
        monitor.observe(bit).unwrap();
        if taken == words.len() && moore.idle {
            break;
        }
        // A word that was asked for waits no longer than there are bits of the one before.
        assert_eq!(moore.idle, !bit.valid && !takes, "cycle {cycle}");
        bits.extend(bit.fires().then_some((cycle, bit.payload)));
        let i = In { word: source.offer(cycle), data: memory.q(), bit_ready: bit.ready };
        let out = sim.clock(i).unwrap().out;
        assert_eq!(out.take, out.read.asked().is_some());
        source.edge(out.take);
        takes = out.take;
        taken += usize::from(takes);
        memory.pass_read(out.read);
        memory.pass_write(out.clear);
        edge(&mut memory);
    }
    // Each word is read once, and cleared if there was something in it.
    let (reads, writes) = traffic(&mut memory);
    let full = words.iter().filter(|word| **word != 0).count() as u64;
    assert_eq!((reads - before.0, writes - before.1), (words.len() as u64, full));
    assert_eq!(contents(&mut memory, words.len() as u32), vec![0; words.len()]);
    bits
}

fn places(bits: &[(u64, u32)]) -> Vec<u32> {
    bits.iter().map(|(_, bit)| *bit).collect()
}

fn cycles(words: &[u64]) -> Vec<u64> {
    let bits = walk(words, &Pattern::always(), &Pattern::always());
    bits.iter().map(|(cycle, _)| *cycle).collect()
}

#[test]
fn a_bits_number_is_that_of_its_word_times_64_and_its_place() {
    let words = [1 | 1 << 5 | 1 << 63, 0, 1 << 1, 1 << 63];
    let bits = walk(&words, &Pattern::always(), &Pattern::always());
    assert_eq!(places(&bits), [0, 5, 63, 129, 255]);
}

#[test]
fn one_bit_a_cycle_across_words() {
    // Asked for, there, sent: the first bit comes two cycles after its word.
    assert_eq!(cycles(&[u64::MAX, 1, 1, 0b110, 1 << 63]), (2..71).collect::<Vec<_>>());
}

#[test]
fn a_word_without_any_takes_a_cycle() {
    assert_eq!(cycles(&[1, 0, 0, 0, 1]), [2, 6]);
    assert_eq!(cycles(&[0, 0, 1]), [4]);
    // One of them is looked up while the word before it is sent.
    assert_eq!(cycles(&[0b111, 0, 1]), [2, 3, 4, 6]);
}

proptest! {
    /// Every set bit once, lowest first, however words and receiver come and go.
    #[test]
    fn sends_every_set_bit(
        words in proptest::collection::vec(
            prop_oneof![2 => Just(0_u64), 2 => (0..64_u32).prop_map(|k| 1 << k), 1 => any::<u64>()],
            1..12,
        ),
        starts in pattern(),
        ready in pattern(),
    ) {
        let set = (0..64 * words.len() as u32).filter(|k| words[(k / 64) as usize] >> (k % 64) & 1 == 1);
        prop_assert_eq!(places(&walk(&words, &starts, &ready)), set.collect::<Vec<_>>());
    }
}
