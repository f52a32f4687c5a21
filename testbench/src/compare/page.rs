//! A comparison as one page.

use super::{Compared, Comparison, Row, Sweep, cell, heat};
use crate::html::{self, escaped, figure, legend, plot, sample};
use crate::plots;
use crate::report::grouped;
use crate::trial::Trial;
use serde_json::json;
use std::io;

/// The figures that have a plot.
const PLOTTED: [(&str, &str); 9] = [
    ("storage", "seed_bytes"),
    ("storage", "seed_bytes_used"),
    ("accesses", "seed"),
    ("accesses", "full"),
    ("cycles", "total"),
    ("time", "frame"),
    ("energy", "total"),
    ("energy", "on_chip"),
    ("area", "memories"),
];

/// A machine's name, a setting a line.
fn name(machine: &str) -> String {
    format!("<span class=\"name\">{}</span>", escaped(machine).replace(',', ",<br/>"))
}

/// The page.
///
/// # Errors
/// A picture or a plot cannot be made.
pub(super) fn page(comparison: &Comparison) -> io::Result<String> {
    let mut text = faults(comparison);
    text += &machines(comparison);
    text += &table(comparison);
    text += &bars(comparison)?;
    for scene in &comparison.scenes {
        text += &curves(scene)?;
    }
    for scene in &comparison.scenes {
        text += &frame(comparison, scene)?;
    }
    let about = "Each machine drew each scene; a golden model in plain software says what the image must be.";
    Ok(html::page("Machines compared", about, &comparison.command, &text))
}

/// What is wrong.
fn faults(comparison: &Comparison) -> String {
    if let Some(sentence) = comparison.approval() {
        return format!("<p>{sentence}</p>\n");
    }
    let faults: Vec<String> =
        comparison.faults().map(|fault| format!("<li>{}</li>\n", escaped(&fault))).collect();
    format!("<p>Not every result is right:</p>\n<ul>\n{}</ul>\n", faults.concat())
}

/// The machines' parameters.
fn machines(comparison: &Comparison) -> String {
    let mut text = String::from(
        "<h2>Machines</h2>\n<table id=\"machines\">\n<tr><th>machine</th><th>parameters</th></tr>\n",
    );
    let trials = comparison.scenes.first().map(|scene| &scene.trials);
    for (machine, trial) in comparison.machines.iter().zip(trials.into_iter().flatten()) {
        let values = trial.report.config().iter().map(|(name, value)| format!("{name}={value}"));
        let values = values.collect::<Vec<_>>().join(", ");
        text += &format!("<tr><td>{}</td><td>{}</td></tr>\n", name(machine), escaped(&values));
    }
    text + "</table>\n"
}

/// All figures.
fn table(comparison: &Comparison) -> String {
    let heads = comparison.machines.iter();
    let heads = heads.map(|machine| format!("<th class=\"machine\">{}</th>", name(machine)));
    let heads: String = heads.collect();
    let mut text = format!(
        "<h2>Figures</h2>\n<div class=\"wide\">\n<table id=\"figures\">\n\
         <tr><th>figure</th>{heads}</tr>\n"
    );
    let columns = comparison.machines.len() + 1;
    for (k, scene) in comparison.scenes.iter().enumerate() {
        let name = escaped(&scene.case.scene);
        text += &format!("<tr class=\"scene\"><th colspan=\"{columns}\">{name}</th></tr>\n");
        // What it means is told once.
        let line = |Row { figure, values }: &Row, shown: usize| {
            let cell = |value| format!("<td class=\"number\">{}</td>", cell(value));
            let cells: String = values.iter().copied().take(shown).map(cell).collect();
            let (label, unit, about) = (figure.full_label(), figure.unit, escaped(figure.about));
            let meaning = match k {
                0 => format!("<small>in {unit}. {about}</small>"),
                _ => String::new(),
            };
            format!("<tr><td>{label}{meaning}</td>{cells}</tr>\n")
        };
        let all = scene.rows();
        let is_equal =
            |row: &&Row| row.values.len() > 1 && row.values.windows(2).all(|v| v[0] == v[1]);
        let (equal, others): (Vec<&Row>, Vec<&Row>) = all.iter().partition(is_equal);
        others.into_iter().for_each(|row| text += &line(row, row.values.len()));
        if !equal.is_empty() {
            let lines: String = equal.iter().map(|row| line(row, 1)).collect();
            text += &format!(
                "<tr><td colspan=\"{columns}\"><details>\n<summary>{} figures are the same for all \
                 machines</summary>\n<table>\n{lines}</table>\n</details></td></tr>\n",
                equal.len()
            );
        }
    }
    text + "</table>\n</div>\n"
}

/// The plots of figures.
fn bars(comparison: &Comparison) -> io::Result<String> {
    let mut text = String::from(
        "<h2>Plots</h2>\n<p>A group of bars for each scene, a bar for each machine, from left to right in \
         this order:</p>\n",
    );
    text += &legend(comparison.machines.iter().map(|machine| &**machine));
    text += "<div class=\"plots\">\n";
    let names: Vec<&str> = comparison.scenes.iter().map(|scene| &*scene.case.scene).collect();
    let names = plots::short(&names);
    for (group, name) in PLOTTED {
        let rows = comparison.scenes.iter().filter_map(|scene| scene.row(group, name));
        let rows: Vec<Row> = rows.collect();
        let Some(Row { figure, .. }) = rows.first() else { continue };
        let values: Vec<Vec<f64>> = rows.iter().map(Row::numbers).collect();
        let svg = plots::groups(&names, &values, figure.unit)?;
        let caption = format!("{}, in {}. {}", figure.full_label(), figure.unit, figure.about);
        text += &plot(&svg, &caption);
    }
    Ok(text + "</div>\n")
}

