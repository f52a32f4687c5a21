//! The lookup: from a pixel to its chain of sections and its opaque depth.
//!
//! ```text
//!             +--------+
//!  pixel ---->|        |---> chain (Stream), then the end of the frame
//!  ready <----| Lookup |<--- chain_ready
//!  entry ---->|        |---> SSA read, write
//!  depth ---->|        |---> depth read
//!             +--------+
//! ```
//! One pixel a cycle. A pixel without fragments is passed over; the SSA entry of any other is set to
//! NULL as it leaves, so that the next frame finds a clean table.

use super::config::Config;
use super::tables::SsaEntry;
use crate::pixel::{Marked, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, WritePort, fifo};

/// See the module's description.
pub struct Lookup;

/// A pixel's chain of sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Chain {
    /// The pixel.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// Its opaque depth.
    #[width(Z_BITS)]
    pub depth: u32,
    /// Its SSA entry.
    #[with(*cfg)]
    pub entry: SsaEntry,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Pixels that arrived.
    #[with(QUEUE_DEPTH)]
    pub queue: fifo::State,
    /// The pixel whose entry was asked for.
    #[with(cfg.screen.pixel_bits())]
    pub stage: Stream<Marked<u32>>,
}

const QUEUE_DEPTH: u32 = 2;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Pixels to visit, then the end of the frame.
    pub pixel: Stream<Marked<u32>>,
    /// The SSA entry that was asked for.
    pub ssa: Read<SsaEntry>,
    /// The depth that was asked for.
    pub depth: Read<u32>,
    /// The receiver takes a chain.
    pub chain_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// A pixel is taken.
    pub ready: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug)]
pub struct Out {
    /// Reads an SSA entry.
    pub ssa_read: ReadPort,
    /// Sets an SSA entry to NULL.
    pub ssa_write: WritePort<SsaEntry>,
    /// Reads a pixel's opaque depth.
    pub depth_read: ReadPort,
    /// Chains, then the end of the frame.
    pub chain: Stream<Marked<Chain>>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Pixels that arrived.
    pub queue: <Fifo<Marked<u32>> as Block>::Mem,
}

fn queue(cfg: &Config) -> fifo::Config<u32> {
    fifo::Config { depth: QUEUE_DEPTH, item: cfg.screen.pixel_bits() }
}

impl Block for Lookup {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State { queue: Fifo::<Marked<u32>>::reset(&queue(cfg)), stage: Stream::idle() }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { queue: Fifo::<Marked<u32>>::memories(&queue(cfg)) }
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        Moore { ready: Fifo::<Marked<u32>>::moore(&queue(cfg), &q.queue, &m.queue).ready }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (mut ssa_read, mut ssa_write) = (ReadPort::default(), WritePort::default());
        let mut depth_read = ReadPort::default();

        // Second stage: the pixel's entry and depth are at hand.
        let Marked { end, item: pixel } = q.stage.payload;
        let found = q.stage.valid && (end || i.ssa.data.head != cfg.null);
        let stall = found && !i.chain_ready;
        if found && !end && i.chain_ready {
            ssa_write.write(pixel, SsaEntry::null(cfg));
        }
        let chain = Chain { pixel, depth: i.depth.data, entry: i.ssa.data };

        // First stage: ask for those of the next pixel.
        let front = Fifo::<Marked<u32>>::moore(&queue(cfg), &q.queue, &m.queue).front;
        if !stall {
            d.stage = front;
            if front.valid && !front.payload.end {
                ssa_read.read(front.payload.item);
                depth_read.read(front.payload.item);
            }
        }
        let to_queue = fifo::In { push: i.pixel, pop: !stall };
        Fifo::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        let chain = Stream { valid: found, payload: Marked { end, item: chain } };
        Out { ssa_read, ssa_write, depth_read, chain }
    }
}
