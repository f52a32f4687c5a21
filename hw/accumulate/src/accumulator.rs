//! The accumulator: N frames in, pixel by pixel, and one image out.
//!
//! ```text
//!              +-----------------------------+
//!  frame ----->| Tree, Sums or Planes        |       +------+
//!  (colours)   |   ^                         |------>| Fifo |---> image (colours)
//!  ready <-----| number of pixel and frame   |       +------+
//!              +-----------------------------+
//! ```
//! A pixel a cycle, unless a node of the tree has a sweep of its own. `ready` is low where the image could not take all that is
//! under way: nothing behind it ever stalls.

use crate::colour::{Pixel, packed, unpacked};
use crate::config::{Config, Method};
use crate::planes::{self, Planes};
use crate::sums::{self, Sums};
use crate::tree::{self, MOST_LEVELS, Tree};
use pellucid_machine::outside::{self, Request};
use pellucid_machine::pixel::COLOUR_BITS;
use pellucid_sim::{Block, Fifo, Memory, Optional, Registers, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Accumulator;

/// Registers.
#[derive(Clone, Debug, Registers)]
pub struct State {
    /// The pixel that comes next.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// Its frame, by number within its image; with planes outside [`planes`] has it.
    #[width(cfg.frame_bits())]
    #[exists(!cfg.outside())]
    pub frame: u32,
    /// See [`tree`].
    #[with(cfg.tree)]
    #[block(Tree)]
    #[exists(cfg.has_tree())]
    pub tree: tree::State,
    /// See [`sums`].
    #[with(cfg.sums)]
    #[block(Sums)]
    #[exists(cfg.has_sums())]
    pub sums: sums::State,
    /// See [`planes`].
    #[with(*cfg)]
    #[block(Planes)]
    #[exists(cfg.outside())]
    pub planes: planes::State,
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
    /// What the outside memory shows.
    #[with(cfg.plane_port())]
    #[exists(cfg.outside())]
    pub memory: outside::In,
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
    /// The node of each level that gives a pixel of its result.
    #[with(cfg.merge(k as u32))]
    #[len(cfg.levels())]
    pub nodes: [Merge; MOST_LEVELS],
    /// Levels whose node gives the last pixel of it.
    #[width(cfg.levels())]
    pub merged: u32,
    /// A pixel of a frame comes.
    pub comes: bool,
    /// A node's own sweep goes on by a pixel.
    pub sweeps: bool,
    /// What is asked of the outside memory.
    #[with(cfg.plane_port())]
    #[exists(cfg.outside())]
    pub request: Stream<Request>,
    /// What happened.
    pub events: Events,
}

/// Bits of [`Merge`].
#[derive(Clone, Copy, Debug)]
pub struct MergeConfig {
    number_bits: u32,
    frame_bits: u32,
}

/// Which node merges what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(MergeConfig)]
pub struct Merge {
    /// It gives a pixel of its result.
    pub valid: bool,
    /// Its number in its level, from the first frames on.
    #[width(cfg.number_bits)]
    pub number: u32,
    /// The first frame of which it is the mean, by number within the image.
    #[width(cfg.frame_bits)]
    pub first: u32,
    /// The last one.
    #[width(cfg.frame_bits)]
    pub last: u32,
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
    #[exists(cfg.has_tree())]
    pub tree: Optional<tree::Mem>,
    /// See [`sums`].
    #[block(Sums, cfg.sums)]
    #[exists(cfg.has_sums())]
    pub sums: Optional<sums::Mem>,
    /// See [`planes`].
    #[block(Planes, *cfg)]
    #[exists(cfg.outside())]
    pub planes: Optional<planes::Mem>,
    /// Pixels of the image.
    #[block(Fifo<u32>, cfg.queue())]
    pub queue: <Fifo<u32> as Block>::Mem,
}

/// Pixels of the image that may wait while the next ones are let in.
const WAITING: u32 = 2;

impl Config {
    /// There is a tree of planes on the chip.
    fn has_tree(&self) -> bool {
        self.method() == Method::Tree && !self.outside()
    }
    /// There is a plane of sums there.
    fn has_sums(&self) -> bool {
        self.method() != Method::Tree && !self.outside()
    }
    fn merge(&self, level: u32) -> MergeConfig {
        let number_bits = self.tree.level(level).number_bits();
        MergeConfig { number_bits, frame_bits: self.frame_bits() }
    }
    /// Frames below a node of a level.
    fn frames_of(&self, level: u32) -> u32 {
        (0..=level).map(|k| self.tree.level(k).node.inputs).product()
    }
    /// Room for all that is under way, so that nothing stalls.
    fn queue(&self) -> fifo::Config<u32> {
        let latency = if self.has_tree() {
            self.tree.latency()
        } else if self.outside() {
            0
        } else {
            1
        };
        fifo::Config { depth: WAITING + 1 + latency, item: COLOUR_BITS }
    }
}

/// What the node `number` of a level merges.
#[inline(always)]
#[rtl]
fn merge(cfg: &Config, level: &u32, number: u32) -> Merge {
    let first = number * cfg.frames_of(*level);
    let mut last = cfg.frames() - 1;
    if number < cfg.tree.level(*level).nodes - 1 {
        last = first + (cfg.frames_of(*level) - 1);
    }
    Merge { valid: true, number, first, last }
}

#[rtl(
    check(Accumulator, crate::test_util::small(&[("frames", "4")])),
    check(Accumulator, crate::test_util::small(&[("frames", "4"), ("schedule", "nodes")])),
    check(Accumulator, crate::test_util::small(&[("frames", "3"), ("method", "buffer")])),
    check(Accumulator, crate::test_util::small(&[("frames", "3"), ("method", "blend")])),
    check(Accumulator, crate::test_util::small(&[("frames", "5"), ("weights", "triangle")])),
    check(Accumulator, crate::test_util::outside(&[("frames", "4")]))
)]
impl Block for Accumulator {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let queue = Fifo::<u32>::moore(&cfg.queue(), &q.queue, &m.queue);
        let mut ready = queue.count <= WAITING;
        let mut busy = q.pixel != 0;
        if cfg.outside() {
            let planes = Planes::moore(cfg, &q.planes, &m.planes);
            ready = planes.ready;
            busy |= planes.busy;
        } else if cfg.has_tree() {
            let tree = Tree::moore(&cfg.tree, &q.tree, &m.tree);
            ready &= tree.ready;
            busy |= tree.busy;
        } else {
            busy |= Sums::moore(&cfg.sums, &q.sums, &m.sums).busy;
        }
        Moore { ready, image: queue.front, busy }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let queue = Fifo::<u32>::moore(&cfg.queue(), &q.queue, &m.queue);
        let Stream { valid: comes, payload: rgb } = i.frame;
        let last = q.pixel == cfg.screen.pixels() - 1;
        let frame_in = comes && last;
        if comes {
            d.pixel = if last { 0 } else { q.pixel + 1 };
        }

