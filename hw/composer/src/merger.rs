//! The processing elements in a line: each an engine with its merging unit. Together the units are the pipelined
//! image merger.
//!
//! ```text
//!  primitive ---->+--------+    +--------+           +--------+
//!  taken <--------| Engine |    | Engine |    ...    | Engine |
//!                 +--------+    +--------+           +--------+
//!                  |      ^      |      ^             |      ^
//!             local| read,|      |      |             |      |
//!                  v wipe |      v      |             v      |
//!    +--------+   +-------------+  +-------------+  +-------------+   +--------+
//!  ->| Raster |-->| MergingUnit |->| MergingUnit |->| MergingUnit |-->| Raster |--> merged (Stream)
//!    +--------+   +-------------+  +-------------+  +-------------+   +--------+
//! ```
//! While the engines draw one frame, the image of the one before goes through the units, which are fed with
//! the far plane and the background: in raster order, a pixel a cycle, with `beta` cycles of overhead after
//! each scan line. Unless its receiver stalls it, that takes exactly
//! `(width + beta) * height + 4 * engines` cycles.

use super::merging_unit::{self, MergingUnit, Opaque};
use super::object_engine::{self, Engine};
use super::raster::{self, Raster};
use pellucid_machine::pixel::{Marked, Screen, Z_FAR};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_sim::{
    Block, Handshake, Memory, Registers, Signals, Stream, bits_for, check_range, rtl,
};
use std::marker::PhantomData;

/// See the module's description. `E` is the engines.
pub struct Merger<E>(PhantomData<E>);

/// How long the line is, and what goes through it.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// How many elements there are, at least 1.
    pub engines: u32,
    /// The screen, and the overhead of its scan lines.
    pub raster: raster::Config,
}

impl Shape {
    /// The screen.
    pub fn screen(&self) -> &Screen {
        &self.raster.screen
    }
    /// Bits of an engine's number.
    pub fn engine_bits(&self) -> u32 {
        bits_for(u64::from(self.engines - 1))
    }
    fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.engines))
    }
}

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// The line.
    pub shape: Shape,
    /// Each engine.
    pub engine: C,
}

/// Registers.
#[derive(Clone, Registers)]
#[signals(Config<E::Config>)]
pub struct State<E: Engine> {
    /// Pixels that enter the line.
    #[with(cfg.shape.raster)]
    pub head: raster::State,
    /// The merging units.
    #[with(*cfg.shape.screen())]
    #[len(cfg.shape.engines)]
    pub units: Vec<merging_unit::State>,
    /// The engines.
    #[with(cfg.engine)]
    #[len(cfg.shape.engines)]
    pub engines: Vec<E::State>,
    /// Pixels that leave the line.
    #[with(cfg.shape.raster)]
    pub tail: raster::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Shape)]
pub struct In {
    /// A primitive for one of the engines, or the end of the frame for all.
    #[with(Format::drawn(*cfg.screen()))]
    pub primitive: Stream<Marked<Primitive>>,
    /// Which engine.
    #[width(cfg.engine_bits())]
    pub engine: u32,
    /// The frame that was drawn is merged from now on, and the next one may come. Only while all is `done` and
    /// nothing is merged.
    pub swap: bool,
    /// Wipes a pixel of all frame buffers, after reset.
    #[with(cfg.screen().pixel_bits())]
    pub clear: Stream<u32>,
    /// The receiver takes a merged pixel.
    pub merged_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The frame is drawn.
    pub done: bool,
    /// A frame is being merged.
    pub busy: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Shape)]
pub struct Out {
    /// The primitive is taken.
    pub taken: bool,
    /// The merged image in raster order.
    pub merged: Handshake<Opaque>,
    /// A scan line of it is complete, its overhead included.
    pub line_done: bool,
    /// The image is.
    pub frame_done: bool,
    /// Engines that drew a fragment.
    #[width(cfg.count_bits())]
    pub drawn: u32,
    /// Engines that dropped a hidden fragment.
    #[width(cfg.count_bits())]
    pub hidden: u32,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<E: Engine> {
    /// The engines.
    pub engines: Vec<E::Mem>,
}

#[rtl(
    input = cfg.shape,
    moore = (),
    output = cfg.shape,
    check(Merger<object_engine::ObjectEngine>, crate::test_util::merger(1, 0)),
    check(Merger<object_engine::ObjectEngine>, crate::test_util::merger(3, 2))
)]
impl<E: Engine> Block for Merger<E> {
    type Config = Config<E::Config>;
    type State = State<E>;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem<E>;

