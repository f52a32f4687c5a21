//! The T-buffer (seed 000): transparent fragments grouped by pixel in sections that any pixel can
//! have.
//!
//! ```text
//!             +-----------+ passed +-------+    +-----------+    +---------+
//! fragment -->| DepthTest |------->| Store |--->| Ssa       |--->| Resolve |
//!             +-----------+        +-------+    | Nsa       |    +---------+
//!                   |                  ^        | Sections  |      |     |
//!                   |            grant |        | Occupancy |      |     |
//!                   |              +------+     +-----------+      |     |
//!                   |              | Pool |<-----------------------+     |
//!                   |              +------+        release               |
//!                   | opaque depth and colour              blended colour|
//!                   v                                                    v
//!             +------------------------------------------------------------+
//!             | FrameBuffer: depth and colour, two banks                   |
//!             +------------------------------------------------------------+
//!                   |
//!             +---------+
//!             | Scanout |--> image
//!             +---------+
//! ```
//! A frame is stored, then resolved; then the banks of the frame buffer swap, and while `Scanout`
//! shows the frame and wipes its bank the next one is stored. Resolve gives every section back and
//! sets every SSA entry that was used to NULL, so that the next frame begins without clearing.

pub mod chain;
pub mod config;
pub mod lookup;
pub mod monitor;
pub mod nsa;
pub mod occupancy;
pub mod pool;
pub mod release;
pub mod resolve;
pub mod scan;
pub mod sections;
pub mod ssa;
pub mod store;
pub mod tables;
pub mod walk;

use crate::allocator::{self, Allocator};
use crate::blender::Sorted;
use crate::course::{self, Course};
use crate::depth_test::{self, DepthTest};
use crate::frame_buffer::{self, FrameBuffer};
use crate::machine::{Frame, Phase};
use crate::pixel::{Fragment, Marked, PixelFragment};
use crate::scanout::{self, Scanout};
use crate::sorter::Arrived;
use config::Config;
use lookup::Chain;
use nsa::Nsa;
use occupancy::Occupancy;
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Signals, Stream, WritePort, rtl};
use pool::Pool;
use resolve::Resolve;
use sections::Sections;
use ssa::Ssa;
use std::marker::PhantomData;
use store::Store;

/// The T-buffer with allocator `A`.
pub struct TBuffer<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// See [`course`].
    #[with(cfg.screen)]
    pub course: course::State,
    /// See [`depth_test`].
    #[with(cfg.screen)]
    pub depth_test: depth_test::State,
    /// See [`store`].
    #[with(*cfg)]
    pub store: store::State,
    /// See [`pool`].
    #[with(*cfg)]
    pub pool: pool::State<A>,
    /// See [`resolve`].
    #[with(*cfg)]
    pub resolve: resolve::State,
    /// See [`frame_buffer`].
    #[with(cfg.screen)]
    pub frame_buffer: frame_buffer::State,
    /// See [`scanout`].
    #[with(cfg.screen)]
    pub scanout: scanout::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<A: Allocator> {
    /// See [`ssa`].
    pub ssa: ssa::Mem,
    /// See [`nsa`].
    pub nsa: nsa::Mem,
    /// See [`sections`].
    pub sections: sections::Mem,
    /// See [`pool`].
    pub pool: pool::Mem<A>,
    /// See [`occupancy`].
    pub occupancy: occupancy::Mem,
    /// See [`frame_buffer`].
    pub frame_buffer: frame_buffer::Mem,
    /// See [`depth_test`].
    pub depth_test: depth_test::Mem,
    /// See [`store`].
    pub store: store::Mem,
    /// See [`resolve`].
    pub resolve: resolve::Mem,
    /// See [`scanout`].
    pub scanout: scanout::Mem,
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
    /// Free sections. An offer may be replaced by a better one: see [`pool`].
    #[with(cfg.id_bits())]
    pub grant: Handshake<u32>,
    /// Sections that are given back.
    #[with(cfg.id_bits())]
    pub release: Handshake<u32>,
    /// Pixels to visit.
    #[with(cfg.screen.pixel_bits())]
    pub pixel: Handshake<Marked<u32>>,
    /// Pixels with their chains.
    #[with(*cfg)]
    pub chain: Handshake<Marked<Chain>>,
    /// Fragments that were read back.
    #[with(cfg.sorter)]
    pub arrived: Handshake<Marked<Arrived>>,
    /// Fragments in blending order.
    #[with(cfg.screen)]
    pub sorted: Handshake<Marked<Sorted>>,
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
    /// A fragment was stored.
    pub stored: bool,
    /// It was stored in an outside section.
    pub spilled: bool,
    /// It was its pixel's first.
    pub first: bool,
    /// It took a new section.
    pub section_taken: bool,
    /// A fragment found no section.
    pub dropped: bool,
    /// A fragment waited for a section.
    pub waits: bool,
    /// A chain was begun to be read.
    pub chain_begun: bool,
    /// A fragment was read back.
    pub read: bool,
    /// It was read in a second pass or later.
    pub read_again: bool,
    /// A stored fragment turned out to be hidden.
    pub culled_late: bool,
    /// A fragment was blended.
    pub blended: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "tbuffer",
    input = cfg.screen,
    check(TBuffer<allocator::FreeList>, crate::test_util::small(true)),
    check(TBuffer<allocator::FreeList>, crate::test_util::small(false))
)]
impl<A: Allocator> Block for TBuffer<A> {
    type Config = Config;
    type State = State<A>;
    type In = Frame;
    type Moore = ();
    type Out = Out;
    type Mem = Mem<A>;

