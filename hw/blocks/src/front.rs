//! What machines of fragments have in common: the frame sequencer, the early depth test, the frame buffer and the
//! scanout that shows it.
//!
//! ```text
//!              +-------------------------------------------+
//!  fragment -->| DepthTest                                 |---> passed (transparent, in front)
//!              |     | depth, colour      Sequencer        |---> phase, clear
//!              |     v                                     |
//!  depth,  --->| Display: frame buffer (depth and colour,  |---> depth, colour
//!  colour      |          two banks), scanout              |---> image
//!              +-------------------------------------------+
//! ```
//! Around it a machine stores what has passed, and says when the frame is `stored`; then it turns that into an image,
//! with the frame buffer's ports for itself, and says when it is `resolved`. Then the banks swap, and while the frame is
//! shown and its bank wiped the next one is stored. The depth test is clocked while fragments come, from the first
//! offer of a frame on.
//!
//! Where the frame buffer lies in outside memory [`Pixels`] are there instead of depth test and display. Then a machine
//! says beforehand which pixels it will use while it resolves, and takes depths and colours as they come: see
//! [`Resolve`].

pub mod alone;
pub mod monitor;

use crate::blender::Sorted;
use crate::cached_table::{Cached, Place};
use crate::depth_test::{self, DepthTest};
use crate::display::{self, Display};
use crate::pixels::{self, Blends, Pixel, Pixels, Resolve, Resolved, Revisit};
use crate::sequencer::{self, Sequencer};
pub use crate::sequencer::{PHASES, Phase};
use crate::shared_port;
use crate::sorter;
use pellucid_machine::Outside;
use pellucid_machine::outside::{self, Request};
use pellucid_machine::params::ParamError;
use pellucid_machine::pixel::{
    Arrived, COLOUR_BITS, Fragment, Marked, PixelFragment, Screen, Z_BITS,
};
use pellucid_sim::{Block, Memory, Optional, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Front;

/// The path of a frame buffer in outside memory, among the memories of a machine.
pub const FRAMEBUFFER: &str = "front.pixels.outside";

/// Where depth and colour of the pixels lie.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The frame buffer, where it lies in outside memory; else it is on chip.
    pub pixels: Option<pixels::Config>,
}

impl Config {
    /// All of it on chip.
    pub fn on_chip(screen: Screen) -> Config {
        Config { screen, pixels: None }
    }
    /// The frame buffer where the parameters `framebuffer` and `framebuffer_sets`, `_ways` and `_line` say, with so many reads in
    /// flight and so many pixels [blended](pixels::Config::blended), and the port that it shares with what keeps fragments and has
    /// `fragments`.
    ///
    /// # Errors
    /// A number of its cache is no power of two.
    pub fn sharing(
        screen: Screen,
        (place, lines): (Place, [u32; 3]),
        reads_in_flight: u32,
        blended: u32,
        fragments: outside::Config,
    ) -> Result<(Config, shared_port::Config), ParamError> {
        let pixels = Cached::of("framebuffer", place, lines)?
            .map(|cached| pixels::Config::new(screen, cached, reads_in_flight, blended));
        let reads = pixels.map_or(1, |pixels| 4 * pixels.reads_in_flight);
        let port = shared_port::Config::new(fragments, Config { screen, pixels }.port(), reads);
        let pixels = pixels.map(|pixels| pixels.behind(port.memory().bits));
        Ok((Config { screen, pixels }, port))
    }
    /// The same where what is resolved is known to be visible, so that it needs no depth.
    #[must_use]
    pub fn without_depths(mut self) -> Config {
        self.pixels = self.pixels.map(pixels::Config::without_depths);
        self
    }
    /// The same where transparent fragments are blended at that time.
    #[must_use]
    pub fn blending(mut self, blends: Blends) -> Config {
        self.pixels = self.pixels.map(|pixels| pixels.blending(blends));
        self
    }
    /// What lies outside, where `fragments` do, with a memory of that latency.
    pub fn outside_memory(&self, fragments: Option<Outside>, latency: u32) -> Option<Outside> {
        let Some(pixels) = self.pixels else { return fragments };
        let mut tables = fragments.map_or(vec![], |fragments| fragments.tables);
        tables.push(pixels.memory(FRAMEBUFFER));
        Some(Outside { tables, latency })
    }
    /// Whether the frame buffer lies in outside memory.
    #[inline]
    pub fn outside(&self) -> bool {
        self.pixels.is_some()
    }
    /// The frame buffer there.
    #[inline]
    pub fn pixels(&self) -> pixels::Config {
        self.pixels.unwrap_or(pixels::Config::NONE)
    }
    /// The port to it; none where it is on chip.
    #[inline]
    pub fn port(&self) -> outside::Config {
        self.pixels.map_or(outside::Config::NONE, |pixels| pixels.port())
    }
}

