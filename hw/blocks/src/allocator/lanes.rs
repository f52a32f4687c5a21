//! An allocator with several ports: a small cache of sections for each lane, over a shared allocator, so that
//! every lane can take a section and give one back in every cycle.
//!
//! ```text
//!                    +-------+
//!   take, for each ->|       |-> grant, for each
//!          release ->| Lanes |-> exhausted
//!                    |       |-> ready
//!                    +-------+
//!
//!   lane 0   lane 1   lane 2      an offer and CACHE sections in registers
//!      |        |        |
//!   +--------------------------+
//!   |       Hierarchical       |  one grant and one release a cycle
//!   +--------------------------+
//! ```
//! Each lane has the contract of [`super`] and one thing more: a release is taken where `ready` is high. What
//! came back to a lane last it offers first.
//!
//! A lane with less than half a cache asks the shared allocator for more, and one with more than half gives
//! back what it would offer last. Each cycle one lane gets and one gives, in turn; of those that ask, lanes
//! without an offer go first, and of those that give, lanes whose cache is full. A lane whose turn it is to
//! give is ready though its cache is full; so a single lane is always ready.
//!
//! From half a cache each lane grants three sections, one a cycle, and goes on for as long as what it takes
//! comes back to it. Beyond that, and after a reset, all lanes together get one section a cycle.
//!
//! Where the shared allocator has nothing and a lane has no offer, the other lanes give, in turn, whatever
//! they have in their caches. What a lane gives it can no more offer, even if it is taken from in the same
//! cycle. So a lane waits for no more than the lanes before it: see [`Lanes::latency`].
//!
//! [`Lanes::latency`]: Contract::latency

use super::Hierarchical;
use super::hierarchical::{self, LATENCY};
use crate::round_robin::{self, behind, first};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Registers, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Lanes;

/// The most lanes that there can be.
pub const MAX_LANES: usize = round_robin::MOST;
/// Sections in the cache of a lane, beside the one that it offers.
pub const CACHE: u32 = 4;
/// How many of them a lane keeps.
pub(super) const HALF: u32 = CACHE / 2;
const PLACES: usize = CACHE as usize;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// How many lanes, 1..=[`MAX_LANES`].
    pub lanes: u32,
    /// How many sections, for all lanes together.
    pub numbers: super::Config,
}

impl Config {
    /// Bits of the number of a lane.
    fn lane_bits(&self) -> u32 {
        bits_for(u64::from(self.lanes - 1))
    }
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// What the lane is granted is taken. Without effect while it is granted nothing.
    #[len(cfg.lanes)]
    pub take: [bool; MAX_LANES],
    /// A section is given back to the lane. Without effect while the lane is not ready.
    #[with(cfg.numbers.id_bits())]
    #[len(cfg.lanes)]
    pub release: [Stream<u32>; MAX_LANES],
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The section that a take of the lane would get.
    #[with(cfg.numbers.id_bits())]
    #[len(cfg.lanes)]
    pub grant: [Stream<u32>; MAX_LANES],
    /// The lane is granted nothing, and no section is free but for those that other lanes offer.
    #[len(cfg.lanes)]
    pub exhausted: [bool; MAX_LANES],
    /// The lane takes a release.
    #[len(cfg.lanes)]
    pub ready: [bool; MAX_LANES],
}

/// A block that keeps the contract of an allocator with lanes. Whether it does is a matter of tests: see
/// `pellucid-properties`.
pub trait Contract:
    Block<Config = Config, In = In, Moore = Moore, Out = (), State: Registers<Config = Config>>
{
    /// The most sections that it can have.
    const MOST: u32 = u32::MAX;

    /// While a section is free that no other lane offers, cycles until a lane offers one at the latest: after a
    /// reset, after the take of another one, and after that section's release. At least 1.
    fn latency(cfg: &Config) -> u32;
    /// Cycles until a lane takes a release at the latest: 1 if it is always ready.
    fn room(cfg: &Config) -> u32;
}

