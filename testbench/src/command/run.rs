//! `pellucid run`: one frame through one architecture.

use super::machine::MachineArgs;
use super::{SceneArgs, complain, say, tell};
use crate::arch::Job;
use crate::bench::BenchError;
use crate::golden::{Golden, GoldenError, Reference};
use crate::output::create_dir;
use crate::progress::Progress;
use crate::report::Report;
use crate::scoreboard::Verdict;
use crate::source::{Source, SourceError};
use crate::window::{DEFAULT_WINDOWS, Window};
use clap::Args;
use comfy_table::Table;
use pellucid_hw::machine::Census;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// The folder for image.png, stats.json, stats.csv and wave.vcd
    #[arg(long, default_value = "pellucid-out", value_name = "DIR")]
    out: PathBuf,
    /// Cycles that the waveform shows: FROM..TO counted from the frame's start, `store` or `resolve`
    /// (1000 cycles from there on), `all`; several with commas [default: store,resolve]
    #[arg(long, value_name = "WINDOW", value_delimiter = ',', allow_hyphen_values = true)]
    wave: Vec<Window>,
    /// Write no waveform
    #[arg(long, conflicts_with = "wave")]
    no_wave: bool,
    /// Dropped fragments are no failure, only a warning
    #[arg(long)]
    allow_drops: bool,
    /// Print nothing but errors and warnings
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
    /// Print the figures as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Runs; whether the result is exact.
pub(super) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let source = args.scene.open()?;
    let screen = source.screen();
    let machine = args.machine.build(screen)?;
    create_dir(&args.out)?;

    let reference = golden(&source, args.quiet)?;
    let wave = (!args.no_wave).then(|| {
        let windows =
            if args.wave.is_empty() { DEFAULT_WINDOWS.to_vec() } else { args.wave.clone() };
        (args.out.join("wave.vcd"), windows)
    });
    let mut progress = Progress::new("simulating", Some(reference.fragments), args.quiet);
    let job = Job { source: &source, wave, progress: &mut progress };
    let outcome = match machine.run(job) {
        Ok(outcome) => outcome,
        Err(BenchError::Source(error)) => return Err(error.into()),
        Err(BenchError::Output(error)) => return Err(error.into()),
        Err(wrong) => {
            complain(&wrong.to_string());
            return Ok(false);
        }
    };
    drop(progress);

    let census = Census { stored: reference.stored, histogram: reference.stored_histogram.clone() };
    let closed_forms = machine.closed_forms(&outcome.tally, &census);
    let verdict = Verdict::new(&reference, &outcome.image, &outcome.tally, closed_forms);
    let report = Report::new(
        arch.name,
        &args.scene.scene,
        machine.values(),
        screen,
        &reference,
        outcome.tally,
        &verdict,
    );
    outcome.image.write_png(&args.out.join("image.png"))?;
    report.write(&args.out)?;

    let allowed = args.allow_drops && verdict.is_exact_but_for_drops();
    for fault in verdict.faults() {
        tell(&format!("{}: {fault}", if allowed { "warning" } else { "error" }));
    }
    if args.json {
        say(&format!("{:#}\n", report.json()))?;
    } else if !args.quiet {
        let table = report.table(Table::new().width());
        say(&format!("{table}\n{}{}", report.headline(), summary(args, &verdict)))?;
    }
    Ok(verdict.is_exact() || allowed)
}

/// Where everything is, and whether it is right.
fn summary(args: &RunArgs, verdict: &Verdict) -> String {
    let exact = if verdict.is_exact() {
        "The image equals the golden model's, bit for bit, and every count its closed form."
    } else {
        "The result is not exact: see what is said on standard error."
    };
    let mut files = vec![
        ("image.png", "the image"),
        ("stats.json", "the figures, with unit and meaning of each"),
        ("stats.csv", "the same as a table"),
    ];
    if !args.no_wave {
        files.push(("wave.vcd", "the waveform, for GTKWave or Surfer"));
    }
    let mut text = format!("{exact}\n\n");
    for (name, what) in files {
        text += &format!("  {:32} {what}\n", args.out.join(name).display());
    }
    text
}

/// What the golden model says of the frame.
fn golden(source: &Source, quiet: bool) -> anyhow::Result<Reference> {
    let mut progress = Progress::new("golden model", None, quiet);
    let mut golden = Golden::new(source.screen());
    source.play::<PlayError>(&mut |fragment| {
        progress.step();
        Ok(golden.push(fragment)?)
    })?;
    Ok(golden.finish())
}

#[derive(Debug, thiserror::Error)]
enum PlayError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
}
