//! Watches what all machines have in common: the course of their frames, the depth test, and the display.

use crate::depth_test;
use crate::display;
use crate::machine::{Fragments, Phase, PhaseCounts, Seen, seen};
use crate::pixel::{Fragment, Marked, PixelFragment};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Handshake, StreamMonitor, Violation};

/// What it sees of a machine in a cycle.
pub struct Ends<'a> {
    /// What the machine is at.
    pub phase: Phase,
    /// Fragments come in.
    pub fragment: Handshake<Marked<Fragment>>,
    /// Transparent ones in front go on.
    pub passed: Handshake<Marked<PixelFragment>>,
    /// The image goes out.
    pub image: Handshake<u32>,
    /// An opaque fragment was drawn.
    pub drawn: bool,
    /// An opaque fragment was hidden.
    pub hidden: bool,
    /// A transparent fragment was hidden on arrival.
    pub culled: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The frame came before: its fragments are counted already.
    pub again: bool,
    /// The depth test's registers.
    pub depth_test: &'a depth_test::State,
    /// The display's registers.
    pub display: &'a display::State,
}

/// See the module's description.
pub struct EndsMonitor {
    /// Cycles by phase.
    pub phases: PhaseCounts,
    /// Fragments that came in, and the opaque ones by what became of them.
    pub fragments: Fragments,
    /// Transparent fragments that were hidden on arrival.
    pub culled: u64,
    fragment: StreamMonitor<Marked<Fragment>>,
    passed: StreamMonitor<Marked<PixelFragment>>,
    image: StreamMonitor<u32>,
    depth_test: u32,
    scanout: u32,
}

impl EndsMonitor {
    /// A monitor that has seen nothing; `receiver` is the block that takes transparent fragments.
    pub fn new(receiver: &'static str) -> EndsMonitor {
        EndsMonitor {
            phases: PhaseCounts::default(),
            fragments: Fragments::default(),
            culled: 0,
            fragment: StreamMonitor::new("fragment", "source", "depth_test"),
            passed: StreamMonitor::new("passed", "depth_test", receiver),
            image: StreamMonitor::new("image", "scanout", "display"),
            depth_test: 0,
            scanout: 0,
        }
    }

    /// One cycle.
    ///
    /// # Errors
    /// A stream broke its rules.
    #[inline(always)]
    pub fn observe(&mut self, ends: Ends) -> Result<(), Violation> {
        self.phases.observe(ends.phase, ends.fragment.fires(), ends.scanout);
        self.image.observe(ends.image)?;
        self.scanout = self.scanout.max(ends.display.scanout.queue.count);
        if ends.phase == Phase::Clear {
            return Ok(());
        }
        self.fragment.observe(ends.fragment)?;
        self.passed.observe(ends.passed)?;
        if !ends.again {
            let f = &mut self.fragments;
            f.arrived += u64::from(ends.fragment.fires() && !ends.fragment.payload.end);
            f.drawn += u64::from(ends.drawn);
            f.hidden += u64::from(ends.hidden);
            self.culled += u64::from(ends.culled);
        }
        self.depth_test = self.depth_test.max(ends.depth_test.queue.count);
        Ok(())
    }

    /// The streams, with those of the machine between them.
    pub fn streams(&self, own: impl IntoIterator<Item = Seen>) -> Vec<Seen> {
        let mut streams = vec![seen(&self.fragment), seen(&self.passed)];
        streams.extend(own);
        streams.push(seen(&self.image));
        streams
    }

    /// The state of a block: the scanout's, or else what the machine is at.
    pub fn state(block: &str, phase: Phase, display: &display::State) -> &'static str {
        match block {
            "scanout" => state_name(display.scanout.fsm),
            _ => state_name(phase),
        }
    }

    /// The most words of a memory, by its path, that held something of use at once.
    pub fn peak_words(&self, name: &str, words: u64) -> u64 {
        match name {
            "depth_test.queue" => self.depth_test.into(),
            "display.scanout.queue" => self.scanout.into(),
            // Of each pixel something is known from the start.
            _ => words,
        }
    }
}
