//! The contract of an allocator with lanes, see [`mod@pellucid_blocks::allocator::lanes`], as properties.
//!
//! A sequence says for every cycle and every lane whether what is offered is taken and which of the sections
//! that are out is given back, if any, and whether the allocator is reset. A section may be given back to
//! another lane than the one that granted it. A plain list of the sections that are out says what must hold;
//! behind the last cycle all sections are taken, through all lanes, so that none can have been lost.

use crate::harness;
use crate::reference::{Judged, LONG, Long, Reference};
use pellucid_blocks::allocator::Config as Numbers;
use pellucid_blocks::allocator::lanes::{Config, Contract, In, MAX_LANES, Moore};
use pellucid_sim::{Fault, Stream};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// What happens at a lane in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hand {
    /// What the lane offers is taken.
    pub take: bool,
    /// A section is given back to it: this one of those that are out, counted round from the lowest.
    pub release: Option<u8>,
}

/// What happens in a cycle.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// At each lane; nothing at those that are not named.
    pub hands: Vec<Hand>,
    /// The allocator is reset instead.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A granted section is one of those that there are.
    Range,
    /// No section is out twice, nor offered by two lanes.
    Twice,
    /// What a lane offers is held until it is taken.
    Held,
    /// While a section is free that no other lane offers, a lane grants one within the latency.
    Granted,
    /// `exhausted` is high where no section is free but for those that other lanes offer, and only there.
    Exhausted,
    /// A lane takes a release within the stated time.
    Ready,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Range => "a granted section is one of those that there are",
            Property::Twice => "no section is out twice, nor offered by two lanes",
            Property::Held => "what a lane offers is held until it is taken",
            Property::Granted => {
                "while a section is free that no other lane offers, a lane grants one within the latency"
            }
            Property::Exhausted => {
                "`exhausted` is high where no section is free but for those that other lanes offer, and \
                 only there"
            }
            Property::Ready => "a lane takes a release within the stated time",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// A broken property.
pub type Broken = harness::Broken<Property>;

/// How many lanes and sections there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Lanes.
    pub lanes: u32,
    /// Sections.
    pub sections: u32,
}

impl Setup {
    fn config(self) -> Config {
        Config { lanes: self.lanes, numbers: Numbers { sections: self.sections } }
    }
}

/// What is remembered of a lane.
#[derive(Clone, Copy, Default)]
struct Lane {
    /// What it offered in the cycle before and was not taken.
    offered: Option<u32>,
    /// Cycles in a row in which it offered nothing and a section was free for it.
    without: u32,
    /// How many were free for it as it was said that none is; 0 if that was not said.
    said: u32,
    /// Cycles in a row in which none was free for it and that was not said.
    unsaid: u32,
    /// Cycles in a row in which it was not ready.
    closed: u32,
}

/// The plain list that an allocator is held to.
pub struct Model<A> {
    setup: Setup,
    latency: u32,
    room: u32,
    cycle: u64,
    /// The sections that are out: which lane granted each, and in which cycle.
    out: BTreeMap<u32, (u32, u64)>,
    lanes: Vec<Lane>,
    allocator: PhantomData<A>,
}

