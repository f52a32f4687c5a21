//! A comparison: the figures of several machines on several scenes, side by side.

mod heat;
mod page;

use crate::output::{OutputError, put};
use crate::report::{Entry, Report, align_right, at_margin, csv_text, grouped, nest};
use crate::scoreboard::Verdict;
use crate::trial::{Case, Trial};
use comfy_table::{Table, presets};
use pellucid_machine::params::Value;
use serde_json::{Map, Value as Json, json};
use std::path::Path;

/// The figures of all machines that are compared: group and name. Each is one of a run's report.
const FIGURES: [(&str, &str); 25] = [
    ("cycles", "total"),
    ("cycles", "store"),
    ("cycles", "resolve"),
    ("stalls", "streams"),
    ("accesses", "seed"),
    ("accesses", "full"),
    ("storage", "seed_bytes"),
    ("storage", "seed_bytes_used"),
    ("storage", "bits"),
    ("storage", "on_chip_bytes"),
    ("storage", "outside_bytes"),
    ("fragments", "stored"),
    ("fragments", "spilled"),
    ("fragments", "dropped"),
    ("image", "mismatched_pixels"),
    ("image", "max_error"),
    ("image", "error_bound"),
    ("energy", "total"),
    ("energy", "on_chip"),
    ("energy", "reads"),
    ("energy", "writes"),
    ("energy", "leakage"),
    ("area", "memories"),
    ("time", "clock"),
    ("time", "frame"),
];

/// See the module's description.
pub struct Comparison {
    /// The command that makes it, as a shell takes it.
    pub command: String,
    /// The machines' names.
    pub machines: Vec<String>,
    /// The scenes with their runs.
    pub scenes: Vec<Compared>,
}

/// One scene's runs.
pub struct Compared {
    /// The scene as the first machine takes it.
    pub case: Case,
    /// A run for each machine, in their order.
    pub trials: Vec<Trial>,
}

/// The names of a machine's settings.
fn names(report: &Report) -> impl Iterator<Item = &String> {
    report.config().iter().map(|(name, _)| name)
}

/// Machines that are the same but for a parameter that is a number.
struct Sweep<'a> {
    /// The parameter.
    parameter: &'a str,
    /// Its values from the smallest on, each with the number of its machine.
    values: Vec<(u32, usize)>,
}

/// One figure, and its value for each machine that has it.
struct Row<'a> {
    figure: &'a Entry,
    values: Vec<Option<&'a Json>>,
}

impl Row<'_> {
    /// Of each machine a number, 0 where it has none.
    fn numbers(&self) -> Vec<f64> {
        self.values.iter().map(|value| value.and_then(Json::as_f64).unwrap_or_default()).collect()
    }
}

/// A value as a table shows it.
fn cell(value: Option<&Json>) -> String {
    value.map_or("-".to_string(), grouped)
}

impl Compared {
    /// The figures that are compared, in their order: those of every machine; if all machines are of one architecture also
    /// its own, as far as all have them; and those of a memory outside, where any has one that counts.
    fn figures(&self) -> Vec<(&'static str, &'static str)> {
        let mut figures = FIGURES.to_vec();
        let Some(first) = self.trials.first().map(|trial| &trial.report) else { return figures };
        let reports = || self.trials.iter().map(|trial| &trial.report);
        if reports().all(|report| report.arch() == first.arch()) {
            let phases = first.tally().cycles.figures();
            let own = first.entries().iter().filter(|entry| match entry.group {
                "cycles" => phases.iter().all(|figure| figure.name != entry.name),
                group => group == first.arch(),
            });
            let names = own.map(|entry| (entry.group, entry.name));
            let shared = names.filter(|(group, name)| {
                reports().all(|report| report.figure(group, name).is_some())
            });
            figures.extend(shared);
        }
        let outside = |report: &Report| {
            let of_outside = |entry: &&Entry| {
                entry.group == "outside"
                    || (entry.group == "energy" && entry.name.starts_with("outside_"))
            };
            let entries = report.entries().iter().filter(of_outside);
            entries.map(|entry| (entry.group, entry.name)).collect::<Vec<_>>()
        };
        // Not every DRAM has figures of energy.
        for name in reports().flat_map(outside) {
            if !figures.contains(&name) {
                figures.push(name);
            }
        }
        figures
    }

