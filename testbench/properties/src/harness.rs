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
    /// The inputs in words.
    pub(crate) told: Vec<String>,
}

/// A block under the clock and what it is held to, whatever the block is: what plays and searches is compiled once for
/// all blocks of a contract, those with a fault among them.
pub(crate) trait Play<S, P> {
    /// One cycle; without a step it is only looked at.
    fn step(&mut self, step: Option<&S>) -> Result<(), Broken<P>>;
    /// A fault that must be has ended the sequence.
    fn is_over(&self) -> bool;
    /// How many cycles were played.
    fn cycle(&self) -> u64;
    /// All that is known of the block and of its model.
    fn known(&mut self) -> Vec<u64>;
    /// See [`Reference::rest`].
    fn rest(&self) -> Option<S>;
    /// See [`Reference::choices`].
    fn choices(&self) -> Vec<S>;
}

/// A block in reset, unless it panics there.
pub(crate) type Made<S, P> = Result<Box<dyn Play<S, P>>, Broken<P>>;

/// The block of a reference in reset.
pub(crate) fn make<R: Reference>(setup: &R::Setup) -> Made<R::Step, R::Property> {
    Ok(Box::new(Run::<R>::new(setup)?))
}

/// Plays a sequence, then what shows that nothing is lost.
pub(crate) fn play<'a, S: 'a, P>(
    run: &mut dyn Play<S, P>,
    steps: &mut dyn Iterator<Item = &'a S>,
) -> Result<(), Broken<P>> {
    for step in steps {
        run.step(Some(step))?;
        if run.is_over() {
            return Ok(());
        }
    }
    while let Some(step) = run.rest() {
        run.step(Some(&step))?;
    }
    run.step(None)
}

/// See [`Play`].
pub(crate) struct Run<R: Reference> {
    sim: Sim<R::Block>,
    reference: R,
    cycle: u64,
    /// The cycle was looked at.
    looked: bool,
    over: bool,
    /// The cycles so far, where they are to be shown.
    pub(crate) kept: Option<Vec<Seen<R>>>,
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
        Ok(Run { sim, reference, cycle: 0, looked: false, over: false, kept: None })
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
}

impl<R: Reference> Play<R::Step, R::Property> for Run<R> {
    fn step(&mut self, step: Option<&R::Step>) -> Result<(), Broken<R::Property>> {
        let (cycle, q) = (self.cycle, self.sim.state().clone());
        let (inputs, outputs, told) = (None, None, vec![]);
        let mut seen = Seen { cycle, q, inputs, outputs, reset: false, told };
        let judged = match caught(|| self.clock(step, &mut seen)) {
            Ok(judged) => judged.map_err(|(property, seen)| (Must::Keep(property), seen)),
            Err(said) => Err((Must::NotPanic, said)),
        };
        if let Some(kept) = &mut self.kept
            && (step.is_some() || judged.is_err())
        {
            seen.told = seen.inputs.map_or(vec![], |inputs| self.reference.tell(&inputs));
            kept.push(seen);
        }
        judged.map_err(|(property, seen)| Broken { property, cycle, seen })?;
        if step.is_some() {
            self.cycle += 1;
            self.looked = false;
        }
        Ok(())
    }
    fn is_over(&self) -> bool {
        self.over
    }
    fn cycle(&self) -> u64 {
        self.cycle
    }
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
    fn rest(&self) -> Option<R::Step> {
        self.reference.rest()
    }
    fn choices(&self) -> Vec<R::Step> {
        self.reference.choices()
    }
}

/// Plays a sequence.
///
/// # Errors
/// The first property that is broken.
pub fn check<R: Reference>(setup: &R::Setup, steps: &[R::Step]) -> Result<(), Broken<R::Property>> {
    play(&mut *make::<R>(setup)?, &mut steps.iter())
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
    searched(&|| make::<R>(setup), most)
}

/// [`exhaust`] of a block that is made anew for each way.
pub(crate) fn searched<S: Clone, P>(
    make: &dyn Fn() -> Made<S, P>,
    most: usize,
) -> Result<Searched, (Broken<P>, Vec<S>)> {
    let mut left = most as u64 * CYCLES;
    let mut seen: HashSet<Vec<u64>> = HashSet::new();
    let mut next = VecDeque::from([vec![]]);
    // What breaks only behind a sequence, unless a shorter one is found before.
    let mut behind: Option<(Broken<P>, Vec<S>)> = None;
    while seen.len() < most
        && left > 0
        && let Some(steps) = next.pop_front()
    {
        if let Some(found) = behind.take_if(|(broken, _)| broken.cycle < steps.len() as u64) {
            return Err(found);
        }
        // A block cannot be copied: the way to the state is gone again.
        let mut run = match make() {
            Ok(run) => run,
            Err(broken) => return Err((broken, steps)),
        };
        let played = steps.iter().try_for_each(|step| run.step(Some(step)));
        let looked = played.and_then(|()| if run.is_over() { Ok(()) } else { run.step(None) });
        if let Err(broken) = looked {
            return Err((broken, steps));
        }
        left = left.saturating_sub(run.cycle());
        if run.is_over() || !seen.insert(run.known()) {
            continue;
        }
        next.extend(run.choices().into_iter().map(|step| {
            let mut longer = steps.clone();
            longer.push(step);
            longer
        }));
        if let Err(broken) = play(&mut *run, &mut [].iter())
            && behind.as_ref().is_none_or(|(before, _)| broken.cycle < before.cycle)
        {
            behind = Some((broken, steps));
        }
    }
    behind.map_or(Ok(Searched { states: seen.len(), every: next.is_empty() }), Err)
}
