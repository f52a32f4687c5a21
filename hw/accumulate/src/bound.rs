//! How far an image can be from the exact mean: what nodes lose in rounding down, and what weights of few bits are off.

use crate::node::Node;

impl Node {
    /// What a node loses at most, in levels.
    pub fn loss(&self) -> f64 {
        // The lowest `lost` of `bits` bits, the upper 8 of which are a level.
        let of = |lost: u32, bits: u32| f64::from((1u32 << lost) - 1) / 2f64.powi(bits as i32 - 8);
        let within = if self.weighted() {
            // A product loses its bits before it is one of `mean_bits`, with a fraction of one of those.
            let each = 1.0 - 2f64.powi(-(self.cut() as i32));
            f64::from(self.inputs) * each / 2f64.powi(self.mean_bits() as i32 - 8)
        } else {
            (0..self.steps()).map(|step| of(self.lost(step), self.operand_bits(step))).sum()
        };
        within + of(self.dropped(), self.mean_bits())
    }
}

/// How far an image can be from the exact mean rounded to nearest, in levels, where all is rounded down to be at most `lost` levels
/// below a mean that is at most `off` levels from the exact one.
pub fn rounded(lost: f64, off: f64) -> u32 {
    // What is less than a level by a rounding error of this sum is not less.
    (lost + off + 0.5 + 1e-9).floor().min(255.0) as u32
}

/// How far the mean is from the exact one, in levels, at most: of white where its weights are too small, and black elsewhere.
pub fn off(exact: &[u64], by_tree: &[f64]) -> f64 {
    let whole = exact.iter().sum::<u64>() as f64;
    let pairs = exact.iter().zip(by_tree);
    255.0 * pairs.map(|(exact, found)| (*exact as f64 / whole - found).max(0.0)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the paper and its kin have: stored in 8 bits.
    fn loss(inputs: u32, node_bits: u32, plane_bits: u32) -> f64 {
        let (input_bits, output_bits) = (plane_bits, plane_bits);
        Node { inputs, input_bits, node_bits, output_bits, weight_bits: 0 }.loss()
    }

    #[test]
    fn of_plain_nodes() {
        assert_eq!(loss(2, 9, 8), 0.5);
        assert_eq!(loss(2, 8, 8), 1.0);
        assert_eq!(loss(4, 10, 8), 0.75);
        assert_eq!(loss(4, 24, 8), 0.75);
        assert_eq!(loss(4, 9, 8), 1.0);
        assert_eq!(loss(2, 17, 16), 1.0 / 512.0);
    }

    #[test]
    fn of_weighted_nodes() {
        let node = |inputs, node_bits, weight_bits| {
            Node { inputs, input_bits: 8, node_bits, output_bits: 8, weight_bits }.loss()
        };
        // All bits of the products: what is dropped of 16 is less than a level.
        assert_eq!(node(2, 24, 8), 255.0 / 256.0);
        // Two products lose less than a half each, and the ninth bit is a half.
        assert_eq!(node(2, 9, 8), 2.0 * (127.0 / 128.0) / 2.0 + 0.5);
    }

    #[test]
    fn of_images() {
        // 0.5 levels below 7.5, which is rounded to 8.
        assert_eq!(rounded(0.5, 0.0), 1);
        assert_eq!(rounded(4.0, 0.0), 4);
        assert_eq!(rounded(0.4, 0.0), 0);
        assert_eq!(rounded(1000.0, 0.0), 255);
        assert_eq!(off(&[1, 1], &[0.5, 0.5]), 0.0);
        assert_eq!(off(&[3, 1], &[0.5, 0.5]), 255.0 / 4.0);
    }
}
