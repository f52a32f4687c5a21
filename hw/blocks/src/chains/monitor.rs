//! Watches the chains: counts what they do and holds their streams to their rules.

use super::config::{Config, Link, Shape};
use super::lookup::Chain;
use super::{State, Wires};
use crate::allocator::Allocator;
use pellucid_machine::outside::Request;
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_machine::{Census, Check, Memories, Seen, Tally, seen};
use pellucid_sim::signals::state_name;
use pellucid_sim::{StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// What the chains count.
    pub struct ChainCounters {
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
        /// SSA entries that were found in their cache, or on their way to it.
        ssa_hits: "entries",
        /// SSA entries whose line was fetched.
        ssa_misses: "entries",
        /// SSA entries that went back to outside memory to make room.
        ssa_written_back: "entries",
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
    own: ChainCounters,
    /// The first section outside.
    first_outside: u32,
    /// The row of the section that was taken last.
    row: u32,
    frame: Usage,
    peak: Usage,
    release: StreamMonitor<u32>,
    pixel: StreamMonitor<Marked<u32>>,
    chain: StreamMonitor<Marked<Chain>>,
    arrived: StreamMonitor<Marked<Arrived>>,
    request: StreamMonitor<Request>,
}

impl ChainsMonitor {
    /// A monitor that has seen nothing; `receiver` is the block that takes what is read back.
    pub fn new(cfg: &Config, receiver: &'static str) -> ChainsMonitor {
        ChainsMonitor {
            stored: 0,
            spilled: 0,
            dropped: 0,
            own: ChainCounters::default(),
            first_outside: cfg.first_outside(),
            row: 0,
            frame: Usage::default(),
            peak: Usage::default(),
            release: StreamMonitor::new("release", "release", "pool"),
            pixel: StreamMonitor::new("pixel", "scan", "lookup"),
            chain: StreamMonitor::new("chain", "lookup", "reader"),
            arrived: StreamMonitor::new("arrived", "reader", receiver),
            request: StreamMonitor::new("request", "sections", "outside"),
        }
    }

    /// A cycle of store.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe_store(&mut self, wires: &Wires) -> Result<(), Violation> {
        // The read-back is clocked from the last cycle of the store on.
        self.pixel.observe(wires.pixel)?;
        self.observe_port(wires)?;
        let e = &wires.events;
        self.stored += u64::from(e.stored);
        self.spilled += u64::from(e.spilled);
        self.dropped += u64::from(e.dropped);
        self.own.pixels_stored += u64::from(e.first);
        self.own.allocator_stalls += u64::from(e.waits);
        let mut takes_outside = false;
        if e.section_taken {
            takes_outside = wires.grant.payload >= self.first_outside;
            let row = wires.grant.payload / ROW;
            self.own.row_switches += u64::from(row != self.row);
            self.row = row;
        }
        let frame = &mut self.frame;
        frame.pixels += u64::from(e.first);
        frame.sections += u64::from(e.section_taken);
        frame.outside_sections += u64::from(takes_outside);
        frame.words += u64::from(e.stored && !e.spilled);
        frame.outside_words += u64::from(e.spilled);
        Ok(())
    }

    /// A cycle of resolve.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe_resolve(&mut self, wires: &Wires, frame_done: bool) -> Result<(), Violation> {
        self.pixel.observe(wires.pixel)?;
        self.chain.observe(wires.chain)?;
        self.arrived.observe(wires.arrived)?;
        self.release.observe(wires.release)?;
        self.observe_port(wires)?;
        let (e, own) = (&wires.events, &mut self.own);
        own.chains_read += u64::from(e.chain_begun);
        own.fragments_read += u64::from(e.read && !e.read_again);
        own.fragments_read_again += u64::from(e.read && e.read_again);
        own.culled_late += u64::from(e.culled_late);
        if frame_done {
            self.peak = self.peak.max(self.frame);
            self.frame = Usage::default();
        }
        Ok(())
    }

    /// What the frame at hand has taken so far: sections, and fragments that were stored.
    pub fn taken(&self) -> (u64, u64) {
        (self.frame.sections, self.frame.words + self.frame.outside_words)
    }

    /// The frame at hand is cleared, and comes again. Its fragments that were stored are no more; it is told how many they were.
    pub fn discard(&mut self) -> u64 {
        let (frame, (_, fragments)) = (self.frame, self.taken());
        self.stored -= fragments;
        self.spilled -= frame.outside_words;
        self.own.pixels_stored -= frame.pixels;
        self.peak = self.peak.max(frame);
        self.frame = Usage::default();
        fragments
    }

    fn observe_port(&mut self, wires: &Wires) -> Result<(), Violation> {
        let (e, own) = (&wires.events, &mut self.own);
        own.ssa_hits += u64::from(e.ssa_hit);
        own.ssa_misses += u64::from(e.ssa_miss);
        own.ssa_written_back += u64::from(e.ssa_write_back);
        self.request.observe(wires.outside.request)
    }

    /// The streams between the blocks.
    pub fn streams(&self) -> [Seen; 5] {
        [
            seen(&self.release),
            seen(&self.pixel),
            seen(&self.chain),
            seen(&self.arrived),
            seen(&self.request),
        ]
    }

    /// What was counted.
    pub fn own(&self) -> ChainCounters {
        let peak = self.peak.max(self.frame);
        ChainCounters {
            peak_sections: peak.sections,
            peak_outside_sections: peak.outside_sections,
            ..self.own
        }
    }

    /// What both directions of the section memory must have carried, if a machine reads `compared` fragments and writes
    /// `rewritten` ones beside storing each once and reading it back.
    pub fn closed_forms(
        tally: &Tally,
        census: &Census,
        compared: u64,
        rewritten: u64,
    ) -> [Check; 2] {
        let sides = ["chains.sections.on_chip", "chains.sections.outside"];
        let infos = sides.map(|side| tally.memory(side).map(|memory| memory.info));
        let sum = |of: fn(StorageInfo) -> u64| infos.into_iter().flatten().map(of).sum();
        [
            Check {
                what: "fragments written to section memory, F and weights that changed",
                expected: census.stored + rewritten,
                found: sum(|info| info.writes),
            },
            Check {
                what: "fragments read from section memory, F, those read again and those compared",
                expected: census.stored + tally.figure("fragments_read_again") + compared,
                found: sum(|info| info.reads),
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

    /// Says of the memories of the chains how many of their words were in use. Queues know that by themselves; of the
    /// bitmap every word means something from the start.
    pub fn set_peaks(&self, cfg: &Config, memories: &mut Memories) {
        let peak = self.peak.max(self.frame);
        // Where tails are kept the last section of a chain has no entry: there is one for each section but a
        // chain's first. Elsewhere there is one for each.
        let entries = match cfg.shape {
            Shape { owned: false, link: Link::Tail, .. } => peak.sections - peak.pixels,
            _ => peak.sections,
        };
        if cfg.caches_ssa() {
            memories.set_peak("chains.ssa.outside", peak.pixels);
        } else {
            memories.set_peak("chains.ssa.table", peak.pixels);
        }
        memories.set_peak("chains.nsa.table", entries);
        memories.set_peak("chains.nsa.lent", entries);
        memories.set_peak("chains.sections.on_chip", peak.words);
        if cfg.fragments_outside() > 0 {
            memories.set_peak("chains.sections.outside", peak.outside_words);
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
