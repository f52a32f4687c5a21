//! The figures of energy, area and time in a report.

use super::entry::{Basis, Entry};
use crate::costs::{CLOCK, Clock, Costs, Logic, MemoryCosts};
use pellucid_machine::Tally;
use serde_json::{Value as Json, json};

/// How far figures are to be trusted: the chapter on energy says why.
const AREA_ERROR: &str =
    "up to 15 % between points of the table; a foundry's memories may be half as large again";
const ACCESS_ERROR: &str =
    "up to 24 % between points of the table; the table by up to a factor of two";
const LEAKAGE_ERROR: &str = "up to 11 % between points of the table; the table by up to a factor of ten, with temperature and kind of transistor";
const LOGIC_ERROR: &str =
    "rows on a chip are 60 to 80 % full; wires have neither area nor length, and nothing is placed";
const TIME_ERROR: &str = "up to 16 % between points of the table; logic and wires may be slower";
const CLOCK_ERROR: &str = "nothing says that a given clock is kept; else up to 16 % between points of the table, and logic and wires may be slower";
const OUTSIDE_ERROR: &str = "currents are the most that a data sheet allows: real devices were measured far below; no wires";

/// What the figures of a DRAM's energy are called here.
const OUTSIDE: [(&str, &str); 5] = [
    ("activates", "outside_activates"),
    ("reads", "outside_reads"),
    ("writes", "outside_writes"),
    ("refreshes", "outside_refreshes"),
    ("background", "outside_background"),
];

/// What each memory on the chip has beside its counts.
pub(super) const MEMORY_FIELDS: [(&str, &str, &str); 5] = [
    ("read_energy", "nJ per frame", "Energy of its reads."),
    ("write_energy", "nJ per frame", "Energy of its writes."),
    ("leakage_energy", "nJ per frame", "Its leakage over the time of a frame."),
    ("area", "mm2", "Its area on the chip."),
    ("access_time", "ns", "From an address to its word."),
];

/// The values of these.
pub(super) fn memory_values(costs: &MemoryCosts) -> [Json; 5] {
    let MemoryCosts { reads_nj, writes_nj, leakage_nj, area_mm2, access_ns } = *costs;
    [reads_nj, writes_nj, leakage_nj, area_mm2, access_ns].map(rounded)
}

/// Where each of these comes from.
pub(super) fn memory_bases(costs: &Costs) -> [Basis; 5] {
    let of = |error| basis(costs.technology.clone(), error);
    [of(ACCESS_ERROR), of(ACCESS_ERROR), of(LEAKAGE_ERROR), of(AREA_ERROR), of(TIME_ERROR)]
}

fn basis(source: String, error: &'static str) -> Basis {
    Basis { source, error }
}

