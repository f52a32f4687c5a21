//! Watches the R-buffer: counts what it does and holds its streams to their rules.

use super::config::{Config, LEAST_QUEUE};
use super::{Out, RBuffer, State, selector};
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::front::monitor::{FrontMonitor, Wires, framebuffer_form};
use pellucid_blocks::front::{self, PHASES, Phase};
use pellucid_machine::outside::{self, Outside, Request};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment, Screen};
use pellucid_machine::{
    Arithmetic, Census, Check, Fragments, Machine, Memories, Monitor, PhaseInfo, Ports, Rest, Room,
    Seen, Tally, seen, waits,
};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// The R-buffer's own figures.
    pub struct RBufferCounters {
        /// Passes over what is left in the queue.
        passes: "passes",
        /// Fragments taken from the queue, over all passes.
        popped: "fragments",
        /// Fragments that went back into the queue.
        pushed_back: "fragments",
        /// The most fragments that were in the queue at once.
        peak_queue: "fragments",
        /// Times that a fragment went into outside memory, arrivals and those pushed back.
        spilled: "fragments",
        /// Times that a frame was sent.
        rounds: "rounds",
        /// Of these, those of which the band's fragments did not fit.
        failed_rounds: "rounds",
        /// Fragments that were sent again.
        replayed: "fragments",
        /// Fragments that went into the queue as they came, in all rounds.
        queued: "fragments",
        /// Of these, those that were thrown away in rounds that failed.
        thrown_away: "fragments",
        /// Transparent fragments dropped on arrival by the early depth test.
        culled_early: "fragments",
        /// Stored fragments that a later opaque one hid.
        culled_late: "fragments",
        /// Cycles of resolve in which no fragment left the queue.
        queue_idle: "cycles",
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
            again: self.events.again,
        }
    }
}

/// See the module's description.
pub struct RBufferMonitor {
    front: FrontMonitor,
    fragments: Fragments,
    /// Transparent fragments in front of the opaque depth when they first came.
    passed: u64,
    /// Fragments of the round's band that were hidden on arrival.
    hidden_in_band: u64,
    own: RBufferCounters,
    /// The most fragments that the queue held, on chip, outside and on their way.
    peak_queue: u32,
    /// The most of them that lay outside.
    peak_outside: u32,
    popped: StreamMonitor<Marked<PixelFragment>>,
    pushed: StreamMonitor<PixelFragment>,
    picked: StreamMonitor<Marked<Sorted>>,
    request: StreamMonitor<Request>,
}

impl RBufferMonitor {
    fn streams(&self) -> Vec<Seen> {
        let own = [seen(&self.popped), seen(&self.pushed), seen(&self.picked), seen(&self.request)];
        self.front.streams(own)
    }
}

impl Machine for RBuffer {
    type Item = Fragment;
    type Monitor = RBufferMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    fn replays(cfg: &Config) -> bool {
        cfg.replay
    }

    pellucid_blocks::front_alone! {
        |cfg, q, d, m, clear| cfg.front.outside(), selector::clear_alone(cfg, &q.selector, &mut d.selector, &mut m.selector, clear)
    }

    fn arithmetic(_: &Config) -> Arithmetic {
        Arithmetic::BLEND
    }

    #[inline(always)]
    fn ports(_: &Config, out: &Out) -> Ports {
        Ports {
            phase: out.phase as u8,
            item_ready: out.fragment.ready,
            image: out.image,
            replay: out.replay,
            outside: out.outside,
        }
    }

    fn port(cfg: &Config) -> outside::Config {
        cfg.port.memory()
    }

    fn outside(cfg: &Config) -> Option<Outside> {
        cfg.outside_memory()
    }

    fn room(cfg: &Config, frame: &Census) -> Option<Room> {
        // Sent again in bands, a frame needs no more than its deepest pixel.
        let (least, rest) = match cfg.replay {
            true => (frame.deepest(), Rest::Nothing),
            false => (0, Rest::Beyond("outside_queue".to_string())),
        };
        let least = least.max(LEAST_QUEUE.into());
        Some(Room { units: frame.stored, on_chip: "queue".to_string(), of_unit: 1, least, rest })
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let figure = |name| tally.figure(name);
        let check = |what, expected, found| Check { what, expected, found };
        let mut checks: Vec<Check> = framebuffer_form(&cfg.front, tally).into_iter().collect();
        checks.push(check(
            "fragments queued: blended, culled late or thrown away",
            tally.fragments.blended + figure("culled_late") + figure("thrown_away"),
            figure("queued"),
        ));
        // Where an opaque fragment came after those that it hides, passes depend on the order; where a
        // frame is sent again, on what fits.
        if figure("culled_late") > 0 || figure("replayed") > 0 {
            return checks;
        }
        let census = Census::together(frames);
        let popped = census.layers().map(|(n, i)| n * i * (i + 1) / 2).sum();
        let most = frames.iter().map(|frame| frame.stored).max().unwrap_or(0);
        checks.extend([
            check(
                "passes: layers of the deepest pixel",
                frames.iter().map(Census::deepest).sum(),
                figure("passes"),
            ),
            check("most fragments in the queue, F", most, figure("peak_queue")),
            check("fragments popped, sum of N_i * i(i+1)/2", popped, figure("popped")),
            check(
                "fragments pushed back, sum of N_i * i(i-1)/2",
                popped - census.stored,
                figure("pushed_back"),
            ),
            check(
                "accesses as the paper counts them, F + 2 * sum of N_i * i(i+1)/2 + F",
                2 * census.stored + 2 * popped,
                tally.seed_accesses,
            ),
        ]);
        checks
    }
}

