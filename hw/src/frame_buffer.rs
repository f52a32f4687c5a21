//! Depth and colour of every pixel, twice: one bank is drawn into while the other is shown.
//!
//! ```text
//!   front depth  read, write --->+-------------+---> depth
//!   front colour read, write --->|             |---> colour
//!   back colour  read, wipe ---->| FrameBuffer |---> back_colour
//!   clear, swap ---------------->|             |
//!                                +-------------+
//! ```
//! `wipe` sets a pixel of the back bank to the far plane and the background: whoever shows a frame
//! leaves the bank clean, so that drawing never waits for clearing. `clear` does so in both banks;
//! it serves the time after reset.

use crate::pixel::{Screen, Z_BITS, Z_FAR};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort};

/// See the module's description.
pub struct FrameBuffer;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// Bank b is in front.
    pub front_is_b: bool,
}

/// Inputs. In a cycle at most one user asks on each port.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Reads a depth of the front bank: two users.
    pub depth_read: [ReadPort; 2],
    /// Writes a depth of the front bank.
    pub depth_write: WritePort<u32>,
    /// Reads a colour of the front bank.
    pub colour_read: ReadPort,
    /// Writes a colour, `0xRRGGBB`, of the front bank: two users.
    pub colour_write: [WritePort<u32>; 2],
    /// Reads a colour of the back bank.
    pub back_read: ReadPort,
    /// Wipes a pixel of the back bank.
    pub wipe: Stream<u32>,
    /// Wipes a pixel of both banks.
    pub clear: Stream<u32>,
    /// The banks change places on the coming edge.
    pub swap: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// Depth of the front bank.
    pub depth: Read<u32>,
    /// Colour of the front bank.
    pub colour: Read<u32>,
    /// Colour of the back bank.
    pub back_colour: Read<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Depth, bank a.
    pub depth_a: Ram1R1W<u32>,
    /// Depth, bank b.
    pub depth_b: Ram1R1W<u32>,
    /// Colour, bank a.
    pub colour_a: Ram1R1W<u32>,
    /// Colour, bank b.
    pub colour_b: Ram1R1W<u32>,
}

impl Block for FrameBuffer {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Screen) -> State {
        State { front_is_b: false }
    }

    fn memories(cfg: &Screen) -> Mem {
        // A depth is read for the next fragment while the last one's is written: the same pixel
        // twice in a row must see the new depth. No user reads a colour while it is written.
        let depth = || Ram1R1W::new(cfg.pixels(), Z_BITS, 1, ReadDuringWrite::New);
        let colour = || Ram1R1W::new(cfg.pixels(), 24, 1, ReadDuringWrite::Forbidden);
        Mem { depth_a: depth(), depth_b: depth(), colour_a: colour(), colour_b: colour() }
    }

    #[inline(always)]
    fn moore(_: &Screen, q: &State, m: &Self::Mem) -> Moore {
        let (depth, colour, back_colour) = if q.front_is_b {
            (&m.depth_b, &m.colour_b, &m.colour_a)
        } else {
            (&m.depth_a, &m.colour_a, &m.colour_b)
        };
        Moore { depth: depth.q(), colour: colour.q(), back_colour: back_colour.q() }
    }

    #[inline(always)]
    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Self::Mem, i: In) {
        let Mem { depth_a, depth_b, colour_a, colour_b } = m;
        let (front_depth, back_depth, front_colour, back_colour) = if q.front_is_b {
            (depth_b, depth_a, colour_b, colour_a)
        } else {
            (depth_a, depth_b, colour_a, colour_b)
        };
        for user in i.depth_read {
            front_depth.pass_read(user);
        }
        front_depth.pass_write(i.depth_write);
        front_colour.pass_read(i.colour_read);
        for user in i.colour_write {
            front_colour.pass_write(user);
        }
        back_colour.pass_read(i.back_read);
        if i.wipe.valid {
            back_depth.write(i.wipe.payload, Z_FAR);
            back_colour.write(i.wipe.payload, cfg.background);
        }
        if i.clear.valid {
            front_depth.write(i.clear.payload, Z_FAR);
            front_colour.write(i.clear.payload, cfg.background);
            back_depth.write(i.clear.payload, Z_FAR);
            back_colour.write(i.clear.payload, cfg.background);
        }
        d.front_is_b = q.front_is_b ^ i.swap;
    }
}
