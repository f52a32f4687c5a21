use crate::found::{self, NONE, fault, found};
use pellucid_blocks::allocator::Lanes;
use pellucid_blocks::allocator::lanes::{Config, Contract, In, MAX_LANES, Moore};
use pellucid_properties::harness::{Must, check};
use pellucid_properties::lanes::{Hand, Model, Property, Setup, Step};
use pellucid_properties::lanes_properties;
use pellucid_sim::{Block, Signals, Stream};

lanes_properties!(Lanes, all);
lanes_properties!(Bits, bits);

/// What is wrong with [`Bits`].
const TWICE: u32 = 1;
const OUT: u32 = 2;
const LOST: u32 = 3;
const STARVES: u32 = 4;
const EARLY: u32 = 5;
const UNSAID: u32 = 6;
const RANGE: u32 = 7;
const HELD: u32 = 8;
const CLOSED: u32 = 9;
const RESET: u32 = 10;

/// A bit for each section, in a register, an offer for each lane, and a fault.
struct Bits;

#[derive(Clone, Copy, Signals)]
struct Free {
    /// Which are free and not offered.
    #[width(cfg.numbers.sections)]
    bits: u64,
    #[with(cfg.numbers.id_bits())]
    #[len(cfg.lanes)]
    offers: [Stream<u32>; MAX_LANES],
}

/// The lowest of the free ones.
fn lowest(bits: u64) -> Stream<u32> {
    if bits == 0 { Stream::idle() } else { Stream::offer(bits.trailing_zeros()) }
}

impl Contract for Bits {
    const MOST: u32 = 63;

    fn latency(_: &Config) -> u32 {
        1
    }
    fn room(_: &Config) -> u32 {
        1
    }
}

impl Block for Bits {
    type Config = Config;
    type State = Free;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> Free {
        let lost = u32::from(fault() == RESET && cfg.numbers.sections > 1);
        let mut bits = (1 << (cfg.numbers.sections - lost)) - 1;
        let mut offers = [Stream::idle(); MAX_LANES];
        for offer in &mut offers[..cfg.lanes as usize] {
            *offer = lowest(bits);
            bits &= bits.wrapping_sub(1);
        }
        Free { bits, offers }
    }
    fn memories(_: &Config) {}
    fn moore(cfg: &Config, q: &Free, (): &()) -> Moore {
        let mut grant = q.offers;
        let none = grant.map(|offer| !offer.valid);
        if fault() == RANGE && none[0] {
            grant[0] = Stream::offer(cfg.numbers.sections);
        }
        let exhausted = match fault() {
            // Said of all as soon as it is true of one.
            EARLY => [none[..cfg.lanes as usize].contains(&true); MAX_LANES],
            UNSAID => [false; MAX_LANES],
            _ => none.map(|none| none && q.bits == 0),
        };
        let mut ready = [true; MAX_LANES];
        ready[cfg.lanes as usize - 1] = fault() != CLOSED || q.bits == 0;
        Moore { grant, exhausted, ready }
    }
    fn next(cfg: &Config, q: &Free, d: &mut Free, (): &mut (), i: In) {
        let lanes = cfg.lanes as usize;
        let ready = Self::moore(cfg, q, &()).ready;
        let mut spilt = false;
        for (k, back) in i.release[..lanes].iter().enumerate() {
            if back.valid && ready[k] {
                // Of two that come back, only one finds room.
                d.bits |= u64::from(fault() != LOST || !spilt) << back.payload;
                spilt = true;
            }
        }
        for k in 0..lanes {
            let taken = i.take[k] && q.offers[k].valid;
            if !taken && q.offers[k].valid {
                if fault() != HELD {
                    continue;
                }
                // The lowest of all is offered next.
                d.bits |= 1 << q.offers[k].payload;
            }
            if fault() == OUT && taken && i.release[k].valid {
                d.bits |= 1 << q.offers[k].payload;
            }
            // The last lane gets something only where the first one is taken from.
            let passed_over = fault() == STARVES && k > 0 && !i.take[0];
            d.offers[k] = if passed_over { Stream::idle() } else { lowest(d.bits) };
            if d.offers[k].valid && !(fault() == TWICE && k > 0) {
                d.bits &= d.bits.wrapping_sub(1);
            }
        }
    }
}