    fn reset(cfg: &Config) -> State<A> {
        State {
            course: Course::reset(&cfg.screen),
            depth_test: DepthTest::reset(&cfg.screen),
            store: Store::reset(cfg),
            pool: Pool::<A>::reset(cfg),
            resolve: Resolve::reset(cfg),
            frame_buffer: FrameBuffer::reset(&cfg.screen),
            scanout: Scanout::reset(&cfg.screen),
        }
    }

    fn memories(cfg: &Config) -> Mem<A> {
        Mem {
            ssa: Ssa::memories(cfg),
            nsa: Nsa::memories(cfg),
            sections: Sections::memories(cfg),
            pool: Pool::<A>::memories(cfg),
            occupancy: Occupancy::memories(cfg),
            frame_buffer: FrameBuffer::memories(&cfg.screen),
            depth_test: DepthTest::memories(&cfg.screen),
            store: Store::memories(cfg),
            resolve: Resolve::memories(cfg),
            scanout: Scanout::memories(&cfg.screen),
        }
    }

    fn moore(_: &Config, _: &State<A>, _: &Self::Mem) {}

    #[inline(always)]
    fn next(cfg: &Config, q: &State<A>, d: &mut State<A>, m: &mut Self::Mem, i: Frame) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let ssa = Ssa::moore(cfg, &(), &m.ssa);
        let nsa = Nsa::moore(cfg, &(), &m.nsa);
        let occupancy = Occupancy::moore(cfg, &(), &m.occupancy);
        let word = Sections::moore(cfg, &(), &m.sections);
        let pool = Pool::<A>::moore(cfg, &q.pool, &m.pool);
        let buffer = FrameBuffer::moore(screen, &q.frame_buffer, &m.frame_buffer);
        let depth_test_ready = DepthTest::moore(screen, &q.depth_test, &m.depth_test).ready;
        let store_ready = Store::moore(cfg, &q.store, &m.store).ready;
        let scanout = Scanout::moore(screen, &q.scanout, &m.scanout);

        // Store, clocked from a frame's first offer on: from the depth test to the sections.
        let course = Course::moore(screen, &q.course, &());
        let fragment_ready = course.open && depth_test_ready;
        let storing = course.phase == Phase::Store || (course.open && i.fragment.valid);
        let (test, store) = if storing {
            let to_depth_test = depth_test::In {
                fragment: Stream {
                    valid: i.fragment.valid && course.open,
                    payload: i.fragment.payload,
                },
                depth: buffer.depth,
                passed_ready: store_ready,
            };
            let test = DepthTest::next(
                screen,
                &q.depth_test,
                &mut d.depth_test,
                &mut m.depth_test,
                to_depth_test,
            );
            let to_store = store::In {
                fragment: test.passed,
                ssa,
                nsa,
                grant: pool.grant,
                exhausted: pool.exhausted,
            };
            (test, Store::next(cfg, &q.store, &mut d.store, &mut m.store, to_store))
        } else {
            (depth_test::Out::default(), store::Out::default())
        };

