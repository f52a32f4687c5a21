//! The shape of a table cache.

use crate::cache;
use pellucid_machine::outside;
use pellucid_sim::{Signals, bits_for, check_range, fifo, rtl};

/// Parameters. The cache holds no more words than the memory.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The port to the memory: one word for each entry of the table; a whole number of lines.
    pub port: outside::Config,
    /// How many sets; a power of two.
    pub sets: u32,
    /// Lines of a set, 1..=[`MAX_WAYS`](cache::MAX_WAYS); a power of two.
    pub ways: u32,
    /// Words of a line, 1..=[`MAX_LINE`](cache::MAX_LINE); a power of two.
    pub line: u32,
    /// Asks that may wait for their turn, at least 1.
    pub in_flight: u32,
    /// Lines that may be on their way from memory, at least 1.
    pub misses: u32,
    /// What was written can be flushed to memory.
    pub flushes: bool,
}

impl Config {
    /// Holds every number to its range.
    pub(super) fn check(&self) {
        self.cache().check();
        check_range("the number of asks in flight of a table cache", self.in_flight, 1..);
        let most = u32::MAX / cache::MAX_LINE;
        check_range("the number of misses in flight of a table cache", self.misses, 1..=most);
    }
    /// The lines are found as in a cache. It knows nothing of what is dirty: here that is known only later.
    pub(super) fn cache(&self) -> cache::Config {
        let Config { port, sets, ways, line, .. } = *self;
        cache::Config { port, sets, ways, line, write_back: false }
    }
    pub(super) fn queue(&self) -> fifo::Config<Config> {
        fifo::Config { depth: self.in_flight, item: *self }
    }
    /// Lines that memory is to be asked for: all that may be under way.
    pub(super) fn fetches(&self) -> fifo::Config<u32> {
        fifo::Config { depth: self.misses, item: self.port.address_bits() }
    }
    pub(super) fn answers(&self) -> fifo::Config<outside::Config> {
        fifo::Config { depth: self.misses * self.line, item: self.port }
    }
    /// Bits of the number of a miss. They must tell apart those that are under way; a few more than the lines need keep old
    /// numbers from being taken for those.
    pub(super) fn number_bits(&self) -> u32 {
        bits_for(u64::from(self.misses).max(8 * u64::from(self.sets * self.ways))).min(u32::BITS)
    }
}

/// What is to be known of a line that made room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Old {
    /// There was one.
    pub valid: bool,
    /// The upper bits of its words' addresses.
    #[width(cfg.cache().tag_bits())]
    pub tag: u32,
}

/// Where an entry lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Place {
    /// Its number in the table.
    #[width(cfg.port.address_bits())]
    pub address: u32,
    /// The way of its set.
    #[width(cfg.cache().way_bits())]
    pub way: u32,
}

/// An ask that was looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Order {
    /// Where the entry lies when its turn comes.
    #[with(*cfg)]
    pub place: Place,
    /// Its line is to come from memory first.
    pub miss: bool,
    /// For a miss, the line that is to make room.
    #[with(*cfg)]
    pub old: Old,
}

#[rtl]
impl Config {
    /// The number of a place's line among the cache's own.
    #[inline(always)]
    pub(super) fn line_of(&self, place: Place) -> u32 {
        self.cache().line_at(self.cache().set_of(place.address), place.way)
    }
}