impl<A: Contract + 'static> Reference for Model<A> {
    type Block = A;
    type Config = Config;
    type Setup = Setup;
    type Step = Step;
    type Property = Property;
    type Outputs = Moore;
    const NAME: &'static str = "lanes";

    fn setups() -> BoxedStrategy<Setup> {
        // Seldom so many that they fill several words of bits.
        let sections = prop_oneof![4 => 0..=MANY.min(A::MOST), 1 => 0..=A::MOST.min(150)];
        (1..=LANES, sections).prop_map(|(lanes, sections)| Setup { lanes, sections }).boxed()
    }
    fn steps(setup: &Setup) -> BoxedStrategy<Step> {
        step(*setup, [0.6, 0.5, 0.01])
    }
    fn long() -> Vec<Long<Self>> {
        [(1, FEW), (LANES, MANY)]
            .map(|(lanes, sections)| {
                let setup = Setup { lanes, sections: sections.min(A::MOST) };
                let step = step(setup, [0.95, 0.9, 0.0]);
                Long { setup: Just(setup).boxed(), step, steps: LONG }
            })
            .into()
    }
    fn small() -> Vec<Setup> {
        let setup = |(lanes, sections)| Setup { lanes, sections };
        [(1, 0), (1, 1), (1, 2), (1, 3), (2, 0), (2, 1), (2, 2)].map(setup).to_vec()
    }
    fn told(setup: &Setup) -> String {
        format!("{} lanes, {} sections", setup.lanes, setup.sections)
    }
    fn config(setup: &Setup) -> Config {
        setup.config()
    }
    fn new(setup: &Setup) -> Model<A> {
        Model {
            setup: *setup,
            latency: A::latency(&setup.config()).max(1),
            room: A::room(&setup.config()).max(1),
            cycle: 0,
            out: BTreeMap::new(),
            lanes: vec![Lane::default(); setup.lanes as usize],
            allocator: PhantomData,
        }
    }

    fn look(&mut self, cycle: u64, seen: &Moore) -> Judged<Property> {
        self.cycle = cycle;
        let grants: Vec<Option<u32>> = (0..self.lanes.len()).map(|k| granted(seen, k)).collect();
        for (k, lane) in self.lanes.iter().enumerate() {
            if let Some(before) = lane.offered
                && grants[k] != Some(before)
            {
                let now = grants[k].map_or("nothing".to_string(), |id| id.to_string());
                return Err((Property::Held, format!("lane {k} offered {before}, then {now}")));
            }
        }
        for (k, grant) in grants.iter().enumerate() {
            let Some(id) = *grant else { continue };
            if id >= self.setup.sections {
                let seen = format!("lane {k} offers {id} of {} sections", self.setup.sections);
                return Err((Property::Range, seen));
            }
            if let Some((lane, since)) = self.out.get(&id) {
                let seen = format!(
                    "lane {k} offers {id}, which is out through lane {lane} since cycle {since}"
                );
                return Err((Property::Twice, seen));
            }
            if let Some(other) = grants[..k].iter().position(|other| *other == *grant) {
                return Err((Property::Twice, format!("lanes {other} and {k} offer {id}")));
            }
        }
        let free = self.setup.sections - self.out.len() as u32;
        let offered = grants.iter().flatten().count() as u32;
        for (k, lane) in self.lanes.iter_mut().enumerate() {
            // Free, and not offered by others.
            let free = free - offered + u32::from(grants[k].is_some());
            let exhausted = seen.exhausted[k];
            let without = free > 0 && grants[k].is_none();
            lane.without = if without { lane.without + 1 } else { 0 };
            if lane.without >= self.latency {
                let cycles = lane.without;
                let seen =
                    format!("{free} are free and lane {k} offers nothing for {cycles} cycles");
                return Err((Property::Granted, seen));
            }
            // What was said wrongly is so if one is granted after all: else it is lost.
            if exhausted && free > 0 {
                lane.said = free;
            }
            if lane.said > 0 && !without {
                let seen = format!("it was high at lane {k} while {} were free", lane.said);
                return Err((Property::Exhausted, seen));
            }
            lane.unsaid = if free == 0 && !exhausted { lane.unsaid + 1 } else { 0 };
            if lane.unsaid >= self.latency {
                let seen = format!("it is low at lane {k} while none is free");
                return Err((Property::Exhausted, seen));
            }
            lane.closed = if seen.ready[k] { 0 } else { lane.closed + 1 };
            if lane.closed >= self.room {
                let seen = format!("lane {k} is not ready for {} cycles", lane.closed);
                return Err((Property::Ready, seen));
            }
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, seen: &Moore) -> Option<In> {
        if step.reset {
            self.out.clear();
            self.lanes.fill(Lane::default());
            return None;
        }
        let mut inputs = In::default();
        // What is given back is one of those that are out, and each but once.
        let mut left: Vec<u32> = self.out.keys().copied().collect();
        for (k, hand) in step.hands.iter().enumerate().take(self.lanes.len()) {
            if let Some(back) = hand.release.filter(|_| !left.is_empty()) {
                let id = left.remove(usize::from(back) % left.len());
                inputs.release[k] = Stream::offer(id);
                if seen.ready[k] {
                    self.out.remove(&id);
                }
            }
            inputs.take[k] = hand.take;
        }
        for (k, lane) in self.lanes.iter_mut().enumerate() {
            let grant = granted(seen, k);
            lane.offered = grant.filter(|_| !inputs.take[k]);
            let taken = grant.filter(|_| inputs.take[k]);
            self.out.extend(taken.map(|id| (id, (k as u32, self.cycle))));
        }
        Some(inputs)
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        let take = Hand { take: true, release: None };
        let all = Step { hands: vec![take; self.lanes.len()], reset: false };
        ((self.out.len() as u32) < self.setup.sections).then_some(all)
    }
    fn choices(&self) -> Vec<Step> {
        let out = self.out.len() as u8;
        let releases = |left: u8| (0..left).map(Some).chain([None]);
        // What each lane gives back is counted among what the lanes before it have left.
        let mut all: Vec<(Vec<Hand>, u8)> = vec![(vec![], out)];
        for _ in &self.lanes {
            let longer = |(hands, left): (Vec<Hand>, u8)| {
                releases(left).flat_map(move |release| {
                    let hands = hands.clone();
                    [false, true].map(move |take| {
                        let hands = [&hands[..], &[Hand { take, release }]].concat();
                        (hands, left - u8::from(release.is_some()))
                    })
                })
            };
            all = all.into_iter().flat_map(longer).collect();
        }
        let steps = all.into_iter().map(|(hands, _)| Step { hands, reset: false });
        steps.chain([Step { reset: true, ..Step::default() }]).collect()
    }
    fn known(&self, to: &mut Vec<u64>) {
        for lane in &self.lanes {
            to.push(lane.offered.map_or(0, |id| u64::from(id) + 1));
            to.extend([lane.without, lane.said, lane.unsaid, lane.closed].map(u64::from));
        }
        to.extend(self.out.keys().map(|id| u64::from(*id)));
    }
    fn outputs(seen: &Moore, _: Option<&()>) -> Moore {
        *seen
    }
    fn tell(&self, inputs: &In) -> Vec<String> {
        let mut what = vec![];
        for k in 0..self.lanes.len() {
            what.extend(inputs.take[k].then(|| format!("take {k}")));
            let Stream { valid, payload } = inputs.release[k];
            what.extend(valid.then(|| format!("release {payload} to {k}")));
        }
        what
    }
}

