//! Where a table lies, and the shape of one that lies outside.

use crate::table_cache;
use pellucid_machine::choice;
use pellucid_machine::outside::{self, Table};
use pellucid_machine::params::{ParamError, power_of_two};
use pellucid_sim::bits_for;

choice! {
    /// Where a table lies.
    pub enum Place {
        /// All of it is on chip.
        OnChip = "on_chip",
        /// It is in outside memory, and a cache on chip.
        Cached = "cached",
    }
}

/// How much of a table that lies in outside memory is kept on chip: numbers of a [cache](crate::table_cache).
#[derive(Clone, Copy, Debug)]
pub struct Cached {
    /// Sets; a power of two.
    pub sets: u32,
    /// Lines of a set; a power of two.
    pub ways: u32,
    /// Entries of a line; a power of two.
    pub line: u32,
}

impl Cached {
    /// What the parameter `table` and those that are named after it, `_sets`, `_ways` and `_line`, ask for, in this order.
    ///
    /// # Errors
    /// One of the numbers is no power of two.
    pub fn of(
        table: &str,
        place: Place,
        [sets, ways, line]: [u32; 3],
    ) -> Result<Option<Cached>, ParamError> {
        for (name, value) in [("sets", sets), ("ways", ways), ("line", line)] {
            power_of_two(&format!("{table}_{name}"), value)?;
        }
        Ok((place == Place::Cached).then_some(Cached { sets, ways, line }))
    }

    /// A table of so many entries, of so many bits each, with a cache that covers a latency of as many cycles as reads may be in
    /// flight. The port is that of the table alone; see [`Shape::behind`].
    pub fn shape(self, entries: u32, bits: u32, reads_in_flight: u32) -> Shape {
        let Cached { sets, ways, line } = self;
        // A cache is no larger than what lies behind it.
        let words = entries.next_multiple_of(line).max(sets * ways * line);
        let port = outside::Config { words, bits };
        let (in_flight, misses) = (reads_in_flight + 2 * line, 2 + reads_in_flight / line);
        let flushes = false;
        let cache = table_cache::Config { port, sets, ways, line, in_flight, misses, flushes };
        Shape { entries, bits, cache }
    }
}

/// A table in outside memory.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Its entries, at least 1.
    pub entries: u32,
    /// Bits of an entry.
    pub bits: u32,
    /// The cache, with the port to a word for each entry. There may be words behind the last one.
    pub cache: table_cache::Config,
}

impl Shape {
    /// What is named where no table lies outside.
    pub const NONE: Shape = Shape {
        entries: 1,
        bits: 1,
        cache: table_cache::Config {
            port: outside::Config { words: 1, bits: 1 },
            sets: 1,
            ways: 1,
            line: 1,
            in_flight: 1,
            misses: 1,
            flushes: false,
        },
    };
    /// The same behind a port with words of `bits` bits, as many as its entries have at least.
    #[must_use]
    pub fn behind(mut self, bits: u32) -> Shape {
        self.cache.port.bits = bits;
        self
    }
    /// The same of which what was written can be flushed to memory.
    #[must_use]
    pub fn flushed(mut self) -> Shape {
        self.cache.flushes = true;
        self
    }
    /// Its words, of as many bits as an entry has.
    pub fn words(&self) -> outside::Config {
        outside::Config { words: self.cache.port.words, bits: self.bits }
    }
    /// The same as a part of outside memory, that is called `path`.
    pub fn table(&self, path: &str) -> Table {
        let outside::Config { words, bits } = self.words();
        Table { path: path.to_string(), words, bits }
    }
    /// How many asks may be on their way from `ask` to `entry`, so that whoever asks knows what is to be done with so many.
    #[inline]
    pub fn ahead(&self) -> u32 {
        self.cache.in_flight + 4
    }
    /// Words behind the last entry that are in its line.
    #[inline]
    pub fn padding(&self) -> u32 {
        self.entries.next_multiple_of(self.cache.line) - self.entries
    }
    pub(super) fn padding_bits(&self) -> u32 {
        bits_for(u64::from(self.padding()))
    }
}

/// Everything that the block needs to know.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// What an entry's widths depend on.
    pub entry: C,
    /// The table.
    pub shape: Shape,
}
