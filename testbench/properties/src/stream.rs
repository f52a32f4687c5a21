//! The contract of a stage, a block that takes one stream and gives another, as properties: the rules of
//! [`mod@pellucid_sim::stream`], and nothing lost, doubled or out of order.
//!
//! A sequence says for every cycle whether the next item is offered, whether the receiver is ready, and
//! whether the stage is reset. An offer stays until it is taken. Behind the last cycle the rest is sent and
//! the receiver is always ready, so that all that is due must come.

use crate::reference::{Judged, Long, Reference};
use pellucid_sim::{Block, Fault, Fifo, Registers, Signals, Stream, fifo};
use proptest::prelude::*;
use std::fmt::{self, Debug};

/// The most items that are sent. What must be given is asked for anew with each, which is why there are no more.
pub const MOST_ITEMS: u32 = 4000;

/// A block that takes one stream and gives another.
pub trait Stage:
    Block<
        Config: Clone + Debug,
        State: Registers<Config = Self::Config>,
        In: Signals<Config = Self::Config>,
        Moore: Signals<Config = Self::Config>,
    > + 'static
{
    /// What it takes.
    type Item: Copy + Default + Debug;
    /// What it gives.
    type Gives: Copy + Debug + PartialEq;

    /// Configurations to be tried, the smallest first.
    fn configs() -> Vec<Self::Config>;
    /// Item `number` of those that are sent, of which there may be [`MOST_ITEMS`].
    fn item(cfg: &Self::Config, number: u32) -> Self::Item;
    /// What it must give once it has taken these items, in order.
    fn gives(cfg: &Self::Config, items: &[Self::Item]) -> Vec<Self::Gives>;
    /// The most cycles in a row in which nothing is taken or given, while more is offered or due and the
    /// receiver is ready.
    fn latency(cfg: &Self::Config) -> u32;
    /// The inputs for an offer, and a receiver that is ready or not.
    fn inputs(offer: Stream<Self::Item>, ready: bool) -> Self::In;
    /// Whether an item is taken.
    fn ready(seen: &Self::Moore) -> bool;
    /// What is given.
    fn given(seen: &Self::Moore) -> Stream<Self::Gives>;
}

impl Stage for crate::fifo::Alone<Fifo<u32>> {
    type Item = u32;
    type Gives = u32;
    fn configs() -> Vec<Self::Config> {
        [1, 2, 3, 8].map(|depth| fifo::Config { depth, item: 8 }).to_vec()
    }
    fn item(cfg: &Self::Config, number: u32) -> u32 {
        number & ((1 << cfg.item) - 1)
    }
    fn gives(_: &Self::Config, items: &[u32]) -> Vec<u32> {
        items.to_vec()
    }
    fn latency(_: &Self::Config) -> u32 {
        0
    }
    fn inputs(push: Stream<u32>, pop: bool) -> fifo::In<u32> {
        fifo::In { push, pop }
    }
    fn ready(seen: &fifo::Moore<u32>) -> bool {
        seen.ready
    }
    fn given(seen: &fifo::Moore<u32>) -> Stream<u32> {
        seen.front
    }
}

/// The two ends of a stage: items that are sent, each offered until it is taken, and a receiver.
pub(crate) struct StreamDriver<T, G> {
    items: Vec<T>,
    /// How many were taken by the stage.
    pub(crate) sent: usize,
    /// How many were taken from it.
    pub(crate) given: usize,
    /// Cycles in a row in which nothing moved, though it could.
    pub(crate) still: u32,
    /// The next item is offered until it is taken.
    offering: bool,
    /// What was given in the cycle before and not taken.
    held: Option<G>,
}

impl<T: Copy + Default, G: Copy + Debug + PartialEq> StreamDriver<T, G> {
    pub(crate) fn new(items: Vec<T>) -> StreamDriver<T, G> {
        StreamDriver { items, sent: 0, given: 0, still: 0, offering: false, held: None }
    }

    /// The items that the stage has taken.
    pub(crate) fn taken(&self) -> &[T] {
        &self.items[..self.sent]
    }

