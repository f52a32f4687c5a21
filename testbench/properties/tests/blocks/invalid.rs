//! Allocators that say what comes of a release of a section that is not out.

use crate::found::{fault, is_found};
use pellucid_blocks::allocator::{Config, Contract, In, InvalidRelease, Lent, Moore};
use pellucid_properties::allocator::{Model, Property};
use pellucid_properties::allocator_properties;
use pellucid_sim::{Block, Signals, Stream};

allocator_properties!(Guarded<FLAGS>, flags);
allocator_properties!(Guarded<REFUSES>, refuses);

/// What [`Guarded`] does of an invalid release: it flags it, or has no flag.
const FLAGS: u8 = 0;
const REFUSES: u8 = 1;
/// What may be wrong.
const TAKEN_AT_ONCE: u32 = 1;
const BEYOND: u32 = 2;
const SILENT: u32 = 3;
const ALARMED: u32 = 4;

/// A bit for each section, by which what comes back is judged.
struct Guarded<const KIND: u8>;

#[derive(Clone, Copy, Signals)]
#[signals(Config)]
struct State {
    /// One for each number that can be given back.
    #[width(1 << cfg.id_bits())]
    free: u32,
    #[with(cfg.id_bits())]
    offer: Stream<u32>,
    flag: bool,
}

impl<const KIND: u8> Contract for Guarded<KIND> {
    const MOST: u32 = 20;
    const INVALID_RELEASE: InvalidRelease = match KIND {
        REFUSES => InvalidRelease::Refused,
        _ => InvalidRelease::Flagged,
    };
    fn flagged(_: &Config, q: &State) -> bool {
        q.flag
    }
}

fn lowest(free: u32) -> Stream<u32> {
    if free == 0 { Stream::idle() } else { Stream::offer(free.trailing_zeros()) }
}

impl<const KIND: u8> Block for Guarded<KIND> {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let free = (1 << cfg.sections) - 1;
        State { free, offer: lowest(free), flag: false }
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &State, _: &()) -> Moore {
        Moore { grant: q.offer, exhausted: q.free == 0 }
    }
    fn next(cfg: &Config, q: &State, d: &mut State, _: &mut (), i: In) -> Lent {
        let bit = 1 << i.release.payload;
        let taken = if i.take && q.offer.valid { 1 << q.offer.payload } else { 0 };
        d.free &= !taken;
        let out = if fault() == TAKEN_AT_ONCE { !d.free } else { !q.free };
        let last = if fault() == BEYOND { u32::MAX } else { (1 << cfg.sections) - 1 };
        let valid = i.release.valid && out & last & bit != 0;
        if valid {
            d.free |= bit;
        }
        let alarmed = fault() == ALARMED && taken != 0;
        d.flag = i.release.valid && fault() != SILENT && (!valid || alarmed);
        if i.take || !q.offer.valid {
            d.offer = lowest(d.free);
        }
        Lent::default()
    }
}

/// A section that is given back in the cycle of its take is not out yet.
#[test]
fn a_release_that_should_have_no_effect_is_found() {
    is_found::<Model<Guarded<FLAGS>>>(TAKEN_AT_ONCE, Property::Flagged);
}

#[test]
fn a_release_of_a_number_beyond_the_last_is_found() {
    is_found::<Model<Guarded<FLAGS>>>(BEYOND, Property::Flagged);
}

#[test]
fn a_wrong_flag_is_found() {
    is_found::<Model<Guarded<FLAGS>>>(SILENT, Property::Flagged);
    is_found::<Model<Guarded<FLAGS>>>(ALARMED, Property::Flagged);
}
