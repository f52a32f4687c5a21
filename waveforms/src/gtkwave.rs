//! What GTKWave needs to show a dump at once: a save file, and files that translate states to names.
//!
//! The save file lists the clock, then the wires: streams as groups of `valid`, `ready` and payload,
//! events as single bits; then a closed group of registers for each block. States show their names,
//! how many items are in a queue shows as steps. All paths in it are relative, so the files can be
//! moved together.

use pellucid_sim::{Declare, Kind, States};
use std::collections::BTreeSet;
use std::fmt::Write;

/// A file of the set-up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewFile {
    /// Its path, relative to the folder of the dump.
    pub name: String,
    /// What it holds.
    pub text: String,
}

/// A signal of the dump.
struct Found {
    /// The scopes that it stands in, from the outermost on.
    scopes: Vec<String>,
    name: String,
    width: u32,
    kind: Kind,
}

/// Gathers declarations.
#[derive(Default)]
struct Signals {
    scopes: Vec<String>,
    found: Vec<Found>,
}

impl Declare for Signals {
    fn open(&mut self, name: &str) {
        self.scopes.push(name.to_string());
    }
    fn close(&mut self) {
        self.scopes.pop();
    }
    fn signal(&mut self, name: &str, width: u32, kind: Kind) {
        let (scopes, name) = (self.scopes.clone(), name.to_string());
        self.found.push(Found { scopes, name, width, kind });
    }
}

/// How a trace is drawn: GTKWave's flags.
mod flag {
    pub const HEX: u32 = 0x22;
    pub const DECIMAL: u32 = 0x24;
    pub const BINARY: u32 = 0x28;
    pub const BLANK: u32 = 0x200;
    pub const TRANSLATED: u32 = 0x2000;
    pub const STEPS: u32 = 0x8000;
    pub const STRETCH: u32 = 0x2_0000;
    pub const CLOSED: u32 = 0x40_0000;
    pub const GROUP_BEGIN: u32 = 0x80_0000;
    pub const GROUP_END: u32 = 0x100_0000;
}

/// From how many bits on a number is shown in hexadecimal digits: depths and colours are.
const HEX_FROM: u32 = 24;
/// Colours of states, in the order of their numbers.
const COLOURS: [&str; 6] =
    ["DarkSlateGray", "DarkGreen", "DarkBlue", "Purple4", "DarkGoldenrod4", "Maroon"];
/// GTKWave's number of the colour of a thing that should not happen, and of anything else that happens.
const RED: u32 = 1;
const YELLOW: u32 = 3;
/// Events that slow a machine down or lose something.
const TROUBLE: [&str; 4] = ["dropped", "waits", "spilled", "round_failed"];

/// A save file being written.
struct Save {
    text: String,
    stem: String,
    /// Tables of state names, in the order of their first use; GTKWave counts them from 1.
    tables: Vec<&'static States>,
}

impl Save {
    fn line(&mut self, text: std::fmt::Arguments) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{text}");
    }

    fn group(&mut self, name: &str, closed: bool, signals: &[&Found]) {
        let state = if closed { flag::CLOSED } else { 0 };
        self.line(format_args!("@{:x}\n-{name}", flag::GROUP_BEGIN | flag::BLANK | state));
        for signal in signals {
            self.signal(signal);
        }
        self.line(format_args!("@{:x}\n-{name}", flag::GROUP_END | flag::BLANK | state));
    }

    fn signal(&mut self, signal: &Found) {
        let mut path = format!("top.{}.{}", signal.scopes.join("."), signal.name);
        if signal.width > 1 {
            let _ = write!(path, "[{}:0]", signal.width - 1);
        }
        let event = signal.scopes.last().is_some_and(|scope| scope == "events");
        match signal.kind {
            Kind::State(states) => {
                let number = self.table(states);
                let file = filter(&self.stem, number, states);
                self.line(format_args!("@{:x}\n^{number} {file}", flag::HEX | flag::TRANSLATED));
            }
            _ if event => {
                let trouble = TROUBLE.contains(&signal.name.as_str());
                let colour = if trouble { RED } else { YELLOW };
                self.line(format_args!("@{:x}\n[color] {colour}", flag::BINARY));
            }
            _ if signal.width == 1 => self.line(format_args!("@{:x}", flag::BINARY)),
            _ if signal.name == "count" => {
                self.line(format_args!("@{:x}", flag::DECIMAL | flag::STEPS));
            }
            _ if signal.width >= HEX_FROM => self.line(format_args!("@{:x}", flag::HEX)),
            _ => self.line(format_args!("@{:x}", flag::DECIMAL)),
        }
        self.line(format_args!("{path}"));
        if signal.name == "count" && signal.width > 1 {
            // Room for the steps.
            self.line(format_args!("@{:x}\n-", flag::STRETCH));
        }
    }

    fn table(&mut self, states: &'static States) -> usize {
        let known = self.tables.iter().position(|known| *known == states);
        known.map_or_else(
            || {
                self.tables.push(states);
                self.tables.len()
            },
            |at| at + 1,
        )
    }
}

