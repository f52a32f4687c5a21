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
//! changes; one in outside memory takes that memory's latency.

use super::config::Config;
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use crate::weights::{WEIGHT_BITS, behind, own_weight};
use pellucid_machine::pixel::PixelFragment;
use pellucid_sim::{Block, Port, Read, Signals, Stream, rtl};

/// See the module's description.
pub struct Weigh;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// No fragment is at hand.
    Idle,
    /// About to ask for a stored fragment.
    Ask,
    /// A stored fragment is on its way.
    Wait,
    /// All are compared.
    Done,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The place that is about to be asked for, or was.
    #[with(*cfg)]
    pub place: Place,
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
    /// The stored fragment that was asked for.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// The fragment goes to its place.
    pub taken: bool,
    /// Sections outside may be asked for.
    pub outside_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The fragment's weight, once all are compared.
    #[with(WEIGHT_BITS)]
    pub weight: Stream<u32>,
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
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { fsm: Fsm::Idle, place: Place::default(), weight: 0 }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { weight: Stream { valid: q.fsm == Fsm::Done, payload: q.weight } }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out::default();
        let mut ask = false;
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.place =
                        Place { section: cfg.first_section(i.fragment.pixel, i.entry), slot: 0 };
                    d.weight = own_weight(i.fragment.rgba);
                    ask = true;
                }
            }
            Fsm::Ask => ask = true,
            Fsm::Wait => {
                if i.word.valid {
                    let stored = i.word.data;
                    let nearer = i.fragment.z <= stored.z;
                    let weight = if nearer { stored.weight } else { q.weight };
                    let weight = behind(weight, if nearer { i.fragment.rgba } else { stored.rgba });
                    if nearer {
                        o.write = Stream::offer(q.place);
                        o.word = Word { weight, ..stored };
                    } else {
                        d.weight = weight;
                    }
                    let in_tail = q.place.section == i.entry.tail;
                    let fill = if in_tail { i.entry.fill } else { cfg.shape.capacity };
                    let more = q.place.slot + 1 < fill;
                    if more {
                        d.place.slot = q.place.slot + 1;
                    } else if !in_tail {
                        d.place = Place { section: i.nsa.data.next, slot: 0 };
                    }
                    ask = (more || !in_tail) && !nearer;
                    d.fsm = if more || !in_tail { Fsm::Ask } else { Fsm::Done };
                }
            }
            Fsm::Done => {
                if i.taken {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        if ask && !i.outside_ready && cfg.is_outside(d.place.section) {
            d.fsm = Fsm::Ask;
        } else if ask {
            o.read = Stream::offer(d.place);
            d.fsm = Fsm::Wait;
            // What follows its section is looked up with a section's first fragment.
            if d.place.slot == 0 && d.place.section != i.entry.tail {
                o.nsa.read(d.place.section);
            }
        }
        o
    }
}

#[cfg(test)]
mod tests;
