//! The steps of a frame: counted, summed up, stored and resolved, the last three band by band.
//!
//! ```text
//!  ended, summed ---->+-------+
//!  written, whole --->| Steps |---> step, replay
//!  an item comes ---->|       |---> again, resolved
//!                     +-------+
//! ```
//! A frame is asked for again each time that a band's counters are summed up. `replay` is high until its first item comes.

use pellucid_sim::{Block, Signals, rtl};

/// See the module's description.
pub struct Steps;

/// What is done with a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Step {
    /// Its fragments are counted.
    #[default]
    Count,
    /// Counters are summed up.
    Scan,
    /// It came again, and the fragments of a band are stored.
    Store,
    /// They are read back, sorted and blended.
    Resolve,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What is done.
    pub step: Step,
    /// The frame is asked for again.
    pub replay: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// All fragments of the frame have come.
    pub ended: bool,
    /// The band's counters are summed up.
    pub summed: bool,
    /// The band's last pixel is written.
    pub written: bool,
    /// The band is the frame's last.
    pub whole: bool,
    /// An item of the frame comes.
    pub comes: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What is done.
    pub step: Step,
    /// What comes next is the same frame again, from its first item.
    pub replay: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The frame is to be sent again.
    pub again: bool,
    /// The frame's last pixel is written.
    pub resolved: bool,
}

#[rtl(check(Steps, ()))]
impl Block for Steps {
    type Config = ();
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset((): &()) -> State {
        State { step: Step::Count, replay: false }
    }

    fn memories((): &()) {}

    fn moore((): &(), q: &State, (): &()) -> Moore {
        Moore { step: q.step, replay: q.replay }
    }

    fn next((): &(), q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out { again: false, resolved: false };
        match q.step {
            Step::Count => {
                if i.ended {
                    d.step = Step::Scan;
                }
            }
            Step::Scan => {
                if i.summed {
                    o.again = true;
                    d.step = Step::Store;
                }
            }
            Step::Store => {
                if i.ended {
                    d.step = Step::Resolve;
                }
            }
            Step::Resolve => {
                if i.written {
                    o.resolved = i.whole;
                    d.step = if i.whole { Step::Count } else { Step::Scan };
                }
            }
        }
        d.replay = o.again || (q.replay && !i.comes);
        o
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;

    #[test]
    fn a_frame_of_two_bands_goes_its_course_cycle_by_cycle() {
        let nothing =
            In { ended: false, summed: false, written: false, whole: false, comes: false };
        let comes = In { comes: true, ..nothing };
        let ended = In { ended: true, ..nothing };
        let summed = In { summed: true, ..nothing };
        let written = In { written: true, ..nothing };
        let last = In { whole: true, ..written };
        let mut sim = Sim::<Steps>::new(());
        for frame in 0..2 {
            for (cycle, (i, step, replay, again, resolved)) in [
                (comes, Step::Count, false, false, false),
                (ended, Step::Count, false, false, false),
                (nothing, Step::Scan, false, false, false),
                (summed, Step::Scan, false, true, false),
                (nothing, Step::Store, true, false, false),
                (comes, Step::Store, true, false, false),
                (ended, Step::Store, false, false, false),
                (nothing, Step::Resolve, false, false, false),
                (written, Step::Resolve, false, false, false),
                (summed, Step::Scan, false, true, false),
                (comes, Step::Store, true, false, false),
                (ended, Step::Store, false, false, false),
                (last, Step::Resolve, false, false, true),
            ]
            .into_iter()
            .enumerate()
            {
                let seen = sim.moore();
                let out = sim.clock(i).unwrap().out;
                assert_eq!(
                    (seen.step, seen.replay, out.again, out.resolved),
                    (step, replay, again, resolved),
                    "in cycle {cycle} of frame {frame}"
                );
            }
        }
    }
}
