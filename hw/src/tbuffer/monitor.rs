//! Watches the T-buffer: counts what it does and holds its streams to their rules.

use super::TBuffer;
use super::config::Config;
use super::lookup::Chain;
use super::{Out, State};
use crate::allocator::Allocator;
use crate::blender::Sorted;
use crate::machine::{
    Cycles, Fragments, Machine, MemoryTally, Monitor, Phase, Ports, StreamTally, Tally,
};
use crate::pixel::{Fragment, Marked, PixelFragment, Screen};
use crate::sorter::Arrived;
use pellucid_sim::signals::{Signals, state_name};
use pellucid_sim::{Deadlock, Figures, Handshake, StorageInfo, StreamMonitor, Violation, Wait};

pellucid_sim::counters! {
    /// The T-buffer's own figures.
    pub struct Own {
        /// Pixels that had at least one fragment stored.
        pixels_stored: "pixels",
        /// The most sections that were in use at once.
        peak_sections: "sections",
        /// The most of them in outside memory.
        peak_outside_sections: "sections",
        /// Chains that resolve read.
        chains_read: "chains",
        /// Fragments read back in a pixel's first pass.
        fragments_read: "fragments",
        /// Fragments read back again for pixels deeper than the sorter.
        fragments_read_again: "fragments",
        /// Transparent fragments dropped on arrival by the early depth test.
        culled_early: "fragments",
        /// Stored fragments that a later opaque one hid.
        culled_late: "fragments",
        /// Cycles in which a fragment waited for the allocator.
        allocator_stalls: "cycles",
        /// Cycles in which resolve had no fragment to blend.
        blender_idle: "cycles",
    }
}

/// See the module's description.
pub struct TBufferMonitor {
    cycles: Cycles,
    fragments: Fragments,
    own: Own,
    sections: u64,
    outside_sections: u64,
    on_chip_peak: u64,
    links_peak: u64,
    words: u64,
    outside_words: u64,
    peak_words: u64,
    peak_outside_words: u64,
    pixels: u64,
    peak_pixels: u64,
    fragment: StreamMonitor<Marked<Fragment>>,
    passed: StreamMonitor<Marked<PixelFragment>>,
    grant: StreamMonitor<u32>,
    release: StreamMonitor<u32>,
    pixel: StreamMonitor<Marked<u32>>,
    chain: StreamMonitor<Marked<Chain>>,
    arrived: StreamMonitor<Marked<Arrived>>,
    sorted: StreamMonitor<Marked<Sorted>>,
    image: StreamMonitor<u32>,
}
