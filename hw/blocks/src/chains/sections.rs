//! The section memory: the fragments themselves, on chip and outside.
//!
//! ```text
//!  write (place, word) --->+----------+
//!  read (place) ---------->| Sections |---> words (Read of each side)
//!                          +----------+
//! ```
//! Those that pixels own and the first free ones are on chip (one cycle), the others outside
//! (`outside_latency` cycles).
//! One access a cycle to each; reads are pipelined. Each side answers in order and by itself: see [`super::answers`].

use super::answers::Words;
use super::config::Config;
use super::tables::{Place, Word};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Ram1RW, Signals, Stream, rtl};

/// See the module's description.
pub struct Sections;

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Where a fragment is written.
    #[with(*cfg)]
    pub write: Stream<Place>,
    /// The fragment.
    #[with(*cfg)]
    pub word: Word,
    /// Where a fragment is read.
    #[with(*cfg)]
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

#[rtl]
impl Config {
    /// Whether a section lies in outside memory.
    #[inline(always)]
    pub fn is_outside(&self, section: u32) -> bool {
        section >= self.first_outside()
    }
}

#[inline(always)]
#[rtl]
fn on_chip_address(cfg: &Config, place: Place) -> u32 {
    place.section * cfg.shape.capacity + place.slot
}

#[inline(always)]
#[rtl]
fn outside_address(cfg: &Config, place: Place) -> u32 {
    (place.section - cfg.first_outside()) * cfg.shape.capacity + place.slot
}

#[rtl(
    check(Sections, crate::test_util::small(true)),
    check(Sections, crate::test_util::small(false))
)]
impl Block for Sections {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Words;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let shape = &cfg.shape;
        Mem {
            on_chip: Ram1RW::new(cfg.first_outside() * shape.capacity, *cfg, 1),
            outside: Ram1RW::new(shape.outside * shape.capacity, *cfg, shape.outside_latency)
                .outside(),
        }
    }

    #[inline(always)]
    fn moore(_: &Config, (): &(), m: &Self::Mem) -> Words {
        Words { on_chip: m.on_chip.q(), outside: m.outside.q() }
    }

    #[inline(always)]
    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Self::Mem, i: In) {
        if i.write.valid {
            let place = i.write.payload;
            if cfg.is_outside(place.section) {
                m.outside.write(outside_address(cfg, place), i.word);
            } else {
                m.on_chip.write(on_chip_address(cfg, place), i.word);
            }
        }
        if i.read.valid {
            let place = i.read.payload;
            if cfg.is_outside(place.section) {
                m.outside.read(outside_address(cfg, place));
            } else {
                m.on_chip.read(on_chip_address(cfg, place));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chains::answers::only;
    use crate::chains::config::Shape;
    use crate::test_util::{Clocked, screen, shape};

    const ON_CHIP: u32 = 3;
    const SECTIONS: u32 = 5;
    const CAPACITY: u32 = 4;

    fn word(place: Place) -> Word {
        Word { z: place.section * 100 + place.slot, rgba: place.slot, ..Word::default() }
    }

    fn places() -> impl Iterator<Item = Place> {
        (0..SECTIONS).flat_map(|section| (0..CAPACITY).map(move |slot| Place { section, slot }))
    }

    fn reads(read: Stream<Place>) -> In {
        In { write: Stream::idle(), word: Word::default(), read }
    }

    /// A memory in which every place holds its own word.
    fn full(outside_latency: u32) -> Clocked<Sections> {
        let shape = Shape {
            on_chip: ON_CHIP,
            outside: SECTIONS - ON_CHIP,
            capacity: CAPACITY,
            outside_latency,
            ..shape()
        };
        let mut table = Clocked::<Sections>::new(Config::new(screen(2, 2), shape));
        for place in places() {
            let write = Stream::offer(place);
            table.clock(In { write, word: word(place), read: Stream::idle() }).unwrap();
        }
        table
    }

    #[test]
    fn an_answer_comes_at_its_cycle_and_is_that_places_own() {
        for outside_latency in [1, 2, 7] {
            for place in places() {
                let mut table = full(outside_latency);
                table.clock(reads(Stream::offer(place))).unwrap();
                let latency = if place.section < ON_CHIP { 1 } else { outside_latency };
                for after in 1..=10 {
                    let seen = only(table.moore());
                    assert_eq!(seen.valid, after == latency, "{place:?}, {after} cycles after");
                    assert!(!seen.valid || seen.data == word(place), "{place:?}");
                    table.clock(reads(Stream::idle())).unwrap();
                }
            }
        }
    }

    #[test]
    fn reads_are_pipelined() {
        let mut table = full(6);
        let outside: Vec<Place> = places().filter(|p| p.section >= ON_CHIP).collect();
        let mut seen = vec![];
        for cycle in 0..outside.len() + 6 {
            let answer = table.moore().outside;
            seen.extend(answer.valid.then_some((cycle, answer.data)));
            let read = outside.get(cycle).map_or(Stream::idle(), |place| Stream::offer(*place));
            table.clock(reads(read)).unwrap();
        }
        let expected: Vec<(usize, Word)> =
            outside.iter().enumerate().map(|(k, place)| (k + 6, word(*place))).collect();
        assert_eq!(seen, expected);
    }
}
