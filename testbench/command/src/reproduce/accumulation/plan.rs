//! Which frames become one image, and how.

use crate::reproduce::frames::Frames;
use crate::reproduce::kept::Machine;
use pellucid_testbench::scene::{Sequence, Varied, Vary};
use std::fmt;

/// What frames are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Table 1, and the error over the number of frames: samples of one view.
    Table,
    /// Figure 3: equal frames.
    Equal,
}

/// How frames become one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Sums in an accumulation buffer.
    Buffer,
    /// Blending with 1/N in a frame buffer of 8 bits.
    Blend,
    /// A tree of nodes with so many inputs, each in a sweep of its own, as the paper has it.
    Tree(u32),
    /// The same tree, its nodes in the sweep of the frame that completes them.
    Stream(u32),
}

/// Those of the paper's table, in the order of its columns.
pub const COLUMNS: [Method; 4] = [Method::Buffer, Method::Blend, Method::Tree(2), Method::Tree(4)];
/// The paper's trees.
pub const TREES: [Method; 2] = [Method::Tree(2), Method::Tree(4)];
/// Those of Figure 3, row by row.
pub const ROWS: [Method; 3] = [Method::Buffer, Method::Blend, Method::Tree(2)];
/// The numbers of frames in Figure 3's columns.
pub const EQUAL: [u32; 3] = [32, 64, 128];
/// The number of equal frames of which blending leaves nothing.
pub const BLACK: u32 = 256;

/// Bits of the sums of 1024 levels.
const SUM_BITS: u32 = 18;

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Method::Buffer => f.write_str("buffer"),
            Method::Blend => f.write_str("blend"),
            Method::Tree(inputs) => write!(f, "tree {inputs}"),
            Method::Stream(inputs) => write!(f, "tree {inputs} in one sweep"),
        }
    }
}

impl Method {
    /// The inputs of a node, if it is a tree.
    pub fn inputs(self) -> Option<u32> {
        match self {
            Method::Tree(inputs) | Method::Stream(inputs) => Some(inputs),
            Method::Buffer | Method::Blend => None,
        }
    }

    /// Passes for an image of so many frames: one for each, and one for each node.
    pub fn passes(self, frames: u32) -> u64 {
        let nodes = self.inputs().map_or(0, |inputs| (frames - 1) / (inputs - 1));
        u64::from(frames + nodes)
    }

    /// Planes beside the frame that is drawn: of a tree (b - 1) log_b N + 1, where the last input of a node needs none if it is taken
    /// as it comes.
    pub fn planes(self, frames: u32) -> u64 {
        match self {
            Method::Buffer | Method::Blend => 1,
            Method::Tree(inputs) => u64::from((inputs - 1) * frames.ilog(inputs) + 1),
            Method::Stream(inputs) => u64::from((inputs - 1) * frames.ilog(inputs)),
        }
    }

    /// Whether it makes an image of just so many frames, each with the same weight.
    fn takes(self, frames: u32) -> bool {
        self.inputs().is_none_or(|inputs| inputs.pow(frames.ilog(inputs)) == frames)
    }

    /// As a machine is asked for that makes an image of so many frames.
    pub fn machine(self, frames: u32) -> Machine {
        // Adders of a node that lose nothing of its inputs before they are stored.
        let node = |inputs: u32| {
            vec![("branching", inputs), ("node_bits", 8 + inputs.next_power_of_two().ilog2())]
        };
        let (preset, own) = match self {
            Method::Buffer => ("buffer", vec![("sum_bits", SUM_BITS)]),
            Method::Blend => ("blend", vec![]),
            Method::Tree(inputs) => ("paper", node(inputs)),
            Method::Stream(inputs) => ("stream", node(inputs)),
        };
        let settings = [("frames", frames)].into_iter().chain(own);
        Machine {
            name: self.to_string(),
            arch: "accumulate",
            preset: Some(preset),
            settings: settings.map(|(name, value)| (name, value.to_string())).collect(),
        }
    }
}

/// Frames, what they are for, and the ways in which they become an image.
pub struct Planned {
    /// What they are for.
    pub figure: Figure,
    /// The frames.
    pub frames: Frames,
    /// The ways.
    pub methods: Vec<Method>,
}

/// Everything, on the paper's screen or on smaller ones.
pub fn plan(full: bool) -> Vec<Planned> {
    let sequence = |vary, frames| Some(Sequence::Varied(Varied { vary, frames }));
    let (table, equal) = if full { (512, 256) } else { (32, 64) };
    let mut all = vec![];
    for frames in (1..=10).map(|bits| 1 << bits) {
        let sampled = sequence(Vary::Aa, frames);
        let methods = COLUMNS.into_iter().chain([Method::Stream(2), Method::Stream(4)]);
        all.push(Planned {
            figure: Figure::Table,
            frames: Frames { sequence: sampled, ..Frames::square("cube", table) },
            methods: methods.filter(|method| method.takes(frames)).collect(),
        });
    }
    for frames in EQUAL.into_iter().chain([BLACK]) {
        let same = sequence(Vary::None, frames);
        all.push(Planned {
            figure: Figure::Equal,
            frames: Frames { sequence: same, ..Frames::square("cube", equal) },
            methods: ROWS.to_vec(),
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 15 nodes of two inputs over 16 leaves, 5 of four; and what the paper's formula gives at 1024.
    #[test]
    fn passes_and_planes_are_those_of_trees() {
        let [two, four] = TREES;
        assert_eq!((two.passes(16), four.passes(16)), (31, 21));
        assert_eq!((two.passes(1024), four.passes(1024)), (2047, 1365));
        assert_eq!((two.planes(1024), four.planes(1024)), (11, 16));
        assert_eq!((Method::Stream(2).planes(1024), Method::Stream(4).planes(1024)), (10, 15));
        assert_eq!((Method::Blend.passes(7), Method::Blend.planes(7)), (7, 1));
    }

    #[test]
    fn trees_of_four_are_there_for_powers_of_four() {
        let with_four = |planned: &&Planned| planned.methods.contains(&Method::Tree(4));
        let plan = plan(false);
        let counts: Vec<u32> = plan.iter().filter(with_four).map(|p| p.frames.count()).collect();
        assert_eq!(counts, [4, 16, 64, 256, 1024]);
    }
}
