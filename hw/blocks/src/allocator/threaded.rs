//! The free list as a stack without a memory of its own: it is threaded through the words that the free
//! sections lend, each of which holds the number of the free section below.
//!
//! ```text
//!             +----------+
//!   take ---->|          |---> grant
//!  release -->| Threaded |---> exhausted
//!     word -->|          |---> lent (read, write)
//!             +----------+
//! ```
//! One grant and one release a cycle, in the order of a [`Stack`](super::Stack). A take reads a word and a
//! release writes one, but for a release in the cycle of a take, which needs neither. In a T-buffer the lent
//! words are the NSA table, which has a second port for it: while a section is free its entry has no other
//! use. Sections that were never used come last; a counter grants them, so that nothing need be linked after
//! reset.

use super::{Allocator, Config, Contract, In, Lent, Moore};
use pellucid_sim::Block;
use pellucid_sim::{Signals, Stream, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Threaded;

impl Contract for Threaded {}

impl Allocator for Threaded {}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What is offered; it is not in the list.
    #[with(cfg.id_bits())]
    pub offer: Stream<u32>,
    /// The first of the list, or the number of sections if the list is empty; without meaning while it is on
    /// its way.
    #[width(cfg.count_bits())]
    pub head: u32,
    /// The first of the list is the word that was asked for.
    pub asked: bool,
    /// The lowest section that was never offered; the number of sections once all were.
    #[width(cfg.count_bits())]
    pub fresh: u32,
}

#[rtl(check(Threaded, Config { sections: 1 }), check(Threaded, Config { sections: 6 }))]
impl Block for Threaded {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let some = cfg.sections > 0;
        let offer = if some { Stream::offer(0) } else { Stream::idle() };
        State { offer, head: cfg.sections, asked: false, fresh: u32::from(some) }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { grant: q.offer, exhausted: !q.offer.valid }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Lent {
        let head = if q.asked { i.word } else { q.head };
        let mut o = Lent { word: head, ..Lent::default() };
        d.head = head;
        d.asked = false;
        if i.take || !q.offer.valid {
            // The next one: what comes back, else the first of the list, else a new one.
            if i.release.valid {
                d.offer = i.release;
            } else if head < cfg.sections {
                d.offer = Stream { valid: true, payload: head };
                o.read = Stream { valid: true, payload: head };
                d.asked = true;
            } else if q.fresh < cfg.sections {
                d.offer = Stream { valid: true, payload: q.fresh };
                d.fresh = q.fresh + 1;
            } else {
                d.offer.valid = false;
            }
        } else if i.release.valid {
            o.write = i.release;
            d.head = i.release.payload;
        }
        o
    }
}
