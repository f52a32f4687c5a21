//! The parameters, and what the blocks derive from them.

use pellucid_blocks::array::config::{self as array, MAX_LANES, Shape};
use pellucid_blocks::cached_table::{Cached, Place};
use pellucid_blocks::{front, shared_port, sorter};
use pellucid_machine::Outside;
use pellucid_machine::params::{ParamError, Preset};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{choice, parameters};

choice! {
    /// How counters are summed up.
    pub enum Scan {
        /// In one sweep, by a tree of adders with carry.
        Adders = "adders",
        /// In sweeps over memory, of which each doubles what is in a sum.
        Passes = "passes",
    }
}

choice! {
    /// How a fragment's slot is found.
    pub enum Index {
        /// Counters are cleared and counted up again (seed 002).
        Up = "up",
        /// Counters are counted down.
        Down = "down",
    }
}

choice! {
    /// What happens to fragments for which the buffer has no slots.
    pub enum Overflow {
        /// They are stored and resolved in bands of pixels, for each of which the frame is sent again.
        Bands = "bands",
        /// They are dropped.
        Drop = "drop",
    }
}

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Fragments that the buffer holds on chip.
        fragments: u32 = 786_432, "fragments", 1..=1 << 27;
        /// Further fragments that it holds in outside memory.
        outside_fragments: u32 = 3_145_728, "fragments", 0..=1 << 27;
        /// Bits of a pixel's counter; what a pixel has beyond what they can say is dropped.
        count_bits: u32 = 32, "bits", 1..=32;
        /// Counters of a word, summed up and looked at together: 1, 2, 4, 8 or 16. With counters=cached no more than fit into 64 bits.
        scan_width: u32 = 16, "counters", 1..=MAX_LANES as u32;
        /// How counters are summed up: in one sweep by a tree of adders, or in a sweep for each doubling of the words in a sum.
        scan: Scan = Scan::Adders, "", ();
        /// How a fragment's slot is found: counters are cleared and counted up again, or counted down.
        index: Index = Index::Down, "", ();
        /// What happens to fragments for which there are no slots: they are stored and resolved in further bands of pixels, or dropped.
        overflow: Overflow = Overflow::Bands, "", ();
        /// Fragments sorted in one pass (K); a pixel with more takes several passes.
        sorter_depth: u32 = 16, "fragments", 1..=sorter::MAX_DEPTH as u32;
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Fragment reads under way at once during resolve, and fragments that wait for their counters with counters=cached; with framebuffer=cached also pixels that are read ahead.
        reads_in_flight: u32 = 64, "reads", 2..=4096;
        /// Where counters and sums lie: on chip, or in outside memory with a cache on chip for each.
        counters: Place = Place::OnChip, "", ();
        /// Sets of that cache (counters=cached), a power of two.
        counters_sets: u32 = 256, "sets", 1..=1 << 16;
        /// Lines of a set, a power of two.
        counters_ways: u32 = 4, "lines", 1..=8;
        /// Words of a line, a power of two.
        counters_line: u32 = 8, "words", 1..=16;
        /// Where depth and colour of the pixels lie: on chip, or in outside memory with a cache on chip.
        framebuffer: Place = Place::OnChip, "", ();
        /// Sets of that cache (framebuffer=cached), a power of two.
        framebuffer_sets: u32 = 256, "sets", 1..=1 << 16;
        /// Lines of a set, a power of two.
        framebuffer_ways: u32 = 4, "lines", 1..=8;
        /// Pixels of a line, a power of two.
        framebuffer_line: u32 = 8, "pixels", 1..=16;
    }
}

/// All presets; the first is the default.
pub const PRESETS: &[Preset<Params>] = &[
    Preset {
        name: "fast",
        about: "scan_width=16, index=down: counts and stores a fragment a cycle, and resolves one while all are on chip.",
        params: Params::default,
    },
    Preset {
        name: "paper",
        about: "scan_width=1, index=up: as the paper on the Dynamic Fragment Buffer describes it.",
        params: || Params { scan_width: 1, index: Index::Up, ..Params::default() },
    },
    Preset {
        name: "dx",
        about: "scan=passes, overflow=drop: as its forerunner in a DirectX sample, with 8 fragments a pixel on average at 640x480.",
        params: || Params {
            fragments: 8 * 640 * 480,
            outside_fragments: 0,
            scan_width: 1,
            scan: Scan::Passes,
            index: Index::Up,
            overflow: Overflow::Drop,
            ..Params::default()
        },
    },
];

