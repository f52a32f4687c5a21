//! What a machine takes in standard cells: Yosys maps its Verilog to those of a library, OpenSTA times them, and memories are priced by a
//! table.
//!
//! Each block is mapped by itself, and the whole is flattened then, so that every cell's name says where it stands. Outputs are
//! buffered by what `abc` is told of the cells before and behind. Nothing is placed or routed: wires have no length.

use super::liberty::Library;
use super::tool::{self, Tool};
use super::tree::Tree;
use super::{AreaError, YOSYS, cache, cells};
use crate::costs::{Logic, Memory, Technology, memory};
use crate::export::modules;
use pellucid_machine::Model;
use pellucid_sim::netlist::Module;
use pellucid_verilog::File;
use pellucid_verilog::macros::{Macro, with_macros};
use std::collections::BTreeMap;

/// The timer.
const TIMER: [&str; 1] = ["sta"];
/// The library where none is named, as Debian's `qflow-tech-osu018` has it.
pub const DEFAULT_LIBRARY: &str = "/usr/share/qflow/tech/osu018/osu018_stdcells.lib";

/// What tools are told, and what they leave.
const LIBRARY: &str = "cells.lib";
const MACROS: &str = "macros.lib";
const CONSTRAINTS: &str = "constraints.txt";
const SCRIPT: &str = "area.ys";
const MAPPED: &str = "mapped.blif";
const NETLIST: &str = "mapped.v";
const TIMING: &str = "timing.tcl";
const LOG: &str = "log.txt";
const PATH: &str = "path.txt";
/// A period that every path keeps, in the library's units.
const LONG: &str = "1000000";

/// What a block takes, with all that is in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Where it stands below the machine; empty for the machine itself.
    pub path: String,
    /// Its block.
    pub block: &'static str,
    /// Cells.
    pub cells: u64,
    /// Their area, mm2.
    pub logic_mm2: f64,
    /// Area of its memories, mm2.
    pub memories_mm2: f64,
}

impl Block {
    /// How deep in the hierarchy it stands.
    pub fn depth(&self) -> usize {
        if self.path.is_empty() { 0 } else { 1 + self.path.matches('.').count() }
    }
}

/// The path that needs the longest period.
#[derive(Clone, Debug, PartialEq)]
pub struct LongestPath {
    /// The shortest period, ns: the path with what its end asks for.
    pub period_ns: f64,
    /// Cells on it.
    pub cells: u64,
    /// The blocks that it goes through, in order.
    pub through: Vec<String>,
}

/// What a machine takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Silicon {
    /// The tools and their versions.
    pub tools: Vec<String>,
    /// The library's path.
    pub library: String,
    /// Where areas and times of memories come from.
    pub memories: String,
    /// The machine and its blocks, each before those in it.
    pub blocks: Vec<Block>,
    /// How many there are of each kind of cell.
    pub kinds: BTreeMap<String, u64>,
    /// The longest path from a register or memory to the next; none where there is none.
    pub longest: Option<LongestPath>,
}

/// What Yosys is told.
fn script(top: &str, files: &[File]) -> String {
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let names = names.join(" ");
    format!(
        "read_verilog {names}\n\
         hierarchy -check -top {top}\n\
         synth -top {top}\n\
         dfflibmap -liberty {LIBRARY}\n\
         abc -liberty {LIBRARY} -constr {CONSTRAINTS}\n\
         flatten\n\
         setundef -zero\n\
         opt_clean -purge\n\
         write_blif -cname {MAPPED}\n\
         splitnets\n\
         opt_clean -purge\n\
         write_verilog -norename -noattr -noexpr -nohex -nodec {NETLIST}\n"
    )
}

/// What OpenSTA is told.
fn timing(top: &str) -> String {
    format!(
        "read_liberty {LIBRARY}\nread_liberty {MACROS}\nread_verilog {NETLIST}\nlink_design {top}\n\
         create_clock -name clk -period {LONG} [get_ports clk]\n\
         report_checks -path_delay max -format full -digits 4\nexit\n"
    )
}

