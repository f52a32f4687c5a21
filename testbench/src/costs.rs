//! What a run costs beside cycles: energy of a frame, area and time, of the memories on the chip and of a DRAM outside.
//!
//! Energy is that of the accesses that were counted, and leakage over the time of a frame. Where a frame's time comes from is the
//! clock: the one that is given, or the fastest that the memories allow, and logic where it was mapped. The energy of logic, wires between
//! blocks and the clock tree are not among it.

use pellucid_machine::params::Value;
use pellucid_machine::{MemoryTally, Tally};
use pellucid_sim::{Figure, StorageInfo};
use pellucid_sram::{Node, Price};

pub use pellucid_sram::{Memory, Table, TableError};

/// Where the figures of memories on the chip come from.
#[derive(Clone, Debug)]
pub struct Technology {
    /// What the table is called.
    table: String,
    node: Node,
}

impl Technology {
    /// The node where none is named, nm.
    pub const NODE: u32 = 22;

    /// The node of a table.
    ///
    /// # Errors
    /// The table has none of that name.
    pub fn new(table: &Table, nm: u32) -> Result<Technology, TableError> {
        Ok(Technology { table: table.name.clone(), node: table.node(nm)?.clone() })
    }

    /// Its name with that of the table.
    pub fn name(&self) -> String {
        format!("{}, {} nm", self.table, self.node.nm)
    }

    /// What a memory on the chip takes.
    pub fn price(&self, memory: &Memory) -> Price {
        self.node.price(memory)
    }
}

/// A machine's memory, as a table has it.
pub fn memory(info: &StorageInfo) -> Memory {
    let StorageInfo { words, bits_per_word, ports, .. } = *info;
    Memory { words, bits: bits_per_word, ports }
}

impl Default for Technology {
    /// That of the shipped table.
    fn default() -> Technology {
        Technology::new(&Table::shipped(), Technology::NODE).expect("a node of the shipped table")
    }
}

/// What one memory on the chip costs; energies in nJ a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemoryCosts {
    /// Its reads.
    pub reads_nj: f64,
    /// Its writes.
    pub writes_nj: f64,
    /// Its leakage.
    pub leakage_nj: f64,
    /// Its area, mm2.
    pub area_mm2: f64,
    /// From an address to its word, ns.
    pub access_ns: f64,
}

/// What the logic of a machine takes in the cells of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct Logic {
    /// The library, and the tools.
    pub source: String,
    /// Area of its cells, mm2.
    pub area_mm2: f64,
    /// The shortest period, ns: of the longest path from a register or memory to the next; none where there is none.
    pub period_ns: Option<f64>,
}

/// What limits a clock where a memory does not.
const LOGIC: &str = "logic";

/// The clock, and what a frame's time is by it.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// MHz.
    pub mhz: f64,
    /// It was given, and is not that of the slowest part.
    pub given: bool,
    /// The fastest that the memories allow, and logic where it is known, MHz.
    pub fastest_mhz: f64,
    /// The memory that allows no faster one, or `logic`.
    pub slowest: String,
    /// Time of a frame, ns.
    pub frame_ns: f64,
}

/// See the module's description.
#[derive(Clone, Debug)]
pub struct Costs {
    /// The technology, by name.
    pub technology: String,
    /// The clock; none where no memory is on the chip.
    pub clock: Option<Clock>,
    /// Of each memory in the order of the tally; none for one that is not on the chip.
    pub memories: Vec<Option<MemoryCosts>>,
    /// Of the memory outside by what for, nJ a frame; empty where it is not known.
    pub outside: Vec<(Figure, f64)>,
    /// A memory outside was read or written.
    pub uses_outside: bool,
    /// What the logic takes, where it was mapped.
    pub logic: Option<Logic>,
}

/// The unit of those figures of the outside memory that are energies, over all frames.
pub const PICOJOULES: &str = "pJ";
/// The setting that gives a clock, MHz.
pub const CLOCK: &str = "clock_mhz";

/// It is outside, and was read or written.
fn used_outside(memory: &MemoryTally) -> bool {
    memory.info.outside && memory.info.reads + memory.info.writes > 0
}

