//! Watches the machine: counts what it does and holds its streams to their rules.

use super::config::{Config, Store, VERTICES};
use super::{FBuffer, MachinePhase, Out, PHASES, State};
use crate::{forms, golden};
use pellucid_blocks::front::monitor::{FramebufferCounters, FrontMonitor};
use pellucid_machine::outside::{self, Outside, Request};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment, Screen};
use pellucid_machine::primitive::Primitive;
use pellucid_machine::{
    Arithmetic, Census, Check, Dealer, Fragments, Machine, Memories, Monitor, PhaseCounts,
    PhaseInfo, Ports, Seen, Tally, seen, waits,
};
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// The machine's own figures.
    pub struct FBufferCounters {
        /// Transparent fragments that get a place (N): all, hidden or not, or where depth is tested early the visible ones.
        fragments: "fragments",
        /// Windows over these, or batches of primitives, that were shaded to the end, again in each round of a sort; one at least for each frame.
        windows: "windows",
        /// How often the primitives were submitted: for each pass of each window, and for the background if it has a play of its own.
        submissions: "submissions",
        /// Primitives of the frames.
        primitives: "primitives",
        /// Vertices that were processed, three for each primitive of a submission.
        vertices: "vertices",
        /// Fragments that went through a pass.
        shaded: "fragments",
        /// Fragments that did not go through a pass since one before had killed them (kill=compact).
        spared: "fragments",
        /// Fragments that were discarded before a pass: outside of its window, or killed before and dropped.
        discarded: "fragments",
        /// First passes of batches that did not fit.
        wasted_passes: "passes",
        /// Fragments that went through these.
        wasted_fragments: "fragments",
        /// Passes of the sort over its memory.
        sort_passes: "passes",
    }
}

/// See the module's description.
pub struct FBufferMonitor {
    phases: PhaseCounts,
    fragments: Fragments,
    own: FBufferCounters,
    framebuffer: FramebufferCounters,
    frames: u64,
    /// Fragments that this play has shaded.
    of_play: u64,
    /// Of these, those that it has killed.
    killed: u64,
    /// Of these, those of the first round.
    killed_at_first: u64,
    /// Of the fragments that were spared a pass, those of first rounds.
    spared_at_first: u64,
    /// The most places that were in use.
    most: u64,
    primitive: StreamMonitor<Marked<Primitive>>,
    fragment: StreamMonitor<Marked<Fragment>>,
    shaded: StreamMonitor<Marked<Fragment>>,
    blends: StreamMonitor<Marked<PixelFragment>>,
    image: StreamMonitor<u32>,
    request: StreamMonitor<Request>,
}

impl FBufferMonitor {
    fn streams(&self) -> Vec<Seen> {
        vec![
            seen(&self.primitive),
            seen(&self.fragment),
            seen(&self.shaded),
            seen(&self.blends),
            seen(&self.image),
            seen(&self.request),
        ]
    }
}

impl Machine for FBuffer {
    type Item = Primitive;
    type Monitor = FBufferMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    fn replays(_: &Config) -> bool {
        true
    }

    /// One engine draws all that is opaque, before a transparent fragment is tested.
    fn dealer(_: &Config) -> Option<Dealer> {
        Some(Box::new(|_| 0))
    }

    fn arithmetic(cfg: &Config) -> Arithmetic {
        let params = &cfg.params;
        golden::arithmetic(
            params.program,
            params.seed,
            params.targets,
            cfg.shader.bits,
            params.store == Store::FrameBuffer,
            cfg.plays.sorts,
        )
    }

