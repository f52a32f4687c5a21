//! The contract of a queue, see [`mod@pellucid_sim::fifo`], as properties.
//!
//! A sequence says for every cycle whether an item is offered, whether the front is taken, and whether the
//! queue is reset. Items are numbered as they go in, so that a plain counter says which is due; behind the
//! last cycle all are taken, so that none can have been lost.

use crate::reference::{Judged, LONG, Long, Reference};
use pellucid_sim::fifo::{Config, In, Moore};
use pellucid_sim::{Block, Fault, Registers, Stream};
use proptest::prelude::*;
use std::collections::VecDeque;
use std::fmt;
use std::marker::PhantomData;

/// What can be tested: a block with the ports of [`pellucid_sim::Fifo`] for numbers.
pub trait Queue:
    Block<
        Config = Config<u32>,
        State: Registers<Config = Config<u32>>,
        In = In<u32>,
        Moore = Moore<u32>,
        Out = (),
    > + 'static
{
}

impl<B> Queue for B where
    B: Block<
            Config = Config<u32>,
            State: Registers<Config = Config<u32>>,
            In = In<u32>,
            Moore = Moore<u32>,
            Out = (),
        > + 'static
{
}

/// A queue whose registers have widths that depend on nothing but its depth, such as [`pellucid_sim::Fifo`].
/// A block under the clock has its whole configuration.
pub struct Alone<F>(PhantomData<F>);

/// Its registers.
#[derive(Clone, Debug, Registers)]
#[signals(Config<u32>)]
pub struct AloneState<S: Registers<Config = u32>> {
    /// Those of the queue.
    #[with(cfg.depth)]
    pub queue: S,
}

