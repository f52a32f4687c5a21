//! `pellucid explain`: why one run takes longer than another.

use super::say;
use anyhow::{anyhow, bail};
use clap::Args;
use comfy_table::{Table, presets};
use pellucid_testbench::output::reason;
use pellucid_testbench::report::{align_right, at_margin, grouped};
use serde_json::{Value as Json, json};
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(super) struct ExplainArgs {
    /// A run: its folder, its stats.json, or the file of a point that `explore` has kept
    #[arg(value_name = "RUN")]
    first: PathBuf,
    /// Another one
    #[arg(value_name = "RUN")]
    second: PathBuf,
    /// The most lines of each part
    #[arg(long, value_name = "LINES", default_value_t = 8)]
    lines: usize,
}

/// A run that is looked at.
struct Run {
    name: String,
    report: Json,
}

/// Something that both runs counted, or one of them.
struct Difference {
    name: String,
    values: [Option<u64>; 2],
}

impl Difference {
    fn size(&self) -> i128 {
        let [first, second] = self.values.map(|value| i128::from(value.unwrap_or(0)));
        second - first
    }
}

/// Explains; always done.
pub(super) fn explain(args: &ExplainArgs) -> anyhow::Result<bool> {
    let runs = [open(&args.first)?, open(&args.second)?];
    let totals = [&runs[0], &runs[1]].map(|run| run.report["cycles"]["total"].as_u64());
    let [Some(first), Some(second)] = totals else {
        bail!(
            "a run without `cycles.total`: expected two that `pellucid run` or `explore` have left"
        );
    };
    let mut text = String::new();
    for (name, run) in ["first", "second"].into_iter().zip(&runs) {
        text += &format!("{name:6}  {}\n", run.name);
    }
    text += &format!("\n{}\n", headline(first, second));
    let phases = object(&runs, "cycles");
    let stalls = list(&runs, "streams", &["stalls"]);
    let accesses = list(&runs, "memories", &["reads", "writes"]);
    let fragments = object(&runs, "fragments");
    let outside = object(&runs, "outside");
    for (what, differences) in [
        ("CYCLES", phases.into_iter().filter(|d| d.name != "total").collect()),
        ("STALLS OF STREAMS, cycles", stalls),
        ("FRAGMENTS", fragments),
        ("ACCESSES OF MEMORIES, words", accesses),
        ("OUTSIDE", outside),
    ] {
        text += &part(what, differences, args.lines);
    }
    say(&text)?;
    Ok(true)
}

/// What is known of a run.
fn open(path: &Path) -> anyhow::Result<Run> {
    let file = if path.is_dir() { path.join("stats.json") } else { path.to_owned() };
    let text = match fs::read(&file) {
        Ok(text) => text,
        Err(error) => bail!("cannot read `{}`: {}", file.display(), reason(&error)),
    };
    let json: Json = serde_json::from_slice(&text)
        .map_err(|error| anyhow!("`{}` is no JSON: {error}", file.display()))?;
    // A point has its report within.
    let report = if json["report"].is_object() { json["report"].clone() } else { json };
    let (arch, scene) = (report["arch"].as_str(), report["scene"].as_str());
    let (Some(arch), Some(scene)) = (arch, scene) else {
        bail!(
            "`{}` is no report: expected one that `pellucid run` or `explore` has left",
            file.display()
        );
    };
    Ok(Run { name: format!("{arch} on {scene}, `{}`", path.display()), report })
}

/// How many cycles more or fewer the second run takes.
fn headline(first: u64, second: u64) -> String {
    let [a, b] = [first, second].map(|cycles| grouped(&json!(cycles)));
    let share = (second as f64 / first.max(1) as f64 - 1.0) * 100.0;
    let more = if second > first { "more" } else { "fewer" };
    match first == second {
        true => format!("Both take {a} cycles."),
        false => format!("{b} cycles instead of {a}: {:.1} % {more}.", share.abs()),
    }
}

/// Numbers of an object of each run.
fn object(runs: &[Run; 2], group: &str) -> Vec<Difference> {
    let each = |run: &Run| -> Vec<(String, u64)> {
        let entries = run.report[group].as_object().into_iter().flatten();
        entries.filter_map(|(name, value)| Some((name.clone(), value.as_u64()?))).collect()
    };
    paired([each(&runs[0]), each(&runs[1])])
}

/// Sums of fields of each part of a list of each run.
fn list(runs: &[Run; 2], list: &str, fields: &[&str]) -> Vec<Difference> {
    let each = |run: &Run| -> Vec<(String, u64)> {
        let parts = run.report[list].as_array().into_iter().flatten();
        let sum = |part: &Json| fields.iter().filter_map(|field| part[*field].as_u64()).sum();
        parts.filter_map(|part| Some((part["name"].as_str()?.to_string(), sum(part)))).collect()
    };
    paired([each(&runs[0]), each(&runs[1])])
}

/// What differs, the most first.
fn paired([first, second]: [Vec<(String, u64)>; 2]) -> Vec<Difference> {
    let of = |list: &[(String, u64)], name: &str| {
        list.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    };
    let mut names: Vec<&String> = first.iter().chain(&second).map(|(name, _)| name).collect();
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| seen.insert(*name));
    let each = names.into_iter().map(|name| Difference {
        name: name.clone(),
        values: [of(&first, name), of(&second, name)],
    });
    let mut differences: Vec<Difference> = each.filter(|d| d.size() != 0).collect();
    differences.sort_by_key(|difference| std::cmp::Reverse(difference.size().unsigned_abs()));
    differences
}

/// A part of the text, of so many lines at most; nothing where nothing differs.
fn part(what: &str, differences: Vec<Difference>, lines: usize) -> String {
    if differences.is_empty() {
        return String::new();
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_row([what, "first", "second", "difference"]);
    for difference in differences.iter().take(lines) {
        let shown = |value: Option<u64>| value.map_or("-".to_string(), |n| grouped(&json!(n)));
        let size = difference.size();
        let sign = if size < 0 { '-' } else { '+' };
        let size = format!("{sign}{}", grouped(&json!(size.unsigned_abs() as u64)));
        let [first, second] = difference.values.map(shown);
        table.add_row([format!("  {}", difference.name), first, second, size]);
    }
    align_right(&mut table, &[1, 2, 3]);
    let left = differences.len().saturating_sub(lines);
    let left = if left > 0 { format!("  and {left} that differ by less\n") } else { String::new() };
    format!("\n{}{left}", at_margin(&table.to_string()))
}
