//! The measurements of seed document 004, made again: images of up to 1024 frames by a buffer, by blending and by trees.

mod claims;
mod figures;
mod page;
mod pictures;
mod plan;
mod runs;

use super::ReproduceArgs;
use super::kept::Kept;
use super::results::Results;
use claims::claims;
use pellucid_testbench::output::OutputFolder;
use rayon::prelude::*;

/// Plays everything and leaves the figures; whether every image is right and every count its closed form.
pub(super) fn reproduce(args: &ReproduceArgs) -> anyhow::Result<bool> {
    let plan = plan::plan(args.full);
    let out = args.out();
    let _folder = OutputFolder::claim(&out)?;
    let number = plan.iter().map(|planned| planned.methods.len() as u64).sum();
    let kept = Kept::new(&out, number, args.quiet);
    let entries: Vec<_> =
        plan.par_iter().map(|planned| runs::play(planned, &kept)).collect::<anyhow::Result<_>>()?;
    // Machines whose image or whose counts are not right have said so.
    let Some(entries) = entries.into_iter().collect::<Option<Vec<_>>>() else { return Ok(false) };
    kept.note();

    let said = claims(&entries);
    let command =
        format!("pellucid reproduce accumulation{}", if args.full { " --full" } else { "" });
    let results = Results {
        name: "accumulation",
        page: page::page(&command, &entries, &said, &pictures::pictures(&plan)?),
        json: figures::json(&command, &entries, &said),
        csv: figures::csv(&entries),
        text: figures::text(&entries, &said),
        exact: true,
    };
    results.leave(&out, args.json)?;
    Ok(true)
}
