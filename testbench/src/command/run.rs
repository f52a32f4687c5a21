//! `pellucid run`: one frame, or several in a row, through one architecture.

use super::machine::MachineArgs;
use super::wave::WaveArgs;
use super::{NOT_RIGHT, SceneArgs, finished, passes, say, tell};
use crate::output::create_dir;
use crate::progress::Progress;
use crate::recorder::{WaveJob, WaveReport};
use crate::report::grouped;
use crate::scoreboard::Verdict;
use crate::trial::{Case, Trial};
use anyhow::bail;
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
    /// Frames in a row, 1 to 1000: the camera goes 3 degrees round the scene from each to the next; figures
    /// are those of all frames together
    #[arg(long, default_value_t = 1, value_name = "FRAMES", value_parser = frames, allow_hyphen_values = true)]
    frames: u32,
    /// The folder for image.png (image-000.png and so on, if there are several frames), stats.json, stats.csv, the
    /// waveform and how viewers show it
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

/// The most frames of a run.
const MOST_FRAMES: u32 = 1000;

/// A number of frames.
fn frames(text: &str) -> Result<u32, String> {
    let frames = text.parse().ok().filter(|frames| (1..=MOST_FRAMES).contains(frames));
    frames.ok_or_else(|| format!("expected a whole number from 1 to {MOST_FRAMES}"))
}

/// Runs; whether the result is right.
pub(super) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let source = args.scene.open()?;
    if args.frames > 1 && source.later(1).is_none() {
        bail!(
            "--frames {}: `{}` is one frame alone, expected a scene whose camera can go round it: `glass`, \
             `teapot` or a mesh",
            args.frames,
            args.scene.scene
        );
    }
    let screen = source.screen();
    let machine = args.machine.build(screen)?;
    create_dir(&args.out)?;

    let mut progress = Progress::new("golden model", None, args.quiet);
    let case = Case::new(&args.scene.scene, source, &*machine, &mut progress)?;
    let case = case.with_frames(args.frames, &*machine, &mut progress)?;
    let wave = args.wave.job(&args.out, screen, case.items)?;
    progress = Progress::new("simulating", Some(case.items * u64::from(args.frames)), args.quiet);
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
    let Trial { images, verdict, report, wave: seen } = trial;
    for (image, path) in images.iter().zip(image_paths(args)) {
        image.write_png(&path)?;
    }
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

/// Where the image of each frame is.
fn image_paths(args: &RunArgs) -> impl Iterator<Item = PathBuf> {
    (0..args.frames).map(|frame| match args.frames {
        1 => args.out.join("image.png"),
        _ => args.out.join(format!("image-{frame:03}.png")),
    })
}

/// Where everything is, and whether it is right.
fn summary(args: &RunArgs, verdict: &Verdict, wave: Option<&WaveJob>, seen: &WaveReport) -> String {
    let result = verdict.approval().unwrap_or(NOT_RIGHT.to_string());
    let mut images = image_paths(args);
    let mut files: Vec<(PathBuf, &str)> = vec![];
    files.extend(images.next().map(|path| (path, "the image")));
    files.extend(images.last().map(|path| (path, "the last of the images, one for each frame")));
    files.extend([
        (args.out.join("stats.json"), "the figures, with unit and meaning of each"),
        (args.out.join("stats.csv"), "the same as a table"),
    ]);
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
