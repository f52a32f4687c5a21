//! `pellucid explore`: a study, which answers what to build.

mod criteria;
mod designs;
mod dialogue;
mod genetic;
mod page;
#[cfg(feature = "parquet")]
mod parquet;
mod points;
mod reading;
mod results;
mod space;
mod standing;
mod study;
mod work;
mod workers;

use super::sequence::Opened;
use super::{quoted, say, tell};
use anyhow::{Context, bail};
use clap::Args;
use comfy_table::Table;
use designs::{Design, Searcher};
use pellucid_machine::params::{did_you_mean, nearest};
use pellucid_machine::pixel::Screen;
use pellucid_testbench::output::{OutputFolder, create_dir};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::Case;
use points::{Points, Status, figures};
use rayon::ThreadPoolBuilder;
use reading::{File, StudyError};
use standing::{Standing, small, standings};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use study::{Method, Study};
use work::{Candidate, Share, Work};
use workers::Workers;

/// A study that says what can stand in one.
const EXAMPLE: &str = include_str!("explore/example.toml");

#[derive(Args)]
pub(super) struct ExploreArgs {
    /// The study: scenes, machines with what their parameters may be, what must hold, and what counts
    #[arg(value_name = "STUDY.toml", required_unless_present = "example")]
    study: Option<PathBuf>,
    /// Only print a study with comments, to begin with
    #[arg(long)]
    example: bool,
    /// The folder for explore.html, points.csv, points.jsonl and columns.json
    #[arg(long, default_value = "pellucid-explore", value_name = "DIR")]
    out: PathBuf,
    /// The folder in which points are kept, each under a hash of all that it depends on; several studies may share it, at the same
    /// time too [default: `points` in the folder of --out]
    #[arg(long, value_name = "DIR")]
    points: Option<PathBuf>,
    /// Run nothing: show what is kept
    #[arg(long, conflicts_with = "ask_tell")]
    front: bool,
    /// Run what another program asks for on standard input, a design a line as JSON, and answer each with its objectives: see the
    /// book. `search` of the study does not count
    #[arg(long)]
    ask_tell: bool,
    /// Let these run the points, each a share of them, with `pellucid run-point`; all must see the folder of points. What was
    /// stopped goes on with the same command
    #[arg(long, value_enum, value_name = "SCHEDULER", conflicts_with_all = ["front", "ask_tell"])]
    workers: Option<Workers>,
    /// How many shares the points are cut into for workers: many more than there are workers keep all of them busy to the end
    #[arg(long, default_value_t = 64, value_name = "NUMBER", requires = "workers", value_parser = clap::value_parser!(u16).range(1..))]
    shares: u16,
    /// Print nothing but errors and warnings
    #[arg(long, short)]
    quiet: bool,
}

/// How often results are written while work goes on.
const EVERY: Duration = Duration::from_secs(10);
/// The folder for what workers say, in the folder of results.
const LOG: &str = "shares";

#[derive(Args)]
pub(super) struct RunPointArgs {
    /// The study
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
    /// The folder in which points are kept, which all that work on the study share
    #[arg(long, value_name = "DIR")]
    points: PathBuf,
    /// Which share of the points, as `3/16`; every share is run by somebody, in any order, more than once if need be
    #[arg(long, value_name = "NUMBER/SHARES")]
    share: Share,
    /// How many points are run at the same time, each on a core
    #[arg(long, default_value_t = 1, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// Show no sign of progress
    #[arg(long, short)]
    quiet: bool,
}

/// Runs a share of the points of a study; always done, since a point that fails is a result.
pub(super) fn run_point(args: &RunPointArgs) -> anyhow::Result<bool> {
    let study = Study::read(&File::read(&args.study)?)?;
    let (mut searcher, sources, designs) = opened(&study)?;
    let points = Points::new(&args.points)?;
    let mut work = Work::new(&study, &points, sources);
    // Of a search by generations, all that are kept and the first that is not.
    generations(&study, &mut searcher, &mut work, designs, |_| Ok(()))?;
    work.keep_to(args.share);
    let threads = ThreadPoolBuilder::new().num_threads(args.threads.into()).build();
    threads
        .context("this computer has no more threads")?
        .install(|| work.run(args.quiet, |_| Ok(())))?;
    if !args.quiet {
        say(&format!("{} points were run.\n", work.run))?;
    }
    Ok(true)
}

