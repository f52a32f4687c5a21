//! Watches the T-buffer: counts what it does and holds its streams to their rules.

use super::TBuffer;
use super::config::Config;
use super::{Out, State};
use crate::allocator::Allocator;
use crate::blender::Sorted;
use crate::chains::monitor::{ADDRESS_BYTES, ChainsMonitor, section_bytes};
use crate::ends::{Ends, EndsMonitor};
use crate::machine::{
    Arithmetic, Census, Check, Fragments, Machine, Monitor, Phase, Ports, Seen, Tally,
    memory_tallies, seen, waits,
};
use crate::pixel::{Fragment, Marked, Screen};
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// The T-buffer's own figures, beside those of its chains.
    pub struct Own {
        /// Transparent fragments dropped on arrival by the early depth test.
        culled_early: "fragments",
        /// Cycles in which resolve had no fragment to blend.
        blender_idle: "cycles",
    }
}

/// See the module's description.
pub struct TBufferMonitor {
    ends: EndsMonitor,
    chains: ChainsMonitor,
    blended: u64,
    blender_idle: u64,
    sorted: StreamMonitor<Marked<Sorted>>,
}

impl TBufferMonitor {
    fn streams(&self) -> Vec<Seen> {
        self.ends.streams(self.chains.streams().into_iter().chain([seen(&self.sorted)]))
    }
}

impl<A: Allocator> Machine for TBuffer<A> {
    type Item = Fragment;
    type Monitor = TBufferMonitor;
    const ARITHMETIC: Arithmetic = Arithmetic::Blend;

    #[inline(always)]
    fn ports(out: &Out) -> Ports {
        Ports { phase: out.phase, item_ready: out.fragment.ready, image: out.image, replay: false }
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let capacity = u64::from(cfg.params.section_capacity);
        let census = Census::together(frames);
        let sections =
            |frame: &Census| -> u64 { frame.layers().map(|(n, i)| n * i.div_ceil(capacity)).sum() };
        let mut checks = vec![
            Check {
                what: "seed accesses, 2F + P",
                expected: 2 * census.stored + census.pixels(),
                found: tally.seed_accesses,
            },
            Check {
                what: "sections in use, sum of N_i * ceil(i / L)",
                expected: frames.iter().map(sections).max().unwrap_or(0),
                found: tally.figure("peak_sections"),
            },
        ];
        checks.extend(ChainsMonitor::closed_forms(tally, &census));
        checks
    }
}

impl<A: Allocator> Monitor<TBuffer<A>> for TBufferMonitor {
    fn new(_: &Config) -> TBufferMonitor {
        TBufferMonitor {
            ends: EndsMonitor::new("store"),
            chains: ChainsMonitor::new("sorter"),
            blended: 0,
            blender_idle: 0,
            sorted: StreamMonitor::new("sorted", "sorter", "blender"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, _: &Config, q: &State<A>, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.ends.observe(Ends {
            phase: o.phase,
            fragment: o.fragment,
            passed: o.passed,
            image: o.image,
            drawn: e.drawn,
            hidden: e.hidden,
            culled: e.culled_early,
            scanout: e.scanout,
            again: false,
            depth_test: &q.depth_test,
            display: &q.display,
        })?;
        // What is not clocked in a phase has nothing to show.
        match o.phase {
            Phase::Clear => Ok(()),
            Phase::Idle | Phase::Store => self.chains.observe_store(&q.chains, &o.chains),
            Phase::Resolve | Phase::Wait => {
                self.chains.observe_resolve(&q.chains, &o.chains, e.frame_done)?;
                self.sorted.observe(o.sorted)?;
                self.blended += u64::from(e.blended);
                self.blender_idle += u64::from(o.phase == Phase::Resolve && !e.blended);
                Ok(())
            }
        }
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State<A>) -> Deadlock {
        let state = |block: &str| {
            ChainsMonitor::state(block, &q.chains)
                .unwrap_or_else(|| EndsMonitor::state(block, q.course.phase, &q.display))
        };
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let (ends, chains) = (&self.ends, &self.chains);
        let own = chains.own();
        let mut figures = own.figures();
        figures
            .extend(Own { culled_early: ends.culled, blender_idle: self.blender_idle }.figures());
        let peak_words = |name: &str, words| match name.strip_prefix("chains.") {
            Some(name) => chains.peak_words(&cfg.chains, name, words),
            None => ends.peak_words(name, words),
        };
        Tally {
            cycles: ends.phases.cycles(),
            further_cycles: vec![],
            fragments: Fragments {
                stored: chains.stored,
                spilled: chains.spilled,
                culled: ends.culled + own.culled_late,
                blended: self.blended,
                dropped: chains.dropped,
                ..ends.fragments
            },
            dropped_since: "no section was free (see `sections` and `outside_sections`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memory_tallies(memories, peak_words),
            seed_accesses: chains.stored + own.fragments_read + own.chains_read,
            seed_bytes: seed_bytes(cfg, u64::from(cfg.chains.null)),
            seed_bytes_used: seed_bytes(cfg, own.peak_sections),
            own: figures,
        }
    }
}

/// Storage as seed 000 counts it (its Table 2), in bytes: `S_a*W*H + (L*S_f + S_a)*sections`, with
/// 2 bytes for an address and 6 for a fragment without its x and y.
pub fn seed_bytes(cfg: &Config, sections: u64) -> u64 {
    let pixels = u64::from(cfg.screen.pixels());
    ADDRESS_BYTES * pixels + section_bytes(cfg.params.section_capacity) * sections
}
