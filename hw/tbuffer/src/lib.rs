//! The T-buffer (seed 000): transparent fragments grouped by pixel in sections that any pixel can
//! have, sorted as they are read back.
//!
//! ```text
//!             +-----------+ passed +--------+ arrived +--------+ sorted +---------+
//! fragment -->| DepthTest |------->| Chains |-------->| Sorter |------->| Blender |
//!             +-----------+        +--------+         +--------+        +---------+
//!                   |                   |                                    |
//!                   | depth, colour     | depth                       colour |
//!                   v                   v                                    v
//!             +-------------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout      |--> image
//!             +-------------------------------------------------------------------+
//! ```
//! A frame is stored in the [`chains`], then resolved: they give it back pixel by pixel, and
//! each pixel's fragments are sorted and blended. Then the banks of the frame buffer swap, and while the frame
//! is shown and its bank wiped the next one is stored.

pub mod architecture;
pub mod config;
pub mod monitor;

#[cfg(test)]
mod test_util;

use config::Config;
use pellucid_blocks::allocator::Allocator;
use pellucid_blocks::blender::{self, Blender, Sorted};
use pellucid_blocks::chains::{self, Chains};
use pellucid_blocks::front::{self, Front, Phase, Status};
use pellucid_blocks::pixels::{self, Revisit};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{FragmentIn, InConfig, outside};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Optional, Signals, Stream, WritePort, rtl};
use std::marker::PhantomData;

/// The T-buffer with allocator `A`.
#[derive(Clone, Copy, Debug)]
pub struct TBuffer<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// See [`front`].
    #[with(cfg.front)]
    #[block(Front)]
    pub front: front::State,
    /// See [`chains`].
    #[with(cfg.chains)]
    #[block(Chains<A>)]
    pub chains: chains::State<A>,
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
pub struct Mem<A: Allocator> {
    /// See [`front`].
    #[block(Front, cfg.front)]
    pub front: front::Mem,
    /// See [`chains`].
    #[block(Chains<A>, cfg.chains)]
    pub chains: chains::Mem<A>,
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
    pub phase: Phase,
    /// Fragments come in, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Handshake<Marked<Fragment>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(24)]
    pub image: Handshake<u32>,
    /// Transparent fragments in front, to be stored.
    #[with(cfg.screen)]
    pub passed: Handshake<Marked<PixelFragment>>,
    /// What can be seen of the chains.
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
    /// A fragment was blended.
    pub blended: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "tbuffer",
    input = InConfig { screen: cfg.screen, outside: cfg.port.memory() },
    moore = (),
    check(TBuffer<pellucid_blocks::allocator::FreeList>, crate::test_util::small_tbuffer(true)),
    check(TBuffer<pellucid_blocks::allocator::FreeList>, crate::test_util::small_tbuffer(false))
)]
impl<A: Allocator> Block for TBuffer<A> {
    type Config = Config;
    type State = State<A>;
    type In = FragmentIn;
    type Moore = Status;
    type Out = Out;
    type Mem = Mem<A>;

    fn moore(cfg: &Config, q: &State<A>, m: &Self::Mem) -> Status {
        Front::moore(&cfg.front, &q.front, &m.front).status
    }

    fn next(cfg: &Config, q: &State<A>, d: &mut State<A>, m: &mut Self::Mem, i: FragmentIn) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let front = Front::moore(&cfg.front, &q.front, &m.front);
        let stored = Chains::<A>::moore(&cfg.chains, &q.chains, &m.chains);
        let sorter = Sorter::moore(&cfg.sorter, &q.sorter, &());

        let resolving = matches!(front.status.phase, Phase::Resolve);
        let gated = front::gated(&cfg.front, front.resolve, stored.arrived, sorter);
        let arrived_ready = gated.arrived_ready;

        // What chains and frame buffer see of the outside memory.
        let (mut of_chains, mut of_pixels) = (i.outside, outside::In::default());
        if cfg.front.outside() {
            let port = SharedPort::moore(&cfg.port, &q.port, &m.port);
            of_chains = shared_port::fragments(&cfg.port, port, i.outside);
            of_pixels = shared_port::pixels(&cfg.port, port, i.outside);
        }

        // Resolve: from the chains to the frame buffer.
        let blend = if resolving {
            let to_sorter = sorter::In { arrived: gated.arrived, sorted_ready: gated.sorted_ready };
            Sorter::next(&cfg.sorter, &q.sorter, &mut d.sorter, &mut (), to_sorter);
            let to_blender = blender::In { sorted: gated.sorted, colour: front.colour };
            Blender::next(&screen.pixel_bits(), &q.blender, &mut d.blender, &mut (), to_blender)
        } else {
            blender::Out::default()
        };

        let to_chains = chains::In {
            storing: matches!(front.status.phase, Phase::Store),
            resolving,
            start: false,
            limit: 0,
            fragment: front.passed,
            depth: front.depth,
            depth_ready: front.resolve.ready,
            arrived_ready,
            written: blend.frame_done,
            clear: front.clear,
            outside: of_chains,
        };
        let chains =
            Chains::<A>::next(&cfg.chains, &q.chains, &mut d.chains, &mut m.chains, to_chains);

        let to_front = front::In {
            fragment: i.fragment,
            image_ready: i.image_ready,
            passed_ready: stored.ready,
            stored: chains.stored,
            resolved: chains.done,
            again: false,
            cleared: stored.clear_ready,
            depth_read: chains.depth_read,
            depth_write: WritePort::default(),
            colour_read: blend.colour_read,
            colour_write: blend.colour_write,
            resolve: pixels::arriving(chains.resolve, stored.arrived, arrived_ready),
            revisit: Revisit::default(),
            memory: of_pixels,
        };
        let done = Front::next(&cfg.front, &q.front, &mut d.front, &mut m.front, to_front);

        let mut outside = outside::Wires::default();
        if cfg.front.outside() {
            let asked = chains.wires.outside.request;
            let to_port = shared_port::In {
                fragments: Stream { valid: asked.valid, payload: asked.payload },
                pixels: done.request,
                memory: i.outside,
            };
            outside = SharedPort::next(&cfg.port, &q.port, &mut d.port, &mut m.port, to_port);
        }

        Out {
            phase: done.phase,
            fragment: i.fragment.with(front.status.ready),
            image: front.status.image.with(i.image_ready),
            passed: front.passed.with(stored.ready),
            chains: chains.wires,
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
