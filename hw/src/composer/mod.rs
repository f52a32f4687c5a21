//! The image composition machine (seed 001): opaque primitives are drawn by several object-order engines at
//! once, their images merged, and the transparent primitives added to the result.
//!
//! ```text
//!                               +--------------+ local images +--------+ merged +--------------+
//!                  opaque +---->| ObjectEngine |------------->| Merger |------->| Transparency |--> image
//!               +-------------+ +--------------+              |        |        |              |
//!  primitive -->| Distributor | | ObjectEngine |------------->|        |        |              |
//!               +-------------+ +--------------+              |        |        |              |
//!             transparent |     | ...          |------------->|        |        |              |
//!                         |     +--------------+              +--------+        |              |
//!                         +---------------------------------------------------->|              |
//!                                                                               +--------------+
//! ```
//! Three frames are in flight: the primitives of one come in, are drawn or sorted into buckets; the images
//! of the one before are merged and its transparent primitives added; the one before that is shown. When the
//! first is drawn and the second complete, the local frame buffers and the buckets change places.

pub mod buckets;
pub mod config;
pub mod distributor;
pub mod merger;
pub mod merging_unit;
pub mod monitor;
pub mod object_engine;
pub mod raster;
pub mod scan_line;
pub mod scan_lines;
pub mod sweep;
pub mod transparency;
pub mod walker;

use crate::machine::{Phase, PrimitiveFrame};
use crate::pixel::{COLOUR_BITS, Marked, Screen};
use crate::primitive::Primitive;
use distributor::Distributor;
use merger::Merger;
use merging_unit::Opaque;
use object_engine::ObjectEngine;
use pellucid_sim::{Block, Handshake, Memory, Signals, Stream, rtl};
use std::marker::PhantomData;
use transparency::Transparency;

/// The image composition machine with at most `N` object-order engines and `T` behind its merger.
pub struct Composer<const N: usize, T>(PhantomData<T>);

/// Parameters, checked: see [`config`].
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// Who gets a primitive.
    pub distributor: distributor::Config,
    /// Each object-order engine.
    pub engine: object_engine::Config,
    /// The image merger.
    pub merger: merger::Config,
    /// What stands behind it.
    pub transparency: C,
}

impl<C> Config<C> {
    /// The screen.
    pub fn screen(&self) -> &Screen {
        &self.merger.raster.screen
    }
    /// Object-order engines.
    pub fn engines(&self) -> u32 {
        self.merger.engines
    }
}

/// Registers.
#[derive(Clone, Copy, Signals)]
#[signals(Config<T::Config>)]
pub struct State<const N: usize, T: Transparency> {
    /// The pixel that is cleared next, after reset.
    #[with(cfg.screen().pixel_bits())]
    pub clear: Stream<u32>,
    /// A frame's primitives have begun to go to the engines.
    pub begun: bool,
    /// All of them have gone, its end included: the next frame's must wait.
    pub ended: bool,
    /// See [`distributor`].
    #[with(cfg.distributor)]
    pub distributor: distributor::State<N>,
    /// The object-order engines.
    #[with(cfg.engine)]
    #[len(cfg.engines())]
    pub engines: [object_engine::State; N],
    /// See [`merger`].
    #[with(cfg.merger)]
    pub merger: merger::State<N>,
    /// What stands behind it.
    #[with(cfg.transparency)]
    pub transparency: T::State,
}

/// What can be seen of the machine in a cycle.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct Out<const N: usize, T: Transparency> {
    /// What the machine is at.
    pub phase: Phase,
    /// Primitives come in, then the end of the frame.
    #[with(*cfg.screen())]
    pub primitive: Handshake<Marked<Primitive>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Handshake<u32>,
    /// The merged opaque image.
    pub merged: Handshake<Opaque>,
    /// What each object-order engine did.
    #[len(cfg.engines())]
    pub engines: [object_engine::Out; N],
    /// What was done behind the merger.
    #[with(cfg.transparency)]
    pub transparency: T::Out,
    /// A frame is being drawn and sorted.
    pub draws: bool,
    /// A frame is being merged.
    pub merges: bool,
    /// A line of it is complete.
    pub line_merged: bool,
    /// A frame is being composed.
    pub composes: bool,
    /// An image is being shown.
    pub shows: bool,
    /// Local frame buffers and buckets change places.
    pub swap: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<T: Transparency> {
    /// The object-order engines.
    pub engines: Vec<object_engine::Mem>,
    /// What stands behind the merger.
    pub transparency: T::Mem,
}

#[rtl(
    name = "composer",
    input = *cfg.screen(),
    check(Composer<2, scan_lines::ScanLines<2>>, crate::test_util::composer(1, 1)),
    check(Composer<4, scan_lines::ScanLines<2>>, crate::test_util::composer(3, 2))
)]
impl<const N: usize, T: Transparency> Block for Composer<N, T> {
    type Config = Config<T::Config>;
    type State = State<N, T>;
    type In = PrimitiveFrame;
    type Moore = ();
    type Out = Out<N, T>;
    type Mem = Mem<T>;

