//! `pellucid run`: one frame through one architecture.

use super::machine::MachineArgs;
use super::wave::WaveArgs;
use super::{NOT_RIGHT, SceneArgs, finished, passes, say, tell};
use crate::output::create_dir;
use crate::progress::Progress;
use crate::recorder::{WaveJob, WaveReport};
use crate::report::grouped;
use crate::scoreboard::Verdict;
use crate::trial::{Case, Trial};
use clap::Args;
use comfy_table::Table;
use pellucid_waveforms::Marker;
use serde_json::json;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// The folder for image.png, stats.json, stats.csv, the waveform and how viewers show it
    #[arg(long, default_value = "pellucid-out", value_name = "DIR")]
    out: PathBuf,
    /// Dropped fragments are no failure, only a warning
    #[arg(long)]
    allow_drops: bool,
    /// Print nothing but errors and warnings
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
    /// Print the figures as JSON instead of a table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    wave: WaveArgs,
}

/// Runs; whether the result is right.
pub(super) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let source = args.scene.open()?;
    let screen = source.screen();
    let machine = args.machine.build(screen)?;
    create_dir(&args.out)?;

    let mut progress = Progress::new("golden model", None, args.quiet);
    let case = Case::new(&args.scene.scene, source, &*machine, &mut progress)?;
    let wave = args.wave.job(&args.out, screen, case.items)?;
    progress = Progress::new("simulating", Some(case.items), args.quiet);
    let mut trial = case.run(arch.name, &*machine, wave.as_ref(), &mut progress);
    if let (Ok(done), Some(wave)) = (&trial, &wave)
        && !done.verdict.passes(args.allow_drops)
        && let Some(window) = done.verdict.place()
    {
        trial = case.run_again(arch.name, &*machine, wave, window, &mut progress);
    }
    drop(progress);
    let Some(trial) = finished(trial, "")? else {
        if let Some(wave) = &wave {
            tell(&format!("The cycles before are in `{}`.", wave.path.display()));
        }
        return Ok(false);
    };
    let Trial { image, verdict, report, wave: seen } = trial;
    image.write_png(&args.out.join("image.png"))?;
    report.write(&args.out)?;
    seen.notes.iter().for_each(|note| tell(&format!("note: {note}")));

    let passes = passes(&verdict, args.allow_drops, "");
    if args.json {
        say(&format!("{:#}\n", report.json()))?;
    } else if !args.quiet {
        let table = report.table(Table::new().width());
        let summary = summary(args, &verdict, wave.as_ref(), &seen);
        say(&format!("{table}\n{}{summary}", report.headline()))?;
    }
    Ok(passes)
}

/// Where everything is, and whether it is right.
fn summary(args: &RunArgs, verdict: &Verdict, wave: Option<&WaveJob>, seen: &WaveReport) -> String {
    let result = verdict.approval().unwrap_or(NOT_RIGHT.to_string());
    let mut files = vec![
        (args.out.join("image.png"), "the image"),
        (args.out.join("stats.json"), "the figures, with unit and meaning of each"),
        (args.out.join("stats.csv"), "the same as a table"),
    ];
    if let Some(WaveJob { path, .. }) = wave {
        files.push((path.clone(), "the waveform"));
        let gtkwave = "how GTKWave shows it: `gtkwave` takes this file";
        files.push((path.with_extension("gtkw"), gtkwave));
        files.push((
            path.with_extension("sucl"),
            "how Surfer shows it: `surfer -c` takes this file",
        ));
    }
    let mut text = format!("{result}\n\n");
    for (path, what) in files {
        text += &format!("  {:32} {what}\n", path.display());
    }
    if !seen.markers.is_empty() {
        text += "\nMarkers of the waveform\n";
        for (letter, Marker { cycle, name }) in ('A'..='Z').zip(&seen.markers) {
            text += &format!("  {letter} cycle {:>12}  {name}\n", grouped(&json!(cycle)));
        }
    }
    text
}
