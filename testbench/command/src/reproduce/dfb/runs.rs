//! Machines play frames; what came of it is kept in files, so that work that was stopped goes on from there.

use super::contender::Contender;
use super::frames::{Frames, Need, need};
use super::plan::Figure;
use crate::{finished, passes};
use indicatif::MultiProgress;
use pellucid_hw::architecture;
use pellucid_machine::architecture::settings;
use pellucid_testbench::output::{create_dir, put};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::trial::Case;
use rayon::prelude::*;
use serde_json::{Map, Value as Json, json};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::UNIX_EPOCH;
use std::{env, fs};

/// What a machine took for frames, or for one of them.
#[derive(Clone, Debug)]
pub struct Cycles {
    /// All of them.
    pub total: u64,
    by_phase: Map<String, Json>,
}

/// Phases that some machine has.
pub const PHASES: [&str; 5] = ["count", "scan", "store", "rebuild", "resolve"];

impl Cycles {
    /// What a report says, if its phases add up.
    fn read(json: &Json) -> Option<Cycles> {
        let by_phase = json.as_object()?.clone();
        let cycles = Cycles { total: json["total"].as_u64()?, by_phase };
        let sum: u64 = PHASES.iter().map(|phase| cycles.of(phase)).sum();
        (sum == cycles.total).then_some(cycles)
    }

    /// Those of a phase; none where the machine has no such phase.
    pub fn of(&self, phase: &str) -> u64 {
        self.by_phase.get(phase).and_then(Json::as_u64).unwrap_or(0)
    }
}

/// One frame in one machine.
#[derive(Clone, Debug)]
pub struct Played {
    /// What it took.
    pub cycles: Cycles,
    /// How often it came.
    pub plays: u64,
    /// Fragments that had to be stored.
    pub stored: u64,
    /// `[i]`: pixels with exactly `i` layers.
    pub layers: Vec<u64>,
}

/// Frames in one machine.
#[derive(Clone, Debug)]
pub struct Run {
    /// The command that does the same.
    pub command: String,
    /// What they took together.
    pub cycles: Cycles,
    /// Accesses to memory as the paper counts them, and all of them, in words.
    pub accesses: [u64; 2],
    /// Storage in use at the peak as the paper counts it, in bytes.
    pub bytes: u64,
    /// Each by itself.
    pub frames: Vec<Played>,
}

/// What came of frames in one machine.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// They were played.
    Run(Run),
    /// They cannot be, for lack of this.
    Lacks(&'static str),
}

/// What came of frames.
pub struct Entry {
    /// What they are for.
    pub figure: Figure,
    /// The frames.
    pub frames: Frames,
    /// What they need.
    pub need: Need,
    /// What came of them in each of their machines.
    pub outcomes: Vec<Outcome>,
}

impl Entry {
    /// What came of them in a machine that can hold them.
    pub fn run(&self, contender: Contender) -> Option<&Run> {
        let k = self.frames.contenders.iter().position(|other| *other == contender)?;
        match &self.outcomes[k] {
            Outcome::Run(run) => Some(run),
            Outcome::Lacks(_) => None,
        }
    }

    /// All cycles in a machine that can hold them.
    pub fn total(&self, contender: Contender) -> Option<u64> {
        self.run(contender).map(|run| run.cycles.total)
    }
}

impl Run {
    /// What a report without faults says, with the command beside it.
    pub fn read(json: &Json) -> Option<Run> {
        if !json["faults"].as_array()?.is_empty() {
            return None;
        }
        let frame = |json: &Json| {
            let layers = json["layer_histogram"].as_array()?.iter().map(Json::as_u64);
            Some(Played {
                cycles: Cycles::read(&json["cycles"])?,
                plays: json["plays"].as_u64()?,
                stored: json["stored"].as_u64()?,
                layers: layers.collect::<Option<_>>()?,
            })
        };
        let frames = json["frames"].as_array()?.iter().map(frame);
        Some(Run {
            command: json["command"].as_str()?.to_string(),
            cycles: Cycles::read(&json["cycles"])?,
            accesses: [json["accesses"]["seed"].as_u64()?, json["accesses"]["full"].as_u64()?],
            bytes: json["storage"]["seed_bytes_used"].as_u64()?,
            frames: frames.collect::<Option<_>>()?,
        })
    }

