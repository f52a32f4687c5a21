//! Depth and colour of every pixel, twice: one bank is drawn into while the other is shown.
//!
//! ```text
//!   front depth  read, write --->+-------------+---> depth
//!   front colour read, write --->|             |---> colour
//!   back depth   read ---------->| FrameBuffer |---> back_depth
//!   back colour  read, wipe ---->|             |---> back_colour
//!   clear, swap ---------------->|             |
//!                                +-------------+
//! ```
//! `wipe` sets a pixel of the back bank to the far plane and the background: whoever shows a frame
//! leaves the bank clean, so that drawing never waits for clearing. `clear` does so in both banks;
//! it serves the time after reset.

use pellucid_machine::pixel::{COLOUR_BITS, Screen, Z_BITS, Z_FAR};
use pellucid_sim::Block;
use pellucid_sim::{
    Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort, rtl,
};

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
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Reads a depth of the front bank: two users.
    #[with(cfg.pixel_bits())]
    pub depth_read: [ReadPort; 2],
    /// Writes a depth of the front bank: two users.
    #[with(cfg.pixel_bits(), Z_BITS)]
    pub depth_write: [WritePort<u32>; 2],
    /// Reads a colour of the front bank.
    #[with(cfg.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes a colour, `0xRRGGBB`, of the front bank: two users.
    #[with(cfg.pixel_bits(), COLOUR_BITS)]
    pub colour_write: [WritePort<u32>; 2],
    /// Reads a depth of the back bank.
    #[with(cfg.pixel_bits())]
    pub back_depth_read: ReadPort,
    /// Reads a colour of the back bank.
    #[with(cfg.pixel_bits())]
    pub back_read: ReadPort,
    /// Wipes a pixel of the back bank.
    #[with(cfg.pixel_bits())]
    pub wipe: Stream<u32>,
    /// Wipes a pixel of both banks.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
    /// The banks change places on the coming edge.
    pub swap: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// Depth of the front bank.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// Colour of the front bank.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
    /// Depth of the back bank.
    #[with(Z_BITS)]
    pub back_depth: Read<u32>,
    /// Colour of the back bank.
    #[with(COLOUR_BITS)]
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

#[rtl(check(FrameBuffer, crate::test_util::screen(3, 2)))]
impl Block for FrameBuffer {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(cfg: &Screen) -> State {
        cfg.check();
        State { front_is_b: false }
    }

    fn memories(cfg: &Screen) -> Mem {
        // A depth is read for the next fragment while the last one's is written: the same pixel
        // twice in a row must see the new depth. No user reads a colour while it is written.
        let depth = || Ram1R1W::new(cfg.pixels(), Z_BITS, 1, ReadDuringWrite::New);
        let colour = || Ram1R1W::new(cfg.pixels(), COLOUR_BITS, 1, ReadDuringWrite::Forbidden);
        Mem { depth_a: depth(), depth_b: depth(), colour_a: colour(), colour_b: colour() }
    }

