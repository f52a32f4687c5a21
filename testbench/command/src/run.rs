//! `pellucid run`: one frame, or several in a row, through one architecture.

use super::check::check;
use super::machine::MachineArgs;
use super::technology::{LibertyArgs, TechnologyArgs, logic_in};
use super::wave::WaveArgs;
use super::{SceneArgs, complain, finished, not_right, passes, quoted, say, tell};
use anyhow::bail;
use clap::Args;
use comfy_table::Table;
use pellucid_machine::{Census, Kind, Model};
use pellucid_testbench::bench::BenchError;
use pellucid_testbench::output::OutputFolder;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::recorder::{WaveJob, WaveReport};
use pellucid_testbench::report::grouped;
use pellucid_testbench::scene::{CameraPath, Walk};
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::{Case, Trial};
use pellucid_waveforms::Marker;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Only read the scene, and print what it holds and what of it is used: nothing is run, nothing is written. With --json
    /// as JSON
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    machine: MachineArgs,
    /// Frames in a row, 1 to 1024: the camera goes 3 degrees round the scene from each to the next, or the animation
    /// of a glTF plays at 24 frames a second; figures are those of all frames together, and those of each beside them.
    /// `accumulate` makes one image of them all
    #[arg(long, default_value_t = 1, value_name = "FRAMES", value_parser = frames, allow_hyphen_values = true)]
    frames: u32,
    /// The way of the camera through the frames instead: `orbit`, once round on a circle, `ellipse`, once round on an ellipse half
    /// as wide as long, or `zoom`, from four times the distance to a quarter of it
    #[arg(long, value_name = "PATH")]
    path: Option<CameraPath>,
    /// The folder for image.png (image-000.png and so on, if there are several frames), stats.json, stats.csv, the
    /// waveform and how viewers show it
    #[arg(long, default_value = "pellucid-out", value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    technology: TechnologyArgs,
    #[command(flatten)]
    liberty: LibertyArgs,
    /// Dropped fragments are no failure, only a warning
    #[arg(long)]
    allow_drops: bool,
    /// Print every figure as well, as a table
    #[arg(long)]
    details: bool,
    /// Print nothing but errors and warnings
    #[arg(long, short, conflicts_with_all = ["details", "json"])]
    quiet: bool,
    /// Print the figures as JSON and nothing else
    #[arg(long, conflicts_with = "details")]
    json: bool,
    #[command(flatten)]
    wave: WaveArgs,
}

/// The most frames of a run.
const MOST_FRAMES: u32 = 1024;

/// A number of frames.
pub(super) fn frames(text: &str) -> Result<u32, String> {
    let frames = text.parse().ok().filter(|frames| (1..=MOST_FRAMES).contains(frames));
    frames.ok_or_else(|| format!("expected a whole number from 1 to {MOST_FRAMES}"))
}

/// Checks that a scene has so many frames.
pub(super) fn has_frames(scene: &str, source: &Source, frames: u32) -> anyhow::Result<()> {
    if frames > 1 && source.later(1)?.is_none() {
        bail!(
            "--frames {frames}: `{scene}` is one frame alone, expected a scene whose camera can go round it: `glass`, \
             `teapot`, `plant` or a mesh"
        );
    }
    Ok(())
}

