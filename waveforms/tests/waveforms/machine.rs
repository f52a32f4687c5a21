//! A machine of a few signals, and waveforms of it.

use pellucid_sim::Sampler;
use pellucid_sim::{Declare, Kind, Label, Sink, States};
use pellucid_waveforms::{FileFormat, Layout, StreamOf, Wave};
use std::fs::File;
use std::path::PathBuf;
use tempfile::TempDir;

pub const STATES: &States = &States { name: "Fsm", variants: &["Idle", "Run", "Stall"] };
/// Another table of the same name.
pub const OTHERS: &States = &States { name: "Fsm", variants: &["Idle", "Load", "Drain", "Stall"] };

/// Every value by its path below the machine, in the order of the declarations, and its width.
pub const SIGNALS: [(&str, u32); 11] = [
    ("registers.store.fsm", 2),
    ("registers.store.stage.valid", 1),
    ("registers.store.stage.payload.pixel", 12),
    ("registers.store.queue.count", 3),
    ("registers.scan.fsm", 2),
    ("registers.scan.entries[3]", 64),
    ("wires.phase", 2),
    ("wires.passed.valid", 1),
    ("wires.passed.ready", 1),
    ("wires.passed.payload.z", 24),
    ("wires.events.dropped", 1),
];
/// Where the value `passed.valid` is among them, and `passed.ready` behind it.
const VALID: usize = 7;
/// Every label by its path, with the value that it is shown by.
pub const LABELS: [(&str, usize); 2] =
    [("registers.store.stage.label", 1), ("wires.passed.label", VALID)];

pub fn declare(to: &mut dyn Declare) {
    to.open("machine");
    to.open("registers");
    to.open("store");
    to.signal("fsm", 2, Kind::State(STATES));
    to.open("stage");
    to.signal("valid", 1, Kind::Flag);
    to.open("payload");
    to.signal("pixel", 12, Kind::Bits(32));
    to.label("label");
    to.close();
    to.close();
    to.open("queue");
    to.signal("count", 3, Kind::Bits(32));
    to.close();
    to.close();
    to.open("scan");
    to.signal("fsm", 2, Kind::State(OTHERS));
    to.signal("entries[3]", 64, Kind::Bits(64));
    to.close();
    to.close();
    to.open("wires");
    to.signal("phase", 2, Kind::State(STATES));
    to.open("passed");
    to.signal("valid", 1, Kind::Flag);
    to.signal("ready", 1, Kind::Flag);
    to.open("payload");
    to.signal("z", 24, Kind::Bits(32));
    to.label("label");
    to.close();
    to.close();
    to.open("events");
    to.signal("dropped", 1, Kind::Flag);
    to.close();
    to.close();
    to.close();
}

pub fn layout() -> Layout {
    Layout::new(vec![StreamOf { name: "passed".into(), to: "store".into() }], declare)
}

/// Values that change now and then, at every width.
pub fn values(cycle: u64) -> [u64; 11] {
    let mixed = (cycle / 3).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let wide = if cycle == 7 { u64::MAX } else { mixed };
    [
        cycle / 5 % 3,
        cycle / 2 % 2,
        mixed >> 52,
        cycle % 8,
        cycle % 4,
        wide,
        cycle / 40 % 3,
        cycle / 3 % 2,
        cycle % 3 / 2,
        mixed >> 40,
        u64::from(cycle % 50 == 9),
    ]
}

pub fn labels(cycle: u64) -> [Label; 2] {
    [Label::new(cycle as u32 / 4, 3, 1000), Label::new(cycle as u32 / 6 + 5, 8191, 0)]
}

/// The stall of `passed` in a cycle.
pub fn stall(cycle: u64) -> u64 {
    let values = values(cycle);
    values[VALID] & !values[VALID + 1] & 1
}

/// What is to be read of label `k` in a cycle: nothing if its stage is empty.
pub fn shown_label(cycle: u64, k: usize) -> String {
    if values(cycle)[LABELS[k].1] == 1 { labels(cycle)[k].to_string() } else { String::new() }
}

/// Samples a cycle.
pub fn sample(cycle: u64) -> impl FnOnce(&mut Sampler) {
    move |to| {
        values(cycle).into_iter().for_each(|value| to.push(value));
        labels(cycle).into_iter().for_each(|label| to.label(label));
    }
}

/// Shows a cycle.
pub fn show(wave: &mut Wave, cycle: u64) {
    wave.sample(sample(cycle));
    wave.show(cycle).unwrap();
}

/// Remembers a cycle in which everything is as it is in cycle `like`.
pub fn remember(wave: &mut Wave, cycle: u64, like: u64) {
    wave.sample(sample(like));
    wave.remember(cycle).unwrap();
}

/// A waveform in a folder of its own.
pub struct Dump {
    folder: TempDir,
    format: FileFormat,
}

impl Dump {
    pub fn path(&self) -> PathBuf {
        self.folder.path().join("wave").with_extension(self.format.extension())
    }
    pub fn bytes(&self) -> Vec<u8> {
        std::fs::read(self.path()).unwrap()
    }
    pub fn text(&self) -> String {
        String::from_utf8(self.bytes()).unwrap()
    }
}

/// The waveform that `play` writes, with a history of so many cycles.
pub fn dump(format: FileFormat, layout: Layout, history: usize, play: impl FnOnce(Wave)) -> Dump {
    let dump = Dump { folder: tempfile::tempdir().unwrap(), format };
    let file = File::create(dump.path()).unwrap();
    play(Wave::new(format, file, layout, history).unwrap());
    dump
}

/// The waveform of some cycles, with gaps between those that do not follow each other.
pub fn dump_cycles(format: FileFormat, cycles: impl IntoIterator<Item = u64>) -> Dump {
    dump(format, layout(), 0, |mut wave| {
        let mut next = None;
        for cycle in cycles {
            if let Some(next) = next.filter(|next| cycle > *next) {
                wave.gap(next).unwrap();
            }
            show(&mut wave, cycle);
            next = Some(cycle + 1);
        }
        wave.finish(next.unwrap_or(0)).unwrap();
    })
}
