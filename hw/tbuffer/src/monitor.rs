//! Watches the T-buffer: counts what it does and holds its streams to their rules.

use super::TBuffer;
use super::config::Config;
use super::{Out, State};
use pellucid_blocks::allocator::Allocator;
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::chains;
use pellucid_blocks::chains::monitor::{ADDRESS_BYTES, ChainsMonitor, section_bytes};
use pellucid_blocks::front::monitor::{FrontMonitor, Wires};
use pellucid_blocks::front::{self, PHASES, Phase};
use pellucid_machine::outside::{self, Outside};
use pellucid_machine::pixel::{Fragment, Marked, Screen};
use pellucid_machine::{
    Arithmetic, Census, Check, Fragments, Machine, Memories, Monitor, PhaseInfo, Ports, Rest, Room,
    Seen, Tally, seen, waits,
};
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// The T-buffer's own figures, beside those of its chains.
    pub struct TBufferCounters {
        /// Transparent fragments dropped on arrival by the early depth test.
        culled_early: "fragments",
        /// Cycles in which resolve had no fragment to blend.
        blender_idle: "cycles",
    }
}

impl Out {
    /// What is to be seen of its front.
    #[inline(always)]
    fn front(&self) -> Wires {
        let e = &self.events;
        Wires {
            fragment: self.fragment,
            passed: self.passed,
            image: self.image,
            out: front::Out {
                phase: self.phase,
                drawn: e.drawn,
                hidden: e.hidden,
                culled: e.culled_early,
                frame_done: e.frame_done,
                events: self.framebuffer.events,
                ..front::Out::default()
            },
            shows: e.scanout,
            again: false,
        }
    }
}

/// See the module's description.
pub struct TBufferMonitor {
    front: FrontMonitor,
    chains: ChainsMonitor,
    blended: u64,
    blender_idle: u64,
    sorted: StreamMonitor<Marked<Sorted>>,
}

impl TBufferMonitor {
    fn streams(&self) -> Vec<Seen> {
        self.front.streams(self.chains.streams().into_iter().chain([seen(&self.sorted)]))
    }
}

/// Sections that a frame takes.
fn sections(cfg: &Config, frame: &Census) -> u64 {
    let capacity = u64::from(cfg.params.section_capacity);
    frame.sum(|i| i.div_ceil(capacity))
}

impl<A: Allocator> Machine for TBuffer<A> {
    type Item = Fragment;
    type Monitor = TBufferMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    pellucid_blocks::front_alone! {
        |cfg, q, d, m, clear| cfg.front.outside(), chains::clear_alone::<A>(&cfg.chains, &mut m.chains, clear)
    }

    fn arithmetic(_: &Config) -> Arithmetic {
        Arithmetic::BLEND
    }

    #[inline(always)]
    fn ports(cfg: &Config, out: &Out) -> Ports {
        Ports {
            phase: out.phase as u8,
            item_ready: out.fragment.ready,
            image: out.image,
            replay: false,
            outside: if cfg.front.outside() { out.outside } else { out.chains.outside },
        }
    }

    fn port(cfg: &Config) -> outside::Config {
        cfg.port.memory()
    }

    fn outside(cfg: &Config) -> Option<Outside> {
        cfg.outside_memory()
    }

    fn room(cfg: &Config, frame: &Census) -> Option<Room> {
        Some(Room {
            units: sections(cfg, frame),
            on_chip: "sections".to_string(),
            of_unit: 1,
            least: 1,
            rest: Rest::Beyond("outside_sections".to_string()),
        })
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let census = Census::together(frames);
        let mut checks = vec![
            Check {
                what: "accesses as the paper counts them, 2F + P",
                expected: 2 * census.stored + census.pixels(),
                found: tally.seed_accesses,
            },
            Check {
                what: "sections in use, sum of N_i * ceil(i / L)",
                expected: frames.iter().map(|frame| sections(cfg, frame)).max().unwrap_or(0),
                found: tally.figure("peak_sections"),
            },
        ];
        checks.extend(ChainsMonitor::closed_forms(tally, &census, 0, 0));
        checks
    }
}

impl<A: Allocator> Monitor<TBuffer<A>> for TBufferMonitor {
    fn new(cfg: &Config) -> TBufferMonitor {
        TBufferMonitor {
            front: FrontMonitor::new("store"),
            chains: ChainsMonitor::new(&cfg.chains, "sorter"),
            blended: 0,
            blender_idle: 0,
            sorted: StreamMonitor::new("sorted", "sorter", "blender"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, _: &Config, _: &State<A>, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.front.observe(o.front())?;
        // What is not clocked in a phase has nothing to show.
        match o.phase {
            Phase::Clear => Ok(()),
            Phase::Idle | Phase::Store => self.chains.observe_store(&o.chains),
            Phase::Resolve | Phase::Wait => {
                self.chains.observe_resolve(&o.chains, e.frame_done)?;
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
                .unwrap_or_else(|| FrontMonitor::state(block, &q.front))
        };
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let (front, chains) = (&self.front, &self.chains);
        let own = chains.own();
        let mut figures = own.figures();
        figures.extend(
            TBufferCounters { culled_early: front.culled, blender_idle: self.blender_idle }
                .figures(),
        );
        figures.extend(front.framebuffer_figures(&cfg.front));
        let mut memories = Memories::new(memories);
        chains.set_peaks(&cfg.chains, &mut memories);
        Tally {
            cycles: front.cycles(),
            further_cycles: vec![],
            fragments: Fragments {
                stored: chains.stored,
                spilled: chains.spilled,
                culled: front.culled + own.culled_late,
                blended: self.blended,
                dropped: chains.dropped,
                ..front.fragments
            },
            dropped_since: "no section was free (see `sections` and `outside_sections`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            seed_accesses: chains.stored + own.fragments_read + own.chains_read,
            seed_bytes: seed_bytes(cfg, u64::from(cfg.chains.null)),
            seed_bytes_used: seed_bytes(cfg, own.peak_sections),
            own: figures,
            outside: vec![],
        }
    }
}

/// Storage as seed 000 counts it (its Table 2), in bytes: `S_a*W*H + (L*S_f + S_a)*sections`, with
/// 2 bytes for an address and 6 for a fragment without its x and y.
pub fn seed_bytes(cfg: &Config, sections: u64) -> u64 {
    let pixels = u64::from(cfg.screen.pixels());
    ADDRESS_BYTES * pixels + section_bytes(cfg.params.section_capacity) * sections
}