    /// Whether all were.
    pub(crate) fn all_taken(&self) -> bool {
        self.sent == self.items.len()
    }

    /// All begins anew.
    pub(crate) fn reset(&mut self) {
        *self = StreamDriver::new(std::mem::take(&mut self.items));
    }

    /// What is wrong with what is given, after what was given in the cycle before.
    pub(crate) fn held(&self, now: Stream<G>) -> Result<(), String> {
        match self.held {
            Some(before) if !now.valid => Err(format!("{before:?} was given, then nothing")),
            Some(before) if now.payload != before => {
                Err(format!("{before:?} was given, then {:?}", now.payload))
            }
            _ => Ok(()),
        }
    }

    /// The rest of a cycle in which the stage is `ready` and gives what it `gives`; `more` of it is due. Gives
    /// what is offered to it.
    pub(crate) fn cycle(
        &mut self,
        step: Step,
        ready: bool,
        gives: Stream<G>,
        more: bool,
    ) -> Stream<T> {
        self.offering |= step.offer;
        let next = self.items.get(self.sent).filter(|_| self.offering).copied();
        let (taken, given) = (next.is_some() && ready, gives.valid && step.ready);
        let could = step.ready && (next.is_some() || more);
        self.still = if could && !taken && !given { self.still + 1 } else { 0 };
        self.held = (gives.valid && !given).then_some(gives.payload);
        self.sent += usize::from(taken);
        self.given += usize::from(given);
        self.offering &= !taken;
        next.map_or(Stream::idle(), Stream::offer)
    }

    /// All that is remembered.
    pub(crate) fn known(&self, to: &mut Vec<u64>) {
        let flags = u64::from(self.offering) | u64::from(self.held.is_some()) << 1;
        to.extend([self.sent as u64, self.given as u64, flags, u64::from(self.still)]);
    }
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The next item is offered from now on.
    pub offer: bool,
    /// The receiver is ready.
    pub ready: bool,
    /// The stage is reset instead, and all begins anew.
    pub reset: bool,
}

impl Step {
    /// A step in which all moves that can.
    pub(crate) const MOVES: Step = Step { offer: true, ready: true, reset: false };

    /// Steps of a random sequence.
    pub(crate) fn any() -> BoxedStrategy<Step> {
        let bits = (any::<bool>(), any::<bool>(), prop::bool::weighted(0.01));
        bits.prop_map(|(offer, ready, reset)| Step { offer, ready, reset }).boxed()
    }

    /// Steps of a long sequence: all moves most of the time.
    pub(crate) fn often() -> BoxedStrategy<Step> {
        let often = || prop::bool::weighted(0.9);
        (often(), often()).prop_map(|(offer, ready)| Step { offer, ready, reset: false }).boxed()
    }

    /// Every step.
    pub(crate) fn all() -> Vec<Step> {
        let inputs = [(false, false), (true, false), (false, true), (true, true)];
        let inputs = inputs.map(|(offer, ready)| Step { offer, ready, reset: false });
        inputs.into_iter().chain([Step { reset: true, ..Step::default() }]).collect()
    }
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// What is given is held until it is taken.
    Held,
    /// What must come comes once, in order.
    Order,
    /// Nothing is given but for what was taken.
    Early,
    /// While the receiver is ready, all goes on within the latency.
    Stuck,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Held => "what is given is held until it is taken",
            Property::Order => "what must come comes once, in order",
            Property::Early => "nothing is given but for what was taken",
            Property::Stuck => "while the receiver is ready, all goes on within the latency",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// What is fixed while a sequence is played.
#[derive(Clone, Debug)]
pub struct Setup<C> {
    /// The stage's configuration.
    pub cfg: C,
    /// How many items are sent.
    pub items: u32,
}

/// What a stage is held to.
pub struct Model<S: Stage> {
    cfg: S::Config,
    ends: StreamDriver<S::Item, S::Gives>,
    /// All that must be given for what was taken.
    due: Vec<S::Gives>,
    /// What is offered in this cycle, by its number, and whether the receiver is ready.
    last: (Option<usize>, bool),
}

impl<S: Stage> Reference for Model<S> {
    type Block = S;
    type Config = S::Config;
    type Setup = Setup<S::Config>;
    type Step = Step;
    type Property = Property;
    type Outputs = S::Moore;
    const NAME: &'static str = "stage";

