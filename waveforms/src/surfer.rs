//! What Surfer needs to show a waveform at once: a command file, and mappings of states to names.
//!
//! Surfer looks for mappings in the folder `.surfer` of where it is started, so it is started beside the
//! waveform: `surfer wave.vcd -c wave.sucl`.

use crate::layout::Entry;
use crate::view::{COLOURS, Line, List, Style, Table, View, ViewFile};
use crate::wave::{FileFormat, PERIOD_NS};
use std::fmt::Write;

fn mapping(table: &Table) -> ViewFile {
    let name = &table.name;
    let mut text = format!("Name = {name}\nBits = {}\n", table.bits());
    for (number, state) in table.states.variants.iter().enumerate() {
        let (_, colour) = COLOURS[number % COLOURS.len()];
        let _ = writeln!(text, "{number}[#{colour}] {state}");
    }
    ViewFile { name: format!(".surfer/mappings/{name}.txt"), text }
}

/// The command file and the mappings.
pub(crate) fn files(view: &View, list: &List) -> Vec<ViewFile> {
    let mut text = String::new();
    // Writing to a string does not fail.
    let mut line = |args: std::fmt::Arguments| {
        let _ = writeln!(text, "{args}");
    };
    line(format_args!("variable_add top.clk\nvariable_add top.cycle\nitem_set_format Unsigned"));
    for item in &list.lines {
        let (entry, style): (&Entry, Style) = match item {
            Line::Open { name, .. } => {
                line(format_args!("divider_add {}", name.replace(": ", "_")));
                continue;
            }
            Line::Close { .. } => continue,
            Line::Signal { entry, style } => (entry, *style),
        };
        line(format_args!("variable_add top.{}", entry.path()));
        match style {
            Style::States(number) => {
                line(format_args!("item_set_format {}", list.tables[number].name));
            }
            Style::Trouble => line(format_args!("item_set_color Red")),
            Style::Event => line(format_args!("item_set_color Yellow")),
            Style::Hex => line(format_args!("item_set_format Hexadecimal")),
            Style::Decimal | Style::Level => line(format_args!("item_set_format Unsigned")),
            Style::Label if view.format == FileFormat::Fst => {
                line(format_args!("item_set_format ASCII"));
            }
            Style::Label | Style::Bit => {}
        }
    }
    line(format_args!("cursor_set {}", view.begins() * PERIOD_NS));
    for marker in &view.markers {
        // A name is one word; one that begins with `#` would be a number.
        let name = marker.name.replace(' ', "_").replace('#', "");
        line(format_args!("marker_set {name} {}", marker.cycle * PERIOD_NS));
    }
    line(format_args!("goto_cursor"));
    let mut files: Vec<ViewFile> = list.tables.iter().map(mapping).collect();
    files.push(ViewFile { name: format!("{}.sucl", view.stem), text });
    files
}
