//! Runs a block beside its [`Reference`]: a sequence by hand, or every state of a small one.

use crate::panics::caught;
use crate::reference::{Judged, Reference};
use pellucid_sim::{Block, Memory, Registers, Sim};
use std::collections::{HashSet, VecDeque};
use std::fmt::{self, Display};

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Must<P> {
    /// A property of the contract.
    Keep(P),
    /// Nothing panics, in the block or in what a contract of one's own says of it: asked of every block.
    NotPanic,
}

impl<P: Display> Display for Must<P> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Must::Keep(property) => property.fmt(f),
            Must::NotPanic => f.write_str("nothing panics"),
        }
    }
}

/// A broken property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken<P> {
    /// Which.
    pub property: Must<P>,
    /// In which cycle of the sequence; those that show that nothing is lost follow it.
    pub cycle: u64,
    /// What was seen.
    pub seen: String,
}

impl<P: Display> Display for Broken<P> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "broken in cycle {}: {}: {}", self.cycle, self.property, self.seen)
    }
}

/// What there is to see in a cycle.
pub(crate) struct Seen<R: Reference> {
    pub(crate) cycle: u64,
    pub(crate) q: <R::Block as Block>::State,
    /// None where it is reset or only looked at.
    pub(crate) inputs: Option<<R::Block as Block>::In>,
    /// None where it panics before.
    pub(crate) outputs: Option<R::Outputs>,
    pub(crate) reset: bool,
}

/// A block under the clock, and what it is held to.
pub(crate) struct Run<R: Reference> {
    sim: Sim<R::Block>,
    reference: R,
    cycle: u64,
    /// The cycle was looked at.
    looked: bool,
    /// A fault that must be has ended the sequence.
    over: bool,
}

impl<R: Reference> Run<R> {
    /// A block in reset.
    ///
    /// # Errors
    /// It panics.
    pub(crate) fn new(setup: &R::Setup) -> Result<Run<R>, Broken<R::Property>> {
        let made = caught(|| (Sim::new(R::config(setup)), R::new(setup)));
        let (sim, reference) =
            made.map_err(|seen| Broken { property: Must::NotPanic, cycle: 0, seen })?;
        Ok(Run { sim, reference, cycle: 0, looked: false, over: false })
    }

    /// One cycle; without a step it is only looked at. `show` is told of it.
    fn step(
        &mut self,
        step: Option<&R::Step>,
        show: &mut dyn FnMut(&R, Seen<R>),
    ) -> Result<(), Broken<R::Property>> {
        let (cycle, q) = (self.cycle, self.sim.state().clone());
        let mut seen = Seen { cycle, q, inputs: None, outputs: None, reset: false };
        let judged = match caught(|| self.clock(step, &mut seen)) {
            Ok(judged) => judged.map_err(|(property, seen)| (Must::Keep(property), seen)),
            Err(said) => Err((Must::NotPanic, said)),
        };
        if step.is_some() || judged.is_err() {
            show(&self.reference, seen);
        }
        judged.map_err(|(property, seen)| Broken { property, cycle, seen })?;
        if step.is_some() {
            self.cycle += 1;
            self.looked = false;
        }
        Ok(())
    }

    fn clock(&mut self, step: Option<&R::Step>, to: &mut Seen<R>) -> Judged<R::Property> {
        let seen = self.sim.moore();
        to.outputs = Some(R::outputs(&seen, None));
        if !self.looked {
            self.looked = true;
            self.reference.look(self.cycle, &seen)?;
        }
        let Some(step) = step else { return Ok(()) };
        to.inputs = self.reference.inputs(step, &seen);
        let Some(inputs) = to.inputs else {
            to.reset = true;
            self.sim.reset();
            return Ok(());
        };
        match self.sim.clock(inputs) {
            Ok(clocked) => {
                to.outputs = Some(R::outputs(&seen, Some(&clocked.out)));
                self.reference.judge(&clocked.out)
            }
            Err(fault) => {
                self.over = true;
                let out = self.sim.at_fault().map(|cycle| cycle.out);
                to.outputs = Some(R::outputs(&seen, out.as_ref()));
                self.reference.fault(&fault)
            }
        }
    }

