//! The parameters, and what the blocks derive from them.

use crate::branching::Branching;
use crate::node::Node;
use crate::weights::{Weights, edges};
use crate::{bound, golden, level, sums, tree};
use pellucid_blocks::arbiter::{self, Policy};
use pellucid_machine::accumulation::{Accumulation, Channel};
use pellucid_machine::outside::{self, Outside, Table};
use pellucid_machine::params::{ParamError, Preset};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{choice, parameters};
use pellucid_sim::bits_for;
use pellucid_tbuffer::config as tbuffer;

/// The most frames of an image.
pub const MOST_FRAMES: u32 = 1024;
/// Bits of a channel of a frame, and of an image.
const LEVEL_BITS: u32 = 8;

choice! {
    /// How frames become one image.
    pub enum Method {
        /// A tree of averages.
        Tree = "tree",
        /// Sums in an accumulation buffer, divided at the end.
        Buffer = "buffer",
        /// Blending with 1/N in a frame buffer of 8 bits.
        Blend = "blend",
    }
}

choice! {
    /// When nodes of the tree are computed.
    pub enum Schedule {
        /// With the sweep of the frame that completes them.
        Stream = "stream",
        /// Each in a sweep of its own.
        Nodes = "nodes",
    }
}

choice! {
    /// Where planes lie.
    pub enum Place {
        /// On the chip.
        OnChip = "on_chip",
        /// In outside memory.
        Outside = "outside",
    }
}

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Frames of an image (N); `--frames` of a run sets it.
        frames: u32 = 1, "frames", 1..=MOST_FRAMES;
        /// How frames become one image: a tree of averages, sums in an accumulation buffer, or blending with 1/N in a frame buffer of 8 bits.
        method: Method = Method::Tree, "", ();
        /// Inputs of the nodes, level by level from the frames on; the last number counts for all levels above (method=tree).
        branching: Branching = Branching::all(2), "", ();
        /// When nodes are computed: in the sweep of the frame that completes them, or each in a sweep of its own (method=tree).
        schedule: Schedule = Schedule::Stream, "", ();
        /// Bits of a channel of the accumulation buffer (method=buffer).
        sum_bits: u32 = 16, "bits", 8..=24;
        /// Bits of the adders of a node (method=tree).
        node_bits: u32 = 9, "bits", 8..=24;
        /// Bits of a channel in which means are stored (method=tree).
        plane_bits: u32 = 8, "bits", 8..=16;
        /// What each frame weighs: all the same, a window, or a number for each (method=tree).
        weights: Weights = Weights::None, "", ();
        /// Bits of the weights of a node's inputs (method=tree, with weights).
        weight_bits: u32 = 8, "bits", 1..=16;
        /// Where planes lie, and the top: on chip, or in outside memory behind what the T-buffer has there.
        planes: Place = Place::OnChip, "", ();
        /// Reads of planes under way at once (planes=outside).
        reads_in_flight: u32 = 64, "reads", 1..=4096;
        part tbuffer: tbuffer::Params;
    }
}

/// All presets; the first is the default.
pub const PRESETS: &[Preset<Params>] = &[
    Preset {
        name: "stream",
        about: "schedule=stream: a tree of nodes with two inputs, in one sweep of the screen for each frame.",
        params: Params::default,
    },
    Preset {
        name: "paper",
        about: "schedule=nodes: as the paper on accumulation trees has it, a sweep for each node; nodes of 9 bits, 8 of them stored.",
        params: || Params { schedule: Schedule::Nodes, ..Params::default() },
    },
    Preset {
        name: "buffer",
        about: "method=buffer: the classical accumulation buffer, with sums of 16 bits.",
        params: || Params { method: Method::Buffer, ..Params::default() },
    },
    Preset {
        name: "blend",
        about: "method=blend: blending with 1/N in a frame buffer of 8 bits.",
        params: || Params { method: Method::Blend, ..Params::default() },
    },
];

/// Everything that the blocks need to know, checked.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The parameters.
    pub params: Params,
    /// The T-buffer that draws each frame.
    pub tbuffer: pellucid_tbuffer::config::Config,
    /// The tree, with method=tree.
    pub tree: tree::Config,
    /// The sums, with another method.
    pub sums: sums::Config,
}

