//! `pellucid compare`: several machines on several scenes, side by side.

use super::machine::Choice;
use super::technology::{LibertyArgs, TechnologyArgs, logic_in};
use super::{DEFAULT_SCENE, ViewArgs, finished, not_right, passes, quoted, say, tell};
use anyhow::bail;
use clap::Args;
use comfy_table::Table;
use indicatif::MultiProgress;
use pellucid_machine::Model;
use pellucid_testbench::bench::BenchError;
use pellucid_testbench::compare::{Compared, Comparison};
use pellucid_testbench::output::OutputFolder;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::grouped;
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::{Case, CaseError, Trial};
use rayon::prelude::*;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args)]
pub(super) struct CompareArgs {
    /// A machine: an architecture (see `pellucid list`), its preset if not the first, and parameters;
    /// may be given several times [default: the first preset of every architecture, as far as it takes few
    /// cycles: what is left out is said]
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
    #[command(flatten)]
    technology: TechnologyArgs,
    #[command(flatten)]
    liberty: LibertyArgs,
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

/// Cycles of any frame that a machine which was not asked for may take, and further ones for each fragment: one
/// that needs more is nothing to wait for unasked.
const PATIENCE: u64 = 4_000_000;
/// See [`PATIENCE`].
const PATIENCE_PER_FRAGMENT: u64 = 4;

/// One run that is to be done.
struct Planned<'a> {
    choice: &'a Choice,
    machine: &'a dyn Model,
    case: &'a Case,
}

impl Planned<'_> {
    fn name(&self) -> String {
        format!("{} on {}", self.choice.name, self.case.scene)
    }
}

