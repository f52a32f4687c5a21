//! Walks over words of bits and names every set bit.
//!
//! ```text
//!             +---------+
//!  word ----->|         |---> bit (Stream)
//!  take <-----| BitWalk |<--- bit_ready
//!  data ----->|         |---> read, clear
//!             +---------+
//! ```
//! It is sent the numbers of words, looks each up in a memory that answers after one cycle, sends the
//! number of every set bit (the word's number times [`WORD_BITS`] plus its place), lowest first,
//! and clears the word. One bit a cycle, or one word without any; the next word is looked up ahead.

use super::config::Config;
use crate::bits::{WORD_BITS, WORD_SHIFT, lowest, rest};
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct BitWalk;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Bits of the word at hand that are yet to be sent.
    #[width(WORD_BITS)]
    pub bits: u64,
    /// Number of the word at hand.
    #[width(cfg.word_bits())]
    pub word: u32,
    /// The word that the memory shows.
    #[with(cfg.word_bits())]
    pub asked: Stream<u32>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A word to visit.
    #[with(cfg.word_bits())]
    pub word: Stream<u32>,
    /// The word that was asked for.
    #[with(WORD_BITS)]
    pub data: Read<u64>,
    /// The receiver takes a bit.
    pub bit_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Numbers of set bits.
    #[with(cfg.walk_bits())]
    pub bit: Stream<u32>,
    /// No word is at hand or asked for.
    pub idle: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The word to visit is taken.
    pub take: bool,
    /// Reads a word.
    #[with(cfg.word_bits())]
    pub read: ReadPort,
    /// Clears a word.
    #[with(cfg.word_bits(), WORD_BITS)]
    pub clear: WritePort<u64>,
}

impl Config {
    /// Bits of the number of a bit that a walk finds.
    pub fn walk_bits(&self) -> u32 {
        self.word_bits() + WORD_SHIFT
    }
}

#[rtl(check(BitWalk, crate::test_util::small(true)))]
impl Block for BitWalk {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { bits: 0, word: 0, asked: Stream::idle() }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore {
            bit: Stream { valid: q.bits != 0, payload: q.word * WORD_BITS + lowest(q.bits) },
            idle: q.bits == 0 && !q.asked.valid,
        }
    }

    fn next(_: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let (mut read, mut clear) = (ReadPort::default(), WritePort::default());
        // The bit that leaves is the lowest.
        let left = if i.bit_ready { rest(q.bits) } else { q.bits };
        let empty = left == 0;
        d.bits = left;
        if empty && q.asked.valid {
            d.word = q.asked.payload;
            d.bits = i.data.data;
            d.asked.valid = false;
            if i.data.data != 0 {
                clear.write(q.asked.payload, 0);
            }
        }
        // The next word is asked for as soon as the memory is free to show it.
        let take = i.word.valid && (empty || !q.asked.valid);
        if take {
            read.read(i.word.payload);
            d.asked = i.word;
        }
        Out { take, read, clear }
    }
}

#[cfg(test)]
mod tests;
