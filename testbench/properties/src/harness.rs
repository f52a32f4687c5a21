//! Runs a block beside its [`Reference`]: sequences by hand or at random, and every state of a small one.

use crate::reference::{Judged, Reference};
use crate::report::report;
use pellucid_sim::{Block, Memory, Registers, Sim};
use proptest::test_runner::{Config as Effort, TestCaseError, TestError, TestRunner};
use proptest_state_machine::Sequential;
use std::collections::{HashSet, VecDeque};
use std::fmt::{self, Display};
use std::path::Path;
use std::sync::atomic::Ordering;

/// A broken property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken<P> {
    /// Which.
    pub property: P,
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
    pub(crate) outputs: R::Outputs,
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
    pub(crate) fn new(setup: &R::Setup) -> Run<R> {
        let sim = Sim::new(R::config(setup));
        Run { sim, reference: R::new(setup), cycle: 0, looked: false, over: false }
    }

    fn broken(&self, judged: Judged<R::Property>) -> Result<(), Broken<R::Property>> {
        let broken = |(property, seen)| Broken { property, cycle: self.cycle, seen };
        judged.map_err(broken)
    }

    fn look(&mut self) -> Result<(), Broken<R::Property>> {
        if self.looked {
            return Ok(());
        }
        self.looked = true;
        let looked = self.reference.look(self.cycle, &self.sim.moore());
        self.broken(looked)
    }

    /// One cycle; without a step it is only looked at. `show` is told of it.
    fn step(
        &mut self,
        step: Option<&R::Step>,
        show: &mut dyn FnMut(&R, Seen<R>),
    ) -> Result<(), Broken<R::Property>> {
        let looked = self.look();
        let (q, seen) = (self.sim.state().clone(), self.sim.moore());
        let step = step.filter(|_| looked.is_ok());
        let inputs = step.map(|step| self.reference.inputs(step, &seen));
        let (mut out, mut judged) = (None, Ok(()));
        match inputs {
            None => {}
            Some(None) => self.sim.reset(),
            Some(Some(inputs)) => match self.sim.clock(inputs) {
                Ok(clocked) => {
                    judged = self.reference.judge(&clocked.out);
                    out = Some(clocked.out);
                }
                Err(fault) => {
                    judged = self.reference.fault(&fault);
                    out = self.sim.at_fault().map(|cycle| cycle.out);
                    self.over = true;
                }
            },
        }
        if step.is_some() || looked.is_err() {
            let seen = Seen {
                cycle: self.cycle,
                q,
                inputs: inputs.flatten(),
                outputs: R::outputs(&seen, out.as_ref()),
                reset: inputs.is_some_and(|inputs| inputs.is_none()),
            };
            show(&self.reference, seen);
        }
        looked?;
        self.broken(judged)?;
        if step.is_some() {
            self.cycle += 1;
            self.looked = false;
        }
        Ok(())
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
    Run::<R>::new(setup).play(steps, &mut |_, _| {})
}

/// What a search has found: a broken property and the shortest sequence that breaks it.
pub type Found<R> = (Broken<<R as Reference>::Property>, Vec<<R as Reference>::Step>);

