//! `pellucid run`: one frame, or several in a row, through one architecture.

use super::check::check;
use super::machine::MachineArgs;
use super::sequence::SequenceArgs;
use super::technology::{LibertyArgs, TechnologyArgs, logic_in};
use super::wave::WaveArgs;
use super::{SceneArgs, ViewArgs, complain, finished, not_right, passes, quoted, say, tell};
use clap::Args;
use comfy_table::Table;
use pellucid_machine::{Census, Kind, Model};
use pellucid_testbench::bench::BenchError;
use pellucid_testbench::output::OutputFolder;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::recorder::{WaveJob, WaveReport};
use pellucid_testbench::report::grouped;
use pellucid_testbench::trial::{Case, Trial};
use pellucid_waveforms::Marker;
use serde_json::json;
use std::path::{Path, PathBuf};
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
    #[command(flatten)]
    sequence: SequenceArgs,
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

/// Runs; whether the result is right.
pub(super) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let SceneArgs { scene, view } = &args.scene;
    if args.check {
        let (source, frames) = args.sequence.open(scene, view, false)?;
        return check(scene, &source, frames, args.json, args.quiet);
    }
    let arch = args.machine.arch()?;
    let technology = Arc::new(args.technology.open()?);
    let library = args.liberty.open()?;
    let mut sequence = args.sequence.clone();
    sequence.frames = sequence.frames.or(args.machine.frames()?);
    let (source, frames) = sequence.open(scene, view, args.machine.accumulates()?)?;
    let screen = source.screen();
    let machine = args.machine.build(screen, frames)?;
    let frames = frames.next_multiple_of(machine.frames_of_image());
    view.tell_of_order(arch.name, &*machine);
    ViewArgs::tell_of_points(scene, &source, &[&*machine]);
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
    for (image, path) in images.iter().zip(image_paths(&args.out, images.len())) {
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
        let images = image_paths(&args.out, images.len());
        let files = files(&args.out, images, wave.as_ref(), &seen);
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
    words.extend(args.sequence.given());
    words.extend(args.machine.words(&room.names())?);
    let words = words.join(" ");
    tell(&format!("hint: `{words}` finds the smallest machine that drops nothing"));
    Ok(())
}

/// Where each of so many images is.
fn image_paths(out: &Path, images: usize) -> impl Iterator<Item = PathBuf> {
    (0..images).map(move |image| match images {
        1 => out.join("image.png"),
        _ => out.join(format!("image-{image:03}.png")),
    })
}

/// Where everything is.
fn files(
    out: &Path,
    mut images: impl Iterator<Item = PathBuf>,
    wave: Option<&WaveJob>,
    seen: &WaveReport,
) -> String {
    let mut files: Vec<(PathBuf, &str)> = vec![];
    files.extend(images.next().map(|path| (path, "the image")));
    files.extend(images.last().map(|path| (path, "the last of the images, one for each frame")));
    files.extend([
        (out.join("stats.json"), "the figures, with unit and meaning of each"),
        (out.join("stats.csv"), "the same as a table"),
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
