//! What viewers show of a waveform: which signals, in which order and how, and where to begin.
//!
//! From top to bottom: the clock, the cycle, the machine's own wires and events; then a group for each block
//! in the order in which blocks are declared, that is pipeline order. A block's group has the streams that
//! it receives, its events, the labels of its stages, and a closed group of its registers. Registers that no block
//! has come before them. What was looked for and found stands above the machine's own wires; where something was
//! followed, only groups in which it was are open. Where there are no streams it is not a machine but a block alone, and no
//! group is closed.

use crate::gtkwave;
use crate::layout::{Entry, Form, Layout, StreamOf};
use crate::surfer;
use crate::wave::FileFormat;
use pellucid_sim::{Kind, States};
use std::fmt::Write;
use std::path::Path;

/// A file of a set-up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewFile {
    /// Its path, relative to the folder of the waveform.
    pub name: String,
    /// What it holds.
    pub text: String,
}

/// A point in time with a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Marker {
    /// The cycle.
    pub cycle: u64,
    /// Its name.
    pub name: String,
}

/// What was looked for in a run, and where it was found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Events and stalls that came, by the numbers of their values: see [`Layout::events`] and [`Layout::stalls`].
    pub values: Vec<usize>,
    /// Where a followed item was: numbers of labels, as [`Wave::labels`](crate::Wave::labels) has them. Empty if
    /// none was followed.
    pub labels: Vec<usize>,
}

/// What is shown of a waveform.
#[derive(Clone, Debug, Default)]
pub struct View {
    /// The waveform's file name without its extension.
    pub stem: String,
    /// Its format.
    pub format: FileFormat,
    /// Points of interest. The first is where viewers begin.
    pub markers: Vec<Marker>,
    /// The first cycle that is shown: where viewers begin if there is no marker.
    pub first: u64,
    /// Characters of the longest label: viewers begin with cycles so wide that it fits.
    pub longest_label: usize,
    /// What was looked for.
    pub found: Found,
}

/// A line of the list of signals.
pub(crate) enum Line<'a> {
    /// A group begins.
    Open { name: String, closed: bool },
    /// The innermost group ends.
    Close { name: String, closed: bool },
    /// A signal.
    Signal { entry: &'a Entry, style: Style },
}

/// How a signal is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// One bit.
    Bit,
    /// One bit that tells that something happened.
    Event,
    /// One bit that tells that something slows the machine down or is lost.
    Trouble,
    /// Names of states: table `.0` of the list.
    States(usize),
    /// A number.
    Decimal,
    /// Many bits: depths and colours are.
    Hex,
    /// How many of something there are, as steps.
    Level,
    /// A label.
    Label,
}

/// Colours of states, in the order of their numbers: X11's names, and red, green and blue.
pub(crate) const COLOURS: [(&str, &str); 6] = [
    ("DarkSlateGray", "2f4f4f"),
    ("DarkGreen", "006400"),
    ("DarkBlue", "00008b"),
    ("Purple4", "551a8b"),
    ("DarkGoldenrod4", "8b6508"),
    ("Maroon", "b03060"),
];
/// From how many bits on a number is shown in hexadecimal digits: depths and colours are.
const HEX_FROM: u32 = 24;
/// Registers that say how much of something there is: items of a queue, planes in use.
const LEVELS: [&str; 2] = ["count", "filled"];
/// Events that slow a machine down or lose something.
const TROUBLE: [&str; 5] = ["dropped", "lacking", "waits", "spilled", "round_failed"];

/// The list of signals, with the tables of states' names that it needs.
pub(crate) struct List<'a> {
    pub(crate) lines: Vec<Line<'a>>,
    pub(crate) tables: Vec<Table>,
}

/// The names of a state machine's states.
pub(crate) struct Table {
    /// What it is called: after the register that first uses it.
    pub(crate) name: String,
    pub(crate) states: &'static States,
}

impl Table {
    /// The bits of a state.
    pub(crate) fn bits(&self) -> u32 {
        usize::BITS - (self.states.variants.len().max(2) - 1).leading_zeros()
    }
}

