//! The parameters, and what the blocks derive from them.

use crate::program::{Kind, MOST_TARGETS, Program};
use crate::window::Places;
use crate::{ahead, plays, shader, sort, window};
use pellucid_blocks::bitonic::MAX_LANE_BITS;
use pellucid_blocks::cached_table::Place;
use pellucid_blocks::pixels::Blends;
use pellucid_blocks::{front, shared_port, walker};
use pellucid_machine::params::{ParamError, Preset, power_of_two};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Outside, choice, parameters};

/// Vertices of a primitive.
pub const VERTICES: u32 = 3;
/// The longest side of an F-buffer.
const MOST_SIDE: u32 = 2048;

choice! {
    /// What becomes of fragments for which there is no place.
    pub enum Overflow {
        /// They come again, a window of fragments after the other.
        Window = "window",
        /// They come again, in smaller batches of primitives.
        Batch = "batch",
    }
}

choice! {
    /// What is done with shaded fragments.
    pub enum Mode {
        /// They are blended in the order in which they arrive.
        Shade = "shade",
        /// They are sorted first.
        Sort = "sort",
    }
}

choice! {
    /// Where a pass leaves what it knows of a fragment.
    pub enum Store {
        /// In the F-buffer, in a place of its own.
        FBuffer = "fbuffer",
        /// At its pixel, as the traditional way is: the last one of a pixel overwrites all others.
        FrameBuffer = "framebuffer",
    }
}

choice! {
    /// Where the F-buffer lies.
    pub enum Lies {
        /// On chip, as a whole.
        OnChip = "on_chip",
        /// In outside memory, read ahead of the walk.
        Outside = "outside",
    }
}

choice! {
    /// What becomes of a fragment that its program kills.
    pub enum Kill {
        /// It keeps its place, and is not blended.
        Keep = "keep",
        /// It is dropped from the F-buffer.
        Compact = "compact",
    }
}

choice! {
    /// Whether hidden fragments are dropped before they are shaded.
    pub enum EarlyDepth {
        /// They are not.
        Off = "off",
        /// They are, before they are counted.
        BeforeWindow = "before_window",
    }
}

choice! {
    /// Bits of a component.
    pub enum ComponentBits {
        /// A byte.
        Eight = "8",
        /// Two bytes.
        Sixteen = "16",
        /// Four bytes.
        ThirtyTwo = "32",
    }
}

impl ComponentBits {
    /// The number.
    pub fn bits(self) -> u32 {
        match self {
            ComponentBits::Eight => 8,
            ComponentBits::Sixteen => 16,
            ComponentBits::ThirtyTwo => 32,
        }
    }
}

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Places along a side of the F-buffer: a power of two.
        size: u32 = 256, "places", 1..=MOST_SIDE;
        /// Targets that a pass writes, each of four components.
        targets: u32 = 1, "targets", 1..=MOST_TARGETS;
        /// Bits of a component.
        component_bits: ComponentBits = ComponentBits::ThirtyTwo, "bits", ();
        /// The fragment program.
        program: Kind = Kind::Glass, "", ();
        /// What the program is drawn from (program=random).
        seed: u32 = 1, "", 0..=u32::MAX;
        /// What happens to fragments for which there is no place: they come again a window after the other, or in smaller batches of primitives.
        overflow: Overflow = Overflow::Window, "", ();
        /// Where a pass leaves what it knows: in a place of each fragment's own, or the traditional way in one place for each pixel.
        store: Store = Store::FBuffer, "", ();
        /// Where the F-buffer lies: on chip, or in outside memory, from where it is read ahead of the walk.
        buffer: Lies = Lies::OnChip, "", ();
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Words of the F-buffer that are asked for before their fragments come (buffer=outside); with framebuffer=cached also fragments that wait for their pixel, and pixels that are read ahead.
        reads_in_flight: u32 = 64, "reads", 2..=4096;
        /// What becomes of fragments that the program kills: they keep their place to the last pass, or are dropped from the F-buffer.
        kill: Kill = Kill::Keep, "", ();
        /// Whether hidden fragments are dropped before they are counted, once all that is opaque is drawn.
        early_depth: EarlyDepth = EarlyDepth::Off, "", ();
        /// What is done with shaded fragments: they are blended in the order in which they arrive, or sorted first.
        mode: Mode = Mode::Shade, "", ();
        /// Compare-exchanges that the sort does in a cycle: a power of two (mode=sort).
        sorter_lanes: u32 = 4, "lanes", 1..=1 << MAX_LANE_BITS;
        /// From vertex to vertex of a submission.
        vertex_cycles: u32 = 1, "cycles", 1..=256;
        /// From fragment to fragment of a pass.
        fragment_cycles: u32 = 1, "cycles", 1..=256;
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
        name: "x800",
        about: "overflow=window: windows over the fragments of a submission, as ATI's X800 has them.",
        params: Params::default,
    },
    Preset {
        name: "r9800",
        about: "overflow=batch: overflow is noticed after the first pass, as on ATI's 9800, and smaller batches are submitted.",
        params: || Params { overflow: Overflow::Batch, ..Params::default() },
    },
];

