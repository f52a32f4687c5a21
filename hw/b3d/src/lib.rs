//! B3D, the fixed rival of the Dynamic Fragment Buffer in seed 002: transparent fragments stored in an array of slots for each
//! pixel, all of one length, and sorted as they are read back.
//!
//! ```text
//!             +-----------+ passed +-------------+ arrived +--------+ sorted +---------+
//! fragment -->| DepthTest |------->| FixedArrays |-------->| Sorter |------->| Blender |
//!             +-----------+        +-------------+         +--------+        +---------+
//!                   |                 |     ^  |                                  |
//!                   | depth,   replay v     |  | depth read                colour |
//!                   v colour                |  v                                  v
//!             +-------------------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout            |--> image
//!             +-------------------------------------------------------------------------+
//! ```
//! A frame is stored in [fixed arrays](fixed) and resolved as in other machines. Where a pixel has more fragments than slots the
//! counters are cleared and the frame is asked for again, with twice the slots for each pixel; what finds no slot when there
//! can be no more is dropped. When the frame comes again the depth buffer stays as the first time has left it.

pub mod architecture;
pub mod config;
pub mod monitor;

#[cfg(test)]
mod test_util;

use config::Config;
use pellucid_blocks::array::fixed::{self, FixedArrays};
use pellucid_blocks::blender::{self, Blender, Sorted};
use pellucid_blocks::front::{self, Front, Status};
use pellucid_blocks::pixels::{self, Revisit};
use pellucid_blocks::rebuild::{self, Step};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{FragmentIn, InConfig, PhaseInfo, outside};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Optional, Signals, Stream, WritePort, rtl};

/// The machine.
#[derive(Clone, Copy, Debug)]
pub struct B3d;

/// What the machine is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum MachinePhase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Storing a frame's fragments.
    Store,
    /// Clearing counters, to have the frame again.
    Rebuild,
    /// Turning fragments into an image.
    Resolve,
    /// The image is done, but the one before is still being shown.
    Wait,
}

/// The same by name, in the order of [`MachinePhase`].
pub const PHASES: &[PhaseInfo] = &[
    front::PHASES[front::Phase::Clear as usize],
    front::PHASES[front::Phase::Idle as usize],
    front::PHASES[front::Phase::Store as usize],
    rebuild::PHASE,
    front::PHASES[front::Phase::Resolve as usize],
    front::PHASES[front::Phase::Wait as usize],
];

/// The phase of the machine whose front is at `front`, and which is at `step` with the frame.
#[inline(always)]
#[rtl]
fn phase(front: front::Phase, step: Step) -> MachinePhase {
    match front {
        front::Phase::Clear => MachinePhase::Clear,
        front::Phase::Idle => MachinePhase::Idle,
        front::Phase::Wait => MachinePhase::Wait,
        front::Phase::Store | front::Phase::Resolve => match step {
            Step::Store => MachinePhase::Store,
            Step::Clear => MachinePhase::Rebuild,
            Step::Resolve => MachinePhase::Resolve,
        },
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`front`].
    #[with(cfg.front)]
    #[block(Front)]
    pub front: front::State,
    /// See [`fixed`].
    #[with(cfg.arrays)]
    #[block(FixedArrays)]
    pub arrays: fixed::State,
    /// See [`sorter`].
    #[with(cfg.sorter)]
    #[block(Sorter)]
    pub sorter: sorter::State,
    /// See [`blender`].
    #[with(cfg.screen.pixel_bits())]
    #[block(Blender)]
    pub blender: blender::State,
    /// See [`shared_port`].
    #[with(cfg.port)]
    #[exists(cfg.front.outside())]
    #[block(SharedPort)]
    pub port: shared_port::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`front`].
    #[block(Front, cfg.front)]
    pub front: front::Mem,
    /// See [`fixed`].
    #[block(FixedArrays, cfg.arrays)]
    pub arrays: fixed::Mem,
    /// See [`shared_port`].
    #[block(SharedPort, cfg.port)]
    #[exists(cfg.front.outside())]
    pub port: Optional<shared_port::Mem>,
}

