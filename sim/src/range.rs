//! The ranges of what a block is configured with, checked where the block is built.

use std::ops::{Bound, RangeBounds};

/// Checks that a number of a block's configuration is in its range. Costs nothing in a cycle: `reset` is the place
/// for it.
///
/// # Panics
/// If it is not; the message says what was expected.
///
/// # Example
/// ```should_panic
/// // the depth of a sorter is 65: expected 1 to 64
/// pellucid_sim::check_range("the depth of a sorter", 65, 1..=64);
/// ```
#[track_caller]
pub fn check_range(what: &str, value: u32, range: impl RangeBounds<u32>) {
    let bound = |bound: Bound<&u32>| match bound {
        Bound::Included(value) => Some(*value),
        _ => None,
    };
    let expected = match (bound(range.start_bound()), bound(range.end_bound())) {
        (Some(least), Some(most)) => format!("{least} to {most}"),
        (Some(least), None) => format!("at least {least}"),
        (None, Some(most)) => format!("at most {most}"),
        (None, None) => return,
    };
    assert!(range.contains(&value), "{what} is {value}: expected {expected}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_range_are_in_it() {
        for value in [1, 64] {
            check_range("it", value, 1..=64);
        }
        check_range("it", 2, 2..);
        check_range("it", u32::MAX, 2..);
        check_range("it", 9, ..=9);
    }

    #[test]
    #[should_panic(expected = "it is 0: expected 1 to 64")]
    fn below() {
        check_range("it", 0, 1..=64);
    }

    #[test]
    #[should_panic(expected = "it is 1: expected at least 2")]
    fn below_what_has_no_end() {
        check_range("it", 1, 2..);
    }

    #[test]
    #[should_panic(expected = "it is 10: expected at most 9")]
    fn above() {
        check_range("it", 10, ..=9);
    }
}