/// Takes up the designs of a search, generation by generation: each has `run` done, and the next one comes if nothing is left
/// to do of it.
fn generations<'a>(
    study: &Study,
    searcher: &mut Searcher,
    work: &mut Work<'a>,
    mut designs: Vec<Design>,
    run: impl Fn(&mut Work<'a>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    while !designs.is_empty() {
        designs.into_iter().for_each(|design| work.add(design));
        run(work)?;
        if work.left() > 0 {
            break;
        }
        let candidates = &work.candidates;
        designs =
            searcher.next(|number| small(study, &Standing::of(study, &candidates[number])))?;
    }
    Ok(())
}

/// A study that is right, with its scenes and its first designs.
fn opened(study: &Study) -> anyhow::Result<(Searcher<'_>, Vec<Opened>, Vec<Design>)> {
    let sources: Vec<Opened> =
        study.scenes.iter().map(study::Scene::open).collect::<anyhow::Result<_>>()?;
    let screen = sources[0].0.screen();
    designs::check(&study.families, screen)?;
    let mut searcher = Searcher::new(study);
    // Nothing is known of any design yet.
    let designs = searcher.next(|_| None)?;
    check_figures(study, &designs, screen)?;
    Ok((searcher, sources, designs))
}

/// Explores; whether a design is on the front and none is wrong.
pub(super) fn explore(args: &ExploreArgs) -> anyhow::Result<bool> {
    let Some(path) = args.study.as_ref().filter(|_| !args.example) else {
        say(EXAMPLE)?;
        return Ok(true);
    };
    let study = Study::read(&File::read(path)?)?;
    let (mut searcher, sources, designs) = opened(&study)?;

    let _folder = OutputFolder::claim(&args.out)?;
    let folder = args.points.clone().unwrap_or_else(|| args.out.join("points"));
    let points = Points::new(&folder)?;
    let others = points.of_others();
    if others > 0 {
        tell(&format!(
            "note: {others} files of other versions beside `{}` are left alone",
            points.folder().display()
        ));
    }
    let mut work = Work::new(&study, &points, sources);
    let mut command = format!("pellucid explore {}", quoted(&path.display().to_string()));
    if let Some(points) = &args.points {
        command += &format!(" --points {}", quoted(&points.display().to_string()));
    }
    let write = |candidates: &[Candidate], standings: &[(Standing, bool)]| {
        results::write(&args.out, &command, &study, &points, candidates, standings)
    };
    let due = Mutex::new(Instant::now() + EVERY);
    let seen = |candidates: &[Candidate]| {
        if let Ok(mut due) = due.lock()
            && Instant::now() >= *due
        {
            let start = Instant::now();
            write(candidates, &standings(&study, candidates))?;
            // What takes long is not done often.
            *due = Instant::now() + EVERY.max(20 * start.elapsed());
        }
        Ok(())
    };
    if args.ask_tell {
        let mut searcher = Searcher::new(&study);
        let lines = std::io::stdin().lock();
        let run = |work: &mut Work| work.run(args.quiet, seen);
        dialogue::answer(&study, &mut searcher, &mut work, lines, run)?;
        write(&work.candidates, &standings(&study, &work.candidates))?;
        return Ok(true);
    }
    generations(&study, &mut searcher, &mut work, designs, |work| match args.workers {
        _ if args.front || work.left() == 0 => Ok(()),
        None => work.run(args.quiet, seen),
        Some(workers) => {
            let log = args.out.join(LOG);
            create_dir(&log)?;
            let shares = work.points().min(args.shares.into());
            let mut child = workers.start(path, &folder, shares, &log)?;
            let ended = || {
                let status = child.try_wait().context("the workers cannot be waited for")?;
                Ok(status.is_some())
            };
            work.wait(ended, args.quiet, seen)
        }
    })?;
    let left = if args.front { 0 } else { work.left() };
    let (found, asked) = (work.candidates.len(), study.search.designs);
    if study.search.method != Method::Grid && found < asked && !args.front {
        tell(&format!("note: only {found} different designs were found, and not {asked}"));
    }
    let standings = standings(&study, &work.candidates);
    write(&work.candidates, &standings)?;
    if !args.quiet {
        say(&results::table(&study, &work.candidates, &standings, Table::new().width()))?;
        say(&summary(args, &study, &work, &standings, &points))?;
    }
    let wrong = |candidate: &Candidate| {
        candidate.outcomes.iter().flatten().any(|outcome| outcome.status == Status::Wrong)
    };
    for candidate in work.candidates.iter().filter(|candidate| wrong(candidate)) {
        tell(&format!("error: {}: the result is wrong", candidate.design.choice.name));
    }
    if left > 0 {
        tell(&format!(
            "error: {} not run: the shares that failed have said why in `{}`; the same command goes on",
            number(left, "point") + if left == 1 { " was" } else { " were" },
            args.out.join(LOG).display()
        ));
    }
    let any = standings.iter().any(|(_, front)| *front);
    if !any && left == 0 && !args.front {
        tell("error: no design is left: see `reason` in points.csv");
    }
    Ok(any && left == 0 && !work.candidates.iter().any(wrong))
}