/// The macros as a library: a word is there as long after the edge as the table says.
fn macro_library(macros: &[Macro], technology: &Technology) -> String {
    let mut widths: Vec<u32> =
        macros.iter().flat_map(|m| m.inputs().into_iter().map(|(_, bits)| bits)).collect();
    widths.sort_unstable();
    widths.dedup();
    let mut text = String::from(
        "library (macros) {\n  delay_model : table_lookup;\n  time_unit : \"1ns\";\n  voltage_unit : \"1V\";\n  \
         current_unit : \"1uA\";\n  pulling_resistance_unit : \"1kohm\";\n  capacitive_load_unit (1, ff);\n",
    );
    for edge in ["rise", "fall"] {
        text += &format!(
            "  slew_upper_threshold_pct_{edge} : 80;\n  slew_lower_threshold_pct_{edge} : 20;\n  \
             input_threshold_pct_{edge} : 50;\n  output_threshold_pct_{edge} : 50;\n"
        );
    }
    for bits in widths {
        let last = bits - 1;
        text += &format!(
            "  type (bits_{bits}) {{ base_type : array; data_type : bit; bit_width : {bits}; bit_from : {last}; \
             bit_to : 0; downto : true; }}\n"
        );
    }
    let value = |name: &str, value: f64| format!("{name} (scalar) {{ values (\"{value:.6}\"); }} ");
    let setup = format!(
        "timing () {{ related_pin : \"clk\"; timing_type : setup_rising; {}{}}}",
        value("rise_constraint", 0.0),
        value("fall_constraint", 0.0)
    );
    for size in macros {
        let (name, bits) = (size.name(), size.bits);
        let access =
            technology.price(&Memory { words: size.words, bits, ports: size.ports }).access_ns;
        text += &format!(
            "  cell ({name}) {{\n    area : 0;\n    pin (clk) {{ direction : input; clock : true; capacitance : 1; }}\n"
        );
        for (input, bits) in size.inputs() {
            text += &format!(
                "    bus ({input}) {{ bus_type : bits_{bits}; direction : input; capacitance : 1; {setup} }}\n"
            );
        }
        let delays: String = [
            ("cell_rise", access),
            ("cell_fall", access),
            ("rise_transition", 0.05),
            ("fall_transition", 0.05),
        ]
        .map(|(name, ns)| value(name, ns))
        .concat();
        text += &format!(
            "    bus (data_o) {{ bus_type : bits_{bits}; direction : output; timing () {{ related_pin : \"clk\"; \
             timing_type : rising_edge; {delays}}} }}\n  }}\n"
        );
    }
    text + "}\n"
}

/// Reads what OpenSTA says of the longest path: none if there is none.
fn follow(said: &str, tree: &Tree, time_ns: f64) -> Option<LongestPath> {
    let number_before = |what: &str| {
        let line = said.lines().find(|line| line.trim_end().ends_with(what))?;
        line.split_whitespace().next()?.parse::<f64>().ok()
    };
    let arrival = number_before("data arrival time")?;
    let setup = number_before("library setup time").unwrap_or(0.0);
    let mut path =
        LongestPath { period_ns: (arrival - setup) * time_ns, cells: 0, through: vec![] };
    // Of each cell the pin at which the path leaves it, and that at which it ends.
    let lines = said.lines().take_while(|line| !line.contains("data arrival time"));
    let mut last = "";
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, _, "^" | "v", pin, kind] = words[..] else { continue };
        let Some((cell, _)) = pin.rsplit_once('/') else { continue };
        if !kind.starts_with('(') || cell == last {
            continue;
        }
        last = cell;
        path.cells += 1;
        let at = tree.around(cell).last().copied().unwrap_or(0);
        let name = &tree.places[at].path;
        if path.through.last() != Some(name) {
            path.through.push(name.clone());
        }
    }
    Some(path)
}

