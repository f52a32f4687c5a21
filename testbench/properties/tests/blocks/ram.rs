use crate::found::{self, fault};
use pellucid_properties::harness::{Must, check};
use pellucid_properties::ram::{Config, Model, Property, Ram, Step};
use pellucid_properties::ram_properties;
use pellucid_sim::{Memory, Ports, Ram1R1W, Ram1RW, Read, ReadDuringWrite, Storage};

ram_properties!(Ram1R1W<u32>, two_ports);
ram_properties!(Ram1RW<u32>, one_port);
ram_properties!(Wrong, right);

/// What is wrong with [`Wrong`].
const LATE: u32 = 1;
const SWAPPED: u32 = 2;
const LOST: u32 = 3;
const UNHELD: u32 = 4;
const WIPED: u32 = 5;
const UNSTOPPED: u32 = 6;
const HEEDLESS: u32 = 7;
const BEYOND: u32 = 8;

/// A memory with two ports, and a fault.
struct Wrong {
    ram: Ram1R1W<u32>,
    /// Which words were written.
    words: Vec<bool>,
    read: Option<u32>,
    written: bool,
}

impl Memory for Wrong {
    fn clock(&mut self) -> bool {
        (self.read, self.written) = (None, false);
        self.ram.clock()
    }
    fn reset(&mut self) {
        if fault() != UNSTOPPED {
            self.ram.reset();
        }
        if fault() == WIPED {
            self.ram.write(0, 0);
            self.ram.clock();
        }
    }
    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        self.ram.visit(path, to);
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        self.ram.each(to);
    }
}

impl Ram for Wrong {
    const PORTS: Ports = Ports::OneReadOneWrite;
    fn new(cfg: &Config) -> Self {
        use ReadDuringWrite::{New, Old};
        let policy = match cfg.read_during_write {
            Old if fault() == SWAPPED => New,
            New if fault() == SWAPPED => Old,
            policy => policy,
        };
        let latency = cfg.latency + u32::from(fault() == LATE);
        let ram = Ram1R1W::new(cfg.words, cfg.bits, latency, policy);
        Wrong { ram, words: vec![false; cfg.words as usize], read: None, written: false }
    }
    fn q(&self) -> Read<u32> {
        let q = self.ram.q();
        if fault() == UNHELD && !q.valid { Read::default() } else { q }
    }
    fn read(&mut self, addr: u32) {
        if fault() != HEEDLESS || self.read.is_none() {
            self.ram.read(addr);
        }
        self.read = Some(addr);
    }
    fn write(&mut self, addr: u32, data: u32) {
        let again = std::mem::replace(&mut self.words[addr as usize], true);
        let lost = fault() == LOST && again && self.read.is_some_and(|read| read != addr);
        let heedless = fault() == HEEDLESS && self.written;
        let beyond = fault() == BEYOND && data == 2;
        if !lost && !heedless {
            self.ram.write(if beyond { self.words.len() as u32 } else { addr }, data);
        }
        self.written = true;
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Wrong>>(fault, property);
}

#[test]
fn data_that_comes_late_or_after_a_reset_is_found() {
    is_found(LATE, Property::Valid);
    is_found(UNSTOPPED, Property::Valid);
}

#[test]
fn a_read_that_meets_a_write_and_gives_the_wrong_word_is_found() {
    is_found(SWAPPED, Property::Meets);
}

#[test]
fn a_word_that_is_lost_is_found() {
    is_found(LOST, Property::Data);
    is_found(WIPED, Property::Data);
}

#[test]
fn data_that_does_not_stay_is_found() {
    is_found(UNHELD, Property::Held);
}

#[test]
fn a_misuse_that_nobody_reports_is_found() {
    is_found(HEEDLESS, Property::Misuse);
}

#[test]
fn a_fault_is_found() {
    is_found(BEYOND, Property::Fault);
}

/// The shortest sequence for a write that is lost where another word is read.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Wrong>>(LOST);
    let expected = format!(
        "broken in cycle 4: a read gives what was last written before it: 1 came where 2 is due\n\
         its waveform: gtkwave {}\n\
         2 words of 2 bits, latency 1, read during write Old, cycle by cycle:\n     \
         0  write 0 to 0\n     1  write 1 to 1\n     2  read 0, write 2 to 1\n     3  read 1\n     \
         4  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Data);
    let valid = found::shown(&folder, "memory.wires.out.q.valid");
    assert_eq!(valid, [(0, 0), (3, 1)]);
    assert_eq!(found::shown(&folder, "memory.wires.out.q.data"), [(0, 0), (4, 1)]);
}

#[test]
fn a_misuse_ends_a_sequence_that_keeps_the_contract() {
    let cfg = Config { words: 2, bits: 8, latency: 1, read_during_write: ReadDuringWrite::New };
    let write = Step { write: Some(0), ..Step::default() };
    let both = Step { read: Some(0), misuse: true, ..write };
    // One port is misused by a read and a write, two ports by two reads.
    assert_eq!(check::<Model<Ram1RW<u32>>>(&cfg, &[write, both, write]), Ok(()));
    assert_eq!(check::<Model<Ram1R1W<u32>>>(&cfg, &[write, both, write]), Ok(()));
    let broken =
        found::with(HEEDLESS, || check::<Model<Wrong>>(&cfg, &[write, both, write])).unwrap_err();
    assert_eq!((broken.property, broken.cycle), (Must::Keep(Property::Misuse), 1));
}
