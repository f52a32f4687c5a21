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

pub mod alone;
pub mod monitor;

use crate::depth_test::{self, DepthTest};
use crate::display::{self, Display};
use crate::sequencer::{self, Sequencer};
pub use crate::sequencer::{PHASES, Phase};
use pellucid_machine::pixel::{COLOUR_BITS, Fragment, Marked, PixelFragment, Screen, Z_BITS};
use pellucid_sim::{Block, Memory, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Front;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// See [`sequencer`].
    #[with(*cfg)]
    #[block(Sequencer)]
    pub sequencer: sequencer::State,
    /// See [`depth_test`].
    #[with(*cfg)]
    #[block(DepthTest)]
    pub depth_test: depth_test::State,
    /// See [`display`].
    #[with(*cfg)]
    #[block(Display)]
    pub display: display::State,
}

/// Memories.
#[derive(Memory)]
#[memory(Screen)]
pub struct Mem {
    /// See [`depth_test`].
    #[block(DepthTest, *cfg)]
    pub depth_test: depth_test::Mem,
    /// See [`display`].
    #[block(Display, *cfg)]
    pub display: display::Mem,
}

/// Inputs. The ports of the frame buffer are the machine's: while fragments come, for depth alone, and no other than the
/// depth test may write.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct In {
    /// Fragments in arrival order, then the end of the frame.
    #[with(*cfg)]
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
    #[with(cfg.pixel_bits())]
    pub depth_read: ReadPort,
    /// Writes a depth.
    #[with(cfg.pixel_bits(), Z_BITS)]
    pub depth_write: WritePort<u32>,
    /// Reads a colour.
    #[with(cfg.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes a colour, `0xRRGGBB`.
    #[with(cfg.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
}

/// Outputs of registers and read data: those of a machine of fragments, and what the machine itself needs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// What the machine shows to the outside.
    pub status: Status,
    /// Transparent fragments in front, in order, then the end of the frame.
    #[with(*cfg)]
    pub passed: Stream<Marked<PixelFragment>>,
    /// The depth that was asked for.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
    /// After reset: the pixel that is cleared.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
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
#[derive(Clone, Copy, Debug, Signals)]
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
}

#[rtl(output = (), check(Front, crate::test_util::screen(5, 3)))]
impl Block for Front {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    #[inline(always)]
    fn moore(cfg: &Screen, q: &State, m: &Mem) -> Moore {
        let sequencer = Sequencer::moore(cfg, &q.sequencer, &());
        let depth_test = DepthTest::moore(cfg, &q.depth_test, &m.depth_test);
        let display = Display::moore(cfg, &q.display, &m.display);
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
            clear: sequencer.clear,
        }
    }

    #[inline(always)]
    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let sequencer = Sequencer::moore(cfg, &q.sequencer, &());
        let display = Display::moore(cfg, &q.display, &m.display);
        let ready = DepthTest::moore(cfg, &q.depth_test, &m.depth_test).ready;

        let offered = i.fragment.valid && sequencer.open;
        let storing = matches!(sequencer.phase, Phase::Store) || offered;
        let test = if storing {
            let to_depth_test = depth_test::In {
                fragment: Stream { valid: offered, payload: i.fragment.payload },
                depth: display.depth,
                passed_ready: i.passed_ready,
            };
            DepthTest::next(cfg, &q.depth_test, &mut d.depth_test, &mut m.depth_test, to_depth_test)
        } else {
            depth_test::Out::default()
        };

        let to_sequencer = sequencer::In {
            comes: offered && ready,
            end: i.fragment.payload.end,
            stored: i.stored,
            resolved: i.resolved,
            again: i.again,
            cleared: i.cleared,
            busy: display.busy,
        };
        let frame_done =
            Sequencer::next(cfg, &q.sequencer, &mut d.sequencer, &mut (), to_sequencer).done;

        let to_display = display::In {
            depth_read: [test.depth_read, i.depth_read],
            depth_write: [test.depth_write, i.depth_write],
            colour_read: i.colour_read,
            colour_write: [test.colour_write, i.colour_write],
            clear: sequencer.clear,
            show: frame_done,
            image_ready: i.image_ready,
        };
        Display::next(cfg, &q.display, &mut d.display, &mut m.display, to_display);

        Out {
            phase: if storing { Phase::Store } else { sequencer.phase },
            drawn: test.drawn,
            hidden: test.hidden,
            culled: test.culled,
            frame_done,
        }
    }
}