/// So many of something.
fn number(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// How many designs and points there are, what became of them, and where everything is.
fn summary(
    args: &ExploreArgs,
    study: &Study,
    work: &Work,
    standings: &[(Standing, bool)],
    points: &Points,
) -> String {
    let count = |of: &dyn Fn(&Standing) -> bool| standings.iter().filter(|(s, _)| of(s)).count();
    let inside = count(&|standing| matches!(standing, Standing::In(_)));
    let out = count(&|standing| matches!(standing, Standing::Out { .. }));
    let front = standings.iter().filter(|(_, front)| *front).count();
    let mut text = format!(
        "\n{} on {}: {front} on the front, {inside} that hold all constraints, {out} out. {} points were \
         run, {} were kept",
        number(work.candidates.len(), "design"),
        number(study.scenes.len(), "scene"),
        work.run,
        work.kept,
    );
    match args.front {
        true => text += &format!(", {} are left to run.\n\n", work.left()),
        false => text += ".\n\n",
    }
    let mut kinds: Vec<(usize, &String)> = vec![];
    for (standing, _) in standings {
        let Standing::Out { kind, .. } = standing else { continue };
        match kinds.iter_mut().find(|(_, known)| *known == kind) {
            Some((count, _)) => *count += 1,
            None => kinds.push((1, kind)),
        }
    }
    if !kinds.is_empty() {
        let each: Vec<String> =
            kinds.iter().map(|(count, kind)| format!("{count} {kind}")).collect();
        text += &format!("Out are: {}.\n\n", each.join(", "));
    }
    for (name, what) in results::FILES {
        text += &format!("  {:32} {what}\n", args.out.join(name).display());
    }
    text + &format!("  {:32} every point, for this study and others\n", points.folder().display())
}

/// Every figure that the study names is one that a design of it has. They are looked up in runs of an empty frame.
fn check_figures(study: &Study, designs: &[Design], screen: Screen) -> anyhow::Result<()> {
    let named = study.constraints.iter().map(|c| (&c.figure, &c.place));
    let named = named.chain(study.objectives.iter().map(|o| (&o.figure, &o.place)));
    let mut unknown: Vec<(&String, &String)> = named.collect();
    let mut known: BTreeSet<String> = BTreeSet::new();
    let mut seen: Vec<(usize, Vec<&String>)> = vec![];
    for design in designs.iter().filter(|design| design.refused.is_none()) {
        unknown.retain(|(figure, _)| !known.contains(*figure));
        if unknown.is_empty() {
            return Ok(());
        }
        // Which figures there are depends on names, not on numbers.
        let settings = design.choice.settings.iter().map(|setting| &setting.value);
        let names = settings.filter(|value| value.parse::<f64>().is_err());
        let kind = (design.family, names.collect());
        if seen.contains(&kind) {
            continue;
        }
        let Ok(machine) = design.choice.build(screen) else { continue };
        seen.push(kind);
        let mut progress = Progress::new("", None, true);
        let source = Source::Fragments(screen, vec![]);
        let case = Case::new("nothing", source, &*machine, &mut progress)?;
        if let Ok(trial) = case.run(design.choice.arch.name, &*machine, None, &mut progress) {
            known.extend(figures(&trial.report.json()).into_iter().map(|(name, _)| name));
        }
    }
    unknown.retain(|(figure, _)| !known.contains(*figure));
    let Some((figure, place)) = unknown.first() else { return Ok(()) };
    if known.is_empty() {
        bail!("no design of this study can be built: see `pellucid list` for parameters");
    }
    let hint = did_you_mean(&nearest(figure, known.iter().map(String::as_str)));
    let all: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
    let problem = format!("unknown figure `{figure}`{hint}; known are {}", all.join(", "));
    Err(StudyError::Line { place: place.to_string(), problem }.into())
}