    fn reset(cfg: &Self::Config) -> State<E> {
        check_range("the number of engines of a merger", cfg.shape.engines, 1..);
        let engines = cfg.shape.engines as usize;
        State {
            head: Raster::reset(&cfg.shape.raster),
            units: vec![MergingUnit::reset(cfg.shape.screen()); engines],
            engines: vec![E::reset(&cfg.engine); engines],
            tail: Raster::reset(&cfg.shape.raster),
        }
    }

    fn memories(cfg: &Self::Config) -> Mem<E> {
        Mem { engines: (0..cfg.shape.engines).map(|_| E::memories(&cfg.engine)).collect() }
    }

    fn moore(cfg: &Self::Config, q: &State<E>, m: &Self::Mem) -> Moore {
        let mut done = true;
        for k in 0..cfg.shape.engines as usize {
            done &= E::moore(&cfg.engine, &q.engines[k], &m.engines[k]).done;
        }
        Moore { done, busy: Raster::moore(&cfg.shape.raster, &q.tail, &()).runs }
    }

    // It is so much code that one copy of it is enough.
    #[inline(never)]
    fn next(cfg: &Self::Config, q: &State<E>, d: &mut State<E>, m: &mut Self::Mem, i: In) -> Out {
        // Whoever is to have the primitive must be ready: one engine, or all at the end of a frame.
        let end = i.primitive.payload.end;
        let mut ready = true;
        for k in 0..cfg.shape.engines {
            let engine = E::moore(&cfg.engine, &q.engines[k as usize], &m.engines[k as usize]);
            ready &= engine.ready || !(end || i.engine == k);
        }
        let taken = i.primitive.valid && ready;

        let head = Raster::moore(&cfg.shape.raster, &q.head, &());
        let first = MergingUnit::moore(cfg.shape.screen(), &q.units[0], &());
        let to_head = raster::In { start: i.swap, moves: head.pixel && first.ready };
        Raster::next(&cfg.shape.raster, &q.head, &mut d.head, &mut (), to_head);

        let tail = Raster::moore(&cfg.shape.raster, &q.tail, &());
        let far = Opaque { z: Z_FAR, colour: cfg.shape.screen().background };
        let mut upstream = Stream { valid: head.pixel, payload: far };
        let (mut drawn, mut hidden) = (0, 0);
        for k in 0..cfg.shape.engines {
            let merged_ready = if k + 1 < cfg.shape.engines {
                MergingUnit::moore(cfg.shape.screen(), &q.units[k as usize + 1], &()).ready
            } else {
                tail.pixel && i.merged_ready
            };
            let local = E::moore(&cfg.engine, &q.engines[k as usize], &m.engines[k as usize]).local;
            let unit = MergingUnit::moore(cfg.shape.screen(), &q.units[k as usize], &());
            let to_unit = merging_unit::In { upstream, local, merged_ready };
            let asked = MergingUnit::next(
                cfg.shape.screen(),
                &q.units[k as usize],
                &mut d.units[k as usize],
                &mut (),
                to_unit,
            );
            upstream = unit.merged;

            let own = end || i.engine == k;
            let to_engine = object_engine::In {
                primitive: Stream { valid: taken && own, payload: i.primitive.payload },
                read: asked.read,
                wipe: asked.wipe,
                clear: i.clear,
                swap: i.swap,
            };
            let did = E::next(
                &cfg.engine,
                &q.engines[k as usize],
                &mut d.engines[k as usize],
                &mut m.engines[k as usize],
                to_engine,
            );
            drawn += u32::from(did.drawn);
            hidden += u32::from(did.hidden);
        }

        let merged = Stream { valid: upstream.valid && tail.pixel, payload: upstream.payload };
        let to_tail = raster::In { start: i.swap, moves: merged.valid && i.merged_ready };
        let counted = Raster::next(&cfg.shape.raster, &q.tail, &mut d.tail, &mut (), to_tail);
        Out {
            taken,
            merged: merged.with(i.merged_ready),
            line_done: counted.line_done,
            frame_done: counted.frame_done,
            drawn,
            hidden,
        }
    }
}

#[cfg(test)]
mod tests;
