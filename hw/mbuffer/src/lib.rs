//! The M-buffer with weight factors (seed 000, after Amor et al., 2006): transparent fragments grouped by
//! pixel in sections, of which each pixel owns one, and added up by weight without being sorted.
//!
//! ```text
//!             +-----------+ passed +--------+ arrived +-------+ term +-----+
//! fragment -->| DepthTest |------->| Chains |-------->| Array |----->| Sum |
//!             +-----------+        +--------+         +-------+      +-----+
//!                   |                   |                               |
//!                   | depth, colour     | depth                  colour |
//!                   v                   v                               v
//!             +--------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout |--> image
//!             +--------------------------------------------------------------+
//! ```
//! A frame is stored in the [`chains`], then resolved: they give it back pixel by pixel, the
//! array weighs each pixel's fragments, and they are summed up with what they let through of the opaque
//! colour. With `weights=memory` they are weighed as they arrive and there is no array. See
//! [`weights`](pellucid_blocks::weights) for the arithmetic.

pub mod architecture;
pub mod array;
pub mod config;
pub mod golden;
pub mod monitor;
pub mod sum;

#[cfg(test)]
mod test_util;

use array::Array;
use config::Config;
use pellucid_blocks::allocator::Allocator;
use pellucid_blocks::chains::{self, Chains};
use pellucid_blocks::front::{self, Front, Phase, Status};
use pellucid_blocks::pixels::{self, Revisit};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{FragmentIn, InConfig, outside};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Optional, Signals, Stream, WritePort, rtl};
use std::marker::PhantomData;
use sum::{Sum, Term, plus};

/// The M-buffer with allocator `A`.
#[derive(Clone, Copy, Debug)]
pub struct MBuffer<A>(PhantomData<A>);

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
    /// See [`mod@array`].
    #[with(cfg.array)]
    #[exists(!cfg.in_memory)]
    #[block(Array)]
    pub array: array::State,
    /// See [`sum`].
    #[with(cfg.screen)]
    #[block(Sum)]
    pub sum: sum::State,
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
    /// Sums of weighted fragments.
    #[with(cfg.screen)]
    pub term: Handshake<Marked<Term>>,
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
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "mbuffer",
    input = InConfig { screen: cfg.screen, outside: cfg.port.memory() },
    moore = (),
    check(MBuffer<pellucid_blocks::allocator::FreeList>, crate::test_util::small_mbuffer(true)),
    check(MBuffer<pellucid_blocks::allocator::FreeList>, crate::test_util::small_mbuffer(false))
)]
impl<A: Allocator> Block for MBuffer<A> {
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

        let resolving = matches!(front.status.phase, Phase::Resolve);

        // What chains and frame buffer see of the outside memory.
        let (mut of_chains, mut of_pixels) = (i.outside, outside::In::default());
        if cfg.front.outside() {
            let port = SharedPort::moore(&cfg.port, &q.port, &m.port);
            of_chains = shared_port::fragments(&cfg.port, port, i.outside);
            of_pixels = shared_port::pixels(&cfg.port, port, i.outside);
        }

        // Where the frame buffer lies outside, colours have been read and can be written.
        let arrives = cfg
            .front
            .goes(pixels::opens(front.resolve, stored.arrived) && front.resolve.colour_ready);
        let mut arrived = stored.arrived;
        arrived.valid &= arrives;

        // Resolve: from the chains to the frame buffer. What is weighed already is a term of its own.
        let Marked { end, item } = arrived.payload;
        let weighed = Term { pixel: item.pixel, last: item.last, ..Term::default() };
        let weighed = if item.visible { plus(weighed, item.rgba, item.weight) } else { weighed };
        let term = if cfg.in_memory {
            Stream { valid: arrived.valid, payload: Marked { end, item: weighed } }
        } else {
            Array::moore(&cfg.array, &q.array, &()).term
        };
        let sum = if resolving {
            if !cfg.in_memory {
                let to_array = array::In { arrived };
                Array::next(&cfg.array, &q.array, &mut d.array, &mut (), to_array);
            }
            let to_sum = sum::In { term, colour: front.colour };
            Sum::next(screen, &q.sum, &mut d.sum, &mut (), to_sum)
        } else {
            sum::Out::default()
        };

        let to_chains = chains::In {
            storing: matches!(front.status.phase, Phase::Store),
            resolving,
            start: false,
            limit: 0,
            fragment: front.passed,
            depth: front.depth,
            depth_ready: front.resolve.ready,
            arrived_ready: arrives,
            written: sum.frame_done,
            clear: front.clear,
            outside: of_chains,
        };
        let chains =
            Chains::<A>::next(&cfg.chains, &q.chains, &mut d.chains, &mut m.chains, to_chains);

        // A pixel is written whatever is visible of it.
        let mut resolve = pixels::arriving(chains.resolve, stored.arrived, arrives);
        resolve.visible = true;
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
            colour_read: sum.colour_read,
            colour_write: sum.colour_write,
            resolve,
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
            term: term.with(true),
            events: Events {
                drawn: done.drawn,
                hidden: done.hidden,
                culled_early: done.culled,
                scanout: front.status.shows,
                frame_done: done.frame_done,
            },
            framebuffer: pixels::Wires { events: done.events },
            outside,
        }
    }
}