        let image_ready = queue.count <= WAITING;
        let mut request = Stream::idle();
        let (mut merges, mut merged, mut sweeps) = (0, 0, false);
        let mut numbers = [0; MOST_LEVELS];
        let image = if cfg.outside() {
            let to_planes = planes::In { frame: i.frame, image_ready, memory: i.memory };
            let out = Planes::next(cfg, &q.planes, &mut d.planes, &mut m.planes, to_planes);
            request = out.request;
            (merges, merged, sweeps) = (out.merges, out.merged, out.sweeps);
            numbers = out.nodes;
            out.image
        } else {
            let closes = q.frame == cfg.frames() - 1;
            if frame_in {
                d.frame = if closes { 0 } else { q.frame + 1 };
            }
            let colour = unpacked(&cfg.fraction_bits(), rgb);
            let frame = Stream { valid: comes, payload: Pixel { pixel: q.pixel, closes, colour } };
            if cfg.has_tree() {
                let to_tree = tree::In { frame, image_ready };
                let out = Tree::next(&cfg.tree, &q.tree, &mut d.tree, &mut m.tree, to_tree);
                (merges, merged, sweeps) = (out.merges, out.merged, out.sweeps);
                numbers = out.nodes;
                out.image
            } else {
                let image = Sums::moore(&cfg.sums, &q.sums, &m.sums).image;
                let to_sums = sums::In { frame, opens: q.frame == 0 };
                Sums::next(&cfg.sums, &q.sums, &mut d.sums, &mut m.sums, to_sums);
                image
            }
        };
        let mut nodes = [Merge::default(); MOST_LEVELS];
        for k in 0..cfg.levels() {
            if merges >> k & 1 != 0 {
                nodes[k as usize] = merge(cfg, &k, numbers[k as usize]);
            }
        }
        let push = Stream { valid: image.valid, payload: packed(image.payload.colour) };
        let to_queue = fifo::In { push, pop: i.image_ready };
        Fifo::<u32>::next(&cfg.queue(), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        let image_done = image.valid && image.payload.pixel == cfg.screen.pixels() - 1;
        let events = Events { frame_in, node_done: merged != 0, image_done };
        Out { nodes, merged, comes, sweeps, request, events }
    }
}

#[cfg(test)]
mod tests;