/// The name of the file that translates table `number` of states: several may have one name.
fn filter(stem: &str, number: usize, states: &States) -> String {
    format!("{stem}.states/{}-{number}", states.name)
}

/// The lines of that file: a number as it is shown in hexadecimal digits, a colour and a name.
fn translation(states: &States) -> String {
    let bits = usize::BITS - (states.variants.len().max(2) - 1).leading_zeros();
    let digits = bits.div_ceil(4) as usize;
    let mut text = String::new();
    for (number, name) in states.variants.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let _ = writeln!(text, "{number:0digits$x} ?{colour}?{name}");
    }
    text
}

/// The set-up for the dump `{stem}.vcd` of the signals that `declare` declares, in the scope of a machine
/// with its `registers` and its `wires`.
pub fn gtkwave(stem: &str, declare: impl FnOnce(&mut dyn Declare)) -> Vec<ViewFile> {
    let mut signals = Signals::default();
    declare(&mut signals);
    let found = signals.found;
    let below = |part: &'static str| {
        found.iter().filter(move |s| s.scopes.get(1).is_some_and(|scope| scope == part))
    };

    let mut save = Save { text: String::new(), stem: stem.to_string(), tables: vec![] };
    save.line(format_args!("[dumpfile] \"{stem}.vcd\"\n[savefile] \"{stem}.gtkw\""));
    save.line(format_args!("[timestart] 0\n[size] 1600 1000\n[pos] -1 -1"));
    save.line(format_args!("*-6.000000 -1"));
    save.line(format_args!("[sst_width] 220\n[signals_width] 260\n[sst_expanded] 0"));
    save.line(format_args!("@{:x}\ntop.clk", flag::BINARY));

    // A stream is a scope with `valid` and `ready`; all below it is its payload.
    let with = |name: &str| -> BTreeSet<&[String]> {
        below("wires").filter(|s| s.name == name).map(|s| &s.scopes[..]).collect()
    };
    let (valid, ready) = (with("valid"), with("ready"));
    let streams: BTreeSet<&[String]> = valid.intersection(&ready).copied().collect();
    let group_of = |signal: &Found| {
        let scopes = &signal.scopes;
        let stream = (2..=scopes.len()).find(|len| streams.contains(&scopes[..*len]));
        scopes[2..stream.unwrap_or(scopes.len())].join(".")
    };
    let wires: Vec<&Found> = below("wires").collect();
    for group in wires.chunk_by(|a, b| group_of(a) == group_of(b)) {
        match group_of(group[0]).as_str() {
            "" => group.iter().for_each(|signal| save.signal(signal)),
            name => save.group(name, false, group),
        }
    }
    let registers: Vec<&Found> = below("registers").collect();
    for block in registers.chunk_by(|a, b| a.scopes.get(2) == b.scopes.get(2)) {
        let name = block[0].scopes.get(2).map_or("registers", |name| name);
        save.group(&format!("{name}: registers"), true, block);
    }

    let translate = |(number, states): (usize, &&'static States)| ViewFile {
        name: filter(stem, number, states),
        text: translation(states),
    };
    let mut files: Vec<ViewFile> = (1..).zip(&save.tables).map(translate).collect();
    files.push(ViewFile { name: format!("{stem}.gtkw"), text: save.text });
    files
}
