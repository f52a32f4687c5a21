//! What each frame weighs in its image, and the weights of the tree's edges that come to it.

use pellucid_machine::params::{ParamType, Value};

/// Units of a weight of a list: 9 digits behind the point.
const WHOLE: u64 = 1_000_000_000;
/// How far a list may be from one: numbers of a few digits each.
const TOLERANCE: u64 = 1_000_000;
/// Bits of the weights of a Gaussian window.
const GAUSSIAN_BITS: u32 = 20;

/// What each frame weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// All the same, and the nodes of the tree are plain.
    None,
    /// All the same.
    Box,
    /// A window that rises and falls by equal steps.
    Triangle,
    /// A bell whose standard deviation is a quarter of the frames.
    Gaussian,
    /// A number for each, in units of 10^-9. Parameters are copied: the list stays for as long as the program runs.
    List(&'static [u32]),
}

const NAMES: &[(&str, Weights)] = &[
    ("none", Weights::None),
    ("box", Weights::Box),
    ("triangle", Weights::Triangle),
    ("gaussian", Weights::Gaussian),
];

/// A number from 0 to 1 in units of 10^-9.
fn part(text: &str) -> Option<u32> {
    let number: f64 = text.parse().ok()?;
    (0.0..=1.0).contains(&number).then(|| (number * WHOLE as f64).round() as u32)
}

impl ParamType for Weights {
    type Limits = ();

    fn parse(text: &str, (): &()) -> Option<Weights> {
        if let Some((_, named)) = NAMES.iter().find(|(name, _)| *name == text) {
            return Some(*named);
        }
        let numbers = text.split([',', ' ', '\t', '\n', '\r']).filter(|text| !text.is_empty());
        let list: Vec<u32> = numbers.map(part).collect::<Option<_>>()?;
        (!list.is_empty()).then(|| Weights::List(list.leak()))
    }

    fn expected((): &()) -> String {
        "`none`, `box`, `triangle`, `gaussian`, or a number from 0 to 1 for each frame, as in `0.1,0.4,0.4,0.1`"
            .to_string()
    }

    fn value(self) -> Value {
        if let Some((name, _)) = NAMES.iter().find(|(_, named)| *named == self) {
            return Value::Choice(name);
        }
        let Weights::List(list) = self else { unreachable!("all others have names") };
        let number = |part: &u32| (f64::from(*part) / WHOLE as f64).to_string();
        Value::Text(list.iter().map(number).collect::<Vec<_>>().join(","))
    }
}

impl Weights {
    /// What each of so many frames weighs, in a unit of its own.
    ///
    /// # Errors
    /// A list has not one number for each frame, or its numbers do not sum to one: what was found, and what was expected.
    pub fn of(self, frames: u32) -> Result<Vec<u64>, [String; 2]> {
        let each = 0..u64::from(frames);
        match self {
            Weights::None | Weights::Box => Ok(each.map(|_| 1).collect()),
            Weights::Triangle => Ok(each.clone().map(|k| (k + 1).min(each.end - k)).collect()),
            Weights::Gaussian => {
                let (middle, deviation) = (f64::from(frames - 1) / 2.0, f64::from(frames) / 4.0);
                let height = |k: u64| (-0.5 * ((k as f64 - middle) / deviation).powi(2)).exp();
                let weight = |k| (height(k) * f64::from(1u32 << GAUSSIAN_BITS)).round() as u64;
                Ok(each.map(weight).collect())
            }
            Weights::List(list) => {
                let sum: u64 = list.iter().map(|part| u64::from(*part)).sum();
                if list.len() as u64 != each.end {
                    let found = format!("a list of {} numbers", list.len());
                    return Err([found, format!("{frames}, one for each of `frames`")]);
                }
                if sum.abs_diff(WHOLE) > TOLERANCE {
                    let sum = sum as f64 / WHOLE as f64;
                    let found = format!("a list of numbers whose sum is {sum}");
                    return Err([found, "numbers that sum to one".to_string()]);
                }
                Ok(list.iter().map(|part| u64::from(*part)).collect())
            }
        }
    }
}

