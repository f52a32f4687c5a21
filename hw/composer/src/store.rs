//! A fragment store behind the merger: takes the merged image as opaque fragments, then the fragments of the
//! transparent primitives.
//!
//! ```text
//!               +--------------+   +--------+ transparent
//!  primitive -->| DoubleBuffer |-->| Walker |------------+
//!               +--------------+   +--------+            v
//!                                               opaque +---+ fragment +---+
//!  merged -------------------------------------------->|   |--------->| M |--> image
//!                                                      +---+          +---+
//! ```
//! `M` is any machine that takes fragments. Transparent primitives wait while the frame before is composed.
//! Merged pixels come as fragments in raster order, those at the far plane left out; after the last one the
//! primitives go through set-up and edge walk, a fragment a cycle, so that `M` stores none that is hidden. The
//! end of the frame goes when the overhead of its last line has passed, so that no frame ends before its merging.
//! Where it asks for the frame again, the primitives come again: the opaque image is in its frame buffer.

pub mod monitor;

use super::double_buffer::{self, DoubleBuffer};
use super::transparency::{In, Moore};
use pellucid_blocks::front::{Phase, Status};
use pellucid_blocks::walker::{self, Walker};
use pellucid_machine::pixel::{Fragment, Marked, Screen, Z_FAR};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_machine::{FragmentIn, InConfig, Machine};
use pellucid_sim::{Block, Label, Memory, Netlist, Registers, Signals, Stream, rtl};
use std::marker::PhantomData;

/// A machine that can stand behind the merger.
pub trait FragmentStore: Machine<Item = Fragment> + Netlist<Moore = Status> + Copy {}

impl<M: Machine<Item = Fragment> + Netlist<Moore = Status> + Copy> FragmentStore for M {}

/// See the module's description. `M` is the fragment store.
#[derive(Clone, Copy, Debug)]
pub struct Store<M>(PhantomData<M>);

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// Transparent primitives that a frame may have, at least 1.
    pub primitives: u32,
    /// Set-up and edge walk.
    pub walker: walker::Config,
    /// The fragment store, for the same screen.
    pub store: C,
    /// What its parameters have before a dot.
    pub part: &'static str,
}

impl<C> Config<C> {
    fn screen(&self) -> &Screen {
        &self.walker.screen
    }
    fn buffer(&self) -> double_buffer::Config<Format> {
        double_buffer::Config { capacity: self.primitives, item: Format::drawn(*self.screen()) }
    }
}

/// Registers.
#[derive(Clone, Registers)]
#[signals(Config<M::Config>)]
pub struct State<M: FragmentStore> {
    /// The end of the frame that comes in has come.
    pub sorted: bool,
    /// See [`double_buffer`].
    #[with(cfg.primitives)]
    #[block(Primitives, cfg.buffer())]
    pub primitives: double_buffer::State,
    /// A frame is being composed.
    pub composes: bool,
    /// Its merged image is coming.
    pub merges: bool,
    /// It has come, but for the overhead of its last line.
    pub overhead: bool,
    /// The column of the merged pixel that comes next.
    #[width(cfg.screen().x_bits())]
    pub column: u32,
    /// Its row.
    #[width(cfg.screen().y_bits())]
    pub row: u32,
    /// All primitives of the frame and its end went to the walker.
    pub walked: bool,
    /// See [`walker`].
    #[with(cfg.walker)]
    #[block(Walker)]
    pub walker: walker::State,
    /// All fragments of the frame and its end are in the store.
    pub stored: bool,
    /// The fragment store.
    #[with(cfg.store)]
    #[block(M)]
    pub store: M::State,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<M::Config>)]
pub struct Out<M: FragmentStore> {
    /// A primitive for which there is no place.
    #[with(Format::drawn(*cfg.screen()))]
    pub lost: Stream<Primitive>,
    /// What can be seen of the store.
    #[with(cfg.store)]
    pub store: M::Out,
}

/// Memories.
#[derive(Memory)]
#[memory(Config<M::Config>)]
pub struct Mem<M: FragmentStore> {
    /// See [`double_buffer`].
    #[block(Primitives, cfg.buffer())]
    pub primitives: double_buffer::Mem<Primitive>,
    /// The fragment store.
    #[block(M, cfg.store)]
    pub store: M::Mem,
}

type Primitives = DoubleBuffer<Primitive>;