    /// How often frames came in all.
    pub fn plays(&self) -> u64 {
        self.frames.iter().map(|frame| frame.plays).sum()
    }
}

/// Where runs are kept, and how far they are.
pub struct Runs<'a> {
    folder: PathBuf,
    bars: MultiProgress,
    all: Mutex<Progress>,
    kept: AtomicU64,
    quiet: bool,
    plan: &'a [(Figure, Frames)],
}

impl Runs<'_> {
    /// Runs of this plan that are kept below `folder`.
    pub fn new<'a>(folder: &Path, plan: &'a [(Figure, Frames)], quiet: bool) -> Runs<'a> {
        let bars = MultiProgress::new();
        let number = plan.iter().map(|(_, frames)| frames.contenders.len() as u64).sum();
        let all = Progress::among(&bars, String::new(), "runs", Some(number), quiet);
        let (all, kept) = (Mutex::new(all), AtomicU64::new(0));
        Runs { folder: folder.join("runs"), bars, all, kept, quiet, plan }
    }

    /// Plays everything that no file has yet; nothing if a model is at fault, or an image wrong.
    ///
    /// # Errors
    /// Frames cannot be read, or a file not be written.
    pub fn play(&self) -> anyhow::Result<Option<Vec<Entry>>> {
        let each = self.plan.par_iter().map(|(figure, frames)| self.entry(*figure, frames));
        each.collect()
    }

    /// How many runs were there already.
    pub fn kept(&self) -> u64 {
        self.kept.load(Ordering::Relaxed)
    }

    /// Where they are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn progress(&self, subject: String, what: &'static str, total: Option<u64>) -> Progress {
        Progress::among(&self.bars, subject, what, total, self.quiet)
    }

    fn done(&self, runs: u64) {
        // A thread that panicked while it held the bar has ended the work anyway.
        if let Ok(mut all) = self.all.lock() {
            all.steps(runs);
        }
    }

    fn entry(&self, figure: Figure, frames: &Frames) -> anyhow::Result<Option<Entry>> {
        let folder = self.folder.join(slug(&frames.arguments()));
        let path = folder.join("frames.json");
        let made_of = made_of(&frames.scene);
        let known = read(&path, "scene", &frames.arguments(), &made_of);
        let known = known.and_then(|json| Need::read(&json["need"]));
        let stored = |contender: &Contender, need: &Need| -> Option<Outcome> {
            if let Some(why) = contender.lacks(need) {
                return Some(Outcome::Lacks(why));
            }
            let path = file(&folder, contender);
            let json = read(&path, "command", &command(contender, frames, need), &made_of)?;
            let run = Run::read(&json)?;
            self.kept.fetch_add(1, Ordering::Relaxed);
            Some(Outcome::Run(run))
        };
        let mut outcomes: Vec<Option<Outcome>> = vec![None; frames.contenders.len()];
        if let Some(need) = &known {
            outcomes = frames.contenders.iter().map(|c| stored(c, need)).collect();
            if outcomes.iter().all(Option::is_some) {
                self.done(outcomes.len() as u64);
                let outcomes = outcomes.into_iter().flatten().collect();
                return Ok(Some(Entry { figure, frames: frames.clone(), need: *need, outcomes }));
            }
        }
        let case = frames.case(&mut self.progress(frames.arguments(), "golden model", None))?;
        let need = need(&case, frames.pixels());
        if known != Some(need) {
            create_dir(&folder)?;
            let json =
                json!({ "scene": frames.arguments(), "made_of": made_of, "need": need.json() });
            put(&path, &format!("{json:#}\n"))?;
        }
        let each = frames.contenders.par_iter().zip(outcomes).map(|(contender, outcome)| {
            let outcome = match (outcome, contender.lacks(&need)) {
                (Some(outcome), _) => Some(outcome),
                (None, Some(why)) => Some(Outcome::Lacks(why)),
                (None, None) => {
                    let run = self.run(contender, frames, &need, &case)?;
                    let Some(mut json) = run else { return Ok(None) };
                    json["made_of"] = made_of.clone();
                    put(&file(&folder, contender), &format!("{json:#}\n"))?;
                    Some(Outcome::Run(
                        Run::read(&json).expect("a report has all that is read of it"),
                    ))
                }
            };
            self.done(1);
            Ok(outcome)
        });
        let outcomes: Option<Vec<Outcome>> = each.collect::<anyhow::Result<_>>()?;
        Ok(outcomes.map(|outcomes| Entry { figure, frames: frames.clone(), need, outcomes }))
    }

    /// One run; nothing if it is not right.
    fn run(
        &self,
        contender: &Contender,
        frames: &Frames,
        need: &Need,
        case: &Case,
    ) -> anyhow::Result<Option<Json>> {
        let arch = architecture(contender.arch)?;
        let with: Vec<(&str, String)> =
            contender.settings(need).iter().map(|(n, v)| (*n, v.to_string())).collect();
        let screen = case.source.screen();
        let machine = arch.build(screen, Some(contender.preset), &settings(&with))?;
        let name = format!("{} on {}", contender.name, frames.arguments());
        let items = case.items * u64::from(frames.count());
        let mut progress = self.progress(name.clone(), "simulating", Some(items));
        let about = format!("{name}: ");
        let done = case.run(arch.name, &*machine, None, &mut progress);
        let Some(trial) = finished(done, &about)? else { return Ok(None) };
        if !passes(&trial.verdict, false, &about) {
            return Ok(None);
        }
        let mut json = trial.report.json();
        json["command"] = json!(command(contender, frames, need));
        Ok(Some(json))
    }
}