/// To four digits: the last one is more than is known.
pub(super) fn rounded(value: f64) -> Json {
    if value == 0.0 || !value.is_finite() {
        return json!(0);
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    // Two powers of ten that are exact.
    let rounded = match digits {
        0.. => (value * 10f64.powi(digits)).round() / 10f64.powi(digits),
        _ => (value / 10f64.powi(-digits)).round() * 10f64.powi(-digits),
    };
    if rounded.fract() == 0.0 { json!(rounded as u64) } else { json!(rounded) }
}

/// The figures of all memories together.
pub(super) fn entries(costs: &Costs, tally: &Tally) -> Vec<Entry> {
    let mut entries = vec![];
    let mut add = |group, name, value: f64, unit, about, source: &str, error| {
        let basis = Some(basis(source.to_string(), error));
        entries.push(Entry { group, name, value: rounded(value), unit, about, basis });
    };
    let technology = &costs.technology;
    let nj = "nJ per frame";
    if let Some(total) = costs.total_nj() {
        let about = "Energy of all memories, on the chip and outside; left out where what is outside is used and not known.";
        let both = format!("{technology}; outside the file of the DRAM's part");
        add("energy", "total", total, nj, about, &both, ACCESS_ERROR);
    }
    for (name, value, about, error) in [
        (
            "on_chip",
            costs.on_chip_nj(),
            "Energy of memories on the chip: of reads, of writes and of leakage.",
            ACCESS_ERROR,
        ),
        ("reads", costs.reads_nj(), "Reads of memories on the chip.", ACCESS_ERROR),
        ("writes", costs.writes_nj(), "Writes of memories on the chip.", ACCESS_ERROR),
        (
            "leakage",
            costs.leakage_nj(),
            "Leakage of memories on the chip over the time of a frame.",
            LEAKAGE_ERROR,
        ),
    ] {
        add("energy", name, value, nj, about, technology, error);
    }
    for (figure, value) in &costs.outside {
        let name = OUTSIDE.iter().find(|(kind, _)| *kind == figure.name);
        let name = name.map_or(figure.name, |(_, name)| name);
        add("energy", name, *value, nj, figure.about, "the file of the DRAM's part", OUTSIDE_ERROR);
    }
    if !tally.memories.is_empty() {
        let about = "Memories on the chip, frame buffers included; logic is not among it.";
        add("area", "memories", costs.area_mm2(), "mm2", about, technology, AREA_ERROR);
    }
    if let Some(Logic { source, area_mm2, .. }) = &costs.logic {
        let about = "Standard cells of the machine, by --liberty.";
        add("area", "logic", *area_mm2, "mm2", about, source, LOGIC_ERROR);
    }
    if let Some(Clock { mhz, fastest_mhz, frame_ns, .. }) = &costs.clock {
        let source = &format!(
            "{CLOCK}, or where it is not given the slowest memory by {technology}, or logic by --liberty"
        );
        let about = "The clock by which cycles become time: as given, or the fastest that the memories allow, and logic where it is known.";
        add("time", "clock", *mhz, "MHz", about, source, CLOCK_ERROR);
        let about =
            "The fastest clock that the memories on the chip allow, and logic where it is known.";
        let logic = costs.logic.as_ref();
        let by = [technology.as_str()].into_iter().chain(logic.map(|logic| &*logic.source));
        let by = by.collect::<Vec<_>>().join("; ");
        add("time", "fastest_clock", *fastest_mhz, "MHz", about, &by, TIME_ERROR);
        if let Some(Logic { source, period_ns: Some(ns), .. }) = logic {
            let about = "The longest path of logic from a register or memory to the next, with what its end asks for.";
            add("time", "logic_period", *ns, "ns", about, source, LOGIC_ERROR);
        }
        let about = "Time of a frame: its cycles by the clock.";
        add("time", "frame", frame_ns / 1000.0, "us", about, source, CLOCK_ERROR);
    }
    entries
}

/// What matters most of it, in a line.
pub(super) fn headline(costs: &Costs) -> Option<String> {
    let Clock { mhz, given, frame_ns, fastest_mhz, slowest } = costs.clock.as_ref()?;
    let short = |value: f64| super::grouped(&rounded(value));
    let on_chip = costs.on_chip_nj();
    let leaks = (costs.leakage_nj() / on_chip * 100.0).round();
    let mut text = format!(
        "Memories on the chip ({}): {} mm2; a frame takes {} us at {} MHz and {} uJ, {leaks} % of it leakage.",
        costs.technology,
        short(costs.area_mm2()),
        short(frame_ns / 1000.0),
        short(*mhz),
        short(on_chip / 1000.0),
    );
    if let Some(Logic { area_mm2, period_ns, .. }) = &costs.logic {
        text += &format!(" Logic: {} mm2", short(*area_mm2));
        text += &period_ns.map_or(String::new(), |ns| format!(", {} ns", short(ns)));
        text += ".";
    }
    if *given && mhz > fastest_mhz {
        text += &format!(" {slowest} allows {} MHz.", short(*fastest_mhz));
    }
    match costs.outside_nj() {
        Some(outside) => text += &format!(" Outside: {} uJ.", short(outside / 1000.0)),
        None if costs.uses_outside => text += " What is outside is not known.",
        None => {}
    }
    Some(text + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_are_kept() {
        for (value, text) in [
            (0.0, "0"),
            (0.00123456, "0.001235"),
            (0.98765, "0.9877"),
            (12.3456, "12.35"),
            (1234.56, "1235"),
            (123456.0, "123500"),
            (5.0, "5"),
        ] {
            assert_eq!(rounded(value).to_string(), text);
        }
    }
}
