//! The tests that are made of a [`Reference`]: random sequences, long ones, and a search through every state.

use crate::harness::{Broken, Made, Searched, make, play, searched};
use crate::reference::{Long, Reference};
use crate::report::report;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config as Effort, Reason, RngSeed, TestError, TestRunner};
use std::fmt::{Debug, Display};
use std::path::Path;

/// The longest of the short random sequences.
const STEPS: usize = 300;
/// So many short random sequences have a long one beside them.
const SHORT: u32 = 256;
/// States that are searched for a shorter sequence than the one that was found.
const SEARCHED: usize = 20_000;
/// Cycles that are played to leave out what a sequence does not need.
const SHRINKING: usize = 5_000_000;
/// The most states of a setup that a test looks at, see [`exhaust`](crate::harness::exhaust).
pub const MOST_STATES: usize = 500_000;

/// What is fixed while a sequence is played, and its steps.
type Sequence<T, S> = (T, Vec<S>);

/// Strategies for setup and step, and how many steps: see [`Long`].
type LongOf<T, S> = (BoxedStrategy<T>, BoxedStrategy<S>, usize);

/// A [`Reference`] by what it can do. What tries sequences is compiled once for all blocks of a contract.
struct Contract<T, S, P> {
    setups: fn() -> BoxedStrategy<T>,
    steps: fn(&T) -> BoxedStrategy<S>,
    long: fn() -> Vec<LongOf<T, S>>,
    small: fn() -> Vec<T>,
    told: fn(&T) -> String,
    make: fn(&T) -> Made<S, P>,
    report: fn(&T, &[S], &Path) -> String,
}

/// That of a reference.
type ContractOf<R> =
    Contract<<R as Reference>::Setup, <R as Reference>::Step, <R as Reference>::Property>;

fn contract<R: Reference>() -> ContractOf<R> {
    Contract {
        setups: R::setups,
        steps: R::steps,
        long: || {
            let parts = |Long::<R> { setup, step, steps }| (setup, step, steps);
            R::long().into_iter().map(parts).collect()
        },
        small: R::small,
        told: R::told,
        make: make::<R>,
        report: report::<R>,
    }
}

/// How much proptest is told to try, and where regressions are kept.
fn effort(source: &'static str) -> Effort {
    Effort { source_file: Some(source), ..Effort::default() }
}

impl<T, S, P> Contract<T, S, P>
where
    T: Clone + Debug + 'static,
    S: Clone + Debug + 'static,
    P: Display + 'static,
{
    fn check(&self, setup: &T, steps: &[S]) -> Result<(), Broken<P>> {
        play(&mut *(self.make)(setup)?, &mut steps.iter())
    }

    /// The steps that a sequence needs to break a property, as far as can be told: a half of it is left out, if that
    /// still breaks one, then the other, then quarters, and so on down to single steps.
    fn needed(&self, setup: &T, mut steps: Vec<S>) -> Vec<S> {
        let mut played = 0;
        let mut part = steps.len();
        loop {
            part = part.div_ceil(2);
            let mut end = steps.len();
            while end > 0 && played < SHRINKING {
                let begin = end.saturating_sub(part);
                let shorter = [&steps[..begin], &steps[end..]].concat();
                played += shorter.len();
                if self.check(setup, &shorter).is_err() {
                    steps = shorter;
                }
                end = begin;
            }
            if part <= 1 {
                return steps;
            }
        }
    }

    /// The shortest sequence that breaks a property: by a search, if a small setup breaks one, else the one that
    /// was found, without the steps that it does not need.
    fn shortest(&self, setup: T, mut steps: Vec<S>, broken: &Broken<P>) -> Sequence<T, S> {
        let found = (self.small)().into_iter().find_map(|setup| {
            let (_, steps) = searched(&|| (self.make)(&setup), SEARCHED).err()?;
            Some((setup, steps))
        });
        found.unwrap_or_else(|| {
            steps.truncate(broken.cycle as usize + 1);
            let needed = self.needed(&setup, steps);
            (setup, needed)
        })
    }

    fn test(&self, source: &'static str, folder: &Path) {
        let steps = self.steps;
        // Both shrink: a setup beside the steps as they are, which are not drawn anew.
        let sequences =
            (self.setups)().prop_ind_flat_map2(move |setup| vec(steps(&setup), 1..STEPS));
        let tried = TestRunner::new(effort(source)).run(&sequences, |(setup, steps)| {
            let played = self.check(&setup, &steps);
            played.map_err(|broken| TestCaseError::fail(broken.to_string()))
        });
        self.fail(tried, Ok, folder);
    }

    fn test_long(&self, source: &'static str, folder: &Path) {
        for (setup, step, steps) in (self.long)() {
            let drawn = |seed| -> Result<Sequence<T, S>, Reason> {
                let drawing = Effort { rng_seed: RngSeed::Fixed(seed), ..Effort::default() };
                let mut runner = TestRunner::new(drawing);
                let setup = setup.new_tree(&mut runner)?.current();
                let next = |_| step.new_tree(&mut runner).map(|tree| tree.current());
                Ok((setup, (0..steps).map(next).collect::<Result<_, _>>()?))
            };
            let effort = effort(source);
            let effort = Effort { cases: effort.cases.div_ceil(SHORT), ..effort };
            let tried = TestRunner::new(effort).run(&any::<u64>().no_shrink(), |seed| {
                let (setup, steps) = drawn(seed).map_err(TestCaseError::Reject)?;
                let played = self.check(&setup, &steps);
                played.map_err(|broken| TestCaseError::fail(broken.to_string()))
            });
            self.fail(tried, |seed| drawn(seed).map_err(TestError::Abort), folder);
        }
    }

    /// Reports a failure, which is one of a `sequence`.
    fn fail<F: Debug>(
        &self,
        tried: Result<(), TestError<F>>,
        sequence: impl FnOnce(F) -> Result<Sequence<T, S>, TestError<F>>,
        folder: &Path,
    ) {
        let tried = tried.map_err(|error| match error {
            TestError::Fail(reason, failed) => sequence(failed).map(|sequence| (reason, sequence)),
            error => Err(error),
        });
        match tried {
            Ok(()) => {}
            Err(Ok((reason, (setup, steps)))) => {
                let Err(broken) = self.check(&setup, &steps) else {
                    panic!(
                        "a second time it is not broken, so the block remembers something: {reason}"
                    )
                };
                let (setup, steps) = self.shortest(setup, steps, &broken);
                panic!("{}", (self.report)(&setup, &steps, folder))
            }
            Err(Err(error)) => panic!("{error}"),
        }
    }

    fn search_first(&self, folder: &Path, most: usize) -> Vec<String> {
        let mut more = vec![];
        for setup in (self.small)() {
            match searched(&|| (self.make)(&setup), most) {
                Err((_, steps)) => panic!("{}", (self.report)(&setup, &steps, folder)),
                Ok(searched) if searched.every => {}
                Ok(Searched { states, .. }) => {
                    more.push(format!("the first {states} of {}", (self.told)(&setup)));
                }
            }
        }
        more
    }
}

