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
//!
//! Where weights are kept in memory fragments are written and read in one cycle. A write goes first, and a read that it meets
//! on its side waits in a queue of that side, as those that come behind it: so both sides work while one has more to do. Each
//! side says whether it takes reads.

use super::config::Config;
use super::tables::{Place, Word, packed};
use crate::skid::{self, Skid};
use pellucid_machine::outside::Request;
use pellucid_sim::{Block, Fifo, Memory, Ram1RW, Read, Signals, Stream, fifo, rtl};

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
    /// Where a fragment is read. Only where weights are kept in memory while one is written.
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
    /// Reads on chip that wait.
    #[with(WAITING)]
    #[exists(cfg.weighs())]
    #[block(Reads, waiting(true, cfg))]
    pub on_chip_reads: fifo::State,
    /// Those outside.
    #[with(WAITING)]
    #[exists(cfg.weighs() && cfg.shape.outside > 0)]
    #[block(Reads, waiting(true, cfg))]
    pub outside_reads: fifo::State,
}

/// Reads that wait on a side.
const WAITING: u32 = 16;

type Requests = Skid<Request>;
type Reads = Fifo<Place>;

#[inline(always)]
fn waiting(exists: bool, cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: if exists { WAITING } else { 0 }, item: *cfg }
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The fragment on chip that was asked for.
    #[with(*cfg)]
    pub on_chip: Read<Word>,
    /// Sections outside may be asked for.
    pub ready: bool,
    /// Which reads may come while something is written.
    #[exists(cfg.weighs())]
    pub reads: ReadsReady,
}

/// On which sides reads may come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct ReadsReady {
    /// Those on chip.
    pub on_chip: bool,
    /// Those outside.
    pub outside: bool,
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
    /// Reads on chip that wait.
    pub on_chip_reads: <Reads as Block>::Mem,
    /// Those outside.
    pub outside_reads: <Reads as Block>::Mem,
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

/// What a side does about reads.
#[derive(Clone, Copy, Debug, Signals)]
struct Served {
    /// The one that is carried out.
    #[with(*cfg)]
    read: Stream<Place>,
    /// What its queue is told.
    #[with(fifo::Config { depth: WAITING, item: *cfg })]
    queue: fifo::In<Place>,
}

/// What a side does about a read that comes, where one is at the front of its queue, and it is free or not.
#[inline(always)]
#[rtl]
fn serve(comes: Stream<Place>, front: Stream<Place>, free: bool) -> Served {
    let first = if front.valid { front } else { comes };
    let waits = comes.valid && (front.valid || !free);
    Served {
        read: Stream { valid: first.valid && free, payload: first.payload },
        queue: fifo::In { push: Stream { valid: waits, payload: comes.payload }, pop: free },
    }
}

