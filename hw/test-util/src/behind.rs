//! The memory behind a port to outside memory.

use crate::Pattern;
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::{Label, Stream};
use std::collections::VecDeque;

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
