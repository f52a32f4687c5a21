//! `pellucid trace`: a scene's fragments as a file.

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
    let source = args.scene.open()?;
    let mut writer = TraceWriter::create(&args.out, source.screen())?;
    let mut progress = Progress::new("writing", None, args.quiet);
    let mut fragments = 0u64;
    source.play_fragments::<WriteError>(&mut |fragment| {
        progress.step();
        fragments += 1;
        Ok(writer.push(fragment)?)
    })?;
    writer.finish()?;
    drop(progress);
    if !args.quiet {
        say(&format!("{fragments} fragments in {}\n", args.out.display()))?;
    }
    Ok(true)
}
