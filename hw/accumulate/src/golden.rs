//! What an image of several frames must be, channel by channel, in plain software: written apart from the machine, so that a mistake
//! of one is not one of both.

/// The accumulation buffer: the sum of all frames, divided once and rounded to nearest, a half up.
pub fn buffer(frames: &[u8]) -> u8 {
    let n = frames.len() as f64;
    let sum: f64 = frames.iter().map(|c| f64::from(*c)).sum();
    (sum / n + 0.5).floor() as u8
}

/// Frames blended into a frame buffer of 8 bits, each with 1/N and rounded down.
pub fn blend(frames: &[u8]) -> u8 {
    let n = frames.len();
    frames.iter().fold(0, |sum, c| sum + (usize::from(*c) / n) as u8)
}

/// A tree of nodes.
#[derive(Clone, Debug)]
pub struct Tree {
    /// Inputs of the nodes of each level, from that of the frames on.
    pub inputs: Vec<u32>,
    /// Bits of the nodes' adders.
    pub node_bits: u32,
    /// Bits in which means are stored.
    pub plane_bits: u32,
    /// Of each level the weights of all edges, in units of 2^-`weight_bits`; none if nodes are plain.
    pub edges: Option<(u32, Vec<Vec<u32>>)>,
}

impl Tree {
    /// The image of the frames. A value is a whole number of levels times 2^(bits - 8).
    pub fn image(&self, frames: &[u8]) -> u8 {
        let scale = 1u64 << (self.plane_bits - 8);
        let mut values: Vec<u64> = frames.iter().map(|c| u64::from(*c) * scale).collect();
        for (level, inputs) in self.inputs.iter().enumerate() {
            let last = level + 1 == self.inputs.len();
            let to_bits = if last { 8 } else { self.plane_bits };
            let nodes = values.chunks(*inputs as usize).enumerate();
            values = nodes.map(|(node, of)| self.node(level, node, of, to_bits)).collect();
        }
        let bits = if self.inputs.is_empty() { self.plane_bits } else { 8 };
        (values[0] >> (bits - 8)) as u8
    }

    fn node(&self, level: usize, node: usize, of: &[u64], to_bits: u32) -> u64 {
        let (mean, bits) = match &self.edges {
            None => pairs(of, self.plane_bits, self.node_bits),
            Some((weight_bits, edges)) => {
                let edges = edges[level].chunks(self.inputs[level] as usize).nth(node);
                let all = self.plane_bits + weight_bits;
                let bits = all.min(self.node_bits);
                let product =
                    |(value, edge): (&u64, &u32)| (value * u64::from(*edge)) >> (all - bits);
                (of.iter().zip(edges.unwrap_or_default()).map(product).sum(), bits)
            }
        };
        // Bits that are lost are those of a fraction; those that are new are zeros.
        if bits > to_bits { mean / (1 << (bits - to_bits)) } else { mean * (1 << (to_bits - bits)) }
    }
}

/// The mean of values of so many bits, a power of two of them, by adders of `most` bits: its value, and its bits.
fn pairs(of: &[u64], bits: u32, most: u32) -> (u64, u32) {
    if let [one] = of {
        return (*one, bits);
    }
    let (left, right) = of.split_at(of.len() / 2);
    let ((left, bits), (right, _)) = (pairs(left, bits, most), pairs(right, bits, most));
    if bits < most {
        return (left + right, bits + 1);
    }
    let lost = bits + 1 - most;
    ((left >> lost) + (right >> lost), most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tree as the paper has it: nodes of 9 bits, 8 of them stored.
    fn tree(inputs: u32, levels: usize, node_bits: u32) -> Tree {
        Tree { inputs: vec![inputs; levels], node_bits, plane_bits: 8, edges: None }
    }

    #[test]
    fn white_blended() {
        for (frames, left) in [(1, 255), (2, 254), (32, 224), (64, 192), (128, 128), (256, 0)] {
            assert_eq!(blend(&vec![255; frames]), left, "{frames} frames");
        }
    }

    #[test]
    fn a_buffer_is_exact_to_half_a_level() {
        assert_eq!(buffer(&[7, 8]), 8);
        assert_eq!(buffer(&[255; 1024]), 255);
        assert_eq!(buffer(&[0, 0, 1]), 0);
    }

    #[test]
    fn a_tree_loses_half_a_level_each_time() {
        assert_eq!(tree(2, 1, 9).image(&[7, 8]), 7);
        assert_eq!(tree(2, 2, 9).image(&[7, 8, 8, 8]), 7);
        assert_eq!(tree(2, 0, 9).image(&[77]), 77);
        // (1 + 2 + 5 + 8) / 4 = 4; in pairs 1.5 and 6.5.
        assert_eq!(tree(2, 2, 9).image(&[1, 2, 5, 8]), 3);
        assert_eq!(tree(4, 1, 10).image(&[1, 2, 5, 8]), 4);
        assert_eq!(tree(4, 1, 9).image(&[0, 1, 7, 8]), 3);
    }

    #[test]
    fn weights() {
        let edges = Some((2, vec![vec![3, 1, 4, 0], vec![2, 2]]));
        let tree = Tree { inputs: vec![2, 2], node_bits: 10, plane_bits: 8, edges };
        // 3/4 of 8 and 1/4 of 4 are 7; the third frame alone is 9.
        assert_eq!(tree.image(&[8, 4, 9]), 8);
    }
}