    fn rows(&self) -> Vec<Row<'_>> {
        self.figures().into_iter().filter_map(|(group, name)| self.row(group, name)).collect()
    }

    /// What the machines are a sweep over, if they are one.
    fn sweep(&self) -> Option<Sweep<'_>> {
        let (first, others) = self.trials.split_first()?;
        let first = &first.report;
        // One with a DRAM has settings that others do not have.
        let like_first =
            |report: &Report| report.arch() == first.arch() && names(report).eq(names(first));
        if !others.iter().all(|trial| like_first(&trial.report)) {
            return None;
        }
        let at = |k: usize| self.trials.iter().map(move |trial| &trial.report.config()[k].1);
        let mut varied =
            (0..first.config().len()).filter(|k| at(*k).any(|v| *v != first.config()[*k].1));
        let (Some(k), None) = (varied.next(), varied.next()) else { return None };
        let number = |(value, machine): (&Value, usize)| match value {
            Value::Number(number) => Some((*number, machine)),
            Value::Choice(_) | Value::Text(_) => None,
        };
        let mut values: Vec<(u32, usize)> = at(k).zip(0..).map(number).collect::<Option<_>>()?;
        values.sort_unstable();
        Some(Sweep { parameter: &first.config()[k].0, values })
    }

    /// Of each machine a parameter that is a number, 1 where it has none of that name.
    fn number(&self, parameter: &str) -> Vec<f64> {
        let of = |trial: &Trial| {
            let value = trial.report.config().iter().find(|(name, _)| name == parameter);
            match value {
                Some((_, Value::Number(number))) => f64::from(*number),
                _ => 1.0,
            }
        };
        self.trials.iter().map(of).collect()
    }

    /// One figure; there is none where no run has it.
    fn row(&self, group: &str, name: &str) -> Option<Row<'_>> {
        let entries: Vec<Option<&Entry>> =
            self.trials.iter().map(|trial| trial.report.figure(group, name)).collect();
        let figure = *entries.iter().flatten().next()?;
        let values = entries.into_iter().map(|entry| entry.map(|entry| &entry.value)).collect();
        Some(Row { figure, values })
    }
}

