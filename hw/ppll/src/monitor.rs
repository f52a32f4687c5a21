//! Watches the machine: counts what it does and holds its streams to their rules.

use super::config::Config;
use super::{MachinePhase, Out, PHASES, Ppll, State};
use crate::forms::{self, pages_of};
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::chains;
use pellucid_blocks::chains::monitor::ChainsMonitor;
use pellucid_blocks::front;
use pellucid_blocks::front::monitor::{FrontMonitor, Wires};
use pellucid_blocks::rebuild::{Overflow, Rebuild};
use pellucid_machine::outside::{self, Outside};
use pellucid_machine::pixel::{Fragment, Marked, Screen};
use pellucid_machine::{
    Arithmetic, Census, Check, Fragments, Machine, Memories, Monitor, PhaseCounts, PhaseInfo,
    Ports, Rest, Room, Seen, Tally, seen, waits,
};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Block, Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// The machine's own figures, beside those of its lists, of which a page is a section.
    pub struct PpllCounters {
        /// How often a frame was played again, since pages were too few.
        rebuilds: "rebuilds",
        /// Pages that may be used in the end.
        pages_allowed: "pages",
        /// The most pages that a frame took in the play that was resolved.
        pages_used: "pages",
        /// Slots of those pages that stayed empty.
        slots_wasted: "slots",
        /// Fragments that were stored in plays that were not resolved.
        discarded: "fragments",
        /// Fragments that were sent again.
        replayed: "fragments",
        /// Transparent fragments dropped by the early depth test as they first came.
        culled_early: "fragments",
        /// Cycles in which resolve had no fragment to blend.
        blender_idle: "cycles",
    }
}

impl MachinePhase {
    /// What the front is at meanwhile.
    fn of_front(self) -> front::Phase {
        match self {
            MachinePhase::Clear => front::Phase::Clear,
            MachinePhase::Idle => front::Phase::Idle,
            MachinePhase::Store => front::Phase::Store,
            MachinePhase::Rebuild | MachinePhase::Resolve => front::Phase::Resolve,
            MachinePhase::Wait => front::Phase::Wait,
        }
    }
}

impl Out {
    /// What is to be seen of its front; whether the frame came before.
    #[inline(always)]
    fn front(&self, again: bool) -> Wires {
        let e = &self.events;
        Wires {
            fragment: self.fragment,
            passed: self.passed,
            image: self.image,
            out: front::Out {
                phase: self.phase.of_front(),
                drawn: e.drawn,
                hidden: e.hidden,
                culled: e.culled_early,
                frame_done: e.frame_done,
                events: self.framebuffer.events,
                ..front::Out::default()
            },
            shows: e.scanout,
            again,
        }
    }
}

/// See the module's description.
pub struct PpllMonitor {
    phases: PhaseCounts,
    front: FrontMonitor,
    chains: ChainsMonitor,
    /// The frame comes again.
    again: bool,
    /// Transparent fragments in front of the opaque depth when they first came.
    passed: u64,
    blended: u64,
    /// Fragments of the pixel at hand that were blended, and the pages that those of the pixels before would fill.
    of_pixel: u64,
    pages_blended: u64,
    frames: u64,
    own: PpllCounters,
    sorted: StreamMonitor<Marked<Sorted>>,
}

impl PpllMonitor {
    fn streams(&self) -> Vec<Seen> {
        self.front.streams(self.chains.streams().into_iter().chain([seen(&self.sorted)]))
    }

    /// A frame is done: what its last play took.
    fn frame_done(&mut self, cfg: &Config, q: &State) {
        let (pages, fragments) = self.chains.taken();
        if pages > self.own.pages_used {
            self.own.pages_used = pages;
            self.own.slots_wasted = pages * u64::from(cfg.params.page) - fragments;
        }
        self.own.pages_allowed = Rebuild::moore(&cfg.rebuild, &q.rebuild, &()).limit.into();
        self.frames += 1;
        self.again = false;
    }
}

impl Machine for Ppll {
    type Item = Fragment;
    type Monitor = PpllMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    fn replays(cfg: &Config) -> bool {
        cfg.rebuild.rebuilds()
    }

    pellucid_blocks::front_alone! {
        |cfg, q, d, m, clear| cfg.front.outside(), chains::clear_alone(&cfg.chains, &mut m.chains, clear)
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
            replay: out.replay,
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
        let names = match cfg.params.overflow {
            Overflow::Rebuild => &["most_pages", "pages"][..],
            Overflow::Drop => &["pages"],
        };
        Some(Room {
            units: frame.sum(|i| pages_of(cfg, i)),
            on_chip: "fragments".to_string(),
            of_unit: cfg.params.page.into(),
            least: 1,
            rest: Rest::all(names),
        })
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        forms::closed_forms(cfg, tally, frames)
    }
}