impl<'a> List<'a> {
    fn style(&mut self, entry: &Entry, layout: &Layout) -> Style {
        let (at, width, kind) = match entry.form {
            Form::Label { .. } => return Style::Label,
            Form::Bits { at, width, kind } => (at, width, kind),
        };
        match kind {
            Kind::State(states) => Style::States(self.table(states, entry)),
            _ if at >= layout.sampled => Style::Trouble,
            _ if entry.is_event() && TROUBLE.contains(&&entry.name[..]) => Style::Trouble,
            _ if entry.is_event() => Style::Event,
            _ if width == 1 => Style::Bit,
            _ if LEVELS.contains(&&entry.name[..]) => Style::Level,
            _ if width >= HEX_FROM => Style::Hex,
            _ => Style::Decimal,
        }
    }

    fn table(&mut self, states: &'static States, entry: &Entry) -> usize {
        let known = self.tables.iter().position(|table| table.states == states);
        known.unwrap_or_else(|| {
            let mut name = match entry.scopes.get(2..).and_then(|scopes| scopes.last()) {
                Some(block) => format!("{block}_{}", entry.name),
                None => entry.name.clone(),
            };
            if self.tables.iter().any(|table| table.name == name) {
                let _ = write!(name, "_{}", self.tables.len());
            }
            self.tables.push(Table { name, states });
            self.tables.len() - 1
        })
    }

    /// Entries in a group of their own, closed if it is wanted so, or if what was followed is not there.
    fn group(
        &mut self,
        name: &str,
        closed: bool,
        entries: &[&'a Entry],
        layout: &Layout,
        found: &Found,
    ) {
        if entries.is_empty() {
            return;
        }
        let closed = closed || !found.opens(entries.iter().copied());
        self.lines.push(Line::Open { name: name.to_string(), closed });
        self.signals(entries, layout);
        self.lines.push(Line::Close { name: name.to_string(), closed });
    }

    fn signals(&mut self, entries: &[&'a Entry], layout: &Layout) {
        for entry in entries {
            let style = self.style(entry, layout);
            self.lines.push(Line::Signal { entry, style });
        }
    }

    /// The list for a machine.
    pub(crate) fn new(layout: &'a Layout, found: &Found) -> List<'a> {
        let streams = &layout.streams;
        let mut list = List { lines: vec![], tables: vec![] };
        let part = |name: &'static str| {
            let entries = layout.entries.iter();
            entries.filter(move |e| e.scopes.get(1).is_some_and(|scope| scope == name))
        };
        let shown = |name| part(name).filter(|entry| entry.shown).collect::<Vec<&Entry>>();
        let (registers, wires, memories) = (shown("registers"), shown("wires"), shown("memories"));

        // A block is a part of the machine, or a part of one that receives a stream.
        let is_block = |name: &str| streams.iter().any(|stream| stream.to == name);
        let block_of = |scopes: &[String]| -> String {
            let below = scopes.get(2..).unwrap_or_default();
            let deepest = below.iter().rposition(|name| is_block(name)).unwrap_or(0);
            below.iter().take(deepest + 1).cloned().collect::<Vec<_>>().join(".")
        };
        let mut blocks: Vec<String> = vec![];
        for entry in part("registers") {
            let block = block_of(&entry.scopes);
            if !block.is_empty() && !blocks.contains(&block) {
                blocks.push(block);
            }
        }

        // A stream is a scope with `valid` and `ready`; all below it is its payload.
        let with = |name: &str, scopes: &[String]| {
            part("wires").any(|e| e.name == name && e.scopes == scopes)
        };
        let stream_of = |entry: &Entry| {
            let is_stream = |len: &usize| {
                let scopes = &entry.scopes[..*len];
                with("valid", scopes) && with("ready", scopes)
            };
            (3..=entry.scopes.len()).find(is_stream)
        };
        // Where a wire is shown: the block that receives its stream, or the block that it is a wire of.
        let home = |entry: &Entry| -> Option<&String> {
            let stream = stream_of(entry).and_then(|len| entry.scopes.get(len - 1));
            let to = stream.and_then(|name| streams.iter().find(|stream| stream.name == *name));
            let receiver = to.and_then(|StreamOf { to, .. }| {
                blocks.iter().find(|block| block.rsplit('.').next() == Some(&to[..]))
            });
            receiver.or_else(|| blocks.iter().find(|block| entry.scopes.get(2) == Some(*block)))
        };
        let group_of = |entry: &Entry| {
            let end = stream_of(entry).unwrap_or(entry.scopes.len());
            entry.scopes.get(2..end).unwrap_or_default().join(".")
        };
        let show_wires = |list: &mut List<'a>, of: Option<&String>| {
            let mine: Vec<&Entry> = wires.iter().copied().filter(|e| home(e) == of).collect();
            for group in mine.chunk_by(|a, b| group_of(a) == group_of(b)) {
                // A label alone is named after its stream and needs no group around it.
                let label = group.len() == 1 && matches!(group[0].form, Form::Label { .. });
                match &group_of(group[0])[..] {
                    "" => list.signals(group, layout),
                    _ if label => list.signals(group, layout),
                    name => list.group(name, false, group, layout, found),
                }
            }
        };
        for value in &found.values {
            let is_value = |e: &Entry| matches!(e.form, Form::Bits { at, .. } if at == *value);
            let Some(entry) = wires.iter().copied().find(|entry| is_value(entry)) else { continue };
            if *value < layout.sampled {
                list.signals(&[entry], layout);
                continue;
            }
            // A stall, with the stream that it is of.
            let stream: Vec<&Entry> =
                wires.iter().copied().filter(|other| other.scopes == entry.scopes).collect();
            list.group(&group_of(entry), false, &stream, layout, &Found::default());
        }
        show_wires(&mut list, None);
        let alone = streams.is_empty();
        let own: Vec<&Entry> =
            registers.iter().copied().filter(|e| block_of(&e.scopes).is_empty()).collect();
        let of = own.first().map_or("", |entry| &entry.scopes[0]);
        list.group(&format!("{of}: registers"), !alone, &own, layout, found);
        for block in &blocks {
            let begin = list.lines.len();
            show_wires(&mut list, Some(block));
            let mine = registers.iter().copied().filter(|e| block_of(&e.scopes) == *block);
            let (labels, rest): (Vec<&Entry>, Vec<&Entry>) =
                mine.partition(|e| matches!(e.form, Form::Label { .. }));
            list.signals(&labels, layout);
            let open = found.opens(list.lines[begin..].iter().filter_map(Line::entry));
            // A block that has only registers needs no group around theirs.
            let grouped = list.lines.len() > begin;
            list.group(&format!("{block}: registers"), !alone, &rest, layout, found);
            if grouped {
                let (name, closed) = (block.clone(), !open);
                list.lines.insert(begin, Line::Open { name: name.clone(), closed });
                list.lines.push(Line::Close { name, closed });
            }
        }
        // Words are there because they are asked for: they stay open.
        let memory_of = |entry: &Entry| entry.scopes.get(2..).unwrap_or_default().join(".");
        for memory in memories.chunk_by(|a, b| memory_of(a) == memory_of(b)) {
            let name = format!("{}: words", memory_of(memory[0]));
            list.group(&name, false, memory, layout, &Found::default());
        }
        list
    }
}

impl Line<'_> {
    fn entry(&self) -> Option<&Entry> {
        match self {
            Line::Signal { entry, .. } => Some(entry),
            Line::Open { .. } | Line::Close { .. } => None,
        }
    }
}