/// What a lane has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(super::Config)]
pub struct Lane {
    /// What it offers. While that is nothing, its cache is empty.
    #[with(cfg.id_bits())]
    pub offer: Stream<u32>,
    /// Sections in its cache.
    #[width(bits_for(u64::from(CACHE)))]
    pub count: u32,
    /// These sections; the first is offered next.
    #[width(cfg.id_bits())]
    #[len(CACHE)]
    pub cache: [u32; PLACES],
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The lanes.
    #[with(cfg.numbers)]
    #[len(cfg.lanes)]
    pub lanes: [Lane; MAX_LANES],
    /// The lane whose turn it is to get a section.
    #[width(cfg.lane_bits())]
    pub gets: u32,
    /// The lane whose turn it is to give one.
    #[width(cfg.lane_bits())]
    pub gives: u32,
    /// All other sections.
    #[with(cfg.numbers)]
    pub shared: hierarchical::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Of the shared allocator.
    pub shared: hierarchical::Mem,
}

/// The section that a lane would offer last.
#[inline(always)]
#[rtl]
pub(crate) fn last(lane: Lane) -> u32 {
    let mut last = lane.cache[0];
    for k in 1..CACHE {
        if lane.count == k + 1 {
            last = lane.cache[k as usize];
        }
    }
    last
}

/// A lane after a cycle in which it was taken from, given `back`, has given its last section away, and has got
/// `more`.
#[inline(always)]
#[rtl]
pub(crate) fn after(
    lane: Lane,
    take: bool,
    back: Stream<u32>,
    gives: bool,
    more: Stream<u32>,
) -> Lane {
    let mut next = lane;
    let kept = lane.count - u32::from(gives);
    let wanted = take || !lane.offer.valid;
    let pop = wanted && !back.valid && kept > 0;
    let push = !wanted && back.valid;
    // What came back is offered first, then what is in the cache, then what it gets.
    if pop {
        next.offer = Stream { valid: true, payload: lane.cache[0] };
    } else if wanted && back.valid {
        next.offer = back;
    } else if wanted {
        next.offer = more;
    }
    if pop {
        for k in 1..CACHE {
            next.cache[k as usize - 1] = lane.cache[k as usize];
        }
    }
    if push {
        next.cache[0] = back.payload;
        for k in 1..CACHE {
            next.cache[k as usize] = lane.cache[k as usize - 1];
        }
    }
    let count = kept + u32::from(push) - u32::from(pop);
    let put = more.valid && (!wanted || back.valid || pop);
    if put {
        for k in 0..CACHE {
            if count == k {
                next.cache[k as usize] = more.payload;
            }
        }
    }
    next.count = count + u32::from(put);
    next
}

/// The lane that gets the next section of the shared allocator.
#[inline(always)]
#[rtl]
fn getter(cfg: &Config, lanes: [Lane; MAX_LANES], turn: u32) -> Stream<u32> {
    let mut without = [false; MAX_LANES];
    let mut few = [false; MAX_LANES];
    let mut some = false;
    for k in 0..cfg.lanes {
        let lane = lanes[k as usize];
        without[k as usize] = !lane.offer.valid;
        few[k as usize] = lane.count < HALF;
        some |= !lane.offer.valid;
    }
    first(&cfg.lanes, if some { without } else { few }, turn)
}

/// The lane that gives a section to the shared allocator.
#[inline(always)]
#[rtl]
fn giver(cfg: &Config, lanes: [Lane; MAX_LANES], turn: u32, exhausted: bool) -> Stream<u32> {
    let mut full = [false; MAX_LANES];
    let mut many = [false; MAX_LANES];
    let mut any = [false; MAX_LANES];
    let mut some_full = false;
    let mut some_without = false;
    for k in 0..cfg.lanes {
        let lane = lanes[k as usize];
        full[k as usize] = lane.count == CACHE;
        many[k as usize] = lane.count > HALF;
        any[k as usize] = lane.count > 0;
        some_full |= lane.count == CACHE;
        some_without |= !lane.offer.valid;
    }
    let asks = if some_full {
        full
    } else if exhausted && some_without {
        any
    } else {
        many
    };
    first(&cfg.lanes, asks, turn)
}

