//! The figures as a page.

use super::contender::{Contender, RIVALS};
use super::figures::{MANAGEMENT, costs, five_numbers, management, table};
use super::plan::{Figure, MANAGED, NUMBERS, Sizes};
use super::runs::Entry;
use crate::reproduce::claims::{self, Claim};
use crate::reproduce::number;
use pellucid_testbench::html::{escaped, legend, page as whole, plot, shades};
use pellucid_testbench::plots::{boxes, groups, lines};
use std::io;

/// From so many layers on; the first has those below, which are not shown, as in the paper.
const LAYERS: [usize; 6] = [0, 10, 20, 50, 100, 200];

/// The page.
///
/// # Errors
/// A plot cannot be drawn.
pub fn page(command: &str, sizes: &Sizes, entries: &[Entry], said: &[Claim]) -> io::Result<String> {
    let about = "The figures of <em>Memory-efficient order-independent transparency with Dynamic Fragment Buffer</em> (M. Maule, \
                 J. Comba, R. Torchelsen and R. Bastos, 2012), made again with clocked machines: cycles where the paper has \
                 frames a second of a graphics card of 2011. Every image was equal to the golden model's. All fragments are on \
                 chip, a word a cycle; memory is as the paper counts it.";
    let mut body = claims::html(said);
    body += &table_1(entries);
    body += &quads(sizes, entries)?;
    body += &walks(sizes, entries)?;
    body += &tour(entries)?;
    Ok(whole("The Dynamic Fragment Buffer and its rivals", about, command, &body))
}

fn names() -> impl Iterator<Item = &'static str> {
    RIVALS.iter().map(|machine| machine.name)
}

fn table_1(entries: &[Entry]) -> String {
    let mut text = String::from(
        "<h2>Table I</h2>\n<p>One view of one model. In brackets the speed against DFB (here: against dfb:fast).</p>\n<table>\n",
    );
    for row in table(entries).into_iter().chain(costs(entries)) {
        let is_head = !row[0].starts_with(' ');
        let cell = |text: &String| match is_head {
            true => format!("<th>{}</th>", escaped(text)),
            false => format!("<td class=\"number\">{}</td>", escaped(text)),
        };
        text += &format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
    }
    text + "</table>\n"
}

/// A value as a plot takes it: none has no point.
fn point(value: Option<u64>) -> f64 {
    value.map_or(f64::NAN, |value| value as f64)
}

fn quads(sizes: &Sizes, entries: &[Entry]) -> io::Result<String> {
    let labels: Vec<String> = sizes.percents.iter().map(ToString::to_string).collect();
    let along = "% of the screen covered";
    let caption = |number: u32, side: u32| {
        let quads = if number == 1 { "One quad".to_string() } else { format!("{number} quads") };
        format!("{quads} on a screen of {side}x{side} pixels.")
    };
    let frames = |number: u32, side: u32| {
        let of = move |entry: &&Entry| {
            matches!(entry.figure, Figure::Quads(n, _) if n == number)
                && entry.frames.screen.0 == side
        };
        entries.iter().filter(of).collect::<Vec<_>>()
    };
    let mut text = format!(
        "<h2>Figure 5: cycles over coverage</h2>\n{}<div class=\"plots\">\n",
        legend(names())
    );
    for number in NUMBERS {
        for side in sizes.sides {
            let frames = frames(number, side);
            let of = |machine: &Contender| {
                frames.iter().map(|entry| point(entry.total(*machine))).collect::<Vec<_>>()
            };
            let series: Vec<Vec<f64>> = RIVALS.iter().map(of).collect();
            text +=
                &plot(&lines(&labels, &series, (along, "cycles"), &[])?, &caption(number, side));
        }
    }
    text += &format!(
        "</div>\n<h2>Figure 6: what memory management costs</h2>\n<p>Count and scan, and what further bands and plays take \
         beyond the same machine with enough memory. Lists begin with a slot for each pixel.</p>\n{}<div class=\"plots\">\n",
        legend(MANAGEMENT)
    );
    for number in MANAGED {
        for side in sizes.sides {
            let costs: Vec<_> = frames(number, side).into_iter().map(management).collect();
            let of = |k: usize| costs.iter().map(|costs| point(costs[k])).collect::<Vec<_>>();
            let series: Vec<Vec<f64>> = (0..MANAGEMENT.len()).map(of).collect();
            text +=
                &plot(&lines(&labels, &series, (along, "cycles"), &[])?, &caption(number, side));
        }
    }
    Ok(text + "</div>\n")
}

