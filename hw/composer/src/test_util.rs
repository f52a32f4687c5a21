//! What the tests of this architecture share.

use crate::config::Distribution;
use crate::scan_line::{self, bucket_sort};
use crate::{Config, distributor, merger, object_engine, raster, scan_lines, store};
use pellucid_blocks::walker;
use pellucid_rbuffer::config::{self as rbuffer, Overflow, Params};
pub use pellucid_test_util::*;

/// An object-order engine for few pixels.
pub fn object_engine(queue: u32) -> object_engine::Config {
    let walker = walker::Config { screen: screen(7, 5), set_up_cycles: 2, fragment_cycles: 1 };
    object_engine::Config { walker, queue }
}

/// Object-order engines for few pixels, with their merging units.
pub fn merger(engines: u32, beta: u32) -> merger::Config<object_engine::Config> {
    let raster = raster::Config { screen: screen(7, 5), beta };
    merger::Config { shape: merger::Shape { engines, raster }, engine: object_engine(2) }
}

/// A scan-line engine for few pixels, one of several.
pub fn scan_line(engines: u32, index: u32) -> scan_line::Config {
    let bucket_sort = bucket_sort::Config { screen: screen(7, 5), engines, index, capacity: 12 };
    scan_line::Config { bucket_sort, line_primitives: 9, sorter_depth: 3 }
}

/// Scan-line engines for few pixels.
pub fn scan_lines(engines: u32) -> scan_lines::Config {
    let raster = raster::Config { screen: screen(7, 5), beta: 2 };
    scan_lines::Config { engines, engine: scan_line(engines, 0), raster }
}

/// An image composition machine for few pixels.
pub fn composer(engines: u32, scan_line_engines: u32) -> Config<scan_lines::Config> {
    let transparency = scan_lines(scan_line_engines);
    Config {
        distributor: distributor::Config {
            screen: screen(7, 5),
            engines,
            distribution: Distribution::RoundRobin,
        },
        merger: merger(engines, transparency.raster.beta),
        transparency,
    }
}

/// An R-buffer that stands behind a merger: with a queue outside, or with replay.
pub fn rbuffer_store(queue: u32, outside: Option<u32>) -> store::Config<rbuffer::Config> {
    let overflow = if outside.is_some() { Overflow::Outside } else { Overflow::Replay };
    let outside_queue = outside.unwrap_or_default();
    let params = Params { queue, overflow, outside_queue, outside_latency: 3, ..Params::default() };
    let store = rbuffer::Config::new(screen(7, 3), params).unwrap();
    let walker = walker::Config { screen: store.screen, set_up_cycles: 1, fragment_cycles: 1 };
    store::Config { primitives: 12, walker, store, part: "rbuffer" }
}
