//! The report of a run: every figure once, shown as a table, as JSON and as CSV.

mod costs;
mod entry;
mod frames;
mod lists;
mod text;

pub(crate) use entry::{Entry, nest};
pub use frames::Frame;
pub use text::{align_right, at_margin, csv_text, grouped};

use crate::costs::{Costs, PICOJOULES};
use crate::golden::Reference;
use crate::output::{OutputError, put};
use crate::scoreboard::Verdict;
use comfy_table::{ColumnConstraint, ContentArrangement, Table, presets};
use entry::meaning;
use lists::{MEMORY_FIELDS, STREAM_FIELDS, memory_json, memory_values, stream_json, stream_values};
use pellucid_machine::params::Value;
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Cycles, MemoryTally, Model, Tally};
use pellucid_sim::{Figure, Figures};
use serde_json::{Map, Value as Json, json};
use std::path::Path;

/// See the module's description.
pub struct Report {
    arch: &'static str,
    scene: String,
    config: Vec<(String, Value)>,
    entries: Vec<Entry>,
    tally: Tally,
    histogram: Vec<u64>,
    frames: Vec<Frame>,
    costs: Option<Costs>,
    faults: Vec<String>,
}

/// From how many columns on there is room for the sentences beside the figures.
const SENTENCES_FROM: u16 = 110;

/// `part` per `whole`, to four digits; 0 where there is no whole.
fn rate(part: u64, whole: u64) -> Json {
    let rate = if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    json!((rate * 10_000.0).round() / 10_000.0)
}

/// What memories take.
fn of_memories(memories: &[MemoryTally]) -> [Figure; 3] {
    let bits = memories.iter().map(|m| memory_values(m)[5]).sum();
    let bytes = |outside: bool| {
        let those = memories.iter().filter(|m| m.info.outside == outside);
        those.map(|m| memory_values(m)[5].div_ceil(8)).sum()
    };
    let figure = |name, unit, about, value| Figure { name, unit, about, value };
    [
        figure("bits", "bits", "All memories of the model together.", bits),
        figure(
            "on_chip_bytes",
            "bytes",
            "Memories on the chip, frame buffers included.",
            bytes(false),
        ),
        figure("outside_bytes", "bytes", "Memories outside of the chip.", bytes(true)),
    ]
}

/// A figure `group.name` that a machine has before it has seen a frame, and keeps; nothing if it is none of these.
pub fn known_beforehand(machine: &dyn Model, figure: &str) -> Option<u64> {
    let name = figure.strip_prefix("storage.")?;
    let known = of_memories(&machine.power_up().tally().memories);
    known.into_iter().find(|figure| figure.name == name).map(|figure| figure.value)
}

