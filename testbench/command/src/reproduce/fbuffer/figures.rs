//! The figures as text, JSON and CSV.

use super::claims::printed;
use super::plan::{Buffer, Figure, PASSES};
use super::runs::{Entry, Run, Terms};
use super::{Found, sorting};
use crate::reproduce::claims::{self, Claim};
use crate::reproduce::number;
use crate::reproduce::price::Price;
use comfy_table::{Table, presets};
use pellucid_testbench::report::{align_right, at_margin, csv_text};
use serde_json::{Value as Json, json};

/// What the columns of [`row`] are.
pub const COLUMNS: [&str; 8] = [
    "buffer",
    "windows",
    "submissions",
    "closed form",
    "printed",
    "vertices",
    "cycles",
    "larger term",
];

/// A run as a table shows it.
pub fn row(entry: &Entry, buffer: Buffer, run: &Run) -> [String; 8] {
    let closed_form = PASSES * run.fragments.div_ceil(buffer.places());
    [
        format!("{0}x{0}", buffer.size),
        number(run.windows),
        number(run.submissions),
        number(closed_form),
        printed(entry, buffer).map_or(String::new(), number),
        number(run.vertices),
        number(run.cycles),
        number(Terms::of(buffer, run).larger()),
    ]
}

/// Frames as a table's head names them.
pub fn head(entry: &Entry) -> String {
    let fragments = entry.runs.first().map_or(0, |(_, run)| run.fragments);
    let Entry { figure, frames, .. } = entry;
    let what = format!("{} at {}, {} fragments", frames.scene, frames.size(), number(fragments));
    format!("{}: {what}", self::figure(*figure))
}

/// Frames whose submissions are of interest.
pub fn submissions(entries: &[Entry]) -> impl Iterator<Item = &Entry> {
    entries.iter().filter(|entry| entry.figure != Figure::Memory)
}

/// Everything as text: a table for each set of frames, and the claims.
pub fn text(all: &Found, said: &[Claim]) -> String {
    let mut text = String::new();
    for entry in submissions(&all.entries) {
        let rows = entry.runs.iter().map(|(buffer, run)| row(entry, *buffer, run));
        text += &table(&head(entry), COLUMNS, rows);
    }
    for sorting::Rows { head, rows } in sorting::rows(&all.sorted) {
        text += &table(head, sorting::COLUMNS, rows);
    }
    text + &claims::text(said)
}

/// A table of numbers below its head.
fn table(head: &str, columns: [&str; 8], rows: impl IntoIterator<Item = [String; 8]>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_row(columns);
    for [first, counts @ ..] in rows {
        // What is indented stands below its head.
        table.add_row([format!("  {first}")].into_iter().chain(counts));
    }
    align_right(&mut table, &[1, 2, 3, 4, 5, 6, 7]);
    format!("{head}\n{}\n", at_margin(&table.to_string()))
}

/// The part of the paper that frames are for.
fn figure(figure: Figure) -> &'static str {
    match figure {
        Figure::View => "Figure 3",
        Figure::Counts => "Section 4",
        Figure::Rates => "Figure 4",
        Figure::Memory => "Section 3.1",
    }
}

/// Everything as JSON.
pub fn json(command: &str, all: &Found, claims: &[Claim]) -> Json {
    let claims: Vec<Json> = claims.iter().map(Claim::json).collect();
    let frames = all.entries.iter().map(|entry| {
        let runs = entry.runs.iter().map(|(buffer, run)| {
            let terms = Terms::of(*buffer, run);
            json!({
                "size": buffer.size,
                "targets": buffer.targets,
                "vertex_cycles": buffer.vertex_cycles,
                "fragment_cycles": buffer.fragment_cycles,
                "command": run.command,
                "bytes": run.bytes,
                "fragments": run.fragments,
                "windows": run.windows,
                "submissions": {
                    "counted": run.submissions,
                    "closed_form": PASSES * run.fragments.div_ceil(buffer.places()),
                    "printed": printed(entry, *buffer),
                },
                "vertices": run.vertices,
                "shaded": run.shaded,
                "discarded": run.discarded,
                "cycles": {
                    "counted": run.cycles,
                    "vertices": terms.vertices,
                    "fragments": terms.fragments,
                },
                "costs": run.price.json(),
            })
        });
        let (width, height) = entry.frames.screen;
        json!({
            "figure": figure(entry.figure),
            "scene": entry.frames.scene,
            "width": width,
            "height": height,
            "camera": entry.frames.camera.map(|camera| camera.to_string()),
            "runs": runs.collect::<Vec<_>>(),
        })
    });
    let overlap = all.overlap.iter().map(|of| {
        json!({ "store": of.store, "overlapping_pixels": of.overlapping, "wrong_pixels": of.wrong })
    });
    json!({
        "command": command,
        "claims": claims,
        "figure_1": overlap.collect::<Vec<_>>(),
        "frames": frames.collect::<Vec<_>>(),
        "sorts": sorting::json(&all.sorted),
    })
}

/// Every run as a line.
pub fn csv(all: &Found) -> String {
    let mut text = format!(
        "figure,scene,width,height,size,targets,vertex_cycles,fragment_cycles,fragments,windows,submissions,printed,vertices,\
         shaded,discarded,cycles,vertex_term,fragment_term,bytes,{},sort_passes,sort_cycles\n",
        Price::COLUMNS
    );
    for entry in &all.entries {
        let (width, height) = entry.frames.screen;
        let (figure, scene) = (figure(entry.figure), csv_text(&entry.frames.scene));
        for (buffer, run) in &entry.runs {
            let Buffer { size, targets, vertex_cycles, fragment_cycles } = buffer;
            let Run { cycles, fragments, windows, submissions, vertices, .. } = run;
            let Run { shaded, discarded, bytes, .. } = run;
            let printed = printed(entry, *buffer).map_or(String::new(), |n| n.to_string());
            let terms = Terms::of(*buffer, run);
            text += &format!(
                "{figure},{scene},{width},{height},{size},{targets},{vertex_cycles},{fragment_cycles},{fragments},{windows},\
                 {submissions},{printed},{vertices},{shaded},{discarded},{cycles},{},{},{bytes},{},,\n",
                terms.vertices,
                terms.fragments,
                run.price.csv()
            );
        }
    }
    text + &sorting::csv(&all.sorted)
}
