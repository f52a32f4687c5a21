//! What can be seen of arrays of one length.

use super::Config;
use crate::array::Cached;
use crate::array::walk::Extent;
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_sim::{Handshake, Signals};

/// What can be seen of the arrays in a cycle: the streams between their blocks, and what these did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Wires {
    /// Slots of every array.
    #[width(cfg.arrays.layer_bits())]
    pub length: u32,
    /// Pixels with their fragments.
    #[with(cfg.arrays)]
    pub extent: Handshake<Marked<Extent>>,
    /// Fragments that were read back.
    #[with(cfg.arrays.screen.pixel_bits(), 0)]
    pub arrived: Handshake<Marked<Arrived>>,
    /// The port to what lies outside.
    #[with(cfg.arrays.port())]
    #[exists(cfg.arrays.port().exists())]
    pub outside: outside::Wires,
    /// What happened.
    pub events: Events,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// A fragment was stored.
    pub stored: bool,
    /// It was stored in outside memory.
    pub spilled: bool,
    /// A fragment found no slot: the frame will be played again.
    pub lacking: bool,
    /// A fragment found no slot, and there will be none.
    pub dropped: bool,
    /// The frame is asked for again.
    pub again: bool,
    /// A fragment was read back.
    pub read: bool,
    /// It was read in a second pass or later.
    pub read_again: bool,
    /// A fragment that was read back is hidden.
    pub culled_late: bool,
    /// What the cache of counters did.
    pub counters: Cached,
}
