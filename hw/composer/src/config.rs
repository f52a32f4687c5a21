//! The image composition machine's parameters, and what the blocks derive from them.

use super::distributor::MOST_LOAD;
use super::scan_line::bucket_sort;
use super::{Config, distributor, merger, object_engine, raster, scan_line, scan_lines, store};
use pellucid_blocks::cached_table::Place;
use pellucid_blocks::{sorter, walker};
use pellucid_machine::params::{ParamError, Preset};
use pellucid_machine::pixel::Screen;
use pellucid_machine::primitive::Primitive;
use pellucid_machine::{choice, parameters};
use pellucid_mbuffer::config as mbuffer;
use pellucid_rbuffer::config as rbuffer;
use pellucid_tbuffer::config as tbuffer;

/// The most object-order engines.
const MAX_ENGINES: u32 = 1024;
/// The most scan-line engines.
const MAX_SCAN_LINE_ENGINES: u32 = 64;
/// Pixels that all local frame buffers together may have: what a simulation can hold in memory.
const MAX_LOCAL_PIXELS: u64 = 1 << 29;

choice! {
    /// Which object-order engine an opaque primitive goes to.
    pub enum Distribution {
        /// To each in turn.
        RoundRobin = "round_robin",
        /// To the one that has the fewest pixels to draw so far.
        Area = "area",
    }
}

impl Distribution {
    /// A model of where primitives go, among so many engines.
    pub fn engines(self, engines: u32) -> Engines {
        Engines { by_area: self == Distribution::Area, turn: 0, loads: vec![0; engines as usize] }
    }
}

/// See [`Distribution::engines`].
#[derive(Clone, Debug)]
pub struct Engines {
    by_area: bool,
    turn: usize,
    loads: Vec<u32>,
}

impl Engines {
    /// The engine that the frame's next opaque primitive goes to.
    pub fn engine(&mut self, primitive: &Primitive) -> u32 {
        let turn = self.turn;
        self.turn = (turn + 1) % self.loads.len();
        let least = |(k, load): (usize, &u32)| (*load, k);
        let by_area = self.loads.iter().enumerate().map(least).min().map_or(0, |(_, k)| k);
        let engine = if self.by_area { by_area } else { turn };
        let load = self.loads[engine] + primitive.area + 1;
        self.loads[engine] = load.min(MOST_LOAD);
        engine as u32
    }
}

choice! {
    /// What stands behind the merger.
    pub enum Behind {
        /// Scan-line engines.
        ScanLine = "scanline",
        /// A T-buffer.
        TBuffer = "tbuffer",
        /// An R-buffer.
        RBuffer = "rbuffer",
        /// An M-buffer.
        MBuffer = "mbuffer",
    }
}

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Object-order engines, each with its merging unit (n).
        engines: u32 = 16, "engines", 1..=MAX_ENGINES;
        /// What adds the transparent primitives to the merged image: scan-line engines, or a fragment store.
        transparency: Behind = Behind::ScanLine, "", ();
        /// Scan-line engines (r); each has every r-th line (transparency=scanline).
        scan_line_engines: u32 = 1, "engines", 1..=MAX_SCAN_LINE_ENGINES;
        /// Overhead after each scan line, in the merger and where results are collected.
        beta: u32 = 20, "cycles", 0..=1023;
        /// Which object-order engine an opaque primitive goes to.
        distribution: Distribution = Distribution::RoundRobin, "", ();
        /// Set-up of a primitive, beside the drawing of the one before.
        set_up_cycles: u32 = 4, "cycles", 1..=256;
        /// From fragment to fragment of an object-order engine, and of transparent primitives for a fragment store.
        fragment_cycles: u32 = 1, "cycles", 1..=256;
        /// Primitives that wait for an object-order engine.
        primitive_queue: u32 = 4, "primitives", 1..=4096;
        /// Transparent primitives that a frame may have.
        primitives: u32 = 2_500_000, "primitives", 1..=1 << 22;
        /// Transparent primitives that a scan line may have (transparency=scanline).
        line_primitives: u32 = 12_288, "primitives", 1..=1 << 20;
        /// Fragments sorted in one pass (K), the opaque one included; a pixel with more takes several passes (transparency=scanline).
        sorter_depth: u32 = 16, "fragments", 1..=sorter::MAX_DEPTH as u32;
        part tbuffer: tbuffer::Params;
        part rbuffer: rbuffer::Params;
        part mbuffer: mbuffer::Params;
    }
}

/// All presets; the first is the default.
pub const PRESETS: &[Preset<Params>] = &[
    Preset {
        name: "vc1",
        about: "16 object-order engines and one scan-line engine, with the paper's numbers of the VC-1 machine.",
        params: Params::default,
    },
    Preset {
        name: "wide",
        about: "scan_line_engines=4, distribution=area: for frames with much transparency.",
        params: || Params {
            scan_line_engines: 4,
            distribution: Distribution::Area,
            ..Params::default()
        },
    },
];