impl Contract for Lanes {
    fn latency(cfg: &Config) -> u32 {
        // A lane waits for a search for each lane, itself the last. A search begins a cycle late if a section
        // comes back just before it; with one lane or two there comes a search before which no lane has a
        // section to give.
        let always = cfg.lanes * LATENCY;
        if cfg.lanes > 2 { always } else { always - 1 }
    }
    fn room(cfg: &Config) -> u32 {
        cfg.lanes
    }
}

#[rtl(
    check(Lanes, Config { lanes: 1, numbers: super::Config { sections: 5 } }),
    check(Lanes, Config { lanes: 2, numbers: super::Config { sections: 9 } }),
    check(Lanes, Config { lanes: 4, numbers: super::Config { sections: 70 } })
)]
impl Block for Lanes {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the number of lanes", cfg.lanes, 1..=MAX_LANES as u32);
        let shared = Hierarchical::reset(&cfg.numbers);
        State { lanes: [Lane::default(); MAX_LANES], gets: 0, gives: 0, shared }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { shared: Hierarchical::memories(&cfg.numbers) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let shared = Hierarchical::moore(&cfg.numbers, &q.shared, &m.shared);
        let gives = giver(cfg, q.lanes, q.gives, shared.exhausted);
        let mut none = shared.exhausted;
        for k in 0..cfg.lanes {
            none &= q.lanes[k as usize].count == 0;
        }
        let mut grant = [Stream { valid: false, payload: 0 }; MAX_LANES];
        let mut exhausted = [false; MAX_LANES];
        let mut ready = [false; MAX_LANES];
        for k in 0..cfg.lanes {
            let lane = q.lanes[k as usize];
            let its_turn = gives.valid && gives.payload == k;
            grant[k as usize] = lane.offer;
            exhausted[k as usize] = none && !lane.offer.valid;
            ready[k as usize] = lane.count < CACHE || its_turn;
        }
        Moore { grant, exhausted, ready }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) {
        let Moore { ready, .. } = Self::moore(cfg, q, m);
        let shared = Hierarchical::moore(&cfg.numbers, &q.shared, &m.shared);
        let gets = getter(cfg, q.lanes, q.gets);
        let gives = giver(cfg, q.lanes, q.gives, shared.exhausted);
        let mut given = 0;
        for k in 0..cfg.lanes {
            let lane = q.lanes[k as usize];
            let back = Stream {
                valid: i.release[k as usize].valid && ready[k as usize],
                payload: i.release[k as usize].payload,
            };
            let more = Stream {
                valid: shared.grant.valid && gets.valid && gets.payload == k,
                payload: shared.grant.payload,
            };
            let its_turn = gives.valid && gives.payload == k;
            if its_turn {
                given = last(lane);
            }
            d.lanes[k as usize] = after(lane, i.take[k as usize], back, its_turn, more);
        }
        if gets.valid && shared.grant.valid {
            d.gets = behind(&cfg.lanes, gets.payload);
        }
        if gives.valid {
            d.gives = behind(&cfg.lanes, gives.payload);
        }
        let release = Stream { valid: gives.valid, payload: given };
        let to_shared = super::In { take: gets.valid, release, word: 0 };
        Hierarchical::next(&cfg.numbers, &q.shared, &mut d.shared, &mut m.shared, to_shared);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;
    use std::collections::BTreeSet;

    const ALL: [bool; MAX_LANES] = [true; MAX_LANES];

    fn lanes(lanes: u32, sections: u32) -> Sim<Lanes> {
        Sim::new(Config { lanes, numbers: super::super::Config { sections } })
    }

    /// Lanes whose caches had time to fill.
    fn warm(count: u32, sections: u32) -> Sim<Lanes> {
        let mut sim = lanes(count, sections);
        (0..40).for_each(|_| clock(&mut sim, &[], &[]));
        sim
    }

    fn clock(sim: &mut Sim<Lanes>, takes: &[usize], back: &[(usize, u32)]) {
        let mut i = In::default();
        takes.iter().for_each(|lane| i.take[*lane] = true);
        back.iter().for_each(|(lane, id)| i.release[*lane] = Stream::offer(*id));
        sim.clock(i).unwrap();
    }

    /// What each lane grants.
    fn granted(sim: &Sim<Lanes>) -> Vec<Option<u32>> {
        let grants = sim.moore().grant;
        let lanes = sim.config().lanes as usize;
        grants[..lanes].iter().map(|grant| grant.valid.then_some(grant.payload)).collect()
    }

    #[test]
    fn cold_the_sections_come_one_a_cycle() {
        let mut sim = lanes(4, 64);
        let mut came = vec![];
        for _ in 0..10 {
            came.push(granted(&sim).iter().flatten().count());
            sim.clock(In { take: ALL, ..In::default() }).unwrap();
        }
        assert_eq!(came, [0, 0, 1, 1, 1, 1, 1, 1, 1, 1]);
    }

    #[test]
    fn warm_every_lane_grants_one_a_cycle_for_three_cycles() {
        for count in [1, 4, 8] {
            let mut sim = warm(count, 64);
            let mut out = BTreeSet::new();
            for _ in 0..1 + HALF {
                let now = granted(&sim);
                out.extend(now.into_iter().map(|grant| grant.expect("a lane waits")));
                sim.clock(In { take: ALL, ..In::default() }).unwrap();
            }
            assert_eq!(out.len() as u32, count * (1 + HALF), "no section twice");
        }
    }

    /// Whoever gives as many back as it takes never waits, however many lanes there are.
    #[test]
    fn every_lane_takes_one_and_gives_one_back_in_every_cycle() {
        let mut sim = warm(8, 64);
        let mut held = vec![None; 8];
        for cycle in 0..1000 {
            let Moore { ready, .. } = sim.moore();
            assert!(ready.iter().all(|ready| *ready), "in cycle {cycle}");
            let now = granted(&sim);
            assert!(now.iter().all(|grant| grant.is_some()), "in cycle {cycle}");
            let back: Vec<(usize, u32)> =
                (0..8).filter_map(|lane| Some((lane, held[lane]?))).collect();
            clock(&mut sim, &[0, 1, 2, 3, 4, 5, 6, 7], &back);
            held = now;
        }
    }

    #[test]
    fn what_came_back_to_a_lane_it_grants_first() {
        let mut sim = warm(2, 64);
        let mut mine = vec![];
        for _ in 0..3 {
            mine.extend(granted(&sim)[1]);
            clock(&mut sim, &[1], &[]);
        }
        let offered = granted(&sim)[1].unwrap();
        mine.iter().for_each(|id| clock(&mut sim, &[], &[(1, *id)]));
        let mut again = vec![];
        for _ in 0..3 {
            again.extend(granted(&sim)[1]);
            clock(&mut sim, &[1], &[]);
        }
        // What was offered stays offered; then the last two that came back.
        assert_eq!(again, [offered, mine[2], mine[1]]);
    }

    #[test]
    fn a_single_lane_is_always_ready() {
        let mut sim = lanes(1, 40);
        (0..50).for_each(|_| clock(&mut sim, &[0], &[]));
        assert!(sim.moore().exhausted[0]);
        for id in 0..40 {
            assert!(sim.moore().ready[0]);
            clock(&mut sim, &[], &[(0, id)]);
        }
    }

    /// What another lane offers is not to be had; what it has in its cache is.
    #[test]
    fn sections_of_other_caches_flow_back() {
        let mut sim = lanes(2, 3);
        (0..20).for_each(|_| clock(&mut sim, &[0], &[]));
        assert_eq!(granted(&sim), [None, Some(1)]);
        assert_eq!(sim.moore().exhausted[..2], [true, false]);
        clock(&mut sim, &[], &[(1, 0)]);
        assert_eq!(sim.moore().exhausted[..2], [false, false]);
        // It gives the section, the shared allocator offers it, and the lane does.
        (0..2).for_each(|_| clock(&mut sim, &[], &[]));
        assert_eq!(granted(&sim), [Some(0), Some(1)]);
    }

    #[test]
    #[should_panic(expected = "the number of lanes is 0: expected 1 to 8")]
    fn there_is_a_lane() {
        lanes(0, 9);
    }
}