    /// The sequence, then what shows that nothing is lost.
    pub(crate) fn play<'a>(
        &mut self,
        steps: impl IntoIterator<Item = &'a R::Step>,
        show: &mut dyn FnMut(&R, Seen<R>),
    ) -> Result<(), Broken<R::Property>> {
        for step in steps {
            self.step(Some(step), show)?;
            if self.over {
                return Ok(());
            }
        }
        while let Some(step) = self.reference.rest() {
            self.step(Some(&step), show)?;
        }
        self.step(None, show)
    }

    /// All that is known of the block and of its model.
    fn known(&mut self) -> Vec<u64> {
        let mut values = vec![];
        Registers::sample(self.sim.state(), self.sim.config(), &mut values);
        self.sim.memories().visit("", &mut |_, storage| {
            (0..storage.info().words).for_each(|k| storage.peek(k as u32, &mut values));
            storage.under_way(&mut values);
        });
        self.reference.known(&mut values);
        values
    }
}

/// Plays a sequence.
///
/// # Errors
/// The first property that is broken.
pub fn check<R: Reference>(setup: &R::Setup, steps: &[R::Step]) -> Result<(), Broken<R::Property>> {
    Run::<R>::new(setup)?.play(steps, &mut |_, _| {})
}

/// What a search has found: a broken property and the shortest sequence that breaks it.
pub type Found<R> = (Broken<<R as Reference>::Property>, Vec<<R as Reference>::Step>);

/// How far a search has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Searched {
    /// How many states it has seen.
    pub states: usize,
    /// There is no other.
    pub every: bool,
}

/// A search plays so many cycles for each state that it may see: the way to every state is played again.
const CYCLES: u64 = 200;

/// Looks at every state that a block can come to, by every step in each: a plain search, from reset on, of
/// `most` states and 200 times as many cycles at most.
///
/// # Errors
/// The first property that is broken.
pub fn exhaust<R: Reference>(setup: &R::Setup, most: usize) -> Result<Searched, Found<R>> {
    let mut left = most as u64 * CYCLES;
    let mut seen: HashSet<Vec<u64>> = HashSet::new();
    let mut next = VecDeque::from([vec![]]);
    // What breaks only behind a sequence, unless a shorter one is found before.
    let mut behind: Option<Found<R>> = None;
    while seen.len() < most
        && left > 0
        && let Some(steps) = next.pop_front()
    {
        if let Some(found) = behind.take_if(|(broken, _)| broken.cycle < steps.len() as u64) {
            return Err(found);
        }
        // A block cannot be copied: the way to the state is gone again.
        let mut run = match Run::<R>::new(setup) {
            Ok(run) => run,
            Err(broken) => return Err((broken, steps)),
        };
        let look =
            |run: &mut Run<R>| if run.over { Ok(()) } else { run.step(None, &mut |_, _| {}) };
        let mut way = steps.iter();
        let played = way.try_for_each(|step| run.step(Some(step), &mut |_, _| {}));
        if let Err(broken) = played.and_then(|()| look(&mut run)) {
            return Err((broken, steps));
        }
        left = left.saturating_sub(run.cycle);
        if run.over || !seen.insert(run.known()) {
            continue;
        }
        next.extend(run.reference.choices().into_iter().map(|step| {
            let mut longer = steps.clone();
            longer.push(step);
            longer
        }));
        if let Err(broken) = run.play([], &mut |_, _| {})
            && behind.as_ref().is_none_or(|(before, _)| broken.cycle < before.cycle)
        {
            behind = Some((broken, steps));
        }
    }
    behind.map_or(Ok(Searched { states: seen.len(), every: next.is_empty() }), Err)
}
