//! An allocator of at most 32 sections: a bit for each, and a priority encoder that finds the lowest.
//!
//! It is not part of Pellucid's library: it stands for one of your own. Its test, `tests/properties.rs`, is a
//! line. [`Hasty`] is the same but for a fault that is easily made, which the properties find.

use pellucid_hw::allocator::{Config, Contract, In, Moore};
use pellucid_sim::{Block, Signals, Stream};

/// A bit for each section.
pub struct LowestFirst;

/// The same with a fault: it offers the lowest free section of every cycle.
pub struct Hasty;

/// Registers of both.
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

fn all(cfg: &Config) -> State {
    let free = u32::MAX.checked_shr(u32::BITS - cfg.sections).unwrap_or(0);
    State { free, offer: lowest(free) }
}

/// The sections that are free after the cycle.
fn free_after(q: &State, grant: Stream<u32>, i: In) -> u32 {
    let mut free = q.free;
    if i.take && grant.valid {
        free &= !(1 << grant.payload);
    }
    if i.release.valid {
        free |= 1 << i.release.payload;
    }
    free
}

impl Contract for LowestFirst {}

impl Block for LowestFirst {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        all(cfg)
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &State, _: &()) -> Moore {
        Moore { grant: q.offer, exhausted: q.free == 0 }
    }
    fn next(_: &Config, q: &State, d: &mut State, _: &mut (), i: In) {
        d.free = free_after(q, q.offer, i);
        // What is offered stays until it is taken.
        if i.take || !q.offer.valid {
            d.offer = lowest(d.free);
        }
    }
}

impl Contract for Hasty {}

impl Block for Hasty {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        all(cfg)
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &State, _: &()) -> Moore {
        Moore { grant: q.offer, exhausted: q.free == 0 }
    }
    fn next(_: &Config, q: &State, d: &mut State, _: &mut (), i: In) {
        d.free = free_after(q, q.offer, i);
        d.offer = lowest(d.free);
    }
}
