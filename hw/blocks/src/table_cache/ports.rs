//! The ports of a table cache.

use super::config::Config;
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::{Signals, Stream};

/// An entry of the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Entry {
    /// Its number.
    #[width(cfg.port.address_bits())]
    pub address: u32,
    /// What it holds.
    #[with(cfg.port)]
    pub word: Word,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// The number of an entry that will be used.
    #[with(cfg.port.address_bits())]
    pub ask: Stream<u32>,
    /// The entry that is shown is taken.
    pub taken: bool,
    /// What it holds from now on. Without effect where none is taken.
    #[with(cfg.port)]
    pub write: Stream<Word>,
    /// What an entry holds at first.
    #[with(*cfg)]
    pub clear: Stream<Entry>,
    /// All that was written is to be in memory.
    #[exists(cfg.flushes)]
    pub flush: bool,
    /// What the memory drives. It answers what it was asked for and nothing else.
    #[with(cfg.port)]
    pub memory: outside::In,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// An ask is taken.
    pub ready: bool,
    /// What an entry holds at first is taken.
    pub clear_ready: bool,
    /// The entries that were asked for, in that order.
    #[with(*cfg)]
    pub entry: Stream<Entry>,
    /// Nothing is under way.
    pub idle: bool,
}

/// Outputs. The default is what the cache shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// What is asked of the memory.
    #[with(cfg.port)]
    pub request: Stream<Request>,
    /// An ask finds its line in the cache or on its way. Each ask is a hit or a miss, once.
    pub hit: bool,
    /// An ask does not.
    pub miss: bool,
    /// A word of a dirty line goes to the memory.
    pub write_back: bool,
}
