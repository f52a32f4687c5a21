//! A study that another program drives: it asks for designs line by line, and is told what came of them.
//!
//! Lines are JSON. The first one that is written says what can be asked for: `machines`, each with its `parameters`, and `objectives`.
//! Each line that is read is a design, `{"machine": 0, "parameters": {"sections": 4096}}`, or a list of such, which are run at
//! once. The answer has for each its number, name and `objectives`; or in `out` why it has none. What is no design
//! is answered by an `error`, and the dialogue goes on.

use super::designs::{Design, Searcher};
use super::space::{Axis, Values};
use super::standing::Standing;
use super::study::{Family, Study};
use super::work::Work;
use crate::say;
use pellucid_machine::params::{did_you_mean, nearest};
use serde_json::{Map, Value as Json, json};
use std::io::BufRead;

/// Answers every line of `lines`; `run` does what is left of the work.
///
/// # Errors
/// Those of `run`, and a line that cannot be read or written.
pub fn answer(
    study: &Study,
    searcher: &mut Searcher,
    work: &mut Work,
    lines: impl BufRead,
    mut run: impl FnMut(&mut Work) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    say(&format!("{}\n", space(study)))?;
    for line in lines.lines() {
        let line = line?;
        if line.trim().is_empty() {
            continue;
        }
        let asked: Vec<Json> = match serde_json::from_str(&line) {
            Ok(Json::Array(each)) => each,
            Ok(one) => vec![one],
            Err(error) => {
                say(&format!("{}\n", json!({ "error": format!("no JSON: {error}") })))?;
                continue;
            }
        };
        let numbers: Vec<Result<usize, String>> = asked
            .iter()
            .map(|asked| {
                let (machine, values) = read(&study.families, asked)?;
                Ok(searcher.add(machine, &values))
            })
            .collect();
        let designs: Vec<Design> = searcher.found();
        designs.into_iter().for_each(|design| work.add(design));
        run(work)?;
        let answers = numbers.into_iter().map(|number| match number {
            Ok(number) => told(study, work, number),
            Err(problem) => json!({ "error": problem }),
        });
        let mut answers: Vec<Json> = answers.collect();
        let is_list = line.trim_start().starts_with('[');
        let text = if is_list { json!(answers) } else { answers.remove(0) };
        say(&format!("{text}\n"))?;
    }
    Ok(())
}

/// What can be asked for.
fn space(study: &Study) -> Json {
    let parameter = |axis: &Axis| match &axis.values {
        Values::List(values) => Some(json!({ "name": axis.name, "values": values })),
        Values::Span { from, to, log2, .. } => {
            let scale = if *log2 { "log2" } else { "linear" };
            Some(json!({ "name": axis.name, "from": from, "to": to, "scale": scale }))
        }
        Values::Formula(_) => None,
    };
    let machines = study.families.iter().map(|family| {
        let parameters: Vec<Json> = family.axes.iter().filter_map(parameter).collect();
        json!({ "arch": family.arch.name, "parameters": parameters })
    });
    let objectives = study.objectives.iter().map(|objective| {
        let goal = if objective.most { "max" } else { "min" };
        json!({ "figure": objective.figure, "goal": goal })
    });
    json!({ "machines": machines.collect::<Vec<_>>(), "objectives": objectives.collect::<Vec<_>>() })
}

/// The machine's number, and a value for each of its parameters.
fn read(families: &[Family], asked: &Json) -> Result<(usize, Vec<String>), String> {
    let nothing = Map::new();
    let last = families.len() - 1;
    let number = match asked["machine"].as_u64() {
        None if asked["machine"].is_null() && last == 0 => 0,
        Some(number) if number <= last as u64 => number as usize,
        _ => {
            return Err(format!(
                "`machine` is {}: expected a number from 0 to {last}",
                asked["machine"]
            ));
        }
    };
    let given = match &asked["parameters"] {
        Json::Object(given) => given,
        Json::Null => &nothing,
        other => return Err(format!("`parameters` is {other}: expected an object")),
    };
    let axes = &families[number].axes;
    if let Some(unknown) = given.keys().find(|name| axes.iter().all(|axis| axis.name != **name)) {
        let hint = did_you_mean(&nearest(unknown, axes.iter().map(|axis| axis.name.as_str())));
        return Err(format!("unknown parameter `{unknown}`{hint}"));
    }
    let values = axes.iter().map(|axis| {
        let text = given.get(&axis.name).map(|value| match value {
            Json::String(text) => text.clone(),
            other => other.to_string(),
        });
        axis.values.checked(text.as_deref()).map_err(|problem| format!("`{}` {problem}", axis.name))
    });
    Ok((number, values.collect::<Result<_, _>>()?))
}

/// What came of a design.
fn told(study: &Study, work: &Work, number: usize) -> Json {
    let candidate = &work.candidates[number];
    let standing = Standing::of(study, candidate);
    let out = match &standing {
        Standing::Out { why, .. } => json!(why),
        Standing::Open | Standing::In(_) => Json::Null,
    };
    json!({ "design": number, "name": candidate.design.choice.name, "objectives": standing.values(), "out": out })
}
