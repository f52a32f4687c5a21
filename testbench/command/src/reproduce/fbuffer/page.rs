//! The figures as a page.

use super::claims::rates;
use super::figures::{COLUMNS, head, row, submissions};
use super::pictures::{Overlap, Picture};
use super::plan::{Buffer, Figure, SPHERES};
use super::runs::{Entry, Run, Terms};
use super::{Found, sorting};
use crate::reproduce::claims::{self, Claim};
use crate::reproduce::number;
use pellucid_testbench::html::{cells, escaped, figure, legend, page as whole, plot};
use pellucid_testbench::plots::lines;
use std::io;

/// The page.
///
/// # Errors
/// A plot or a picture cannot be made.
pub fn page(
    command: &str,
    Found { entries, sorted, overlap }: &Found,
    said: &[Claim],
    pictures: &[Picture],
) -> io::Result<String> {
    let about = "What <em>The hardware F-Buffer</em> (M. Houston, A. J. Preetham and M. Segal) measures, made again with a clocked machine: \
                 cycles where the paper has the rate of a graphics card of 2004. Every image was equal to the golden model's, which \
                 shades each fragment at once. A smaller screen stands for the paper's with a buffer that is smaller by as much, and so has \
                 as many windows.";
    let mut body = claims::html(said);
    body += &tables(entries);
    body += &figure_1(overlap)?;
    body += "<h2>Figure 2: what lies where</h2>\n<p>Fragments in the order in which they come, row by row; of those that do \
             not fit the first window is shown.</p>\n<div class=\"plots\">\n";
    for picture in pictures {
        body += &figure(&picture.image, &picture.caption)?;
    }
    body += "</div>\n";
    body += &figure_4(entries)?;
    body += &sorts(sorted)?;
    body += &memory(entries);
    Ok(whole("The F-buffer", about, command, &body))
}

fn tables(entries: &[Entry]) -> String {
    let mut text = String::from(
        "<h2>How often geometry is sent</h2>\n<p>The larger term is what vertices take, or what fragments take, in cycles.</p>\n",
    );
    for entry in submissions(entries) {
        text += &format!("<h3>{}</h3>\n<table>\n{}", escaped(&head(entry)), cells("th", COLUMNS));
        for (buffer, run) in &entry.runs {
            let row = row(entry, *buffer, run);
            text += &cells("td", row.iter().map(String::as_str));
        }
        text += "</table>\n";
    }
    text
}

fn figure_1(overlap: &[Overlap; 2]) -> io::Result<String> {
    let mut text = String::from(
        "<h2>Figure 1: two triangles in two passes</h2>\n<p>A cyan one behind a yellow one, each half transparent. The first pass stores \
         the colour, the second one takes it from there and blends.</p>\n<div class=\"plots\">\n",
    );
    for Overlap { store, wrong, overlapping, image } in overlap {
        let caption = format!(
            "store={store}: {wrong} pixels are wrong, of {overlapping} in which the triangles overlap"
        );
        text += &figure(image, &caption)?;
    }
    Ok(text + "</div>\n")
}

fn sorts(sorted: &[(sorting::Sorted, sorting::Run)]) -> io::Result<String> {
    let mut text = String::from(
        "<h2>Sorted transparency</h2>\n<p>A bitonic sort over the F-buffer, four compare-exchanges a cycle; the closed form of a sort \
         of n fragments, padded to 2^k, is k (k + 1) / 2 passes of 2^k / 8 + 1 cycles, n to give them, and 2.</p>\n",
    );
    for sorting::Rows { head, rows } in sorting::rows(sorted) {
        text += &format!("<h3>{}</h3>\n<table>\n{}", escaped(head), cells("th", sorting::COLUMNS));
        for row in rows {
            text += &cells("td", row.iter().map(String::as_str));
        }
        text += "</table>\n";
    }
    let (labels, series) = sorting::series(sorted);
    let svg = lines(&labels, &series, ("fragments that fit", "cycles of the sort for each"), &[])?;
    Ok(text
        + &legend(["counted", "closed form"])
        + &plot(&svg, "The closed form lies on what is counted."))
}

/// Frames in a thousand million cycles.
fn rate(cycles: u64) -> f64 {
    1e9 / cycles as f64
}

fn figure_4(entries: &[Entry]) -> io::Result<String> {
    let names = SPHERES.iter().flat_map(|s| [s.to_string(), format!("{s}, closed form")]);
    let names: Vec<String> = names.collect();
    let sizes: Vec<u32> =
        rates(entries, SPHERES[0]).iter().map(|(buffer, _)| buffer.size).collect();
    let mut series: Vec<Vec<f64>> = vec![];
    for sphere in SPHERES {
        let runs = rates(entries, sphere);
        // A size that was not played has no point.
        let over_sizes = |cycles: &dyn Fn(Buffer, &Run) -> u64| {
            let of = |size: &u32| {
                let run = runs.iter().find(|(buffer, _)| buffer.size == *size);
                run.map_or(f64::NAN, |(buffer, run)| rate(cycles(*buffer, run)))
            };
            sizes.iter().map(of).collect()
        };
        series.push(over_sizes(&|_, run| run.cycles));
        series.push(over_sizes(&|buffer, run| Terms::of(buffer, run).larger()));
    }
    let labels: Vec<String> = sizes.iter().map(ToString::to_string).collect();
    let up = "frames in 10^9 cycles";
    let svg = lines(&labels, &series, ("side of the buffer", up), &[])?;
    Ok(format!(
        "<h2>Figure 4: rate over the size of the buffer</h2>\n{}{}",
        legend(names.iter().map(String::as_str)),
        plot(&svg, "Closed form: the larger of what vertices and what fragments take.")
    ))
}

fn memory(entries: &[Entry]) -> String {
    let mut text = String::from("<h2>Memory</h2>\n<table>\n");
    text += &cells("th", ["buffer", "targets of four floats", "bytes", "MiB"]);
    for entry in entries.iter().filter(|entry| entry.figure == Figure::Memory) {
        for (buffer, run) in &entry.runs {
            let size = format!("{0}x{0}", buffer.size);
            let mib = (run.bytes >> 20).to_string();
            text += &cells("td", [&*size, &buffer.targets.to_string(), &number(run.bytes), &mib]);
        }
    }
    text + "</table>\n"
}