    fn reset(cfg: &Self::Config) -> State<N, T> {
        State {
            clear: Stream::offer(0),
            begun: false,
            ended: false,
            distributor: Distributor::reset(&cfg.distributor),
            engines: [ObjectEngine::reset(&cfg.engine); N],
            merger: Merger::reset(&cfg.merger),
            transparency: T::reset(&cfg.transparency),
        }
    }

    fn memories(cfg: &Self::Config) -> Mem<T> {
        Mem {
            engines: (0..cfg.engines()).map(|_| ObjectEngine::memories(&cfg.engine)).collect(),
            transparency: T::memories(&cfg.transparency),
        }
    }

    fn moore(_: &Self::Config, _: &State<N, T>, _: &Self::Mem) {}

    #[inline(never)]
    fn next(
        cfg: &Self::Config,
        q: &State<N, T>,
        d: &mut State<N, T>,
        m: &mut Self::Mem,
        i: PrimitiveFrame,
    ) -> Out<N, T> {
        // What every block shows before its inputs are known.
        let given = Distributor::<N>::moore(&cfg.distributor, &q.distributor, &());
        let behind = T::moore(&cfg.transparency, &q.transparency, &m.transparency);
        let merger = Merger::<N>::moore(&cfg.merger, &q.merger, &());
        let mut local = [Opaque::default(); N];
        let (mut all_ready, mut all_done, mut engine_ready) = (behind.ready, true, false);
        for k in 0..cfg.engines() {
            let engine =
                ObjectEngine::moore(&cfg.engine, &q.engines[k as usize], &m.engines[k as usize]);
            local[k as usize] = engine.local;
            all_ready &= engine.ready;
            all_done &= engine.done;
            if given.engine == k {
                engine_ready = engine.ready;
            }
        }

        // After reset all memories are cleared, a pixel a cycle.
        let clears = q.clear.valid;
        if clears {
            let last = q.clear.payload + 1 == cfg.screen().pixels();
            d.clear = if last { Stream::idle() } else { Stream::offer(q.clear.payload + 1) };
        }

        // From frame to frame.
        let swap = q.ended && all_done && behind.sorted && !behind.busy && !merger.busy;

        // Primitives to whom they are for, until the end of the frame.
        let Marked { end, .. } = given.item.payload;
        let ready = if end {
            all_ready
        } else if given.to_engine {
            engine_ready
        } else {
            behind.ready
        };
        let goes = given.item.valid && ready && !q.ended;
        let to_distributor = distributor::In {
            primitive: Stream { valid: i.primitive.valid && !clears, payload: i.primitive.payload },
            taken: ready && !q.ended,
        };
        let distributed = Distributor::<N>::next(
            &cfg.distributor,
            &q.distributor,
            &mut d.distributor,
            &mut (),
            to_distributor,
        );
        d.begun = (q.begun && !swap) || goes;
        d.ended = (q.ended && !swap) || (goes && end);

        // The images of the frame before are merged.
        let to_merger = merger::In { start: swap, local, merged_ready: behind.merged_ready };
        let merged = Merger::<N>::next(&cfg.merger, &q.merger, &mut d.merger, &mut (), to_merger);

        // The engines draw.
        let mut engines = [object_engine::Out::default(); N];
        for k in 0..cfg.engines() {
            let own = end || (given.to_engine && given.engine == k);
            let to_engine = object_engine::In {
                primitive: Stream { valid: goes && own, payload: given.item.payload },
                read: merged.read[k as usize],
                wipe: merged.wipe[k as usize],
                clear: q.clear,
                swap,
            };
            engines[k as usize] = ObjectEngine::next(
                &cfg.engine,
                &q.engines[k as usize],
                &mut d.engines[k as usize],
                &mut m.engines[k as usize],
                to_engine,
            );
        }

        let to_transparency = transparency::In {
            primitive: Stream {
                valid: goes && (end || !given.to_engine),
                payload: given.item.payload,
            },
            swap,
            merged: Stream {
                valid: merged.merged.valid && merged.merged.ready,
                payload: merged.merged.payload,
            },
            line_merged: merged.line_done,
            image_ready: i.image_ready,
            clear: q.clear,
        };
        let transparency = T::next(
            &cfg.transparency,
            &q.transparency,
            &mut d.transparency,
            &mut m.transparency,
            to_transparency,
        );

        let (draws, composes) = (q.begun || given.item.valid, merger.busy || behind.busy);
        let phase = if clears {
            Phase::Clear
        } else if behind.waits {
            Phase::Wait
        } else if composes {
            Phase::Resolve
        } else if draws {
            Phase::Store
        } else {
            Phase::Idle
        };
        Out {
            phase,
            primitive: i.primitive.with(distributed.ready && !clears),
            image: behind.image.with(i.image_ready),
            merged: merged.merged,
            engines,
            transparency,
            draws,
            merges: merger.busy,
            line_merged: merged.line_done,
            composes,
            shows: behind.shows,
            swap,
        }
    }
}

#[cfg(test)]
mod tests;
