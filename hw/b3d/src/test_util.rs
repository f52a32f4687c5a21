//! What the tests of this architecture share.

use crate::config::{Config, Params};
pub use pellucid_test_util::*;

/// A machine for few pixels, whose memories are smaller than random numbers: with so many slots for each pixel to begin with,
/// and so many at most.
pub fn small_b3d(layers: u32, most_layers: u32) -> Config {
    let params = Params {
        layers,
        most_layers,
        fragments: 50,
        outside_latency: 3,
        sorter_depth: 2,
        reads_in_flight: 5,
        ..Params::default()
    };
    Config::new(screen(7, 5), params).unwrap()
}
