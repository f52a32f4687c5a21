//! Machines play frames; what came of it is kept in files, so that work that was stopped goes on from there.

use super::frames::Frames;
use crate::machine::run_command;
use crate::{finished, passes, tell};
use indicatif::MultiProgress;
use pellucid_hw::architecture;
use pellucid_machine::architecture::settings;
use pellucid_testbench::output::{create_dir, put};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::trial::Case;
use rayon::prelude::*;
use serde_json::{Value as Json, json};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::UNIX_EPOCH;
use std::{env, fs};

/// A machine as it is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Its name in messages and files, one of its own among those that play the same frames.
    pub name: String,
    /// The architecture.
    pub arch: &'static str,
    /// The preset; nothing for the default one.
    pub preset: Option<&'static str>,
    /// Parameters beside it.
    pub settings: Vec<(&'static str, String)>,
}

impl Machine {
    /// The command that does the same by itself.
    fn command(&self, frames: &Frames) -> String {
        let Machine { arch, preset, settings, .. } = self;
        let settings = settings.iter().map(|(name, value)| (*name, &**value));
        run_command(arch, *preset, settings, &frames.arguments())
    }
}

/// Where runs are kept, and how far they are.
pub struct Kept {
    folder: PathBuf,
    bars: MultiProgress,
    all: Mutex<Progress>,
    there: AtomicU64,
    quiet: bool,
}

impl Kept {
    /// So many runs, kept below `out`.
    pub fn new(out: &Path, runs: u64, quiet: bool) -> Kept {
        let bars = MultiProgress::new();
        let all = Progress::among(&bars, String::new(), "runs", Some(runs), quiet);
        let (all, there) = (Mutex::new(all), AtomicU64::new(0));
        Kept { folder: out.join("runs"), bars, all, there, quiet }
    }

    /// Says how many runs were there already, if some were.
    pub fn note(&self) {
        let there = self.there.load(Ordering::Relaxed);
        if there > 0 && !self.quiet {
            let folder = self.folder.display();
            tell(&format!(
                "note: {there} runs are those of an earlier time; without `{folder}` they are made again"
            ));
        }
    }

    /// Where the runs of these frames are.
    pub fn of(&self, frames: &Frames) -> PathBuf {
        self.folder.join(slug(&frames.arguments()))
    }

    /// How far one work is.
    pub fn progress(&self, subject: String, what: &'static str, total: Option<u64>) -> Progress {
        Progress::among(&self.bars, subject, what, total, self.quiet)
    }

    /// So many runs are done, or were there.
    pub fn done(&self, runs: u64) {
        // A thread that panicked while it held the bar has ended the work anyway.
        if let Ok(mut all) = self.all.lock() {
            all.steps(runs);
        }
    }

    /// A run that is there, as `parse` reads its report with its command; nothing if that cannot.
    pub fn get<T>(
        &self,
        machine: &Machine,
        frames: &Frames,
        parse: impl FnOnce(&Json) -> Option<T>,
    ) -> Option<T> {
        let path = self.of(frames).join(file(machine));
        let json = read(&path, "command", &machine.command(frames), &made_of(&frames.scene))?;
        let run = parse(&json)?;
        self.there.fetch_add(1, Ordering::Relaxed);
        Some(run)
    }

    /// What `read` takes of the report of each of some machines, at least one, that see and blend a frame alike; those that no
    /// file has are played. Nothing if one is not right.
    ///
    /// # Errors
    /// The frames cannot be read, or a file not be written.
    pub fn play_all<R: Send>(
        &self,
        machines: &[Machine],
        frames: &Frames,
        read: fn(&Json) -> Option<R>,
    ) -> anyhow::Result<Option<Vec<R>>> {
        let there: Vec<Option<R>> =
            machines.iter().map(|machine| self.get(machine, frames, read)).collect();
        let mut case = None;
        if there.iter().any(Option::is_none) {
            let source = frames.open()?;
            let Machine { arch, preset, settings: with, .. } = &machines[0];
            let built = architecture(arch)?.build(source.screen(), *preset, &settings(with))?;
            let mut progress = self.progress(frames.arguments(), "golden model", None);
            case = Some(Case::new(&frames.scene, source, &*built, &mut progress)?);
        }
        let each = machines.par_iter().zip(there).map(|(machine, there)| {
            let run = match (there, &case) {
                (None, Some(case)) => self
                    .play(machine, frames, case)?
                    .map(|json| read(&json).expect("a report has all that is read of it")),
                (there, _) => there,
            };
            self.done(1);
            Ok(run)
        });
        each.collect()
    }

    /// Plays frames in a machine and keeps the report, with its command; nothing if it is not right.
    ///
    /// # Errors
    /// The frames cannot be read, or the file not be written.
    pub fn play(
        &self,
        machine: &Machine,
        frames: &Frames,
        case: &Case,
    ) -> anyhow::Result<Option<Json>> {
        let arch = architecture(machine.arch)?;
        let with: Vec<(&str, String)> = machine.settings.clone();
        let built = arch.build(case.source.screen(), machine.preset, &settings(&with))?;
        let name = format!("{} on {}", machine.name, frames.arguments());
        let items = case.items * u64::from(frames.count());
        let mut progress = self.progress(name.clone(), "simulating", Some(items));
        let about = format!("{name}: ");
        let done = case.run(arch.name, &*built, None, &mut progress);
        let Some(trial) = finished(done, &about)? else { return Ok(None) };
        if !passes(&trial.verdict, false, &about) {
            return Ok(None);
        }
        let mut json = trial.report.json();
        json["command"] = json!(machine.command(frames));
        json["made_of"] = made_of(&frames.scene);
        create_dir(&self.of(frames))?;
        put(&self.of(frames).join(file(machine)), &format!("{json:#}\n"))?;
        Ok(Some(json))
    }
}

/// What a run is made of beside its command: this program, and the scene's file if it has one, each by its size and by when it was
/// written.
pub fn made_of(scene: &str) -> Json {
    let file = |path: &Path| {
        let data = fs::metadata(path).ok()?;
        let written = data.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(format!("{} bytes of {}.{:09}", data.len(), written.as_secs(), written.subsec_nanos()))
    };
    let program = env::current_exe().ok().and_then(|path| file(&path));
    json!({ "version": env!("CARGO_PKG_VERSION"), "program": program, "scene": file(Path::new(scene)) })
}

/// A file that is made of this and says of itself what it must.
pub fn read(path: &Path, what: &str, expected: &str, made_of: &Json) -> Option<Json> {
    let json: Json = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
    (json[what] == expected && json["made_of"] == *made_of).then_some(json)
}

/// The file of a machine among those of its frames.
pub fn file(machine: &Machine) -> String {
    format!("{}.json", slug(&machine.name))
}

/// A text as the name of a file.
pub fn slug(text: &str) -> String {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}