/// Everything that the blocks need to know, checked.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The parameters.
    pub params: Params,
    /// The arrays.
    pub arrays: array::Config,
    /// The sorter.
    pub sorter: sorter::Config,
    /// The frame buffer.
    pub front: front::Config,
    /// The port to what lies outside.
    pub port: shared_port::Config,
}

impl Config {
    /// What lies outside.
    pub fn outside_memory(&self) -> Option<Outside> {
        let arrays = self.arrays.outside_memory().map(|memory| memory.within("arrays"));
        self.front.outside_memory(arrays, self.params.outside_latency)
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// `scan_width` or a number of the caches is no power of two.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        if !params.scan_width.is_power_of_two() {
            return Err(ParamError::Value {
                name: "scan_width".to_string(),
                found: params.scan_width.to_string(),
                expected: "1, 2, 4, 8 or 16".to_string(),
            });
        }
        let cached = Cached::of(
            "counters",
            params.counters,
            [params.counters_sets, params.counters_ways, params.counters_line],
        )?;
        let shape = Shape {
            lanes: params.scan_width,
            count_bits: params.count_bits,
            down: params.index == Index::Down,
            sweeps: params.scan == Scan::Passes,
            bands: params.overflow == Overflow::Bands,
            on_chip: params.fragments,
            outside: params.outside_fragments,
            outside_latency: params.outside_latency,
            reads_in_flight: params.reads_in_flight,
            depth: params.sorter_depth,
            fixed: 0,
            cached,
            pixels_ahead: params.framebuffer == Place::Cached,
        };
        let arrays = array::Config::new(screen, shape);
        let sorter = sorter::Config {
            depth: params.sorter_depth,
            pixel_bits: screen.pixel_bits(),
            layer_bits: arrays.layer_bits(),
            newest_first: false,
        };
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let reads = params.reads_in_flight;
        let (front, port) = front::Config::sharing(screen, place, reads, 4, arrays.port())?;
        let front = front.without_depths();
        Ok(Config { screen, params, arrays, sorter, front, port })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::params::{MAX_FRAGMENTS, Parameters};

    #[test]
    fn presets_set_what_they_say() {
        let by_name = |name| (PRESETS.iter().find(|p| p.name == name).unwrap().params)();
        let of = |name| {
            let Params { scan_width, scan, index, overflow, .. } = by_name(name);
            (scan_width, scan, index, overflow)
        };
        assert_eq!(of("fast"), (16, Scan::Adders, Index::Down, Overflow::Bands));
        assert_eq!(of("paper"), (1, Scan::Adders, Index::Up, Overflow::Bands));
        assert_eq!(of("dx"), (1, Scan::Passes, Index::Up, Overflow::Drop));
        assert_eq!(by_name("dx").fragments, 8 * 307_200);
    }

    #[test]
    fn a_width_that_is_no_power_of_two_is_refused() {
        let screen = Screen { width: 4, height: 4, background: 0 };
        let params = Params { scan_width: 12, ..Params::default() };
        let error = Config::new(screen, params).unwrap_err();
        assert_eq!(error.to_string(), "parameter `scan_width` is 12: expected 1, 2, 4, 8 or 16");
    }

    #[test]
    fn a_simulation_can_hold_the_largest_buffer() {
        let mut params = Params::default();
        params.set("fragments", "134217728").unwrap();
        params.set("outside_fragments", "134217728").unwrap();
        let screen = Screen { width: 4, height: 4, background: 0 };
        let slots = Config::new(screen, params).unwrap().arrays.slots();
        assert_eq!(u64::from(slots), MAX_FRAGMENTS);
    }
}
