//! What came of frames in machines that make one image of them.

use super::plan::{Figure, Method, Planned};
use crate::reproduce::frames::Frames;
use crate::reproduce::kept::Kept;
use crate::reproduce::price::Price;
use serde_json::Value as Json;

/// An image by one method.
#[derive(Clone, Debug)]
pub struct Run {
    /// The command that does the same.
    pub command: String,
    /// Cycles.
    pub cycles: u64,
    /// Passes: one for each frame, and one for each node.
    pub passes: u64,
    /// Sweeps of the screen that these took.
    pub sweeps: u64,
    /// Planes that held something of use at once, at most.
    pub planes: u64,
    /// How far a channel is from the exact mean, in levels, at most.
    pub error: u64,
    /// How far it may be.
    pub bound: u64,
    /// What a frame costs.
    pub price: Price,
}

impl Run {
    /// What a report says, with the command beside it.
    fn read(json: &Json) -> Option<Run> {
        let own = |name: &str| json["accumulate"][name].as_u64();
        Some(Run {
            command: json["command"].as_str()?.to_string(),
            cycles: json["cycles"]["total"].as_u64()?,
            passes: own("passes")?,
            sweeps: own("sweeps")?,
            planes: own("peak_planes")?,
            error: json["image"]["max_error"].as_u64()?,
            bound: json["image"]["error_bound"].as_u64()?,
            price: Price::read(json)?,
        })
    }
}

/// What came of frames by each method.
pub struct Entry {
    /// What they are for.
    pub figure: Figure,
    /// The frames.
    pub frames: Frames,
    /// Each method, and what came of it.
    pub runs: Vec<(Method, Run)>,
}

impl Entry {
    /// What came of a method, if it was played.
    pub fn run(&self, method: Method) -> Option<&Run> {
        self.runs.iter().find(|(of, _)| *of == method).map(|(_, run)| run)
    }
}

/// Plays what no file has yet; nothing if a model is at fault, or an image or a count wrong.
///
/// # Errors
/// Frames cannot be read, or a file not be written.
pub fn play(planned: &Planned, kept: &Kept) -> anyhow::Result<Option<Entry>> {
    let Planned { figure, frames, methods } = planned;
    let machines: Vec<_> = methods.iter().map(|method| method.machine(frames.count())).collect();
    let runs = kept.play_all(&machines, frames, Run::read)?;
    Ok(runs.map(|runs| Entry {
        figure: *figure,
        frames: frames.clone(),
        runs: methods.iter().copied().zip(runs).collect(),
    }))
}
