//! `pellucid reproduce`: a seed document's comparison, made again.

mod accumulation;
mod claims;
mod composer;
mod dfb;
mod fbuffer;
mod frames;
mod kept;
mod price;
mod results;
mod tbuffer;

use super::{finished, passes, say};
use anyhow::bail;
use clap::{Args, ValueEnum};
use composer::{SETTINGS, Setting, Timing};
use indicatif::MultiProgress;
use pellucid_hw::architecture;
use pellucid_machine::{Model, architecture as parameters};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::grouped;
use pellucid_testbench::scene::{Options, built_in};
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::{Case, Trial};
use rayon::prelude::*;
use serde_json::json;
use std::path::PathBuf;
use tbuffer::{Frame, Reproduction};

/// Where pages and figures are, if nothing else is said.
const FOLDER: &str = "pellucid-reproduce";

/// The machines, as the document describes them.
const MACHINES: [(&str, &str); 3] =
    [("tbuffer", "paper"), ("rbuffer", "on-chip"), ("mbuffer", "registers")];

#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Storage and accesses of T-buffer, R-buffer and M-buffer, by the T-buffer paper
    Tbuffer,
    /// Times of the image merger and the scan-line engine, by the image composition paper
    Composer,
    /// Cycles and memory of the Dynamic Fragment Buffer, fixed arrays and linked lists, by the Dynamic Fragment Buffer paper
    Dfb,
    /// Windows, submissions and cycles of shading in several passes, by the F-buffer paper
    Fbuffer,
    /// Cycles, planes and errors of accumulation by a buffer, by blending and by trees, by the paper on accumulation trees
    Accumulation,
}

#[derive(Args)]
pub(super) struct ReproduceArgs {
    /// Which comparison
    what: What,
    /// The paper's sizes instead of small ones: takes hours; what is stopped goes on where it was (dfb, fbuffer, accumulation)
    #[arg(long)]
    full: bool,
    /// A mesh (.obj, .ply, .ply.gz, .gltf, .glb) or scene for the figures that show one model (dfb) [default: `teapot`; for the
    /// walks of --full `plant`]
    #[arg(long, value_name = "NAME|FILE")]
    scene: Option<String>,
    /// The folder for pages, figures and runs (dfb, fbuffer, accumulation) [default: pellucid-reproduce]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
    /// Show no sign of progress
    #[arg(long, short)]
    quiet: bool,
}

impl ReproduceArgs {
    /// The folder for pages, figures and runs.
    fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from(FOLDER))
    }
}

/// A number as people read it.
fn number(n: u64) -> String {
    grouped(&json!(n))
}

/// Reproduces; whether all comes out.
pub(super) fn reproduce(args: &ReproduceArgs) -> anyhow::Result<bool> {
    let leaves_files = matches!(args.what, What::Dfb | What::Fbuffer | What::Accumulation);
    if !leaves_files && (args.full || args.out.is_some()) {
        let option = if args.full { "--full" } else { "--out" };
        bail!(
            "{option}: is for `reproduce dfb`, `reproduce fbuffer` and `reproduce accumulation`; the others have one size and leave no files"
        );
    }
    if args.scene.is_some() && !matches!(args.what, What::Dfb) {
        bail!("--scene: is for `reproduce dfb`; the others have scenes of their own");
    }
    match args.what {
        What::Dfb => dfb::reproduce(args),
        What::Fbuffer => fbuffer::reproduce(args),
        What::Accumulation => accumulation::reproduce(args),
        What::Tbuffer => tbuffer(args),
        What::Composer => composer(args),
    }
}

fn composer(args: &ReproduceArgs) -> anyhow::Result<bool> {
    let bars = MultiProgress::new();
    let done: Vec<anyhow::Result<Option<(Timing, bool)>>> =
        SETTINGS.par_iter().map(|setting| timing(*setting, &bars, args.quiet)).collect();
    let (mut timings, mut exact) = (vec![], true);
    for timing in done {
        let Some((timing, passed)) = timing? else { return Ok(false) };
        exact &= passed && timing.is_reproduced();
        timings.push(timing);
    }
    if args.json {
        say(&format!("{:#}\n", composer::json(&timings)))?;
    } else {
        let verdict = if exact {
            "Every image is right, every count its closed form, and every printed number that is no slip comes out."
        } else {
            "Not everything comes out: see the figures above."
        };
        say(&format!("{}\n\n{verdict}\n", composer::table(&timings)))?;
    }
    Ok(exact)
}