/// Lanes that lose what they give to the shared allocator while it offers something.
struct Spills;

impl Contract for Spills {
    fn latency(cfg: &Config) -> u32 {
        Lanes::latency(cfg)
    }
    fn room(cfg: &Config) -> u32 {
        Lanes::room(cfg)
    }
}

/// Lanes that are said to be a cycle faster than they are.
struct Hasty;

impl Contract for Hasty {
    fn latency(cfg: &Config) -> u32 {
        Lanes::latency(cfg) - 1
    }
    fn room(cfg: &Config) -> u32 {
        Lanes::room(cfg)
    }
}

/// Lanes that are said to take a release a cycle sooner than they do.
struct Roomy;

impl Contract for Roomy {
    fn latency(cfg: &Config) -> u32 {
        Lanes::latency(cfg)
    }
    fn room(cfg: &Config) -> u32 {
        Lanes::room(cfg) - 1
    }
}

/// As the lanes of the library, but for what is done with the next state.
macro_rules! as_lanes {
    ($block:ty, $change:expr) => {
        impl Block for $block {
            type Config = Config;
            type State = <Lanes as Block>::State;
            type In = In;
            type Moore = Moore;
            type Out = ();
            type Mem = <Lanes as Block>::Mem;
            fn reset(cfg: &Config) -> Self::State {
                Lanes::reset(cfg)
            }
            fn memories(cfg: &Config) -> Self::Mem {
                Lanes::memories(cfg)
            }
            fn moore(cfg: &Config, q: &Self::State, m: &Self::Mem) -> Moore {
                Lanes::moore(cfg, q, m)
            }
            fn next(cfg: &Config, q: &Self::State, d: &mut Self::State, m: &mut Self::Mem, i: In) {
                Lanes::next(cfg, q, d, m, i);
                let change: fn(&mut Self::State) = $change;
                change(d);
            }
        }
    };
}

as_lanes!(Spills, |d| d.shared.back.valid = false);
as_lanes!(Hasty, |_| {});
as_lanes!(Roomy, |_| {});

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Bits>>(fault, property);
}

#[test]
fn a_section_that_is_out_twice_is_found() {
    is_found(TWICE, Property::Twice);
    is_found(OUT, Property::Twice);
}

#[test]
fn a_section_that_is_lost_is_found() {
    is_found(LOST, Property::Granted);
    is_found(RESET, Property::Granted);
}

#[test]
fn a_section_that_is_lost_in_a_spill_is_found() {
    let (message, _) = found::<Model<Spills>>(NONE);
    assert!(message.contains(&Property::Granted.to_string()), "{message}");
}

#[test]
fn a_lane_that_starves_is_found() {
    is_found(STARVES, Property::Granted);
}

#[test]
fn a_wrong_word_about_being_exhausted_is_found() {
    is_found(EARLY, Property::Exhausted);
    is_found(UNSAID, Property::Exhausted);
}

#[test]
fn a_section_that_there_is_not_is_found() {
    is_found(RANGE, Property::Range);
}

#[test]
fn an_offer_that_is_replaced_is_found() {
    is_found(HELD, Property::Held);
}

#[test]
fn a_lane_that_takes_no_release_is_found() {
    is_found(CLOSED, Property::Ready);
}

/// A sequence cycle by cycle, first of takes at all lanes until all sections are out.
struct Script {
    setup: Setup,
    steps: Vec<Step>,
    begin: usize,
}

