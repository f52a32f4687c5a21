//! What the tests of this architecture share.

use crate::config::{Config, Params, Weights};
pub use pellucid_test_util::*;

/// An M-buffer for few pixels: weights in memory, or in registers.
pub fn small_mbuffer(in_memory: bool) -> Config {
    let params = Params {
        overflow_sections: 5,
        outside_sections: 6,
        outside_latency: 3,
        weights: if in_memory { Weights::Memory } else { Weights::Registers },
        array: 3,
        reads_in_flight: 5,
        ..Params::default()
    };
    Config::new(screen(5, 3), params).unwrap()
}
