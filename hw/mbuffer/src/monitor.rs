//! Watches the M-buffer: counts what it does and holds its streams to their rules.

use super::MBuffer;
use super::config::Config;
use super::golden;
use super::sum::Term;
use super::{Out, State, array};
use pellucid_blocks::allocator::Allocator;
use pellucid_blocks::chains;
use pellucid_blocks::chains::monitor::{ChainsMonitor, section_bytes};
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
    /// The M-buffer's own figures, beside those of its chains.
    pub struct MBufferCounters {
        /// Stored fragments that were read to be compared with one that came (weights=memory).
        compared: "fragments",
        /// Weights of stored fragments that were changed in memory (weights=memory).
        weights_changed: "fragments",
        /// Transparent fragments dropped on arrival by the early depth test.
        culled_early: "fragments",
        /// Cycles in which resolve had no fragment read back.
        array_idle: "cycles",
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
pub struct MBufferMonitor {
    front: FrontMonitor,
    chains: ChainsMonitor,
    own: MBufferCounters,
    blended: u64,
    term: StreamMonitor<Marked<Term>>,
}

impl MBufferMonitor {
    fn streams(&self) -> Vec<Seen> {
        self.front.streams(self.chains.streams().into_iter().chain([seen(&self.term)]))
    }
}

/// Fragments that tokens take from their cells in this cycle.
#[inline(always)]
fn taken(cfg: &array::Config, q: &array::State) -> u64 {
    let cells = 0..if q.busy { cfg.cells as usize } else { 0 };
    cells.map(|k| u64::from(q.tokens[k].valid && q.cells[k].valid)).sum()
}

/// Sections that a frame takes beyond those that its pixels own.
fn sections(cfg: &Config, frame: &Census) -> u64 {
    let capacity = u64::from(cfg.params.section_capacity);
    frame.sum(|i| i.div_ceil(capacity).saturating_sub(1))
}

impl<A: Allocator> Machine for MBuffer<A> {
    type Item = Fragment;
    type Monitor = MBufferMonitor;

    const PHASES: &[PhaseInfo] = PHASES;

    pellucid_blocks::front_alone! {
        |cfg, q, d, m, clear| cfg.front.outside(), chains::clear_alone::<A>(&cfg.chains, &mut m.chains, clear)
    }

    fn arithmetic(_: &Config) -> Arithmetic {
        golden::WEIGHTED_SUM
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
            on_chip: "overflow_sections".to_string(),
            of_unit: 1,
            least: 0,
            rest: Rest::Beyond("outside_sections".to_string()),
        })
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let census = Census::together(frames);
        let pairs = census.layers().skip(1).map(|(n, i)| n * i * (i - 1) / 2).sum();
        let mut checks = vec![
            Check {
                what: "accesses as the paper counts them, 2F",
                expected: 2 * census.stored,
                found: tally.seed_accesses,
            },
            Check {
                what: "sections beyond the pixels' own, sum of N_i * (ceil(i / D) - 1)",
                expected: frames.iter().map(|frame| sections(cfg, frame)).max().unwrap_or(0),
                found: tally.figure("peak_sections"),
            },
            Check {
                what: "fragments compared on arrival, sum of N_i * i(i-1)/2",
                expected: if cfg.in_memory { pairs } else { 0 },
                found: tally.figure("compared"),
            },
        ];
        checks.extend(ChainsMonitor::closed_forms(
            tally,
            &census,
            tally.figure("compared"),
            tally.figure("weights_changed"),
        ));
        checks
    }
}

impl<A: Allocator> Monitor<MBuffer<A>> for MBufferMonitor {
    fn new(cfg: &Config) -> MBufferMonitor {
        MBufferMonitor {
            front: FrontMonitor::new("store"),
            chains: ChainsMonitor::new(&cfg.chains, if cfg.in_memory { "sum" } else { "array" }),
            own: MBufferCounters::default(),
            blended: 0,
            term: StreamMonitor::new("term", if cfg.in_memory { "reader" } else { "array" }, "sum"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, cfg: &Config, q: &State<A>, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.front.observe(o.front())?;
        // What is not clocked in a phase has nothing to show.
        match o.phase {
            Phase::Clear => {}
            Phase::Idle | Phase::Store => {
                self.chains.observe_store(&o.chains)?;
                self.own.compared += u64::from(o.chains.events.compared);
                self.own.weights_changed += u64::from(o.chains.events.weight_changed);
            }
            Phase::Resolve | Phase::Wait => {
                self.chains.observe_resolve(&o.chains, e.frame_done)?;
                self.term.observe(o.term)?;
                if o.phase == Phase::Resolve {
                    let arrived = &o.chains.arrived;
                    let fragment = arrived.fires() && !arrived.payload.end;
                    let visible = fragment && arrived.payload.item.visible;
                    self.own.array_idle += u64::from(!fragment);
                    self.blended +=
                        if cfg.in_memory { visible.into() } else { taken(&cfg.array, &q.array) };
                }
            }
        }
        Ok(())
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
        figures.extend(MBufferCounters { culled_early: front.culled, ..self.own }.figures());
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
            dropped_since: "no section was free (see `overflow_sections` and `outside_sections`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            seed_accesses: chains.stored + own.fragments_read,
            seed_bytes: seed_bytes(cfg, u64::from(cfg.chains.null - cfg.chains.owned)),
            seed_bytes_used: seed_bytes(cfg, own.peak_sections),
            own: figures,
            outside: vec![],
        }
    }
}

/// Storage as seed 000 counts it (its Table 2), in bytes: `(W*H + N_L) * (D_avg*S_f + S_a)` for `overflow`
/// sections (N_L) beyond the pixels' own, with 2 bytes for an address and 6 for a fragment without its x
/// and y.
pub fn seed_bytes(cfg: &Config, overflow: u64) -> u64 {
    let sections = u64::from(cfg.screen.pixels()) + overflow;
    sections * section_bytes(cfg.params.section_capacity)
}
