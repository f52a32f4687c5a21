//! The measurements of seed document 003, made again: shading in several passes through F-buffers of all sizes.

mod claims;
mod figures;
mod page;
mod pictures;
mod plan;
mod runs;
mod sorting;

use super::ReproduceArgs;
use super::kept::Kept;
use super::results::Results;
use claims::claims;
use pellucid_testbench::output::OutputFolder;
use rayon::prelude::*;

/// All that was found.
struct Found {
    /// What came of frames in F-buffers.
    entries: Vec<runs::Entry>,
    /// What came of sorts.
    sorted: Vec<(sorting::Sorted, sorting::Run)>,
    /// Figure 1.
    overlap: [pictures::Overlap; 2],
}

/// Plays everything and leaves the figures; whether every image is right and every count its closed form.
pub(super) fn reproduce(args: &ReproduceArgs) -> anyhow::Result<bool> {
    let (plan, sorted) = (plan::plan(args.full), sorting::plan(args.full));
    let out = args.out();
    let _folder = OutputFolder::claim(&out)?;
    let number: usize = plan.iter().map(|planned| planned.buffers.len()).sum();
    let kept = Kept::new(&out, (number + sorted.len()) as u64, args.quiet);
    let entries: Vec<_> =
        plan.par_iter().map(|planned| runs::play(planned, &kept)).collect::<anyhow::Result<_>>()?;
    let sorted = sorting::play(sorted, &kept)?;
    let overlap = pictures::overlap()?;
    // Machines whose image or whose counts are not right have said so.
    let entries = entries.into_iter().collect::<Option<Vec<_>>>();
    let (Some(entries), Some(sorted), Some(overlap)) = (entries, sorted, overlap) else {
        return Ok(false);
    };
    kept.note();

    let all = Found { entries, sorted, overlap };
    let said = claims(&all);
    let command = format!("pellucid reproduce fbuffer{}", if args.full { " --full" } else { "" });
    let results = Results {
        name: "fbuffer",
        page: page::page(&command, &all, &said, &pictures::pictures()?),
        json: figures::json(&command, &all, &said),
        csv: figures::csv(&all),
        text: figures::text(&all, &said),
        exact: true,
    };
    results.leave(&out, args.json)?;
    Ok(true)
}
