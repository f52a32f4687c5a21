//! What `pellucid area --liberty` prints.

use super::AreaArgs;
use comfy_table::{Table, presets};
use pellucid_machine::params::Value;
use pellucid_testbench::area::standard::{Block, Silicon};
use pellucid_testbench::report::{align_right, config_json, grouped};
use serde_json::{Value as Json, json};

/// What the figures mean.
const LEGEND: &str = "A block's figures include all that is in it. Logic is the cells alone, and nothing is placed or routed: wires take \
                      no\narea and no time. Memories are macros of the table, whatever the library's node is.\n";

/// Square millimetres: cells of new nodes need more digits.
fn mm2(area: f64) -> String {
    if area > 0.0 && area < 0.001 { format!("{area:.6}") } else { format!("{area:.4}") }
}

/// Nanoseconds to three digits behind the point.
fn ns(time: f64) -> f64 {
    (time * 1000.0).round() / 1000.0
}

/// As a table.
pub(super) fn as_text(arch: &str, args: &AreaArgs, silicon: &Silicon) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_row(["INSTANCE", "BLOCK", "CELLS", "LOGIC, MM2", "MEMORIES, MM2"]);
    for block in &silicon.blocks {
        let Block { path, block: kind, cells, logic_mm2, memories_mm2 } = block;
        let last = path.rsplit('.').next().filter(|name| !name.is_empty()).unwrap_or(arch);
        table.add_row([
            format!("{}{last}", "  ".repeat(block.depth())),
            kind.to_string(),
            grouped(&json!(cells)),
            mm2(*logic_mm2),
            mm2(*memories_mm2),
        ]);
    }
    align_right(&mut table, &[2, 3, 4]);
    let lines = table.to_string();
    let lines: Vec<&str> =
        lines.lines().map(|l| l.strip_prefix(' ').unwrap_or(l).trim_end()).collect();
    let mut text = format!(
        "{arch} for a screen of {}x{} pixels in the cells of {}, by {};\nmemories by {}\n\n{}\n\n",
        args.width,
        args.height,
        silicon.library,
        silicon.tools.join(" and "),
        silicon.memories,
        lines.join("\n")
    );
    if let Some(path) = &silicon.longest {
        let through: Vec<&str> =
            path.through.iter().map(|p| if p.is_empty() { arch } else { p }).collect();
        text += &format!(
            "Shortest period: {} ns. The longest path from a register or memory to the next has {} cells, through\n{}.\n",
            ns(path.period_ns),
            path.cells,
            through.join(", ")
        );
    }
    text + "\n" + LEGEND
}

/// As JSON.
pub(super) fn as_json(
    arch: &str,
    args: &AreaArgs,
    config: &[(String, Value)],
    silicon: &Silicon,
) -> Json {
    let block = |block: &Block| {
        json!({
            "path": block.path,
            "block": block.block,
            "cells": block.cells,
            "logic_mm2": block.logic_mm2,
            "memories_mm2": block.memories_mm2,
        })
    };
    let blocks: Vec<Json> = silicon.blocks.iter().map(block).collect();
    let longest = silicon.longest.as_ref().map(|path| {
        json!({ "period_ns": ns(path.period_ns), "cells": path.cells, "through": path.through })
    });
    json!({
        "arch": arch,
        "width": args.width,
        "height": args.height,
        "config": config_json(config),
        "tools": silicon.tools,
        "library": silicon.library,
        "memories": silicon.memories,
        "blocks": blocks,
        "cells": silicon.kinds,
        "longest_path": longest,
    })
}
