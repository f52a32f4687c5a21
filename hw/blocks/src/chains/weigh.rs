//! The weigher: compares a fragment that arrives with all that its pixel has, and brings their weights up
//! to date.
//!
//! ```text
//!                     +-------+
//!  start, fragment -->|       |---> weight, once all are compared
//!  entry ------------>| Weigh |<--- taken
//!  nsa, word -------->|       |---> section read and write, NSA read
//!                     +-------+
//! ```
//! Of each two, the weight of the farther one is multiplied by what the nearer one lets through; of equal
//! depths the later one is nearer. A stored fragment takes a cycle, and another one if its own weight
//! changes and the last of them is not asked for yet. Reads go ahead, `reads_in_flight` at most, so that outside memory costs
//! its latency once.

use super::config::Config;
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use crate::weights::{WEIGHT_BITS, behind, own_weight};
use pellucid_machine::pixel::PixelFragment;
use pellucid_sim::{Block, Fifo, Memory, Port, Read, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Weigh;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// No fragment is at hand.
    Idle,
    /// The first stored fragment is yet to be asked for.
    Ask,
    /// Stored fragments are asked for, or on their way.
    Read,
    /// All are compared.
    Done,
}

/// A read that is under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Pending {
    /// The stored fragment's place.
    #[with(*cfg)]
    pub place: Place,
    /// It is the pixel's last.
    pub last: bool,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The place that was asked for last, or in `Ask` is about to be.
    #[with(*cfg)]
    pub place: Place,
    /// Reads under way.
    #[with(cfg.shape.reads_in_flight)]
    pub pending: fifo::State,
    /// Weight of the fragment at hand so far.
    #[width(WEIGHT_BITS)]
    pub weight: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A fragment is to be compared. It and its entry stay until it is taken.
    pub start: bool,
    /// The fragment.
    #[with(cfg.screen)]
    pub fragment: PixelFragment,
    /// Its pixel's entry, not NULL.
    #[with(*cfg)]
    pub entry: SsaEntry,
    /// The NSA entry that was asked for.
    #[with(*cfg)]
    pub nsa: Read<NsaEntry>,
    /// The oldest stored fragment that was asked for and is not there yet, if it comes: one outside only while such may be
    /// asked for.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// The fragment goes to its place.
    pub taken: bool,
    /// Sections outside may be asked for.
    pub outside_ready: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Reads under way.
    pub pending: <Pendings as Block>::Mem,
}

type Pendings = Fifo<Pending>;

#[inline(always)]
fn pendings(cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: cfg.shape.reads_in_flight, item: *cfg }
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The fragment's weight, once all are compared.
    #[with(WEIGHT_BITS)]
    pub weight: Stream<u32>,
    /// A read is under way; whether the oldest one went outside.
    pub oldest: Stream<bool>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a stored fragment.
    #[with(*cfg)]
    pub read: Stream<Place>,
    /// Writes one back. Never with a read.
    #[with(*cfg)]
    pub write: Stream<Place>,
    /// What is written back.
    #[with(*cfg)]
    pub word: Word,
    /// Reads an NSA entry.
    #[with(cfg.id_bits(), *cfg)]
    pub nsa: Port<NsaEntry>,
}

#[rtl(check(Weigh, crate::test_util::small_owned(true)))]
impl Block for Weigh {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            fsm: Fsm::Idle,
            place: Place::default(),
            pending: Pendings::reset(&pendings(cfg)),
            weight: 0,
        }
    }

    fn memories(cfg: &Config) -> Mem {
        // Where no weights are kept it does not exist.
        let depth = if cfg.weighs() { cfg.shape.reads_in_flight } else { 0 };
        Mem { pending: Pendings::memories(&fifo::Config { depth, item: *cfg }) }
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let pending = Pendings::moore(&pendings(cfg), &q.pending, &m.pending).front;
        let outside = cfg.is_outside(pending.payload.place.section);
        Moore {
            weight: Stream { valid: q.fsm == Fsm::Done, payload: q.weight },
            oldest: Stream { valid: pending.valid, payload: outside },
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let mut o = Out::default();

        // The oldest read is answered: its fragment and the one at hand are compared.
        let pending = Pendings::moore(&pendings(cfg), &q.pending, &m.pending);
        let oldest = pending.front.payload;
        if i.word.valid {
            let stored = i.word.data;
            let nearer = i.fragment.z <= stored.z;
            let weight = if nearer { stored.weight } else { q.weight };
            let weight = behind(weight, if nearer { i.fragment.rgba } else { stored.rgba });
            if nearer {
                o.write = Stream::offer(oldest.place);
                o.word = Word { weight, ..stored };
            } else {
                d.weight = weight;
            }
            if oldest.last {
                d.fsm = Fsm::Done;
            }
        }

        // What follows the place that was asked for last?
        let in_tail = q.place.section == i.entry.tail;
        let fill = if in_tail { i.entry.fill } else { cfg.shape.capacity };
        let more_here = q.place.slot + 1 < fill;
        let mut place = q.place;
        let mut wants = false;
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    place =
                        Place { section: cfg.first_section(i.fragment.pixel, i.entry), slot: 0 };
                    wants = true;
                    d.place = place;
                    d.weight = own_weight(i.fragment.rgba);
                    d.fsm = Fsm::Ask;
                }
            }
            Fsm::Ask => wants = true,
            Fsm::Read => {
                wants = more_here || !in_tail;
                if more_here {
                    place.slot = q.place.slot + 1;
                } else {
                    place = Place { section: i.nsa.data.next, slot: 0 };
                }
            }
            Fsm::Done => {
                if i.taken {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        let open = i.outside_ready || !cfg.is_outside(place.section);
        let mut fetch = Stream::idle();
        if wants && open && pending.ready && !o.write.valid {
            o.read = Stream::offer(place);
            d.place = place;
            d.fsm = Fsm::Read;
            // What follows its section is looked up with a section's first fragment.
            let is_tail = place.section == i.entry.tail;
            if place.slot == 0 && !is_tail {
                o.nsa.read(place.section);
            }
            let last = is_tail && place.slot + 1 == i.entry.fill;
            fetch = Stream::offer(Pending { place, last });
        }
        let to_pending = fifo::In { push: fetch, pop: i.word.valid };
        Pendings::next(&pendings(cfg), &q.pending, &mut d.pending, &mut m.pending, to_pending);
        o
    }
}

#[cfg(test)]
mod tests;
