//! A level of the accumulation tree: the planes in which results of the level below wait, and the node that merges them.
//!
//! ```text
//!               +--------+
//!   value ----->| planes |--+   +------+
//!   (pixels)    +--------+  +-->| node |---> result (pixels)
//!        |                  +-->|      |
//!        +------------------+   +------+
//! ```
//! What comes first of a node's inputs is stored, each in a plane of its own; as the last one comes they are all read and merged,
//! and the planes are free. Pixels come in order, one a cycle at most, a sweep of the screen for each input; a result comes in the
//! cycle after its last input. The end of an image closes a node whose inputs have not all come: those that lack have weight zero.

use crate::colour::{Colour, Format, Pixel};
use crate::node::{MOST_INPUTS, Node, mean};
use pellucid_sim::{
    Block, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, check_range, rtl,
};

/// See the module's description.
pub struct Level;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The node.
    pub node: Node,
    /// It is the last one: nobody asks whether an image ends with its result.
    pub root: bool,
    /// Pixels of the screen.
    pub pixels: u32,
    /// Bits of a pixel's number.
    pub pixel_bits: u32,
    /// Nodes of the level in an image.
    pub nodes: u32,
    /// The weights of their edges, those of one node after those of the one before; none if they are plain.
    pub edges: &'static [u32],
}

impl Config {
    /// Planes.
    pub fn planes(&self) -> u32 {
        self.node.inputs - 1
    }
    fn format(&self) -> Format {
        let (pixel_bits, channel_bits) = (self.pixel_bits, self.node.input_bits);
        Format { pixel_bits, channel_bits, closes: true }
    }
    /// What goes through the node, and out of it.
    fn given(&self) -> Format {
        Format { closes: !self.root, ..self.format() }
    }
    /// Bits of a node's number.
    pub fn number_bits(&self) -> u32 {
        if self.nodes > 1 { bits_for(u64::from(self.nodes - 1)) } else { 0 }
    }
    fn edge_bits(&self) -> u32 {
        if self.node.weighted() { self.node.weight_bits + 1 } else { 0 }
    }
    fn filled_bits(&self) -> u32 {
        bits_for(u64::from(self.planes()))
    }
    fn merged_bits(&self) -> u32 {
        if self.node.weighted() { self.filled_bits() } else { 0 }
    }
    /// The weight of an input of a node.
    pub fn edge(&self, node: u32, input: u32) -> u32 {
        self.edges[(node * self.node.inputs + input) as usize]
    }
}

/// Registers: how far the node at hand is.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Config)]
pub struct Fill {
    /// Planes that hold an input.
    #[width(cfg.filled_bits())]
    pub filled: u32,
    /// The node that is filled, by number.
    #[width(cfg.number_bits())]
    pub number: u32,
    /// The weights of the inputs of the one that is merged.
    #[width(cfg.edge_bits())]
    #[len(cfg.node.inputs)]
    pub edges: [u32; MOST_INPUTS],
}

impl Fill {
    /// Nothing waits.
    pub const NONE: Fill = Fill { filled: 0, number: 0, edges: [0; MOST_INPUTS] };
}

/// The weights of the inputs of a node.
#[inline(always)]
#[rtl]
pub fn edges(cfg: &Config, number: u32) -> [u32; MOST_INPUTS] {
    let mut edges = [0; MOST_INPUTS];
    if cfg.node.weighted() {
        for node in 0..cfg.nodes {
            if node == number {
                for k in 0..cfg.node.inputs {
                    edges[k as usize] = cfg.edge(node, k);
                }
            }
        }
    }
    edges
}

/// Where a level is behind a sweep that merges a node, or fills a plane.
#[inline(always)]
#[rtl]
pub fn swept(cfg: &Config, q: Fill, merges: bool, closes: bool) -> Fill {
    let mut number = q.number;
    if cfg.nodes > 1 && merges {
        number = if closes { 0 } else { q.number + 1 };
    }
    Fill { filled: if merges { 0 } else { q.filled + 1 }, number, edges: q.edges }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// How far the node at hand is.
    #[with(*cfg)]
    pub fill: Fill,
    /// Planes that the node that is merged reads.
    #[width(cfg.merged_bits())]
    pub merged: u32,
    /// The number of that node.
    #[width(cfg.number_bits())]
    pub node: u32,
    /// Its last input, while the others are read.
    #[with(cfg.given())]
    pub stage: Stream<Pixel>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A pixel of an input.
    #[with(cfg.format())]
    pub value: Stream<Pixel>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The next input is a node's last.
    pub full: bool,
    /// The node that gives its result, by number.
    #[width(cfg.number_bits())]
    pub node: u32,
    /// A pixel of it.
    #[with(cfg.given())]
    pub result: Stream<Pixel>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// What waits.
    pub planes: Vec<Ram1R1W<Colour>>,
}

#[rtl(
    output = (),
    check(Level, crate::test_util::level(2, 0)),
    check(Level, crate::test_util::level(4, 0)),
    check(Level, crate::test_util::level(2, 3)),
    check(Level, crate::test_util::level(4, 3))
)]
impl Block for Level {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the inputs of an accumulation node", cfg.node.inputs, 2..=MOST_INPUTS as u32);
        State { fill: Fill::NONE, merged: 0, node: 0, stage: Stream::idle() }
    }

    fn memories(cfg: &Config) -> Mem {
        // A pixel is read or written in a sweep, never both.
        let plane =
            |_| Ram1R1W::new(cfg.pixels, cfg.node.input_bits, 1, ReadDuringWrite::Forbidden);
        Mem { planes: (0..cfg.planes()).map(plane).collect() }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let last = q.stage.payload;
        let mut of = [last.colour; MOST_INPUTS];
        for k in 0..cfg.planes() {
            if cfg.node.weighted() {
                // Inputs that lack have weight zero, whatever their planes show.
                if k < q.merged {
                    of[k as usize] = m.planes[k as usize].q().data;
                }
            } else {
                of[k as usize] = m.planes[k as usize].q().data;
            }
        }
        let colour = mean(&cfg.node, of, q.fill.edges);
        let payload = Pixel { pixel: last.pixel, closes: last.closes, colour };
        let full = q.fill.filled == cfg.planes();
        Moore { full, node: q.node, result: Stream { valid: q.stage.valid, payload } }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) {
        let Pixel { pixel, closes, colour } = i.value.payload;
        let merges = closes || q.fill.filled == cfg.planes();
        d.stage.valid = i.value.valid && merges;
        if i.value.valid {
            for k in 0..cfg.planes() {
                if merges {
                    if k < q.fill.filled {
                        m.planes[k as usize].read(pixel);
                    }
                } else if k == q.fill.filled {
                    m.planes[k as usize].write(pixel, colour);
                }
            }
            if merges {
                let closes = closes && !cfg.root;
                d.stage.payload = Pixel { pixel, closes, colour };
                d.node = q.fill.number;
            }
            if pixel == cfg.pixels - 1 {
                d.fill = swept(cfg, q.fill, merges, closes);
            }
            if cfg.node.weighted() {
                d.merged = q.fill.filled;
                if merges && pixel == 0 {
                    d.fill.edges = edges(cfg, q.fill.number);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
