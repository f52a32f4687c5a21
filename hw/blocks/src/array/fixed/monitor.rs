//! Watches the fixed arrays: counts what they do and holds their streams to their rules.

use super::{Config, Wires};
use crate::array::monitor::counter_lines;
use crate::array::walk::Extent;
use pellucid_machine::outside::Request;
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_machine::{Check, Memories, Seen, Tally, seen};
use pellucid_sim::{StreamMonitor, Violation};

pellucid_sim::counters! {
    /// What fixed arrays count.
    pub struct FixedCounters {
        /// How often a frame was played again since a pixel had more fragments than slots.
        rebuilds: "plays",
        /// The most slots that each pixel had.
        layers_used: "fragments",
        /// The most fragments that lay in slots at once.
        fragments_used: "fragments",
        /// Fragments written to slots, of every play.
        fragments_written: "fragments",
        /// Fragments read back in a pixel's first pass.
        fragments_read: "fragments",
        /// Fragments read back again for pixels deeper than one pass.
        fragments_read_again: "fragments",
        /// Stored fragments that a later opaque one hid, found out as they were read back.
        culled_late: "fragments",
        /// Words of counters that were in their cache or on their way (counters=cached).
        counter_hits: "words",
        /// Those that were not.
        counter_misses: "words",
        /// Words of counters written back to outside memory.
        counters_written_back: "words",
    }
}

/// Fragments that lie in slots.
#[derive(Clone, Copy, Default)]
struct Held {
    on_chip: u64,
    outside: u64,
}

/// See the module's description.
pub struct FixedMonitor {
    /// Fragments of frames as they were read back that lay in outside memory.
    pub spilled: u64,
    /// Fragments that found no slot in a frame that was read back.
    pub dropped: u64,
    /// What was counted.
    pub own: FixedCounters,
    /// In the play at hand, and the most of any.
    held: Held,
    most: Held,
    extent: StreamMonitor<Marked<Extent>>,
    arrived: StreamMonitor<Marked<Arrived>>,
    request: StreamMonitor<Request>,
}

impl FixedMonitor {
    /// A monitor that has seen nothing; `receiver` is the block that takes what is read back.
    pub fn new(receiver: &'static str) -> FixedMonitor {
        FixedMonitor {
            spilled: 0,
            dropped: 0,
            own: FixedCounters::default(),
            held: Held::default(),
            most: Held::default(),
            extent: StreamMonitor::new("extent", "walk", "reader"),
            arrived: StreamMonitor::new("arrived", "reader", receiver),
            request: StreamMonitor::new("request", "fragments", "outside"),
        }
    }

    /// One cycle, and whether the frame ends with it.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe(&mut self, wires: &Wires, frame_done: bool) -> Result<(), Violation> {
        self.extent.observe(wires.extent)?;
        self.arrived.observe(wires.arrived)?;
        self.request.observe(wires.outside.request)?;
        let (e, own) = (&wires.events, &mut self.own);
        self.dropped += u64::from(e.dropped);
        self.held.on_chip += u64::from(e.stored && !e.spilled);
        self.held.outside += u64::from(e.spilled);
        own.rebuilds += u64::from(e.again);
        own.fragments_written += u64::from(e.stored);
        own.fragments_read += u64::from(e.read && !e.read_again);
        own.fragments_read_again += u64::from(e.read && e.read_again);
        own.culled_late += u64::from(e.culled_late);
        own.counter_hits += u64::from(e.counters.hit);
        own.counter_misses += u64::from(e.counters.miss);
        own.counters_written_back += u64::from(e.counters.write_back);
        // What a play has stored lies there until the frame comes again or is done.
        if e.again || frame_done {
            let Held { on_chip, outside } = std::mem::take(&mut self.held);
            self.spilled += if frame_done { outside } else { 0 };
            self.most.on_chip = self.most.on_chip.max(on_chip);
            self.most.outside = self.most.outside.max(outside);
            own.fragments_used = own.fragments_used.max(on_chip + outside);
        }
        own.layers_used = own.layers_used.max(wires.length.into());
        Ok(())
    }

    /// The streams between the blocks.
    pub fn streams(&self) -> [Seen; 3] {
        [seen(&self.extent), seen(&self.arrived), seen(&self.request)]
    }

    /// What the counters must have been asked for, and have moved, if `frames` were resolved and none was played again.
    pub fn table_forms(cfg: &Config, tally: &Tally, frames: u64) -> Vec<Check> {
        let arrays = &cfg.arrays;
        if !arrays.caches() {
            return vec![];
        }
        let mut checks = vec![counter_lines(arrays, tally)];
        if tally.figure("rebuilds") == 0 {
            checks.push(Check {
                what: "words of counters asked for, one for each fragment, and all to resolve",
                expected: tally.figure("fragments_written")
                    + tally.fragments.dropped
                    + frames * u64::from(arrays.words()),
                found: tally.figure("counter_hits") + tally.figure("counter_misses"),
            });
        }
        checks
    }

    /// Says of the slots how many of them were in use. Of counters every word means something from the start.
    pub fn set_peaks(&self, cfg: &Config, memories: &mut Memories) {
        memories.set_peak("arrays.fragments.on_chip", self.most.on_chip);
        if cfg.arrays.fragments.port().exists() {
            memories.set_peak("arrays.fragments.outside", self.most.outside);
        }
    }
}
