//! What a study leaves: a row for each point as CSV and as JSON lines, what each column is, and the front as a table.

use super::criteria::written;
use super::page::page;
use super::points::{Outcome, Points};
use super::standing::Standing;
use super::study::Study;
use super::work::Candidate;
use comfy_table::{Table, presets};
use pellucid_machine::params::Value;
use pellucid_testbench::output::{OutputError, put};
use pellucid_testbench::report::{align_right, at_margin, csv_text};
use serde_json::{Map, Value as Json, json};
use std::path::Path;

/// Files, and what they are.
pub const FILES: &[(&str, &str)] = &[
    ("explore.html", "fronts, parameters and all designs, for a browser"),
    ("points.csv", "a row for each point"),
    ("points.jsonl", "the same as JSON lines"),
    #[cfg(feature = "parquet")]
    ("points.parquet", "the same as Parquet"),
    ("columns.json", "unit and meaning of each column"),
];

/// Columns that are no parameter and no figure.
const FIXED: [(&str, &str); 9] = [
    ("design", "Number of the design, from 0."),
    ("scene", "The scene, as `pellucid run` takes it."),
    ("arch", "The architecture."),
    ("machine", "The design's name."),
    ("status", "`right`, `lossy`, `wrong`, `failed`, `refused` or `excluded`."),
    ("reason", "Why it is not right."),
    ("front", "Whether the design is on the front."),
    ("command", "What does the same."),
    ("file", "Where the point is kept, with its whole report."),
];
/// What the names of columns with parameters begin with.
const PARAMETER: &str = "parameter.";

/// Writes everything.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    folder: &Path,
    command: &str,
    study: &Study,
    points: &Points,
    candidates: &[Candidate],
    standings: &[(Standing, bool)],
) -> Result<(), OutputError> {
    let rows = rows(study, candidates, standings);
    let columns = columns(&rows);
    let about: Map<String, Json> = columns.iter().map(|c| (c.clone(), about(c, points))).collect();
    let about = Json::Object(about);
    put(&folder.join("columns.json"), &format!("{about:#}\n"))?;
    put(&folder.join("points.csv"), &csv(&columns, &rows))?;
    let lines: String = rows.iter().map(|row| format!("{}\n", Json::Object(row.clone()))).collect();
    put(&folder.join("points.jsonl"), &lines)?;
    #[cfg(feature = "parquet")]
    {
        let path = folder.join("points.parquet");
        let bytes = super::parquet::file(&columns, &rows, &about)
            .map_err(|error| OutputError::write(&path, &std::io::Error::other(error)))?;
        put(&path, &bytes)?;
    }
    put(&folder.join("explore.html"), &page(command, study, points, candidates, standings))
}

/// A row for each point that is there.
fn rows(
    study: &Study,
    candidates: &[Candidate],
    standings: &[(Standing, bool)],
) -> Vec<Map<String, Json>> {
    let mut rows = vec![];
    for (number, (candidate, (_, front))) in candidates.iter().zip(standings).enumerate() {
        let choice = &candidate.design.choice;
        let parameters = parameters(candidate);
        let points = study.scenes.iter().zip(&candidate.outcomes);
        let points = points.zip(&candidate.commands).zip(&candidate.files);
        for (((scene, outcome), command), file) in points {
            let Some(Outcome { status, reason, figures, .. }) = outcome else { continue };
            let fixed = [
                json!(number),
                json!(scene.arguments()),
                json!(choice.arch.name),
                json!(choice.name),
                json!(status.name()),
                json!(reason),
                json!(front),
                json!(command),
                json!(file.as_ref().map(|file| file.display().to_string())),
            ];
            let mut row: Map<String, Json> = FIXED
                .iter()
                .zip(fixed)
                .map(|((name, _), value)| (name.to_string(), value))
                .collect();
            let parameters = parameters
                .iter()
                .map(|(name, value)| (format!("{PARAMETER}{name}"), value.clone()));
            row.extend(parameters);
            row.extend(figures.iter().map(|(name, value)| (name.clone(), number_json(*value))));
            rows.push(row);
        }
    }
    rows
}