impl Report {
    /// The report of one run.
    pub fn new(
        arch: &'static str,
        scene: &str,
        config: Vec<(String, Value)>,
        screen: Screen,
        reference: &Reference,
        tally: Tally,
        verdict: &Verdict,
    ) -> Report {
        let mut entries = vec![];
        let mut add = |group, name, value: Json, unit, about| {
            entries.push(Entry { group, name, value, unit, about, basis: None });
        };
        let r = reference;
        let n = |value: u64| json!(value);
        add("frame", "width", n(screen.width.into()), "pixels", "Columns of the screen.");
        add("frame", "height", n(screen.height.into()), "pixels", "Rows of the screen.");
        let about = "Frames that were played; what is counted is counted over all of them.";
        add("frame", "frames", n(verdict.frames.into()), "frames", about);
        for f in frames::of_reference(r).into_iter().chain([frames::of_plays(verdict.plays)]) {
            add("frame", f.name, n(f.value), f.unit, f.about);
        }
        let about = "Transparent fragments that count per pixel that has any.";
        let mean = rate(r.blended, r.transparent_pixels);
        add("frame", "mean_layers", mean, "fragments per pixel", about);
        for f in tally.cycles.figures().iter().chain(&tally.further_cycles) {
            add("cycles", f.name, n(f.value), f.unit, f.about);
        }
        let stalls = tally.streams.iter().map(|s| s.stalls).sum();
        let about = "Cycles with an offer that was not taken, of all streams added up.";
        add("stalls", "streams", n(stalls), "cycles", about);
        let f = &tally.fragments;
        let unit = "fragments per cycle";
        // What comes again meets final depths: of all that was in front at first, what is visible is there to be resolved.
        let again = verdict.plays > u64::from(verdict.frames);
        let resolved = if again { f.blended } else { f.stored };
        let about_resolved = "Stored fragments done with per cycle of resolve; where frames came again, those that were blended.";
        for (name, phase, part, about) in [
            ("accepted", "store", f.arrived, "Fragments of any kind taken per cycle of store."),
            ("stored", "store", f.stored, "Fragments stored per cycle of store."),
            ("resolved", "resolve", resolved, about_resolved),
        ] {
            if let Some(cycles) = tally.cycles.of(phase) {
                add("rates", name, rate(part, cycles), unit, about);
            }
        }
        for f in f.figures() {
            add("fragments", f.name, n(f.value), f.unit, f.about);
        }
        let about = "Accesses as the architecture's paper counts them.";
        add("accesses", "seed", n(tally.seed_accesses), "words", about);
        let full = tally.memories.iter().map(|m| m.info.reads + m.info.writes).sum();
        let about = "Every access to every memory of the model.";
        add("accesses", "full", n(full), "words", about);
        let about = "Storage as the architecture's paper counts it, for the machine as configured.";
        add("storage", "seed_bytes", n(tally.seed_bytes), "bytes", about);
        let about = "The same for just the storage that was in use at the peak.";
        add("storage", "seed_bytes_used", n(tally.seed_bytes_used), "bytes", about);
        let f = of_memories(&tally.memories);
        f.into_iter().for_each(|f| add("storage", f.name, n(f.value), f.unit, f.about));
        let image = &verdict.image;
        let about = "Pixels that differ from the exact blend, or from the exact mean of several frames, rounded once.";
        add("image", "mismatched_pixels", n(image.mismatched_pixels), "pixels", about);
        let about = "The largest difference of a channel, 0 to 255.";
        add("image", "max_error", n(image.max_error.into()), "levels", about);
        let about = "The largest difference that the architecture's arithmetic allows, 0 to 255.";
        add("image", "error_bound", n(verdict.error_bound.into()), "levels", about);
        for f in tally.outside.iter().filter(|figure| figure.unit != PICOJOULES) {
            add("outside", f.name, n(f.value), f.unit, f.about);
        }
        let of = |name| tally.outside.iter().find(|f| f.name == name).map(|f| f.value);
        if let (Some(busy), Some(all)) = (of("busy_bus_clocks"), of("bus_clocks")) {
            let about = "The share of the memory's peak bandwidth that was used.";
            add("outside", "bandwidth_used", rate(busy, all), "of the peak", about);
        }
        for f in &tally.own {
            add(arch, f.name, n(f.value), f.unit, f.about);
        }
        Report {
            arch,
            scene: scene.to_string(),
            config,
            entries,
            tally,
            histogram: r.layer_histogram.clone(),
            frames: vec![],
            costs: None,
            faults: verdict.faults(),
        }
    }

    /// The same with the figures of each frame by itself.
    #[must_use]
    pub fn with_frames(self, frames: Vec<Frame>) -> Report {
        Report { frames, ..self }
    }

    /// The same with what the run costs beside cycles.
    #[must_use]
    pub fn with_costs(mut self, costs: Costs) -> Report {
        self.entries.extend(costs::entries(&costs, &self.tally));
        Report { costs: Some(costs), ..self }
    }

    /// The memories with what each costs, as far as that is known.
    fn memories(&self) -> impl Iterator<Item = (&MemoryTally, Option<[Json; 5]>)> {
        let costs = |k: usize| self.costs.as_ref()?.memories[k].as_ref();
        let memories = self.tally.memories.iter().enumerate();
        memories.map(move |(k, memory)| (memory, costs(k).map(costs::memory_values)))
    }

