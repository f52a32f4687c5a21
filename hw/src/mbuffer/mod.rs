//! The M-buffer with weight factors (seed 000, after Amor et al., 2006): transparent fragments grouped by
//! pixel in sections, of which each pixel owns one, and added up by weight without being sorted.
//!
//! ```text
//!             +-----------+ passed +--------+ arrived +-------+ term +-----+
//! fragment -->| DepthTest |------->| Chains |-------->| Array |----->| Sum |
//!             +-----------+        +--------+         +-------+      +-----+
//!                   |                   |                               |
//!                   | depth, colour     | depth                  colour |
//!                   v                   v                               v
//!             +--------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout |--> image
//!             +--------------------------------------------------------------+
//! ```
//! A frame is stored in the [`chains`], then resolved: they give it back pixel by pixel, the
//! array weighs each pixel's fragments, and they are summed up with what they let through of the opaque
//! colour. With `weights=memory` they are weighed as they arrive and there is no array. See
//! [`weights`](crate::weights) for the arithmetic.

pub mod array;
pub mod config;
pub mod monitor;
pub mod sum;

use crate::allocator::Allocator;
use crate::chains::{self, Chains};
use crate::course::{self, Course};
use crate::depth_test::{self, DepthTest};
use crate::display::{self, Display};
use crate::machine::{Frame, Phase, Shown, shown};
use crate::pixel::{Fragment, Marked, PixelFragment};
use array::Array;
use config::Config;
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Signals, Stream, WritePort, rtl};
use std::marker::PhantomData;
use sum::{Sum, Term, plus};

/// The M-buffer with allocator `A`.
#[derive(Clone, Copy, Debug)]
pub struct MBuffer<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// See [`course`].
    #[with(cfg.screen)]
    pub course: course::State,
    /// See [`depth_test`].
    #[with(cfg.screen)]
    pub depth_test: depth_test::State,
    /// See [`chains`].
    #[with(cfg.chains)]
    pub chains: chains::State<A>,
    /// See [`mod@array`].
    #[with(cfg.array)]
    pub array: array::State,
    /// See [`sum`].
    #[with(cfg.screen)]
    pub sum: sum::State,
    /// See [`display`].
    #[with(cfg.screen)]
    pub display: display::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<A: Allocator> {
    /// See [`chains`].
    pub chains: chains::Mem<A>,
    /// See [`display`].
    pub display: display::Mem,
    /// See [`depth_test`].
    pub depth_test: depth_test::Mem,
}

/// What can be seen of the machine in a cycle: its ports, the streams between its blocks, and what
/// its blocks did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What the machine is at.
    pub phase: Phase,
    /// Fragments come in, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Handshake<Marked<Fragment>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(24)]
    pub image: Handshake<u32>,
    /// Transparent fragments in front, to be stored.
    #[with(cfg.screen)]
    pub passed: Handshake<Marked<PixelFragment>>,
    /// What can be seen of the chains.
    #[with(cfg.chains)]
    pub chains: chains::Wires,
    /// Sums of weighted fragments.
    #[with(cfg.screen)]
    pub term: Handshake<Marked<Term>>,
    /// What happened.
    pub events: Events,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// An opaque fragment was drawn.
    pub drawn: bool,
    /// An opaque fragment was hidden.
    pub hidden: bool,
    /// A transparent fragment was hidden on arrival.
    pub culled_early: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "mbuffer",
    input = cfg.screen,
    moore = (),
    check(MBuffer<crate::allocator::FreeList>, crate::test_util::small_mbuffer(true)),
    check(MBuffer<crate::allocator::FreeList>, crate::test_util::small_mbuffer(false))
)]
impl<A: Allocator> Block for MBuffer<A> {
    type Config = Config;
    type State = State<A>;
    type In = Frame;
    type Moore = Shown;
    type Out = Out;
    type Mem = Mem<A>;

    fn reset(cfg: &Config) -> State<A> {
        State {
            course: Course::reset(&cfg.screen),
            depth_test: DepthTest::reset(&cfg.screen),
            chains: Chains::<A>::reset(&cfg.chains),
            array: Array::reset(&cfg.array),
            sum: Sum::reset(&cfg.screen),
            display: Display::reset(&cfg.screen),
        }
    }

