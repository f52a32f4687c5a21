//! What the tests of several blocks share.

use crate::allocator::AllocatorKind;
use crate::chains::config::{Config, Passes, Shape};
use crate::weights::WEIGHT_BITS;
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::{Label, Stream};
pub use pellucid_test_util::*;
use std::collections::VecDeque;

/// Chains that keep tails, with a bitmap, as large as an architecture has them.
pub fn shape() -> Shape {
    Shape {
        owned: false,
        on_chip: 262_144,
        outside: 1_048_576,
        outside_latency: 64,
        capacity: 3,
        tail: true,
        bitmap: true,
        reads_in_flight: 64,
        passes: Passes::Each(16),
        weight_bits: 0,
        allocator: AllocatorKind::Fifo,
    }
}

/// Chains for few pixels, whose memories are smaller than random numbers: kept tail and bitmap, or neither.
pub fn small(fast: bool) -> Config {
    let shape = Shape {
        on_chip: 13,
        outside: 6,
        outside_latency: 3,
        tail: fast,
        bitmap: fast,
        reads_in_flight: 5,
        passes: Passes::Each(4),
        ..shape()
    };
    Config::new(screen(16, 9), shape)
}

/// The faster ones with so many sections on chip and outside.
pub fn small_of(on_chip: u32, outside: u32) -> Config {
    let small = small(true);
    Config::new(small.screen, Shape { on_chip, outside, ..small.shape })
}

/// The slower ones, with an NSA table that lends entries.
pub fn small_lending() -> Config {
    let mut cfg = small(false);
    cfg.shape.allocator = AllocatorKind::Threaded;
    cfg
}

/// Chains of which each pixel owns the first section: weights in memory, or none.
pub fn small_owned(in_memory: bool) -> Config {
    let shape = Shape {
        owned: true,
        on_chip: 5,
        outside: 6,
        outside_latency: 3,
        capacity: 2,
        reads_in_flight: 5,
        passes: if in_memory { Passes::One } else { Passes::Twice(3) },
        weight_bits: if in_memory { WEIGHT_BITS } else { 0 },
        ..shape()
    };
    Config::new(screen(5, 3), shape)
}

/// A word of 70 bits.
pub fn word(number: u64) -> Word {
    Word { low: number, high: number & 0x3f, label: Label::NONE }
}

/// Asks for a word.
pub fn read(address: u32) -> Request {
    Request { write: false, address, word: Word::default() }
}

/// Writes one.
pub fn write(address: u32, number: u64) -> Request {
    Request { write: true, address, word: word(number) }
}

/// What a word holds before it was ever written.
pub fn at_first(address: u32) -> Word {
    word(1000 + u64::from(address))
}

/// A memory behind a port: takes requests in some cycles, and answers each read after a time of its own.
pub struct Behind {
    /// What it holds.
    pub words: Vec<Word>,
    ready: Pattern,
    latencies: Vec<u64>,
    reads: usize,
    due: VecDeque<(u64, Word)>,
}

impl Behind {
    /// So many words, of which it takes requests in the cycles of `ready` and answers reads after `latencies`, over and over.
    pub fn new(words: u32, ready: Pattern, latencies: Vec<u64>) -> Behind {
        let words = (0..words).map(at_first).collect();
        Behind { words, ready, latencies, reads: 0, due: VecDeque::new() }
    }
    /// What it drives in `cycle`.
    pub fn shows(&self, cycle: u64) -> outside::In {
        let answer = self.due.front().filter(|(due, _)| *due <= cycle);
        let response = answer.map_or(Stream::idle(), |(_, word)| Stream::offer(*word));
        outside::In { ready: self.ready.at(cycle), response }
    }
    /// That cycle ends; what was asked of it is taken if it was ready.
    pub fn edge(&mut self, cycle: u64, request: Stream<Request>) {
        let shown = self.shows(cycle);
        if shown.response.valid {
            self.due.pop_front();
        }
        let Request { write, address, word } = request.payload;
        if request.valid && shown.ready && write {
            self.words[address as usize] = word;
        } else if request.valid && shown.ready {
            let latency = self.latencies[self.reads % self.latencies.len()];
            self.due.push_back((cycle + latency, self.words[address as usize]));
            self.reads += 1;
        }
    }
}
