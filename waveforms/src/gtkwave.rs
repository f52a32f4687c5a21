//! What GTKWave needs to show a waveform at once: a save file, and files that translate states to names.
//!
//! All paths in the save file are relative, so the files can be moved together.

use crate::fst::LABEL_CHARS;
use crate::layout::Entry;
use crate::layout::Form;
use crate::vcd::CYCLE_BITS;
use crate::view::{COLOURS, Line, List, Style, Table, View, ViewFile};
use crate::wave::{FileFormat, PERIOD_NS};
use std::fmt::Write;

/// How a trace is drawn: GTKWave's flags.
mod flag {
    pub const HEX: u32 = 0x22;
    pub const DECIMAL: u32 = 0x24;
    pub const BINARY: u32 = 0x28;
    pub const BLANK: u32 = 0x200;
    pub const ASCII: u32 = 0x820;
    pub const TRANSLATED: u32 = 0x2000;
    pub const STEPS: u32 = 0x8000;
    pub const STRETCH: u32 = 0x2_0000;
    pub const HIDDEN: u32 = 0x1000;
    pub const CLOSED: u32 = 0x40_0000;
    pub const GROUP_BEGIN: u32 = 0x80_0000;
    pub const GROUP_END: u32 = 0x100_0000;
}

/// GTKWave's numbers of the colours of troubles, of other events and of labels.
const RED: u32 = 1;
const YELLOW: u32 = 3;
const BLUE: u32 = 5;
/// How many markers can have names: a letter each.
const MARKERS: usize = 26;
/// How many cycles are seen before the one where the view begins.
const BEFORE: u64 = 3;
/// The least pixels that a cycle is wide.
const CYCLE_PIXELS: u32 = 64;
/// Pixels of a character of a value, and of the slanted ends around one.
const CHAR_PIXELS: u32 = 7;
const ENDS_PIXELS: u32 = 10;
/// GTKWave's zoom `-z` shows `2^z` units of time on so many pixels.
const ZOOM_PIXELS: u64 = 200;

/// How many characters of a marker's name a cycle is as wide as, at the zoom where the view begins.
const NAME_CHARS: u64 = 12;

/// The file that translates a table of states.
fn filter(stem: &str, table: &Table) -> String {
    format!("{stem}.states/{}", table.name)
}

/// The lines of that file: a number as it is shown in hexadecimal digits, a colour and a name.
fn translation(table: &Table) -> String {
    let digits = table.bits().div_ceil(4) as usize;
    let mut text = String::new();
    for (number, name) in table.states.variants.iter().enumerate() {
        let (colour, _) = COLOURS[number % COLOURS.len()];
        let _ = writeln!(text, "{number:0digits$x} ?{colour}?{name}");
    }
    text
}

/// What a label is called: its stage, as all labels have one name.
fn alias(entry: &Entry) -> &str {
    entry.scopes.last().map_or("", |scope| &scope[..])
}

/// The zoom at which a cycle is wide enough for its labels.
fn zoom(longest_label: usize) -> f64 {
    let pixels = CYCLE_PIXELS.max(CHAR_PIXELS * longest_label as u32 + ENDS_PIXELS);
    -((PERIOD_NS * ZOOM_PIXELS) as f64 / f64::from(pixels)).log2()
}

/// The save file and those that it names.
pub(crate) fn files(view: &View, list: &List) -> Vec<ViewFile> {
    let (stem, mut text) = (&view.stem, String::new());
    // Writing to a string does not fail.
    let mut line = |args: std::fmt::Arguments| {
        let _ = writeln!(text, "{args}");
    };
    let extension = view.format.extension();
    line(format_args!("[dumpfile] \"{stem}.{extension}\"\n[savefile] \"{stem}.gtkw\""));
    let begins = view.begins();
    let start = begins.saturating_sub(BEFORE).max(view.first.min(begins)) * PERIOD_NS;
    line(format_args!("[timestart] {start}\n[size] 1600 1000\n[pos] -1 -1"));
    // Zoom, the main marker, those with names.
    let mut times = format!("*{:.6} {}", zoom(view.longest_label), begins * PERIOD_NS);
    for k in 0..MARKERS {
        let marker = view.markers.get(k).map(|marker| marker.cycle * PERIOD_NS);
        let _ = write!(times, " {}", marker.map_or("-1".to_string(), |time| time.to_string()));
    }
    line(format_args!("{times}"));
    for (letter, marker) in ('A'..='Z').zip(&view.markers) {
        // A name stands in the middle above its marker. One that the left edge would cut begins there: blanks as
        // long as it is are cut instead.
        let (name, chars) = (&marker.name, marker.name.chars().count());
        let before = marker.cycle.checked_sub(start / PERIOD_NS);
        let is_cut = before.is_some_and(|cycles| 2 * NAME_CHARS * cycles < chars as u64);
        let blanks = if is_cut { chars } else { 0 };
        line(format_args!("[markername] {letter}{:blanks$}{name}", ""));
    }
    line(format_args!("[sst_width] 220\n[signals_width] 260\n[sst_expanded] 0"));
    line(format_args!("@{:x}\ntop.clk", flag::BINARY));
    line(format_args!("@{:x}\ntop.cycle[{}:0]", flag::DECIMAL, CYCLE_BITS - 1));
    for item in &list.lines {
        let (entry, style) = match item {
            Line::Open { name, closed } => {
                let state = if *closed { flag::CLOSED } else { 0 };
                line(format_args!("@{:x}\n-{name}", flag::GROUP_BEGIN | flag::BLANK | state));
                continue;
            }
            Line::Close { name, closed } => {
                let state = if *closed { flag::CLOSED | flag::HIDDEN } else { 0 };
                line(format_args!("@{:x}\n-{name}", flag::GROUP_END | flag::BLANK | state));
                continue;
            }
            Line::Signal { entry, style } => (*entry, *style),
        };
        match style {
            Style::States(number) => {
                let file = filter(stem, &list.tables[number]);
                let flags = flag::HEX | flag::TRANSLATED;
                line(format_args!("@{flags:x}\n^{} {file}", number + 1));
            }
            Style::Trouble => line(format_args!("@{:x}\n[color] {RED}", flag::BINARY)),
            Style::Event => line(format_args!("@{:x}\n[color] {YELLOW}", flag::BINARY)),
            Style::Bit => line(format_args!("@{:x}", flag::BINARY)),
            Style::Level => line(format_args!("@{:x}", flag::DECIMAL | flag::STEPS)),
            Style::Hex => line(format_args!("@{:x}", flag::HEX)),
            Style::Decimal => line(format_args!("@{:x}", flag::DECIMAL)),
            Style::Label => line(format_args!("@{:x}\n[color] {BLUE}", flag::ASCII)),
        }
        let width = match entry.form {
            Form::Bits { width, .. } => width,
            Form::Label { .. } if view.format == FileFormat::Fst => 8 * LABEL_CHARS as u32,
            Form::Label { .. } => 1,
        };
        let range = if width > 1 { format!("[{}:0]", width - 1) } else { String::new() };
        let alias =
            if style == Style::Label { format!("+{{{}}} ", alias(entry)) } else { String::new() };
        line(format_args!("{alias}top.{}{range}", entry.path()));
        if style == Style::Level {
            // Room for the steps.
            line(format_args!("@{:x}\n-", flag::STRETCH));
        }
    }
    let translate = |table| ViewFile { name: filter(stem, table), text: translation(table) };
    let mut files: Vec<ViewFile> = list.tables.iter().map(translate).collect();
    files.push(ViewFile { name: format!("{stem}.gtkw"), text });
    files
}
