//! `pellucid trace`: a scene's fragments as a file, of one frame or of several.

use super::sequence::SequenceArgs;
use super::{SceneArgs, say};
use clap::Args;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::source::SourceError;
use pellucid_testbench::trace::{TraceError, TraceWriter};
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct TraceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    sequence: SequenceArgs,
    /// The trace to write: text if it ends in .csv, the compact binary form if it ends in .ptrace
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Debug, thiserror::Error)]
enum WriteError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Trace(#[from] TraceError),
}

/// Writes the trace.
pub(super) fn trace(args: &TraceArgs) -> anyhow::Result<bool> {
    let SceneArgs { scene, view } = &args.scene;
    let (first, frames) = args.sequence.open(scene, view, false)?;
    let mut writer = TraceWriter::create(&args.out, first.screen(), frames)?;
    let mut progress = Progress::new("writing", None, args.quiet);
    let mut fragments = 0u64;
    first.each_frame::<WriteError>(frames, &mut |number, source| {
        if number > 0 {
            writer.next_frame()?;
        }
        source.play_fragments(&mut |fragment| {
            progress.step();
            fragments += 1;
            Ok(writer.push(fragment)?)
        })
    })?;
    writer.finish()?;
    drop(progress);
    if !args.quiet {
        let of_frames = if frames > 1 { format!(" of {frames} frames") } else { String::new() };
        say(&format!("{fragments} fragments{of_frames} in {}\n", args.out.display()))?;
    }
    Ok(true)
}