/// Work of all engines of a kind, that of the busiest one, and the parameter that says how many there are.
const LOADS: [(&str, &str, &str); 2] = [
    ("engine_work", "busiest_engine", "engines"),
    ("scan_line_work", "busiest_scan_line_engine", "scan_line_engines"),
];

/// Cycles by phase, beside the total.
const BY_PHASE: [&str; 2] = ["store", "resolve"];

/// Where the machines differ by a number alone: what is gained with it, and how evenly engines are busy.
fn curves(scene: &Compared) -> io::Result<String> {
    let Some(Sweep { parameter, values }) = scene.sweep() else { return Ok(String::new()) };
    let labels: Vec<String> = values.iter().map(|(value, _)| value.to_string()).collect();
    let along_sweep = |row: &Row| -> Vec<f64> {
        let numbers = row.numbers();
        values.iter().map(|(_, k)| numbers[*k]).collect()
    };
    let part = |lines: &[(String, Vec<f64>)], up: &str, caption: &str| -> io::Result<String> {
        let series: Vec<Vec<f64>> = lines.iter().map(|(_, values)| values.clone()).collect();
        let text = plot(&plots::lines(&labels, &series, (parameter, up), &[])?, caption);
        Ok(text + &legend(lines.iter().map(|(name, _)| &**name)))
    };
    let name = &scene.case.scene;
    let mut text = format!("<h2>Scene {} over {}</h2>\n", escaped(name), escaped(parameter));

    // Total, and the cycles that the architecture counts or, where it counts none, those by phase.
    let rows = scene.rows();
    let mut cycles: Vec<&Row> = rows.iter().filter(|row| row.figure.group == "cycles").collect();
    if cycles.len() > BY_PHASE.len() + 1 {
        cycles.retain(|row| !BY_PHASE.contains(&row.figure.name));
    }
    let gains = cycles.into_iter().map(|row| (row.figure.key(), along_sweep(row)));
    let gains: Vec<_> = gains
        .filter(|(_, cycles)| cycles.iter().all(|cycles| *cycles > 0.0))
        .map(|(key, cycles)| (key, cycles.iter().map(|c| cycles[0] / c).collect()))
        .collect();
    let caption = format!("Speed-up: cycles with {parameter}={}, over cycles.", labels[0]);
    text += &part(&gains, "speed-up", &caption)?;

    let mut loads = vec![];
    for (work, busiest, count) in LOADS {
        let row = |name| rows.iter().find(|row| row.figure.name == name).map(along_sweep);
        if let (Some(work), Some(busiest)) = (row(work), row(busiest)) {
            let engines = scene.number(count);
            let load = |n: usize| work[n] / engines[values[n].1] / busiest[n].max(1.0);
            loads.push((count.to_string(), (0..values.len()).map(load).collect()));
        }
    }
    if !loads.is_empty() {
        let caption = "Load balance: the mean work of an engine, over that of the busiest one.";
        text += &part(&loads, "load balance", caption)?;
    }
    Ok(text)
}

/// What a scene looks like, and how deep it is.
fn frame(comparison: &Comparison, scene: &Compared) -> io::Result<String> {
    let reference = &scene.case.reference;
    let number = |n: u64| grouped(&json!(n));
    let mut text = format!(
        "<h2>Scene {}</h2>\n<p>{} x {} pixels, {} fragments, {} of them transparent, {} of these behind \
         something opaque.</p>\n",
        escaped(&scene.case.scene),
        reference.image.width,
        reference.image.height,
        number(reference.fragments),
        number(reference.transparent),
        number(reference.culled),
    );
    text += &figure(&reference.image, "The image by the golden model: the exact blend.")?;
    let runs = comparison.machines.iter().zip(&scene.trials);
    let differ = |trial: &Trial| trial.images[0].compare(&reference.image).mismatched_pixels;
    let (same, different): (Vec<_>, Vec<_>) = runs.partition(|(_, trial)| differ(trial) == 0);
    if !same.is_empty() {
        let same: Vec<String> = same.iter().map(|(machine, _)| escaped(machine)).collect();
        text += &format!("<p>The same image, bit for bit, came from: {}.</p>\n", same.join("; "));
    }
    for (machine, trial) in different {
        let pixels = number(differ(trial));
        let own = trial.report.figure("image", "mismatched_pixels").and_then(|e| e.value.as_u64());
        let caption = match own {
            Some(own) if own != differ(trial) => format!(
                "The image by {machine}: {} pixels differ from the exact blend of the fragments as this machine orders \
                 them; {pixels} from the image above.",
                number(own)
            ),
            _ => format!("The image by {machine}: {pixels} pixels differ."),
        };
        text += &figure(&trial.images[0], &caption)?;
    }
    let caption =
        "Layers at each pixel: transparent fragments that are in front of all that is opaque.";
    text += &figure(&heat::map(reference), caption)?;
    text += "<p>Layers:\n";
    for (layers, rgb) in heat::legend(reference.max_layers) {
        text += &sample(rgb, &layers.to_string());
    }
    text += "</p>\n";
    let without = number(reference.layer_histogram[0]);
    if reference.max_layers > 0 {
        let caption = format!(
            "Pixels with each number of layers. The {without} pixels without any are left out."
        );
        text += &plot(&plots::histogram(&reference.layer_histogram)?, &caption);
    } else {
        text += &format!("<p>None of the {without} pixels has a layer.</p>\n");
    }
    Ok(text)
}
