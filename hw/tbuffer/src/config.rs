//! The T-buffer's parameters, and what the blocks derive from them.

use pellucid_blocks::allocator::AllocatorKind;
use pellucid_blocks::cached_table::{Cached, Place};
use pellucid_blocks::chains::config::{self as chains, Link, Passes, Scan, Shape};
use pellucid_blocks::{front, shared_port, sorter};
use pellucid_machine::Outside;
use pellucid_machine::params::{ParamError, Preset, too_many_fragments};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{choice, parameters};

choice! {
    /// How a fragment finds the end of its pixel's chain.
    pub enum Append {
        /// The SSA table holds the first section; each store walks the chain (seed 000).
        Walk = "walk",
        /// The SSA table also holds the last section and how full it is.
        Tail = "tail",
    }
}

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Sections on chip.
        sections: u32 = 262_144, "sections", 1..=1 << 28;
        /// Fragments that a section holds (L).
        section_capacity: u32 = 3, "fragments", 1..=64;
        /// How a store finds the end of its pixel's chain: walk it, or keep its tail in the SSA table.
        append: Append = Append::Tail, "", ();
        /// How resolve finds pixels: visit every one, or skip empty ones by an occupancy bitmap.
        scan: Scan = Scan::Bitmap, "", ();
        /// Which allocator hands out sections.
        allocator: AllocatorKind = AllocatorKind::Fifo, "", ();
        /// Fragments sorted in one pass (K); a pixel with more takes several passes.
        sorter_depth: u32 = 16, "fragments", 1..=sorter::MAX_DEPTH as u32;
        /// Further sections in outside memory, used once those on chip are all taken.
        outside_sections: u32 = 1_048_576, "sections", 0..=1 << 28;
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Fragment reads under way at once during resolve, and pixels that wait for their SSA entry with ssa=cached; with framebuffer=cached also pixels that are read ahead.
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
        name: "fast",
        about: "append=tail, scan=bitmap: stores about a fragment a cycle, and resolves one while all are on chip and no pixel has more than `sorter_depth`.",
        params: Params::default,
    },
    Preset {
        name: "paper",
        about: "append=walk, scan=linear: as the T-buffer paper describes it.",
        params: || Params { append: Append::Walk, scan: Scan::Linear, ..Params::default() },
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
        let chains = self.chains.outside_memory().map(|memory| memory.within("chains"));
        self.front.outside_memory(chains, self.params.outside_latency)
    }
    /// Checks the parameters against each other.
    ///
    /// # Errors
    /// If all sections together would hold more fragments than a simulation can, or are more than the
    /// allocator can have; if a number of a cache is no power of two.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        let sections = u64::from(params.sections) + u64::from(params.outside_sections);
        let fragments = sections * u64::from(params.section_capacity);
        let what = "`sections` + `outside_sections` times `section_capacity`";
        too_many_fragments(what, fragments)?;
        params.allocator.check("sections", params.sections)?;
        params.allocator.check("outside_sections", params.outside_sections)?;
        let shape = Shape {
            owned: false,
            on_chip: params.sections,
            outside: params.outside_sections,
            outside_latency: params.outside_latency,
            capacity: params.section_capacity,
            link: match params.append {
                Append::Walk => Link::Walk,
                Append::Tail => Link::Tail,
            },
            bitmap: params.scan == Scan::Bitmap,
            reads_in_flight: params.reads_in_flight,
            passes: Passes::Each(params.sorter_depth),
            weight_bits: 0,
            allocator: params.allocator,
            ssa: Cached::of(
                "ssa",
                params.ssa,
                [params.ssa_sets, params.ssa_ways, params.ssa_line],
            )?,
            depth_ahead: params.framebuffer == Place::Cached,
        };
        let chains = chains::Config::new(screen, shape);
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let reads = params.reads_in_flight;
        let (front, port) = front::Config::sharing(screen, place, reads, 4, chains.port())?;
        let sorter = sorter::Config {
            depth: params.sorter_depth,
            pixel_bits: screen.pixel_bits(),
            layer_bits: chains.layer_bits(),
            newest_first: false,
        };
        Ok(Config { screen, params, chains, sorter, front, port })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::params::Parameters;

    #[test]
    fn presets_set_what_they_say() {
        let by_name = |name| (PRESETS.iter().find(|p| p.name == name).unwrap().params)();
        assert_eq!((by_name("fast").append, by_name("fast").scan), (Append::Tail, Scan::Bitmap));
        assert_eq!((by_name("paper").append, by_name("paper").scan), (Append::Walk, Scan::Linear));
    }

    #[test]
    fn a_bitmap_has_few_sections() {
        let screen = Screen { width: 4, height: 4, background: 0 };
        let few = |sections, outside_sections| {
            let allocator = AllocatorKind::Bitmap;
            let params = Params { allocator, sections, outside_sections, ..Params::default() };
            Config::new(screen, params).map_err(|error| error.to_string())
        };
        assert!(few(4096, 4096).is_ok());
        let refused = |name: &str| {
            format!("parameter `{name}` is 4097: expected at most 4096 with `allocator=bitmap`")
        };
        assert_eq!(few(4097, 0).unwrap_err(), refused("sections"));
        assert_eq!(few(1, 4097).unwrap_err(), refused("outside_sections"));
    }

    #[test]
    fn a_cache_has_powers_of_two() {
        let screen = Screen { width: 4, height: 4, background: 0 };
        for (name, value) in [
            ("ssa_sets", "3"),
            ("ssa_ways", "6"),
            ("ssa_line", "12"),
            ("framebuffer_sets", "3"),
            ("framebuffer_ways", "6"),
            ("framebuffer_line", "12"),
        ] {
            let mut params = Params::default();
            params.set(name, value).unwrap();
            let error = Config::new(screen, params).unwrap_err().to_string();
            assert_eq!(error, format!("parameter `{name}` is {value}: expected a power of two"));
        }
    }

    #[test]
    fn too_much_storage_is_refused() {
        let screen = Screen { width: 4, height: 4, background: 0 };
        let mut params = Params::default();
        params.set("sections", "16777216").unwrap();
        params.set("section_capacity", "16").unwrap();
        let error = Config::new(screen, params).unwrap_err();
        assert_eq!(
            error.to_string(),
            "parameters `sections` + `outside_sections` times `section_capacity` hold 285212672 \
             fragments: expected at most 268435456"
        );
    }
}
