//! The comparison of seed document 002, made again: the Dynamic Fragment Buffer beside fixed arrays and linked lists.

mod claims;
mod contender;
mod figures;
mod need;
mod page;
mod plan;
mod runs;

use super::ReproduceArgs;
use super::kept::Kept;
use super::results::Results;
use crate::{quoted, tell};
use anyhow::bail;
use claims::claims;
use pellucid_testbench::output::OutputFolder;
use pellucid_testbench::scene::Options;
use pellucid_testbench::source::Source;
use runs::{Entry, Outcome};

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
    let out = args.out();
    let _folder = OutputFolder::claim(&out)?;
    let plan = plan::plan(&sizes, mesh);
    let runs = plan.iter().map(|planned| planned.contenders.len() as u64).sum();
    let kept = Kept::new(&out, runs, args.quiet);
    let Some(entries) = runs::play(&plan, &kept)? else { return Ok(false) };
    kept.note();
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
    let results = Results {
        name: "dfb",
        page: page::page(&command, &sizes, &entries, &claims),
        csv: figures::csv(&entries),
        text: figures::text(&entries, &claims),
        json,
        exact,
    };
    results.leave(&out, args.json)?;
    Ok(exact)
}

/// What is wrong with the memory that machines have counted, by the paper's formulas: a machine that is given no more than it
/// needs uses all of it. In a list frames that were sent again meet final depths, so that it may need less.
fn inexact(entry: &Entry) -> Vec<String> {
    let machines = entry.contenders.iter().zip(&entry.outcomes);
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
