//! Per-pixel linked lists (seed 002's rivals PLL and PPLL): transparent fragments in lists of pages, one list for each pixel,
//! with a new page at its head, sorted as they are read back.
//!
//! ```text
//!             +-----------+ passed +--------+ arrived +--------+ sorted +---------+
//! fragment -->| DepthTest |------->| Chains |-------->| Sorter |------->| Blender |
//!             +-----------+        +--------+         +--------+        +---------+
//!                   |              |Rebuild |--> replay                      |
//!                   | depth,       +--------+                         colour |
//!                   v colour                                                 v
//!             +-------------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout      |--> image
//!             +-------------------------------------------------------------------+
//! ```
//! A page is a section of the [`chains`], and one counter gives pages out. If they are too few the frame is not resolved: the
//! heads are cleared, more pages may be used, and the frame is asked for again, until it fits or there are no more. The depth
//! buffer stays as the first time has left it, so that what is stored when the frame comes again is visible.

pub mod architecture;
pub mod config;
mod forms;
pub mod monitor;

#[cfg(test)]
mod test_util;

use config::Config;
use pellucid_blocks::allocator::Bump;
use pellucid_blocks::blender::{self, Blender, Sorted};
use pellucid_blocks::chains::{self, Chains};
use pellucid_blocks::front::{self, Front, Status};
use pellucid_blocks::pixels::{self, Revisit};
use pellucid_blocks::rebuild::{self, Rebuild, Step};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{FragmentIn, InConfig, PhaseInfo, outside};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Optional, Signals, Stream, WritePort, rtl};

/// The machine.
#[derive(Clone, Copy, Debug)]
pub struct Ppll;

/// What the machine is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum MachinePhase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Storing fragments.
    Store,
    /// Pages were too few: clearing heads.
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
#[derive(Clone, Copy, Signals)]
pub struct State {
    /// See [`front`].
    #[with(cfg.front)]
    #[block(Front)]
    pub front: front::State,
    /// See [`rebuild`].
    #[with(cfg.rebuild)]
    #[block(Rebuild)]
    pub rebuild: rebuild::State,
    /// The lists begin to be read back.
    pub begins: bool,
    /// See [`chains`].
    #[with(cfg.chains)]
    #[block(Chains<Bump>)]
    pub chains: chains::State<Bump>,
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
    /// See [`chains`].
    #[block(Chains<Bump>, cfg.chains)]
    pub chains: chains::Mem<Bump>,
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
    /// What can be seen of the lists.
    #[with(cfg.chains)]
    pub chains: chains::Wires,
    /// Fragments in blending order.
    #[with(cfg.screen.pixel_bits())]
    pub sorted: Handshake<Marked<Sorted>>,
    /// What happened.
    pub events: Events,
    /// What can be seen of a frame buffer outside.
    #[exists(cfg.front.outside())]
    pub framebuffer: pixels::Wires,
    /// The port to outside memory, where the frame buffer lies there; else it is that of the chains.
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
    /// A fragment found no page, and comes again.
    pub lacking: bool,
    /// The frame is to come again.
    pub again: bool,
    /// A fragment was blended.
    pub blended: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "ppll",
    input = InConfig { screen: cfg.screen, outside: cfg.port.memory() },
    moore = (),
    check(Ppll, crate::test_util::small_ppll("ppll4", "rebuild")),
    check(Ppll, crate::test_util::small_ppll("pll", "drop"))
)]
impl Block for Ppll {
    type Config = Config;
    type State = State;
    type In = FragmentIn;
    type Moore = Status;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Status {
        let front = Front::moore(&cfg.front, &q.front, &m.front).status;
        Status { replay: Rebuild::moore(&cfg.rebuild, &q.rebuild, &()).replay, ..front }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: FragmentIn) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let front = Front::moore(&cfg.front, &q.front, &m.front);
        let at = Rebuild::moore(&cfg.rebuild, &q.rebuild, &());
        let stored = Chains::<Bump>::moore(&cfg.chains, &q.chains, &m.chains);
        let sorter = Sorter::moore(&cfg.sorter, &q.sorter, &());

        let gated = front::gated(&cfg.front, front.resolve, stored.arrived, sorter);
        let arrived_ready = gated.arrived_ready;

        // What chains and frame buffer see of the outside memory.
        let (mut of_chains, mut of_pixels) = (i.outside, outside::In::default());
        if cfg.front.outside() {
            let port = SharedPort::moore(&cfg.port, &q.port, &m.port);
            of_chains = shared_port::fragments(&cfg.port, port, i.outside);
            of_pixels = shared_port::pixels(&cfg.port, port, i.outside);
        }

        // Resolve: from the lists to the frame buffer.
        let resolving = at.step == Step::Resolve;
        let blend = if resolving {
            let to_sorter = sorter::In { arrived: gated.arrived, sorted_ready: gated.sorted_ready };
            Sorter::next(&cfg.sorter, &q.sorter, &mut d.sorter, &mut (), to_sorter);
            let to_blender = blender::In { sorted: gated.sorted, colour: front.colour };
            Blender::next(&screen.pixel_bits(), &q.blender, &mut d.blender, &mut (), to_blender)
        } else {
            blender::Out::default()
        };

        let to_chains = chains::In {
            storing: matches!(front.status.phase, front::Phase::Store),
            resolving,
            start: q.begins,
            limit: at.limit,
            fragment: front.passed,
            depth: front.depth,
            depth_ready: front.resolve.ready,
            arrived_ready,
            written: blend.frame_done,
            clear: if front.clear.valid { front.clear } else { at.clear },
            outside: of_chains,
        };
        let chains =
            Chains::<Bump>::next(&cfg.chains, &q.chains, &mut d.chains, &mut m.chains, to_chains);

        // What finds no page comes again while there can be more of them.
        let mut wires = chains.wires;
        let found_none = wires.events.dropped;
        let mut lacking = false;
        if cfg.rebuild.rebuilds() {
            lacking = found_none && at.limit < cfg.rebuild.most;
            wires.events.dropped = found_none && !lacking;
        }
        let to_rebuild = rebuild::In {
            lacking,
            asked: stored.asked,
            ended: chains.stored,
            resolved: chains.done,
            comes: i.fragment.valid && front.status.ready,
            clear_ready: stored.clear_ready,
        };
        let rebuild = Rebuild::next(&cfg.rebuild, &q.rebuild, &mut d.rebuild, &mut (), to_rebuild);
        d.begins = rebuild.begins;

        let resolve = pixels::arriving(chains.resolve, stored.arrived, arrived_ready);
        let to_front = front::In {
            fragment: i.fragment,
            image_ready: i.image_ready,
            passed_ready: stored.ready,
            stored: chains.stored,
            resolved: chains.done,
            again: rebuild.again,
            cleared: stored.clear_ready,
            depth_read: chains.depth_read,
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
            let asked = wires.outside.request;
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
            chains: wires,
            sorted: sorter.sorted.with(gated.sorted_ready),
            events: Events {
                drawn: done.drawn,
                hidden: done.hidden,
                culled_early: done.culled,
                lacking,
                again: rebuild.again,
                blended: blend.blended,
                scanout: front.status.shows,
                frame_done: done.frame_done,
            },
            framebuffer: pixels::Wires { events: done.events },
            outside,
        }
    }
}
