//! The work of a study: every point that is not kept yet is run, frames are rendered once for all machines.

use super::designs::Design;
use super::points::{Key, Outcome, Points, Status, figures};
use super::study::{Scene, Study};
use indicatif::MultiProgress;
use pellucid_machine::Model;
use pellucid_machine::params::Value;
use pellucid_testbench::bench::BenchError;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::known_beforehand;
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::{Case, Trial};
use rayon::prelude::*;
use serde_json::Value as Json;
use std::sync::{Arc, Mutex};

/// A design with what came of it on every scene.
pub struct Candidate {
    /// The design.
    pub design: Design,
    /// Its parameters' final values, if it can be built.
    pub values: Vec<(String, Value)>,
    /// For each scene the command that does the same.
    pub commands: Vec<String>,
    /// For each scene what came of it; nothing as long as it has not been run.
    pub outcomes: Vec<Option<Outcome>>,
}

/// One run that is to be done.
struct Task {
    candidate: usize,
    scene: usize,
    key: Key,
    arch: &'static str,
    machine: Box<dyn Model>,
}

/// See the module's description.
pub struct Work<'a> {
    study: &'a Study,
    points: &'a Points,
    tasks: Vec<Task>,
    /// All designs.
    pub candidates: Vec<Candidate>,
    /// How many points were kept.
    pub kept: usize,
}

impl Work<'_> {
    /// What is kept of these designs, and what is left to do.
    pub fn new<'a>(
        study: &'a Study,
        points: &'a Points,
        designs: Vec<Design>,
        sources: &[Source],
    ) -> Work<'a> {
        let mut work = Work { study, points, tasks: vec![], candidates: vec![], kept: 0 };
        designs.into_iter().for_each(|design| work.add(design, sources));
        work
    }

    fn add(&mut self, design: Design, sources: &[Source]) {
        let (scenes, number) = (&self.study.scenes, self.candidates.len());
        let mut candidate = Candidate {
            values: vec![],
            commands: scenes.iter().map(|scene| command(&design, scene)).collect(),
            outcomes: vec![],
            design,
        };
        for (k, (scene, source)) in scenes.iter().zip(sources).enumerate() {
            let outcome = match self.machine(&candidate.design, source) {
                Err(outcome) => Some(outcome),
                Ok(machine) => {
                    let (arch, values) = (candidate.design.choice.arch.name, machine.values());
                    let key = self.points.key(arch, &values, &scene.arguments(), &scene.name);
                    candidate.values = values;
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
    fn machine(&self, design: &Design, source: &Source) -> Result<Box<dyn Model>, Outcome> {
        let refused = |why| Err(Outcome::without(Status::Refused, why));
        if let Some(why) = &design.refused {
            return refused(why.clone());
        }
        let machine = match design.choice.build(source.screen()) {
            Ok(machine) => machine,
            Err(error) => return refused(error.to_string()),
        };
        if self.study.constraints.is_empty() {
            return Ok(machine);
        }
        let known = known_beforehand(&*machine);
        let beyond = self.study.constraints.iter().find_map(|constraint| {
            let value = known.iter().find(|(name, _)| *name == constraint.figure)?.1;
            let value = value as f64;
            (!constraint.holds(value)).then(|| constraint.broken(value))
        });
        match beyond {
            Some(why) => Err(Outcome::without(Status::Excluded, why)),
            None => Ok(machine),
        }
    }

    /// How many points are left to do.
    pub fn left(&self) -> usize {
        self.tasks.len()
    }

    /// Does what is left, the scenes with the fewest items first; `seen` is called after each point.
    ///
    /// # Errors
    /// A frame cannot be read or held, or a file not be written.
    pub fn run(
        &mut self,
        sources: Vec<Source>,
        quiet: bool,
        seen: impl Fn(&[Candidate]) -> anyhow::Result<()> + Sync,
    ) -> anyhow::Result<()> {
        let bars = MultiProgress::new();
        let mut tasks: Vec<Vec<Task>> = sources.iter().map(|_| vec![]).collect();
        self.tasks.drain(..).for_each(|task| tasks[task.scene].push(task));
        let total: usize = tasks.iter().map(Vec::len).sum();
        let scenes = &self.study.scenes;
        let prepared =
            sources.into_par_iter().zip(tasks).zip(scenes).map(|((source, tasks), scene)| {
                let mut progress =
                    Progress::among(&bars, scene.name.clone(), "golden model", None, quiet);
                let cases = cases(scene, source, &tasks, &mut progress)?;
                Ok(tasks.into_iter().zip(cases).collect())
            });
        let prepared: Vec<Vec<(Task, Case)>> = prepared.collect::<anyhow::Result<_>>()?;
        let mut prepared: Vec<(Task, Case)> = prepared.into_iter().flatten().collect();
        prepared.sort_by_key(|(_, case)| case.items * u64::from(case.frames()));
        let all = Progress::among(&bars, String::new(), "points", Some(total as u64), quiet);
        let state = Mutex::new((all, std::mem::take(&mut self.candidates)));
        let points = self.points;
        // Taken one by one, so that they are done in their order.
        let done = prepared.into_iter().par_bridge().try_for_each(|(task, case)| {
            let (outcome, report) = outcome(&task, &case)?;
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
        done
    }
}

/// The command that does the same as a point.
fn command(design: &Design, scene: &Scene) -> String {
    let choice = &design.choice;
    let settings = choice
        .settings
        .iter()
        .map(|setting| crate::quoted(&format!("{}={}", setting.name, setting.value)));
    let settings: String = settings.map(|setting| format!(" -p {setting}")).collect();
    let (arch, preset) = (choice.arch.name, &choice.preset);
    format!("pellucid run --arch {arch} --preset {preset}{settings} {}", scene.arguments())
}

/// A case for each task; machines that see the frames alike share what the golden model says.
fn cases(
    scene: &Scene,
    source: Source,
    tasks: &[Task],
    progress: &mut Progress,
) -> anyhow::Result<Vec<Case>> {
    let machines: Vec<&dyn Model> = tasks.iter().map(|task| &*task.machine).collect();
    let mut cases = Case::all(&scene.name, source, &machines, progress)?;
    if scene.frames == 1 {
        return Ok(cases);
    }
    let first: Vec<usize> = (0..cases.len())
        .map(|k| {
            let alike = |case: &Case| Arc::ptr_eq(&case.reference, &cases[k].reference);
            cases.iter().position(alike).unwrap_or(k)
        })
        .collect();
    for k in 0..cases.len() {
        cases[k] = if first[k] == k {
            let alike = machines.iter().zip(&first).filter(|(_, first)| **first == k);
            let alike: Vec<&dyn Model> = alike.map(|(machine, _)| *machine).collect();
            cases[k].clone().with_frames(scene.frames, &alike, progress)?
        } else {
            cases[first[k]].clone()
        };
    }
    Ok(cases)
}

/// Runs a point: what came of it, and the report.
///
/// # Errors
/// The frame cannot be read.
fn outcome(task: &Task, case: &Case) -> Result<(Outcome, Json), BenchError> {
    let mut progress = Progress::new("", None, true);
    let Trial { verdict, report, .. } =
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
    Ok((Outcome { status, reason, figures: figures(&report) }, report))
}
