//! The parameters, and what the blocks derive from them.

use pellucid_blocks::array::fixed::{self, Shape};
use pellucid_blocks::cached_table::{Cached, Place};
use pellucid_blocks::rebuild::Overflow;
use pellucid_blocks::{front, shared_port, sorter};
use pellucid_machine::params::{ParamError, Preset, too_many_fragments};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Outside, parameters};

/// The most slots that a pixel can have.
const MOST_LAYERS: u32 = 1 << 16;

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Slots of each pixel, to begin with.
        layers: u32 = 8, "fragments", 1..=MOST_LAYERS;
        /// The most slots that each pixel can come to have, with `overflow=rebuild`.
        most_layers: u32 = 64, "fragments", 1..=MOST_LAYERS;
        /// What happens to fragments of a pixel whose slots are full: the frame is sent again with twice the slots for each pixel, or they are dropped.
        overflow: Overflow = Overflow::Rebuild, "", ();
        /// The most slots that are on chip; all others are in outside memory.
        fragments: u32 = 786_432, "fragments", 1..=1 << 27;
        /// Fragments sorted in one pass (K); a pixel with more takes several passes.
        sorter_depth: u32 = 16, "fragments", 1..=sorter::MAX_DEPTH as u32;
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Fragment reads under way at once during resolve, and fragments that wait for their counters with counters=cached; with framebuffer=cached also pixels that are read ahead.
        reads_in_flight: u32 = 64, "reads", 2..=4096;
        /// Where counters lie: on chip, or in outside memory with a cache on chip.
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
        about: "layers=8, overflow=rebuild: few slots for each pixel, and twice as many each time that a frame needs more.",
        params: Params::default,
    },
    Preset {
        name: "paper",
        about: "layers=64, overflow=drop: as the paper on the Dynamic Fragment Buffer measures it, enough slots from the start and none checked.",
        params: || Params { layers: 64, overflow: Overflow::Drop, ..Params::default() },
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
    pub arrays: fixed::Config,
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
        let arrays = self.arrays.arrays.outside_memory().map(|memory| memory.within("arrays"));
        self.front.outside_memory(arrays, self.params.outside_latency)
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// There are more `layers` than `most_layers`, or more slots than a simulation can hold, or a number of the cache is no power of
    /// two.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        let Params { layers, most_layers, .. } = params;
        let (name, most) = match params.overflow {
            Overflow::Rebuild => ("`most_layers`", most_layers),
            Overflow::Drop => ("`layers`", layers),
        };
        if layers > most {
            return Err(ParamError::Together(format!(
                "parameter `layers` is {layers}: expected at most {most}, as `most_layers` with `overflow=rebuild`"
            )));
        }
        let Screen { width, height, .. } = screen;
        let slots = u64::from(screen.pixels()) * u64::from(most);
        too_many_fragments(&format!("{name} for each of {width} x {height} pixels"), slots)?;
        let cached = Cached::of(
            "counters",
            params.counters,
            [params.counters_sets, params.counters_ways, params.counters_line],
        )?;
        let shape = Shape {
            begin: layers,
            most,
            on_chip: params.fragments,
            outside_latency: params.outside_latency,
            reads_in_flight: params.reads_in_flight,
            depth: params.sorter_depth,
            cached,
            pixels_ahead: params.framebuffer == Place::Cached,
        };
        let arrays = fixed::Config::new(screen, shape);
        let sorter = sorter::Config {
            depth: params.sorter_depth,
            pixel_bits: screen.pixel_bits(),
            layer_bits: arrays.arrays.layer_bits(),
            newest_first: false,
        };
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let reads = params.reads_in_flight;
        let (front, port) = front::Config::sharing(screen, place, reads, 4, arrays.arrays.port())?;
        Ok(Config { screen, params, arrays, sorter, front, port })
    }

    /// The most slots that each pixel can have.
    #[inline]
    pub fn most(&self) -> u32 {
        self.arrays.rebuild.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::params::Parameters;

    const SCREEN: Screen = Screen { width: 640, height: 480, background: 0 };

    fn config(settings: &[(&str, &str)]) -> Result<Config, String> {
        let mut params = Params::default();
        for (name, value) in settings {
            params.set(name, value).unwrap();
        }
        Config::new(SCREEN, params).map_err(|error| error.to_string())
    }

    #[test]
    fn presets_set_what_they_say() {
        let of = |name| {
            let Params { layers, most_layers, overflow, .. } =
                (PRESETS.iter().find(|p| p.name == name).unwrap().params)();
            (layers, most_layers, overflow)
        };
        assert_eq!(of("fast"), (8, 64, Overflow::Rebuild));
        assert_eq!(of("paper"), (64, 64, Overflow::Drop));
    }

    #[test]
    fn what_is_not_on_chip_is_outside() {
        let slots = |settings: &[(&str, &str)]| {
            let shape = config(settings).unwrap().arrays.arrays.shape;
            (shape.on_chip, shape.outside)
        };
        assert_eq!(slots(&[]), (786_432, 64 * 307_200 - 786_432));
        assert_eq!(slots(&[("overflow", "drop")]), (786_432, 8 * 307_200 - 786_432));
        assert_eq!(slots(&[("overflow", "drop"), ("layers", "2")]), (614_400, 0));
    }

    #[test]
    fn layers_are_no_more_than_the_most() {
        let layers = |layers| config(&[("layers", layers), ("most_layers", "10")]);
        assert_eq!(layers("10").unwrap().most(), 10);
        assert_eq!(
            layers("11").unwrap_err(),
            "parameter `layers` is 11: expected at most 10, as `most_layers` with `overflow=rebuild`"
        );
        assert_eq!(config(&[("layers", "100"), ("overflow", "drop")]).unwrap().most(), 100);
    }

    #[test]
    fn more_slots_than_a_simulation_holds_are_refused() {
        assert_eq!(config(&[("most_layers", "873")]).unwrap().most(), 873);
        assert_eq!(
            config(&[("most_layers", "874")]).unwrap_err(),
            "parameters `most_layers` for each of 640 x 480 pixels hold 268492800 fragments: expected at most 268435456"
        );
        assert_eq!(
            config(&[("layers", "874"), ("overflow", "drop")]).unwrap_err(),
            "parameters `layers` for each of 640 x 480 pixels hold 268492800 fragments: expected at most 268435456"
        );
    }
}
