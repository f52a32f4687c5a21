//! How many inputs the nodes of each level of the tree have.

use crate::tree::MOST_LEVELS;
use pellucid_machine::params::{ParamType, Value};

/// Inputs level by level, from that of the frames on; the last number counts for all levels above, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branching {
    inputs: [u32; MOST_LEVELS],
    count: usize,
}

impl Branching {
    /// The same for all levels.
    pub const fn all(inputs: u32) -> Branching {
        Branching { inputs: [inputs; MOST_LEVELS], count: 1 }
    }

    /// The inputs of each level of a tree that has so many leaves or, if there is none of just as many, the fewest more.
    pub fn levels(&self, leaves: u32) -> Vec<u32> {
        let (mut levels, mut reached) = (vec![], 1);
        while reached < leaves {
            let inputs = self.inputs[levels.len().min(self.count - 1)];
            reached *= inputs;
            levels.push(inputs);
        }
        levels
    }
}

impl ParamType for Branching {
    type Limits = ();

    fn parse(text: &str, (): &()) -> Option<Branching> {
        let level = |text: &str| match text.trim() {
            "2" => Some(2),
            "4" => Some(4),
            _ => None,
        };
        let levels: Vec<u32> = text.split(',').map(level).collect::<Option<_>>()?;
        let mut branching = Branching { count: levels.len(), ..Branching::all(0) };
        branching.inputs.get_mut(..levels.len())?.copy_from_slice(&levels);
        Some(branching)
    }

    fn expected((): &()) -> String {
        format!("2, 4, or up to {MOST_LEVELS} of these level by level, as in `2,4`")
    }

    fn value(self) -> Value {
        let levels: Vec<String> = self.inputs[..self.count].iter().map(u32::to_string).collect();
        Value::Text(levels.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_number_counts_for_all_levels_above() {
        let levels = |text, leaves| Branching::parse(text, &()).unwrap().levels(leaves);
        assert_eq!(levels("2", 1), []);
        assert_eq!(levels("2", 8), [2, 2, 2]);
        assert_eq!(levels("2", 1024), [2; 10]);
        assert_eq!(levels("4", 5), [4, 4]);
        assert_eq!(levels("2,4", 2), [2]);
        assert_eq!(levels("2, 4", 32), [2, 4, 4]);
        assert_eq!(levels("4,2", 16), [4, 2, 2]);
    }

    #[test]
    fn what_is_none() {
        for text in ["", "3", "2,", "2,8", "22", "2,2,2,2,2,2,2,2,2,2,2"] {
            assert_eq!(Branching::parse(text, &()), None, "{text}");
        }
        for text in ["2", "4", "2,4", "2,2,2,2,2,2,2,2,2,2"] {
            assert_eq!(Branching::parse(text, &()).unwrap().value().to_string(), text);
        }
    }
}