/// Tries random sequences. `source` is the test's file, beside which regressions are kept; the waveform of a
/// failure goes into the folder `folder`.
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn test<R: Reference>(source: &'static str, folder: &Path) {
    contract::<R>().test(source, folder);
}

/// Plays the long random sequences of a [`Reference`], each once for 256 short ones; for the rest see [`test()`]. A
/// sequence is drawn from a number, which is what a regression keeps, and is shrunk only once it has failed.
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn test_long<R: Reference>(source: &'static str, folder: &Path) {
    contract::<R>().test_long(source, folder);
}

/// Looks at every state of the small setups, of each at `most` as [`exhaust`](crate::harness::exhaust) does; the
/// waveform of a failure goes into the folder `folder`. Gives those setups that have more, in words.
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn search_first<R: Reference>(folder: &Path, most: usize) -> Vec<String> {
    contract::<R>().search_first(folder, most)
}

/// Looks at every state of the small setups as [`search_first`] does.
///
/// # Panics
/// A property is broken, or a setup has more states than are looked at.
pub fn search<R: Reference>(folder: &Path, most: usize) {
    let more = search_first::<R>(folder, most);
    assert!(
        more.is_empty(),
        "not every state was looked at, and no property is broken in {}.\nIf that is enough, say so: the word \
         `first_states` behind the name in the macro gives the test another name",
        more.join(", ")
    );
}

/// The tests of a [`Reference`]: `properties!(allocator::Model<MyAllocator>, mine)`, where the second is the
/// name of the module that they stand in. A third, `first_states`, says that it is enough to look at the first
/// states of a block that has too many; the test is then called so, and else fails.
#[macro_export]
macro_rules! properties {
    ($reference:ty, $name:ident $(, $states:ident)?) => {
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
                $crate::trials::test::<$reference>(file!(), &folder());
            }

            /// Sequences of very many steps.
            #[test]
            fn a_long_sequence_keeps_the_contract() {
                $crate::trials::test_long::<$reference>(file!(), &folder().join("long"));
            }

            $crate::__search!($reference $(, $states)?);
        }
    };
}

/// The search among the tests of [`properties!`].
#[doc(hidden)]
#[macro_export]
macro_rules! __search {
    ($reference:ty) => {
        /// Every state of a small one.
        #[test]
        fn every_state_keeps_the_contract() {
            $crate::trials::search::<$reference>(
                &folder().join("states"),
                $crate::trials::MOST_STATES,
            );
        }
    };
    ($reference:ty, first_states) => {
        /// The first states of a small one that has many.
        #[test]
        fn the_first_states_keep_the_contract() {
            $crate::trials::search_first::<$reference>(
                &folder().join("states"),
                $crate::trials::MOST_STATES,
            );
        }
    };
}
