//! The T-buffer (seed 000): transparent fragments grouped by pixel in sections that any pixel can
//! have.
//!
//! ```text
//!                     STORE                                     RESOLVE
//!            +-----------+   +-------+       +------+   +--------+   +-------------+   +--------+
//! fragment ->| DepthTest |-->| Store |       | Scan |-->| Lookup |-->| ChainReader |-->| Sorter |
//!            +-----------+   +-------+       +------+   +--------+   +-------------+   +--------+
//!                 |            | | | |          |        |     |      |      |   |          v
//!                 |     +------+ | | +----------+        |     |      |      |   |     +---------+
//!                 |     |        | |  Occupancy          |     |      |      |   |     | Blender |
//!                 |     |  +-----+ +------ Ssa ----------+     |      |      |   |     +---------+
//!                 |     |  |                                   |      |      |   |          |
//!                 |   Pool Sections, Nsa ----------------------|------+      |   |          |
//!                 |     ^  +-----------------------------------|-------------+   |          |
//!                 |     +---------- ReleaseQueue --------------|-----------------+          |
//!                 v                                            v                            v
//!            +---------------------------------------------------------------------------------+
//!            | FrameBuffer (depth and colour, two banks)                                       |
//!            +---------------------------------------------------------------------------------+
//!                 |
//!            +---------+
//!            | Scanout |--> image
//!            +---------+
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
pub mod scan;
pub mod sections;
pub mod ssa;
pub mod store;
pub mod tables;

use crate::allocator::{self, Allocator};
use crate::blender::{self, Blender, Sorted};
use crate::depth_test::{self, DepthTest};
use crate::frame_buffer::{self, FrameBuffer};
use crate::machine::{Frame, Phase};
use crate::pixel::{Fragment, Marked, PixelFragment};
use crate::scanout::{self, Scanout};
use crate::sorter::{self, Arrived, Sorter};
use chain::ChainReader;
use config::Config;
use lookup::{Chain, Lookup};
use nsa::Nsa;
use occupancy::Occupancy;
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Signals, Stream};
use pool::Pool;
use release::ReleaseQueue;
use scan::Scan;
use sections::Sections;
use ssa::Ssa;
use std::marker::PhantomData;
use store::Store;

/// The T-buffer with allocator `A`.
pub struct TBuffer<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// What the machine is at.
    pub phase: Phase,
    /// The pixel that is cleared next, after reset.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// The end of the frame has come in: fragments of the next one must wait.
    pub ended: bool,
    /// All pixels are blended.
    pub blended: bool,
    /// See [`depth_test`].
    #[with(cfg.screen)]
    pub depth_test: depth_test::State,
    /// See [`store`].
    #[with(*cfg)]
    pub store: store::State,
    /// See [`pool`].
    #[with(*cfg)]
    pub pool: pool::State<A>,
    /// See [`scan`].
    #[with(*cfg)]
    pub scan: scan::State,
    /// See [`lookup`].
    #[with(*cfg)]
    pub lookup: lookup::State,
    /// See [`chain`].
    #[with(*cfg)]
    pub chain: chain::State,
    /// See [`release`].
    #[with(cfg.release())]
    pub release: release::State,
    /// See [`sorter`].
    #[with(cfg.sorter())]
    pub sorter: sorter::State,
    /// See [`blender`].
    #[with(cfg.screen)]
    pub blender: blender::State,
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
    /// See [`lookup`].
    pub lookup: lookup::Mem,
    /// See [`chain`].
    pub chain: chain::Mem,
    /// See [`release`].
    pub release: release::Mem,
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
    #[with(cfg.sorter())]
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

impl Config {
    /// The release queue: room for the sections of a pixel that one pass sorts, and some on the way.
    pub fn release(&self) -> release::Config {
        let depth = self.params.sorter_depth.div_ceil(self.capacity) + 4;
        release::Config { depth, id_bits: self.id_bits() }
    }
}

impl<A: Allocator> Block for TBuffer<A> {
    type Config = Config;
    type State = State<A>;
    type In = Frame;
    type Moore = ();
    type Out = Out;
    type Mem = Mem<A>;