/// Compares; whether every result is right.
pub(super) fn compare(args: &CompareArgs) -> anyhow::Result<bool> {
    let (choices, mut left_out) = choices(args)?;
    let unasked = args.machine.is_empty();
    once("--scene", &args.scene)?;
    let technology = Arc::new(args.technology.open()?);
    let library = args.liberty.open()?;
    let sources: Vec<(&String, Source)> = args
        .scene
        .iter()
        .map(|scene| Ok((scene, args.view.open_one(scene)?)))
        .collect::<anyhow::Result<_>>()?;
    let machines: Vec<Vec<Box<dyn Model>>> = sources
        .iter()
        .map(|(_, source)| choices.iter().map(|choice| choice.build(source.screen())).collect())
        .collect::<anyhow::Result<_>>()?;
    for (choice, machine) in choices.iter().zip(&machines[0]) {
        args.view.tell_of_order(&choice.name, &**machine);
    }
    for ((scene, source), machines) in sources.iter().zip(&machines) {
        let machines: Vec<&dyn Model> = machines.iter().map(|machine| &**machine).collect();
        ViewArgs::tell_of_points(scene, source, &machines);
    }
    let _folder = OutputFolder::claim(&args.out)?;

    let bars = MultiProgress::new();
    let progress = |whose: &str, what, total| {
        Progress::among(&bars, whose.to_string(), what, total, args.quiet)
    };
    let cases: Vec<Result<Vec<Case>, CaseError>> = sources
        .into_par_iter()
        .zip(&machines)
        .map(|((scene, source), machines)| {
            let machines: Vec<&dyn Model> = machines.iter().map(|machine| &**machine).collect();
            let mut progress = progress(scene, "golden model", None);
            let mut cases = Case::all(scene, source, &machines, &mut progress)?;
            for case in &mut cases {
                case.warm_up = args.warm_up;
                case.technology = technology.clone();
                let frames = 1 + u64::from(args.warm_up);
                let each = PATIENCE + PATIENCE_PER_FRAGMENT * case.reference.fragments;
                case.most_cycles = unasked.then_some(frames * each);
            }
            Ok(cases)
        })
        .collect();
    let mut cases: Vec<Vec<Case>> = cases.into_iter().collect::<Result<_, _>>()?;
    let machines: Vec<Vec<Box<dyn Model>>> = machines
        .into_iter()
        .zip(&cases)
        .map(|(machines, cases)| {
            let each = choices.iter().zip(machines).zip(cases);
            each.map(|((choice, machine), case)| choice.with_room(machine, case)).collect()
        })
        .collect();
    for (machines, cases) in machines.iter().zip(&mut cases) {
        for ((choice, machine), case) in choices.iter().zip(machines).zip(cases) {
            let arch = choice.arch.name;
            case.logic = logic_in(library.as_ref(), arch, &**machine, &technology, args.quiet)?;
        }
    }
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

    // A machine is compared on every scene, or on none.
    let mut kept = vec![true; choices.len()];
    for (k, (run, done)) in planned.iter().zip(&done).enumerate() {
        if let Err(BenchError::TooLong(most)) = done {
            kept[k % choices.len()] = false;
            let (name, most) = (run.name(), grouped(&json!(most)));
            left_out.push(format!("{name}, which takes more than {most} cycles"));
        }
    }
    let (mut names, mut trials) = (vec![], vec![]);
    for ((run, done), kept) in planned.iter().zip(done).zip(kept.iter().cycle()) {
        if *kept {
            names.push(run.name());
            trials.push(finished(done, &format!("{}: ", run.name()))?);
        }
    }
    // A model at fault leaves a hole; nothing is written then.
    let Some(trials) = trials.into_iter().collect::<Option<Vec<Trial>>>() else {
        return Ok(false);
    };
    let mut pass = true;
    for (name, trial) in names.iter().zip(&trials) {
        pass &= passes(&trial.verdict, args.allow_drops, &format!("{name}: "));
    }
    let Some(first) = kept.iter().position(|kept| *kept) else {
        bail!("no machine is done within few cycles: name one with --machine to wait for it");
    };
    let (mut trials, count) = (trials.into_iter(), kept.iter().filter(|kept| **kept).count());
    let each = cases.into_iter().map(|mut cases| {
        let trials = trials.by_ref().take(count).collect();
        Compared { case: cases.swap_remove(first), trials }
    });
    let scenes = each.collect();
    let choices = choices.into_iter().zip(&kept).filter(|(_, kept)| **kept);
    let choices: Vec<Choice> = choices.map(|(choice, _)| choice).collect();
    let comparison = Comparison {
        command: command(args, &choices),
        scenes,
        machines: choices.into_iter().map(|choice| choice.name).collect(),
    };
    comparison.write(&args.out)?;
    if args.json {
        say(&format!("{:#}\n", comparison.json()))?;
        left_out.iter().for_each(|name| tell(&format!("note: left out is {name}")));
    } else if !args.quiet {
        say(&format!(
            "{}\n{}",
            comparison.table(Table::new().width()),
            summary(args, &comparison, pass, &left_out)
        ))?;
    }
    Ok(pass)
}

/// The machines that are asked for; if none is, some, and the names of those that are left out.
fn choices(args: &CompareArgs) -> anyhow::Result<(Vec<Choice>, Vec<String>)> {
    if args.machine.is_empty() {
        return Ok(Choice::defaults());
    }
    let choices: Vec<Choice> =
        args.machine.iter().map(|text| Choice::parse(text)).collect::<anyhow::Result<_>>()?;
    once("--machine", choices.iter().map(|choice| &choice.name))?;
    Ok((choices, vec![]))
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
    words.extend(args.view.given());
    words.extend(args.technology.given());
    words.extend(args.liberty.given());
    if args.warm_up > 0 {
        words.push(format!("--warm-up {}", args.warm_up));
    }
    words.join(" ")
}

/// Whether all is right, where everything is, and what is left out.
fn summary(args: &CompareArgs, comparison: &Comparison, pass: bool, left_out: &[String]) -> String {
    let result = comparison.approval().unwrap_or(not_right(pass));
    let mut text = format!("{result}\n\n");
    for (name, what) in [
        ("compare.html", "the figures with plots and images, for a browser"),
        ("compare.json", "the figures, with unit and meaning of each"),
        ("compare.csv", "the same as a table"),
    ] {
        text += &format!("  {:32} {what}\n", args.out.join(name).display());
    }
    if !left_out.is_empty() {
        let names: String = left_out.iter().map(|name| format!("  {name}\n")).collect();
        text += &format!("\nLeft out, unless --machine names them:\n{names}");
    }
    text
}