#[rtl]
impl Config {
    /// Whether something goes on that waits for a frame buffer outside alone.
    #[inline(always)]
    pub fn goes(&self, ready: bool) -> bool {
        !self.outside() || ready
    }
}

/// What goes to a sorter, and from there to a blender.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Gated {
    /// What arrives at the sorter.
    #[with(cfg.pixel_bits(), 0)]
    pub arrived: Stream<Marked<Arrived>>,
    /// It is taken there.
    pub arrived_ready: bool,
    /// What the blender is given.
    #[with(cfg.pixel_bits())]
    pub sorted: Stream<Marked<Sorted>>,
    /// It is taken there.
    pub sorted_ready: bool,
}

/// What goes there of what has arrived and what is sorted: where the frame buffer lies outside, while its port has room for colours
/// to be read and written.
#[inline(always)]
#[rtl]
pub fn gated(
    cfg: &Config,
    seen: Resolved,
    arrived: Stream<Marked<Arrived>>,
    sorter: sorter::Moore,
) -> Gated {
    let arrives = cfg.goes(pixels::opens(seen, arrived));
    let blends = cfg.goes(seen.colour_ready);
    Gated {
        arrived: Stream { valid: arrived.valid && arrives, payload: arrived.payload },
        arrived_ready: sorter.ready && arrives,
        sorted: Stream { valid: sorter.sorted.valid && blends, payload: sorter.sorted.payload },
        sorted_ready: blends,
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`sequencer`].
    #[with(cfg.screen)]
    #[block(Sequencer)]
    pub sequencer: sequencer::State,
    /// See [`depth_test`].
    #[with(cfg.screen)]
    #[exists(!cfg.outside())]
    #[block(DepthTest)]
    pub depth_test: depth_test::State,
    /// See [`display`].
    #[with(cfg.screen)]
    #[exists(!cfg.outside())]
    #[block(Display)]
    pub display: display::State,
    /// See [`pixels`].
    #[with(cfg.pixels())]
    #[exists(cfg.outside())]
    #[block(Pixels)]
    pub pixels: pixels::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`depth_test`].
    #[block(DepthTest, cfg.screen)]
    #[exists(!cfg.outside())]
    pub depth_test: Optional<depth_test::Mem>,
    /// See [`display`].
    #[block(Display, cfg.screen)]
    #[exists(!cfg.outside())]
    pub display: Optional<display::Mem>,
    /// See [`pixels`].
    #[block(Pixels, cfg.pixels())]
    #[exists(cfg.outside())]
    pub pixels: Optional<pixels::Mem>,
}

