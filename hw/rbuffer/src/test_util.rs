//! What the tests of this architecture share.

use crate::config::{Config, Overflow, Params};
use crate::queue;
use pellucid_blocks::cached_table::Place;
pub use pellucid_test_util::*;

/// An R-buffer for few pixels: with a queue outside, or with replay.
pub fn small_rbuffer(queue: u32, outside: Option<u32>) -> Config {
    let overflow = if outside.is_some() { Overflow::Outside } else { Overflow::Replay };
    let outside_queue = outside.unwrap_or_default();
    let params = Params { queue, overflow, outside_queue, outside_latency: 3, ..Params::default() };
    Config::new(screen(7, 3), params).unwrap()
}

/// The same with its frame buffer outside.
pub fn framebuffer_outside(queue: u32, outside: Option<u32>) -> Config {
    let params = small_rbuffer(queue, outside).params;
    let params = Params {
        reads_in_flight: 3,
        framebuffer: Place::Cached,
        framebuffer_sets: 2,
        framebuffer_ways: 2,
        framebuffer_line: 4,
        ..params
    };
    Config::new(screen(7, 3), params).unwrap()
}

/// An R-buffer's queue for few pixels.
pub fn queue(on_chip: u32, outside: u32, latency: u32) -> queue::Config {
    queue::Config { on_chip, outside, latency, screen: screen(5, 3) }
}