    fn setups() -> BoxedStrategy<Self::Setup> {
        let configs = prop::sample::select(S::configs());
        (configs, 0..=40u32).prop_map(|(cfg, items)| Setup { cfg, items }).boxed()
    }
    fn steps(_: &Self::Setup) -> BoxedStrategy<Step> {
        Step::any()
    }
    fn long() -> Vec<Long<Self>> {
        let long = |cfg| {
            let setup = Just(Setup { cfg, items: MOST_ITEMS }).boxed();
            Long { setup, step: Step::often(), steps: 5000 }
        };
        S::configs().into_iter().map(long).collect()
    }
    fn small() -> Vec<Self::Setup> {
        S::configs().into_iter().map(|cfg| Setup { cfg, items: 4 }).collect()
    }
    fn told(setup: &Self::Setup) -> String {
        format!("{:?}, {} items", setup.cfg, setup.items)
    }
    fn config(setup: &Self::Setup) -> S::Config {
        setup.cfg.clone()
    }
    fn new(Setup { cfg, items }: &Self::Setup) -> Model<S> {
        let items = (0..*items).map(|number| S::item(cfg, number)).collect();
        let due = S::gives(cfg, &[]);
        Model { cfg: cfg.clone(), ends: StreamDriver::new(items), due, last: (None, false) }
    }

    fn look(&mut self, _: u64, seen: &S::Moore) -> Judged<Property> {
        let given = S::given(seen);
        self.ends.held(given).map_err(|seen| (Property::Held, seen))?;
        let due = self.due.get(self.ends.given);
        match due {
            Some(due) if given.valid && given.payload != *due => {
                let seen = format!("{:?} came where {due:?} is due", given.payload);
                return Err((Property::Order, seen));
            }
            None if given.valid => {
                let seen = format!("{:?} came where nothing is due", given.payload);
                return Err((Property::Early, seen));
            }
            _ => {}
        }
        if self.ends.still > S::latency(&self.cfg) {
            return Err((Property::Stuck, format!("nothing moves for {} cycles", self.ends.still)));
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, seen: &S::Moore) -> Option<S::In> {
        if step.reset {
            self.ends.reset();
            self.due = S::gives(&self.cfg, &[]);
            return None;
        }
        let (sent, more) = (self.ends.sent, self.ends.given < self.due.len());
        let offer = self.ends.cycle(*step, S::ready(seen), S::given(seen), more);
        self.last = (offer.valid.then_some(sent), step.ready);
        if self.ends.sent > sent {
            self.due = S::gives(&self.cfg, self.ends.taken());
        }
        Some(S::inputs(offer, step.ready))
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        let all = self.ends.all_taken() && self.ends.given >= self.due.len();
        (!all).then_some(Step::MOVES)
    }
    fn choices(&self) -> Vec<Step> {
        Step::all()
    }
    fn known(&self, to: &mut Vec<u64>) {
        self.ends.known(to);
    }
    fn outputs(seen: &S::Moore, _: Option<&S::Out>) -> S::Moore {
        *seen
    }
    fn tell(&self, _: &S::In) -> Vec<String> {
        let (offer, ready) = self.last;
        let mut what = vec![];
        what.extend(offer.map(|number| format!("item {number} is offered")));
        what.extend(ready.then(|| "ready".to_string()));
        what
    }
}

/// Tests of everything that the contract of a stage asks for: `stream_properties!(MyStage)`, or with a name
/// for the module that they stand in, `stream_properties!(MyStage, mine)`.
#[macro_export]
macro_rules! stream_properties {
    ($stage:ty) => {
        $crate::stream_properties!($stage, stream_properties);
    };
    ($stage:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::stream::Model<$stage>, $name $(, $states)?);
    };
}