/// Looks at every state that a block can come to, by every step in each: a plain search, from reset on, of
/// `most` states at most. Gives how many states it has seen.
///
/// # Errors
/// The first property that is broken.
pub fn exhaust<R: Reference>(setup: &R::Setup, most: usize) -> Result<usize, Found<R>> {
    let mut seen: HashSet<Vec<u64>> = HashSet::new();
    let mut next = VecDeque::from([vec![]]);
    // What breaks only behind a sequence, unless a shorter one is found before.
    let mut behind: Option<Found<R>> = None;
    while let Some(steps) = next.pop_front().filter(|_| seen.len() < most) {
        if let Some(found) = behind.take_if(|(broken, _)| broken.cycle < steps.len() as u64) {
            return Err(found);
        }
        // A block cannot be copied: the way to the state is gone again.
        let mut run = Run::<R>::new(setup);
        let mut way = steps.iter();
        let played = way.try_for_each(|step| run.step(Some(step), &mut |_, _| {}));
        if let Err(broken) = played.and_then(|()| if run.over { Ok(()) } else { run.look() }) {
            return Err((broken, steps));
        }
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
    behind.map_or(Ok(seen.len()), Err)
}

/// The longest random sequence.
const STEPS: usize = 300;
/// States that are searched for a shorter sequence than the one that was found.
const SEARCHED: usize = 20_000;
/// The most states of a setup that a test looks at.
pub const MOST_STATES: usize = 500_000;

/// The shortest sequence that breaks a property: by a search, if a small setup breaks one, else the one that
/// was found, without the steps that it does not need.
fn shortest<R: Reference>(setup: R::Setup, steps: Vec<R::Step>) -> (R::Setup, Vec<R::Step>) {
    let searched = R::small().into_iter().find_map(|setup| {
        let (_, steps) = exhaust::<R>(&setup, SEARCHED).err()?;
        Some((setup, steps))
    });
    searched.unwrap_or_else(|| {
        let mut needed = steps;
        for k in (0..needed.len()).rev() {
            let step = needed.remove(k);
            if check::<R>(&setup, &needed).is_ok() {
                needed.insert(k, step);
            }
        }
        (setup, needed)
    })
}

/// Tries random sequences. `source` is the test's file, beside which regressions are kept; the waveform of a
/// failure goes into the folder `folder`.
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn test<R: Reference>(source: &'static str, folder: &Path) {
    let effort = Effort { source_file: Some(source), ..Effort::default() };
    let sequences = Sequential::new(
        (1..STEPS).into(),
        R::setups,
        |_, _| true,
        |setup| R::steps(setup),
        |setup, _| setup,
    );
    let tried = TestRunner::new(effort).run(&sequences, |(setup, steps, seen)| {
        let counted = steps.iter().inspect(|_| {
            if let Some(seen) = &seen {
                seen.fetch_add(1, Ordering::SeqCst);
            }
        });
        let played = Run::<R>::new(&setup).play(counted, &mut |_, _| {});
        played.map_err(|broken| TestCaseError::fail(broken.to_string()))
    });
    match tried {
        Ok(()) => {}
        Err(TestError::Fail(_, (setup, steps, _))) => {
            let (setup, steps) = shortest::<R>(setup, steps);
            panic!("{}", report::<R>(&setup, &steps, folder))
        }
        Err(error) => panic!("{error}"),
    }
}

/// Looks at every state of the small setups; the waveform of a failure goes into the folder `folder`.
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn search<R: Reference>(folder: &Path) {
    for setup in R::small() {
        match exhaust::<R>(&setup, MOST_STATES) {
            Err((_, steps)) => panic!("{}", report::<R>(&setup, &steps, folder)),
            Ok(MOST_STATES) => {
                let told = R::told(&setup);
                println!("{told}: only {MOST_STATES} states were looked at");
            }
            Ok(_) => {}
        }
    }
}

/// The tests of a [`Reference`]: `properties!(allocator::Model<MyAllocator>, mine)`, where the second is the
/// name of the module that they stand in.
#[macro_export]
macro_rules! properties {
    ($reference:ty, $name:ident) => {
        mod $name {
            #[allow(unused_imports)]
            use super::*;

            /// Where the waveform of a failure goes.
            fn folder() -> ::std::path::PathBuf {
                let folder = match option_env!("CARGO_TARGET_TMPDIR") {
                    Some(folder) => ::std::path::PathBuf::from(folder),
                    None => ::std::env::temp_dir(),
                };
                folder.join("failures").join(module_path!().replace("::", "-"))
            }

            /// Any sequence of steps.
            #[test]
            fn any_sequence_keeps_the_contract() {
                $crate::harness::test::<$reference>(file!(), &folder());
            }

            /// Every state of a small one.
            #[test]
            fn every_state_keeps_the_contract() {
                $crate::harness::search::<$reference>(&folder().join("states"));
            }
        }
    };
}
