//! Shows a finished frame that lies in outside memory, and takes the marks of its bank away.
//!
//! ```text
//!             +--------------+
//!  start ---->|              |---> image (Stream of colours)
//!  marked --->| ScanoutAhead |<--- image_ready
//!  memory --->|              |---> mark read, wipe, request (back bank)
//!  busy <-----+--------------+
//! ```
//! As [`Scanout`](crate::scanout), but that pixels are [read ahead](super::fetch), row by row; those without their mark
//! are not read. One pixel a cycle with reads enough in flight.

use super::config::Config;
use super::fetch::{self, Fetch};
use crate::scanout::Fsm;
use pellucid_machine::outside::{self, Request};
use pellucid_machine::pixel::COLOUR_BITS;
use pellucid_sim::{Block, Memory, Read, ReadPort, Signals, Stream, rtl};

/// See the module's description.
pub struct ScanoutAhead;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    #[reset(Fsm::Idle)]
    pub fsm: Fsm,
    /// The next pixel to ask for.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// See [`fetch`].
    #[with(cfg.shown())]
    #[block(Fetch)]
    pub fetch: fetch::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame is in the back bank from the next cycle on. Only while not `busy`.
    pub start: bool,
    /// The mark that was asked for.
    pub marked: Read<bool>,
    /// What the memory drives.
    #[with(cfg.bank())]
    pub memory: outside::In,
    /// The receiver takes a colour.
    pub image_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// The colours, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// A frame is being shown.
    pub busy: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a mark of the back bank.
    #[with(cfg.screen.pixel_bits())]
    pub mark_read: ReadPort,
    /// Takes a mark of the back bank away.
    #[with(cfg.screen.pixel_bits())]
    pub wipe: Stream<u32>,
    /// Reads a pixel of the back bank.
    #[with(cfg.bank())]
    pub request: Stream<Request>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`fetch`].
    #[block(Fetch, cfg.shown())]
    pub fetch: fetch::Mem,
}

#[rtl(
    check(ScanoutAhead, super::tests::config(1, 2)),
    check(ScanoutAhead, super::tests::config(4, 7))
)]
impl Block for ScanoutAhead {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let pixel = Fetch::moore(&cfg.shown(), &q.fetch, &m.fetch).pixel;
        Moore {
            image: Stream { valid: pixel.valid, payload: pixel.payload.colour },
            busy: q.fsm != Fsm::Idle,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let seen = Fetch::moore(&cfg.shown(), &q.fetch, &m.fetch);
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Run;
                    d.pixel = 0;
                }
            }
            Fsm::Run => {
                if seen.ready && q.pixel == cfg.screen.pixels() - 1 {
                    d.fsm = Fsm::Drain;
                } else if seen.ready {
                    d.pixel = q.pixel + 1;
                }
            }
            Fsm::Drain => {
                if seen.idle {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        let to_fetch = fetch::In {
            ask: Stream { valid: matches!(q.fsm, Fsm::Run), payload: q.pixel },
            marked: i.marked,
            taken: i.image_ready,
            memory: i.memory,
        };
        let fetch = Fetch::next(&cfg.shown(), &q.fetch, &mut d.fetch, &mut m.fetch, to_fetch);
        Out { mark_read: fetch.mark_read, wipe: fetch.looked, request: fetch.request }
    }
}