/// The weights of the edges of all nodes of one level, those of one node after those of the one before: whole numbers that sum
/// to 2^`weight_bits` at each node. `below` leaves are below each input; those beyond the last frame weigh nothing.
pub fn edges(weights: &[u64], inputs: u32, below: u64, weight_bits: u32) -> Vec<u32> {
    let node = u64::from(inputs) * below;
    let mut edges = vec![];
    for leaves in weights.chunks(node as usize) {
        let total: u64 = leaves.iter().sum();
        // Up to each input, so that what is lost in rounding one goes to the next.
        let up_to = |input: u32| {
            let end = leaves.len().min((u64::from(input) * below) as usize);
            let sum: u64 = leaves[..end].iter().sum();
            // A node that weighs nothing is its first input.
            let (sum, total) = if total == 0 { (u64::from(input > 0), 1) } else { (sum, total) };
            let scaled = (u128::from(sum) << (weight_bits + 1)) + u128::from(total);
            (scaled / (2 * u128::from(total))) as u32
        };
        edges.extend((0..inputs).map(|input| up_to(input + 1) - up_to(input)));
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn list(text: &str, frames: u32) -> Result<Vec<u64>, [String; 2]> {
        Weights::parse(text, &()).unwrap().of(frames)
    }

    #[test]
    fn windows() {
        assert_eq!(list("box", 3).unwrap(), [1, 1, 1]);
        assert_eq!(list("triangle", 5).unwrap(), [1, 2, 3, 2, 1]);
        assert_eq!(list("triangle", 4).unwrap(), [1, 2, 2, 1]);
        // exp(-1/2 * (3/2 / 1)^2), exp(-1/2 * (1/2 / 1)^2), in units of 2^-20.
        assert_eq!(list("gaussian", 4).unwrap(), [340_423, 925_365, 925_365, 340_423]);
        assert_eq!(list("gaussian", 1).unwrap(), [1 << 20]);
    }

    #[test]
    fn lists() {
        assert_eq!(list("0.25, 0.5\n0.25\n", 3).unwrap(), [WHOLE / 4, WHOLE / 2, WHOLE / 4]);
        assert_eq!(list("0.333,0.333,0.333", 3).unwrap(), [333_000_000; 3]);
        let wrong = |text, frames| list(text, frames).unwrap_err().join("; expected ");
        assert_eq!(
            wrong("0.5,0.5", 3),
            "a list of 2 numbers; expected 3, one for each of `frames`"
        );
        assert_eq!(
            wrong("0.5,0.25", 2),
            "a list of numbers whose sum is 0.75; expected numbers that sum to one"
        );
        for text in ["", ",", "x", "0.5,-0.5", "1.5", "nan", "hamming"] {
            assert_eq!(Weights::parse(text, &()), None, "{text}");
        }
        for text in ["none", "box", "triangle", "gaussian", "0.25,0.75"] {
            assert_eq!(Weights::parse(text, &()).unwrap().value().to_string(), text);
        }
    }

    #[test]
    fn edges_by_hand() {
        assert_eq!(edges(&[1, 1, 1, 1], 2, 1, 8), [128, 128, 128, 128]);
        assert_eq!(edges(&[1, 3, 5, 0, 0, 0], 2, 1, 2), [1, 3, 4, 0, 4, 0]);
        // A third and two thirds; the third frame has a node of its own.
        assert_eq!(edges(&[1, 2, 3], 2, 1, 4), [5, 11, 16, 0]);
        assert_eq!(edges(&[1, 2, 3], 2, 2, 4), [8, 8]);
    }

    proptest! {
        /// At each node they sum to one, and none is a unit or more from what it would be exactly.
        #[test]
        fn edges_sum_to_one(
            weights in prop::collection::vec(0u64..1000, 1..40),
            inputs in prop_oneof![Just(2u32), Just(4)],
            below in 1u64..9,
            weight_bits in 1u32..=16,
        ) {
            let edges = edges(&weights, inputs, below, weight_bits);
            let node = inputs as usize * below as usize;
            prop_assert_eq!(edges.len(), weights.chunks(node).count() * inputs as usize);
            for (leaves, edges) in weights.chunks(node).zip(edges.chunks(inputs as usize)) {
                prop_assert_eq!(edges.iter().sum::<u32>(), 1 << weight_bits);
                let total = leaves.iter().sum::<u64>() as f64;
                for (leaves, edge) in leaves.chunks(below as usize).zip(edges) {
                    let exact = leaves.iter().sum::<u64>() as f64 / total;
                    let found = f64::from(*edge) / f64::from(1 << weight_bits);
                    prop_assert!(total == 0.0 || (exact - found).abs() * f64::from(1 << weight_bits) < 1.0001);
                }
            }
        }
    }
}
