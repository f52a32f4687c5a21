//! The frame sequencer: what a machine of fragments is at.
//!
//! ```text
//!                              +-----------+
//!  fragment comes, its end --->|           |---> phase, open
//!  stored, resolved ---------->| Sequencer |---> clear (pixel by pixel, after reset)
//!  again, busy showing ------->|           |---> done (banks swap, show)
//!                              +-----------+
//! ```
//! A machine may ask for a frame again: then the frame's next round is stored.
//!
//! After reset all pixels are cleared, one a cycle. A frame is stored, then resolved; `done` comes in the
//! cycle in which it is both complete and free to be shown, and the next frame may come in the cycle after.

use pellucid_machine::PhaseInfo;
use pellucid_machine::pixel::Screen;
use pellucid_sim::Block;
use pellucid_sim::{Signals, Stream, rtl};

/// What a machine of fragments is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Phase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Taking a frame's items.
    Store,
    /// Turning them into an image.
    Resolve,
    /// The image is done, but the one before is still being shown.
    Wait,
}

/// The same by name, in the order of [`Phase`].
pub const PHASES: &[PhaseInfo] = &[
    PhaseInfo {
        name: "clear",
        about: "Clearing memories, once after reset.",
        works: false,
        counts: true,
    },
    PhaseInfo { name: "idle", about: "Ready for a frame.", works: false, counts: false },
    PhaseInfo {
        name: "store",
        about: "From a frame's first fragment until its last is stored.",
        works: true,
        counts: true,
    },
    PhaseInfo {
        name: "resolve",
        about: "From there until the image is complete.",
        works: true,
        counts: true,
    },
    PhaseInfo {
        name: "wait",
        about: "With a complete image that waits for the one before to be shown.",
        works: false,
        counts: true,
    },
];

/// See the module's description.
pub struct Sequencer;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// What the machine is at.
    pub phase: Phase,
    /// The pixel that is cleared next, after reset.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
    /// The end of the frame has come in: fragments of the next one must wait.
    pub ended: bool,
    /// The image is complete.
    pub resolved: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// A fragment or the end of a frame is taken.
    pub comes: bool,
    /// It is the end.
    pub end: bool,
    /// The frame's last fragment is stored.
    pub stored: bool,
    /// The frame's last pixel is written.
    pub resolved: bool,
    /// The frame is to come again.
    pub again: bool,
    /// The frame before is still being shown.
    pub busy: bool,
    /// The pixel that is cleared is cleared everywhere.
    pub cleared: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// What the machine is at.
    pub phase: Phase,
    /// Fragments may come.
    pub open: bool,
    /// The pixel that is cleared.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The frame is complete and is shown from the next cycle on.
    pub done: bool,
}

#[rtl(output = (), check(Sequencer, crate::test_util::screen(5, 3)))]
impl Block for Sequencer {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Screen) -> State {
        cfg.check();
        State { phase: Phase::Clear, clear: Stream::offer(0), ended: false, resolved: false }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, q: &State, (): &()) -> Moore {
        let open = matches!(q.phase, Phase::Idle | Phase::Store) && !q.ended;
        Moore { phase: q.phase, open, clear: q.clear }
    }

    fn next(cfg: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let resolved = q.resolved || i.resolved;
        let done = resolved && !i.busy;
        match q.phase {
            Phase::Clear => {
                if q.clear.valid && i.cleared {
                    let last = q.clear.payload + 1 == cfg.pixels();
                    d.clear =
                        if last { Stream::idle() } else { Stream::offer(q.clear.payload + 1) };
                } else if !q.clear.valid {
                    d.phase = Phase::Idle;
                }
            }
            Phase::Idle => {
                if i.comes {
                    d.phase = Phase::Store;
                }
            }
            Phase::Store => {
                if i.stored {
                    d.phase = Phase::Resolve;
                }
            }
            Phase::Resolve | Phase::Wait => {
                if done {
                    d.phase = Phase::Idle;
                } else if resolved {
                    d.phase = Phase::Wait;
                }
            }
        }
        if i.again {
            d.phase = Phase::Store;
        }
        d.ended = (q.ended || (i.comes && i.end)) && !done && !i.again;
        d.resolved = resolved && !done;
        Out { done }
    }
}

#[cfg(test)]
mod tests {
    use super::Phase::{Clear, Idle, Resolve, Store, Wait};
    use super::*;
    use crate::test_util::screen;
    use pellucid_sim::Sim;

    #[test]
    fn a_frame_that_is_sent_twice_goes_its_course_cycle_by_cycle() {
        let nothing = In {
            comes: false,
            end: false,
            stored: false,
            resolved: false,
            again: false,
            busy: false,
            cleared: true,
        };
        let comes = In { comes: true, ..nothing };
        let end = In { end: true, ..comes };
        let stored = In { stored: true, ..nothing };
        let again = In { again: true, ..nothing };
        let busy = In { busy: true, ..nothing };
        let resolved = In { resolved: true, ..busy };
        let mut sim = Sim::<Sequencer>::new(screen(2, 1));
        for (cycle, (i, phase, open, done)) in [
            // Two pixels are cleared.
            (nothing, Clear, false, false),
            (nothing, Clear, false, false),
            (nothing, Clear, false, false),
            (nothing, Idle, true, false),
            (comes, Idle, true, false),
            (end, Store, true, false),
            // What comes after the end waits.
            (nothing, Store, false, false),
            (stored, Store, false, false),
            (nothing, Resolve, false, false),
            (again, Resolve, false, false),
            (nothing, Store, true, false),
            (comes, Store, true, false),
            (nothing, Store, true, false),
            (end, Store, true, false),
            (stored, Store, false, false),
            (resolved, Resolve, false, false),
            // The image before is still being shown.
            (busy, Wait, false, false),
            (nothing, Wait, false, true),
            (nothing, Idle, true, false),
        ]
        .into_iter()
        .enumerate()
        {
            let seen = sim.moore();
            let out = sim.clock(i).unwrap().out;
            let seen = (seen.phase, seen.open, out.done);
            assert_eq!(seen, (phase, open, done), "in cycle {cycle}");
        }
    }
}