    #[inline(always)]
    fn ports(_: &Config, out: &Out) -> Ports {
        Ports {
            phase: out.phase as u8,
            item_ready: out.primitive.ready,
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

    fn screen(cfg: &Config) -> Screen {
        *cfg.screen()
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        forms::closed_forms(cfg, tally, frames)
    }
}

impl Monitor<FBuffer> for FBufferMonitor {
    fn new(_: &Config) -> FBufferMonitor {
        FBufferMonitor {
            phases: PhaseCounts::default(),
            fragments: Fragments::default(),
            own: FBufferCounters::default(),
            framebuffer: FramebufferCounters::default(),
            frames: 0,
            of_play: 0,
            killed: 0,
            killed_at_first: 0,
            spared_at_first: 0,
            most: 0,
            primitive: StreamMonitor::new("primitive", "source", "walker"),
            fragment: StreamMonitor::new("fragment", "walker", "window"),
            shaded: StreamMonitor::new("shaded", "shader", "depth_test"),
            blends: StreamMonitor::new("blends", "depth_test", "compositor"),
            image: StreamMonitor::new("image", "scanout", "display"),
            request: StreamMonitor::new("request", "buffer", "outside"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, cfg: &Config, q: &State, o: &Out) -> Result<(), Violation> {
        let e = &o.events;
        self.phases.observe(o.phase as u8, e.scanout);
        self.image.observe(o.image)?;
        if o.phase == MachinePhase::Clear {
            return Ok(());
        }
        self.primitive.observe(o.primitive)?;
        self.fragment.observe(o.fragment)?;
        self.shaded.observe(o.shaded)?;
        self.blends.observe(o.blends)?;
        self.framebuffer.observe(o.framebuffer.events);
        self.request.observe(o.outside.request)?;
        let (own, fragments) = (&mut self.own, &mut self.fragments);
        let first = o.play.draws;
        own.primitives += u64::from(e.submitted && first);
        own.vertices += u64::from(e.submitted) * u64::from(VERTICES);
        own.discarded += u64::from(e.discarded);
        self.of_play += u64::from(e.shaded);
        self.killed += u64::from(e.killed);
        self.killed_at_first += u64::from(e.killed && first_round(cfg, q));
        let came = o.fragment.fires() && !o.fragment.payload.end && first;
        fragments.arrived += u64::from(came);
        fragments.drawn += u64::from(e.drawn);
        fragments.hidden += u64::from(e.hidden);
        // All that get a place go by once in the last pass of the first window, of each batch; and again in further rounds.
        let last = o.play.shades && q.plays.pass + 1 == cfg.plays.passes && o.play.window == 0;
        let last = last && first_round(cfg, q);
        own.sort_passes += u64::from(e.sort_pass);
        own.fragments += u64::from(last && (e.shaded || e.discarded));
        fragments.culled +=
            u64::from(last && e.culled && cfg.early) + u64::from(e.culled && !cfg.early);
        fragments.blended += u64::from(e.blended);
        if e.play_done {
            self.over(cfg, q, o);
        }
        self.frames += u64::from(e.frame_done);
        Ok(())
    }

    fn transfers(&self) -> u64 {
        self.streams().iter().map(|stream| stream.tally.transfers).sum()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State) -> Deadlock {
        let state = |block: &str| FrontMonitor::state(block, &q.front);
        Deadlock { cycle, idle, waits: waits(&self.streams(), state) }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let mut memories = Memories::new(memories);
        let word_bytes = u64::from(cfg.word_bits() / 8);
        let words = if cfg.window().counts() { self.most } else { cfg.words().into() };
        if cfg.window().counts() {
            let (path, parts) = cfg.memory();
            memories.set_peak(path, self.most * parts);
        }
        let passes = u64::from(cfg.plays.passes);
        let mut own = self.own.figures();
        own.extend(self.framebuffer.figures_of(&cfg.front));
        Tally {
            cycles: self.phases.cycles(PHASES),
            further_cycles: vec![],
            fragments: Fragments { stored: self.fragments.blended, ..self.fragments },
            dropped_since: "a primitive has more fragments than the F-buffer has places (see `size` and `overflow`)",
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: memories.tallies(),
            // Amidst a play more may be spared than are counted by its end.
            seed_accesses: 2
                * ((passes - 1) * self.own.fragments).saturating_sub(self.spared_at_first),
            seed_bytes: word_bytes * u64::from(cfg.words()),
            seed_bytes_used: word_bytes * words,
            own,
            outside: vec![],
        }
    }
}

impl FBufferMonitor {
    /// A play is over.
    #[cold]
    fn over(&mut self, cfg: &Config, q: &State, o: &Out) {
        let own = &mut self.own;
        own.submissions += 1;
        own.shaded += self.of_play;
        if o.events.wasted {
            own.wasted_passes += 1;
            own.wasted_fragments += self.of_play;
        }
        if cfg.window().counts() {
            let gone = if cfg.window().compacts { self.killed } else { 0 };
            self.most = self.most.max(self.of_play - gone);
        }
        if !o.events.wasted {
            let further = u64::from(cfg.plays.passes - 1 - q.plays.pass);
            own.spared += self.killed * further;
            self.spared_at_first += self.killed_at_first * further;
            self.fragments.killed += self.killed_at_first;
        }
        let accepted = o.play.shades && !o.events.wasted;
        if accepted && cfg.plays.batches() && q.plays.pass == 0 {
            self.fragments.dropped += u64::from(o.counted) - self.of_play;
        }
        own.windows += u64::from(accepted && q.plays.pass + 1 == cfg.plays.passes);
        self.of_play = 0;
        self.killed = 0;
        self.killed_at_first = 0;
    }
}

/// Nothing that was sorted has been blended yet.
#[inline(always)]
fn first_round(cfg: &Config, q: &State) -> bool {
    !(cfg.plays.sorts && q.sort.behind.valid)
}