    fn reset(cfg: &Config) -> State<A> {
        State {
            phase: Phase::Clear,
            clear: Stream::offer(0),
            ended: false,
            blended: false,
            depth_test: DepthTest::reset(&cfg.screen),
            store: Store::reset(cfg),
            pool: Pool::<A>::reset(cfg),
            scan: Scan::reset(cfg),
            lookup: Lookup::reset(cfg),
            chain: ChainReader::reset(cfg),
            release: ReleaseQueue::reset(&cfg.release()),
            sorter: Sorter::reset(&cfg.sorter()),
            blender: Blender::reset(&cfg.screen),
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
            lookup: Lookup::memories(cfg),
            chain: ChainReader::memories(cfg),
            release: ReleaseQueue::memories(&cfg.release()),
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
        let pixel = Scan::moore(cfg, &q.scan, &()).pixel;
        let lookup_ready = Lookup::moore(cfg, &q.lookup, &m.lookup).ready;
        let chain = ChainReader::moore(cfg, &q.chain, &m.chain);
        let release = ReleaseQueue::moore(&cfg.release(), &q.release, &m.release);
        let sorter = Sorter::moore(&cfg.sorter(), &q.sorter, &());
        let scanout = Scanout::moore(screen, &q.scanout, &m.scanout);

        // Store: from the depth test to the sections.
        let open = matches!(q.phase, Phase::Idle | Phase::Store) && !q.ended;
        let fragment_ready = open && depth_test_ready;
        let to_depth_test = depth_test::In {
            fragment: Stream { valid: i.fragment.valid && open, payload: i.fragment.payload },
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
            occupancy,
            grant: pool.grant,
            exhausted: pool.exhausted,
        };
        let store = Store::next(cfg, &q.store, &mut d.store, &mut m.store, to_store);

        // Resolve: from the scan to the blended pixel.
        let to_scan = scan::In {
            start: q.phase == Phase::Store && store.frame_stored,
            occupancy,
            pixel_ready: lookup_ready,
        };
        let scan = Scan::next(cfg, &q.scan, &mut d.scan, &mut (), to_scan);
        let to_lookup = lookup::In { pixel, ssa, depth: buffer.depth, chain_ready: chain.ready };
        let lookup = Lookup::next(cfg, &q.lookup, &mut d.lookup, &mut m.lookup, to_lookup);
        let to_chain = chain::In {
            chain: lookup.chain,
            nsa,
            word,
            arrived_ready: sorter.ready,
            release_ready: release.ready,
        };
        let reader = ChainReader::next(cfg, &q.chain, &mut d.chain, &mut m.chain, to_chain);
        let to_sorter = sorter::In { arrived: chain.arrived, sorted_ready: true };
        Sorter::next(&cfg.sorter(), &q.sorter, &mut d.sorter, &mut (), to_sorter);
        let to_blender = blender::In { sorted: sorter.sorted, colour: buffer.colour };
        let blend = Blender::next(screen, &q.blender, &mut d.blender, &mut (), to_blender);
        ReleaseQueue::next(
            &cfg.release(),
            &q.release,
            &mut d.release,
            &mut m.release,
            reader.release,
        );

        // The frame's course.
        let blended = q.blended || blend.frame_done;
        let frame_done = blended && release.empty && !scanout.busy;
        match q.phase {
            Phase::Clear => {
                if q.clear.valid {
                    let last = q.clear.payload + 1 == screen.pixels();
                    d.clear =
                        if last { Stream::idle() } else { Stream::offer(q.clear.payload + 1) };
                } else {
                    d.phase = Phase::Idle;
                }
            }
            Phase::Idle => {
                if i.fragment.valid && fragment_ready {
                    d.phase = Phase::Store;
                }
            }
            Phase::Store => {
                if store.frame_stored {
                    d.phase = Phase::Resolve;
                }
            }
            Phase::Resolve => {
                if frame_done {
                    d.phase = Phase::Idle;
                } else if blended && release.empty {
                    d.phase = Phase::Wait;
                }
            }
            Phase::Wait => {
                if frame_done {
                    d.phase = Phase::Idle;
                }
            }
        }
        let ended = i.fragment.valid && fragment_ready && i.fragment.payload.end;
        d.ended = (q.ended || ended) && !frame_done;
        d.blended = blended && !frame_done;

        // The tables and the frame buffer serve whoever asks.
        let to_ssa = ssa::In {
            store_read: store.ssa_read,
            store_write: store.ssa_write,
            lookup_read: lookup.ssa_read,
            lookup_write: lookup.ssa_write,
            clear: q.clear,
        };
        Ssa::next(cfg, &(), &mut (), &mut m.ssa, to_ssa);
        let to_nsa = nsa::In { store: store.nsa, chain: reader.nsa };
        Nsa::next(cfg, &(), &mut (), &mut m.nsa, to_nsa);
        let to_occupancy = occupancy::In {
            store_read: store.occupancy_read,
            store_write: store.occupancy_write,
            scan_read: scan.read,
            scan_write: scan.write,
            clear: q.clear,
        };
        Occupancy::next(cfg, &(), &mut (), &mut m.occupancy, to_occupancy);
        let to_sections = sections::In { write: store.place, word: store.word, read: reader.read };
        Sections::next(cfg, &(), &mut (), &mut m.sections, to_sections);
        let to_pool = allocator::In { take: store.take, release: release.front };
        Pool::<A>::next(cfg, &q.pool, &mut d.pool, &mut m.pool, to_pool);
        let to_scanout = scanout::In {
            start: frame_done,
            colour: buffer.back_colour,
            image_ready: i.image_ready,
        };
        let shown = Scanout::next(screen, &q.scanout, &mut d.scanout, &mut m.scanout, to_scanout);
        let to_buffer = frame_buffer::In {
            depth_read: [test.depth_read, lookup.depth_read],
            depth_write: test.depth_write,
            colour_read: blend.colour_read,
            colour_write: [test.colour_write, blend.colour_write],
            back_read: shown.read,
            wipe: shown.wipe,
            clear: q.clear,
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
            phase: q.phase,
            fragment: i.fragment.with(fragment_ready),
            image: scanout.image.with(i.image_ready),
            passed: test.passed.with(store_ready),
            grant: pool.grant.with(store.take),
            release: release.front.with(true),
            pixel: pixel.with(lookup_ready),
            chain: lookup.chain.with(chain.ready),
            arrived: chain.arrived.with(sorter.ready),
            sorted: sorter.sorted.with(true),
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
                chain_begun: reader.begins,
                read: reader.read.valid,
                read_again: reader.read_again,
                culled_late: reader.culled,
                blended: blend.blended,
                scanout: scanout.busy,
                frame_done,
            },
        }
    }
}
