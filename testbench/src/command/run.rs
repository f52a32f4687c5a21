//! `pellucid run`: one frame through one architecture.

use super::machine::MachineArgs;
use super::{NOT_RIGHT, SceneArgs, finished, passes, say};
use crate::output::create_dir;
use crate::progress::Progress;
use crate::scoreboard::Verdict;
use crate::trial::{Case, Trial};
use crate::window::{DEFAULT_WINDOWS, Window};
use clap::Args;
use comfy_table::Table;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// The folder for image.png, stats.json, stats.csv, wave.vcd and wave.gtkw
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

/// Runs; whether the result is right.
pub(super) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let source = args.scene.open()?;
    let screen = source.screen();
    let machine = args.machine.build(screen)?;
    create_dir(&args.out)?;

    let mut progress = Progress::new("golden model", None, args.quiet);
    let case = Case::new(&args.scene.scene, source, [machine.arithmetic()], &mut progress)?;
    let wave = (!args.no_wave).then(|| {
        let windows =
            if args.wave.is_empty() { DEFAULT_WINDOWS.to_vec() } else { args.wave.clone() };
        (args.out.join("wave.vcd"), windows)
    });
    progress = Progress::new("simulating", Some(case.reference.fragments), args.quiet);
    let trial = case.run(arch.name, &*machine, wave, &mut progress);
    drop(progress);
    let Some(Trial { image, verdict, report }) = finished(trial, "")? else { return Ok(false) };
    image.write_png(&args.out.join("image.png"))?;
    report.write(&args.out)?;

    let passes = passes(&verdict, args.allow_drops, "");
    if args.json {
        say(&format!("{:#}\n", report.json()))?;
    } else if !args.quiet {
        let table = report.table(Table::new().width());
        say(&format!("{table}\n{}{}", report.headline(), summary(args, &verdict)))?;
    }
    Ok(passes)
}

/// Where everything is, and whether it is right.
fn summary(args: &RunArgs, verdict: &Verdict) -> String {
    let result = verdict.approval().unwrap_or(NOT_RIGHT.to_string());
    let mut files = vec![
        ("image.png", "the image"),
        ("stats.json", "the figures, with unit and meaning of each"),
        ("stats.csv", "the same as a table"),
    ];
    if !args.no_wave {
        files.push(("wave.vcd", "the waveform, for GTKWave or Surfer"));
        files.push(("wave.gtkw", "how GTKWave shows it: `gtkwave` takes this file"));
    }
    let mut text = format!("{result}\n\n");
    for (name, what) in files {
        text += &format!("  {:32} {what}\n", args.out.join(name).display());
    }
    text
}