impl Script {
    fn new(lanes: u32, sections: u32) -> Script {
        let take = vec![Hand { take: true, release: None }; lanes as usize];
        // Cold, the sections come one a cycle, and through two registers.
        let begin = sections as usize + 2;
        let steps = vec![Step { hands: take, reset: false }; begin];
        Script { setup: Setup { lanes, sections }, steps, begin }
    }
    fn hand(&mut self, lane: usize, cycle: usize) -> &mut Hand {
        let (lanes, cycle) = (self.setup.lanes as usize, self.begin + cycle);
        let nothing = Step { hands: vec![Hand::default(); lanes], reset: false };
        self.steps.resize(self.steps.len().max(cycle + 1), nothing);
        &mut self.steps[cycle].hands[lane]
    }
    fn takes(&mut self, lane: usize, cycles: &[usize]) {
        cycles.iter().for_each(|cycle| self.hand(lane, *cycle).take = true);
    }
    /// In each of these cycles the lowest of those that are out is given back.
    fn gives(&mut self, lane: usize, cycles: &[usize]) {
        cycles.iter().for_each(|cycle| self.hand(lane, *cycle).release = Some(0));
    }
    fn check<A: Contract + 'static>(&self) -> Result<(), Must<Property>> {
        check::<Model<A>>(&self.setup, &self.steps).map_err(|broken| broken.property)
    }
}

/// One lane that is emptied while the shared allocator searches.
fn slow_for_one() -> Script {
    let mut script = Script::new(1, 12);
    script.gives(0, &[0, 1, 2, 3, 4]);
    script.takes(0, &[5, 6, 7, 8]);
    script.hand(0, 20);
    script
}

/// The last lane waits for a search for each lane. All but one begin a cycle late, where a lane gives a section
/// in the cycle before; with two lanes one of them does not, and finds its section in another word.
fn slow_for_several(lanes: u32) -> Script {
    let mut script = Script::new(lanes, if lanes == 2 { 128 } else { 60 });
    let (last, helps) = (lanes as usize - 1, 0);
    (1..=last).for_each(|lane| script.gives(lane, &[0, 1, 2]));
    script.gives(helps, &[0, 1, 2, 3, 5, 6]);
    if lanes == 2 {
        script.hand(helps, 4).release = Some(100);
    }
    // One section is offered by the shared allocator and two are at its hand. The first goes to the lane that
    // helps, the others to the last one, which takes them at once.
    let begin = 30;
    let at = |cycles: &[usize]| cycles.iter().map(|cycle| begin + cycle).collect::<Vec<_>>();
    script.takes(last, &at(&[0, 1, 2, 3, 4]));
    script.takes(helps, &at(&[0, 3, 4, 5]));
    script.gives(helps, &at(&[1]));
    // The others empty their caches; the first of them has given a section just before it is its turn to wait.
    for lane in 1..last {
        script.takes(lane, &at(&[7, 8, 9]));
    }
    if lanes > 2 {
        script.gives(1, &at(&[6]));
        script.gives(helps, &at(&[9, 10, 11]));
        (0..lanes as usize - 3).for_each(|k| script.gives(helps, &at(&[16 + 5 * k])));
    }
    script.hand(last, begin + 40);
    script
}

/// The latency is as long as it must be.
#[test]
fn a_lane_may_wait_as_long_as_is_said() {
    for script in [slow_for_one(), slow_for_several(2), slow_for_several(3), slow_for_several(4)] {
        assert_eq!(script.check::<Lanes>(), Ok(()));
        let lanes = script.setup.lanes;
        assert_eq!(script.check::<Hasty>(), Err(Must::Keep(Property::Granted)), "{lanes} lanes");
    }
}

/// Where all caches are full, a lane is ready in its turn.
#[test]
fn a_lane_may_be_ready_in_its_turn_only() {
    for lanes in 2..=4 {
        let mut script = Script::new(lanes, 60);
        let cycles: Vec<usize> = (0..12).collect();
        (0..lanes as usize).for_each(|lane| script.gives(lane, &cycles));
        assert_eq!(script.check::<Lanes>(), Ok(()));
        assert_eq!(script.check::<Roomy>(), Err(Must::Keep(Property::Ready)), "{lanes} lanes");
    }
}