/// Runs; whether the result is right.
pub(super) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let SceneArgs { scene, view } = &args.scene;
    let walk = args.path.map(|path| Walk { path, frames: args.frames });
    if args.check {
        return check(scene, &view.open(scene, walk)?, args.json, args.quiet);
    }
    let arch = args.machine.arch()?;
    let technology = Arc::new(args.technology.open()?);
    let library = args.liberty.open()?;
    let source = view.open(scene, walk)?;
    let screen = source.screen();
    let machine = args.machine.build(screen, args.frames)?;
    // Frames that make one image may be the same.
    if machine.frames_of_image() == 1 {
        has_frames(scene, &source, args.frames)?;
    }
    let frames = args.frames.next_multiple_of(machine.frames_of_image());
    view.tell_of_order(arch.name, &*machine);
    let _folder = OutputFolder::claim(&args.out)?;

    let mut progress = Progress::new("golden model", None, args.quiet);
    let case = Case::new(scene, source, &*machine, &mut progress)?;
    let case = case.with_frames(frames, &*machine, &mut progress)?;
    let case = Case { technology, ..case };
    let machine = args.machine.with_room(machine, &case)?;
    let logic = logic_in(library.as_ref(), arch.name, &*machine, &case.technology, args.quiet)?;
    let case = Case { logic, ..case };
    let wave = args.wave.job(&args.out, &*machine, case.items)?;
    progress = Progress::new("simulating", Some(case.items * u64::from(frames)), args.quiet);
    let mut trial = case.run(arch.name, &*machine, wave.as_ref(), &mut progress);
    if let (Ok(done), Some(wave)) = (&trial, &wave)
        && !done.verdict.passes(args.allow_drops)
        && let Some(window) = done.verdict.place()
    {
        trial = case.run_again(arch.name, &*machine, wave, window, &mut progress);
    }
    drop(progress);
    let unseen = matches!(trial, Err(BenchError::Unseen { .. }));
    let Some(trial) = finished(trial, "")? else {
        if let Some(wave) = &wave
            && !unseen
        {
            tell(&format!("The cycles before are in `{}`.", wave.path.display()));
        }
        return Ok(false);
    };
    let Trial { images, verdict, report, wave: seen } = trial;
    for (image, path) in images.iter().zip(image_paths(args, images.len())) {
        image.write_png(&path)?;
    }
    report.write(&args.out)?;
    seen.notes.iter().for_each(|note| tell(&format!("note: {note}")));

    let passes = passes(&verdict, args.allow_drops, "");
    // Of primitives that find no place it knows nothing.
    if verdict.dropped > 0 && machine.kind() == Kind::Fragments {
        hint_at_size(args, &*machine)?;
    }
    if args.json {
        say(&format!("{:#}\n", report.json()))?;
    } else if !args.quiet {
        let details = if args.details {
            report.table(Table::new().width())
        } else {
            "All figures: `--details` prints them.\n".to_string()
        };
        let result = verdict.approval().unwrap_or_else(|| not_right(passes).to_string());
        let files = files(args, images.len(), wave.as_ref(), &seen);
        say(&format!("{result}\n{}\n{files}\n{details}", report.headline()))?;
    }
    match seen.lost {
        None => Ok(passes),
        Some(lost) if passes => Err(lost.into()),
        Some(lost) => {
            complain(&lost.to_string());
            Ok(false)
        }
    }
}

/// Says how the machine is found that drops nothing of these frames.
fn hint_at_size(args: &RunArgs, machine: &dyn Model) -> anyhow::Result<()> {
    let Some(room) = machine.room(&Census::default()) else { return Ok(()) };
    let mut words = vec!["pellucid size --scene".to_string(), quoted(&args.scene.scene)];
    words.extend(args.scene.view.given());
    if args.frames > 1 {
        words.push(format!("--frames {}", args.frames));
    }
    words.extend(args.path.map(|path| format!("--path {path}")));
    words.extend(args.machine.words(&room.names())?);
    let words = words.join(" ");
    tell(&format!("hint: `{words}` finds the smallest machine that drops nothing"));
    Ok(())
}

/// Where each of so many images is.
fn image_paths(args: &RunArgs, images: usize) -> impl Iterator<Item = PathBuf> {
    (0..images).map(move |image| match images {
        1 => args.out.join("image.png"),
        _ => args.out.join(format!("image-{image:03}.png")),
    })
}

/// Where everything is.
fn files(args: &RunArgs, images: usize, wave: Option<&WaveJob>, seen: &WaveReport) -> String {
    let mut images = image_paths(args, images);
    let mut files: Vec<(PathBuf, &str)> = vec![];
    files.extend(images.next().map(|path| (path, "the image")));
    files.extend(images.last().map(|path| (path, "the last of the images, one for each frame")));
    files.extend([
        (args.out.join("stats.json"), "the figures, with unit and meaning of each"),
        (args.out.join("stats.csv"), "the same as a table"),
    ]);
    if let (Some(WaveJob { path, .. }), None) = (wave, &seen.lost) {
        files.push((path.clone(), "the waveform"));
        let gtkwave = "how GTKWave shows it: `gtkwave` takes this file";
        files.push((path.with_extension("gtkw"), gtkwave));
        files.push((
            path.with_extension("sucl"),
            "how Surfer shows it: `surfer -c` takes this file",
        ));
    }
    let mut text = String::new();
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
