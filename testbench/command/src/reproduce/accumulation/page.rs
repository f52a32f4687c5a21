//! The figures as a page.

use super::claims::{papers_bound, table};
use super::figures::{costs, costs_head, counts, counts_head, head, times, times_head};
use super::pictures::Picture;
use super::plan::{COLUMNS, Method, TREES};
use super::runs::{Entry, Run};
use crate::reproduce::claims::{self, Claim};
use pellucid_testbench::html::{cells, escaped, figure, legend, page as whole, plot};
use pellucid_testbench::plots::lines;
use std::io;

/// The page.
///
/// # Errors
/// A plot or a picture cannot be made.
pub fn page(
    command: &str,
    entries: &[Entry],
    said: &[Claim],
    pictures: &[Vec<Picture>],
) -> io::Result<String> {
    let about = "What <em>Accumulation trees</em> measures, made again with a clocked machine: cycles where the paper has the rate of a \
                 graphics card of 2002. Every image was equal to the golden model's of its method. Trees are as the paper has them, each node \
                 in a sweep of its own; those <em>in one sweep</em> compute their nodes as frames come.";
    let mut body = claims::html(said);
    body += &format!("<h2>{}</h2>\n", escaped(&head(entries)));
    body += &rows(entries, &times_head(), times);
    body += &of_methods(entries)?;
    body += "<h2>Passes, planes and levels</h2>\n<p>An error is the farthest that a channel is from the exact mean, in levels of 255; \
             its bound is what the machine's arithmetic allows.</p>\n";
    body += &rows(entries, &counts_head(), counts);
    body += &errors(entries)?;
    body += "<h2>Energy and area</h2>\n<p>Reads and writes of memories on the chip, a frame, and their area.</p>\n";
    body += &rows(entries, &costs_head(), costs);
    body += "<h2>Figure 3: the mean of equal images</h2>\n";
    for row in pictures {
        body += "<div class=\"plots\">\n";
        for picture in row {
            body += &figure(&picture.image, &picture.caption)?;
        }
        body += "</div>\n";
    }
    Ok(whole("Accumulation", about, command, &body))
}

/// A table with a row for each number of frames.
fn rows(entries: &[Entry], heads: &[String], row: fn(&Entry) -> Vec<String>) -> String {
    let mut text = String::from("<table>\n");
    text += &cells("th", ["N"].into_iter().chain(heads.iter().map(String::as_str)));
    for entry in table(entries) {
        let count = entry.frames.count().to_string();
        text += &cells("td", [&*count].into_iter().chain(row(entry).iter().map(String::as_str)));
    }
    text + "</table>\n"
}

/// The numbers of frames, as they stand along an axis.
fn numbers(entries: &[Entry]) -> Vec<String> {
    table(entries).map(|entry| entry.frames.count().to_string()).collect()
}

/// A line for each method: cycles for each frame.
fn of_methods(entries: &[Entry]) -> io::Result<String> {
    let methods = COLUMNS.into_iter().chain([Method::Stream(2), Method::Stream(4)]);
    let methods: Vec<Method> = methods.collect();
    let line = |method: &Method| {
        let each = |entry: &Entry| {
            let frames = f64::from(entry.frames.count());
            entry.run(*method).map_or(f64::NAN, |run| run.cycles as f64 / frames)
        };
        table(entries).map(each).collect()
    };
    let series: Vec<Vec<f64>> = methods.iter().map(line).collect();
    let names: Vec<String> = methods.iter().map(Method::to_string).collect();
    let svg = lines(&numbers(entries), &series, ("frames of an image", "cycles for a frame"), &[])?;
    Ok(legend(names.iter().map(String::as_str))
        + &plot(&svg, "Cycles of an image, over its frames."))
}

/// Errors with their bounds: of trees, and beside them of blending.
fn errors(entries: &[Entry]) -> io::Result<String> {
    let of = |method: Method, value: fn(&Run) -> u64| -> Vec<f64> {
        let each = |entry: &Entry| entry.run(method).map_or(f64::NAN, |run| value(run) as f64);
        table(entries).map(each).collect()
    };
    let both = |method| [of(method, |run| run.error), of(method, |run| run.bound)];
    let named = |method: Method| [format!("{method}"), format!("{method}, bound")];
    let paper = table(entries).map(|entry| papers_bound(entry.frames.count())).collect();
    let up = "levels of 255";
    let mut text = String::from("<h2>Error over the number of frames</h2>\n");
    let mut drawn = |names: Vec<String>, series: Vec<Vec<f64>>, caption: &str| {
        let svg = lines(&numbers(entries), &series, ("frames of an image", up), &[])?;
        text += &(legend(names.iter().map(String::as_str)) + &plot(&svg, caption));
        io::Result::Ok(())
    };
    let names = TREES.into_iter().flat_map(named).chain(["0.5 log2 N".to_string()]).collect();
    let series = TREES.into_iter().flat_map(both).chain([paper]).collect();
    drawn(names, series, "Trees, with the bounds of their arithmetic and that of the paper.")?;
    let blend = Method::Blend;
    let names = [&named(blend)[..], &named(TREES[0])[..1]].concat();
    let series = [&both(blend)[..], &both(TREES[0])[..1]].concat();
    drawn(names, series, "Blending, with its bound, and a tree.")?;
    Ok(text)
}
