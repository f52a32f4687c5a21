//! The object-order engine: draws opaque primitives, one after the other, into its local frame buffer.
//!
//! ```text
//!                +------+   +--------+   +-----------+
//!  primitive --->| Fifo |-->| Walker |-->| DepthTest |---> done
//!  ready <-------|      |   +--------+   +-----------+
//!                +------+                      | depth, colour
//!                                              v
//!                          swap --->+---------------------+
//!                   read, wipe ---->| FrameBuffer (local) |---> local
//!                                   +---------------------+
//! ```
//! Its frame buffer has two banks. It draws into the front one, while of the back one, which holds the frame
//! before, the image merger reads pixel by pixel and wipes what it has read.

use super::merging_unit::Opaque;
use pellucid_blocks::depth_test::{self, DepthTest};
use pellucid_blocks::frame_buffer::{self, FrameBuffer};
use pellucid_blocks::walker::{self, Walker};
use pellucid_machine::pixel::{Marked, Screen};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_sim::{
    Block, Fifo, Memory, Netlist, ReadPort, Registers, Signals, Stream, WritePort, fifo, rtl,
};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct ObjectEngine;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Set-up and edge walk.
    pub walker: walker::Config,
    /// Primitives that wait for the walk, at least 1.
    pub queue: u32,
}

impl Config {
    fn screen(&self) -> &Screen {
        &self.walker.screen
    }
    fn queue(&self) -> fifo::Config<Format> {
        fifo::Config { depth: self.queue, item: Format::drawn(self.walker.screen) }
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Primitives that wait.
    #[with(cfg.queue)]
    #[block(Queue, cfg.queue())]
    pub queue: fifo::State,
    /// See [`walker`].
    #[with(cfg.walker)]
    #[block(Walker)]
    pub walker: walker::State,
    /// See [`depth_test`].
    #[with(*cfg.screen())]
    #[block(DepthTest)]
    pub depth_test: depth_test::State,
    /// The local frame buffer, see [`frame_buffer`].
    #[with(*cfg.screen())]
    #[block(FrameBuffer)]
    pub local: frame_buffer::State,
    /// The frame is drawn.
    pub done: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Opaque primitives, then the end of the frame.
    #[with(Format::drawn(*cfg))]
    pub primitive: Stream<Marked<Primitive>>,
    /// Reads a pixel of the back bank.
    #[with(cfg.pixel_bits())]
    pub read: ReadPort,
    /// Wipes a pixel of the back bank.
    #[with(cfg.pixel_bits())]
    pub wipe: Stream<u32>,
    /// Wipes a pixel of both banks, after reset.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
    /// The banks change places on the coming edge, and the next frame may come. Only while `done`.
    pub swap: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A primitive is taken.
    pub ready: bool,
    /// The frame is drawn.
    pub done: bool,
    /// The pixel of the back bank that was asked for.
    pub local: Opaque,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// A fragment is drawn.
    pub drawn: bool,
    /// A fragment is hidden.
    pub hidden: bool,
}

/// Whether an engine has something to draw.
pub fn works(q: &State) -> bool {
    let walker = &q.walker;
    q.queue.count > 0 || walker.next.valid || walker.rows.valid || walker.walk.valid
}

/// An engine that draws into a frame buffer of its own.
pub trait Engine:
    Netlist<
        Config: Copy,
        State: Registers<Config = Self::Config>,
        In = In,
        Moore = Moore,
        Out = Out,
    > + Copy
    + 'static
{
}

impl Engine for ObjectEngine {}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Primitives that wait.
    #[block(Queue, cfg.queue())]
    pub queue: <Queue as Block>::Mem,
    /// See [`depth_test`].
    #[block(DepthTest, *cfg.screen())]
    pub depth_test: depth_test::Mem,
    /// The local frame buffer.
    #[block(FrameBuffer, *cfg.screen())]
    pub local: frame_buffer::Mem,
}

type Queue = Fifo<Marked<Primitive>>;

#[rtl(
    input = cfg.walker.screen,
    moore = (),
    output = (),
    check(ObjectEngine, crate::test_util::object_engine(2))
)]
impl Block for ObjectEngine {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let local = FrameBuffer::moore(cfg.screen(), &q.local, &m.local);
        Moore {
            ready: Queue::moore(&cfg.queue(), &q.queue, &m.queue).ready,
            done: q.done,
            local: Opaque { z: local.back_depth.data, colour: local.back_colour.data },
        }
    }

    // It is so much code that one copy of it is enough.
    #[inline(never)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let queued = Queue::moore(&cfg.queue(), &q.queue, &m.queue);
        let fragment = Walker::moore(&cfg.walker, &q.walker, &()).fragment;
        let tested = DepthTest::moore(cfg.screen(), &q.depth_test, &m.depth_test);
        let local = FrameBuffer::moore(cfg.screen(), &q.local, &m.local);

        let to_walker = walker::In { primitive: queued.front, fragment_ready: tested.ready };
        let walked = Walker::next(&cfg.walker, &q.walker, &mut d.walker, &mut (), to_walker);
        let to_queue = fifo::In { push: i.primitive, pop: walked.taken };
        Queue::next(&cfg.queue(), &q.queue, &mut d.queue, &mut m.queue, to_queue);

        let to_test = depth_test::In { fragment, depth: local.depth, passed_ready: true };
        let test = DepthTest::next(
            cfg.screen(),
            &q.depth_test,
            &mut d.depth_test,
            &mut m.depth_test,
            to_test,
        );
        // Of opaque fragments only the end of the frame passes.
        d.done = (q.done && !i.swap) || (tested.stage.valid && tested.stage.payload.end);

        let to_local = frame_buffer::In {
            depth_read: [test.depth_read, ReadPort::default()],
            depth_write: [test.depth_write, WritePort::default()],
            colour_read: ReadPort::default(),
            colour_write: [test.colour_write, WritePort::default()],
            back_depth_read: i.read,
            back_read: i.read,
            wipe: i.wipe,
            clear: i.clear,
            swap: i.swap,
        };
        FrameBuffer::next(cfg.screen(), &q.local, &mut d.local, &mut m.local, to_local);

        Out { drawn: test.drawn, hidden: test.hidden }
    }
}

#[cfg(test)]
mod tests;
