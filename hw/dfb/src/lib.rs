//! The Dynamic Fragment Buffer (seed 002): transparent fragments counted first, then stored side by side in a buffer, each
//! pixel's where the counts before it end, and sorted as they are read back.
//!
//! ```text
//!             +-----------+ passed +--------+ arrived +--------+ sorted +---------+
//! fragment -->| DepthTest |------->| Arrays |-------->| Sorter |------->| Blender |
//!             +-----------+        +--------+         +--------+        +---------+
//!                   |              |  Steps |--> replay                      |
//!                   | depth,       +--------+                         colour |
//!                   v colour                                                 v
//!             +-------------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout      |--> image
//!             +-------------------------------------------------------------------+
//! ```
//! A frame is counted in the [arrays](mod@array) and its counts are summed up; then it is asked for again and stored,
//! and resolved as in other machines. The depth buffer stays as the first time has left it: when the frame comes again each
//! fragment meets its pixel's final depth, opaque ones are hidden, and what is stored is visible. Where the buffer does not
//! hold the frame it is stored and resolved in bands of pixels, for each of which it is asked for again.

pub mod architecture;
pub mod config;
pub mod monitor;
pub mod steps;

#[cfg(test)]
mod test_util;

use config::Config;
use pellucid_blocks::array::{self, Arrays};
use pellucid_blocks::blender::{self, Blender, Sorted};
use pellucid_blocks::front::{self, Front, Status};
use pellucid_blocks::pixels::{self, Revisit};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{FragmentIn, InConfig, PhaseInfo, outside};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Optional, ReadPort, Signals, Stream, WritePort, rtl};
use steps::{Step, Steps};

/// The machine.
#[derive(Clone, Copy, Debug)]
pub struct Dfb;

/// What the machine is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum MachinePhase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Counting a frame's fragments.
    Count,
    /// Summing up counters.
    Scan,
    /// Storing fragments.
    Store,
    /// Turning them into an image.
    Resolve,
    /// The image is done, but the one before is still being shown.
    Wait,
}

/// The same by name, in the order of [`MachinePhase`].
pub const PHASES: &[PhaseInfo] = &[
    front::PHASES[front::Phase::Clear as usize],
    front::PHASES[front::Phase::Idle as usize],
    PhaseInfo {
        name: "count",
        about: "From a frame's first fragment until its last is counted.",
        works: true,
        counts: true,
    },
    PhaseInfo { name: "scan", about: "Summing up counters.", works: true, counts: true },
    front::PHASES[front::Phase::Store as usize],
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
            Step::Count => MachinePhase::Count,
            Step::Scan => MachinePhase::Scan,
            Step::Store => MachinePhase::Store,
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
    /// See [`steps`].
    #[block(Steps)]
    pub steps: steps::State,
    /// See [`mod@array`].
    #[with(cfg.arrays)]
    #[block(Arrays)]
    pub arrays: array::State,
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
    /// See [`mod@array`].
    #[block(Arrays, cfg.arrays)]
    pub arrays: array::Mem,
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
    /// Transparent fragments in front, to be counted or stored.
    #[with(cfg.screen)]
    pub passed: Handshake<Marked<PixelFragment>>,
    /// What can be seen of the arrays.
    #[with(cfg.arrays)]
    pub arrays: array::Wires,
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
    /// A band of pixels is written.
    pub band_done: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "dfb",
    input = InConfig { screen: cfg.screen, outside: cfg.port.memory() },
    moore = (),
    check(Dfb, crate::test_util::small_dfb("fast", "bands")),
    check(Dfb, crate::test_util::small_dfb("paper", "drop")),
    check(Dfb, crate::test_util::small_dfb("dx", "drop"))
)]
impl Block for Dfb {
    type Config = Config;
    type State = State;
    type In = FragmentIn;
    type Moore = Status;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Status {
        let front = Front::moore(&cfg.front, &q.front, &m.front).status;
        Status { replay: Steps::moore(&(), &q.steps, &()).replay, ..front }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: FragmentIn) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let front = Front::moore(&cfg.front, &q.front, &m.front);
        let at = Steps::moore(&(), &q.steps, &());
        let stored = Arrays::moore(&cfg.arrays, &q.arrays, &m.arrays);
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
        let resolving = at.step == Step::Resolve;
        let blend = if resolving {
            let to_sorter = sorter::In { arrived: gated.arrived, sorted_ready: gated.sorted_ready };
            Sorter::next(&cfg.sorter, &q.sorter, &mut d.sorter, &mut (), to_sorter);
            let to_blender = blender::In { sorted: gated.sorted, colour: front.colour };
            Blender::next(&screen.pixel_bits(), &q.blender, &mut d.blender, &mut (), to_blender)
        } else {
            blender::Out::default()
        };

        let to_arrays = array::In {
            comes: matches!(front.status.phase, front::Phase::Store),
            counting: at.step == Step::Count,
            resolving,
            fragment: front.passed,
            arrived_ready,
            pixel_ready: front.resolve.ready,
            written: blend.frame_done,
            clear: front.clear,
            outside: of_arrays,
        };
        let arrays = Arrays::next(&cfg.arrays, &q.arrays, &mut d.arrays, &mut m.arrays, to_arrays);

        let to_steps = steps::In {
            ended: arrays.ended,
            summed: arrays.summed,
            written: blend.frame_done,
            whole: stored.whole,
            comes: i.fragment.valid && front.status.ready,
        };
        let step = Steps::next(&(), &q.steps, &mut d.steps, &mut (), to_steps);

        let resolve = pixels::arriving(arrays.resolve, stored.arrived, arrived_ready);
        let to_front = front::In {
            fragment: i.fragment,
            image_ready: i.image_ready,
            passed_ready: stored.ready,
            stored: arrays.ended,
            resolved: step.resolved,
            again: step.again,
            cleared: stored.clear_ready,
            depth_read: ReadPort::default(),
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
            phase: phase(done.phase, at.step),
            fragment: i.fragment.with(front.status.ready),
            image: front.status.image.with(i.image_ready),
            replay: at.replay,
            passed: front.passed.with(stored.ready),
            arrays: arrays.wires,
            sorted: sorter.sorted.with(gated.sorted_ready),
            events: Events {
                drawn: done.drawn,
                hidden: done.hidden,
                culled_early: done.culled,
                blended: blend.blended,
                band_done: blend.frame_done,
                scanout: front.status.shows,
                frame_done: done.frame_done,
            },
            framebuffer: pixels::Wires { events: done.events },
            outside,
        }
    }
}
