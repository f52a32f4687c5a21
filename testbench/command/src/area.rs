//! `pellucid area`: what an architecture takes as hardware.

mod standard;

use super::machine::MachineArgs;
use super::technology::{LibertyArgs, TechnologyArgs};
use super::{say, side};
use clap::Args;
use comfy_table::{Table, presets};
use pellucid_machine::params::Value;
use pellucid_machine::pixel::Screen;
use pellucid_testbench::area::standard as cells;
use pellucid_testbench::area::{Area, Cells, Part, measure};
use pellucid_testbench::export::modules;
use pellucid_testbench::report::{align_right, config_json, grouped};
use serde_json::{Value as Json, json};

/// What the figures mean.
const LEGEND: &str = "A block's figures include all that is in it. Cells are those of the Xilinx 7 \
                      series: look-up tables\nof six inputs, those of small memories and shift \
                      registers included; RAM blocks of 36 Kbit, .5 for one\nof 18 Kbit; DSP slices \
                      as multipliers. Memory bits are the model's, whatever they are mapped to.\nA \
                      path's cells are look-up tables, carries, wide multiplexers and multipliers; \
                      nothing is placed or\nrouted, so there is no clock rate.\n";

#[derive(Args)]
pub(super) struct AreaArgs {
    #[command(flatten)]
    machine: MachineArgs,
    /// Columns of the screen, 1 to 8192
    #[arg(long, value_name = "PIXELS", default_value = "640", value_parser = side, allow_hyphen_values = true)]
    width: u32,
    /// Rows of the screen, 1 to 8192
    #[arg(long, value_name = "PIXELS", default_value = "480", value_parser = side, allow_hyphen_values = true)]
    height: u32,
    #[command(flatten)]
    liberty: LibertyArgs,
    #[command(flatten)]
    technology: TechnologyArgs,
    /// Print as JSON
    #[arg(long)]
    json: bool,
    /// Show no sign of progress
    #[arg(long, short)]
    quiet: bool,
}

/// Counts and prints.
pub(super) fn area(args: &AreaArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let screen = Screen { width: args.width, height: args.height, background: 0 };
    let technology = args.technology.open()?;
    let library = args.liberty.open()?;
    let machine = args.machine.build(screen, 1)?;
    let netlist = machine.netlist();
    let modules = modules(arch.name, screen, &*machine, &netlist);
    if let Some(library) = library {
        let silicon = cells::measure(&netlist, &modules, &library, &technology, args.quiet)?;
        say(&if args.json {
            format!("{:#}\n", standard::as_json(arch.name, args, &machine.values(), &silicon))
        } else {
            standard::as_text(arch.name, args, &silicon)
        })?;
        return Ok(true);
    }
    let area = measure(&netlist, &modules, args.quiet)?;
    say(&if args.json {
        format!("{:#}\n", as_json(arch.name, args, &machine.values(), &area))
    } else {
        as_text(arch.name, args, &area)
    })?;
    Ok(true)
}

fn ram_blocks(cells: &Cells) -> Json {
    let halves = cells.half_rams;
    if halves.is_multiple_of(2) { json!(halves / 2) } else { json!(halves as f64 / 2.0) }
}

/// The figures of a part, with their names.
fn figures(part: &Part) -> [(&'static str, Json); 5] {
    let cells = &part.cells;
    [
        ("luts", json!(cells.luts)),
        ("flip_flops", json!(cells.flip_flops)),
        ("ram_blocks", ram_blocks(cells)),
        ("multipliers", json!(cells.multipliers)),
        ("memory_bits", json!(cells.memory_bits)),
    ]
}

fn as_text(arch: &str, args: &AreaArgs, area: &Area) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_row([
        "INSTANCE",
        "BLOCK",
        "LUTS",
        "FLIP-FLOPS",
        "RAM BLOCKS",
        "MULTIPLIERS",
        "MEMORY BITS",
    ]);
    for part in &area.parts {
        let last = part.path.rsplit('.').next().filter(|name| !name.is_empty()).unwrap_or(arch);
        let mut row = vec![format!("{}{last}", "  ".repeat(part.depth())), part.block.to_string()];
        row.extend(figures(part).iter().map(|(_, figure)| grouped(figure)));
        table.add_row(row);
    }
    align_right(&mut table, &[2, 3, 4, 5, 6]);
    let lines = table.to_string();
    let lines: Vec<&str> =
        lines.lines().map(|l| l.strip_prefix(' ').unwrap_or(l).trim_end()).collect();
    let mut text = format!(
        "{arch} for a screen of {}x{} pixels, by {}\n\n{}\n\n",
        args.width,
        args.height,
        area.tool,
        lines.join("\n")
    );
    let through = area.through.iter().map(|path| if path.is_empty() { arch } else { path });
    text += &format!(
        "Longest path from a register or memory to the next: {} cells, through {}.\n",
        area.longest_path,
        through.collect::<Vec<_>>().join(", ")
    );
    for cell in &area.unknown {
        text += &format!("Cells of a type that is not known here, not counted: {cell}.\n");
    }
    text + "\n" + LEGEND
}

fn as_json(arch: &str, args: &AreaArgs, config: &[(String, Value)], area: &Area) -> Json {
    let blocks: Vec<Json> = area
        .parts
        .iter()
        .map(|part| {
            let mut block = json!({ "path": part.path, "block": part.block });
            for (name, figure) in figures(part) {
                block[name] = figure;
            }
            block
        })
        .collect();
    json!({
        "arch": arch,
        "width": args.width,
        "height": args.height,
        "config": config_json(config),
        "tool": area.tool,
        "family": "xc7",
        "blocks": blocks,
        "longest_path": { "cells": area.longest_path, "through": area.through },
        "unknown_cells": area.unknown,
    })
}
