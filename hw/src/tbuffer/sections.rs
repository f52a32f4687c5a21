//! The section memory: the fragments themselves, on chip and outside.
//!
//! ```text
//!  write (place, word) --->+----------+
//!  read (place) ---------->| Sections |---> word (Read)
//!                          +----------+
//! ```
//! Sections below `sections` are on chip (one cycle), the others outside (`outside_latency` cycles).
//! One access a cycle to each; reads are pipelined. Answers of the two must not meet: a reader
//! changes from one to the other only when nothing is under way.

use super::config::Config;
use super::tables::{Place, Word};
use pellucid_sim::block::{Block, D, Q};
use pellucid_sim::{Memory, Port, Ram1RW, Read, Stream, width_of};

/// See the module's description.
pub struct Sections;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Where a fragment is written.
    pub write: Stream<Place>,
    /// The fragment.
    pub word: Word,
    /// Where a fragment is read.
    pub read: Stream<Place>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Sections on chip.
    pub on_chip: Ram1RW<Word>,
    /// Sections in outside memory.
    pub outside: Ram1RW<Word>,
}

impl Config {
    /// Whether a section lies in outside memory.
    #[inline(always)]
    pub fn is_outside(&self, section: u32) -> bool {
        section >= self.params.sections
    }
}

impl Block for Sections {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<Word>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let bits = width_of::<Word>(cfg);
        let params = &cfg.params;
        Mem {
            on_chip: Ram1RW::new(params.sections * cfg.capacity, bits, 1),
            outside: Ram1RW::new(
                params.outside_sections * cfg.capacity,
                bits,
                params.outside_latency,
            ),
        }
    }

    #[inline(always)]
    fn moore(_: &Config, (): &(), m: &Q<Self>) -> Read<Word> {
        if m.outside.valid { m.outside } else { m.on_chip }
    }

    #[inline(always)]
    fn next(cfg: &Config, (): (), _: Q<Self>, i: In) -> ((), (), D<Self>) {
        let (mut on_chip, mut outside) = (Port::default(), Port::default());
        if i.write.valid {
            let Place { section, slot } = i.write.payload;
            if cfg.is_outside(section) {
                outside.write((section - cfg.params.sections) * cfg.capacity + slot, i.word);
            } else {
                on_chip.write(section * cfg.capacity + slot, i.word);
            }
        }
        if i.read.valid {
            let Place { section, slot } = i.read.payload;
            if cfg.is_outside(section) {
                outside.read((section - cfg.params.sections) * cfg.capacity + slot);
            } else {
                on_chip.read(section * cfg.capacity + slot);
            }
        }
        ((), (), MemD { on_chip, outside })
    }
}