impl Found {
    /// Whether a group of these entries is to be open.
    fn opens<'e>(&self, mut entries: impl Iterator<Item = &'e Entry>) -> bool {
        let was_here = |form| matches!(form, Form::Label { at } if self.labels.contains(&at));
        self.labels.is_empty() || entries.any(|entry| was_here(entry.form))
    }
}

impl View {
    /// The files of the set-ups for GTKWave and Surfer.
    pub fn files(&self, layout: &Layout) -> Vec<ViewFile> {
        let list = List::new(layout, &self.found);
        let mut files = gtkwave::files(self, &list);
        files.extend(surfer::files(self, &list));
        files
    }

    /// Writes these files into the folder of the waveform: `make` makes a folder, `put` writes a text.
    ///
    /// # Errors
    /// What either says.
    pub fn write<E>(
        &self,
        layout: &Layout,
        folder: &Path,
        make: impl Fn(&Path) -> Result<(), E>,
        put: impl Fn(&Path, &str) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut made = None;
        for file in self.files(layout) {
            let path = folder.join(file.name);
            if path.parent() != made.as_deref() {
                made = path.parent().map(Path::to_owned);
                made.as_deref().map_or(Ok(()), &make)?;
            }
            put(&path, &file.text)?;
        }
        Ok(())
    }

    /// Where viewers begin.
    pub(crate) fn begins(&self) -> u64 {
        self.markers.first().map_or(self.first, |marker| marker.cycle)
    }
}