/// The parameters of a design, its preset first; those that the study gives where it cannot be built.
pub fn parameters(candidate: &Candidate) -> Vec<(String, Json)> {
    let mut given = candidate.design.given();
    if !candidate.values.is_empty() {
        given.truncate(1);
    }
    let text = |text: &String| text.parse::<u32>().map_or(json!(text), |number| json!(number));
    let given = given.iter().map(|(name, value)| (name.clone(), text(value)));
    let values = candidate.values.iter().map(|(name, value)| {
        let value = match value {
            Value::Number(number) => json!(number),
            Value::Choice(_) | Value::Text(_) => json!(value.to_string()),
        };
        (name.clone(), value)
    });
    given.chain(values).collect()
}

/// A whole number as such.
fn number_json(value: f64) -> Json {
    if value.fract() == 0.0 && value.abs() < 1e15 { json!(value as i64) } else { json!(value) }
}

/// All columns: parameters before figures.
fn columns(rows: &[Map<String, Json>]) -> Vec<String> {
    let mut columns: Vec<String> = FIXED.iter().map(|(name, _)| name.to_string()).collect();
    let mut seen: std::collections::HashSet<String> = columns.iter().cloned().collect();
    for is_parameter in [true, false] {
        for name in rows.iter().flat_map(Map::keys) {
            if name.starts_with(PARAMETER) == is_parameter && seen.insert(name.clone()) {
                columns.push(name.clone());
            }
        }
    }
    columns
}

/// Unit and meaning of a column.
fn about(column: &str, points: &Points) -> Json {
    let fixed = FIXED.iter().find(|(name, _)| *name == column).map(|(_, about)| *about);
    let [unit, about] = match (fixed, column.strip_prefix(PARAMETER)) {
        (Some(about), _) => [String::new(), about.to_string()],
        (None, Some(name)) => [String::new(), format!("The parameter `{name}`.")],
        (None, None) => points.about(column),
    };
    json!({ "unit": unit, "about": about })
}

fn csv(columns: &[String], rows: &[Map<String, Json>]) -> String {
    let line = |fields: Vec<String>| format!("{}\n", fields.join(","));
    let field = |value: Option<&Json>| match value {
        None => String::new(),
        Some(Json::String(text)) => csv_text(text),
        Some(other) => other.to_string(),
    };
    let head = line(columns.to_vec());
    let rows = rows.iter().map(|row| line(columns.iter().map(|c| field(row.get(c))).collect()));
    head + &rows.collect::<String>()
}

/// The front, best first by the first objective, as a table of at most `width` columns.
pub fn table(
    study: &Study,
    candidates: &[Candidate],
    standings: &[(Standing, bool)],
    width: Option<u16>,
) -> String {
    let on = candidates.iter().zip(standings).filter(|(_, (_, front))| *front);
    let mut on: Vec<(&[f64], &str)> = on
        .filter_map(|(c, (standing, _))| Some((standing.values()?, c.design.choice.name.as_str())))
        .collect();
    let most = study.objectives[0].most;
    on.sort_by(|(a, _), (b, _)| if most { b[0].total_cmp(&a[0]) } else { a[0].total_cmp(&b[0]) });
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    if let Some(width) = width {
        table.set_width(width).set_content_arrangement(comfy_table::ContentArrangement::Dynamic);
    }
    let heads = study.objectives.iter().map(|objective| objective.figure.clone());
    table.add_row(heads.chain(["FRONT".to_string()]));
    for (values, name) in on {
        table.add_row(values.iter().map(|value| written(*value)).chain([name.to_string()]));
    }
    align_right(&mut table, &(0..study.objectives.len()).collect::<Vec<_>>());
    at_margin(&table.to_string())
}
