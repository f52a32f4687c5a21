//! Watches the chains: counts what they do and holds their streams to their rules.

use super::config::Config;
use super::lookup::Chain;
use super::{State, Wires};
use crate::allocator::Allocator;
use crate::machine::{Census, Check, Seen, Tally, seen};
use crate::pixel::{Arrived, Marked};
use pellucid_sim::signals::state_name;
use pellucid_sim::{StreamMonitor, Violation};

pellucid_sim::counters! {
    /// What the chains count.
    pub struct Own {
        /// Pixels that had at least one fragment stored.
        pixels_stored: "pixels",
        /// The most sections of the pool that were in use at once.
        peak_sections: "sections",
        /// The most of them in outside memory.
        peak_outside_sections: "sections",
        /// Chains that resolve read.
        chains_read: "chains",
        /// Fragments read back in a pixel's first pass.
        fragments_read: "fragments",
        /// Fragments read back again for pixels deeper than one pass.
        fragments_read_again: "fragments",
        /// Stored fragments that a later opaque one hid.
        culled_late: "fragments",
        /// Cycles in which a fragment waited for the allocator.
        allocator_stalls: "cycles",
        /// Sections that were taken in another row of 64 than the one before them.
        row_switches: "sections",
    }
}

/// What a frame holds while it is stored; all of it is given back by the frame's end.
#[derive(Clone, Copy, Default)]
struct Usage {
    pixels: u64,
    sections: u64,
    outside_sections: u64,
    words: u64,
    outside_words: u64,
}

impl Usage {
    fn max(self, other: Usage) -> Usage {
        Usage {
            pixels: self.pixels.max(other.pixels),
            sections: self.sections.max(other.sections),
            outside_sections: self.outside_sections.max(other.outside_sections),
            words: self.words.max(other.words),
            outside_words: self.outside_words.max(other.outside_words),
        }
    }
}

/// The most items that each queue held.
#[derive(Clone, Copy, Default)]
struct Queues {
    store: u32,
    lookup: u32,
    chains: u32,
    pending: u32,
    arrived: u32,
    release: u32,
    on_chip: u32,
    outside: u32,
}

/// Sections of a row: near to each other, as a row of a memory outside the chip holds them.
const ROW: u32 = 64;

/// See the module's description.
pub struct ChainsMonitor {
    /// Fragments that were stored.
    pub stored: u64,
    /// Those of them in outside sections.
    pub spilled: u64,
    /// Fragments that found no section.
    pub dropped: u64,
    own: Own,
    /// The row of the section that was taken last.
    row: u32,
    frame: Usage,
    peak: Usage,
    queues: Queues,
    release: StreamMonitor<u32>,
    pixel: StreamMonitor<Marked<u32>>,
    chain: StreamMonitor<Marked<Chain>>,
    arrived: StreamMonitor<Marked<Arrived>>,
}

impl ChainsMonitor {
    /// A monitor that has seen nothing; `receiver` is the block that takes what is read back.
    pub fn new(receiver: &'static str) -> ChainsMonitor {
        ChainsMonitor {
            stored: 0,
            spilled: 0,
            dropped: 0,
            own: Own::default(),
            row: 0,
            frame: Usage::default(),
            peak: Usage::default(),
            queues: Queues::default(),
            release: StreamMonitor::new("release", "release", "pool"),
            pixel: StreamMonitor::new("pixel", "scan", "lookup"),
            chain: StreamMonitor::new("chain", "lookup", "reader"),
            arrived: StreamMonitor::new("arrived", "reader", receiver),
        }
    }

