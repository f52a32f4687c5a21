//! The scanner: finds the pixels that resolve must visit.
//!
//! ```text
//!             +------+
//!  start ---->|      |---> pixel (Stream), then the end of the frame
//!  summary -->| Scan |<--- pixel_ready
//!  word ----->|      |---> summary and word: read, clear
//!             +------+
//! ```
//! One pixel a cycle, in rising order. With `scan=linear` it sends every pixel. With `scan=bitmap` it
//! sends those whose occupancy bit is set: one [`BitWalk`] finds the occupied words in the summary and
//! passes over a summary word without any in one cycle, a second one finds the occupied pixels in
//! those words. Both clear what they have read.

use super::config::{Config, OCCUPANCY_BITS};
use super::walk::{self, BitWalk};
use crate::pixel::Marked;
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, WritePort, bits_for};

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
    /// The next pixel (`scan=linear`) or summary word (`scan=bitmap`) to visit.
    #[width(bits_for(u64::from(cfg.scan_end())))]
    pub next: u32,
    /// Finds occupied words in the summary.
    #[with(*cfg)]
    pub words: walk::State,
    /// Finds occupied pixels in a word.
    #[with(*cfg)]
    pub pixels: walk::State,
}

impl Config {
    /// How far the scanner counts: pixels or summary words.
    pub fn scan_end(&self) -> u32 {
        if self.bitmap { self.summary_words() } else { self.screen.pixels() }
    }
    /// Bits of the number of an occupancy word.
    pub fn word_bits(&self) -> u32 {
        bits_for(u64::from(self.screen.pixels() / OCCUPANCY_BITS))
    }
}

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// A frame is stored. Only while idle.
    pub start: bool,
    /// The summary word that was asked for.
    pub summary: Read<u64>,
    /// The occupancy word that was asked for.
    pub word: Read<u64>,
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
#[derive(Clone, Copy, Debug, Default)]
pub struct Out {
    /// Reads a summary word.
    pub summary_read: ReadPort,
    /// Clears a summary word.
    pub summary_clear: WritePort<u64>,
    /// Reads an occupancy word.
    pub word_read: ReadPort,
    /// Clears an occupancy word.
    pub word_clear: WritePort<u64>,
}

impl Block for Scan {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let walk = BitWalk::reset(cfg);
        State { fsm: Fsm::Idle, next: 0, words: walk, pixels: walk }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let end = q.fsm == Fsm::End;
        let pixel = if cfg.bitmap {
            BitWalk::moore(cfg, &q.pixels, &()).bit
        } else {
            let left = q.fsm == Fsm::Scan && q.next < cfg.scan_end();
            Stream { valid: left, payload: q.next }
        };
        Moore {
            pixel: Stream {
                valid: pixel.valid || end,
                payload: Marked { end, item: pixel.payload },
            },
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out::default();
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Scan;
                    d.next = 0;
                }
            }
            Fsm::Scan => {
                let more = q.next < cfg.scan_end();
                let mut idle = true;
                let mut step = i.pixel_ready && more;
                if cfg.bitmap {
                    let words = BitWalk::moore(cfg, &q.words, &());
                    let to_pixels =
                        walk::In { word: words.bit, data: i.word, bit_ready: i.pixel_ready };
                    let pixels = BitWalk::next(cfg, &q.pixels, &mut d.pixels, &mut (), to_pixels);
                    let to_words = walk::In {
                        word: Stream { valid: more, payload: q.next },
                        data: i.summary,
                        bit_ready: pixels.take,
                    };
                    let summary = BitWalk::next(cfg, &q.words, &mut d.words, &mut (), to_words);
                    idle = words.idle && BitWalk::moore(cfg, &q.pixels, &()).idle;
                    step = summary.take;
                    o = Out {
                        summary_read: summary.read,
                        summary_clear: summary.clear,
                        word_read: pixels.read,
                        word_clear: pixels.clear,
                    };
                }
                if step {
                    d.next = q.next + 1;
                }
                if !more && idle {
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
