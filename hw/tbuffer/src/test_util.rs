//! What the tests of this architecture share.

use crate::config::{Config, PRESETS, Params};
pub use pellucid_test_util::*;

/// A T-buffer for few pixels, whose memories are smaller than random numbers: kept tail and bitmap, or
/// neither.
pub fn small_tbuffer(fast: bool) -> Config {
    let preset = &PRESETS[usize::from(!fast)];
    let params = Params {
        sections: 13,
        outside_sections: 6,
        section_capacity: 3,
        outside_latency: 3,
        sorter_depth: 4,
        reads_in_flight: 5,
        ..(preset.params)()
    };
    Config::new(screen(16, 9), params).unwrap()
}
