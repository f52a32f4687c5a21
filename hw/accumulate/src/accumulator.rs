//! The accumulator: N frames in, pixel by pixel, and one image out.
//!
//! ```text
//!              +-----------------------------+
//!  frame ----->| Tree or Sums                |       +------+
//!  (colours)   |   ^                         |------>| Fifo |---> image (colours)
//!  ready <-----| number of pixel and frame   |       +------+
//!              +-----------------------------+
//! ```
//! A pixel a cycle, unless a node of the tree has a sweep of its own. `ready` is low where the image could not take all that is
//! under way: nothing behind it ever stalls.

use crate::colour::{Pixel, packed, unpacked};
use crate::config::{Config, Method};
use crate::sums::{self, Sums};
use crate::tree::{self, Tree};
use pellucid_machine::pixel::COLOUR_BITS;
use pellucid_sim::{Block, Fifo, Memory, Registers, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Accumulator;

/// Registers.
#[derive(Clone, Debug, Registers)]
pub struct State {
    /// The pixel that comes next.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// Its frame, by number within its image.
    #[width(cfg.frame_bits())]
    pub frame: u32,
    /// See [`tree`].
    #[with(cfg.tree)]
    #[block(Tree)]
    #[exists(cfg.method() == Method::Tree)]
    pub tree: tree::State,
    /// See [`sums`].
    #[with(cfg.sums)]
    #[block(Sums)]
    #[exists(cfg.method() != Method::Tree)]
    pub sums: sums::State,
    /// Pixels of the image.
    #[with(cfg.queue().depth)]
    #[block(Fifo<u32>, cfg.queue())]
    pub queue: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A pixel of a frame, `0xRRGGBB`, only while `ready`.
    #[with(COLOUR_BITS)]
    pub frame: Stream<u32>,
    /// The display takes a pixel.
    pub image_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A pixel of a frame is taken.
    pub ready: bool,
    /// The image, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// A pixel is under way, or a frame is not complete.
    pub busy: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Levels whose node gives a pixel of its result.
    #[width(cfg.levels())]
    pub merges: u32,
    /// Levels whose node gives the last pixel of it.
    #[width(cfg.levels())]
    pub merged: u32,
    /// A pixel of a frame comes.
    pub comes: bool,
    /// A node's own sweep goes on by a pixel.
    pub sweeps: bool,
    /// What happened.
    pub events: Events,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// A frame has come.
    pub frame_in: bool,
    /// A node has given its result.
    pub node_done: bool,
    /// The last pixel of the image is there.
    pub image_done: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`tree`].
    #[block(Tree, cfg.tree)]
    #[exists(cfg.method() == Method::Tree)]
    pub tree: tree::Mem,
    /// See [`sums`].
    #[block(Sums, cfg.sums)]
    #[exists(cfg.method() != Method::Tree)]
    pub sums: sums::Mem,
    /// Pixels of the image.
    #[block(Fifo<u32>, cfg.queue())]
    pub queue: <Fifo<u32> as Block>::Mem,
}

/// Pixels of the image that may wait while the next ones are let in.
const WAITING: u32 = 2;

impl Config {
    /// Room for all that is under way, so that nothing stalls.
    fn queue(&self) -> fifo::Config<u32> {
        let latency = if self.method() == Method::Tree { self.tree.latency() } else { 1 };
        fifo::Config { depth: WAITING + 1 + latency, item: COLOUR_BITS }
    }
}

#[rtl(
    check(Accumulator, crate::test_util::small(&[("frames", "4")])),
    check(Accumulator, crate::test_util::small(&[("frames", "4"), ("schedule", "nodes")])),
    check(Accumulator, crate::test_util::small(&[("frames", "3"), ("method", "buffer")])),
    check(Accumulator, crate::test_util::small(&[("frames", "3"), ("method", "blend")])),
    check(Accumulator, crate::test_util::small(&[("frames", "5"), ("weights", "triangle")]))
)]
impl Block for Accumulator {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let queue = Fifo::<u32>::moore(&cfg.queue(), &q.queue, &m.queue);
        let mut ready = queue.count <= WAITING;
        let mut busy = q.pixel != 0;
        if cfg.method() == Method::Tree {
            let tree = Tree::moore(&cfg.tree, &q.tree, &m.tree);
            ready &= tree.ready;
            busy |= tree.busy;
        } else {
            busy |= Sums::moore(&cfg.sums, &q.sums, &m.sums).busy;
        }
        Moore { ready, image: queue.front, busy }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let queue = Fifo::<u32>::moore(&cfg.queue(), &q.queue, &m.queue);
        let Stream { valid: comes, payload: rgb } = i.frame;
        let closes = q.frame == cfg.frames() - 1;
        let last = q.pixel == cfg.screen.pixels() - 1;
        let frame_in = comes && last;
        if comes {
            d.pixel = if last { 0 } else { q.pixel + 1 };
        }
        if frame_in {
            d.frame = if closes { 0 } else { q.frame + 1 };
        }

        let colour = unpacked(&cfg.fraction_bits(), rgb);
        let frame = Stream { valid: comes, payload: Pixel { pixel: q.pixel, closes, colour } };
        let out = if cfg.method() == Method::Tree {
            let to_tree = tree::In { frame, image_ready: queue.count <= WAITING };
            Tree::next(&cfg.tree, &q.tree, &mut d.tree, &mut m.tree, to_tree)
        } else {
            let image = Sums::moore(&cfg.sums, &q.sums, &m.sums).image;
            let to_sums = sums::In { frame, opens: q.frame == 0 };
            Sums::next(&cfg.sums, &q.sums, &mut d.sums, &mut m.sums, to_sums);
            tree::Out { image, merges: 0, merged: 0, sweeps: false }
        };
        let tree::Out { image, merges, merged, sweeps } = out;
        let push = Stream { valid: image.valid, payload: packed(image.payload.colour) };
        let to_queue = fifo::In { push, pop: i.image_ready };
        Fifo::<u32>::next(&cfg.queue(), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        let image_done = image.valid && image.payload.pixel == cfg.screen.pixels() - 1;
        let events = Events { frame_in, node_done: merged != 0, image_done };
        Out { merges, merged, comes, sweeps, events }
    }
}

#[cfg(test)]
mod tests;
