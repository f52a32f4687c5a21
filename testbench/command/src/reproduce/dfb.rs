//! The comparison of seed document 002, made again: the Dynamic Fragment Buffer beside fixed arrays and linked lists.

mod claims;
mod contender;
mod figures;
mod frames;
mod page;
mod plan;
mod runs;

use super::ReproduceArgs;
use crate::{quoted, say, tell};
use anyhow::bail;
use claims::claims;
use pellucid_testbench::output::{OutputError, OutputFolder, put};
use pellucid_testbench::scene::Options;
use pellucid_testbench::source::Source;
use runs::{Entry, Outcome, Runs};
use std::path::{Path, PathBuf};

/// Where the figures are, if nothing else is said.
const FOLDER: &str = "pellucid-reproduce";

/// Plays everything and leaves the figures; whether every image is right and every count its closed form.
pub(super) fn reproduce(args: &ReproduceArgs) -> anyhow::Result<bool> {
    let sizes = if args.full { plan::FULL } else { plan::QUICK };
    let mesh = args.scene.as_deref();
    if let Some(name) = mesh
        && Source::open(name, &Options::default())?.contents().is_none()
    {
        bail!(
            "--scene {name}: expected a mesh, `glass`, `teapot` or `plant`, round which a camera can go"
        );
    }
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from(FOLDER));
    let _folder = OutputFolder::claim(&out)?;
    let plan = plan::plan(&sizes, mesh);
    let runs = Runs::new(&out, &plan, args.quiet);
    let Some(entries) = runs.play()? else { return Ok(false) };
    if runs.kept() > 0 && !args.quiet {
        let (kept, folder) = (runs.kept(), runs.folder().display());
        tell(&format!(
            "note: {kept} runs are those of an earlier time; without `{folder}` they are made again"
        ));
    }
    let inexact: Vec<String> = entries.iter().flat_map(inexact).collect();
    inexact.iter().for_each(|sentence| tell(&format!("error: {sentence}")));
    let exact = inexact.is_empty();

    let claims = claims(&entries);
    let mut command = String::from("pellucid reproduce dfb");
    if args.full {
        command += " --full";
    }
    if let Some(mesh) = mesh {
        command += &format!(" --scene {}", quoted(mesh));
    }
    let json = figures::json(&command, &entries, &claims);
    let path = out.join("dfb.html");
    let page = page::page(&command, &sizes, &entries, &claims);
    put(&path, &page.map_err(|error| OutputError::write(&path, &error))?)?;
    put(&out.join("dfb.json"), &format!("{json:#}\n"))?;
    put(&out.join("dfb.csv"), &figures::csv(&entries))?;
    if args.json {
        say(&format!("{json:#}\n"))?;
    } else {
        say(&format!("{}\n{}", figures::text(&entries, &claims), files(&out, exact)))?;
    }
    Ok(exact)
}

/// What is wrong with the memory that machines have counted, by the paper's formulas: a machine that is given no more than it
/// needs uses all of it. In a list frames that were sent again meet final depths, so that it may need less.
fn inexact(entry: &Entry) -> Vec<String> {
    let machines = entry.frames.contenders.iter().zip(&entry.outcomes);
    let wrong = machines.filter_map(|(machine, outcome)| {
        let Outcome::Run(run) = outcome else { return None };
        let (found, expected) = (run.bytes, machine.bytes(&entry.need));
        let again = run.plays() > u64::from(entry.frames.count()) && machine.arch == "ppll";
        let right = if again { found <= expected } else { found == expected };
        let (name, frames) = (machine.name, entry.frames.arguments());
        (machine.is_filled() && !right)
            .then(|| format!("{name} on {frames}: {found} bytes, expected {expected}"))
    });
    wrong.collect()
}

/// Whether all is right, and where everything is.
fn files(out: &Path, exact: bool) -> String {
    let mut text = String::from(if exact {
        "Every image is right, and every count its closed form.\n\n"
    } else {
        "Not every count is its closed form: see what is said on standard error.\n\n"
    });
    for (name, what) in [
        ("dfb.html", "the paper's figures with plots, for a browser"),
        ("dfb.json", "the same for programs, with the command of every run"),
        ("dfb.csv", "every run and each of its frames as a table"),
        ("runs", "what every run counted; what is there is not run again"),
    ] {
        text += &format!("  {:32} {what}\n", out.join(name).display());
    }
    text
}