/// What a run is made of beside its command: this program, and the scene's file if it has one, each by its size and by when it was
/// written.
fn made_of(scene: &str) -> Json {
    let file = |path: &Path| {
        let data = fs::metadata(path).ok()?;
        let written = data.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(format!("{} bytes of {}.{:09}", data.len(), written.as_secs(), written.subsec_nanos()))
    };
    let program = env::current_exe().ok().and_then(|path| file(&path));
    json!({ "version": env!("CARGO_PKG_VERSION"), "program": program, "scene": file(Path::new(scene)) })
}

/// A file that is made of this and says of itself what it must.
fn read(path: &Path, what: &str, expected: &str, made_of: &Json) -> Option<Json> {
    let json: Json = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
    (json[what] == expected && json["made_of"] == *made_of).then_some(json)
}

fn file(folder: &Path, contender: &Contender) -> PathBuf {
    folder.join(format!("{}.json", slug(contender.name)))
}

/// The command that does the same by itself.
fn command(contender: &Contender, frames: &Frames, need: &Need) -> String {
    let Contender { arch, preset, .. } = contender;
    let settings = contender.settings(need).into_iter();
    let settings: String = settings.map(|(name, value)| format!(" -p {name}={value}")).collect();
    format!("pellucid run --arch {arch} --preset {preset}{settings} {}", frames.arguments())
}

/// A text as the name of a file.
fn slug(text: &str) -> String {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::super::plan::{FULL, QUICK, plan};
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_run_has_a_file_of_its_own() {
        for sizes in [QUICK, FULL] {
            let plan = plan(&sizes, Some("../a mesh.ply"));
            let mut files = HashSet::new();
            for (_, frames) in &plan {
                let folder = PathBuf::from(slug(&frames.arguments()));
                for contender in &frames.contenders {
                    assert!(files.insert(file(&folder, contender)), "{}", frames.arguments());
                }
            }
        }
    }
}
