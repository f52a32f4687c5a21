//! The work of a study: every point that is not kept yet is run, frames are rendered once for all machines.

use super::designs::Design;
use super::points::{Key, Outcome, Points, Status, figures};
use super::study::{Scene, Study};
use crate::machine::{Choice, run_command};
use crate::sequence::Opened;
use indicatif::MultiProgress;
use pellucid_machine::Model;
use pellucid_machine::params::Value;
use pellucid_testbench::bench::BenchError;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::known_beforehand;
use pellucid_testbench::trial::{Case, CaseError, Cases, Trial};
use rayon::prelude::*;
use serde_json::Value as Json;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// A design with what came of it on every scene.
pub struct Candidate {
    /// The design.
    pub design: Design,
    /// Its parameters' final values, if it can be built.
    pub values: Vec<(String, Value)>,
    /// For each scene the command that does the same.
    pub commands: Vec<String>,
    /// For each scene the file that has it, if there is a machine.
    pub files: Vec<Option<PathBuf>>,
    /// For each scene what came of it; nothing as long as it has not been run.
    pub outcomes: Vec<Option<Outcome>>,
}

/// How often it is looked what others have done.
const LOOK: Duration = Duration::from_millis(200);

/// One run that is to be done.
struct Task {
    candidate: usize,
    scene: usize,
    key: Key,
    arch: &'static str,
    machine: Box<dyn Model>,
}

/// One of several shares of the points of a study, as equal as they can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    number: usize,
    of: usize,
}

impl Share {
    fn has(self, point: usize) -> bool {
        point % self.of == self.number - 1
    }
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Share, String> {
        let share = text.split_once('/').and_then(|(number, of)| {
            let (number, of) = (number.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&number).then_some(Share { number, of })
        });
        share.ok_or_else(|| "expected NUMBER/SHARES, from 1/N to N/N".to_string())
    }
}

/// See the module's description.
pub struct Work<'a> {
    study: &'a Study,
    points: &'a Points,
    tasks: Vec<Task>,
    frames: Vec<Cases>,
    /// All designs.
    pub candidates: Vec<Candidate>,
    /// How many points were kept.
    pub kept: usize,
    /// How many were run.
    pub run: usize,
}