#[rtl(
    check(Sections, crate::test_util::small(true)),
    check(Sections, crate::test_util::small(false)),
    check(Sections, crate::test_util::small_owned(true))
)]
impl Block for Sections {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn memories(cfg: &Config) -> Mem {
        Mem {
            on_chip: Ram1RW::new(cfg.first_outside() * cfg.shape.capacity, *cfg, 1),
            on_chip_reads: Reads::memories(&waiting(cfg.weighs(), cfg)),
            outside_reads: Reads::memories(&waiting(cfg.weighs() && cfg.shape.outside > 0, cfg)),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let mut ready = true;
        if cfg.shape.outside > 0 {
            ready = Requests::moore(&cfg.section_port(), &q.requests, &()).ready;
        }
        let mut reads = ReadsReady::default();
        if cfg.weighs() {
            let waiting = waiting(true, cfg);
            reads.on_chip = Reads::moore(&waiting, &q.on_chip_reads, &m.on_chip_reads).ready;
            if cfg.shape.outside > 0 {
                reads.outside = Reads::moore(&waiting, &q.outside_reads, &m.outside_reads).ready;
            }
        }
        Moore { on_chip: m.on_chip.q(), ready, reads }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (write, place) = (i.write.payload, i.read.payload);
        let writes_outside = i.write.valid && cfg.is_outside(write.section);
        let writes = i.write.valid && !writes_outside;
        let reads_outside = i.read.valid && cfg.is_outside(place.section);
        let mut read = Stream { valid: i.read.valid && !reads_outside, payload: place };
        if cfg.weighs() {
            let waiting = waiting(true, cfg);
            let front = Reads::moore(&waiting, &q.on_chip_reads, &m.on_chip_reads).front;
            let served = serve(read, front, !writes);
            read = served.read;
            let queue = served.queue;
            Reads::next(
                &waiting,
                &q.on_chip_reads,
                &mut d.on_chip_reads,
                &mut m.on_chip_reads,
                queue,
            );
        }
        if writes {
            m.on_chip.write(on_chip_address(cfg, write), i.word);
        }
        if read.valid {
            m.on_chip.read(on_chip_address(cfg, read.payload));
        }
        let mut request = Stream::idle();
        if cfg.shape.outside > 0 {
            let mut read = Stream { valid: reads_outside, payload: place };
            if cfg.weighs() {
                let waiting = waiting(true, cfg);
                let ready = Requests::moore(&cfg.section_port(), &q.requests, &()).ready;
                let front = Reads::moore(&waiting, &q.outside_reads, &m.outside_reads).front;
                let served = serve(read, front, ready && !writes_outside);
                read = served.read;
                let queue = served.queue;
                Reads::next(
                    &waiting,
                    &q.outside_reads,
                    &mut d.outside_reads,
                    &mut m.outside_reads,
                    queue,
                );
            }
            let mut push = Stream::idle();
            if writes_outside || read.valid {
                let place = if writes_outside { write } else { read.payload };
                let address = outside_address(cfg, place);
                push =
                    Stream::offer(Request { write: writes_outside, address, word: packed(i.word) });
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
    use crate::test_util::{Clocked, pattern, screen, shape, small_owned};
    use proptest::prelude::*;
    use std::collections::VecDeque;

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

        /// With weights in memory a write goes at once, and a read in the first cycle in which nothing is written on its side and
        /// all reads before it there have gone; outside, one that the port has room in.
        #[test]
        fn a_read_waits_for_writes_on_its_side_alone(
            accesses in proptest::collection::vec(proptest::option::of((0..20u32, 0..6u32, any::<[bool; 4]>())), 0..60),
            taken in pattern(),
        ) {
            let cfg = small_owned(true);
            let mut table = Clocked::<Sections>::new(cfg);
            for section in 0..cfg.first_outside() {
                let place = Place { section, slot: 0 };
                table.clock(writes(place)).unwrap();
            }
            let mut waiting = [VecDeque::new(), VecDeque::new()];
            let (mut asked, mut requests, mut accesses) = (vec![], vec![], accesses.into_iter());
            for cycle in 0.. {
                let seen = table.moore();
                // What is written and read lies in slots of its own.
                let mut i = In { taken: taken.at(cycle), ..In::default() };
                let next = accesses.next();
                if let Some((on_chip, outside, [reads, there, writes, too])) = next.flatten() {
                    let side = |is| if is { cfg.first_outside() + outside } else { on_chip };
                    let place = Place { section: side(there), slot: 0 };
                    let open = if there { seen.reads.outside } else { seen.reads.on_chip };
                    i.read = Stream { valid: reads && open, payload: place };
                    let place = Place { section: side(too), slot: 1 };
                    i.write = Stream { valid: writes && (seen.ready || !too), payload: place };
                    i.word = word(place);
                }
                let written = i.write.valid.then_some(cfg.is_outside(i.write.payload.section));
                if i.read.valid {
                    let side = usize::from(cfg.is_outside(i.read.payload.section));
                    waiting[side].push_back(i.read.payload);
                }
                let out = table.clock(i).unwrap();
                if out.request.valid && i.taken {
                    let Request { write, address, .. } = out.request.payload;
                    requests.push((write, address));
                }
                let mut answer = None;
                if written != Some(false) {
                    answer = waiting[0].pop_front();
                }
                let shown = table.moore().on_chip;
                prop_assert_eq!(shown.valid.then_some(shown.data), answer.map(word));
                if written == Some(true) {
                    asked.push((true, (i.write.payload.section - cfg.first_outside()) * 2 + 1));
                } else if seen.ready && let Some(place) = waiting[1].pop_front() {
                    asked.push((false, (place.section - cfg.first_outside()) * 2));
                }
                let over = accesses.len() == 0 && waiting.iter().all(VecDeque::is_empty);
                if over && asked.len() == requests.len() {
                    break;
                }
            }
            prop_assert_eq!(requests, asked);
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
