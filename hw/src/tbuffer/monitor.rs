//! Watches the T-buffer: counts what it does and holds its streams to their rules.

use super::TBuffer;
use super::config::Config;
use super::lookup::Chain;
use super::{Out, State};
use crate::allocator::Allocator;
use crate::blender::Sorted;
use crate::machine::{
    Arithmetic, Census, Check, Fragments, Machine, Monitor, Phase, PhaseCounts, Ports, Seen, Tally,
    memory_tallies, seen, waits,
};
use crate::pixel::{Fragment, Marked, PixelFragment, Screen};
use crate::sorter::Arrived;
use pellucid_sim::signals::state_name;
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

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
    depth_test: u32,
    store: u32,
    lookup: u32,
    chains: u32,
    pending: u32,
    arrived: u32,
    release: u32,
    scanout: u32,
    on_chip: u32,
    outside: u32,
}

/// See the module's description.
pub struct TBufferMonitor {
    phases: PhaseCounts,
    fragments: Fragments,
    own: Own,
    frame: Usage,
    peak: Usage,
    queues: Queues,
    fragment: StreamMonitor<Marked<Fragment>>,
    passed: StreamMonitor<Marked<PixelFragment>>,
    release: StreamMonitor<u32>,
    pixel: StreamMonitor<Marked<u32>>,
    chain: StreamMonitor<Marked<Chain>>,
    arrived: StreamMonitor<Marked<Arrived>>,
    sorted: StreamMonitor<Marked<Sorted>>,
    image: StreamMonitor<u32>,
}

impl TBufferMonitor {
    #[inline(always)]
    fn observe_store<A: Allocator>(&mut self, q: &State<A>, o: &Out) -> Result<(), Violation> {
        self.passed.observe(o.passed)?;
        // Resolve is clocked from the last cycle of the store on.
        self.pixel.observe(o.pixel)?;

        let e = &o.events;
        let f = &mut self.fragments;
        f.arrived += u64::from(o.fragment.fires() && !o.fragment.payload.end);
        f.drawn += u64::from(e.drawn);
        f.hidden += u64::from(e.hidden);
        f.stored += u64::from(e.stored);
        f.spilled += u64::from(e.spilled);
        f.dropped += u64::from(e.dropped);
        self.own.pixels_stored += u64::from(e.first);
        self.own.culled_early += u64::from(e.culled_early);
        self.own.allocator_stalls += u64::from(e.waits);

        let frame = &mut self.frame;
        frame.pixels += u64::from(e.first);
        frame.sections += u64::from(e.section_taken);
        frame.outside_sections += u64::from(e.section_taken && e.spilled);
        frame.words += u64::from(e.stored && !e.spilled);
        frame.outside_words += u64::from(e.spilled);

        let queues = &mut self.queues;
        queues.depth_test = queues.depth_test.max(q.depth_test.queue.count);
        queues.store = queues.store.max(q.store.queue.count);
        Ok(())
    }

    #[inline(always)]
    fn observe_resolve<A: Allocator>(&mut self, q: &State<A>, o: &Out) -> Result<(), Violation> {
        self.passed.observe(o.passed)?;
        self.pixel.observe(o.pixel)?;
        self.chain.observe(o.chain)?;
        self.arrived.observe(o.arrived)?;
        self.sorted.observe(o.sorted)?;
        self.release.observe(o.release)?;

        let e = &o.events;
        self.fragments.blended += u64::from(e.blended);
        let own = &mut self.own;
        own.chains_read += u64::from(e.chain_begun);
        own.fragments_read += u64::from(e.read && !e.read_again);
        own.fragments_read_again += u64::from(e.read && e.read_again);
        own.culled_late += u64::from(e.culled_late);
        own.blender_idle += u64::from(o.phase == Phase::Resolve && !e.blended);
        if e.frame_done {
            self.peak = self.peak.max(self.frame);
            self.frame = Usage::default();
        }

        let (queues, pool, q) = (&mut self.queues, &q.pool, &q.resolve);
        queues.lookup = queues.lookup.max(q.lookup.queue.count);
        queues.chains = queues.chains.max(q.chain.chains.count);
        queues.pending = queues.pending.max(q.chain.pending.count);
        queues.arrived = queues.arrived.max(q.chain.arrived.count);
        queues.release = queues.release.max(q.release.committed + q.release.open);
        queues.on_chip = queues.on_chip.max(A::words_in_use(&pool.on_chip));
        queues.outside = queues.outside.max(A::words_in_use(&pool.outside));
        Ok(())
    }

    fn streams(&self) -> [Seen; 8] {
        [
            seen(&self.fragment),
            seen(&self.passed),
            seen(&self.release),
            seen(&self.pixel),
            seen(&self.chain),
            seen(&self.arrived),
            seen(&self.sorted),
            seen(&self.image),
        ]
    }

    /// The most words of a memory, by its path, that held something of use at once.
    fn peak_words(&self, cfg: &Config, name: &str, words: u64) -> u64 {
        let (peak, queues) = (self.peak.max(self.frame), &self.queues);
        match name {
            "ssa.table" => peak.pixels,
            // With `append=tail` the last section of a chain has no entry.
            "nsa.table" if cfg.tail => peak.sections - peak.pixels,
            "nsa.table" => peak.sections,
            "sections.on_chip" => peak.words,
            "sections.outside" => peak.outside_words,
            "depth_test.queue" => queues.depth_test.into(),
            "store.queue" => queues.store.into(),
            "resolve.lookup.queue" => queues.lookup.into(),
            "resolve.chain.chains" => queues.chains.into(),
            "resolve.chain.pending" => queues.pending.into(),
            "resolve.chain.arrived" => queues.arrived.into(),
            "resolve.release.queue" => queues.release.into(),
            "scanout.queue" => queues.scanout.into(),
            _ if name.starts_with("pool.on_chip") => queues.on_chip.into(),
            _ if name.starts_with("pool.outside") => queues.outside.into(),
            // Depth, colour and bitmap: every word means something from the start.
            _ => words,
        }
    }
}