/// What can be seen of the machine in a cycle: its ports, the streams between its blocks, and what
/// its blocks did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What the machine is at.
    pub phase: MachinePhase,
    /// Fragments come in, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Handshake<Marked<Fragment>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(24)]
    pub image: Handshake<u32>,
    /// What comes next is the same frame again, from its first fragment.
    pub replay: bool,
    /// Transparent fragments in front, to be stored.
    #[with(cfg.screen)]
    pub passed: Handshake<Marked<PixelFragment>>,
    /// What can be seen of the arrays.
    #[with(cfg.arrays)]
    pub arrays: fixed::Wires,
    /// Fragments in blending order.
    #[with(cfg.screen.pixel_bits())]
    pub sorted: Handshake<Marked<Sorted>>,
    /// What happened.
    pub events: Events,
    /// What can be seen of a frame buffer outside.
    #[exists(cfg.front.outside())]
    pub framebuffer: pixels::Wires,
    /// The port to outside memory, where the frame buffer lies there; else it is that of the arrays.
    #[with(cfg.port.memory())]
    #[exists(cfg.front.outside())]
    pub outside: outside::Wires,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// An opaque fragment was drawn.
    pub drawn: bool,
    /// An opaque fragment was hidden.
    pub hidden: bool,
    /// A transparent fragment was hidden on arrival.
    pub culled_early: bool,
    /// A fragment was blended.
    pub blended: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "b3d",
    input = InConfig { screen: cfg.screen, outside: cfg.port.memory() },
    moore = (),
    check(B3d, crate::test_util::small_b3d(1, 6)),
    check(B3d, crate::test_util::small_b3d(3, 3))
)]
impl Block for B3d {
    type Config = Config;
    type State = State;
    type In = FragmentIn;
    type Moore = Status;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Status {
        let front = Front::moore(&cfg.front, &q.front, &m.front).status;
        let replay = FixedArrays::moore(&cfg.arrays, &q.arrays, &m.arrays).replay;
        Status { replay, ..front }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: FragmentIn) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let front = Front::moore(&cfg.front, &q.front, &m.front);
        let stored = FixedArrays::moore(&cfg.arrays, &q.arrays, &m.arrays);
        let sorter = Sorter::moore(&cfg.sorter, &q.sorter, &());

        let gated = front::gated(&cfg.front, front.resolve, stored.arrived, sorter);
        let arrived_ready = gated.arrived_ready;

        // What arrays and frame buffer see of the outside memory.
        let (mut of_arrays, mut of_pixels) = (i.outside, outside::In::default());
        if cfg.front.outside() {
            let port = SharedPort::moore(&cfg.port, &q.port, &m.port);
            of_arrays = shared_port::fragments(&cfg.port, port, i.outside);
            of_pixels = shared_port::pixels(&cfg.port, port, i.outside);
        }

        // Resolve: from the arrays to the frame buffer.
        let blend = if stored.step == Step::Resolve {
            let to_sorter = sorter::In { arrived: gated.arrived, sorted_ready: gated.sorted_ready };
            Sorter::next(&cfg.sorter, &q.sorter, &mut d.sorter, &mut (), to_sorter);
            let to_blender = blender::In { sorted: gated.sorted, colour: front.colour };
            Blender::next(&screen.pixel_bits(), &q.blender, &mut d.blender, &mut (), to_blender)
        } else {
            blender::Out::default()
        };

        let to_arrays = fixed::In {
            comes: matches!(front.status.phase, front::Phase::Store),
            taken: i.fragment.valid && front.status.ready,
            fragment: front.passed,
            depth: front.depth,
            arrived_ready,
            pixel_ready: front.resolve.ready,
            written: blend.frame_done,
            clear: front.clear,
            outside: of_arrays,
        };
        let arrays =
            FixedArrays::next(&cfg.arrays, &q.arrays, &mut d.arrays, &mut m.arrays, to_arrays);

        let resolve = pixels::arriving(arrays.resolve, stored.arrived, arrived_ready);
        let to_front = front::In {
            fragment: i.fragment,
            image_ready: i.image_ready,
            passed_ready: stored.ready,
            stored: arrays.ended,
            resolved: blend.frame_done,
            again: arrays.wires.events.again,
            cleared: stored.clear_ready,
            depth_read: arrays.depth_read,
            depth_write: WritePort::default(),
            colour_read: blend.colour_read,
            colour_write: blend.colour_write,
            resolve,
            revisit: Revisit::default(),
            memory: of_pixels,
        };
        let done = Front::next(&cfg.front, &q.front, &mut d.front, &mut m.front, to_front);

        let mut outside = outside::Wires::default();
        if cfg.front.outside() {
            let asked = arrays.wires.outside.request;
            let to_port = shared_port::In {
                fragments: Stream { valid: asked.valid, payload: asked.payload },
                pixels: done.request,
                memory: i.outside,
            };
            outside = SharedPort::next(&cfg.port, &q.port, &mut d.port, &mut m.port, to_port);
        }

        Out {
            phase: phase(done.phase, stored.step),
            fragment: i.fragment.with(front.status.ready),
            image: front.status.image.with(i.image_ready),
            replay: stored.replay,
            passed: front.passed.with(stored.ready),
            arrays: arrays.wires,
            sorted: sorter.sorted.with(gated.sorted_ready),
            events: Events {
                drawn: done.drawn,
                hidden: done.hidden,
                culled_early: done.culled,
                blended: blend.blended,
                scanout: front.status.shows,
                frame_done: done.frame_done,
            },
            framebuffer: pixels::Wires { events: done.events },
            outside,
        }
    }
}