/// Counts the cells of a mapped design.
fn count(
    blif: &str,
    tree: &Tree,
    library: &Library,
    blocks: &mut [Block],
) -> Result<BTreeMap<String, u64>, AreaError> {
    let mut kinds = BTreeMap::new();
    for (cell, name) in cells(blif) {
        if cell.starts_with("sram_") {
            continue;
        }
        let area = library.area(cell).ok_or_else(|| AreaError::Cell {
            file: library.file.clone(),
            cell: cell.to_string(),
        })?;
        *kinds.entry(cell.to_string()).or_insert(0) += 1;
        for k in tree.around(name) {
            blocks[k].cells += 1;
            blocks[k].logic_mm2 += area / 1e6;
        }
    }
    Ok(kinds)
}

fn found(names: &[&'static str], ask: &str, missing: AreaError) -> Result<Tool, AreaError> {
    tool::find(names, ask).ok_or(missing)
}

/// Measures what a machine takes. `top` is the last of `files`.
///
/// # Errors
/// Yosys or OpenSTA is not here or fails, the library lacks a cell, or there is no room for the tools' files.
pub fn measure(
    machine: &Module,
    files: &[File],
    library: &Library,
    technology: &Technology,
    quiet: bool,
) -> Result<Silicon, AreaError> {
    let yosys = found(&YOSYS, "-V", AreaError::NoTool)?;
    let timer = found(&TIMER, "-version", AreaError::NoTimer)?;
    let mut memories = vec![];
    let tree = Tree::with_memories(machine, &mut |at, ram| {
        memories.push((at, technology.price(&memory(&ram.info)).area_mm2))
    });
    let block = |place: &super::tree::Place| Block {
        path: place.path.clone(),
        block: place.block,
        cells: 0,
        logic_mm2: 0.0,
        memories_mm2: 0.0,
    };
    let mut blocks: Vec<Block> = tree.places.iter().map(block).collect();
    for (at, mm2) in memories {
        tree.over(at).for_each(|k| blocks[k].memories_mm2 += mm2);
    }

    let top = files.last().and_then(|file| file.name.strip_suffix(".v")).unwrap_or_default();
    let (files, macros) = with_macros(machine, files);
    let told = [
        (LIBRARY, library.text.clone()),
        (MACROS, macro_library(&macros, technology)),
        (
            CONSTRAINTS,
            format!("set_driving_cell {}\nset_load {}\n", library.driver, library.load_ff),
        ),
        (SCRIPT, script(top, &files)),
        (TIMING, timing(top)),
    ]
    .map(|(name, text)| File { name: name.to_string(), text });
    let all: Vec<File> = files.into_iter().chain(told).collect();
    let key = cache::key(&[&yosys.version, &timer.version], &all);
    let (mapped, said) = match cache::get(key) {
        Some(both) => both,
        None => {
            let scratch = tool::folder(&all)?;
            yosys.run(&scratch, (&["-q", "-s", SCRIPT], LOG), "maps the design to cells", quiet)?;
            timer.run(&scratch, (&["-exit", TIMING], PATH), "times the cells", quiet)?;
            let said = timer.left(&scratch, PATH)?;
            if let Some(error) = said.lines().find(|line| line.starts_with("Error")) {
                return Err(timer.failed(error.to_string()));
            }
            // Of the mapped design the cells and their names alone.
            let mapped = yosys.left(&scratch, MAPPED)?;
            let mapped =
                cells(&mapped).map(|(cell, name)| format!(".subckt {cell} \n.cname {name}\n"));
            let mapped: String = mapped.collect();
            cache::put(key, &mapped, &said);
            (mapped, said)
        }
    };
    let kinds = count(&mapped, &tree, library, &mut blocks)?;
    Ok(Silicon {
        tools: vec![yosys.version, format!("OpenSTA {}", timer.version)],
        library: library.file.clone(),
        memories: technology.name(),
        longest: follow(&said, &tree, library.time_ns),
        blocks,
        kinds,
    })
}

/// What the logic of a machine of the architecture `arch` takes.
///
/// # Errors
/// As [`measure`].
pub fn logic(
    arch: &'static str,
    machine: &dyn Model,
    library: &Library,
    technology: &Technology,
    quiet: bool,
) -> Result<Logic, AreaError> {
    let netlist = machine.netlist();
    let modules = modules(arch, machine.screen(), machine, &netlist);
    let silicon = measure(&netlist, &modules, library, technology, quiet)?;
    Ok(Logic {
        source: format!("{}, by {}", silicon.library, silicon.tools.join(" and ")),
        area_mm2: silicon.blocks.first().map_or(0.0, |whole| whole.logic_mm2),
        period_ns: silicon.longest.map(|path| path.period_ns),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_blocks::allocator::{Config, FreeList};
    use pellucid_sim::netlist::elaborate;

    fn library() -> Library {
        let text = "library (l) { time_unit : \"1ns\"; capacitive_load_unit (1, pf);\n\
                    cell (INV) { area : 16; pin (A) { direction : input; capacitance : 1; }\n\
                    pin (Y) { direction : output; function : \"!A\"; } }\n\
                    cell (DFF) { area : 96.5; }\n}\n";
        Library::parse("l.lib", text.to_string()).unwrap()
    }

    fn tree() -> Tree {
        Tree::new(&elaborate::<FreeList>(&Config { sections: 512 }))
    }

    fn blocks(tree: &Tree) -> Vec<Block> {
        let block = |place: &super::super::tree::Place| Block {
            path: place.path.clone(),
            block: place.block,
            cells: 0,
            logic_mm2: 0.0,
            memories_mm2: 0.0,
        };
        tree.places.iter().map(block).collect()
    }

    #[test]
    fn areas_of_cells_are_added_up_by_hand() {
        let tree = tree();
        let mut blocks = blocks(&tree);
        let blif = ".subckt INV A=a Y=y\n.cname $flatten\\u_queue.$abc$1\n.subckt DFF D=a Q=y\n.cname x\n\
                    .subckt INV A=a Y=y\n.cname $abc$2\n.subckt sram_1r1w_512x9 clk=c\n.cname u_queue.u_memory.w\n";
        let kinds = count(blif, &tree, &library(), &mut blocks).unwrap();
        assert_eq!(kinds, BTreeMap::from([("DFF".to_string(), 1), ("INV".to_string(), 2)]));
        // 16 + 96.5 + 16, of which 16 in the queue.
        let areas: Vec<(u64, f64)> = blocks.iter().map(|b| (b.cells, b.logic_mm2 * 1e6)).collect();
        assert_eq!(areas.len(), 2);
        assert!((areas[0].1 - 128.5).abs() < 1e-9 && (areas[1].1 - 16.0).abs() < 1e-9, "{areas:?}");
        assert_eq!([areas[0].0, areas[1].0], [3, 1]);
        let error = count(".subckt LATCH D=a\n.cname x\n", &tree, &library(), &mut blocks);
        let expected = "l.lib: no cell `LATCH`: expected every cell that the design is mapped to";
        assert_eq!(error.unwrap_err().to_string(), expected);
    }

    #[test]
    fn a_path_is_followed_from_cell_to_cell() {
        let said = "\
            Startpoint: x\n\n    Delay      Time   Description\n\
            \x20  0.0000    0.0000   clock clk (rise edge)\n\
            \x20  0.0000    0.0000 ^ $flatten\\\\u_queue.$auto$1/CLK (DFF)\n\
            \x20  0.2500    0.2500 v $flatten\\\\u_queue.$auto$1/Q (DFF)\n\
            \x20  0.5000    0.7500 ^ $abc$2/Y (INV)\n\
            \x20  0.0000    0.7500 ^ $auto$3/D (DFF)\n\
            \x20            0.7500   data arrival time\n\n\
            1000.0000 1000.0000   clock clk (rise edge)\n\
            \x20         1000.0000 ^ $auto$3/CLK (DFF)\n\
            \x20 -0.1500  999.8500   library setup time\n\
            \x20          999.8500   data required time\n\
            \x20           -0.7500   data arrival time\n";
        let path = follow(said, &tree(), 2.0).unwrap();
        assert!((path.period_ns - 1.8).abs() < 1e-9, "{path:?}");
        assert_eq!((path.cells, path.through), (3, vec!["queue".to_string(), String::new()]));
        assert_eq!(follow("No paths found.\n", &tree(), 1.0), None);
    }
}