impl<A: Allocator> Machine for TBuffer<A> {
    type Monitor = TBufferMonitor;
    const ARITHMETIC: Arithmetic = Arithmetic::Blend;

    #[inline(always)]
    fn ports(out: &Out) -> Ports {
        Ports { phase: out.phase, fragment_ready: out.fragment.ready, image: out.image }
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, census: &Census) -> Vec<Check> {
        let counted = |memory: &str| {
            let found = tally.memories.iter().find(|m| m.name == memory);
            found.map_or((0, 0), |m| (m.info.reads, m.info.writes))
        };
        let figure = |name| tally.own.iter().find(|f| f.name == name).map_or(0, |f| f.value);
        let (on_chip, outside) = (counted("sections.on_chip"), counted("sections.outside"));
        let capacity = u64::from(cfg.capacity);
        let sections =
            census.histogram.iter().zip(0u64..).map(|(n, i)| n * i.div_ceil(capacity)).sum();
        vec![
            Check {
                what: "seed accesses, 2F + P",
                expected: 2 * census.stored + census.pixels(),
                found: tally.seed_accesses,
            },
            Check {
                what: "sections in use, sum of N_i * ceil(i / L)",
                expected: sections,
                found: figure("peak_sections"),
            },
            Check {
                what: "fragments written to section memory, F",
                expected: census.stored,
                found: on_chip.1 + outside.1,
            },
            Check {
                what: "fragments read from section memory, F and those read again",
                expected: census.stored + figure("fragments_read_again"),
                found: on_chip.0 + outside.0,
            },
        ]
    }
}

impl<A: Allocator> Monitor<TBuffer<A>> for TBufferMonitor {
    fn new(_: &Config) -> TBufferMonitor {
        TBufferMonitor {
            phases: PhaseCounts::default(),
            fragments: Fragments::default(),
            own: Own::default(),
            frame: Usage::default(),
            peak: Usage::default(),
            queues: Queues::default(),
            fragment: StreamMonitor::new("fragment", "source", "depth_test"),
            passed: StreamMonitor::new("passed", "depth_test", "store"),
            release: StreamMonitor::new("release", "release", "pool"),
            pixel: StreamMonitor::new("pixel", "scan", "lookup"),
            chain: StreamMonitor::new("chain", "lookup", "chain"),
            arrived: StreamMonitor::new("arrived", "chain", "sorter"),
            sorted: StreamMonitor::new("sorted", "sorter", "blender"),
            image: StreamMonitor::new("image", "scanout", "display"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, _: &Config, q: &State<A>, o: &Out) -> Result<(), Violation> {
        self.phases.observe(o.phase, o.fragment.fires(), o.events.scanout);
        if o.phase != Phase::Clear {
            self.fragment.observe(o.fragment)?;
        }
        self.image.observe(o.image)?;
        self.queues.scanout = self.queues.scanout.max(q.scanout.queue.count);
        // What is not clocked in a phase has nothing to show.
        match o.phase {
            Phase::Clear => Ok(()),
            Phase::Idle | Phase::Store => self.observe_store(q, o),
            Phase::Resolve | Phase::Wait => self.observe_resolve(q, o),
        }
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State<A>) -> Deadlock {
        let state = |block: &str| match block {
            "store" => state_name(q.store.fsm),
            "scan" => state_name(q.resolve.scan.fsm),
            "chain" => state_name(q.resolve.chain.fsm),
            "scanout" => state_name(q.scanout.fsm),
            _ => state_name(q.course.phase),
        };
        let waits = waits(&self.streams(), state);
        Deadlock { cycle, idle, waits }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let peak = self.peak.max(self.frame);
        let own = Own {
            peak_sections: peak.sections,
            peak_outside_sections: peak.outside_sections,
            ..self.own
        };
        Tally {
            cycles: self.phases.cycles(),
            fragments: Fragments { culled: own.culled_early + own.culled_late, ..self.fragments },
            dropped_since: "no section was free (see `sections` and `outside_sections`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memory_tallies(memories, |name, words| self.peak_words(cfg, name, words)),
            seed_accesses: self.fragments.stored + own.fragments_read + own.chains_read,
            seed_bytes: seed_bytes(cfg, u64::from(cfg.null)),
            seed_bytes_used: seed_bytes(cfg, peak.sections),
            own: own.figures(),
        }
    }
}

/// Storage as seed 000 counts it (its Table 2), in bytes: `S_a*W*H + (L*S_f + S_a)*sections`, with
/// 2 bytes for an address and 6 for a fragment without its x and y.
pub fn seed_bytes(cfg: &Config, sections: u64) -> u64 {
    const ADDRESS: u64 = 2;
    const FRAGMENT: u64 = 6;
    let pixels = u64::from(cfg.screen.pixels());
    ADDRESS * pixels + (u64::from(cfg.capacity) * FRAGMENT + ADDRESS) * sections
}
