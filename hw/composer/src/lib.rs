//! The image composition machine (seed 001): opaque primitives are drawn by several object-order engines at
//! once, their images merged, and the transparent primitives added to the result.
//!
//! ```text
//!                                 +---------------------------+
//!                          opaque | Merger: object-order      | merged
//!               +-------------+-->| engines, each with its    |------->+--------------+
//!  primitive -->| Distributor |   | merging unit              |        | Transparency |--> image
//!               +-------------+   +---------------------------+   +--->|              |
//!                          | transparent                          |    +--------------+
//!                          +--------------------------------------+
//! ```
//! Three frames are in flight: the primitives of one come in, are drawn or sorted into buckets; the images
//! of the one before are merged and its transparent primitives added; the one before that is shown. When the
//! first is drawn and the second complete, the local frame buffers and the buckets change places.

pub mod architecture;
pub mod buckets;
pub mod config;
pub mod distributor;
pub mod double_buffer;
pub mod merger;
pub mod merging_unit;
pub mod monitor;
pub mod object_engine;
pub mod raster;
pub mod scan_line;
pub mod scan_lines;
pub mod store;
pub mod sweep;
pub mod transparency;

#[cfg(test)]
mod test_util;

use distributor::Distributor;
use merger::Merger;
use object_engine::ObjectEngine;
use pellucid_blocks::sequencer::Phase;
use pellucid_machine::pixel::{COLOUR_BITS, Marked, Screen};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_machine::{InConfig, PrimitiveIn};
use pellucid_sim::{Block, Handshake, Memory, Registers, Signals, Stream, rtl};
use std::marker::PhantomData;
use transparency::Transparency;

/// The image composition machine with `T` behind its merger.
pub struct Composer<T>(PhantomData<T>);

/// Parameters, checked: see [`config`].
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// Who gets a primitive.
    pub distributor: distributor::Config,
    /// The object-order engines with the image merger.
    pub merger: merger::Config<object_engine::Config>,
    /// What stands behind it.
    pub transparency: C,
}

impl<C> Config<C> {
    /// The screen.
    pub fn screen(&self) -> &Screen {
        self.merger.shape.screen()
    }
    /// Object-order engines.
    pub fn engines(&self) -> u32 {
        self.merger.shape.engines
    }
}

/// Registers.
#[derive(Clone, Registers)]
#[signals(Config<T::Config>)]
pub struct State<T: Transparency> {
    /// The pixel that is cleared next, after reset.
    #[with(cfg.screen().pixel_bits())]
    #[reset(Stream::offer(0))]
    pub clear: Stream<u32>,
    /// A frame's primitives have begun to go to the engines.
    pub begun: bool,
    /// All of them have gone, its end included: the next frame's must wait.
    pub ended: bool,
    /// See [`distributor`].
    #[with(cfg.distributor)]
    #[block(Distributor)]
    pub distributor: distributor::State,
    /// See [`merger`].
    #[with(cfg.merger)]
    #[block(Merger<ObjectEngine>)]
    pub merger: merger::State<ObjectEngine>,
    /// What stands behind it.
    #[with(cfg.transparency)]
    #[block(T)]
    pub transparency: T::State,
}

/// What can be seen of the machine in a cycle.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct Out<T: Transparency> {
    /// What the machine is at.
    pub phase: Phase,
    /// Primitives come in, then the end of the frame.
    #[with(Format::whole(*cfg.screen()))]
    pub primitive: Handshake<Marked<Primitive>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Handshake<u32>,
    /// What the engines and the merger did.
    #[with(cfg.merger.shape)]
    pub merger: merger::Out,
    /// What was done behind them.
    #[with(cfg.transparency)]
    pub transparency: T::Out,
    /// A frame is being drawn and sorted.
    pub draws: bool,
    /// A frame is being merged.
    pub merges: bool,
    /// A frame is being composed.
    pub composes: bool,
    /// An image is being shown.
    pub shows: bool,
    /// Local frame buffers and buckets change places.
    pub swap: bool,
}

/// Memories.
#[derive(Memory)]
#[memory(Config<T::Config>)]
pub struct Mem<T: Transparency> {
    /// See [`merger`].
    #[block(Merger<ObjectEngine>, cfg.merger)]
    pub merger: merger::Mem<ObjectEngine>,
    /// What stands behind it.
    #[block(T, cfg.transparency)]
    pub transparency: T::Mem,
}