#[rtl(
    input = InConfig { screen: *cfg.screen(), outside: M::port(&cfg.store) },
    moore = *cfg.screen(),
    check(Store<pellucid_rbuffer::RBuffer>, crate::test_util::rbuffer_store(4, Some(7))),
    check(Store<pellucid_rbuffer::RBuffer>, crate::test_util::rbuffer_store(4, None))
)]
impl<M: FragmentStore> Block for Store<M> {
    type Config = Config<M::Config>;
    type State = State<M>;
    type In = In;
    type Moore = Moore;
    type Out = Out<M>;
    type Mem = Mem<M>;

    fn moore(cfg: &Self::Config, q: &State<M>, m: &Self::Mem) -> Moore {
        let shown = M::moore(&cfg.store, &q.store, &m.store);
        Moore {
            ready: !q.sorted,
            sorted: q.sorted,
            merged_ready: shown.ready,
            busy: q.composes,
            waits: q.composes && matches!(shown.phase, Phase::Wait),
            image: shown.image,
            shows: shown.shows,
        }
    }

    // It is so much code that one copy of it is enough.
    #[inline(never)]
    fn next(
        cfg: &Self::Config,
        q: &State<M>,
        d: &mut State<M>,
        m: &mut Self::Mem,
        i: In,
    ) -> Out<M> {
        let shown = M::moore(&cfg.store, &q.store, &m.store);
        let primitives = Primitives::moore(&cfg.buffer(), &q.primitives, &m.primitives);
        let transparent = Walker::moore(&cfg.walker, &q.walker, &()).fragment;

        // Primitives come, to wait for the frame's turn.
        let Marked { end, item } = i.primitive.payload;
        let comes = i.primitive.valid && !q.sorted;
        d.sorted = (q.sorted || (comes && end)) && !i.swap;
        let insert = Stream { valid: comes && !end, payload: item };

        // The merged image.
        let last = i.merged.valid && q.column + 1 == cfg.screen().width;
        let lowest = last && q.row + 1 == cfg.screen().height;
        if i.merged.valid {
            d.column = if last { 0 } else { q.column + 1 };
        }
        if last {
            d.row = if lowest { 0 } else { q.row + 1 };
            d.merges = !lowest;
        }
        d.overhead = (q.overhead || lowest) && !i.line_merged;
        let opaque = Fragment {
            x: q.column,
            y: q.row,
            z: i.merged.payload.z,
            rgba: (i.merged.payload.colour << 8) | 255,
            label: Label::NONE,
        };
        let merged = Stream {
            valid: i.merged.valid && i.merged.payload.z < Z_FAR,
            payload: Marked { end: false, item: opaque },
        };

        // Then the transparent primitives.
        let waits = q.overhead && transparent.payload.end;
        let fragment = if q.merges {
            merged
        } else if waits {
            Stream::idle()
        } else {
            transparent
        };
        let fragment_ready = !q.merges && !waits && shown.ready;
        let stored = transparent.valid && transparent.payload.end && fragment_ready;
        let again = q.stored && shown.replay;
        let ends = q.stored && !shown.replay && matches!(shown.phase, Phase::Idle);
        let offers = q.composes && !q.walked;
        let to_walker = walker::In {
            primitive: Stream {
                valid: offers && (primitives.item.valid || primitives.empty),
                payload: Marked { end: primitives.empty, item: primitives.item.payload },
            },
            fragment_ready,
        };
        let taken = Walker::next(&cfg.walker, &q.walker, &mut d.walker, &mut (), to_walker).taken;
        let to_primitives = double_buffer::In {
            insert,
            swap: i.swap,
            take: offers && taken && primitives.item.valid,
            again,
        };
        Primitives::next(
            &cfg.buffer(),
            &q.primitives,
            &mut d.primitives,
            &mut m.primitives,
            to_primitives,
        );
        d.walked = (q.walked || (offers && taken && primitives.empty)) && !again && !i.swap;
        d.stored = (q.stored || stored) && !again && !ends;
        if ends {
            d.composes = false;
        }
        if i.swap {
            d.composes = true;
            d.merges = true;
        }

        let to_store = FragmentIn { fragment, image_ready: i.image_ready, outside: i.outside };
        let store = M::next(&cfg.store, &q.store, &mut d.store, &mut m.store, to_store);
        Out {
            lost: Stream { valid: insert.valid && primitives.full, payload: insert.payload },
            store,
        }
    }
}

#[cfg(test)]
mod tests;
