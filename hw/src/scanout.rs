//! Shows a finished frame: sends the back bank's colours pixel by pixel and leaves the bank wiped.
//!
//! ```text
//!             +---------+
//!  start ---->|         |---> image (Stream of colours)
//!  colour --->| Scanout |<--- image_ready
//!             |         |---> read, wipe (back bank)
//!  busy <-----+---------+
//! ```
//! One pixel a cycle, row by row from the top left; the first leaves two cycles after `start`. It
//! stalls with its receiver and loses nothing.

use crate::pixel::Screen;
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, fifo};

/// See the module's description.
pub struct Scanout;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for a frame.
    Idle,
    /// Reading pixels.
    Run,
    /// All pixels are read; the last ones leave.
    Drain,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The next pixel to read.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// The pixel whose colour was asked for: it arrives now and is wiped now.
    #[with(cfg.pixel_bits())]
    pub asked: Stream<u32>,
    /// Colours on their way out.
    #[with(QUEUE_DEPTH)]
    pub queue: fifo::State,
}

const QUEUE_DEPTH: u32 = 3;
const COLOUR_BITS: u32 = 24;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// A frame is in the back bank from the next cycle on. Only while not `busy`.
    pub start: bool,
    /// The colour that was asked for.
    pub colour: Read<u32>,
    /// The receiver takes a colour.
    pub image_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// The colours, `0xRRGGBB`.
    pub image: Stream<u32>,
    /// A frame is being shown.
    pub busy: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Out {
    /// Reads a colour of the back bank.
    pub read: ReadPort,
    /// Wipes a pixel of the back bank.
    pub wipe: Stream<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Colours on their way out.
    pub queue: <Fifo<u32> as Block>::Mem,
}

fn queue() -> fifo::Config<u32> {
    fifo::Config { depth: QUEUE_DEPTH, item: COLOUR_BITS }
}

impl Block for Scanout {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(_: &Screen) -> State {
        let queue = Fifo::<u32>::reset(&queue());
        State { fsm: Fsm::Idle, pixel: 0, asked: Stream::idle(), queue }
    }

    fn memories(_: &Screen) -> Mem {
        Mem { queue: Fifo::<u32>::memories(&queue()) }
    }

    #[inline(always)]
    fn moore(_: &Screen, q: &State, m: &Self::Mem) -> Moore {
        let image = Fifo::<u32>::moore(&queue(), &q.queue, &m.queue).front;
        Moore { image, busy: q.fsm != Fsm::Idle }
    }

    #[inline(always)]
    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let mut read = ReadPort::default();
        d.asked.valid = false;
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Run;
                    d.pixel = 0;
                }
            }
            Fsm::Run => {
                // What was asked for finds room, and so must what is asked for now.
                if q.queue.count + u32::from(q.asked.valid) < QUEUE_DEPTH {
                    read.read(q.pixel);
                    d.asked = Stream::offer(q.pixel);
                    if q.pixel == cfg.pixels() - 1 {
                        d.fsm = Fsm::Drain;
                    } else {
                        d.pixel = q.pixel + 1;
                    }
                }
            }
            Fsm::Drain => {
                if q.queue.count == 0 && !q.asked.valid {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        let push = Stream { valid: q.asked.valid, payload: i.colour.data };
        let to_queue = fifo::In { push, pop: i.image_ready };
        Fifo::next(&queue(), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        Out { read, wipe: q.asked }
    }
}