        // Resolve, clocked from the end of the store on.
        let resolve = if store.frame_stored || course.phase == Phase::Resolve {
            let to_resolve = resolve::In {
                start: store.frame_stored,
                ssa,
                nsa,
                occupancy,
                word,
                depth: buffer.depth,
                colour: buffer.colour,
            };
            Resolve::next(cfg, &q.resolve, &mut d.resolve, &mut m.resolve, to_resolve)
        } else {
            resolve::Out::default()
        };

        let to_course = course::In {
            comes: i.fragment.valid && fragment_ready,
            end: i.fragment.payload.end,
            stored: store.frame_stored,
            resolved: resolve.done,
            busy: scanout.busy,
        };
        let frame_done = Course::next(screen, &q.course, &mut d.course, &mut (), to_course).done;

        // The tables and the frame buffer serve whoever asks.
        let to_ssa = ssa::In {
            store_read: store.ssa_read,
            store_write: store.ssa_write,
            lookup_read: resolve.ssa_read,
            lookup_write: resolve.ssa_write,
            clear: course.clear,
        };
        Ssa::next(cfg, &(), &mut (), &mut m.ssa, to_ssa);
        let to_nsa = nsa::In { store: store.nsa, chain: resolve.nsa };
        Nsa::next(cfg, &(), &mut (), &mut m.nsa, to_nsa);
        let to_occupancy = occupancy::In {
            ask: store.occupancy_ask,
            set: store.occupancy_set,
            summary_read: resolve.scan.summary_read,
            summary_clear: resolve.scan.summary_clear,
            word_read: resolve.scan.word_read,
            word_clear: resolve.scan.word_clear,
            clear: course.clear,
        };
        Occupancy::next(cfg, &(), &mut (), &mut m.occupancy, to_occupancy);
        let to_sections = sections::In { write: store.place, word: store.word, read: resolve.read };
        Sections::next(cfg, &(), &mut (), &mut m.sections, to_sections);
        let to_pool = allocator::In { take: store.take, release: resolve.release };
        Pool::<A>::next(cfg, &q.pool, &mut d.pool, &mut m.pool, to_pool);
        let to_scanout = scanout::In {
            start: frame_done,
            colour: buffer.back_colour,
            image_ready: i.image_ready,
        };
        let shown = if scanout.busy || frame_done {
            Scanout::next(screen, &q.scanout, &mut d.scanout, &mut m.scanout, to_scanout)
        } else {
            scanout::Out::default()
        };
        let to_buffer = frame_buffer::In {
            depth_read: [test.depth_read, resolve.depth_read],
            depth_write: [test.depth_write, WritePort::default()],
            colour_read: resolve.colour_read,
            colour_write: [test.colour_write, resolve.colour_write],
            back_read: shown.read,
            wipe: shown.wipe,
            clear: course.clear,
            swap: frame_done,
        };
        FrameBuffer::next(
            screen,
            &q.frame_buffer,
            &mut d.frame_buffer,
            &mut m.frame_buffer,
            to_buffer,
        );

        Out {
            phase: course.phase,
            fragment: i.fragment.with(fragment_ready),
            image: scanout.image.with(i.image_ready),
            passed: test.passed.with(store_ready),
            grant: pool.grant.with(store.take),
            release: resolve.release.with(true),
            pixel: resolve.pixel,
            chain: resolve.chain,
            arrived: resolve.arrived,
            sorted: resolve.sorted,
            events: Events {
                drawn: test.drawn,
                hidden: test.hidden,
                culled_early: test.culled,
                stored: store.place.valid,
                spilled: store.place.valid && cfg.is_outside(store.place.payload.section),
                first: store.first,
                section_taken: store.take,
                dropped: store.dropped,
                waits: store.waits,
                chain_begun: resolve.chain_begun,
                read: resolve.read.valid,
                read_again: resolve.read_again,
                culled_late: resolve.culled,
                blended: resolve.blended,
                scanout: scanout.busy,
                frame_done,
            },
        }
    }
}
