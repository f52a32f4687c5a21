//! How many frames, and how they differ.

use super::ViewArgs;
use anyhow::bail;
use clap::Args;
use pellucid_testbench::scene::{CameraPath, Sequence, Varied, Vary, Walk};
use pellucid_testbench::source::Source;

/// The most frames of a run.
const MOST_FRAMES: u32 = 1024;

#[derive(Args, Clone, Debug, Default)]
pub(super) struct SequenceArgs {
    /// Frames in a row, 1 to 1024: the camera goes 3 degrees round the scene from each to the next, or the animation
    /// of a glTF plays at 24 frames a second, or a trace goes on. `accumulate` makes one image of them, and repeats a frame where
    /// neither --path nor --vary is given [default: all frames of a trace, 1 of any other scene]
    #[arg(long, value_name = "FRAMES", value_parser = frames, allow_hyphen_values = true)]
    pub frames: Option<u32>,
    /// The way of the camera through the frames instead: `orbit`, once round on a circle, `ellipse`, once round on an ellipse half
    /// as wide as long, or `zoom`, from four times the distance to a quarter of it
    #[arg(long, value_name = "PATH")]
    pub path: Option<CameraPath>,
    /// What differs between the frames instead: `none`, each is the first again, `aa`, where in its pixel a sample is, `focus`, where on
    /// a lens that is in focus at the point looked at, `motion`, when while a shutter is open, or `light`, where on a round light
    #[arg(long, value_name = "WAY")]
    pub vary: Option<Vary>,
}

/// The first frame of a scene, and how many there are to play.
pub(super) type Opened = (Source, u32);

/// A number of frames.
pub(super) fn frames(text: &str) -> Result<u32, String> {
    let frames = text.parse().ok().filter(|frames| (1..=MOST_FRAMES).contains(frames));
    frames.ok_or_else(|| format!("expected a whole number from 1 to {MOST_FRAMES}"))
}

impl SequenceArgs {
    /// Opens a scene. Where frames become one image, and it is not told how they differ, each `repeats` the first; a trace goes on.
    ///
    /// # Errors
    /// The scene cannot be read, or does not have such frames.
    pub fn open(&self, scene: &str, view: &ViewArgs, repeats: bool) -> anyhow::Result<Opened> {
        let frames = self.frames.unwrap_or(1);
        let sequence = match (self.path, self.vary) {
            (Some(path), Some(vary)) => bail!(
                "path `{path}` and vary `{vary}` exclude each other: the camera goes a way, or one view is sampled anew"
            ),
            (Some(path), None) => Some(Sequence::Walk(Walk { path, frames })),
            (None, Some(vary)) => Some(Sequence::Varied(Varied { vary, frames })),
            (None, None) => None,
        };
        let source = view.open(scene, sequence)?;
        if self.vary == Some(Vary::None) {
            return Ok((source, frames));
        }
        if let Some(recorded @ 2..) = source.recorded() {
            let most = recorded.min(MOST_FRAMES);
            let frames = self.frames.unwrap_or(most);
            if frames > most {
                bail!(
                    "`{scene}` has {recorded} frames, {frames} are asked for: expected 1 to {most}, or vary `none`, which \
                     repeats the first"
                );
            }
            return Ok((source, frames));
        }
        if repeats && sequence.is_none() {
            return Ok((source.repeated(), frames));
        }
        if frames > 1 && source.later(1)?.is_none() {
            bail!(
                "`{scene}` is one frame alone, {frames} are asked for: expected a scene whose camera can go round it, \
                 `glass`, `teapot`, `plant` or a mesh, or vary `none`, which repeats the frame"
            );
        }
        Ok((source, frames))
    }

    /// What is given of it, as a shell takes it.
    pub fn given(&self) -> Vec<String> {
        let frames = self.frames.map(|frames| format!("--frames {frames}"));
        let path = self.path.map(|path| format!("--path {path}"));
        let vary = self.vary.map(|vary| format!("--vary {vary}"));
        [frames, path, vary].into_iter().flatten().collect()
    }
}
