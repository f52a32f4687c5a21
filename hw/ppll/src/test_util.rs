//! What the tests of this architecture share.

use crate::config::{Config, PRESETS, Params};
use pellucid_machine::params::Parameters;
pub use pellucid_test_util::*;

/// A machine for few pixels, whose memories are smaller than random numbers.
pub fn small_ppll(preset: &str, overflow: &str) -> Config {
    let preset = PRESETS.iter().find(|p| p.name == preset).unwrap();
    let mut params = Params {
        pages: 5,
        most_pages: 13,
        fragments: 19,
        outside_latency: 3,
        sorter_depth: 4,
        reads_in_flight: 5,
        ..(preset.params)()
    };
    params.set("overflow", overflow).unwrap();
    Config::new(screen(16, 9), params).unwrap()
}
