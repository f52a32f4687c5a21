//! The early depth test: draws opaque fragments, drops hidden ones, passes transparent ones on.
//!
//! ```text
//!                    +-----------+
//!  fragment -------->|           |---> passed (transparent, in front)
//!  ready <-----------| DepthTest |<--- passed_ready
//!  depth data ------>|           |---> depth read / write, colour write
//!                    +-----------+
//! ```
//! One fragment a cycle; two cycles from input to output. A fragment passes if it is nearer than the
//! depth that its pixel holds, so of two equal opaque ones the first stays. A transparent fragment
//! that passes here may still be hidden by a later opaque one: whoever reads it back tests again.

use crate::pixel::{Fragment, Marked, PixelFragment, Screen};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, WritePort, fifo};

/// See the module's description.
pub struct DepthTest;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// Fragments that arrived.
    #[with(QUEUE_DEPTH)]
    pub queue: fifo::State,
    /// The fragment whose pixel's depth was asked for.
    #[with(*cfg)]
    pub stage: Stream<Marked<PixelFragment>>,
}

const QUEUE_DEPTH: u32 = 2;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Fragments in arrival order, then the end of the frame.
    pub fragment: Stream<Marked<Fragment>>,
    /// The depth that was asked for.
    pub depth: Read<u32>,
    /// The receiver of `passed` is ready.
    pub passed_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Out {
    /// Reads a pixel's depth.
    pub depth_read: ReadPort,
    /// Writes a pixel's depth.
    pub depth_write: WritePort<u32>,
    /// Writes a pixel's colour, `0xRRGGBB`.
    pub colour_write: WritePort<u32>,
    /// Transparent fragments in front, in order, then the end of the frame.
    pub passed: Stream<Marked<PixelFragment>>,
    /// An opaque fragment is drawn in this cycle.
    pub drawn: bool,
    /// An opaque fragment is dropped in this cycle: it is hidden.
    pub hidden: bool,
    /// A transparent fragment is dropped in this cycle: it is hidden.
    pub culled: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Fragments that arrived.
    pub queue: <Fifo<Marked<Fragment>> as Block>::Mem,
}

fn queue(cfg: &Screen) -> fifo::Config<Screen> {
    fifo::Config { depth: QUEUE_DEPTH, item: *cfg }
}

impl Block for DepthTest {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Screen) -> State {
        State { queue: Fifo::<Marked<Fragment>>::reset(&queue(cfg)), stage: Stream::idle() }
    }

    fn memories(cfg: &Screen) -> Mem {
        Mem { queue: Fifo::<Marked<Fragment>>::memories(&queue(cfg)) }
    }

    #[inline(always)]
    fn moore(cfg: &Screen, q: &State, m: &Self::Mem) -> Moore {
        Moore { ready: Fifo::moore(&queue(cfg), &q.queue, &m.queue).ready }
    }

    #[inline(always)]
    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (mut depth_read, mut depth_write) = (ReadPort::default(), WritePort::default());
        let mut colour_write = WritePort::default();

        // Second stage: the pixel's depth is at hand.
        let end = q.stage.valid && q.stage.payload.end;
        let f = q.stage.payload.item;
        let fragment = q.stage.valid && !end;
        let opaque = f.rgba & 0xff == 0xff;
        let nearer = f.z < i.depth.data;
        let pass = end || (fragment && !opaque && nearer);
        let stall = pass && !i.passed_ready;
        let drawn = fragment && opaque && nearer;
        if drawn {
            depth_write.write(f.pixel, f.z);
            colour_write.write(f.pixel, f.rgba >> 8);
        }

        // First stage: ask for the depth of the next fragment's pixel.
        let front = Fifo::moore(&queue(cfg), &q.queue, &m.queue).front;
        if !stall {
            let Fragment { x, y, z, rgba } = front.payload.item;
            let item = PixelFragment { pixel: y * cfg.width + x, z, rgba };
            d.stage =
                Stream { valid: front.valid, payload: Marked { end: front.payload.end, item } };
            if front.valid && !front.payload.end {
                depth_read.read(item.pixel);
            }
        }
        let to_queue = fifo::In { push: i.fragment, pop: !stall };
        Fifo::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);

        Out {
            depth_read,
            depth_write,
            colour_write,
            passed: Stream { valid: pass, payload: q.stage.payload },
            drawn,
            hidden: fragment && opaque && !nearer,
            culled: fragment && !opaque && !nearer,
        }
    }
}
