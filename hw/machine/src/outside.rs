//! The port to memory outside of the chip.
//!
//! ```text
//!            +---------+ request (Stream)  +---------+
//!            |         |------------------>| outside |
//!            | machine |<------------------| memory  |
//!            +---------+ response (Stream) +---------+
//! ```
//! A request reads or writes one word; both streams keep the rules of [`pellucid_sim::stream`]. Requests are carried out in
//! their order, so that a read gives what was written before it. Reads are answered in their order, each after any time of
//! a cycle or more; a write has no answer. [`board`](crate::board) has the memory.

use pellucid_sim::{Handshake, Label, Signals, Stream, bits_for, rtl};

/// A machine's port: what its widths depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Words that can be addressed; with 0 there is no port.
    pub words: u32,
    /// Bits of a word, 1 to 128.
    pub bits: u32,
}

impl Config {
    /// No port.
    pub const NONE: Config = Config { words: 0, bits: 0 };
    /// Whether there is a port.
    #[inline]
    pub fn exists(&self) -> bool {
        self.words > 0
    }
    /// Bits of an address.
    #[inline]
    pub fn address_bits(&self) -> u32 {
        bits_for(u64::from(self.words.max(1) - 1))
    }
    #[inline]
    fn low_bits(&self) -> u32 {
        self.bits.min(u64::BITS)
    }
    #[inline]
    fn high_bits(&self) -> u32 {
        self.bits - self.low_bits()
    }
}

/// A word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct Word {
    /// Its lower 64 bits.
    #[width(cfg.low_bits())]
    pub low: u64,
    /// The others.
    #[width(cfg.high_bits())]
    pub high: u64,
    /// Which item it holds, in waveforms.
    pub label: Label,
}

/// What a port with words of fewer bits has of a word.
#[inline(always)]
#[rtl]
pub fn cut(port: &Config, word: Word) -> Word {
    let mut low = word.low;
    if port.bits < u64::BITS {
        low &= (1u64 << port.bits) - 1;
    }
    let mut high = 0;
    if port.bits > u64::BITS {
        high = word.high & (u64::MAX >> (2 * u64::BITS - port.bits));
    }
    Word { low, high, label: word.label }
}

/// A fragment as a word: its depth lowest, then its colour, then what is kept beside it.
#[inline(always)]
#[rtl]
pub fn packed(z: u32, rgba: u32, beside: u32, label: Label) -> Word {
    let (z, rgba, beside) = (u64::from(z), u64::from(rgba), u64::from(beside));
    Word { low: beside << 56 | rgba << 24 | z, high: beside >> 8, label }
}

/// The depth of the fragment that a word holds.
#[inline(always)]
#[rtl]
pub fn depth(word: Word) -> u32 {
    (word.low & 0xff_ffff) as u32
}

/// Its colour, `0xRRGGBBAA`.
#[inline(always)]
#[rtl]
pub fn colour(word: Word) -> u32 {
    (word.low >> 24 & 0xffff_ffff) as u32
}

/// What is kept beside it.
#[inline(always)]
#[rtl]
pub fn beside(word: Word) -> u32 {
    (word.low >> 56 | word.high << 8) as u32
}

/// What a machine asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct Request {
    /// A word is written; else one is read.
    pub write: bool,
    /// Which one.
    #[width(cfg.address_bits())]
    pub address: u32,
    /// What is written.
    #[with(*cfg)]
    pub word: Word,
}

/// What the memory drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct In {
    /// A request is taken.
    pub ready: bool,
    /// The words that were read.
    #[with(*cfg)]
    pub response: Stream<Word>,
}

/// All wires of the port in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct Wires {
    /// What the machine asks for.
    #[with(*cfg)]
    pub request: Handshake<Request>,
    /// The words that were read.
    #[with(*cfg)]
    pub response: Handshake<Word>,
}

/// What is behind a machine's port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outside {
    /// What lies there, one behind the other from word 0 on.
    pub tables: Vec<Table>,
    /// Cycles from a read request to its word, at least 1.
    pub latency: u32,
}

/// One of the tables that lie in outside memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The path under which its traffic is counted, as if it were one of the machine's own memories.
    pub path: String,
    /// Words that it has.
    pub words: u32,
    /// Bits of a word.
    pub bits: u32,
}

impl Outside {
    /// The same memory, of a machine that is the part `part` of another one.
    #[must_use]
    pub fn within(mut self, part: &str) -> Outside {
        for table in &mut self.tables {
            table.path = format!("{part}.{}", table.path);
        }
        self
    }
}