/// What a lane grants.
fn granted(seen: &Moore, lane: usize) -> Option<u32> {
    let grant = seen.grant[lane];
    grant.valid.then_some(grant.payload)
}

/// Steps in which each lane's offer is taken, a section is given back to it and the allocator is reset this often.
fn step(setup: Setup, [take, release, reset]: [f64; 3]) -> BoxedStrategy<Step> {
    let release = prop::option::weighted(release, any::<u8>());
    let hand = (prop::bool::weighted(take), release);
    let hand = hand.prop_map(|(take, release)| Hand { take, release });
    // Now and then all lanes do the same.
    let hands = prop::collection::vec(hand, setup.lanes as usize);
    (hands, 0..12u32, prop::bool::weighted(reset))
        .prop_map(|(mut hands, all, reset)| {
            for hand in &mut hands {
                match all {
                    0..=1 => *hand = Hand { take: true, release: None },
                    2 => hand.take = false,
                    _ => {}
                }
            }
            Step { hands, reset }
        })
        .boxed()
}

/// The most lanes in a random sequence.
const LANES: u32 = 4;
const _: () = assert!(LANES as usize <= MAX_LANES);
/// In most random sequences there are no more sections than this.
const MANY: u32 = 40;
/// So many are taken and given back again and again by one lane of a long sequence.
const FEW: u32 = 9;

/// Tests of everything that the contract of an allocator with lanes asks for: `lanes_properties!(MyLanes)`, or
/// with a name for the module that they stand in, `lanes_properties!(MyLanes, mine)`.
#[macro_export]
macro_rules! lanes_properties {
    ($lanes:ty) => {
        $crate::lanes_properties!($lanes, lanes_properties);
    };
    ($lanes:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::lanes::Model<$lanes>, $name $(, $states)?);
    };
}