impl Work<'_> {
    /// Nothing yet, on the scenes of a study.
    pub fn new<'a>(study: &'a Study, points: &'a Points, sources: Vec<Opened>) -> Work<'a> {
        let frames = study.scenes.iter().zip(sources);
        let frames =
            frames.map(|(scene, (source, frames))| Cases::new(&scene.name, source, frames));
        let frames = frames.collect();
        Work { study, points, tasks: vec![], frames, candidates: vec![], kept: 0, run: 0 }
    }

    /// Takes a design up: what is kept of it, and what is left to do.
    pub fn add(&mut self, design: Design) {
        let (scenes, number) = (&self.study.scenes, self.candidates.len());
        let mut candidate = Candidate {
            values: vec![],
            commands: scenes.iter().map(|scene| command(&design, self.study, scene)).collect(),
            files: vec![None; scenes.len()],
            outcomes: vec![],
            design,
        };
        for (k, scene) in scenes.iter().enumerate() {
            let outcome = match self.machine(&candidate.design, k) {
                Err(outcome) => Some(outcome),
                Ok(machine) => {
                    let choice = &candidate.design.choice;
                    let (arch, values) = (choice.arch.name, choice.values(&*machine));
                    let arguments = self.study.arguments(scene);
                    let key = self.points.key(arch, &values, &arguments, self.study.files(scene));
                    candidate.values = machine.values();
                    candidate.files[k] = Some(self.points.path(&key));
                    let kept = self.points.get(&key);
                    match kept {
                        Some(_) => self.kept += 1,
                        None => self.tasks.push(Task {
                            candidate: number,
                            scene: k,
                            key,
                            arch,
                            machine,
                        }),
                    }
                    kept
                }
            };
            candidate.outcomes.push(outcome);
        }
        self.candidates.push(candidate);
    }

    /// The machine, unless it cannot be, or need not be tried.
    fn machine(&self, design: &Design, scene: usize) -> Result<Box<dyn Model>, Outcome> {
        let (source, frames) = (self.frames[scene].source(), self.frames[scene].frames());
        let refused = |why| Err(Outcome::without(Status::Refused, why));
        if let Some(why) = &design.refused {
            return refused(why.clone());
        }
        let machine = match design.choice.build_for(source.screen(), frames) {
            Ok(machine) => machine,
            Err(error) => return refused(error.to_string()),
        };
        let beyond = self.study.constraints.iter().find_map(|constraint| {
            let value = known_beforehand(&*machine, &constraint.figure)? as f64;
            (!constraint.holds(value)).then(|| constraint.broken(value))
        });
        match beyond {
            Some(why) => Err(Outcome::without(Status::Excluded, why)),
            None => Ok(machine),
        }
    }

    /// Leaves to others what is not of this share. Which points are in a share does not depend on which are kept.
    pub fn keep_to(&mut self, share: Share) {
        let scenes = self.study.scenes.len();
        self.tasks.retain(|task| share.has(task.candidate * scenes + task.scene));
    }

    /// How many points there are.
    pub fn points(&self) -> usize {
        self.candidates.len() * self.study.scenes.len()
    }

    /// How many points are left to do.
    pub fn left(&self) -> usize {
        self.tasks.len()
    }

    /// Waits until those who do what is left have `ended`, and takes up what they have done; `seen` is called after each look.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn wait(
        &mut self,
        mut ended: impl FnMut() -> anyhow::Result<bool>,
        quiet: bool,
        seen: impl Fn(&[Candidate]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut progress = Progress::new("points", Some(self.left() as u64), quiet);
        loop {
            let (last, start) = (ended()?, Instant::now());
            let before = self.left();
            self.tasks.retain(|task| {
                let outcome = self.points.get(&task.key);
                let done = outcome.is_some();
                if done {
                    self.candidates[task.candidate].outcomes[task.scene] = outcome;
                }
                !done
            });
            let done = before - self.left();
            self.run += done;
            self.points.learn();
            progress.steps(done as u64);
            seen(&self.candidates)?;
            if last {
                return Ok(());
            }
            // What takes long is not done often.
            std::thread::sleep(LOOK.max(20 * start.elapsed()));
        }
    }

    /// Does what is left, the scenes with the fewest items first; `seen` is called after each point.
    ///
    /// # Errors
    /// A frame cannot be read or held, or a file not be written.
    pub fn run(
        &mut self,
        quiet: bool,
        seen: impl Fn(&[Candidate]) -> anyhow::Result<()> + Sync,
    ) -> anyhow::Result<()> {
        let bars = MultiProgress::new();
        let mut tasks: Vec<Vec<Task>> = self.frames.iter().map(|_| vec![]).collect();
        self.tasks.drain(..).for_each(|task| tasks[task.scene].push(task));
        let total: usize = tasks.iter().map(Vec::len).sum();
        let (scenes, candidates) = (&self.study.scenes, &self.candidates);
        let prepared = self.frames.par_iter_mut().zip(tasks).zip(scenes);
        let prepared = prepared.map(|((frames, tasks), scene)| {
            let mut progress =
                Progress::among(&bars, scene.name.clone(), "golden model", None, quiet);
            let each = tasks.into_iter().map(|task| {
                let mut case = frames.of(&*task.machine, &mut progress)?;
                case.technology = self.study.technology.clone();
                let choice = &candidates[task.candidate].design.choice;
                let machine = choice.with_room(task.machine, &case);
                Ok((Task { machine, ..task }, case))
            });
            each.collect::<Result<Vec<(Task, Case)>, CaseError>>()
        });
        let prepared: Vec<Vec<(Task, Case)>> = prepared.collect::<Result<_, _>>()?;
        let mut prepared: Vec<(Task, Case)> = prepared.into_iter().flatten().collect();
        prepared.sort_by_key(|(_, case)| case.items * u64::from(case.frames()));
        let all = Progress::among(&bars, String::new(), "points", Some(total as u64), quiet);
        let state = Mutex::new((all, std::mem::take(&mut self.candidates)));
        let points = self.points;
        // Taken one by one, so that they are done in their order.
        let done = prepared.into_iter().par_bridge().try_for_each(|(task, case)| {
            let (outcome, report) = outcome(&task, &case, points)?;
            // A thread that panicked while it held the state has ended the work anyway.
            let Ok(mut state) = state.lock() else { return Ok(()) };
            let (all, candidates) = &mut *state;
            let candidate = &mut candidates[task.candidate];
            points.put(&task.key, &candidate.commands[task.scene], &outcome, report)?;
            candidate.outcomes[task.scene] = Some(outcome);
            all.steps(1);
            seen(candidates)
        });
        if let Ok((_, candidates)) = state.into_inner() {
            self.candidates = candidates;
        }
        self.run += total;
        done
    }
}

/// The command that does the same as a point.
fn command(design: &Design, study: &Study, scene: &Scene) -> String {
    let Choice { arch, preset, settings, .. } = &design.choice;
    let settings = settings.iter().map(|setting| (&*setting.name, &*setting.value));
    run_command(arch.name, Some(preset), settings, &study.arguments(scene))
}

/// Runs a point: what came of it, and the report. Its image is kept.
///
/// # Errors
/// The frame cannot be read, or the image not be written.
fn outcome(task: &Task, case: &Case, points: &Points) -> Result<(Outcome, Json), BenchError> {
    let mut progress = Progress::new("", None, true);
    let Trial { verdict, report, images, .. } =
        match case.run(task.arch, &*task.machine, None, &mut progress) {
            Ok(trial) => trial,
            Err(error @ (BenchError::Source(_) | BenchError::Output(_))) => return Err(error),
            Err(error) => {
                let outcome = Outcome::without(Status::Failed, error.to_string());
                return Ok((outcome, Json::Null));
            }
        };
    let status = match () {
        () if verdict.is_right() => Status::Right,
        () if verdict.passes(true) => Status::Lossy,
        () => Status::Wrong,
    };
    let report = report.json();
    let reason = verdict.faults().into_iter().next().unwrap_or_default();
    let image = images.last().map(|image| points.keep(image)).transpose()?;
    Ok((Outcome { status, reason, figures: figures(&report), image }, report))
}