impl Config {
    /// Checks the parameters against each other.
    ///
    /// # Errors
    /// There is no tree of just as many leaves and no weights; weights are not one for each frame or do not sum to one, or the
    /// method knows none; the accumulation buffer has too few bits; the T-buffer cannot be built.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        let Params { frames, method, sum_bits, .. } = params;
        let wrong = |name: &str, found: String, expected: String| ParamError::Value {
            name: name.to_string(),
            found,
            expected,
        };
        let store = tbuffer::Config::new(screen, params.tbuffer);
        let store = store.map_err(|error| error.of_part::<tbuffer::Params>("tbuffer"))?;
        if method != Method::Tree && params.weights != Weights::None {
            let error = "parameter `weights` needs `method=tree`: expected `none` with any other";
            return Err(ParamError::Together(error.to_string()));
        }
        let fits = ((1 << sum_bits) - 1) / 255;
        if method == Method::Buffer && fits < frames {
            let error = format!(
                "parameter `sum_bits` is {sum_bits}, which is enough for {fits} frames: expected {} for the {frames} of `frames`",
                bits_for(u64::from(frames * 255))
            );
            return Err(ParamError::Together(error));
        }
        let weights = params.weights.of(frames);
        let weights = weights.map_err(|[found, expected]| wrong("weights", found, expected))?;
        let levels = params.branching.levels(frames);
        let leaves: u32 = levels.iter().product();
        let plain = params.weights == Weights::None;
        if method == Method::Tree && plain && leaves != frames {
            let fewer = leaves / levels[levels.len() - 1];
            let found = frames.to_string();
            let expected = format!(
                "as many as a tree of this `branching` has leaves, {fewer} or {leaves}, or `weights` for the frames"
            );
            return Err(wrong("frames", found, expected));
        }
        Ok(Config {
            screen,
            params,
            tbuffer: store,
            tree: tree(screen, &params, &levels, &weights),
            sums: sums::Config {
                screen,
                frames,
                bits: if method == Method::Blend { LEVEL_BITS } else { sum_bits },
                blends: method == Method::Blend,
            },
        })
    }

    /// Frames of an image.
    pub fn frames(&self) -> u32 {
        self.params.frames
    }
    /// How they become one.
    pub fn method(&self) -> Method {
        self.params.method
    }
    /// Bits of a frame's number within its image.
    pub fn frame_bits(&self) -> u32 {
        if self.frames() == 1 { 0 } else { bits_for(u64::from(self.frames() - 1)) }
    }
    /// Bits of a channel below those of a level, as frames come.
    pub fn fraction_bits(&self) -> u32 {
        if self.method() == Method::Tree { self.tree.plane_bits - LEVEL_BITS } else { 0 }
    }
    /// Levels of the tree, none with another method.
    pub fn levels(&self) -> u32 {
        if self.method() == Method::Tree { self.tree.count } else { 0 }
    }
    /// There is a plane for what is merged next.
    pub fn has_top(&self) -> bool {
        self.method() == Method::Tree && self.tree.has_top()
    }
    /// Bits of a channel in planes.
    pub fn channel_bits(&self) -> u32 {
        if self.method() == Method::Tree { self.tree.plane_bits } else { self.sums.bits }
    }
    /// Planes lie outside; never where there are none.
    pub fn outside(&self) -> bool {
        self.params.planes == Place::Outside && self.planes() > 0
    }
    /// The planes' part of the outside memory, a pixel a word.
    pub fn plane_port(&self) -> outside::Config {
        let words = self.planes() * self.screen.pixels();
        outside::Config { words, bits: self.port().bits }
    }
    /// The port to outside memory: to what the T-buffer has there, and to the planes behind it.
    pub fn port(&self) -> outside::Config {
        let tbuffer = self.tbuffer.port.memory();
        if self.shares() {
            self.arbiter().memory()
        } else if self.outside() {
            let words = self.planes() * self.screen.pixels();
            outside::Config { words, bits: 3 * self.channel_bits() }
        } else {
            tbuffer
        }
    }
    /// T-buffer and planes take turns at it.
    pub fn shares(&self) -> bool {
        self.outside() && self.tbuffer.port.memory().exists()
    }
    /// The arbiter between them, in this order.
    pub fn arbiter(&self) -> arbiter::Config {
        if !self.shares() {
            return arbiter::Config::NONE;
        }
        let tbuffer = self.tbuffer.port.memory();
        arbiter::Config {
            words: [tbuffer.words, self.planes() * self.screen.pixels(), 0, 0],
            bits: tbuffer.bits.max(3 * self.channel_bits()),
            policy: Policy::RoundRobin,
            reads_in_flight: self.params.tbuffer.reads_in_flight + self.params.reads_in_flight,
        }
    }
    /// The memory behind the port.
    pub fn outside_memory(&self) -> Option<Outside> {
        let tbuffer = self.tbuffer.outside_memory().map(|of| of.within("tbuffer"));
        let mut tables = tbuffer.map_or(vec![], |of| of.tables);
        if self.outside() {
            let (words, bits) = (self.screen.pixels(), 3 * self.channel_bits());
            let table = |path| Table { path, words, bits };
            tables.extend(self.plane_names().into_iter().map(table));
        }
        let latency = self.params.tbuffer.outside_latency;
        self.port().exists().then_some(Outside { tables, latency })
    }
    /// The planes outside, in the order in which they lie there, called as those on chip are.
    fn plane_names(&self) -> Vec<String> {
        if self.method() != Method::Tree {
            return vec!["accumulator.sums.plane.outside".to_string()];
        }
        let top = self.has_top().then(|| "accumulator.tree.top.outside".to_string());
        let of_level = |level: u32| {
            let planes = 0..self.tree.level(level).planes();
            planes.map(move |k| format!("accumulator.tree.levels[{level}].planes[{k}].outside"))
        };
        top.into_iter().chain((0..self.levels()).flat_map(of_level)).collect()
    }
    /// Planes, on the chip or outside.
    pub fn planes(&self) -> u32 {
        if self.method() == Method::Tree {
            let levels = (0..self.levels()).map(|k| self.tree.level(k).planes());
            levels.sum::<u32>() + u32::from(self.tree.has_top())
        } else {
            1
        }
    }

    /// What an image is held to; nothing if it is one frame.
    pub fn accumulation(&self) -> Option<Accumulation> {
        let Params { frames, method, weights, .. } = self.params;
        if frames == 1 {
            return None;
        }
        let weights = weights.of(frames).ok()?;
        let (name, channel, error_bound): (_, Channel, _) = match method {
            Method::Buffer => ("accumulation buffer", Box::new(golden::buffer), 0),
            Method::Blend => {
                let lost = bound::rounded(f64::from(frames - 1), 0.0);
                ("blending with 1/N", Box::new(golden::blend), lost)
            }
            Method::Tree => {
                let tree = self.golden();
                let (name, off) = match &tree.edges {
                    None => ("accumulation tree", 0.0),
                    Some(_) => {
                        let off = bound::off(&weights, &self.found_weights());
                        ("weighted accumulation tree", off)
                    }
                };
                (name, Box::new(move |of: &[u8]| tree.image(of)), bound::rounded(self.loss(), off))
            }
        };
        Some(Accumulation { name, weights, channel, error_bound })
    }

    fn levels_built(&self) -> &[level::Config] {
        &self.tree.levels[..self.tree.count as usize]
    }

    /// What the tree loses at most, in levels.
    pub fn loss(&self) -> f64 {
        self.levels_built().iter().map(|level| level.node.loss()).sum()
    }

    /// What each frame weighs by the weights of the edges above it, of a whole of 1.
    fn found_weights(&self) -> Vec<f64> {
        let weight = |frame: u32| {
            let mut below = frame;
            let up = self.levels_built().iter().map(|level| {
                let input = below % level.node.inputs;
                below /= level.node.inputs;
                f64::from(level.edge(below, input)) / f64::from(1 << level.node.weight_bits)
            });
            up.product()
        };
        (0..self.frames()).map(weight).collect()
    }

    fn golden(&self) -> golden::Tree {
        let Params { weights, node_bits, weight_bits, .. } = self.params;
        let levels = self.levels_built().iter();
        let edges = levels.clone().map(|level| level.edges.to_vec()).collect();
        golden::Tree {
            inputs: levels.map(|level| level.node.inputs).collect(),
            node_bits,
            plane_bits: self.tree.plane_bits,
            edges: (weights != Weights::None).then_some((weight_bits, edges)),
        }
    }
}

