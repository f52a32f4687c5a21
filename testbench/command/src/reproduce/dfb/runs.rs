//! What came of frames in the machines that play them.

use super::contender::Contender;
use super::need::{Need, case, need};
use super::plan::{Figure, Planned};
use crate::reproduce::frames::Frames;
use crate::reproduce::kept::{Kept, made_of, read};
use crate::reproduce::price::Price;
use pellucid_testbench::output::{create_dir, put};
use rayon::prelude::*;
use serde_json::{Map, Value as Json, json};

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
    /// What a frame costs, on the mean.
    pub price: Price,
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
    /// The machines that play them.
    pub contenders: Vec<Contender>,
    /// What came of them in each of these.
    pub outcomes: Vec<Outcome>,
}

impl Entry {
    /// What came of them in a machine that can hold them.
    pub fn run(&self, contender: Contender) -> Option<&Run> {
        let k = self.contenders.iter().position(|other| *other == contender)?;
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
            price: Price::read(json)?,
            frames: frames.collect::<Option<_>>()?,
        })
    }

    /// How often frames came in all.
    pub fn plays(&self) -> u64 {
        self.frames.iter().map(|frame| frame.plays).sum()
    }
}

/// Plays everything that no file has yet; nothing if a model is at fault, or an image wrong.
///
/// # Errors
/// Frames cannot be read, or a file not be written.
pub fn play(plan: &[Planned], kept: &Kept) -> anyhow::Result<Option<Vec<Entry>>> {
    plan.par_iter().map(|planned| entry(planned, kept)).collect()
}

fn entry(planned: &Planned, kept: &Kept) -> anyhow::Result<Option<Entry>> {
    let Planned { figure, frames, contenders } = planned;
    let entry = |need, outcomes| {
        let (frames, contenders) = (frames.clone(), contenders.clone());
        Entry { figure: *figure, frames, need, contenders, outcomes }
    };
    let folder = kept.of(frames);
    let path = folder.join("frames.json");
    let made_of = made_of(&frames.scene);
    let known = read(&path, "scene", &frames.arguments(), &made_of);
    let known = known.and_then(|json| Need::read(&json["need"]));
    let stored = |contender: &Contender, need: &Need| match contender.lacks(need) {
        Some(why) => Some(Outcome::Lacks(why)),
        None => kept.get(&contender.machine(need), frames, Run::read).map(Outcome::Run),
    };
    let mut outcomes: Vec<Option<Outcome>> = vec![None; contenders.len()];
    if let Some(need) = &known {
        outcomes = contenders.iter().map(|c| stored(c, need)).collect();
        if outcomes.iter().all(Option::is_some) {
            kept.done(outcomes.len() as u64);
            return Ok(Some(entry(*need, outcomes.into_iter().flatten().collect())));
        }
    }
    let case = case(frames, &mut kept.progress(frames.arguments(), "golden model", None))?;
    let need = need(&case, frames.pixels());
    if known != Some(need) {
        create_dir(&folder)?;
        let json = json!({ "scene": frames.arguments(), "made_of": made_of, "need": need.json() });
        put(&path, &format!("{json:#}\n"))?;
    }
    let each = contenders.par_iter().zip(outcomes).map(|(contender, outcome)| {
        let outcome = match (outcome, contender.lacks(&need)) {
            (Some(outcome), _) => Some(outcome),
            (None, Some(why)) => Some(Outcome::Lacks(why)),
            (None, None) => kept.play(&contender.machine(&need), frames, &case)?.map(|json| {
                Outcome::Run(Run::read(&json).expect("a report has all that is read of it"))
            }),
        };
        kept.done(1);
        Ok(outcome)
    });
    let outcomes: Option<Vec<Outcome>> = each.collect::<anyhow::Result<_>>()?;
    Ok(outcomes.map(|outcomes| entry(need, outcomes)))
}

#[cfg(test)]
mod tests {
    use super::super::plan::{FULL, QUICK, plan};
    use super::*;
    use crate::reproduce::kept::{file, slug};
    use std::collections::HashSet;

    #[test]
    fn every_run_has_a_file_of_its_own() {
        let need = Need { pixels: 1, fragments: 1, layers: 1, pages: [1, 1] };
        for sizes in [QUICK, FULL] {
            let mut files = HashSet::new();
            for Planned { frames, contenders, .. } in plan(&sizes, Some("../a mesh.ply")) {
                for contender in contenders {
                    let of = (slug(&frames.arguments()), file(&contender.machine(&need)));
                    assert!(files.insert(of), "{}", frames.arguments());
                }
            }
        }
    }
}
