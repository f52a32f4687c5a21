//! Watches the machine: counts what it does and holds its streams to their rules.

use super::config::Config;
use super::{Dfb, MachinePhase, Out, PHASES, State};
use pellucid_blocks::array::counters;
use pellucid_blocks::array::monitor::ArraysMonitor;
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::front::monitor::{FrontMonitor, Wires};
use pellucid_blocks::front::{self};
use pellucid_machine::outside::{self, Outside};
use pellucid_machine::pixel::{Fragment, Marked, Screen};
use pellucid_machine::{
    Arithmetic, Census, Check, Fragments, Machine, Memories, Monitor, PhaseCounts, PhaseInfo,
    Ports, Rest, Room, Seen, Tally, seen, waits,
};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// The machine's own figures, beside those of its arrays.
    pub struct DfbCounters {
        /// Counted fragments that a later opaque one hid: their slots stay empty.
        holes: "fragments",
        /// Bands of pixels that were stored and resolved: one of each frame that the buffer holds.
        bands: "bands",
        /// Fragments that were sent again.
        replayed: "fragments",
        /// Transparent fragments dropped by the early depth test as they were to be counted.
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
            MachinePhase::Count | MachinePhase::Store => front::Phase::Store,
            MachinePhase::Scan | MachinePhase::Resolve => front::Phase::Resolve,
            MachinePhase::Wait => front::Phase::Wait,
        }
    }
}

impl Out {
    /// Fragments come that were counted before.
    fn again(&self) -> bool {
        self.phase == MachinePhase::Store
    }

    /// What is to be seen of its front.
    #[inline(always)]
    fn front(&self) -> Wires {
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
            again: self.again(),
        }
    }
}

/// See the module's description.
pub struct DfbMonitor {
    phases: PhaseCounts,
    front: FrontMonitor,
    arrays: ArraysMonitor,
    /// Transparent fragments in front of the opaque depth when they first came.
    passed: u64,
    blended: u64,
    frames: u64,
    own: DfbCounters,
    sorted: StreamMonitor<Marked<Sorted>>,
}

impl DfbMonitor {
    fn streams(&self) -> Vec<Seen> {
        self.front.streams(self.arrays.streams().into_iter().chain([seen(&self.sorted)]))
    }
}

impl Machine for Dfb {
    type Item = Fragment;
    type Monitor = DfbMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    fn replays(_: &Config) -> bool {
        true
    }

    pellucid_blocks::front_alone! {
        |cfg, q, d, m, clear| cfg.front.outside(), counters::clear_alone(&cfg.arrays, &mut m.arrays.counters, clear)
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
            outside: if cfg.front.outside() { out.outside } else { out.arrays.outside },
        }
    }

    fn port(cfg: &Config) -> outside::Config {
        cfg.port.memory()
    }

    fn outside(cfg: &Config) -> Option<Outside> {
        cfg.outside_memory()
    }

    fn room(_: &Config, frame: &Census) -> Option<Room> {
        Some(Room {
            units: frame.stored,
            on_chip: "fragments".to_string(),
            of_unit: 1,
            least: 1,
            rest: Rest::Beyond("outside_fragments".to_string()),
        })
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let check = |what, expected, found| Check { what, expected, found };
        let counted = |frame: &Census| -> u64 {
            frame.layers().map(|(n, i)| n * i.min(cfg.arrays.limit().into())).sum()
        };
        let all: u64 = frames.iter().map(counted).sum();
        let most = frames.iter().map(counted).max().unwrap_or(0);
        let number = frames.len() as u64;
        let stored = tally.fragments.blended;
        let mut checks = vec![
            check("fragments counted, sum of N_i * i", all, tally.figure("counted")),
            check(
                "accesses as the paper counts them, N to count, 4 for each that is visible, 6WH a frame",
                all + 4 * stored + 6 * u64::from(cfg.screen.pixels()) * number,
                tally.seed_accesses,
            ),
        ];
        let fits = most <= cfg.arrays.slots().into();
        if fits {
            let used = tally.figure("fragments_used");
            checks.push(check("slots of the fullest frame, sum of N_i * i", most, used));
        }
        // Where a frame is parted in bands, the scan ends with each word that has a border.
        if fits || !cfg.arrays.shape.bands {
            let words = cfg.arrays.words();
            let sweeps = u64::from(cfg.arrays.sweeps(words));
            checks.push(check("bands, one a frame", number, tally.figure("bands")));
            // Where counters lie outside the port says how long it takes.
            if !cfg.arrays.caches() {
                checks.push(check(
                    "cycles of scan, a word of counters a cycle and one more, for each sweep",
                    number * sweeps * (u64::from(words) + 1),
                    tally.cycles.of("scan").unwrap_or(0),
                ));
            }
        }
        if fits {
            checks.extend(ArraysMonitor::table_forms(&cfg.arrays, tally, number));
        }
        checks.extend(ArraysMonitor::closed_forms(tally, stored));
        checks
    }
}