/// The shortest period of a memory, ns: its word is there after so many cycles as it has, and an access may begin in each.
fn period(info: &StorageInfo, price: &Price) -> f64 {
    (price.access_ns / f64::from(info.latency.max(1))).max(price.cycle_ns)
}

impl Costs {
    /// Of a run of so many frames by a machine with these settings.
    pub fn new(
        technology: &Technology,
        settings: &[(String, Value)],
        tally: &Tally,
        frames: u32,
        logic: Option<&Logic>,
    ) -> Costs {
        let frames = f64::from(frames.max(1));
        let on_chip = |memory: &&MemoryTally| !memory.info.outside;
        let priced = tally.memories.iter().filter(on_chip);
        let priced =
            priced.map(|m| (&*m.name, period(&m.info, &technology.price(&memory(&m.info)))));
        let logic_period = logic.and_then(|logic| Some((LOGIC, logic.period_ns?)));
        let slowest = priced.chain(logic_period).max_by(|a, b| a.1.total_cmp(&b.1));
        let given = settings.iter().find_map(|(name, value)| match value {
            Value::Number(mhz) if name == CLOCK => Some(f64::from(*mhz)),
            _ => None,
        });
        let clock = slowest.map(|(slowest, period_ns)| {
            let fastest_mhz = 1000.0 / period_ns;
            let mhz = given.unwrap_or(fastest_mhz);
            let frame_ns = tally.cycles.total as f64 / frames * 1000.0 / mhz;
            let slowest = slowest.to_string();
            Clock { mhz, given: given.is_some(), fastest_mhz, slowest, frame_ns }
        });
        let frame_ns = clock.as_ref().map_or(0.0, |clock| clock.frame_ns);
        let costs = |tally: &MemoryTally| {
            let info = &tally.info;
            let price = technology.price(&memory(info));
            MemoryCosts {
                reads_nj: info.reads as f64 * price.read_nj / frames,
                writes_nj: info.writes as f64 * price.write_nj / frames,
                // mW times ns are pJ.
                leakage_nj: price.leakage_mw * frame_ns / 1000.0,
                area_mm2: price.area_mm2,
                access_ns: price.access_ns,
            }
        };
        let memories = tally.memories.iter();
        Costs {
            technology: technology.name(),
            clock,
            memories: memories.map(|m| (!m.info.outside).then(|| costs(m))).collect(),
            outside: tally
                .outside
                .iter()
                .filter(|figure| figure.unit == PICOJOULES)
                .map(|figure| (figure.clone(), figure.value as f64 / 1000.0 / frames))
                .collect(),
            uses_outside: tally.memories.iter().any(used_outside),
            logic: logic.cloned(),
        }
    }

    fn sum(&self, of: impl Fn(&MemoryCosts) -> f64) -> f64 {
        self.memories.iter().flatten().map(of).sum()
    }

    /// Energy of all reads of memories on the chip, nJ a frame.
    pub fn reads_nj(&self) -> f64 {
        self.sum(|memory| memory.reads_nj)
    }

    /// The same of writes.
    pub fn writes_nj(&self) -> f64 {
        self.sum(|memory| memory.writes_nj)
    }

    /// Leakage of memories on the chip, nJ a frame.
    pub fn leakage_nj(&self) -> f64 {
        self.sum(|memory| memory.leakage_nj)
    }

    /// Energy of memories on the chip, nJ a frame.
    pub fn on_chip_nj(&self) -> f64 {
        self.reads_nj() + self.writes_nj() + self.leakage_nj()
    }

    /// Energy of the memory outside, nJ a frame, where it is known.
    pub fn outside_nj(&self) -> Option<f64> {
        (!self.outside.is_empty()).then(|| self.outside.iter().map(|(_, nj)| nj).sum())
    }

    /// Energy of all memories, nJ a frame; none where that of one outside is not known.
    pub fn total_nj(&self) -> Option<f64> {
        match (self.uses_outside, self.outside_nj()) {
            (_, Some(outside)) => Some(self.on_chip_nj() + outside),
            (false, None) => Some(self.on_chip_nj()),
            (true, None) => None,
        }
    }

    /// Area of memories on the chip, mm2.
    pub fn area_mm2(&self) -> f64 {
        self.sum(|memory| memory.area_mm2)
    }
}

#[cfg(test)]
mod tests;
