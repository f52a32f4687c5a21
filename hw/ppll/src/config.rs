//! The parameters, and what the blocks derive from them.

use pellucid_blocks::allocator::AllocatorKind;
use pellucid_blocks::cached_table::{Cached, Place};
use pellucid_blocks::chains::config::{self as chains, Link, Passes, Scan, Shape};
use pellucid_blocks::rebuild::{self, Growth, Overflow};
use pellucid_blocks::{front, shared_port, sorter};
use pellucid_machine::Outside;
use pellucid_machine::parameters;
use pellucid_machine::params::{ParamError, Preset, too_many_fragments};
use pellucid_machine::pixel::Screen;

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Fragments that a page holds.
        page: u32 = 4, "fragments", 1..=64;
        /// Pages that may be used to begin with.
        pages: u32 = 262_144, "pages", 1..=1 << 27;
        /// The most pages that may be used once frames were played again (overflow=rebuild).
        most_pages: u32 = 1_048_576, "pages", 1..=1 << 27;
        /// How many more may be used once they were too few: twice as many as before, or twice as many as the last play has asked for.
        growth: Growth = Growth::Double, "", ();
        /// What happens to a frame for which there are too few pages: it is played again with more, or the fragments that find none are dropped.
        overflow: Overflow = Overflow::Rebuild, "", ();
        /// Fragments held on chip, in whole pages; all further pages lie in outside memory.
        fragments: u32 = 786_432, "fragments", 1..=1 << 27;
        /// How resolve finds pixels: visit every one, or skip empty ones by an occupancy bitmap.
        scan: Scan = Scan::Bitmap, "", ();
        /// Fragments sorted in one pass (K); a pixel with more takes several passes.
        sorter_depth: u32 = 16, "fragments", 1..=sorter::MAX_DEPTH as u32;
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Fragment reads under way at once during resolve, and pixels that wait for their head with ssa=cached; with framebuffer=cached also pixels that are read ahead.
        reads_in_flight: u32 = 64, "reads", 2..=4096;
        /// Where the heads lie: on chip, or in outside memory with a cache on chip.
        ssa: Place = Place::OnChip, "", ();
        /// Sets of that cache (ssa=cached), a power of two.
        ssa_sets: u32 = 256, "sets", 1..=1 << 16;
        /// Lines of a set, a power of two.
        ssa_ways: u32 = 4, "lines", 1..=8;
        /// Heads of a line, a power of two.
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
    Preset { name: "ppll4", about: "page=4: a link for four fragments.", params: Params::default },
    Preset {
        name: "pll",
        about: "page=1: a link for each fragment.",
        params: || Params { page: 1, pages: 1_048_576, most_pages: 4_194_304, ..Params::default() },
    },
];

/// Everything that the blocks need to know, checked.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The parameters.
    pub params: Params,
    /// The lists: chains of which a page is a section.
    pub chains: chains::Config,
    /// How many pages may be used, and what is done once they are too few.
    pub rebuild: rebuild::Config,
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
    /// If there are more pages to begin with than at most; if all pages together would hold more fragments than a simulation can; if a
    /// number of the cache of heads is no power of two.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        let Params { page, pages, most_pages, .. } = params;
        let rebuilds = params.overflow == Overflow::Rebuild;
        if rebuilds && pages > most_pages {
            return Err(ParamError::Value {
                name: "pages".to_string(),
                found: pages.to_string(),
                expected: format!("at most `most_pages`, {most_pages}, with `overflow=rebuild`"),
            });
        }
        let (most, name) = if rebuilds { (most_pages, "most_pages") } else { (pages, "pages") };
        let what = format!("`{name}` times `page`");
        too_many_fragments(&what, u64::from(most) * u64::from(page))?;
        let on_chip = most.min(params.fragments / page);
        let shape = Shape {
            owned: false,
            on_chip,
            outside: most - on_chip,
            outside_latency: params.outside_latency,
            capacity: page,
            link: Link::Head,
            bitmap: params.scan == Scan::Bitmap,
            reads_in_flight: params.reads_in_flight,
            passes: Passes::Each(params.sorter_depth),
            weight_bits: 0,
            allocator: AllocatorKind::Bump,
            ssa: Cached::of(
                "ssa",
                params.ssa,
                [params.ssa_sets, params.ssa_ways, params.ssa_line],
            )?,
            depth_ahead: params.framebuffer == Place::Cached,
        };
        let chains = chains::Config::new(screen, shape);
        let rebuild =
            rebuild::Config { begin: pages, most, growth: params.growth, entries: screen.pixels() };
        let sorter = sorter::Config {
            depth: params.sorter_depth,
            pixel_bits: screen.pixel_bits(),
            layer_bits: chains.layer_bits(),
            newest_first: true,
        };
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let reads = params.reads_in_flight;
        let (front, port) = front::Config::sharing(screen, place, reads, 4, chains.port())?;
        Ok(Config { screen, params, chains, rebuild, sorter, front, port })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::params::Parameters;

    const SCREEN: Screen = Screen { width: 4, height: 4, background: 0 };

    fn built(settings: &[(&str, &str)]) -> Result<Config, String> {
        let mut params = Params::default();
        for (name, value) in settings {
            params.set(name, value).unwrap();
        }
        Config::new(SCREEN, params).map_err(|error| error.to_string())
    }

    #[test]
    fn presets_set_what_they_say() {
        let by_name = |name| (PRESETS.iter().find(|p| p.name == name).unwrap().params)();
        let slots = |params: Params| [params.pages, params.most_pages].map(|n| n * params.page);
        assert_eq!((by_name("ppll4").page, by_name("pll").page), (4, 1));
        assert_eq!(slots(by_name("ppll4")), slots(by_name("pll")));
    }

    #[test]
    fn more_pages_than_the_most_are_refused_where_they_would_grow() {
        let error = built(&[("pages", "9"), ("most_pages", "8")]).unwrap_err();
        assert_eq!(
            error,
            "parameter `pages` is 9: expected at most `most_pages`, 8, with `overflow=rebuild`"
        );
        let dropping = built(&[("pages", "9"), ("most_pages", "8"), ("overflow", "drop")]).unwrap();
        assert_eq!(dropping.chains.null, 9);
    }

    #[test]
    fn too_much_storage_is_refused() {
        let most = |pages| built(&[("page", "64"), ("pages", "1"), ("most_pages", pages)]);
        assert!(most("4194304").is_ok());
        assert_eq!(
            most("4194305").unwrap_err(),
            "parameters `most_pages` times `page` hold 268435520 fragments: expected at most 268435456"
        );
        let drop = [("page", "3"), ("pages", "100000000"), ("overflow", "drop")];
        assert_eq!(
            built(&drop).unwrap_err(),
            "parameters `pages` times `page` hold 300000000 fragments: expected at most 268435456"
        );
    }

    #[test]
    fn whole_pages_are_on_chip_and_the_others_outside() {
        let sides = |fragments| {
            let cfg = built(&[
                ("page", "4"),
                ("pages", "2"),
                ("most_pages", "9"),
                ("fragments", fragments),
            ]);
            let shape = cfg.unwrap().chains.shape;
            (shape.on_chip, shape.outside)
        };
        assert_eq!(
            [sides("3"), sides("11"), sides("36"), sides("99")],
            [(0, 9), (2, 7), (9, 0), (9, 0)]
        );
    }
}