    /// The architecture, which is also the group of its own figures.
    pub(crate) fn arch(&self) -> &'static str {
        self.arch
    }

    /// Every figure that is one number.
    pub(crate) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The figure of that name, if it is one number.
    pub(crate) fn figure(&self, group: &str, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| (e.group, e.name) == (group, name))
    }

    /// All figures, nested by group; at the end `about` tells unit and sentence of each.
    pub fn json(&self) -> Json {
        let mut groups = self.labels();
        let mut about = nest(&self.entries, &mut groups);
        groups["frame"]["layer_histogram"] = json!(self.histogram);
        let what = json!({ "unit": "pixels", "about": "[i]: pixels with exactly i layers." });
        about.insert("frame.layer_histogram".into(), what.clone());
        about.insert("frames[].layer_histogram".into(), what);
        let memories: Vec<Json> = self.memories().map(memory_json).collect();
        groups.insert("memories".into(), json!(memories));
        let streams: Vec<Json> = self.tally.streams.iter().map(stream_json).collect();
        groups.insert("streams".into(), json!(streams));
        for (list, fields) in [("memories", &MEMORY_FIELDS[..]), ("streams", &STREAM_FIELDS[..])] {
            for (name, unit, sentence) in fields {
                about.insert(format!("{list}[].{name}"), meaning(unit, sentence, None));
            }
        }
        let bases = self.costs.iter().flat_map(costs::memory_bases);
        for ((name, unit, sentence), basis) in costs::MEMORY_FIELDS.iter().zip(bases) {
            about.insert(format!("memories[].{name}"), meaning(unit, sentence, Some(&basis)));
        }
        let frames: Vec<Json> = self.frames.iter().map(Frame::json).collect();
        groups.insert("frames".into(), json!(frames));
        for (name, f) in self.frames.first().into_iter().flat_map(Frame::figures) {
            let what = json!({ "unit": f.unit, "about": f.about });
            about.insert(format!("frames[].{name}"), what);
        }
        groups.insert("about".into(), json!(about));
        Json::Object(groups)
    }

    /// The machine's parameters.
    pub(crate) fn config(&self) -> &[(String, Value)] {
        &self.config
    }

    /// What was run, and what is wrong with it.
    pub(crate) fn labels(&self) -> Map<String, Json> {
        let mut labels = Map::new();
        labels.insert("arch".into(), json!(self.arch));
        labels.insert("scene".into(), json!(self.scene));
        labels.insert("config".into(), config_json(&self.config));
        labels.insert("faults".into(), json!(self.faults));
        labels
    }

    /// What the run counted.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// All figures as lines `figure,value,unit,about`.
    pub fn csv(&self) -> String {
        let mut text = String::from("figure,value,unit,about\n");
        let mut line = |name: &str, value: &str, unit: &str, about: &str| {
            text.push_str(&format!("{name},{value},{unit},{}\n", csv_text(about)));
        };
        for e in &self.entries {
            line(&e.key(), &e.value.to_string(), e.unit, e.about);
        }
        let mut pixels = |of: &str, histogram: &[u64]| {
            for (layers, pixels) in histogram.iter().enumerate() {
                let about = "Pixels with exactly that many layers.";
                let name = format!("{of}.layer_histogram.{layers}");
                line(&name, &pixels.to_string(), "pixels", about);
            }
        };
        pixels("frame", &self.histogram);
        for (number, frame) in self.frames.iter().enumerate() {
            pixels(&format!("frames.{number}"), frame.histogram());
        }
        for (number, frame) in self.frames.iter().enumerate() {
            for (name, f) in frame.figures() {
                let name = format!("frames.{number}.{name}");
                line(&name, &f.value.to_string(), f.unit, f.about);
            }
        }
        for (m, costs) in self.memories() {
            for ((field, unit, about), value) in MEMORY_FIELDS.iter().zip(memory_values(m)) {
                line(&format!("memories.{}.{field}", m.name), &value.to_string(), unit, about);
            }
            let costs = costs::MEMORY_FIELDS.iter().zip(costs.iter().flatten());
            for ((field, unit, about), value) in costs {
                line(&format!("memories.{}.{field}", m.name), &value.to_string(), unit, about);
            }
        }
        for s in &self.tally.streams {
            for ((field, unit, about), value) in STREAM_FIELDS.iter().zip(stream_values(s)) {
                line(&format!("streams.{}.{field}", s.name), &value.to_string(), unit, about);
            }
        }
        text
    }

    /// The figures as tables of at most `width` columns, if that is limited; the sentences are left
    /// out where there is no room for them.
    pub fn table(&self, width: Option<u16>) -> String {
        let sentences = width.is_none_or(|width| width >= SENTENCES_FROM);
        let mut figures = Table::new();
        figures.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
        if let Some(width) = width {
            figures.set_width(width);
        }
        let mut group = "";
        for e in &self.entries {
            if e.group != group {
                group = e.group;
                figures.add_row([group.to_uppercase()]);
            }
            let mut row = vec![format!("  {}", e.label()), grouped(&e.value), e.unit.to_string()];
            row.extend(sentences.then(|| e.about.to_string()));
            figures.add_row(row);
        }
        // What must not be broken is as wide as it is; the sentences take what is left.
        for column in figures.column_iter_mut().take(3) {
            column.set_constraint(ColumnConstraint::ContentWidth);
        }
        align_right(&mut figures, &[1]);
        let mut memories = Table::new();
        memories.load_style(presets::NOTHING);
        memories.add_row(["MEMORIES", "words", "bits/word", "reads", "writes", "peak words"]);
        for m in &self.tally.memories {
            let [reads, writes, words, bits, peak, _] =
                memory_values(m).map(|v| grouped(&json!(v)));
            memories.add_row([format!("  {}", m.name), words, bits, reads, writes, peak]);
        }
        align_right(&mut memories, &[1, 2, 3, 4, 5]);
        let mut prices = Table::new();
        prices.load_style(presets::NOTHING);
        prices.add_row(["COSTS", "nJ reads", "writes", "leakage", "mm2", "ns"]);
        for (m, costs) in self.memories() {
            let costs = costs.into_iter().flatten().map(|value| grouped(&value));
            prices.add_row([format!("  {}", m.name)].into_iter().chain(costs));
        }
        align_right(&mut prices, &[1, 2, 3, 4, 5]);
        let mut streams = Table::new();
        streams.load_style(presets::NOTHING);
        streams.add_row(["STREAMS", "from", "to", "transfers", "stall cycles"]);
        for s in &self.tally.streams {
            let (name, from, to) = (format!("  {}", s.name), s.from.into(), s.to.into());
            let [transfers, stalls] = stream_values(s).map(|v| grouped(&json!(v)));
            streams.add_row([name, from, to, transfers, stalls]);
        }
        align_right(&mut streams, &[3, 4]);
        let tables = at_margin(&format!("{figures}\n{memories}\n{prices}\n{streams}"));
        if sentences {
            return tables;
        }
        format!(
            "{tables}\nThere is no room for what each figure means: it stands beside them from\n\
             {SENTENCES_FROM} columns on, and in stats.csv and stats.json.\n"
        )
    }

    /// What matters most, in two lines, and a third one on what it costs.
    pub fn headline(&self) -> String {
        let Cycles { total, phases, .. } = &self.tally.cycles;
        let works = phases.iter().filter(|(phase, _)| phase.works);
        let works: Vec<String> =
            works.map(|(phase, n)| format!("{} of {}", grouped(&json!(n)), phase.name)).collect();
        let rates = self.entries.iter().filter(|e| e.group == "rates");
        let rates: Vec<String> = rates.map(|e| format!("{} {}", e.value, e.name)).collect();
        format!(
            "{} on {}: {} cycles, {}.\n\
             Fragments per cycle: {}.\n{}",
            self.arch,
            self.scene,
            grouped(&json!(total)),
            works.join(" and "),
            rates.join(", "),
            self.costs.as_ref().and_then(costs::headline).unwrap_or_default()
        )
    }

    /// Writes `stats.json` and `stats.csv` to `folder`.
    ///
    /// # Errors
    /// A file cannot be written; nothing half-written is left.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let json = format!("{:#}\n", self.json());
        for (name, text) in [("stats.json", json), ("stats.csv", self.csv())] {
            put(&folder.join(name), &text)?;
        }
        Ok(())
    }
}