impl Monitor<RBuffer> for RBufferMonitor {
    fn new(_: &Config) -> RBufferMonitor {
        RBufferMonitor {
            front: FrontMonitor::new("selector"),
            fragments: Fragments::default(),
            passed: 0,
            hidden_in_band: 0,
            own: RBufferCounters::default(),
            peak_queue: 0,
            peak_outside: 0,
            popped: StreamMonitor::new("popped", "passes", "selector"),
            pushed: StreamMonitor::new("pushed", "selector", "queue"),
            picked: StreamMonitor::new("picked", "selector", "blender"),
            request: StreamMonitor::new("request", "queue", "outside"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, cfg: &Config, q: &State, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.front.observe(o.front())?;
        // What is hidden counts in the round that blends its pixel.
        if e.round_failed {
            self.hidden_in_band = 0;
        } else if e.round_ends || e.frame_done {
            self.own.culled_early += std::mem::take(&mut self.hidden_in_band);
        }
        if o.phase == Phase::Clear {
            return Ok(());
        }
        self.request.observe(o.outside.request)?;
        if o.phase == Phase::Wait {
            return Ok(());
        }
        self.popped.observe(o.popped)?;
        self.pushed.observe(o.pushed)?;
        self.picked.observe(o.picked)?;

        let resolve = o.phase == Phase::Resolve;
        let pushed = u64::from(o.pushed.fires());
        let popped = u64::from(o.popped.fires() && !o.popped.payload.end);
        let f = &mut self.fragments;
        f.dropped += u64::from(e.dropped);
        f.blended += u64::from(e.blended);
        let own = &mut self.own;
        own.spilled += u64::from(e.spilled);
        own.culled_late += u64::from(e.culled_late);
        own.passes += u64::from(e.pass_begins);
        let came = o.fragment.fires() && !o.fragment.payload.end;
        own.replayed += u64::from(came && e.again);
        own.rounds += u64::from(o.fragment.fires() && o.fragment.payload.end);
        own.failed_rounds += u64::from(e.round_failed);
        let passed = o.passed.fires() && !o.passed.payload.end;
        self.passed += u64::from(passed && !e.again);
        let pixel = if cfg.front.outside() {
            o.passed.payload.item.pixel
        } else {
            q.front.depth_test.stage.payload.item.pixel
        };
        let in_band = (q.rounds.from..q.rounds.to).contains(&pixel);
        self.hidden_in_band += u64::from(e.culled_early && in_band);
        if resolve {
            own.popped += popped;
            own.thrown_away += if q.rounds.failed { popped } else { 0 };
            own.pushed_back += pushed;
            own.queue_idle += 1 - popped;
        } else {
            own.queued += pushed;
            f.spilled += u64::from(e.spilled);
        }
        let queue = &q.queue;
        self.peak_outside = self.peak_outside.max(queue.outside);
        self.peak_queue = self.peak_queue.max(queue.on_chip.count + queue.flying + queue.outside);
        Ok(())
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State) -> Deadlock {
        let state = |block: &str| match block {
            "passes" => state_name(q.passes.fsm),
            _ => FrontMonitor::state(block, &q.front),
        };
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let own = RBufferCounters {
            peak_queue: self.peak_queue.into(),
            culled_early: self.own.culled_early + self.hidden_in_band,
            ..self.own
        };
        let f = &self.fragments;
        let mut figures = own.figures();
        figures.extend(self.front.framebuffer_figures(&cfg.front));
        let mut memories = Memories::new(memories);
        if cfg.queue.port().exists() {
            memories.set_peak("queue.outside", self.peak_outside.into());
        }
        Tally {
            cycles: self.front.cycles(),
            further_cycles: vec![],
            fragments: Fragments {
                stored: self.passed - f.dropped,
                spilled: f.spilled,
                culled: own.culled_early + own.culled_late,
                blended: f.blended,
                dropped: f.dropped,
                ..self.front.fragments
            },
            dropped_since: "the queue was full (see `queue`, `overflow` and `outside_queue`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            seed_accesses: own.queued + 2 * own.popped + f.blended,
            seed_bytes: seed_bytes(cfg, cfg.capacity()),
            seed_bytes_used: seed_bytes(cfg, own.peak_queue),
            own: figures,
            outside: vec![],
        }
    }
}

/// Storage as seed 000 counts it (its Table 2), in bytes: `S*F + Z*W*H + 3*W*H/8`, with 10 bytes for a
/// fragment and 4 for a depth.
pub fn seed_bytes(cfg: &Config, fragments: u64) -> u64 {
    const FRAGMENT: u64 = 10;
    const DEPTH: u64 = 4;
    let pixels = u64::from(cfg.screen.pixels());
    FRAGMENT * fragments + DEPTH * pixels + (3 * pixels).div_ceil(8)
}