    fn moore(_: &Screen, q: &State, m: &Self::Mem) -> Moore {
        Moore {
            depth: if q.front_is_b { m.depth_b.q() } else { m.depth_a.q() },
            colour: if q.front_is_b { m.colour_b.q() } else { m.colour_a.q() },
            back_depth: if q.front_is_b { m.depth_a.q() } else { m.depth_b.q() },
            back_colour: if q.front_is_b { m.colour_a.q() } else { m.colour_b.q() },
        }
    }

    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Self::Mem, i: In) {
        if q.front_is_b {
            for user in i.depth_read {
                m.depth_b.pass_read(user);
            }
            for user in i.depth_write {
                m.depth_b.pass_write(user);
            }
            m.colour_b.pass_read(i.colour_read);
            for user in i.colour_write {
                m.colour_b.pass_write(user);
            }
            m.depth_a.pass_read(i.back_depth_read);
            m.colour_a.pass_read(i.back_read);
            if i.wipe.valid {
                m.depth_a.write(i.wipe.payload, Z_FAR);
                m.colour_a.write(i.wipe.payload, cfg.background);
            }
        } else {
            for user in i.depth_read {
                m.depth_a.pass_read(user);
            }
            for user in i.depth_write {
                m.depth_a.pass_write(user);
            }
            m.colour_a.pass_read(i.colour_read);
            for user in i.colour_write {
                m.colour_a.pass_write(user);
            }
            m.depth_b.pass_read(i.back_depth_read);
            m.colour_b.pass_read(i.back_read);
            if i.wipe.valid {
                m.depth_b.write(i.wipe.payload, Z_FAR);
                m.colour_b.write(i.wipe.payload, cfg.background);
            }
        }
        if i.clear.valid {
            m.depth_a.write(i.clear.payload, Z_FAR);
            m.colour_a.write(i.clear.payload, cfg.background);
            m.depth_b.write(i.clear.payload, Z_FAR);
            m.colour_b.write(i.clear.payload, cfg.background);
        }
        d.front_is_b = q.front_is_b ^ i.swap;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::screen;
    use pellucid_sim::Sim;
    use proptest::prelude::*;

    const PIXELS: u32 = 6;

    fn nothing() -> In {
        In {
            depth_read: [ReadPort::default(); 2],
            depth_write: [WritePort::default(); 2],
            colour_read: ReadPort::default(),
            colour_write: [WritePort::default(); 2],
            back_depth_read: ReadPort::default(),
            back_read: ReadPort::default(),
            wipe: Stream::idle(),
            clear: Stream::idle(),
            swap: false,
        }
    }

    /// A frame buffer with both banks cleared.
    fn cleared() -> Sim<FrameBuffer> {
        let mut sim = Sim::<FrameBuffer>::new(screen(3, 2));
        for pixel in 0..PIXELS {
            sim.clock(In { clear: Stream::offer(pixel), ..nothing() }).unwrap();
        }
        sim
    }

    fn reads(pixel: u32) -> ReadPort {
        let mut port = ReadPort::default();
        port.read(pixel);
        port
    }

    fn writes(pixel: u32, data: u32) -> WritePort<u32> {
        let mut port = WritePort::default();
        port.write(pixel, data);
        port
    }

    #[test]
    fn clear_reaches_both_banks() {
        let mut sim = cleared();
        for swap in [true, false] {
            for pixel in 0..PIXELS {
                let ask = In {
                    depth_read: [reads(pixel), ReadPort::default()],
                    colour_read: reads(pixel),
                    ..nothing()
                };
                sim.clock(ask).unwrap();
                assert_eq!(sim.moore().depth, Read { valid: true, data: 0xff_ffff });
                assert_eq!(sim.moore().colour, Read { valid: true, data: 0x10_20_30 });
            }
            sim.clock(In { swap, ..nothing() }).unwrap();
        }
    }

    #[test]
    fn a_depth_read_meets_the_write_of_its_cycle() {
        let mut sim = cleared();
        let both = In {
            depth_read: [reads(4), ReadPort::default()],
            depth_write: [writes(4, 77), WritePort::default()],
            ..nothing()
        };
        sim.clock(both).unwrap();
        assert_eq!(sim.moore().depth.data, 77);
    }

    /// One cycle of every user.
    #[derive(Clone, Debug)]
    struct Step {
        depth_read: (bool, u32),
        depth_write: (bool, u32, u32),
        colour_read: u32,
        colour_write: (bool, u32, u32),
        back_read: u32,
        wipe: u32,
        swap: bool,
    }

    fn step() -> impl Strategy<Value = Step> {
        let pixel = 0..PIXELS;
        // A colour is never read and written at once: written pixels are told as a distance.
        let apart = 1..PIXELS;
        (
            (any::<bool>(), pixel.clone()),
            (any::<bool>(), pixel.clone(), 0..Z_FAR),
            pixel.clone(),
            (any::<bool>(), apart.clone(), 0..1u32 << 24),
            pixel,
            apart,
            prop::bool::weighted(0.2),
        )
            .prop_map(
                |(depth_read, depth_write, colour_read, (user, by, colour), back, away, swap)| {
                    Step {
                        depth_read,
                        depth_write,
                        colour_read,
                        colour_write: (user, (colour_read + by) % PIXELS, colour),
                        back_read: back,
                        wipe: (back + away) % PIXELS,
                        swap,
                    }
                },
            )
    }

    proptest! {
        /// Against two plain banks: who draws meets the front, who shows meets the back.
        #[test]
        fn behaves_as_two_banks(steps in proptest::collection::vec(step(), 1..60)) {
            let mut sim = cleared();
            let bank = ([Z_FAR; PIXELS as usize], [0x10_20_30; PIXELS as usize]);
            let (mut front, mut back) = (bank, bank);
            for step in steps {
                let (mut depth_read, mut colour_write) = (nothing().depth_read, nothing().colour_write);
                depth_read[usize::from(step.depth_read.0)] = reads(step.depth_read.1);
                let (user, pixel, colour) = step.colour_write;
                colour_write[usize::from(user)] = writes(pixel, colour);
                let mut depth_write = nothing().depth_write;
                let (user, at, depth) = step.depth_write;
                depth_write[usize::from(user)] = writes(at, depth);
                sim.clock(In {
                    depth_read,
                    depth_write,
                    colour_read: reads(step.colour_read),
                    colour_write,
                    back_depth_read: reads(step.back_read),
                    back_read: reads(step.back_read),
                    wipe: Stream::offer(step.wipe),
                    clear: Stream::idle(),
                    swap: step.swap,
                }).unwrap();
                front.0[at as usize] = depth;
                front.1[pixel as usize] = colour;
                let expected = (
                    front.0[step.depth_read.1 as usize],
                    front.1[step.colour_read as usize],
                    back.0[step.back_read as usize],
                    back.1[step.back_read as usize],
                );
                back.0[step.wipe as usize] = Z_FAR;
                back.1[step.wipe as usize] = 0x10_20_30;
                if step.swap {
                    std::mem::swap(&mut front, &mut back);
                } else {
                    let seen = sim.moore();
                    let found = (
                        seen.depth.data,
                        seen.colour.data,
                        seen.back_depth.data,
                        seen.back_colour.data,
                    );
                    prop_assert_eq!(found, expected);
                }
            }
        }
    }
}
