//! The section memory: the fragments themselves, on chip and outside.
//!
//! ```text
//!                           +----------+
//!  write (place, word) ---->|          |---> on_chip (Read)
//!  read (place) ----------->| Sections |---> request (Stream)
//!  ready <------------------|          |<--- taken
//!                           +----------+
//! ```
//! Those that pixels own and the first free ones are on chip, one access a cycle, and answer after a cycle; the others lie
//! behind the port to outside memory, which answers by itself: see [`super::answers`]. While `ready` is low, none of those
//! outside may be asked for.

use super::config::Config;
use super::tables::{Place, Word, packed};
use crate::skid::{self, Skid};
use pellucid_machine::outside::Request;
use pellucid_sim::{Block, Memory, Ram1RW, Read, Signals, Stream, rtl};

/// See the module's description.
pub struct Sections;

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// Where a fragment is written.
    #[with(*cfg)]
    pub write: Stream<Place>,
    /// The fragment.
    #[with(*cfg)]
    pub word: Word,
    /// Where a fragment is read. Never outside while one is written there.
    #[with(*cfg)]
    pub read: Stream<Place>,
    /// The outside memory takes the request.
    pub taken: bool,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// A request that the outside memory did not take yet.
    #[with(cfg.section_port())]
    #[exists(cfg.shape.outside > 0)]
    #[block(Requests)]
    pub requests: skid::State<Request>,
}

type Requests = Skid<Request>;

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The fragment on chip that was asked for.
    #[with(*cfg)]
    pub on_chip: Read<Word>,
    /// Sections outside may be asked for.
    pub ready: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What is asked of the outside memory.
    #[with(cfg.section_port())]
    #[exists(cfg.shape.outside > 0)]
    pub request: Stream<Request>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Sections on chip.
    pub on_chip: Ram1RW<Word>,
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
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn memories(cfg: &Config) -> Mem {
        Mem { on_chip: Ram1RW::new(cfg.first_outside() * cfg.shape.capacity, *cfg, 1) }
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let mut ready = true;
        if cfg.shape.outside > 0 {
            ready = Requests::moore(&cfg.section_port(), &q.requests, &()).ready;
        }
        Moore { on_chip: m.on_chip.q(), ready }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (write, read) = (i.write.payload, i.read.payload);
        if i.write.valid && !cfg.is_outside(write.section) {
            m.on_chip.write(on_chip_address(cfg, write), i.word);
        }
        if i.read.valid && !cfg.is_outside(read.section) {
            m.on_chip.read(on_chip_address(cfg, read));
        }
        let mut request = Stream::idle();
        if cfg.shape.outside > 0 {
            let writes = i.write.valid && cfg.is_outside(write.section);
            let reads = i.read.valid && cfg.is_outside(read.section);
            let mut push = Stream::idle();
            if writes || reads {
                let place = if writes { write } else { read };
                let address = outside_address(cfg, place);
                push = Stream::offer(Request { write: writes, address, word: packed(i.word) });
            }
            let to_requests = skid::In { push, taken: i.taken };
            request = Requests::next(
                &cfg.section_port(),
                &q.requests,
                &mut d.requests,
                &mut (),
                to_requests,
            );
        }
        Out { request }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chains::config::Shape;
    use crate::test_util::{Clocked, pattern, screen, shape};
    use proptest::prelude::*;

    const ON_CHIP: u32 = 3;
    const OUTSIDE: u32 = 2;
    const CAPACITY: u32 = 4;

    fn word(place: Place) -> Word {
        Word { z: place.section * 100 + place.slot, rgba: place.slot, ..Word::default() }
    }

    fn places(sections: std::ops::Range<u32>) -> impl Iterator<Item = Place> {
        sections.flat_map(|section| (0..CAPACITY).map(move |slot| Place { section, slot }))
    }

    fn reads(place: Place) -> In {
        let write = Stream::idle();
        In { write, word: Word::default(), read: Stream::offer(place), taken: true }
    }

    fn writes(place: Place) -> In {
        let read = Stream::idle();
        In { write: Stream::offer(place), word: word(place), read, taken: true }
    }

    fn sections() -> Clocked<Sections> {
        let shape = Shape { on_chip: ON_CHIP, outside: OUTSIDE, capacity: CAPACITY, ..shape() };
        Clocked::new(Config::new(screen(2, 2), shape))
    }

    #[test]
    fn those_on_chip_answer_after_a_cycle_with_their_own_word() {
        let mut table = sections();
        for place in places(0..ON_CHIP) {
            assert!(!table.clock(writes(place)).unwrap().request.valid);
        }
        for place in places(0..ON_CHIP) {
            assert!(!table.clock(reads(place)).unwrap().request.valid);
            let seen = table.moore().on_chip;
            assert_eq!(seen, Read { valid: true, data: word(place) });
        }
    }

    proptest! {
        /// Each access is asked of the port once, in order and at once if it is taken: fragments lie one after the other.
        #[test]
        fn those_outside_are_asked_of_the_port(
            accesses in proptest::collection::vec((any::<bool>(), 0..OUTSIDE, 0..CAPACITY), 0..40),
            taken in pattern(),
        ) {
            let mut table = sections();
            let (mut asked, mut seen) = (vec![], vec![]);
            let mut accesses = accesses.into_iter();
            for cycle in 0.. {
                let next = if table.moore().ready { accesses.next() } else { None };
                let mut i = In { taken: taken.at(cycle), ..In::default() };
                if let Some((write, section, slot)) = next {
                    let place = Place { section: ON_CHIP + section, slot };
                    let of = if write { writes(place) } else { reads(place) };
                    i = In { taken: i.taken, ..of };
                    let stored = if write { word(place) } else { Word::default() };
                    asked.push(Request {
                        write,
                        address: section * CAPACITY + slot,
                        word: packed(stored),
                    });
                }
                let out = table.clock(i).unwrap();
                prop_assert_eq!(out.request.valid, asked.len() > seen.len());
                prop_assert!(!table.moore().on_chip.valid);
                if out.request.valid && i.taken {
                    seen.push(out.request.payload);
                }
                if accesses.len() == 0 && seen.len() == asked.len() {
                    break;
                }
            }
            prop_assert_eq!(seen, asked);
        }
    }

    #[test]
    fn a_port_that_always_takes_has_no_pause() {
        let mut table = sections();
        for place in places(ON_CHIP..ON_CHIP + OUTSIDE).chain(places(ON_CHIP..ON_CHIP + 1)) {
            assert!(table.moore().ready);
            assert!(table.clock(writes(place)).unwrap().request.valid);
        }
    }
}
