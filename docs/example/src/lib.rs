//! An allocator of at most 32 sections: a bit for each, and a priority encoder that finds the lowest.
//!
//! It is not part of Pellucid's library: it stands for one of your own. Its test, `tests/properties.rs`, is a
//! line. [`Hasty`] is the same but for a fault that is easily made, which the properties find.

use pellucid_blocks::allocator::{Config, Contract, In, Lent, Moore};
use pellucid_sim::{Block, Signals, Stream};

/// A bit for each section. What it offers it holds until it is taken, unless it is hasty.
pub struct Bits<const HASTY: bool>;

/// The one that is right.
pub type LowestFirst = Bits<false>;

/// The one with a fault: it offers the lowest free section of every cycle.
pub type Hasty = Bits<true>;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct State {
    /// Which sections are free.
    #[width(cfg.sections)]
    pub free: u32,
    /// What is offered.
    #[with(cfg.id_bits())]
    pub offer: Stream<u32>,
}

/// The priority encoder.
fn lowest(free: u32) -> Stream<u32> {
    if free == 0 { Stream::idle() } else { Stream::offer(free.trailing_zeros()) }
}

impl<const HASTY: bool> Contract for Bits<HASTY> {
    const MOST: u32 = u32::BITS;
}

impl<const HASTY: bool> Block for Bits<HASTY> {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let free = u32::MAX.checked_shr(u32::BITS - cfg.sections).unwrap_or(0);
        State { free, offer: lowest(free) }
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &State, _: &()) -> Moore {
        Moore { grant: q.offer, exhausted: q.free == 0 }
    }
    fn next(_: &Config, q: &State, d: &mut State, _: &mut (), i: In) -> Lent {
        if i.take && q.offer.valid {
            d.free &= !(1 << q.offer.payload);
        }
        if i.release.valid {
            d.free |= 1 << i.release.payload;
        }
        // What is offered stays until it is taken.
        if HASTY || i.take || !q.offer.valid {
            d.offer = lowest(d.free);
        }
        Lent::default()
    }
}