/// Parameters and their values as an object.
pub fn config_json(config: &[(String, Value)]) -> Json {
    let pair = |(name, value): &(String, Value)| {
        let value = match value {
            Value::Number(n) => json!(n),
            Value::Choice(c) => json!(c),
            Value::Text(text) => json!(text),
        };
        (name.to_string(), value)
    };
    Json::Object(config.iter().map(pair).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::Golden;
    use pellucid_machine::Arithmetic;

    #[test]
    fn a_table_keeps_to_its_width() {
        let screen = Screen { width: 4, height: 3, background: 0 };
        let reference = Golden::new(screen).of(&[]).unwrap();
        let tally = Tally::default();
        let image = &reference.image;
        let verdict = Verdict::new(&reference, Arithmetic::BLEND, image, &tally, vec![]);
        let report = Report::new("tbuffer", "glass", vec![], screen, &reference, tally, &verdict);
        let short = "Fragments of the frame.";
        let long = "Transparent fragments for which there was no place: the image lacks them.";
        for width in [80, 109, 110, 120] {
            let table = report.table(Some(width));
            assert!(table.lines().all(|line| line.len() <= width.into()), "{width}:\n{table}");
            assert_eq!(table.contains(short), width >= 110, "{width}:\n{table}");
            let hint = "no room for what each figure means";
            assert_eq!(table.contains(hint), width < 110, "{width}:\n{table}");
        }
        assert!(report.table(None).contains(long));
    }

    #[test]
    fn rates_do_not_divide_by_zero() {
        assert_eq!(rate(3, 0), json!(0.0));
        assert_eq!(rate(2, 3), json!(0.6667));
    }
}