/// Inputs. The ports of the frame buffer are the machine's: while fragments come, for depth alone, and no other than the
/// depth test may write.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// Fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<Fragment>>,
    /// The display takes a pixel.
    pub image_ready: bool,
    /// Whoever takes `passed` is ready.
    pub passed_ready: bool,
    /// The frame's last fragment is stored.
    pub stored: bool,
    /// The frame's last pixel is written.
    pub resolved: bool,
    /// The frame is to come again.
    pub again: bool,
    /// The pixel that is cleared is cleared in the machine, too.
    pub cleared: bool,
    /// Reads a depth.
    #[with(cfg.screen.pixel_bits())]
    pub depth_read: ReadPort,
    /// Writes a depth.
    #[with(cfg.screen.pixel_bits(), Z_BITS)]
    pub depth_write: WritePort<u32>,
    /// Reads a colour.
    #[with(cfg.screen.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes a colour, `0xRRGGBB`.
    #[with(cfg.screen.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// What it asks and tells while it resolves, where the frame buffer lies outside. There no depth is read or written.
    #[with(cfg.screen)]
    #[exists(cfg.outside())]
    pub resolve: Resolve,
    /// The same where fragments come again.
    #[with(cfg.screen)]
    #[exists(cfg.pixels().revisits())]
    pub revisit: Revisit,
    /// What the frame buffer sees of outside memory.
    #[with(cfg.port())]
    #[exists(cfg.outside())]
    pub memory: outside::In,
}

/// Outputs of registers and read data: those of a machine of fragments, and what the machine itself needs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What the machine shows to the outside.
    pub status: Status,
    /// Transparent fragments in front, in order, then the end of the frame.
    #[with(cfg.screen)]
    pub passed: Stream<Marked<PixelFragment>>,
    /// The depth that was asked for. Where the frame buffer lies outside, once it is there and until it is taken.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
    /// After reset: the pixel that is cleared.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// What the machine sees while it resolves, where the frame buffer lies outside.
    #[exists(cfg.outside())]
    pub resolve: Resolved,
    /// A fragment that comes again is taken.
    #[exists(cfg.pixels().revisits())]
    pub revisits: bool,
    /// Its pixel, once it is there and until it is done with.
    #[with(cfg.screen)]
    #[exists(cfg.pixels().revisits())]
    pub pixel: Read<Pixel>,
    /// What is drawn may not be shown yet: the frame before still is, or what was drawn is on its way to outside memory.
    pub busy: bool,
}

/// What a machine of fragments shows before its inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
pub struct Status {
    /// What it is at, as its registers have it: in the cycle in which a frame's first fragment comes still idle.
    pub phase: Phase,
    /// A fragment, or the end of a frame, is taken.
    pub ready: bool,
    /// What comes next is the same frame again: see [`Ports::replay`](pellucid_machine::Ports::replay). A machine that asks
    /// for it again says so itself.
    pub replay: bool,
    /// The image, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// An image is being shown.
    pub shows: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// What the machine is at: storing from the cycle on in which a frame's first fragment comes.
    pub phase: Phase,
    /// An opaque fragment is drawn.
    pub drawn: bool,
    /// An opaque fragment is hidden.
    pub hidden: bool,
    /// A transparent fragment is hidden on arrival.
    pub culled: bool,
    /// The frame is complete and is shown from the next cycle on.
    pub frame_done: bool,
    /// What the frame buffer asks of outside memory.
    #[with(cfg.port())]
    #[exists(cfg.outside())]
    pub request: Stream<Request>,
    /// What is told of its cache.
    #[exists(cfg.outside())]
    pub events: pixels::Events,
}

