//! The scanner: finds the pixels that resolve must visit.
//!
//! ```text
//!             +------+
//!  start ---->|      |---> pixel (Stream), then the end of the frame
//!  word ----->| Scan |<--- pixel_ready
//!             |      |---> occupancy read, write
//!             +------+
//! ```
//! One pixel a cycle, in rising order. With `scan=bitmap` it sends the pixels whose occupancy bit is
//! set, passes over a word without any in one cycle, and clears what it has read. With `scan=linear`
//! it sends every pixel.

use super::config::{Config, OCCUPANCY_BITS};
use crate::pixel::Marked;
use pellucid_sim::Block;
use pellucid_sim::{Read, ReadPort, Signals, Stream, WritePort, bits_for};

/// See the module's description.
pub struct Scan;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for a frame.
    Idle,
    /// Sending pixels.
    Scan,
    /// Sending the end of the frame.
    End,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// Pixels of the word at hand that are yet to be sent.
    #[width(OCCUPANCY_BITS)]
    pub bits: u64,
    /// Number of the word at hand.
    #[width(word_bits(cfg))]
    pub word: u32,
    /// The word that the occupancy bitmap shows.
    #[with(word_bits(cfg))]
    pub asked: Stream<u32>,
    /// The next word to ask for.
    #[width(word_bits(cfg))]
    pub next: u32,
}

fn word_bits(cfg: &Config) -> u32 {
    bits_for(u64::from(cfg.occupancy_words()))
}

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// A frame is stored. Only while idle.
    pub start: bool,
    /// The occupancy word that was asked for.
    pub occupancy: Read<u64>,
    /// The receiver takes a pixel.
    pub pixel_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// Pixels to visit.
    pub pixel: Stream<Marked<u32>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug)]
pub struct Out {
    /// Reads an occupancy word.
    pub read: ReadPort,
    /// Clears an occupancy word.
    pub write: WritePort<u64>,
}

/// All pixels of a word: fewer in the last one.
#[inline(always)]
fn every_pixel(cfg: &Config, word: u32) -> u64 {
    let left = cfg.screen.pixels() - word * OCCUPANCY_BITS;
    if left >= OCCUPANCY_BITS { u64::MAX } else { (1 << left) - 1 }
}

impl Block for Scan {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { fsm: Fsm::Idle, bits: 0, word: 0, asked: Stream::idle(), next: 0 }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        let pixel = q.word * OCCUPANCY_BITS + (q.bits.trailing_zeros() & (OCCUPANCY_BITS - 1));
        let end = q.fsm == Fsm::End;
        Moore { pixel: Stream { valid: q.bits != 0 || end, payload: Marked { end, item: pixel } } }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out { read: ReadPort::default(), write: WritePort::default() };
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Scan;
                    d.next = 0;
                }
            }
            Fsm::Scan => {
                // The pixel that leaves is the lowest bit.
                let rest = if i.pixel_ready { q.bits & q.bits.wrapping_sub(1) } else { q.bits };
                let refill = rest == 0;
                d.bits = rest;
                if refill && q.asked.valid {
                    let word = q.asked.payload;
                    d.word = word;
                    if cfg.bitmap {
                        d.bits = i.occupancy.data;
                        if i.occupancy.data != 0 {
                            o.write.write(word, 0);
                        }
                    } else {
                        d.bits = every_pixel(cfg, word);
                    }
                    d.asked.valid = false;
                }
                // The next word is asked for ahead of its use.
                if (refill || !q.asked.valid) && q.next < cfg.occupancy_words() {
                    if cfg.bitmap {
                        o.read.read(q.next);
                    }
                    d.asked = Stream::offer(q.next);
                    d.next = q.next + 1;
                }
                if refill && !q.asked.valid && q.next == cfg.occupancy_words() {
                    d.fsm = Fsm::End;
                }
            }
            Fsm::End => {
                if i.pixel_ready {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        o
    }
}