impl Comparison {
    /// What is right, in a sentence; nothing if a run has a fault.
    pub fn approval(&self) -> Option<&'static str> {
        let verdicts = || self.runs().map(|(_, _, trial)| &trial.verdict);
        let blends = verdicts().all(|verdict| verdict.exact.is_none());
        verdicts().all(Verdict::is_right).then_some(if blends {
            "Every image equals the golden model's, bit for bit, and every count its closed form."
        } else {
            "Every image equals the golden model of its machine's arithmetic, bit for bit, no weighted sum is \
             farther from the exact blend than is allowed, and every count equals its closed form."
        })
    }

    /// Every fault: machine, scene and sentence.
    fn faults(&self) -> impl Iterator<Item = String> {
        self.runs().flat_map(|(scene, machine, trial)| {
            let faults = trial.verdict.faults().into_iter();
            faults.map(move |fault| format!("{machine} on {scene}: {fault}"))
        })
    }

    /// Every run with the names of its scene and of its machine.
    fn runs(&self) -> impl Iterator<Item = (&str, &str, &Trial)> {
        self.scenes.iter().flat_map(|scene| {
            let runs = self.machines.iter().zip(&scene.trials);
            runs.map(|(machine, trial)| (&*scene.case.scene, &**machine, trial))
        })
    }

    /// All figures: an array of scenes, each with an array of machines; `about` tells unit and sentence
    /// of each figure.
    pub fn json(&self) -> Json {
        let mut about = Map::new();
        let scenes: Vec<Json> =
            self.scenes.iter().map(|s| self.scene_json(s, &mut about)).collect();
        json!({ "command": self.command, "scenes": scenes, "about": about })
    }

    fn scene_json(&self, scene: &Compared, about: &mut Map<String, Json>) -> Json {
        let mut object = Map::new();
        object.insert("scene".into(), json!(scene.case.scene));
        if let Some(trial) = scene.trials.first() {
            let frame = trial.report.entries().iter().filter(|e| e.group == "frame");
            about.append(&mut nest(frame, &mut object));
        }
        let figures = scene.figures();
        let runs = self.machines.iter().zip(&scene.trials).map(|(machine, trial)| {
            let mut run = trial.report.labels();
            run.shift_remove("scene");
            run.insert("machine".into(), json!(machine));
            let compared = |e: &&Entry| figures.contains(&(e.group, e.name));
            about.append(&mut nest(trial.report.entries().iter().filter(compared), &mut run));
            Json::Object(run)
        });
        object.insert("machines".into(), runs.collect());
        Json::Object(object)
    }

    /// All figures as lines `scene,machine,figure,value,unit,about`.
    pub fn csv(&self) -> String {
        let mut text = String::from("scene,machine,figure,value,unit,about\n");
        for scene in &self.scenes {
            for Row { figure, values } in scene.rows() {
                let (key, unit, about) = (figure.key(), figure.unit, csv_text(figure.about));
                let has = |(machine, value)| Some((machine, value?));
                for (machine, value) in self.machines.iter().zip(values).filter_map(has) {
                    let names = [&scene.case.scene, machine].map(|name| csv_text(name)).join(",");
                    text += &format!("{names},{key},{value},{unit},{about}\n");
                }
            }
        }
        text
    }

    /// All figures as a table: a column for each machine, a group of lines for each scene. Machines that
    /// do not fit into `width` columns, if that is limited, follow below.
    pub fn table(&self, width: Option<u16>) -> String {
        let all = self.machines.len();
        let fits = |machines: &usize| {
            let columns = |table: &str| table.lines().map(|line| line.chars().count()).max();
            let mut parts = (0..all).step_by(*machines).map(|from| self.part(from, *machines));
            width.is_none_or(|width| parts.all(|part| columns(&part) <= Some(width.into())))
        };
        let machines = (1..=all).rev().find(fits).unwrap_or(1);
        let parts: Vec<String> =
            (0..all).step_by(machines).map(|from| self.part(from, machines)).collect();
        parts.join("\n")
    }

    /// The table of so many machines, from one on.
    fn part(&self, from: usize, machines: usize) -> String {
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        let mut head = vec![String::new(), String::new()];
        // A setting a line, so that a column is not much wider than its figures.
        let names = self.machines.iter().skip(from).take(machines);
        head.extend(names.map(|name| name.replace(',', ",\n")));
        table.add_row(head);
        for scene in &self.scenes {
            table.add_row([format!("SCENE {}", scene.case.scene)]);
            for Row { figure, values } in scene.rows() {
                let mut row = vec![format!("  {}", figure.full_label()), figure.unit.to_string()];
                row.extend(values.into_iter().skip(from).take(machines).map(cell));
                table.add_row(row);
            }
        }
        align_right(
            &mut table,
            &(2..2 + machines.min(self.machines.len() - from)).collect::<Vec<_>>(),
        );
        at_margin(&table.to_string())
    }

    /// Writes `compare.json`, `compare.csv` and `compare.html` to `folder`.
    ///
    /// # Errors
    /// A file cannot be written; nothing half-written is left.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let path = folder.join("compare.html");
        let page = page::page(self).map_err(|error| OutputError::write(&path, &error))?;
        put(&path, &page)?;
        put(&folder.join("compare.json"), &format!("{:#}\n", self.json()))?;
        put(&folder.join("compare.csv"), &self.csv())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::scene::Options;
    use crate::source::Source;
    use pellucid_tbuffer::architecture::ARCHITECTURE;

    #[test]
    fn machines_that_do_not_fit_follow_below() {
        let options = Options { width: Some(8), height: Some(6), ..Options::default() };
        let mut progress = Progress::new("", None, true);
        let source = Source::open("glass", &options).unwrap();
        let machine = ARCHITECTURE.build(source.screen(), None, &[]).unwrap();
        let case = Case::new("glass", source, &*machine, &mut progress).unwrap();
        let run = |_| case.run(ARCHITECTURE.name, &*machine, None, &mut progress).unwrap();
        let trials: Vec<Trial> = (0..5).map(run).collect();
        let machines = (0..5).map(|k| format!("machine-{k}")).collect();
        let scenes = vec![Compared { case, trials }];
        let comparison = Comparison { command: String::new(), machines, scenes };

        let whole = comparison.table(None);
        assert_eq!(whole.matches("SCENE glass").count(), 1);
        let longest = |text: &str| text.lines().map(str::len).max().unwrap();
        assert_eq!(comparison.table(Some(longest(&whole) as u16)), whole);
        for (width, parts) in [(longest(&whole) - 1, 2), (10, 5)] {
            let table = comparison.table(Some(width as u16));
            assert!(longest(&table) <= width || width == 10, "{table}");
            assert_eq!(table.matches("SCENE glass").count(), parts, "{table}");
            for machine in &comparison.machines {
                assert_eq!(table.matches(&**machine).count(), 1, "{table}");
            }
        }
    }
}
