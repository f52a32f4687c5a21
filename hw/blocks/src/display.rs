//! The display side: the frame buffer, and the scanout that shows its back bank.
//!
//! ```text
//!  front: depth, colour ----->+-------------+ back colour +---------+
//!  clear -------------------->| FrameBuffer |------------>| Scanout |---> image (Stream), busy
//!  depth, colour <------------|             |<------------|         |<--- image_ready
//!                             +-------------+ read, wipe  +---------+
//!                                    ^----------- show -------^
//! ```
//! `show` swaps the banks and starts the scanout. Scanout is clocked while it has work.

use crate::frame_buffer::{self, FrameBuffer};
use crate::scanout::{self, Scanout};
use pellucid_machine::pixel::{COLOUR_BITS, Screen, Z_BITS};
use pellucid_sim::{Block, Memory, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Display;

/// A bank is wiped as it is shown.
fn shown(cfg: &Screen) -> scanout::Config {
    scanout::Config { screen: *cfg, wipes: true }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// See [`frame_buffer`].
    #[with(*cfg)]
    #[block(FrameBuffer)]
    pub frame_buffer: frame_buffer::State,
    /// See [`scanout`].
    #[with(shown(cfg))]
    #[block(Scanout)]
    pub scanout: scanout::State,
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
    /// Wipes a pixel of both banks.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
    /// The frame in the front bank is complete: it is shown from the next cycle on. Only while not `busy`.
    pub show: bool,
    /// The receiver takes a colour.
    pub image_ready: bool,
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
    /// The image, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// A frame is being shown.
    pub busy: bool,
}

/// Memories.
#[derive(Memory)]
#[memory(Screen)]
pub struct Mem {
    /// See [`frame_buffer`].
    #[block(FrameBuffer, *cfg)]
    pub frame_buffer: frame_buffer::Mem,
    /// See [`scanout`].
    #[block(Scanout, shown(cfg))]
    pub scanout: scanout::Mem,
}

#[rtl(check(Display, crate::test_util::screen(3, 2)))]
impl Block for Display {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn moore(cfg: &Screen, q: &State, m: &Mem) -> Moore {
        let buffer = FrameBuffer::moore(cfg, &q.frame_buffer, &m.frame_buffer);
        let scanout = Scanout::moore(&shown(cfg), &q.scanout, &m.scanout);
        Moore {
            depth: buffer.depth,
            colour: buffer.colour,
            image: scanout.image,
            busy: scanout.busy,
        }
    }

    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Mem, i: In) {
        let buffer = FrameBuffer::moore(cfg, &q.frame_buffer, &m.frame_buffer);
        let busy = Scanout::moore(&shown(cfg), &q.scanout, &m.scanout).busy;
        let shown = if busy || i.show {
            let to_scanout = scanout::In {
                start: i.show,
                colour: buffer.back_colour,
                image_ready: i.image_ready,
            };
            Scanout::next(&shown(cfg), &q.scanout, &mut d.scanout, &mut m.scanout, to_scanout)
        } else {
            scanout::Out::default()
        };
        let to_buffer = frame_buffer::In {
            depth_read: i.depth_read,
            depth_write: i.depth_write,
            colour_read: i.colour_read,
            colour_write: i.colour_write,
            back_depth_read: ReadPort::default(),
            back_read: shown.read,
            wipe: shown.wipe,
            clear: i.clear,
            swap: i.show,
        };
        FrameBuffer::next(
            cfg,
            &q.frame_buffer,
            &mut d.frame_buffer,
            &mut m.frame_buffer,
            to_buffer,
        );
    }
}
