//! Energy, area and time of memories on a chip: a table of simulated memories, and what lies between its points.
//!
//! [`Table`] is a CSV file; the one that is shipped (`src/cacti7.csv`) was made with CACTI 7. [`Node::price`] reads from it
//! what a memory of so many words of so many bits takes, by these rules:
//!
//! | a memory | is priced as |
//! |---|---|
//! | of a size between two of the table, or of a width | a power law between the two: a straight line between logarithms |
//! | smaller than the smallest | the smallest; a word narrower than the narrowest likewise |
//! | with a wider word than the widest | slices of equal width side by side, each with all words |
//! | larger than the largest, `n` times | `n` times its area and leakage; an access takes the square root of `n` times the energy and time, as the way to a bank grows with the side of the whole |
//!
//! ```
//! use pellucid_sim::Ports;
//! use pellucid_sram::{Memory, Table};
//!
//! let table = Table::shipped();
//! let node = table.node(22).unwrap();
//! let memory = |words| node.price(&Memory { words, bits: 64, ports: Ports::One });
//! // A point of the table, and four of it.
//! assert_eq!(memory(32768).read_nj, 0.00993381);
//! assert_eq!(memory(4 * 32768).read_nj, 2.0 * 0.00993381);
//! assert_eq!(memory(4 * 32768).area_mm2, 4.0 * 0.208251);
//! ```

mod grid;
mod table;

pub use table::{Node, Table, TableError};

use pellucid_sim::Ports;

/// A memory on a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Words, at least 1.
    pub words: u64,
    /// Bits of a word, at least 1.
    pub bits: u32,
    /// Its ports.
    pub ports: Ports,
}

/// What a memory takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Price {
    /// From an address to its word, ns.
    pub access_ns: f64,
    /// From one access to the next, ns.
    pub cycle_ns: f64,
    /// Energy of a read, nJ.
    pub read_nj: f64,
    /// Energy of a write, nJ.
    pub write_nj: f64,
    /// Leakage, mW.
    pub leakage_mw: f64,
    /// Area, mm2.
    pub area_mm2: f64,
}

impl Price {
    fn with(self, other: Price, of: impl Fn(f64, f64) -> f64) -> Price {
        Price {
            access_ns: of(self.access_ns, other.access_ns),
            cycle_ns: of(self.cycle_ns, other.cycle_ns),
            read_nj: of(self.read_nj, other.read_nj),
            write_nj: of(self.write_nj, other.write_nj),
            leakage_mw: of(self.leakage_mw, other.leakage_mw),
            area_mm2: of(self.area_mm2, other.area_mm2),
        }
    }
}

impl Node {
    /// What a memory takes: see the crate's description.
    pub fn price(&self, memory: &Memory) -> Price {
        let grid = self.grid(memory.ports);
        let slices = memory.bits.div_ceil(grid.widest()).max(1);
        let bits = f64::from(memory.bits) / f64::from(slices);
        let bytes = memory.words as f64 * bits / 8.0;
        let banks = (bytes / grid.largest() as f64).max(1.0);
        let one = grid.at(bytes, bits);
        let slices = f64::from(slices);
        Price {
            access_ns: one.access_ns * banks.sqrt(),
            cycle_ns: one.cycle_ns,
            read_nj: one.read_nj * banks.sqrt() * slices,
            write_nj: one.write_nj * banks.sqrt() * slices,
            leakage_mw: one.leakage_mw * banks * slices,
            area_mm2: one.area_mm2 * banks * slices,
        }
    }
}

#[cfg(test)]
mod tests;