impl<C> Config<C> {
    /// The machine with `transparency` behind its merger.
    fn new(screen: Screen, params: &Params, transparency: C) -> Result<Config<C>, ParamError> {
        let Params { engines, beta, distribution, primitive_queue, .. } = *params;
        let pixels = u64::from(engines) * u64::from(screen.pixels());
        if pixels > MAX_LOCAL_PIXELS {
            return Err(ParamError::Together(format!(
                "the local frame buffers of `engines` engines hold {pixels} pixels: expected at most \
                 {MAX_LOCAL_PIXELS}"
            )));
        }
        Ok(Config {
            distributor: distributor::Config { screen, engines, distribution },
            merger: merger::Config {
                shape: merger::Shape { engines, raster: raster::Config { screen, beta } },
                engine: object_engine::Config {
                    walker: walker(screen, params),
                    queue: primitive_queue,
                },
            },
            transparency,
        })
    }
}

fn walker(screen: Screen, params: &Params) -> walker::Config {
    let Params { set_up_cycles, fragment_cycles, .. } = *params;
    walker::Config { screen, set_up_cycles, fragment_cycles }
}

/// What the blocks of a machine with scan-line engines need to know.
///
/// # Errors
/// If there are more scan-line engines than lines, or the local frame buffers are larger than a simulation
/// can hold.
pub fn scan_lines(
    screen: Screen,
    params: &Params,
) -> Result<Config<scan_lines::Config>, ParamError> {
    let engines = params.scan_line_engines;
    if engines > screen.height {
        return Err(ParamError::Together(format!(
            "parameter `scan_line_engines` is {engines}: expected at most {}, the rows of the screen",
            screen.height
        )));
    }
    let capacity = params.primitives;
    let bucket_sort = bucket_sort::Config { screen, engines, index: 0, capacity };
    let engine = scan_line::Config {
        bucket_sort,
        line_primitives: params.line_primitives.min(params.primitives),
        sorter_depth: params.sorter_depth,
    };
    let raster = raster::Config { screen, beta: params.beta };
    Config::new(screen, params, scan_lines::Config { engines, engine, raster })
}

/// What the blocks of a machine with a fragment store need to know; `store` is what the store itself does, for the
/// same screen, and its parameters are those of `part`.
///
/// # Errors
/// If the local frame buffers are larger than a simulation can hold, or the store's own lies outside.
pub fn store<C>(
    screen: Screen,
    params: &Params,
    store: C,
    part: &'static str,
) -> Result<Config<store::Config<C>>, ParamError> {
    let framebuffer = match part {
        "tbuffer" => params.tbuffer.framebuffer,
        "mbuffer" => params.mbuffer.framebuffer,
        _ => Place::OnChip,
    };
    if framebuffer == Place::Cached {
        return Err(ParamError::Together(format!(
            "`{part}.framebuffer=cached` does not go with `transparency={part}`: expected `{part}.framebuffer=on_chip`, \
             as the merger waits for no pixel of the opaque image"
        )));
    }
    let walker = walker(screen, params);
    Config::new(
        screen,
        params,
        store::Config { primitives: params.primitives, walker, store, part },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::params::Parameters;

    fn refused(screen: (u32, u32), params: Params) -> String {
        let screen = Screen { width: screen.0, height: screen.1, background: 0 };
        scan_lines(screen, &params).unwrap_err().to_string()
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let params = Params { scan_line_engines: 49, ..Params::default() };
        assert_eq!(
            refused((64, 48), params),
            "parameter `scan_line_engines` is 49: expected at most 48, the rows of the screen"
        );
        let params = Params { engines: 1024, ..Params::default() };
        assert_eq!(
            refused((1024, 1024), params),
            "the local frame buffers of `engines` engines hold 1073741824 pixels: expected at most 536870912"
        );
        let screen = Screen { width: 64, height: 48, background: 0 };
        assert!(scan_lines(screen, &Params { scan_line_engines: 48, ..Params::default() }).is_ok());
    }

    #[test]
    fn a_store_behind_the_merger_has_its_frame_buffer_on_chip() {
        let screen = Screen { width: 64, height: 48, background: 0 };
        for part in ["tbuffer", "mbuffer"] {
            let mut params = Params::default();
            assert!(store(screen, &params, (), part).is_ok());
            params.set(&format!("{part}.framebuffer"), "cached").unwrap();
            assert_eq!(
                store(screen, &params, (), part).err().unwrap().to_string(),
                format!(
                    "`{part}.framebuffer=cached` does not go with `transparency={part}`: expected \
                     `{part}.framebuffer=on_chip`, as the merger waits for no pixel of the opaque image"
                )
            );
        }
    }
}
