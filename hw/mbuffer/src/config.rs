//! The M-buffer's parameters, and what the blocks derive from them.

use super::array;
use pellucid_blocks::allocator::AllocatorKind;
use pellucid_blocks::cached_table::{Cached, Place};
use pellucid_blocks::chains::config::{self as chains, Link, Passes, Scan, Shape};
use pellucid_blocks::weights::WEIGHT_BITS;
use pellucid_blocks::{front, shared_port};
use pellucid_machine::Outside;
use pellucid_machine::params::{ParamError, Preset, too_many_fragments};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{choice, parameters};

choice! {
    /// Where the weights are kept.
    pub enum Weights {
        /// In the registers of the array, while a pixel's fragments are read back.
        Registers = "registers",
        /// In memory beside the fragments, from their arrival on.
        Memory = "memory",
    }
}

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Fragments that a section holds (D_avg); each pixel owns one section.
        section_capacity: u32 = 2, "fragments", 1..=64;
        /// Further sections on chip, that any pixel can have once its own is full.
        overflow_sections: u32 = 131_072, "sections", 0..=1 << 28;
        /// Further sections in outside memory, used once those on chip are all taken.
        outside_sections: u32 = 1_048_576, "sections", 0..=1 << 28;
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Where the weights are kept: in registers while a pixel is read back, or in memory from the arrival on.
        weights: Weights = Weights::Registers, "", ();
        /// Fragments of a pixel that are weighed at once (weights=registers); a pixel with more takes several passes.
        array: u32 = 8, "fragments", 1..=array::MAX_CELLS as u32;
        /// How resolve finds pixels: visit every one, or skip empty ones by an occupancy bitmap.
        scan: Scan = Scan::Bitmap, "", ();
        /// Which allocator hands out the further sections.
        allocator: AllocatorKind = AllocatorKind::Fifo, "", ();
        /// Fragment reads under way at once, fragments that are weighed at once (weights=memory), and pixels that wait for their SSA entry with ssa=cached; with framebuffer=cached also pixels that are read ahead.
        reads_in_flight: u32 = 64, "reads", 2..=4096;
        /// Where the SSA table lies: on chip, or in outside memory with a cache on chip.
        ssa: Place = Place::OnChip, "", ();
        /// Sets of that cache (ssa=cached), a power of two.
        ssa_sets: u32 = 256, "sets", 1..=1 << 16;
        /// Lines of a set, a power of two.
        ssa_ways: u32 = 4, "lines", 1..=8;
        /// SSA entries of a line, a power of two.
        ssa_line: u32 = 8, "entries", 1..=16;
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
        name: "registers",
        about: "weights=registers: an array of multipliers; stores a fragment a cycle, and resolves one while all are on chip and no pixel has more than `array`.",
        params: Params::default,
    },
    Preset {
        name: "memory",
        about: "weights=memory: one multiplier; each arrival reads all that its pixel has.",
        params: || Params { weights: Weights::Memory, ..Params::default() },
    },
];

/// Everything that the blocks need to know, checked.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The parameters.
    pub params: Params,
    /// The chains of sections.
    pub chains: chains::Config,
    /// The array.
    pub array: array::Config,
    /// The weights are kept in memory: there is no array.
    pub in_memory: bool,
    /// The frame buffer.
    pub front: front::Config,
    /// The port to what lies outside.
    pub port: shared_port::Config,
}

impl Config {
    /// What lies outside.
    pub fn outside_memory(&self) -> Option<Outside> {
        let chains = self.chains.outside_memory().map(|memory| memory.within("chains"));
        self.front.outside_memory(chains, self.params.outside_latency)
    }

    /// Checks the parameters against each other.
    ///
    /// # Errors
    /// If all sections together would hold more fragments than a simulation can, or are more than the
    /// allocator can have; if a number of the SSA table's cache is no power of two.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        let free = u64::from(params.overflow_sections) + u64::from(params.outside_sections);
        let sections = u64::from(screen.pixels()) + free;
        let what = "pixels + `overflow_sections` + `outside_sections` times `section_capacity`";
        too_many_fragments(what, sections * u64::from(params.section_capacity))?;
        params.allocator.check("overflow_sections", params.overflow_sections)?;
        params.allocator.check("outside_sections", params.outside_sections)?;
        let in_memory = params.weights == Weights::Memory;
        let shape = Shape {
            owned: true,
            on_chip: params.overflow_sections,
            outside: params.outside_sections,
            outside_latency: params.outside_latency,
            capacity: params.section_capacity,
            link: Link::Tail,
            bitmap: params.scan == Scan::Bitmap,
            reads_in_flight: params.reads_in_flight,
            passes: if in_memory { Passes::One } else { Passes::Twice(params.array) },
            weight_bits: if in_memory { WEIGHT_BITS } else { 0 },
            allocator: params.allocator,
            ssa: Cached::of(
                "ssa",
                params.ssa,
                [params.ssa_sets, params.ssa_ways, params.ssa_line],
            )?,
            depth_ahead: params.framebuffer == Place::Cached,
        };
        let chains = chains::Config::new(screen, shape);
        let array = array::Config { cells: params.array, screen, layer_bits: chains.layer_bits() };
        // Each cell of the array may have a pixel of its own.
        let blended = if in_memory { 4 } else { params.array + 6 };
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let reads = params.reads_in_flight;
        let (front, port) = front::Config::sharing(screen, place, reads, blended, chains.port())?;
        Ok(Config { screen, params, chains, array, in_memory, front, port })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::params::Parameters;

    #[test]
    fn presets_set_what_they_say() {
        let by_name = |name| (PRESETS.iter().find(|p| p.name == name).unwrap().params)();
        assert_eq!(by_name("registers").weights, Weights::Registers);
        assert_eq!(by_name("memory").weights, Weights::Memory);
    }

    #[test]
    fn too_much_storage_is_refused() {
        let screen = Screen { width: 8192, height: 8192, background: 0 };
        let mut params = Params::default();
        params.set("section_capacity", "4").unwrap();
        let error = Config::new(screen, params).unwrap_err();
        assert_eq!(
            error.to_string(),
            "parameters pixels + `overflow_sections` + `outside_sections` times `section_capacity` hold \
             273154048 fragments: expected at most 268435456"
        );
        params.set("section_capacity", "3").unwrap();
        assert!(Config::new(screen, params).is_ok());
    }
}