#[rtl(
    name = "composer",
    input = InConfig { screen: *cfg.screen(), outside: T::port(&cfg.transparency) },
    check(Composer<scan_lines::ScanLines>, crate::test_util::composer(1, 1)),
    check(Composer<scan_lines::ScanLines>, crate::test_util::composer(3, 2))
)]
impl<T: Transparency> Block for Composer<T> {
    type Config = Config<T::Config>;
    type State = State<T>;
    type In = PrimitiveIn;
    type Moore = ();
    type Out = Out<T>;
    type Mem = Mem<T>;

    fn moore(_: &Self::Config, _: &State<T>, _: &Self::Mem) {}

    // It is so much code that one copy of it is enough.
    #[inline(never)]
    fn next(
        cfg: &Self::Config,
        q: &State<T>,
        d: &mut State<T>,
        m: &mut Self::Mem,
        i: PrimitiveIn,
    ) -> Out<T> {
        // What every block shows before its inputs are known.
        let given = Distributor::moore(&cfg.distributor, &q.distributor, &());
        let behind = T::moore(&cfg.transparency, &q.transparency, &m.transparency);
        let merger = Merger::<ObjectEngine>::moore(&cfg.merger, &q.merger, &m.merger);

        // After reset all memories are cleared, a pixel a cycle.
        let clears = q.clear.valid;
        if clears {
            let last = q.clear.payload + 1 == cfg.screen().pixels();
            d.clear = if last { Stream::idle() } else { Stream::offer(q.clear.payload + 1) };
        }

        // From frame to frame.
        let complete = q.ended && merger.done && behind.sorted;
        let swap = complete && !behind.busy && !merger.busy;

        // Primitives to whom they are for, until the end of the frame, which all take at once.
        let Marked { end, .. } = given.item.payload;
        let offered = given.item.valid && !q.ended;
        let to_merger = merger::In {
            primitive: Stream {
                valid: offered && (given.to_engine || (end && behind.ready)),
                payload: given.item.payload,
            },
            engine: given.engine,
            swap,
            clear: q.clear,
            merged_ready: behind.merged_ready,
        };
        let merged = Merger::<ObjectEngine>::next(
            &cfg.merger,
            &q.merger,
            &mut d.merger,
            &mut m.merger,
            to_merger,
        );
        let transparent = offered && !end && !given.to_engine && behind.ready;
        let goes = merged.taken || transparent;
        let to_distributor = distributor::In {
            primitive: Stream { valid: i.primitive.valid && !clears, payload: i.primitive.payload },
            taken: goes,
        };
        let distributed = Distributor::next(
            &cfg.distributor,
            &q.distributor,
            &mut d.distributor,
            &mut (),
            to_distributor,
        );
        d.begun = (q.begun && !swap) || goes;
        d.ended = (q.ended && !swap) || (goes && end);

        let to_transparency = transparency::In {
            primitive: Stream { valid: transparent || (goes && end), payload: given.item.payload },
            swap,
            merged: Stream {
                valid: merged.merged.valid && merged.merged.ready,
                payload: merged.merged.payload,
            },
            line_merged: merged.line_done,
            image_ready: i.image_ready,
            clear: q.clear,
            outside: i.outside,
        };
        let transparency = T::next(
            &cfg.transparency,
            &q.transparency,
            &mut d.transparency,
            &mut m.transparency,
            to_transparency,
        );

        let (comes, composes) = (q.begun || given.item.valid, merger.busy || behind.busy);
        let first = i.primitive.valid && distributed.ready;
        let phase = if clears {
            Phase::Clear
        } else if behind.waits {
            Phase::Wait
        } else if composes {
            Phase::Resolve
        } else if comes || first {
            Phase::Store
        } else {
            Phase::Idle
        };
        Out {
            phase,
            primitive: i.primitive.with(distributed.ready && !clears),
            image: behind.image.with(i.image_ready),
            merger: merged,
            transparency,
            draws: comes && !complete,
            merges: merger.busy,
            composes,
            shows: behind.shows,
            swap,
        }
    }
}

#[cfg(test)]
mod tests;
