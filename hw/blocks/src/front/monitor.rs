//! Watches the front of a machine of fragments.

use super::{Config, FRAMEBUFFER, Out, Phase, State};
use crate::pixels;
use crate::scanout::Fsm;
use crate::sequencer::PHASES;
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{Check, Cycles, Fragments, PhaseCounts, Seen, Tally, seen};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Figure, Figures, Handshake, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// What is counted of a frame buffer in outside memory.
    pub struct FramebufferCounters {
        /// Fragments whose pixel was found in the frame buffer's cache, or on its way to it.
        framebuffer_hits: "fragments",
        /// Fragments whose pixel's line was fetched.
        framebuffer_misses: "fragments",
        /// Pixels that went back to outside memory.
        framebuffer_written_back: "pixels",
    }
}

impl FramebufferCounters {
    /// One cycle.
    #[inline(always)]
    pub fn observe(&mut self, events: pixels::Events) {
        self.framebuffer_hits += u64::from(events.framebuffer_hit);
        self.framebuffer_misses += u64::from(events.framebuffer_miss);
        self.framebuffer_written_back += u64::from(events.framebuffer_write_back);
    }

    /// What was counted of a frame buffer outside; nothing of one on chip.
    pub fn figures_of(&self, cfg: &Config) -> Vec<Figure> {
        if cfg.outside() { self.figures() } else { vec![] }
    }
}

/// Pixels that were written to a frame buffer outside, where a machine writes none but those of the cache.
pub fn framebuffer_form(cfg: &Config, tally: &Tally) -> Option<Check> {
    let memory = tally.memory(FRAMEBUFFER)?;
    Some(Check {
        what: "pixels written outside, both banks after the reset and what the cache gave back",
        expected: u64::from(cfg.pixels().cleared()) + tally.figure("framebuffer_written_back"),
        found: memory.info.writes,
    })
}

/// The wires of a front in a cycle.
pub struct Wires {
    /// Fragments come in.
    pub fragment: Handshake<Marked<Fragment>>,
    /// Transparent ones in front go on.
    pub passed: Handshake<Marked<PixelFragment>>,
    /// The image goes out.
    pub image: Handshake<u32>,
    /// What the front did.
    pub out: Out,
    /// An image is being shown.
    pub shows: bool,
    /// The frame came before: its fragments are counted already.
    pub again: bool,
}

/// See the module's description.
pub struct FrontMonitor {
    phases: PhaseCounts,
    /// Fragments that came in, and the opaque ones by what became of them.
    pub fragments: Fragments,
    /// Transparent fragments that were hidden on arrival.
    pub culled: u64,
    framebuffer: FramebufferCounters,
    fragment: StreamMonitor<Marked<Fragment>>,
    passed: StreamMonitor<Marked<PixelFragment>>,
    image: StreamMonitor<u32>,
}

impl FrontMonitor {
    /// A monitor that has seen nothing; `receiver` is the block that takes transparent fragments.
    pub fn new(receiver: &'static str) -> FrontMonitor {
        FrontMonitor {
            phases: PhaseCounts::default(),
            fragments: Fragments::default(),
            culled: 0,
            framebuffer: FramebufferCounters::default(),
            fragment: StreamMonitor::new("fragment", "source", "depth_test"),
            passed: StreamMonitor::new("passed", "depth_test", receiver),
            image: StreamMonitor::new("image", "scanout", "display"),
        }
    }

    /// One cycle.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe(&mut self, wires: Wires) -> Result<(), Violation> {
        let Wires { fragment, passed, image, out, shows, again } = wires;
        self.phases.observe(out.phase as u8, shows);
        self.image.observe(image)?;
        self.framebuffer.observe(out.events);
        if out.phase == Phase::Clear {
            return Ok(());
        }
        self.fragment.observe(fragment)?;
        self.passed.observe(passed)?;
        if !again {
            let f = &mut self.fragments;
            f.arrived += u64::from(fragment.fires() && !fragment.payload.end);
            f.drawn += u64::from(out.drawn);
            f.hidden += u64::from(out.hidden);
            self.culled += u64::from(out.culled);
        }
        Ok(())
    }

    /// Cycles by phase.
    pub fn cycles(&self) -> Cycles {
        self.phases.cycles(PHASES)
    }

    /// What was counted of a frame buffer outside; nothing of one on chip.
    pub fn framebuffer_figures(&self, cfg: &Config) -> Vec<Figure> {
        self.framebuffer.figures_of(cfg)
    }

    /// The streams, with those of the machine between them.
    pub fn streams(&self, own: impl IntoIterator<Item = Seen>) -> Vec<Seen> {
        let mut streams = vec![seen(&self.fragment), seen(&self.passed)];
        streams.extend(own);
        streams.push(seen(&self.image));
        streams
    }

    /// The state of a block: the scanout's, or else what the machine is at.
    pub fn state(block: &str, q: &State) -> &'static str {
        match block {
            // Only one of both is ever at work.
            "scanout" if q.pixels.scanout.fsm != Fsm::Idle => state_name(q.pixels.scanout.fsm),
            "scanout" => state_name(q.display.scanout.fsm),
            _ => state_name(q.sequencer.phase),
        }
    }
}
