//! What the tests of several blocks share.

use crate::allocator::AllocatorKind;
use crate::chains::config::{Config, Passes, Shape};
use crate::weights::WEIGHT_BITS;
pub use pellucid_test_util::*;

/// Chains that keep tails, with a bitmap, as large as an architecture has them.
pub fn shape() -> Shape {
    Shape {
        owned: false,
        on_chip: 262_144,
        outside: 1_048_576,
        outside_latency: 64,
        capacity: 3,
        tail: true,
        bitmap: true,
        reads_in_flight: 64,
        passes: Passes::Each(16),
        weight_bits: 0,
        allocator: AllocatorKind::Fifo,
    }
}

/// Chains for few pixels, whose memories are smaller than random numbers: kept tail and bitmap, or neither.
pub fn small(fast: bool) -> Config {
    let shape = Shape {
        on_chip: 13,
        outside: 6,
        outside_latency: 3,
        tail: fast,
        bitmap: fast,
        reads_in_flight: 5,
        passes: Passes::Each(4),
        ..shape()
    };
    Config::new(screen(16, 9), shape)
}

/// The faster ones with so many sections on chip and outside.
pub fn small_of(on_chip: u32, outside: u32) -> Config {
    let small = small(true);
    Config::new(small.screen, Shape { on_chip, outside, ..small.shape })
}

/// The slower ones, with an NSA table that lends entries.
pub fn small_lending() -> Config {
    let mut cfg = small(false);
    cfg.shape.allocator = AllocatorKind::Threaded;
    cfg
}

/// Chains of which each pixel owns the first section: weights in memory, or none.
pub fn small_owned(in_memory: bool) -> Config {
    let shape = Shape {
        owned: true,
        on_chip: 5,
        outside: 6,
        outside_latency: 3,
        capacity: 2,
        reads_in_flight: 5,
        passes: if in_memory { Passes::One } else { Passes::Twice(3) },
        weight_bits: if in_memory { WEIGHT_BITS } else { 0 },
        ..shape()
    };
    Config::new(screen(5, 3), shape)
}