/// A tree whose levels have so many inputs.
fn tree(screen: Screen, params: &Params, inputs: &[u32], weights: &[u64]) -> tree::Config {
    let plain = params.weights == Weights::None;
    // One frame is its image.
    let plane_bits = if inputs.is_empty() { LEVEL_BITS } else { params.plane_bits };
    let mut levels = [level::Config {
        node: Node {
            inputs: 2,
            input_bits: plane_bits,
            node_bits: params.node_bits,
            output_bits: plane_bits,
            weight_bits: if plain { 0 } else { params.weight_bits },
        },
        root: false,
        pixels: screen.pixels(),
        pixel_bits: screen.pixel_bits(),
        nodes: 1,
        edges: &[],
    }; tree::MOST_LEVELS];
    let mut below = 1u64;
    for (number, inputs_of) in inputs.iter().enumerate() {
        let level = &mut levels[number];
        level.node.inputs = *inputs_of;
        level.root = number + 1 == inputs.len();
        if level.root {
            level.node.output_bits = LEVEL_BITS;
        }
        if !plain {
            // A machine's configuration is copied: the weights stay for as long as the program runs.
            level.edges = edges(weights, *inputs_of, below, params.weight_bits).leak();
        }
        below *= u64::from(*inputs_of);
        level.nodes = u64::from(params.frames).div_ceil(below) as u32;
    }
    let (sweeps, count) = (params.schedule == Schedule::Nodes, inputs.len() as u32);
    tree::Config { screen, sweeps, plane_bits, count, levels }
}

#[cfg(test)]
mod tests;
