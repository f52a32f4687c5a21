//! Watches the machine: counts what it does and holds its streams to their rules.

use super::config::Config;
use super::{B3d, MachinePhase, Out, PHASES, State};
use pellucid_blocks::array::counters;
use pellucid_blocks::array::fixed::monitor::FixedMonitor;
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::front::monitor::{FrontMonitor, Wires};
use pellucid_blocks::front::{self};
use pellucid_blocks::rebuild::Overflow;
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
    pub struct B3dCounters {
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
    /// What is to be seen of its front, while a frame comes that came before or not.
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
pub struct B3dMonitor {
    phases: PhaseCounts,
    front: FrontMonitor,
    arrays: FixedMonitor,
    /// The frame at hand came before.
    again: bool,
    /// Transparent fragments in front of the opaque depth when they first came.
    passed: u64,
    blended: u64,
    frames: u64,
    own: B3dCounters,
    sorted: StreamMonitor<Marked<Sorted>>,
}

impl B3dMonitor {
    fn streams(&self) -> Vec<Seen> {
        self.front.streams(self.arrays.streams().into_iter().chain([seen(&self.sorted)]))
    }
}

/// What is known of the plays of frames in which no stored fragment was hidden later, or which came once each.
struct Plays {
    rebuilds: u64,
    /// Slots of each pixel in the last one.
    layers: u64,
    /// Fragments stored in all of them.
    written: u64,
    /// The most that were stored in one.
    most: u64,
    /// Fragments read a second time or later, with passes of K.
    read_again: u64,
}

impl Plays {
    fn of(cfg: &Config, frames: &[Census]) -> Plays {
        let most = u64::from(cfg.most());
        let depth = u64::from(cfg.params.sorter_depth);
        let layers = cfg.params.layers.into();
        let mut plays = Plays { rebuilds: 0, layers, written: 0, most: 0, read_again: 0 };
        for frame in frames {
            loop {
                let kept = |i: u64| i.min(plays.layers);
                let stored = frame.layers().map(|(n, i)| n * kept(i)).sum();
                plays.written += stored;
                plays.most = plays.most.max(stored);
                if stored == frame.stored || plays.layers == most {
                    let again = |i: u64| i * (i.div_ceil(depth).max(1) - 1);
                    plays.read_again +=
                        frame.layers().map(|(n, i)| n * again(kept(i))).sum::<u64>();
                    break;
                }
                plays.rebuilds += 1;
                plays.layers = most.min(2 * plays.layers);
            }
        }
        plays
    }
}

impl Machine for B3d {
    type Item = Fragment;
    type Monitor = B3dMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    fn replays(cfg: &Config) -> bool {
        cfg.arrays.rebuild.rebuilds()
    }

    pellucid_blocks::front_alone! {
        |cfg, q, d, m, clear| cfg.front.outside(), counters::clear_alone(&cfg.arrays.arrays, &mut m.arrays.counters, clear)
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

    fn room(cfg: &Config, frame: &Census) -> Option<Room> {
        let names = match cfg.params.overflow {
            Overflow::Rebuild => &["most_layers", "layers"][..],
            Overflow::Drop => &["layers"],
        };
        Some(Room {
            units: frame.deepest(),
            on_chip: "fragments".to_string(),
            of_unit: cfg.screen.pixels().into(),
            least: 1,
            rest: Rest::all(names),
        })
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let figure = |name| tally.figure(name);
        let check = |what, expected, found| Check { what, expected, found };
        let sides = ["arrays.fragments.on_chip", "arrays.fragments.outside"];
        let infos = || sides.iter().filter_map(|side| tally.memory(side)).map(|side| side.info);
        let rebuilds = figure("rebuilds");
        let most = u64::from(cfg.most());
        let grown = (0..rebuilds).fold(cfg.params.layers.into(), |had, _| most.min(2 * had));
        let stored: u64 = frames.iter().map(|frame| frame.stored).sum();
        let pixels = u64::from(cfg.screen.pixels());
        let mut checks = vec![
            check("slots of each pixel, doubled with each rebuild", grown, figure("layers_used")),
            check(
                "fragments read back, blended or found hidden",
                tally.fragments.blended + figure("culled_late"),
                figure("fragments_read"),
            ),
            check(
                "fragments written to slots, of every play",
                figure("fragments_written"),
                infos().map(|info| info.writes).sum(),
            ),
            check(
                "fragments read from slots, once and again",
                figure("fragments_read") + figure("fragments_read_again"),
                infos().map(|info| info.reads).sum(),
            ),
            check(
                "accesses as the paper counts them, 3F + 2WH a frame",
                3 * stored + 2 * pixels * frames.len() as u64,
                tally.seed_accesses,
            ),
        ];
        checks.extend(FixedMonitor::table_forms(&cfg.arrays, tally, frames.len() as u64));
        if !cfg.arrays.arrays.caches() {
            checks.push(check(
                "cycles of rebuild, one for each word of counters",
                rebuilds * u64::from(cfg.arrays.arrays.words()),
                tally.cycles.of("rebuild").unwrap_or(0),
            ));
        }
        let plays = Plays::of(cfg, frames);
        // A fragment that is hidden after it was stored does not count when the frame comes again.
        let hidden = tally.fragments.culled - figure("culled_early");
        if hidden > 0 && plays.rebuilds > 0 {
            let most = plays.rebuilds;
            checks.extend([
                check(
                    "rebuilds, at most those of what is stored at first",
                    most,
                    most.max(rebuilds),
                ),
                check("rebuilds, at least one", 1, rebuilds.min(1)),
            ]);
            return checks;
        }
        checks.extend([
            check("rebuilds, one each time that slots are too few", plays.rebuilds, rebuilds),
            check(
                "fragments written, sum of N_i * min(i, slots) of every play",
                plays.written,
                figure("fragments_written"),
            ),
            check("fragments read back, F", stored, figure("fragments_read")),
            check("fragments in the fullest play", plays.most, figure("fragments_used")),
            check(
                "storage in use as the paper counts it, W * H * slots * S_f",
                seed_bytes(cfg, plays.layers),
                tally.seed_bytes_used,
            ),
        ]);
        if hidden == 0 {
            checks.push(check(
                "fragments read again, sum of N_i * i * (ceil(i / K) - 1)",
                plays.read_again,
                figure("fragments_read_again"),
            ));
        }
        checks
    }
}

impl Monitor<B3d> for B3dMonitor {
    fn new(_: &Config) -> B3dMonitor {
        B3dMonitor {
            phases: PhaseCounts::default(),
            front: FrontMonitor::new("index"),
            arrays: FixedMonitor::new("sorter"),
            again: false,
            passed: 0,
            blended: 0,
            frames: 0,
            own: B3dCounters::default(),
            sorted: StreamMonitor::new("sorted", "sorter", "blender"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, _: &Config, _: &State, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.phases.observe(o.phase as u8, e.scanout);
        self.front.observe(o.front(self.again))?;
        if o.phase == MachinePhase::Clear {
            return Ok(());
        }
        self.arrays.observe(&o.arrays, e.frame_done)?;
        let passed = o.passed.fires() && !o.passed.payload.end;
        let sent = o.fragment.fires() && !o.fragment.payload.end;
        self.passed += u64::from(passed && !self.again);
        self.own.replayed += u64::from(sent && self.again);
        self.frames += u64::from(e.frame_done);
        if o.phase == MachinePhase::Resolve {
            self.sorted.observe(o.sorted)?;
            self.blended += u64::from(e.blended);
            self.own.blender_idle += u64::from(!e.blended);
        }
        self.again = (self.again || o.arrays.events.again) && !e.frame_done;
        Ok(())
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State) -> Deadlock {
        let state = |block: &str| match block {
            "walk" => state_name(q.arrays.walk.fsm),
            "scanout" => FrontMonitor::state(block, &q.front),
            _ => state_name(q.arrays.rebuild.step),
        };
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let (front, arrays) = (&self.front, &self.arrays);
        let stored = self.passed - arrays.dropped;
        let mut figures = arrays.own.figures();
        figures.extend(B3dCounters { culled_early: front.culled, ..self.own }.figures());
        figures.extend(front.framebuffer_figures(&cfg.front));
        let mut memories = Memories::new(memories);
        arrays.set_peaks(&cfg.arrays, &mut memories);
        Tally {
            cycles: self.phases.cycles(PHASES),
            further_cycles: vec![],
            fragments: Fragments {
                stored,
                spilled: arrays.spilled,
                culled: front.culled + stored - self.blended,
                blended: self.blended,
                dropped: arrays.dropped,
                ..front.fragments
            },
            dropped_since: "the slots of their pixel were full (see `layers`, `most_layers` and `overflow`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            seed_accesses: 3 * stored + 2 * u64::from(cfg.screen.pixels()) * self.frames,
            seed_bytes: seed_bytes(cfg, cfg.most().into()),
            seed_bytes_used: seed_bytes(cfg, arrays.own.layers_used),
            own: figures,
            outside: vec![],
        }
    }
}

/// Storage as seed 002 counts it, in bytes: `W*H*layers*S_f`, with 16 bytes for a fragment as its figure for 590 layers implies
/// (more than 4 GB for 800x600 pixels).
pub fn seed_bytes(cfg: &Config, layers: u64) -> u64 {
    const FRAGMENT: u64 = 16;
    FRAGMENT * layers * u64::from(cfg.screen.pixels())
}