fn value(name: &str, found: &str, expected: &str) -> ParamError {
    ParamError::Value {
        name: name.to_string(),
        found: found.to_string(),
        expected: expected.to_string(),
    }
}

/// Holds parameters to what a sort can do.
fn sortable(params: &Params) -> Result<(), ParamError> {
    if params.store == Store::FrameBuffer {
        return Err(value("store", "framebuffer", "fbuffer, with `mode=sort`"));
    }
    if params.buffer == Lies::Outside {
        return Err(value("buffer", "outside", "on_chip, with `mode=sort`"));
    }
    if params.overflow == Overflow::Batch {
        return Err(value("overflow", "batch", "window, with `mode=sort`"));
    }
    let places = params.size * params.size;
    if params.sorter_lanes > places {
        let found = params.sorter_lanes.to_string();
        return Err(value(
            "sorter_lanes",
            &found,
            &format!("at most {places}, the places of the F-buffer"),
        ));
    }
    Ok(())
}

/// Holds parameters to what a frame buffer outside can do: nothing but the test and the blend of what comes sees a pixel.
fn composable(params: &Params) -> Result<(), ParamError> {
    let alone = |name, found, expected: &str| {
        Err(value(name, found, &format!("{expected}, with `framebuffer=cached`")))
    };
    if params.mode == Mode::Sort {
        return alone("mode", "sort", "shade");
    }
    if params.store == Store::FrameBuffer {
        return alone("store", "framebuffer", "fbuffer");
    }
    if params.early_depth == EarlyDepth::BeforeWindow {
        return alone("early_depth", "before_window", "off");
    }
    Ok(())
}

/// Everything that the blocks need to know, checked.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The parameters.
    pub params: Params,
    /// Vertices, and the edge walk.
    pub walker: walker::Config,
    /// From play to play.
    pub plays: plays::Config,
    /// The fragment program.
    pub shader: shader::Config,
    /// The F-buffer, if it lies outside.
    pub ahead: ahead::Config,
    /// The sort, if there is one.
    pub sort: sort::Config,
    /// Hidden fragments are dropped before they are counted.
    pub early: bool,
    /// The frame buffer.
    pub front: front::Config,
    /// The port to what lies outside.
    pub port: shared_port::Config,
}

