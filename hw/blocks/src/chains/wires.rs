//! What can be seen of the chains.

use super::config::Config;
use super::lookup::Chain;
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_sim::{Handshake, Signals};

/// What can be seen of the chains in a cycle: the streams between their blocks, and what these did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Wires {
    /// Free sections. An offer may be replaced by a better one: see [`pool`](super::pool).
    #[with(cfg.id_bits())]
    pub grant: Handshake<u32>,
    /// Sections that are given back.
    #[with(cfg.id_bits())]
    #[exists(!cfg.counts_out())]
    pub release: Handshake<u32>,
    /// Pixels to visit.
    #[with(cfg.screen.pixel_bits())]
    pub pixel: Handshake<Marked<u32>>,
    /// Pixels with their chains.
    #[with(*cfg)]
    pub chain: Handshake<Marked<Chain>>,
    /// Fragments that were read back.
    #[with(cfg.screen.pixel_bits(), cfg.shape.weight_bits)]
    pub arrived: Handshake<Marked<Arrived>>,
    /// The port to outside memory.
    #[with(cfg.port())]
    #[exists(cfg.port().exists())]
    pub outside: outside::Wires,
    /// What happened.
    pub events: Events,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// A fragment was stored.
    pub stored: bool,
    /// It was stored in an outside section.
    pub spilled: bool,
    /// One that came is its pixel's first.
    pub first: bool,
    /// One that came took a new section.
    pub section_taken: bool,
    /// A fragment found no section.
    pub dropped: bool,
    /// A fragment waited for a section.
    pub waits: bool,
    /// A stored fragment was read, to be compared with one that came.
    pub compared: bool,
    /// A stored fragment's weight was changed.
    pub weight_changed: bool,
    /// A chain was begun to be read.
    pub chain_begun: bool,
    /// A fragment was read back.
    pub read: bool,
    /// It was read in a second pass or later.
    pub read_again: bool,
    /// A stored fragment turned out to be hidden.
    pub culled_late: bool,
    /// An SSA entry is found in the cache, or on its way there.
    pub ssa_hit: bool,
    /// An SSA entry is not.
    pub ssa_miss: bool,
    /// An SSA entry goes from the cache to memory.
    pub ssa_write_back: bool,
}