fn walks(sizes: &Sizes, entries: &[Entry]) -> io::Result<String> {
    let all: Vec<&Entry> =
        entries.iter().filter(|entry| matches!(entry.figure, Figure::Walk(_))).collect();
    let model = all.first().map_or("", |entry| &*entry.frames.scene);
    let mut text = format!(
        "<h2>Figure 7: walks around {}</h2>\n<p>{} frames once round. Boxes: from the lower to the upper quartile of the frames' \
         cycles, with a line at the median and whiskers to both ends. Memory: the most that a frame takes, as the paper counts \
         it.</p>\n{}<div class=\"plots\">\n",
        escaped(model),
        sizes.walk,
        legend(names())
    );
    for number in NUMBERS {
        let walks: Vec<&Entry> =
            all.iter().copied().filter(|entry| entry.figure == Figure::Walk(number)).collect();
        let labels: Vec<String> = walks.iter().map(|entry| entry.frames.size()).collect();
        let spread = |entry: &&Entry| {
            let of = |machine: &Contender| {
                five_numbers(entry.run(*machine)?.frames.iter().map(|frame| frame.cycles.total))
            };
            RIVALS.iter().map(of).collect::<Vec<_>>()
        };
        let spreads: Vec<_> = walks.iter().map(spread).collect();
        let layers = walks.iter().map(|entry| entry.need.layers).max().unwrap_or(0);
        let models =
            if number == 1 { "One model" } else { &format!("{number} models side by side") };
        let caption = format!("{models}, up to {layers} layers.");
        text += &plot(&boxes(&labels, &spreads, "cycles a frame")?, &caption);
        let bytes = |entry: &&Entry| {
            let of = |machine: &Contender| machine.bytes(&entry.need) as f64;
            RIVALS.iter().map(of).collect::<Vec<_>>()
        };
        let bytes: Vec<Vec<f64>> = walks.iter().map(bytes).collect();
        let labels: Vec<&str> = labels.iter().map(|label| &**label).collect();
        let caption = format!("{models}: the most memory that a frame takes.");
        text += &plot(&groups(&labels, &bytes, "bytes")?, &caption);
    }
    Ok(text + "</div>\n")
}

fn tour(entries: &[Entry]) -> io::Result<String> {
    let Some(entry) = entries.iter().find(|entry| entry.figure == Figure::Tour) else {
        return Ok(String::new());
    };
    let runs: Vec<_> = RIVALS.iter().map(|machine| entry.run(*machine)).collect();
    let count = entry.frames.count() as usize;
    let labels: Vec<String> = (0..count).map(|frame| frame.to_string()).collect();
    let series: Vec<Vec<f64>> = runs
        .iter()
        .map(|run| match run {
            Some(run) => run.frames.iter().map(|frame| frame.cycles.total as f64).collect(),
            None => vec![f64::NAN; count],
        })
        .collect();
    let pixels = entry.frames.pixels() as f64;
    let played = runs.iter().flatten().next().map_or(&[][..], |run| &run.frames);
    let share = |k: usize| -> Vec<f64> {
        let to = LAYERS.get(k + 1).copied().unwrap_or(usize::MAX);
        let of = |layers: &[u64]| -> u64 {
            let from = LAYERS[k].min(layers.len());
            layers[from..to.min(layers.len())].iter().sum()
        };
        played.iter().map(|frame| 100.0 * of(&frame.layers) as f64 / pixels).collect()
    };
    let shares: Vec<Vec<f64>> = (1..LAYERS.len()).map(share).collect();
    let strips = (1..LAYERS.len()).map(|k| match LAYERS.get(k + 1) {
        Some(to) => format!("{} to {} layers", LAYERS[k], to - 1),
        None => format!("{} layers or more", LAYERS[k]),
    });
    let strips: Vec<String> = strips.collect();
    let lacking = RIVALS.iter().filter_map(|m| m.lacks(&entry.need).map(|why| (m.name, why)));
    let lacking: String = lacking
        .map(|(name, why)| {
            format!("<p>{}: cannot hold these frames, {}.</p>\n", escaped(name), escaped(why))
        })
        .collect();
    let caption = format!(
        "{count} frames on an ellipse around the power plant, {} pixels, up to {} layers. Behind the lines: the share of pixels with \
         so many layers.",
        entry.frames.size(),
        number(entry.need.layers)
    );
    Ok(format!(
        "<h2>Figure 8: cycles over a walk, with the layers behind them</h2>\n{}{}{lacking}{}",
        legend(names()),
        shades(strips.iter().map(|strip| &**strip)),
        plot(&lines(&labels, &series, ("frame", "cycles"), &shares)?, &caption)
    ))
}
