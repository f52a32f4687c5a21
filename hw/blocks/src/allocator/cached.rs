//! A small cache of sections in registers, over a hierarchical bitmap: one lane of [`Lanes`] behind the port
//! contract of every allocator.
//!
//! ```text
//!             +--------+
//!   take ---->|        |---> grant
//!  release -->| Cached |---> exhausted
//!             +--------+
//! ```
//! One grant and one release a cycle. What came back last is offered first, and what is beyond half a cache
//! goes back into the bitmap. While the bitmap searches, the cache grants what it has: three sections, one a
//! cycle, if it had time to fill.
//!
//! [`Lanes`]: super::Lanes

use super::hierarchical::{self, LATENCY};
use super::lanes::{HALF, Lane, after, last};
use super::{Allocator, Config, Contract, Hierarchical, In, Lent, Moore};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Signals, Stream, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Cached;

impl Contract for Cached {
    fn latency(_: &Config) -> u32 {
        // Whoever has emptied the cache has given nothing to the bitmap in the cycle before its last section
        // left it.
        LATENCY - 1
    }
}

impl Allocator for Cached {}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What is offered, and the cache.
    #[with(*cfg)]
    pub lane: Lane,
    /// All other sections.
    #[with(*cfg)]
    pub shared: hierarchical::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Of the bitmap.
    pub shared: hierarchical::Mem,
}

#[rtl(check(Cached, Config { sections: 1 }), check(Cached, Config { sections: 9 }))]
impl Block for Cached {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State { lane: Lane::default(), shared: Hierarchical::reset(cfg) }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { shared: Hierarchical::memories(cfg) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let shared = Hierarchical::moore(cfg, &q.shared, &m.shared);
        let none = !q.lane.offer.valid && q.lane.count == 0;
        Moore { grant: q.lane.offer, exhausted: none && shared.exhausted }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Lent {
        let shared = Hierarchical::moore(cfg, &q.shared, &m.shared);
        let gives = q.lane.count > HALF;
        let gets = q.lane.count < HALF;
        let more = Stream { valid: gets && shared.grant.valid, payload: shared.grant.payload };
        d.lane = after(q.lane, i.take, i.release, gives, more);
        let release = Stream { valid: gives, payload: last(q.lane) };
        let to_shared = In { take: gets, release, word: i.word };
        Hierarchical::next(cfg, &q.shared, &mut d.shared, &mut m.shared, to_shared)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::clock;
    use super::*;
    use crate::allocator::{Lanes, lanes};
    use pellucid_sim::Sim;
    use proptest::prelude::*;

    /// One section is taken in every second cycle, across the words of the bitmap.
    #[test]
    fn no_search_is_seen_by_a_taker_that_pauses() {
        let mut sim = Sim::<Cached>::new(Config { sections: 256 });
        for _ in 0..256 + 2 {
            clock(&mut sim, true, None);
        }
        assert!(sim.moore().exhausted);
        (0..256).for_each(|id| clock(&mut sim, false, Some(id)));
        (0..LATENCY).for_each(|_| clock(&mut sim, false, None));
        for taken in 0..256 {
            assert!(sim.moore().grant.valid, "after {taken}");
            clock(&mut sim, true, None);
            clock(&mut sim, false, None);
        }
        assert!(sim.moore().exhausted);
    }

    #[test]
    fn what_came_back_last_is_granted_first() {
        let mut sim = Sim::<Cached>::new(Config { sections: 100 });
        (0..12).for_each(|_| clock(&mut sim, true, None));
        let offered = sim.moore().grant.payload;
        for id in [4, 2] {
            clock(&mut sim, false, Some(id));
        }
        let mut granted = vec![];
        for _ in 0..3 {
            granted.push(sim.moore().grant.payload);
            clock(&mut sim, true, None);
        }
        assert_eq!(granted, [offered, 2, 4]);
    }

    proptest! {
        #[test]
        fn behaves_as_one_lane(
            sections in 0u32..12,
            steps in proptest::collection::vec((any::<bool>(), any::<Option<prop::sample::Index>>()), 0..300),
        ) {
            let numbers = Config { sections };
            let mut sim = Sim::<Cached>::new(numbers);
            let mut lane = Sim::<Lanes>::new(lanes::Config { lanes: 1, numbers });
            let mut out: Vec<u32> = vec![];
            for (take, release) in steps {
                let (seen, same) = (sim.moore(), lane.moore());
                prop_assert_eq!(seen.grant, same.grant[0]);
                prop_assert_eq!(seen.exhausted, same.exhausted[0]);
                prop_assert!(same.ready[0]);
                let release = release.filter(|_| !out.is_empty());
                let release = release.map(|k| out.swap_remove(k.index(out.len())));
                out.extend((take && seen.grant.valid).then_some(seen.grant.payload));
                clock(&mut sim, take, release);
                let mut i = lanes::In::default();
                i.take[0] = take;
                i.release[0] = release.map_or(Stream::idle(), Stream::offer);
                lane.clock(i).unwrap();
            }
        }
    }
}