/// One case of seed document 001 on the machine, and whether its image is right; nothing if the model is at fault.
fn timing(
    setting: Setting,
    bars: &MultiProgress,
    quiet: bool,
) -> anyhow::Result<Option<(Timing, bool)>> {
    let progress =
        |what, total| Progress::among(bars, setting.name.to_string(), what, total, quiet);
    let (width, height) = (Some(setting.width), Some(setting.rows()));
    let source = Source::open("panes", &Options { width, height, ..Options::default() })?;
    let architecture = architecture("composer")?;
    let set = |name: &str, value: u32| parameters::Setting {
        name: name.to_string(),
        value: value.to_string(),
        origin: setting.name.to_string(),
    };
    let settings = [set("engines", setting.engines), set("beta", composer::BETA)];
    let machine = architecture.build(source.screen(), None, &settings)?;
    let case = Case::new("panes", source, &*machine, &mut progress("golden model", None))?;
    let about = format!("{}: ", setting.name);
    let mut progress = progress("simulating", Some(case.items));
    let done = case.run(architecture.name, &*machine, None, &mut progress);
    let Some(trial) = finished(done, &about)? else { return Ok(None) };
    let passed = passes(&trial.verdict, false, &about);
    Ok(Some((Timing::new(setting, &trial), passed)))
}

fn tbuffer(args: &ReproduceArgs) -> anyhow::Result<bool> {
    let names: Vec<&str> = built_in()
        .iter()
        .map(|scene| scene.name)
        .filter(|name| name.starts_with("paper-"))
        .collect();
    let bars = MultiProgress::new();
    let done: Vec<anyhow::Result<Option<(Frame, bool)>>> =
        names.par_iter().map(|name| frame(name, &bars, args.quiet)).collect();
    let mut frames = vec![];
    let mut exact = true;
    for frame in done {
        let Some((frame, passed)) = frame? else { return Ok(false) };
        exact &= passed;
        frames.push(frame);
    }
    let reproduction = Reproduction::new(frames)?;
    exact &= reproduction.is_reproduced();
    if args.json {
        say(&format!("{:#}\n", reproduction.json()))?;
    } else {
        let verdict = if exact {
            "Every image is right, every count its closed form, and every percentage within two points of \
             the printed one."
        } else {
            "Not everything comes out: see the figures above."
        };
        say(&format!("{}\n{verdict}\n", reproduction.table()))?;
    }
    Ok(exact)
}

/// One frame through the machines, and whether all is right; nothing if a model is at fault.
fn frame(name: &str, bars: &MultiProgress, quiet: bool) -> anyhow::Result<Option<(Frame, bool)>> {
    let progress = |what, total| Progress::among(bars, name.to_string(), what, total, quiet);
    let source = Source::open(name, &Options::default())?;
    let screen = source.screen();
    let mut machines = vec![];
    for (arch, preset) in MACHINES {
        let arch = architecture(arch)?;
        machines.push((arch, arch.build(screen, Some(preset), &[])?));
    }
    let all: Vec<&dyn Model> = machines.iter().map(|(_, machine)| &**machine).collect();
    // They take fragments, all of them, so that one case is as good as another.
    let case = Case::all(name, source, &all, &mut progress("golden model", None))?.swap_remove(0);
    let mut passed = true;
    let mut trials: Vec<Trial> = vec![];
    for (arch, machine) in &machines {
        let mut progress = progress("simulating", Some(case.items));
        let about = format!("{} on {name}: ", arch.name);
        let done = case.run(arch.name, &**machine, None, &mut progress);
        let Some(trial) = finished(done, &about)? else { return Ok(None) };
        passed &= passes(&trial.verdict, false, &about);
        trials.push(trial);
    }
    let census = case.reference.census();
    let frame = Frame::new(name, screen, census, [&trials[0], &trials[1], &trials[2]])?;
    Ok(Some((frame, passed)))
}
