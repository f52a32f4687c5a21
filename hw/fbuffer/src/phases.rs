//! What the machine is at.

use pellucid_blocks::front;
use pellucid_machine::PhaseInfo;
use pellucid_sim::{Signals, rtl};

/// What the machine is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum MachinePhase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Drawing what is opaque, and nothing else.
    Background,
    /// In a pass before the last one.
    Store,
    /// In the last pass of a window.
    Resolve,
    /// Sorting what it has shaded.
    Sort,
    /// The image is done, but the one before is still being shown.
    Wait,
}

/// The same by name, in the order of [`MachinePhase`].
pub const PHASES: &[PhaseInfo] = &[
    front::PHASES[front::Phase::Clear as usize],
    front::PHASES[front::Phase::Idle as usize],
    PhaseInfo {
        name: "background",
        about: "The frame comes for its opaque fragments alone.",
        works: true,
        counts: true,
    },
    PhaseInfo {
        name: "store",
        about: "Passes before the last one, which leave their values in the F-buffer.",
        works: true,
        counts: true,
    },
    PhaseInfo {
        name: "resolve",
        about: "Last passes: shaded fragments are tested and blended.",
        works: true,
        counts: true,
    },
    PhaseInfo {
        name: "sort",
        about: "Sorting the shaded fragments of a window, and blending them after the last one.",
        works: true,
        counts: true,
    },
    front::PHASES[front::Phase::Wait as usize],
];

/// The phase of the machine whose front is at `front`, with a frame at hand or not.
#[inline(always)]
#[rtl]
pub fn phase(
    front: front::Phase,
    busy: bool,
    shades: bool,
    last: bool,
    sorts: bool,
) -> MachinePhase {
    match front {
        front::Phase::Clear => MachinePhase::Clear,
        front::Phase::Wait => MachinePhase::Wait,
        front::Phase::Idle | front::Phase::Store | front::Phase::Resolve => {
            if !busy {
                MachinePhase::Idle
            } else if !shades {
                MachinePhase::Background
            } else if sorts {
                MachinePhase::Sort
            } else if last {
                MachinePhase::Resolve
            } else {
                MachinePhase::Store
            }
        }
    }
}
