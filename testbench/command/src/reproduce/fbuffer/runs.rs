//! What came of frames in machines with F-buffers.

use super::plan::{Buffer, Figure, PASSES, Planned};
use crate::reproduce::frames::Frames;
use crate::reproduce::kept::{Kept, Machine};
use crate::reproduce::price::Price;
use serde_json::Value as Json;

/// Frames through one buffer.
#[derive(Clone, Debug)]
pub struct Run {
    /// The command that does the same.
    pub command: String,
    /// Cycles.
    pub cycles: u64,
    /// N: fragments of the frame.
    pub fragments: u64,
    /// Windows over these.
    pub windows: u64,
    /// How often the geometry was sent.
    pub submissions: u64,
    /// Vertices that were processed.
    pub vertices: u64,
    /// Fragments that went through a pass.
    pub shaded: u64,
    /// Fragments that were discarded before one.
    pub discarded: u64,
    /// Bytes of the buffer.
    pub bytes: u64,
    /// What the frame costs.
    pub price: Price,
}

impl Run {
    /// What a report says, with the command beside it.
    fn read(json: &Json) -> Option<Run> {
        let own = |name: &str| json["fbuffer"][name].as_u64();
        Some(Run {
            command: json["command"].as_str()?.to_string(),
            cycles: json["cycles"]["total"].as_u64()?,
            fragments: own("fragments")?,
            windows: own("windows")?,
            submissions: own("submissions")?,
            vertices: own("vertices")?,
            shaded: own("shaded")?,
            discarded: own("discarded")?,
            bytes: json["storage"]["seed_bytes"].as_u64()?,
            price: Price::read(json)?,
        })
    }
}

/// What came of frames in each buffer.
pub struct Entry {
    /// What they are for.
    pub figure: Figure,
    /// The frames.
    pub frames: Frames,
    /// Each buffer, and what came of it.
    pub runs: Vec<(Buffer, Run)>,
}

/// What bounds a run, in cycles.
pub struct Terms {
    /// Vertices, one after the other.
    pub vertices: u64,
    /// Fragments: those that are shaded, and a cycle for each that is discarded.
    pub fragments: u64,
}

impl Terms {
    /// For a frame that has a run's fragments and vertices.
    pub fn of(buffer: Buffer, run: &Run) -> Terms {
        let windows = run.fragments.div_ceil(buffer.places());
        let shading = u64::from(buffer.fragment_cycles) + windows - 1;
        Terms {
            vertices: run.vertices * u64::from(buffer.vertex_cycles),
            fragments: PASSES * run.fragments * shading,
        }
    }

    /// The larger one.
    pub fn larger(&self) -> u64 {
        self.vertices.max(self.fragments)
    }
}

/// Plays what no file has yet; nothing if a model is at fault, or an image or a count wrong. Buffers of all sizes blend alike.
///
/// # Errors
/// Frames cannot be read, or a file not be written.
pub fn play(planned: &Planned, kept: &Kept) -> anyhow::Result<Option<Entry>> {
    let Planned { figure, frames, buffers } = planned;
    let machines: Vec<Machine> = buffers.iter().map(|buffer| buffer.machine()).collect();
    let runs = kept.play_all(&machines, frames, Run::read)?;
    Ok(runs.map(|runs| Entry {
        figure: *figure,
        frames: frames.clone(),
        runs: buffers.iter().copied().zip(runs).collect(),
    }))
}
