//! Watches the arrays: counts what they do and holds their streams to their rules.

use super::Wires;
use super::config::Config;
use super::walk::Extent;
use pellucid_machine::outside::Request;
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_machine::{Check, Memories, Seen, Tally, seen};
use pellucid_sim::{StreamMonitor, Violation};

pellucid_sim::counters! {
    /// What the arrays count.
    pub struct ArrayCounters {
        /// Fragments that were counted, of each pixel as many as its counter can say.
        counted: "fragments",
        /// The most slots that a band of pixels took, those that stayed empty among them.
        fragments_used: "fragments",
        /// Fragments read back in a pixel's first pass.
        fragments_read: "fragments",
        /// Fragments read back again for pixels deeper than one pass.
        fragments_read_again: "fragments",
        /// Words of counters that were in their cache or on their way (counters=cached).
        counter_hits: "words",
        /// Those that were not.
        counter_misses: "words",
        /// Words of counters written back to outside memory.
        counters_written_back: "words",
        /// Words of sums that were in their cache or on their way (counters=cached).
        sum_hits: "words",
        /// Those that were not.
        sum_misses: "words",
        /// Words of sums written back to outside memory.
        sums_written_back: "words",
    }
}

/// What is read of counters outside, a line for each that is not in the cache.
pub(super) fn counter_lines(cfg: &Config, tally: &Tally) -> Check {
    lines(cfg, tally, "lines of counters read outside, one for each miss", "counter")
}

/// Lines that were begun: a run may end before all words of the last one have come, when those that are needed are there.
fn lines(cfg: &Config, tally: &Tally, what: &'static str, table: &str) -> Check {
    let line = cfg.shape.cached.map_or(1, |cached| u64::from(cached.line));
    let outside = tally.memory(&format!("arrays.{table}s.outside"));
    Check {
        what,
        expected: tally.figure(&format!("{table}_misses")),
        found: outside.map_or(0, |memory| memory.info.reads).div_ceil(line),
    }
}

/// See the module's description.
pub struct ArraysMonitor {
    /// Fragments that went into a slot.
    pub stored: u64,
    /// Those of them in outside memory.
    pub spilled: u64,
    /// Fragments that found no slot.
    pub dropped: u64,
    /// What was counted.
    pub own: ArrayCounters,
    extent: StreamMonitor<Marked<Extent>>,
    arrived: StreamMonitor<Marked<Arrived>>,
    request: StreamMonitor<Request>,
}

impl ArraysMonitor {
    /// A monitor that has seen nothing; `receiver` is the block that takes what is read back.
    pub fn new(receiver: &'static str) -> ArraysMonitor {
        ArraysMonitor {
            stored: 0,
            spilled: 0,
            dropped: 0,
            own: ArrayCounters::default(),
            extent: StreamMonitor::new("extent", "walk", "reader"),
            arrived: StreamMonitor::new("arrived", "reader", receiver),
            request: StreamMonitor::new("request", "fragments", "outside"),
        }
    }

    /// One cycle.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe(&mut self, wires: &Wires) -> Result<(), Violation> {
        self.extent.observe(wires.extent)?;
        self.arrived.observe(wires.arrived)?;
        self.request.observe(wires.outside.request)?;
        let (e, own) = (&wires.events, &mut self.own);
        self.stored += u64::from(e.stored);
        self.spilled += u64::from(e.spilled);
        self.dropped += u64::from(e.dropped);
        own.counted += u64::from(e.counted);
        own.fragments_read += u64::from(e.read && !e.read_again);
        own.fragments_read_again += u64::from(e.read && e.read_again);
        own.counter_hits += u64::from(e.counters.hit);
        own.counter_misses += u64::from(e.counters.miss);
        own.counters_written_back += u64::from(e.counters.write_back);
        own.sum_hits += u64::from(e.sums.hit);
        own.sum_misses += u64::from(e.sums.miss);
        own.sums_written_back += u64::from(e.sums.write_back);
        // A band's sum grows with every word.
        if wires.slots.valid {
            own.fragments_used = own.fragments_used.max(wires.slots.payload.into());
        }
        Ok(())
    }

    /// The streams between the blocks.
    pub fn streams(&self) -> [Seen; 3] {
        [seen(&self.extent), seen(&self.arrived), seen(&self.request)]
    }

    /// What both directions of the memory of slots must have carried, if `stored` fragments were stored.
    pub fn closed_forms(tally: &Tally, stored: u64) -> [Check; 2] {
        let sides = ["arrays.fragments.on_chip", "arrays.fragments.outside"];
        let infos = sides.map(|side| tally.memory(side).map(|memory| memory.info));
        let infos = || infos.into_iter().flatten();
        [
            Check {
                what: "fragments written to slots, one for each that is visible",
                expected: stored,
                found: infos().map(|info| info.writes).sum(),
            },
            Check {
                what: "fragments read from slots, those and those read again",
                expected: stored + tally.figure("fragments_read_again"),
                found: infos().map(|info| info.reads).sum(),
            },
        ]
    }

    /// What both tables must have been asked for, and have moved, if `frames` were stored whole, and resolved.
    pub fn table_forms(cfg: &Config, tally: &Tally, frames: u64) -> Vec<Check> {
        if !cfg.caches() {
            return vec![];
        }
        let words = frames * u64::from(cfg.words());
        let stored = tally.fragments.blended + tally.fragments.dropped;
        let asks = |table: &str| {
            let [hits, misses] =
                ["hits", "misses"].map(|what| tally.figure(&format!("{table}_{what}")));
            hits + misses
        };
        vec![
            counter_lines(cfg, tally),
            lines(cfg, tally, "lines of sums read outside, one for each miss", "sum"),
            Check {
                what: "words of sums asked for, all in each sweep and to resolve, and one for each that is stored",
                expected: words * u64::from(cfg.sweeps(cfg.words()) + 1) + stored,
                found: asks("sum"),
            },
        ]
    }

    /// Says of the slots how many of them were in use. Of counters and sums every word means something from the start.
    pub fn set_peaks(&self, cfg: &Config, memories: &mut Memories) {
        let (used, on_chip) = (self.own.fragments_used, u64::from(cfg.shape.on_chip));
        memories.set_peak("arrays.fragments.on_chip", used.min(on_chip));
        if cfg.fragments.port().exists() {
            memories.set_peak("arrays.fragments.outside", used.saturating_sub(on_chip));
        }
    }
}