#[rtl(
    check(Front, Config::on_chip(crate::test_util::screen(5, 3))),
    check(Front, tests::outside())
)]
impl Block for Front {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let sequencer = Sequencer::moore(&cfg.screen, &q.sequencer, &());
        let mut clear = sequencer.clear;
        if cfg.outside() {
            let pixels = Pixels::moore(&cfg.pixels(), &q.pixels, &m.pixels);
            // All take it in one cycle, so that none asks memory for it again and again.
            clear.valid &= pixels.clear_ready;
            Moore {
                status: Status {
                    phase: sequencer.phase,
                    ready: sequencer.open && pixels.ready,
                    replay: false,
                    image: pixels.image,
                    shows: pixels.busy,
                },
                passed: pixels.passed,
                depth: pixels.depth,
                colour: pixels.colour,
                clear,
                resolve: pixels.resolve,
                revisits: pixels.ready,
                pixel: pixels.pixel,
                busy: pixels.busy || !pixels.drained,
            }
        } else {
            let depth_test = DepthTest::moore(&cfg.screen, &q.depth_test, &m.depth_test);
            let display = Display::moore(&cfg.screen, &q.display, &m.display);
            Moore {
                status: Status {
                    phase: sequencer.phase,
                    ready: sequencer.open && depth_test.ready,
                    replay: false,
                    image: display.image,
                    shows: display.busy,
                },
                passed: depth_test::passed(depth_test.stage, display.depth),
                depth: display.depth,
                colour: display.colour,
                clear,
                resolve: Resolved::default(),
                revisits: false,
                pixel: Read::default(),
                busy: display.busy,
            }
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let sequencer = Sequencer::moore(&cfg.screen, &q.sequencer, &());
        let offered = i.fragment.valid && sequencer.open;
        let fragment = Stream { valid: offered, payload: i.fragment.payload };
        let storing = matches!(sequencer.phase, Phase::Store) || offered;

        // What is drawn, and what is shown before that.
        let (ready, busy, cleared, depth) = if cfg.outside() {
            let seen = Pixels::moore(&cfg.pixels(), &q.pixels, &m.pixels);
            let cleared = i.cleared && seen.clear_ready;
            (seen.ready, seen.busy || !seen.drained, cleared, seen.depth)
        } else {
            let ready = DepthTest::moore(&cfg.screen, &q.depth_test, &m.depth_test).ready;
            let display = Display::moore(&cfg.screen, &q.display, &m.display);
            (ready, display.busy, i.cleared, display.depth)
        };
        let to_sequencer = sequencer::In {
            comes: offered && ready,
            end: i.fragment.payload.end,
            stored: i.stored,
            resolved: i.resolved,
            again: i.again,
            cleared,
            busy,
        };
        let frame_done =
            Sequencer::next(&cfg.screen, &q.sequencer, &mut d.sequencer, &mut (), to_sequencer)
                .done;

        let mut out = Out::default();
        if cfg.outside() {
            let to_pixels = pixels::In {
                storing,
                fragment,
                passed_ready: i.passed_ready,
                stored: i.stored,
                resolve: i.resolve,
                revisit: i.revisit,
                colour_read: i.colour_read,
                colour_write: i.colour_write,
                clearing: matches!(sequencer.phase, Phase::Clear),
                clear: Stream {
                    valid: sequencer.clear.valid && i.cleared,
                    payload: sequencer.clear.payload,
                },
                show: frame_done,
                image_ready: i.image_ready,
                memory: i.memory,
            };
            let done =
                Pixels::next(&cfg.pixels(), &q.pixels, &mut d.pixels, &mut m.pixels, to_pixels);
            out.drawn = done.drawn;
            out.hidden = done.hidden;
            out.culled = done.culled;
            out.request = done.request;
            out.events = done.events;
        } else {
            let mut test = depth_test::Out::default();
            if storing {
                let to_depth_test =
                    depth_test::In { fragment, depth, passed_ready: i.passed_ready };
                test = DepthTest::next(
                    &cfg.screen,
                    &q.depth_test,
                    &mut d.depth_test,
                    &mut m.depth_test,
                    to_depth_test,
                );
            }
            let to_display = display::In {
                depth_read: [test.depth_read, i.depth_read],
                depth_write: [test.depth_write, i.depth_write],
                colour_read: i.colour_read,
                colour_write: [test.colour_write, i.colour_write],
                clear: sequencer.clear,
                show: frame_done,
                image_ready: i.image_ready,
            };
            Display::next(&cfg.screen, &q.display, &mut d.display, &mut m.display, to_display);
            out.drawn = test.drawn;
            out.hidden = test.hidden;
            out.culled = test.culled;
        }
        out.phase = if storing { Phase::Store } else { sequencer.phase };
        out.frame_done = frame_done;
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cached_table::Cached;
    use crate::test_util::screen;

    pub(super) fn outside() -> Config {
        let cached = Cached { sets: 2, ways: 2, line: 4 };
        let pixels = pixels::Config::new(screen(5, 3), cached, 5, 3);
        Config { screen: screen(5, 3), pixels: Some(pixels) }
    }
}