impl Config {
    /// Checks the parameters.
    ///
    /// # Errors
    /// `size`, `sorter_lanes` or a number of the cache is no power of two, or parameters do not go together.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        power_of_two("size", params.size)?;
        power_of_two("sorter_lanes", params.sorter_lanes)?;
        let sorts = params.mode == Mode::Sort;
        if sorts {
            sortable(&params)?;
        }
        if params.kill == Kill::Compact && params.store == Store::FrameBuffer {
            return Err(value("kill", "compact", "keep, with `store=framebuffer`"));
        }
        if params.buffer == Lies::Outside && params.store == Store::FrameBuffer {
            return Err(value("buffer", "outside", "on_chip, with `store=framebuffer`"));
        }
        if params.framebuffer == Place::Cached {
            composable(&params)?;
        }
        let program = Program::new(params.program, params.seed, params.targets);
        let places = match params.store {
            _ if program.count == 1 && !sorts => Places::None,
            Store::FBuffer => Places::Counted(2 * params.size.ilog2()),
            Store::FrameBuffer => Places::Pixel,
        };
        let window = window::Config {
            screen,
            places,
            fragment_cycles: params.fragment_cycles,
            windows: matches!(places, Places::Counted(_)) && params.overflow == Overflow::Window,
            compacts: params.kill == Kill::Compact && program.kills && program.count > 1,
            outside: params.buffer == Lies::Outside && program.count > 1,
        };
        let early = params.early_depth == EarlyDepth::BeforeWindow
            || params.store == Store::FrameBuffer
            || sorts;
        let sort = sort::Config {
            screen,
            place_bits: if sorts { window.place_bits() } else { 0 },
            lane_bits: if sorts { params.sorter_lanes.ilog2() } else { 0 },
        };
        let shader = shader::Config {
            window,
            program,
            targets: params.targets,
            bits: params.component_bits.bits(),
        };
        let set_up_cycles = VERTICES * params.vertex_cycles;
        let reads_in_flight = params.reads_in_flight;
        let ahead = ahead::Config { shader, reads_in_flight, latency: params.outside_latency };
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let (front, port) =
            front::Config::sharing(screen, place, reads_in_flight, 1, ahead.port())?;
        Ok(Config {
            params,
            walker: walker::Config { screen, set_up_cycles, fragment_cycles: 1 },
            plays: plays::Config {
                window,
                passes: program.count,
                background: early || program.count == 1,
                sorts,
            },
            shader,
            ahead,
            sort,
            early,
            front: front.blending(Blends::Coming),
            port,
        })
    }

    /// The screen.
    #[inline]
    pub fn screen(&self) -> &Screen {
        &self.walker.screen
    }

    /// The window.
    #[inline]
    pub fn window(&self) -> &window::Config {
        &self.plays.window
    }

    /// A pass leaves something for the next one.
    #[inline]
    pub fn stores(&self) -> bool {
        self.plays.passes > 1
    }

    /// It leaves it in outside memory.
    #[inline]
    pub fn outside(&self) -> bool {
        self.window().outside
    }

    /// What lies outside.
    pub fn outside_memory(&self) -> Option<Outside> {
        self.front.outside_memory(self.ahead.outside_memory(), self.params.outside_latency)
    }

    /// The path of the memory in which the F-buffer lies, and how many words it takes there for one of the F-buffer.
    pub fn memory(&self) -> (&'static str, u64) {
        if self.outside() {
            ("buffer.outside", self.ahead.parts().into())
        } else {
            ("buffer.words", 1)
        }
    }

    /// Words of the F-buffer: none where a program has one pass.
    #[inline]
    pub fn words(&self) -> u32 {
        if self.stores() { self.shader.words() } else { 0 }
    }

    /// Bits of a word.
    pub fn word_bits(&self) -> u32 {
        self.shader.values() * self.shader.bits
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
            params.set(name, value).map_err(|error| error.to_string())?;
        }
        Config::new(SCREEN, params).map_err(|error| error.to_string())
    }

    #[test]
    fn presets_set_what_they_say() {
        let of = |name| (PRESETS.iter().find(|p| p.name == name).unwrap().params)().overflow;
        assert_eq!((of("x800"), of("r9800")), (Overflow::Window, Overflow::Batch));
    }

    /// Four floats at 1024x1024 are 16 MiB, four targets of them 64 MiB (seed 003, section 3.1).
    #[test]
    fn the_papers_buffers_are_as_large_as_printed() {
        for (targets, mib) in [("1", 16), ("4", 64)] {
            let cfg = config(&[("size", "1024"), ("targets", targets)]).unwrap();
            assert_eq!(u64::from(cfg.words()) * u64::from(cfg.word_bits()) / 8, mib << 20);
        }
    }

    #[test]
    fn a_side_is_a_power_of_two() {
        assert_eq!(
            config(&[("size", "48")]).unwrap_err(),
            "parameter `size` is 48: expected a power of two"
        );
        assert_eq!(config(&[("size", "2048")]).unwrap().words(), 1 << 22);
        assert!(config(&[("size", "4096")]).is_err());
    }

    #[test]
    fn a_sort_takes_windows_of_the_f_buffer() {
        let sort = |settings: &[(&str, &str)]| {
            let settings = [&[("mode", "sort"), ("size", "2")], settings].concat();
            config(&settings).map(|_| ())
        };
        assert_eq!(sort(&[]), Ok(()));
        let refused = |settings| sort(settings).unwrap_err();
        assert_eq!(
            refused(&[("store", "framebuffer")]),
            "parameter `store` is framebuffer: expected fbuffer, with `mode=sort`"
        );
        assert_eq!(
            refused(&[("buffer", "outside")]),
            "parameter `buffer` is outside: expected on_chip, with `mode=sort`"
        );
        assert_eq!(
            refused(&[("overflow", "batch")]),
            "parameter `overflow` is batch: expected window, with `mode=sort`"
        );
        assert_eq!(
            refused(&[("sorter_lanes", "8")]),
            "parameter `sorter_lanes` is 8: expected at most 4, the places of the F-buffer"
        );
        assert_eq!(
            refused(&[("sorter_lanes", "3")]),
            "parameter `sorter_lanes` is 3: expected a power of two"
        );
    }

    #[test]
    fn nothing_else_looks_at_a_frame_buffer_outside() {
        let cached = |settings: &[(&str, &str)]| {
            config(&[&[("framebuffer", "cached")], settings].concat()).map(|cfg| {
                let memory = cfg.outside_memory().unwrap();
                memory.tables.into_iter().map(|table| (table.path, table.words)).collect::<Vec<_>>()
            })
        };
        let pixels = ("front.pixels.outside".to_string(), 2 * 307_200);
        assert_eq!(cached(&[]), Ok(vec![pixels.clone()]));
        let buffer = ("buffer.outside".to_string(), 1 << 16);
        assert_eq!(cached(&[("buffer", "outside")]), Ok(vec![buffer, pixels]));
        for (name, value, expected) in [
            ("mode", "sort", "shade"),
            ("store", "framebuffer", "fbuffer"),
            ("early_depth", "before_window", "off"),
        ] {
            assert_eq!(
                cached(&[(name, value)]).unwrap_err(),
                format!(
                    "parameter `{name}` is {value}: expected {expected}, with `framebuffer=cached`"
                )
            );
        }
        assert_eq!(
            cached(&[("framebuffer_sets", "3")]).unwrap_err(),
            "parameter `framebuffer_sets` is 3: expected a power of two"
        );
    }

    #[test]
    fn what_is_dropped_has_a_place_of_its_own() {
        let compact = |settings: &[(&str, &str)]| {
            config(&[&[("kill", "compact")], settings].concat()).map(|cfg| cfg.window().compacts)
        };
        assert_eq!(compact(&[("program", "sieve")]), Ok(true));
        // Nothing is ever dropped.
        assert_eq!(compact(&[("program", "glass")]), Ok(false));
        assert_eq!(
            compact(&[("program", "sieve"), ("store", "framebuffer")]).unwrap_err(),
            "parameter `kill` is compact: expected keep, with `store=framebuffer`"
        );
    }

    #[test]
    fn what_lies_outside_has_a_port() {
        let port = |settings: &[(&str, &str)]| {
            let outside = [("buffer", "outside"), ("outside_latency", "9")];
            config(&[&outside, settings].concat()).map(|cfg| {
                let tables =
                    cfg.ahead.outside_memory().map(|memory| (memory.tables.len(), memory.latency));
                (cfg.ahead.port().words, cfg.ahead.port().bits, tables)
            })
        };
        assert_eq!(port(&[]), Ok((1 << 16, 128, Some((1, 9)))));
        assert_eq!(port(&[("targets", "4"), ("size", "2048")]), Ok((4 << 22, 128, Some((1, 9)))));
        assert_eq!(port(&[("buffer", "on_chip")]), Ok((0, 0, None)));
        // There is nothing to store.
        assert_eq!(port(&[("program", "tint")]), Ok((0, 0, None)));
        assert_eq!(
            port(&[("store", "framebuffer")]).unwrap_err(),
            "parameter `buffer` is outside: expected on_chip, with `store=framebuffer`"
        );
    }

    #[test]
    fn one_pass_needs_no_buffer() {
        let cfg = config(&[("program", "tint")]).unwrap();
        assert_eq!((cfg.words(), cfg.plays.background), (0, true));
        let cfg = config(&[("program", "random"), ("seed", "7")]).unwrap();
        assert_eq!((cfg.words(), cfg.plays.background), (1 << 16, false));
    }
}
