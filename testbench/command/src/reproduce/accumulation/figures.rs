//! The figures as text, JSON and CSV.

use super::claims::{papers_bound, printed, ratio, table};
use super::plan::{COLUMNS, Figure, Method, TREES};
use super::runs::{Entry, Run};
use crate::reproduce::claims::{self, Claim};
use crate::reproduce::number;
use crate::reproduce::price::Price;
use comfy_table::{Table, presets};
use pellucid_testbench::report::{align_right, at_margin, csv_text};
use serde_json::{Value as Json, json};

/// The columns of [`times`] after the first: cycles by each method, and for each tree how many times those of blending, here and as
/// printed.
pub fn times_head() -> Vec<String> {
    let methods = COLUMNS.map(|method| method.to_string());
    let ratios = TREES.iter().flat_map(|tree| [format!("{tree} / blend"), "printed".to_string()]);
    methods.into_iter().chain(ratios).collect()
}

/// A row of Table 1, a cell for each of [`times_head`].
pub fn times(entry: &Entry) -> Vec<String> {
    let cycles = |method| entry.run(method).map_or(String::new(), |run| number(run.cycles));
    let shown = |ratio: Option<f64>| ratio.map_or(String::new(), |ratio| format!("{ratio:.2}"));
    let ratios = TREES
        .into_iter()
        .flat_map(|tree| [shown(ratio(entry, tree)), shown(printed(tree, entry.frames.count()))]);
    COLUMNS.map(cycles).into_iter().chain(ratios).collect()
}

/// The columns of [`counts`] after the first.
pub fn counts_head() -> Vec<String> {
    let of = |tree: &Method| {
        ["passes", "planes", "error", "bound"].map(|what| format!("{tree}: {what}"))
    };
    let blend = ["error", "bound"].map(|what| format!("blend: {what}"));
    TREES.iter().flat_map(of).chain(blend).collect()
}

/// Passes, planes and errors of an entry, a cell for each of [`counts_head`].
pub fn counts(entry: &Entry) -> Vec<String> {
    let tree = |tree| {
        entry.run(tree).map_or([const { String::new() }; 4], |run| {
            [run.passes, run.planes, run.error, run.bound].map(number)
        })
    };
    let blend = entry.run(Method::Blend);
    let blend =
        blend.map_or([const { String::new() }; 2], |run| [run.error, run.bound].map(number));
    TREES.into_iter().flat_map(tree).chain(blend).collect()
}

/// The columns of [`costs`] after the first.
pub fn costs_head() -> Vec<String> {
    let of =
        |method: &Method| [format!("{method}: nJ a frame"), format!("{method}: memories, mm2")];
    COLUMNS.iter().flat_map(of).collect()
}

/// Reads and writes of memories on the chip and their area, a cell for each of [`costs_head`].
pub fn costs(entry: &Entry) -> Vec<String> {
    let of = |method| {
        entry.run(method).map_or([const { String::new() }; 2], |run| {
            [run.price.accesses_nj, run.price.area_mm2].map(Price::shown)
        })
    };
    COLUMNS.into_iter().flat_map(of).collect()
}

/// What a table of [`times`] is called.
pub fn head(entries: &[Entry]) -> String {
    let frames = table(entries).next().map(|entry| &entry.frames);
    let of =
        frames.map_or(String::new(), |frames| format!(" of {} at {}", frames.scene, frames.size()));
    format!("Table 1: cycles of an image{of}")
}

/// Everything as text: the tables and the claims.
pub fn text(entries: &[Entry], said: &[Claim]) -> String {
    let shown = |heads: Vec<String>, row: fn(&Entry) -> Vec<String>| {
        let mut shown = Table::new();
        shown.load_style(presets::NOTHING);
        let columns = heads.len();
        shown.add_row(["  N".to_string()].into_iter().chain(heads));
        for entry in table(entries) {
            let frames = format!("  {}", entry.frames.count());
            shown.add_row([frames].into_iter().chain(row(entry)));
        }
        align_right(&mut shown, &(1..=columns).collect::<Vec<_>>());
        at_margin(&shown.to_string())
    };
    format!(
        "{}\n{}\nPASSES, PLANES AND LEVELS OF 255\n{}\nREADS AND WRITES, AND AREA\n{}\n{}",
        head(entries),
        shown(times_head(), times),
        shown(counts_head(), counts),
        shown(costs_head(), costs),
        claims::text(said)
    )
}

/// The part of the paper that frames are for.
fn figure(figure: Figure) -> &'static str {
    match figure {
        Figure::Table => "Table 1",
        Figure::Equal => "Figure 3",
    }
}

/// Everything as JSON.
pub fn json(command: &str, entries: &[Entry], claims: &[Claim]) -> Json {
    let claims: Vec<Json> = claims.iter().map(Claim::json).collect();
    let frames = entries.iter().map(|entry| {
        let count = entry.frames.count();
        let is_table = entry.figure == Figure::Table;
        let runs = entry.runs.iter().map(|(method, run)| {
            json!({
                "method": method.to_string(),
                "command": run.command,
                "cycles": run.cycles,
                "of_blending": {
                    "counted": ratio(entry, *method),
                    "printed": printed(*method, count).filter(|_| is_table),
                },
                "passes": { "counted": run.passes, "closed_form": method.passes(count) },
                "planes": { "counted": run.planes, "closed_form": method.planes(count) },
                "sweeps": run.sweeps,
                "error": { "counted": run.error, "bound": run.bound },
                "costs": run.price.json(),
            })
        });
        let (width, height) = entry.frames.screen;
        json!({
            "figure": figure(entry.figure),
            "scene": entry.frames.scene,
            "width": width,
            "height": height,
            "frames": count,
            "papers_bound": papers_bound(count),
            "runs": runs.collect::<Vec<_>>(),
        })
    });
    json!({ "command": command, "claims": claims, "frames": frames.collect::<Vec<_>>() })
}

/// Every run as a line.
pub fn csv(entries: &[Entry]) -> String {
    let mut text = format!(
        "figure,scene,width,height,frames,method,cycles,of_blending,printed_of_blending,passes,planes,sweeps,error,bound,{}\n",
        Price::COLUMNS
    );
    for entry in entries {
        let (width, height) = entry.frames.screen;
        let (figure, scene) = (figure(entry.figure), csv_text(&entry.frames.scene));
        let count = entry.frames.count();
        for (method, run) in &entry.runs {
            let Run { cycles, passes, planes, sweeps, error, bound, .. } = run;
            let shown =
                |ratio: Option<f64>| ratio.map_or(String::new(), |ratio| format!("{ratio:.4}"));
            let printed = printed(*method, count).filter(|_| entry.figure == Figure::Table);
            text += &format!(
                "{figure},{scene},{width},{height},{count},{method},{cycles},{},{},{passes},{planes},{sweeps},{error},{bound},{}\n",
                shown(ratio(entry, *method)),
                shown(printed),
                run.price.csv(),
            );
        }
    }
    text
}
