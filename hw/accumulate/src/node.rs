//! The arithmetic of an accumulation node: the mean of two or four colours, plain or weighted, always rounded down.
//!
//! A plain node adds in pairs, with adders of `node_bits`: where the sum of two operands would have more, both lose their lowest
//! bits first. A weighted one multiplies each input by the weight of its edge; products lose what lies below `node_bits`, and their
//! sum has no more, since the weights of a node sum to one. What is given on has `output_bits`.

use crate::colour::Colour;
use pellucid_sim::rtl;

/// The most inputs of a node.
pub const MOST_INPUTS: usize = 4;

/// How a node is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Its inputs, 2 or 4.
    pub inputs: u32,
    /// Bits of a channel of each, 8 to 16.
    pub input_bits: u32,
    /// Bits of its adders, 8 to 24.
    pub node_bits: u32,
    /// Bits of a channel of what it gives, 8 to 16.
    pub output_bits: u32,
    /// Bits of the weights of its edges, 1 to 16; 0 if it has none.
    pub weight_bits: u32,
}

impl Node {
    /// Its weights are not all the same.
    pub fn weighted(&self) -> bool {
        self.weight_bits > 0
    }
    /// Pairs of a plain node are added so many times.
    pub fn steps(&self) -> u32 {
        self.inputs.ilog2()
    }
    /// Bits of a plain node's operands, before they are added for time `step`, from 0 on.
    pub(crate) fn operand_bits(&self, step: u32) -> u32 {
        (0..step).fold(self.input_bits, |bits, _| (bits + 1).min(self.node_bits))
    }
    /// How many of these they lose.
    pub fn lost(&self, step: u32) -> u32 {
        (self.operand_bits(step) + 1).saturating_sub(self.node_bits)
    }
    /// How many bits a weighted node's products lose.
    pub fn cut(&self) -> u32 {
        (self.input_bits + self.weight_bits).saturating_sub(self.node_bits)
    }
    /// The largest mean as a weighted node computes it.
    fn most(&self) -> u64 {
        (1 << self.mean_bits()) - 1
    }
    /// Bits of the mean as it is computed.
    pub fn mean_bits(&self) -> u32 {
        if self.weighted() {
            self.input_bits + self.weight_bits - self.cut()
        } else {
            self.operand_bits(self.steps())
        }
    }
    /// How many of them are lost at the end.
    pub fn dropped(&self) -> u32 {
        self.mean_bits().saturating_sub(self.output_bits)
    }
    /// How many zeros are put behind them.
    pub fn added(&self) -> u32 {
        self.output_bits.saturating_sub(self.mean_bits())
    }
}

/// The mean of a channel of plain inputs.
#[inline(always)]
#[rtl]
fn plain(cfg: &Node, of: [u32; MOST_INPUTS]) -> u32 {
    let lost = cfg.lost(0);
    let first = (of[0] >> lost) + (of[1] >> lost);
    if cfg.inputs == 2 {
        first
    } else {
        let second = (of[2] >> lost) + (of[3] >> lost);
        let lost = cfg.lost(1);
        (first >> lost) + (second >> lost)
    }
}

/// The weighted mean of a channel. The weights are in units of 2^-`weight_bits`.
#[inline(always)]
#[rtl]
fn weighted(cfg: &Node, of: [u32; MOST_INPUTS], weights: [u32; MOST_INPUTS]) -> u32 {
    let mut sum = 0;
    for k in 0..cfg.inputs as usize {
        sum += (u64::from(of[k]) * u64::from(weights[k])) >> cfg.cut();
    }
    // Since the weights sum to one, there is no more of it.
    if cfg.dropped() > 0 {
        ((sum >> cfg.dropped()) & (cfg.most() >> cfg.dropped())) as u32
    } else {
        (sum & cfg.most()) as u32
    }
}

/// What a node gives of a channel.
#[inline(always)]
#[rtl]
fn channel(cfg: &Node, of: [u32; MOST_INPUTS], weights: [u32; MOST_INPUTS]) -> u32 {
    let mean = if cfg.weighted() {
        weighted(cfg, of, weights)
    } else if cfg.dropped() > 0 {
        plain(cfg, of) >> cfg.dropped()
    } else {
        plain(cfg, of)
    };
    if cfg.added() > 0 { mean << cfg.added() } else { mean }
}

/// What a node gives.
#[inline(always)]
#[rtl]
pub fn mean(cfg: &Node, of: [Colour; MOST_INPUTS], weights: [u32; MOST_INPUTS]) -> Colour {
    Colour {
        r: channel(cfg, [of[0].r, of[1].r, of[2].r, of[3].r], weights),
        g: channel(cfg, [of[0].g, of[1].g, of[2].g, of[3].g], weights),
        b: channel(cfg, [of[0].b, of[1].b, of[2].b, of[3].b], weights),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(inputs: u32, node_bits: u32, weight_bits: u32) -> Node {
        Node { inputs, input_bits: 8, node_bits, output_bits: 8, weight_bits }
    }

    fn gives(cfg: Node, of: [u32; 4], weights: [u32; 4]) -> u32 {
        mean(&cfg, of.map(|r| Colour { r, ..Colour::default() }), weights).r
    }

    #[test]
    fn by_hand() {
        // (7 + 8) / 2 = 7.5.
        assert_eq!(gives(node(2, 9, 0), [7, 8, 99, 99], [0; 4]), 7);
        // Without the ninth bit: 3 + 4.
        assert_eq!(gives(node(2, 8, 0), [7, 9, 99, 99], [0; 4]), 7);
        // 15 / 4 = 3.75; with adders of 9 bits (1 + 2) / 2 and (5 + 7) / 2 are 1.5 and 6, and 1 + 6 halved 3.5.
        assert_eq!(gives(node(4, 10, 0), [1, 2, 5, 7], [0; 4]), 3);
        assert_eq!(gives(node(4, 9, 0), [1, 2, 5, 7], [0; 4]), 3);
        // 16 / 4 = 4, of which adders of 9 bits lose a half twice.
        assert_eq!(gives(node(4, 10, 0), [0, 1, 7, 8], [0; 4]), 4);
        assert_eq!(gives(node(4, 9, 0), [0, 1, 7, 8], [0; 4]), 3);
        // 3/4 of 9 and 1/4 of 2 are 6.75 and 0.5: with a ninth bit 6.5 and 0.5.
        assert_eq!(gives(node(2, 9, 2), [9, 2, 0, 0], [3, 1, 0, 0]), 7);
        assert_eq!(gives(node(2, 8, 2), [9, 2, 0, 0], [3, 1, 0, 0]), 6);
    }

    #[test]
    fn a_fraction_is_kept_where_there_is_room() {
        let cfg = Node { inputs: 2, input_bits: 8, node_bits: 9, output_bits: 10, weight_bits: 0 };
        assert_eq!(gives(cfg, [7, 8, 0, 0], [0; 4]), 7 * 4 + 2);
        let cfg = Node { input_bits: 10, output_bits: 8, node_bits: 11, ..cfg };
        assert_eq!(gives(cfg, [7 * 4 + 2, 8 * 4 + 3, 0, 0], [0; 4]), 8);
    }
}