impl Monitor<Ppll> for PpllMonitor {
    fn new(cfg: &Config) -> PpllMonitor {
        let pages_allowed = cfg.rebuild.begin.into();
        PpllMonitor {
            phases: PhaseCounts::default(),
            front: FrontMonitor::new("store"),
            chains: ChainsMonitor::new(&cfg.chains, "sorter"),
            again: false,
            passed: 0,
            blended: 0,
            of_pixel: 0,
            pages_blended: 0,
            frames: 0,
            own: PpllCounters { pages_allowed, ..PpllCounters::default() },
            sorted: StreamMonitor::new("sorted", "sorter", "blender"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, cfg: &Config, q: &State, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.phases.observe(o.phase as u8, e.scanout);
        self.front.observe(o.front(self.again))?;
        let sent = o.fragment.fires() && !o.fragment.payload.end;
        self.own.replayed += u64::from(sent && self.again);
        self.passed += u64::from(o.passed.fires() && !o.passed.payload.end && !self.again);
        match o.phase {
            MachinePhase::Clear => return Ok(()),
            MachinePhase::Idle | MachinePhase::Store => self.chains.observe_store(&o.chains)?,
            MachinePhase::Rebuild => {
                self.chains.observe_resolve(&o.chains, false)?;
                if e.again {
                    self.own.discarded += self.chains.discard();
                    self.own.rebuilds += 1;
                    self.again = true;
                }
            }
            MachinePhase::Resolve | MachinePhase::Wait => {
                if e.frame_done {
                    self.frame_done(cfg, q);
                }
                self.chains.observe_resolve(&o.chains, e.frame_done)?;
                self.sorted.observe(o.sorted)?;
                self.blended += u64::from(e.blended);
                self.own.blender_idle += u64::from(o.phase == MachinePhase::Resolve && !e.blended);
                if o.sorted.fires() && !o.sorted.payload.end {
                    self.of_pixel += 1;
                    if o.sorted.payload.item.last {
                        self.pages_blended += pages_of(cfg, self.of_pixel);
                        self.of_pixel = 0;
                    }
                }
            }
        }
        Ok(())
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State) -> Deadlock {
        let state = |block: &str| match block {
            "source" => state_name(q.rebuild.step),
            _ => ChainsMonitor::state(block, &q.chains)
                .unwrap_or_else(|| FrontMonitor::state(block, &q.front)),
        };
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let (front, chains) = (&self.front, &self.chains);
        let lists = chains.own();
        // Fragments that a later opaque one has hidden before their frame came again.
        let hidden = self.passed - chains.stored - chains.dropped;
        let mut figures = lists.figures();
        figures.extend(PpllCounters { culled_early: front.culled, ..self.own }.figures());
        figures.extend(front.framebuffer_figures(&cfg.front));
        let mut memories = Memories::new(memories);
        chains.set_peaks(&cfg.chains, &mut memories);
        let pixels = u64::from(cfg.screen.pixels());
        Tally {
            cycles: self.phases.cycles(PHASES),
            further_cycles: vec![],
            fragments: Fragments {
                stored: self.passed - chains.dropped,
                spilled: chains.spilled,
                culled: front.culled + hidden + lists.culled_late,
                blended: self.blended,
                dropped: chains.dropped,
                ..front.fragments
            },
            dropped_since: "no page was free (see `pages`, `most_pages` and `overflow`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            seed_accesses: 3 * self.blended + 3 * self.pages_blended + 2 * pixels * self.frames,
            seed_bytes: seed_bytes(cfg, cfg.chains.null.into()),
            seed_bytes_used: seed_bytes(cfg, self.own.pages_used),
            own: figures,
            outside: vec![],
        }
    }
}

/// Storage as seed 002 counts it, in bytes: `sum(ceil(n/g))*(g*S_f + 4) + 4*W*H`, for heads and links of 32 bits and 16 bytes for
/// a fragment, which its figure for a fixed array implies (more than 4 GB for 800x600x590 of them).
pub fn seed_bytes(cfg: &Config, pages: u64) -> u64 {
    const FRAGMENT: u64 = 16;
    const ADDRESS: u64 = 4;
    pages * (u64::from(cfg.params.page) * FRAGMENT + ADDRESS)
        + ADDRESS * u64::from(cfg.screen.pixels())
}
