//! `pellucid compare`: several machines on several scenes, side by side.

use super::machine::Choice;
use super::{DEFAULT_SCENE, NOT_RIGHT, ViewArgs, finished, passes, quoted, say};
use crate::arch::Runnable;
use crate::compare::{Compared, Comparison};
use crate::output::create_dir;
use crate::progress::Progress;
use crate::source::Source;
use crate::trial::{Case, CaseError, Trial};
use anyhow::bail;
use clap::Args;
use comfy_table::Table;
use indicatif::MultiProgress;
use rayon::prelude::*;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct CompareArgs {
    /// A machine: an architecture (see `pellucid list`), its preset if not the first, and parameters;
    /// may be given several times [default: every preset of every architecture]
    #[arg(long, value_name = "ARCH[:PRESET][,NAME=VALUE]...")]
    machine: Vec<String>,
    /// A built-in scene (see `pellucid list`), a mesh (.obj, .ply, .ply.gz, .gltf, .glb) or a trace
    /// (.csv, .ptrace); may be given several times
    #[arg(long, default_value = DEFAULT_SCENE, value_name = "NAME|FILE")]
    scene: Vec<String>,
    #[command(flatten)]
    view: ViewArgs,
    /// Frames that each machine plays before the one that counts: the same scene, so that its free sections
    /// are in the order in which a running machine has them
    #[arg(long, value_name = "FRAMES", default_value_t = 0)]
    warm_up: u32,
    /// The folder for compare.html, compare.json and compare.csv
    #[arg(long, default_value = "pellucid-compare", value_name = "DIR")]
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
}

/// One run that is to be done.
struct Planned<'a> {
    choice: &'a Choice,
    machine: &'a dyn Runnable,
    case: &'a Case,
}

impl Planned<'_> {
    fn name(&self) -> String {
        format!("{} on {}", self.choice.name, self.case.scene)
    }
}

/// Compares; whether every result is right.
pub(super) fn compare(args: &CompareArgs) -> anyhow::Result<bool> {
    let choices = choices(args)?;
    once("--scene", &args.scene)?;
    let sources: Vec<(&String, Source)> = args
        .scene
        .iter()
        .map(|scene| Ok((scene, args.view.open(scene)?)))
        .collect::<anyhow::Result<_>>()?;
    let machines: Vec<Vec<Box<dyn Runnable>>> = sources
        .iter()
        .map(|(_, source)| choices.iter().map(|choice| choice.build(source.screen())).collect())
        .collect::<anyhow::Result<_>>()?;
    create_dir(&args.out)?;

    let bars = MultiProgress::new();
    let progress = |whose: &str, what, total| {
        Progress::among(&bars, whose.to_string(), what, total, args.quiet)
    };
    let cases: Vec<Result<Vec<Case>, CaseError>> = sources
        .into_par_iter()
        .zip(&machines)
        .map(|((scene, source), machines)| {
            let machines: Vec<&dyn Runnable> = machines.iter().map(|machine| &**machine).collect();
            let mut progress = progress(scene, "golden model", None);
            let mut cases = Case::all(scene, source, &machines, &mut progress)?;
            cases.iter_mut().for_each(|case| case.warm_up = args.warm_up);
            Ok(cases)
        })
        .collect();
    let cases: Vec<Vec<Case>> = cases.into_iter().collect::<Result<_, _>>()?;
    let planned: Vec<Planned> = cases
        .iter()
        .zip(&machines)
        .flat_map(|(cases, machines)| {
            let each = choices.iter().zip(machines).zip(cases);
            each.map(|((choice, machine), case)| Planned { choice, machine: &**machine, case })
        })
        .collect();
    let done: Vec<_> = planned
        .par_iter()
        .map(|run| {
            let mut progress = progress(&run.name(), "simulating", Some(run.case.items));
            run.case.run(run.choice.arch.name, run.machine, None, &mut progress)
        })
        .collect();

    let mut trials = vec![];
    for (run, done) in planned.iter().zip(done) {
        trials.push(finished(done, &format!("{}: ", run.name()))?);
    }
    let names: Vec<String> = planned.iter().map(Planned::name).collect();
    // A model at fault leaves a hole; nothing is written then.
    let Some(trials) = trials.into_iter().collect::<Option<Vec<Trial>>>() else {
        return Ok(false);
    };
    let mut pass = true;
    for (name, trial) in names.iter().zip(&trials) {
        pass &= passes(&trial.verdict, args.allow_drops, &format!("{name}: "));
    }
    let mut trials = trials.into_iter();
    let each = cases.into_iter().map(|mut cases| {
        let trials = trials.by_ref().take(choices.len()).collect();
        Compared { case: cases.swap_remove(0), trials }
    });
    let comparison = Comparison {
        command: command(args, &choices),
        scenes: each.collect(),
        machines: choices.into_iter().map(|choice| choice.name).collect(),
    };
    comparison.write(&args.out)?;
    if args.json {
        say(&format!("{:#}\n", comparison.json()))?;
    } else if !args.quiet {
        say(&format!(
            "{}\n{}",
            comparison.table(Table::new().width()),
            summary(args, &comparison)
        ))?;
    }
    Ok(pass)
}

/// The machines that are asked for.
fn choices(args: &CompareArgs) -> anyhow::Result<Vec<Choice>> {
    if args.machine.is_empty() {
        return Ok(Choice::all());
    }
    let choices: Vec<Choice> =
        args.machine.iter().map(|text| Choice::parse(text)).collect::<anyhow::Result<_>>()?;
    once("--machine", choices.iter().map(|choice| &choice.name))?;
    Ok(choices)
}

/// Refuses what is given twice: its figures could not be told apart.
fn once<'a>(option: &str, names: impl IntoIterator<Item = &'a String>) -> anyhow::Result<()> {
    let mut seen = vec![];
    for name in names {
        if seen.contains(&name) {
            bail!("{option} {name}: is given twice");
        }
        seen.push(name);
    }
    Ok(())
}

/// The command that gives the same files.
fn command(args: &CompareArgs, choices: &[Choice]) -> String {
    let mut words = vec!["pellucid".to_string(), "compare".to_string()];
    let mut add = |option: &str, value: &str| words.push(format!("{option} {}", quoted(value)));
    for choice in choices {
        add("--machine", &choice.name);
    }
    for scene in &args.scene {
        add("--scene", scene);
    }
    for (option, value) in args.view.given() {
        add(option, &value);
    }
    if args.warm_up > 0 {
        add("--warm-up", &args.warm_up.to_string());
    }
    words.join(" ")
}

/// Whether all is right, and where everything is.
fn summary(args: &CompareArgs, comparison: &Comparison) -> String {
    let result = comparison.approval().unwrap_or(NOT_RIGHT);
    let mut text = format!("{result}\n\n");
    for (name, what) in [
        ("compare.html", "the figures with plots and images, for a browser"),
        ("compare.json", "the figures, with unit and meaning of each"),
        ("compare.csv", "the same as a table"),
    ] {
        text += &format!("  {:32} {what}\n", args.out.join(name).display());
    }
    text
}