    fn memories(cfg: &Config) -> Mem<A> {
        Mem {
            chains: Chains::<A>::memories(&cfg.chains),
            display: Display::memories(&cfg.screen),
            depth_test: DepthTest::memories(&cfg.screen),
        }
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State<A>, m: &Self::Mem) -> Shown {
        shown(
            Course::moore(&cfg.screen, &q.course, &()),
            DepthTest::moore(&cfg.screen, &q.depth_test, &m.depth_test),
            Display::moore(&cfg.screen, &q.display, &m.display),
        )
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State<A>, d: &mut State<A>, m: &mut Self::Mem, i: Frame) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let shown = Self::moore(cfg, q, m);
        let course = Course::moore(screen, &q.course, &());
        let display = Display::moore(screen, &q.display, &m.display);
        let stored = Chains::<A>::moore(&cfg.chains, &q.chains, &m.chains);

        // Store, clocked from a frame's first offer on.
        let storing = course.phase == Phase::Store || (course.open && i.fragment.valid);
        let resolving = course.phase == Phase::Resolve;
        let test = if storing {
            let to_depth_test = depth_test::In {
                fragment: Stream {
                    valid: i.fragment.valid && course.open,
                    payload: i.fragment.payload,
                },
                depth: display.depth,
                passed_ready: stored.ready,
            };
            DepthTest::next(
                screen,
                &q.depth_test,
                &mut d.depth_test,
                &mut m.depth_test,
                to_depth_test,
            )
        } else {
            depth_test::Out::default()
        };

        // Resolve: from the chains to the frame buffer. What is weighed already is a term of its own.
        let Marked { end, item } = stored.arrived.payload;
        let weighed = Term { pixel: item.pixel, last: item.last, ..Term::default() };
        let weighed = if item.visible { plus(weighed, item.rgba, item.weight) } else { weighed };
        let term = if cfg.in_memory {
            Stream { valid: stored.arrived.valid, payload: Marked { end, item: weighed } }
        } else {
            Array::moore(&cfg.array, &q.array, &()).term
        };
        let sum = if resolving {
            if !cfg.in_memory {
                let to_array = array::In { arrived: stored.arrived };
                Array::next(&cfg.array, &q.array, &mut d.array, &mut (), to_array);
            }
            let to_sum = sum::In { term, colour: display.colour };
            Sum::next(screen, &q.sum, &mut d.sum, &mut (), to_sum)
        } else {
            sum::Out::default()
        };

        let to_chains = chains::In {
            storing,
            resolving,
            fragment: test.passed,
            depth: display.depth,
            arrived_ready: true,
            written: sum.frame_done,
            clear: course.clear,
        };
        let chains =
            Chains::<A>::next(&cfg.chains, &q.chains, &mut d.chains, &mut m.chains, to_chains);

        let to_course = course::In {
            comes: i.fragment.valid && shown.ready,
            end: i.fragment.payload.end,
            stored: chains.stored,
            resolved: chains.done,
            again: false,
            busy: display.busy,
        };
        let frame_done = Course::next(screen, &q.course, &mut d.course, &mut (), to_course).done;

        // The frame buffer serves whoever asks.
        let to_display = display::In {
            depth_read: [test.depth_read, chains.depth_read],
            depth_write: [test.depth_write, WritePort::default()],
            colour_read: sum.colour_read,
            colour_write: [test.colour_write, sum.colour_write],
            clear: course.clear,
            show: frame_done,
            image_ready: i.image_ready,
        };
        Display::next(screen, &q.display, &mut d.display, &mut m.display, to_display);

        Out {
            phase: shown.phase,
            fragment: i.fragment.with(shown.ready),
            image: shown.image.with(i.image_ready),
            passed: test.passed.with(stored.ready),
            chains: chains.wires,
            term: term.with(true),
            events: Events {
                drawn: test.drawn,
                hidden: test.hidden,
                culled_early: test.culled,
                scanout: shown.shows,
                frame_done,
            },
        }
    }
}