    /// A cycle of store.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe_store<A: Allocator>(
        &mut self,
        q: &State<A>,
        wires: &Wires,
    ) -> Result<(), Violation> {
        // The read-back is clocked from the last cycle of the store on.
        self.pixel.observe(wires.pixel)?;
        let e = &wires.events;
        self.stored += u64::from(e.stored);
        self.spilled += u64::from(e.spilled);
        self.dropped += u64::from(e.dropped);
        self.own.pixels_stored += u64::from(e.first);
        self.own.allocator_stalls += u64::from(e.waits);
        if e.section_taken {
            let row = wires.grant.payload / ROW;
            self.own.row_switches += u64::from(row != self.row);
            self.row = row;
        }
        let frame = &mut self.frame;
        frame.pixels += u64::from(e.first);
        frame.sections += u64::from(e.section_taken);
        frame.outside_sections += u64::from(e.section_taken && e.spilled);
        frame.words += u64::from(e.stored && !e.spilled);
        frame.outside_words += u64::from(e.spilled);
        self.queues.store = self.queues.store.max(q.store.queue.count);
        Ok(())
    }

    /// A cycle of resolve.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe_resolve<A: Allocator>(
        &mut self,
        q: &State<A>,
        wires: &Wires,
        frame_done: bool,
    ) -> Result<(), Violation> {
        self.pixel.observe(wires.pixel)?;
        self.chain.observe(wires.chain)?;
        self.arrived.observe(wires.arrived)?;
        self.release.observe(wires.release)?;
        let (e, own) = (&wires.events, &mut self.own);
        own.chains_read += u64::from(e.chain_begun);
        own.fragments_read += u64::from(e.read && !e.read_again);
        own.fragments_read_again += u64::from(e.read && e.read_again);
        own.culled_late += u64::from(e.culled_late);
        if frame_done {
            self.peak = self.peak.max(self.frame);
            self.frame = Usage::default();
        }
        let (queues, pool, q) = (&mut self.queues, &q.pool, &q.read_back);
        queues.lookup = queues.lookup.max(q.lookup.queue.count);
        queues.chains = queues.chains.max(q.reader.chains.count);
        queues.pending = queues.pending.max(q.reader.pending.count);
        queues.arrived = queues.arrived.max(q.reader.arrived.count);
        queues.release = queues.release.max(q.release.committed + q.release.open);
        queues.on_chip = queues.on_chip.max(A::words_in_use(&pool.on_chip));
        queues.outside = queues.outside.max(A::words_in_use(&pool.outside));
        Ok(())
    }

    /// The streams between the blocks.
    pub fn streams(&self) -> [Seen; 4] {
        [seen(&self.release), seen(&self.pixel), seen(&self.chain), seen(&self.arrived)]
    }

    /// What was counted.
    pub fn own(&self) -> Own {
        let peak = self.peak.max(self.frame);
        Own {
            peak_sections: peak.sections,
            peak_outside_sections: peak.outside_sections,
            ..self.own
        }
    }

    /// What both directions of the section memory must have carried.
    pub fn closed_forms(tally: &Tally, census: &Census) -> [Check; 2] {
        let counted = |memory: &str| {
            let found = tally.memories.iter().find(|m| m.name == memory);
            found.map_or((0, 0), |m| (m.info.reads, m.info.writes))
        };
        let on_chip = counted("chains.sections.on_chip");
        let outside = counted("chains.sections.outside");
        [
            Check {
                what: "fragments written to section memory, F and weights that changed",
                expected: census.stored + tally.figure("weights_changed"),
                found: on_chip.1 + outside.1,
            },
            Check {
                what: "fragments read from section memory, F, those read again and those compared",
                expected: census.stored
                    + tally.figure("fragments_read_again")
                    + tally.figure("compared"),
                found: on_chip.0 + outside.0,
            },
        ]
    }

    /// The state of a block, if it has one.
    pub fn state<A: Allocator>(block: &str, q: &State<A>) -> Option<&'static str> {
        match block {
            "store" => Some(state_name(q.store.fsm)),
            "scan" => Some(state_name(q.read_back.scan.fsm)),
            "reader" => Some(state_name(q.read_back.reader.fsm)),
            _ => None,
        }
    }

    /// The most words of a memory, by its path in the chains, that held something of use at once.
    pub fn peak_words(&self, cfg: &Config, name: &str, words: u64) -> u64 {
        let (peak, queues) = (self.peak.max(self.frame), &self.queues);
        match name {
            "ssa.table" => peak.pixels,
            // Where tails are kept the last section of a chain has no entry: there is one for each
            // section but a chain's first.
            "nsa.table" | "nsa.lent" if cfg.shape.owned => peak.sections,
            "nsa.table" | "nsa.lent" if cfg.shape.tail => peak.sections - peak.pixels,
            "nsa.table" | "nsa.lent" => peak.sections,
            "sections.on_chip" => peak.words,
            "sections.outside" => peak.outside_words,
            "store.queue" => queues.store.into(),
            "read_back.lookup.queue" => queues.lookup.into(),
            "read_back.reader.chains" => queues.chains.into(),
            "read_back.reader.pending" => queues.pending.into(),
            "read_back.reader.arrived" => queues.arrived.into(),
            "read_back.release.queue" => queues.release.into(),
            _ if name.starts_with("pool.on_chip") => words.min(queues.on_chip.into()),
            _ if name.starts_with("pool.outside") => words.min(queues.outside.into()),
            // The bitmap: every word means something from the start.
            _ => words,
        }
    }
}

/// Bytes of an address, as seed 000's printed percentages imply them.
pub const ADDRESS_BYTES: u64 = 2;

/// Bytes of a section with its address as seed 000 counts them: 6 for a fragment without its x and y.
pub fn section_bytes(capacity: u32) -> u64 {
    const FRAGMENT_BYTES: u64 = 6;
    u64::from(capacity) * FRAGMENT_BYTES + ADDRESS_BYTES
}