impl<F> Block for Alone<F>
where
    F: Block<
            Config = Config<u32>,
            State: Registers<Config = u32>,
            In = In<u32>,
            Moore = Moore<u32>,
            Out = (),
        >,
{
    type Config = Config<u32>;
    type State = AloneState<F::State>;
    type In = In<u32>;
    type Moore = Moore<u32>;
    type Out = ();
    type Mem = F::Mem;

    fn reset(cfg: &Config<u32>) -> Self::State {
        AloneState { queue: F::reset(cfg) }
    }
    fn memories(cfg: &Config<u32>) -> F::Mem {
        F::memories(cfg)
    }
    fn moore(cfg: &Config<u32>, q: &Self::State, m: &F::Mem) -> Moore<u32> {
        F::moore(cfg, &q.queue, m)
    }
    fn next(cfg: &Config<u32>, q: &Self::State, d: &mut Self::State, m: &mut F::Mem, i: In<u32>) {
        F::next(cfg, &q.queue, &mut d.queue, m, i);
    }
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// An item is offered; it goes in where `ready` is high.
    pub push: bool,
    /// The front is taken, where there is one.
    pub pop: bool,
    /// The queue is reset instead.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A reset empties it.
    Reset,
    /// The front stays until it is taken.
    Held,
    /// What goes in comes out once, in order.
    Order,
    /// Something is at the front while an item is in, and only then.
    Front,
    /// `ready` is high while fewer than `depth` items are in, and only then.
    Ready,
    /// `count` says how many items are in.
    Count,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Reset => "a reset empties the queue",
            Property::Held => "the front stays until it is taken",
            Property::Order => "what goes in comes out once, in order",
            Property::Front => "something is at the front while an item is in, and only then",
            Property::Ready => {
                "`ready` is high while fewer than `depth` items are in, and only then"
            }
            Property::Count => "`count` says how many items are in",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// The plain queue that a block is held to.
pub struct Model<F> {
    cfg: Config<u32>,
    /// The items that are in, the oldest first.
    items: VecDeque<u32>,
    /// The number of the next item, as many bits of it as an item has.
    next: u32,
    /// What was at the front in the cycle before and not taken.
    offered: Option<u32>,
    /// It was reset in the cycle before, or never clocked.
    fresh: bool,
    queue: PhantomData<F>,
}

impl<F: Queue> Reference for Model<F> {
    type Block = F;
    type Config = Config<u32>;
    /// Its depth, and the bits of an item.
    type Setup = Config<u32>;
    type Step = Step;
    type Property = Property;
    type Outputs = Moore<u32>;
    const NAME: &'static str = "queue";

    fn setups() -> BoxedStrategy<Config<u32>> {
        (1..=9u32).prop_map(|depth| Config { depth, item: 8 }).boxed()
    }
    fn steps(_: &Config<u32>) -> BoxedStrategy<Step> {
        let step = (any::<bool>(), any::<bool>(), prop::bool::weighted(0.02));
        step.prop_map(|(push, pop, reset)| Step { push, pop, reset }).boxed()
    }
    fn long() -> Vec<Long<Self>> {
        let often = || prop::bool::weighted(0.9);
        let step = (often(), often()).prop_map(|(push, pop)| Step { push, pop, reset: false });
        let setup = Just(Config { depth: 9, item: 8 }).boxed();
        vec![Long { setup, step: step.boxed(), steps: LONG }]
    }
    fn small() -> Vec<Config<u32>> {
        (1..=3).map(|depth| Config { depth, item: 2 }).collect()
    }
    fn told(cfg: &Config<u32>) -> String {
        format!("depth {}, items of {} bits", cfg.depth, cfg.item)
    }
    fn config(cfg: &Config<u32>) -> Config<u32> {
        *cfg
    }
    fn new(cfg: &Config<u32>) -> Model<F> {
        let (items, queue) = (VecDeque::new(), PhantomData);
        Model { cfg: *cfg, items, next: 0, offered: None, fresh: true, queue }
    }

    fn look(&mut self, _: u64, seen: &Moore<u32>) -> Judged<Property> {
        let items = self.items.len();
        let front = seen.front.valid.then_some(seen.front.payload);
        if self.fresh && (seen.count > 0 || front.is_some()) {
            let front = front.map_or("nothing".to_string(), |item| item.to_string());
            let seen = format!("`count` is {} and {front} is at the front", seen.count);
            return Err((Property::Reset, seen));
        }
        if let Some(before) = self.offered
            && front != Some(before)
        {
            let now = front.map_or("nothing".to_string(), |item| item.to_string());
            return Err((Property::Held, format!("{before} was there, then {now}")));
        }
        match (front, self.items.front()) {
            (Some(item), Some(due)) if item != *due => {
                return Err((
                    Property::Order,
                    format!("{item} is at the front where {due} is due"),
                ));
            }
            (Some(item), None) => {
                return Err((Property::Front, format!("{item} is there while nothing is in")));
            }
            (None, Some(due)) => {
                return Err((Property::Front, format!("nothing is there while {due} is due")));
            }
            _ => {}
        }
        if seen.ready != (items < self.cfg.depth as usize) {
            let level = if seen.ready { "high" } else { "low" };
            let depth = self.cfg.depth;
            return Err((Property::Ready, format!("{level} while {items} of {depth} are in")));
        }
        if seen.count as usize != items {
            return Err((Property::Count, format!("{} while {items} are in", seen.count)));
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, seen: &Moore<u32>) -> Option<In<u32>> {
        self.fresh = step.reset;
        if step.reset {
            self.items.clear();
            self.offered = None;
            return None;
        }
        let push = if step.push { Stream::offer(self.next) } else { Stream::idle() };
        self.offered = if step.pop { None } else { self.items.front().copied() };
        if step.pop {
            self.items.pop_front();
        }
        if step.push && seen.ready {
            self.items.push_back(self.next);
            self.next = (self.next + 1) & ((1 << self.cfg.item) - 1);
        }
        Some(In { push, pop: step.pop })
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        (!self.items.is_empty()).then_some(Step { pop: true, ..Step::default() })
    }
    fn choices(&self) -> Vec<Step> {
        let inputs = [(false, false), (false, true), (true, false), (true, true)];
        let inputs = inputs.map(|(push, pop)| Step { push, pop, reset: false });
        inputs.into_iter().chain([Step { reset: true, ..Step::default() }]).collect()
    }
    fn known(&self, to: &mut Vec<u64>) {
        to.extend([u64::from(self.next), u64::from(self.offered.is_some())]);
        to.push(u64::from(self.fresh));
        to.extend(self.items.iter().map(|item| u64::from(*item)));
    }
    fn outputs(seen: &Moore<u32>, _: Option<&()>) -> Moore<u32> {
        *seen
    }
    fn tell(&self, inputs: &In<u32>) -> Vec<String> {
        let mut what = vec![];
        what.extend(inputs.push.valid.then(|| format!("push {}", inputs.push.payload)));
        what.extend(inputs.pop.then(|| "pop".to_string()));
        what
    }
}

/// Tests of everything that the contract of a queue asks for: `fifo_properties!(MyFifo)`, or with a name for
/// the module that they stand in, `fifo_properties!(MyFifo, mine)`.
#[macro_export]
macro_rules! fifo_properties {
    ($queue:ty) => {
        $crate::fifo_properties!($queue, fifo_properties);
    };
    ($queue:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::fifo::Model<$queue>, $name $(, $states)?);
    };
}