impl Monitor<Dfb> for DfbMonitor {
    fn new(_: &Config) -> DfbMonitor {
        DfbMonitor {
            phases: PhaseCounts::default(),
            front: FrontMonitor::new("index"),
            arrays: ArraysMonitor::new("sorter"),
            passed: 0,
            blended: 0,
            frames: 0,
            own: DfbCounters::default(),
            sorted: StreamMonitor::new("sorted", "sorter", "blender"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, _: &Config, _: &State, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.phases.observe(o.phase as u8, e.scanout);
        self.front.observe(o.front())?;
        if o.phase == MachinePhase::Clear {
            return Ok(());
        }
        self.arrays.observe(&o.arrays)?;
        self.passed += u64::from(o.passed.fires() && !o.passed.payload.end && !o.again());
        let sent = o.fragment.fires() && !o.fragment.payload.end;
        self.own.replayed += u64::from(sent && o.again());
        self.own.bands += u64::from(e.band_done);
        self.frames += u64::from(e.frame_done);
        if o.phase == MachinePhase::Resolve {
            self.sorted.observe(o.sorted)?;
            self.blended += u64::from(e.blended);
            self.own.blender_idle += u64::from(!e.blended);
        }
        Ok(())
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State) -> Deadlock {
        let state = |block: &str| match block {
            "walk" => state_name(q.arrays.walk.fsm),
            "scanout" => FrontMonitor::state(block, &q.front),
            _ => state_name(q.steps.step),
        };
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let (front, arrays) = (&self.front, &self.arrays);
        let holes = self.passed - arrays.stored - arrays.dropped;
        let mut figures = arrays.own.figures();
        figures.extend(DfbCounters { holes, culled_early: front.culled, ..self.own }.figures());
        figures.extend(front.framebuffer_figures(&cfg.front));
        let mut memories = Memories::new(memories);
        arrays.set_peaks(&cfg.arrays, &mut memories);
        let pixels = u64::from(cfg.screen.pixels());
        Tally {
            cycles: self.phases.cycles(PHASES),
            further_cycles: vec![],
            fragments: Fragments {
                stored: self.passed - arrays.dropped,
                spilled: arrays.spilled,
                culled: front.culled + holes,
                blended: self.blended,
                dropped: arrays.dropped,
                ..front.fragments
            },
            dropped_since: "their pixel had no slots (see `fragments`, `outside_fragments`, `count_bits` and `overflow`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            seed_accesses: arrays.own.counted
                + 3 * arrays.stored
                + arrays.own.fragments_read
                + 6 * pixels * self.frames,
            seed_bytes: seed_bytes(cfg, cfg.arrays.slots().into()),
            seed_bytes_used: seed_bytes(cfg, arrays.own.fragments_used),
            own: figures,
            outside: vec![],
        }
    }
}

/// Storage as seed 002 counts it, in bytes: `sum(n)*S_f + 4*W*H + 4*W*H`, for counts and bases of 32 bits and 16 bytes for a
/// fragment, which its figure for a fixed array implies (more than 4 GB for 800x600x590 of them).
pub fn seed_bytes(cfg: &Config, fragments: u64) -> u64 {
    const FRAGMENT: u64 = 16;
    FRAGMENT * fragments + 8 * u64::from(cfg.screen.pixels())
}
