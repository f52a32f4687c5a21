//! The shape of a cache, and where a word is in it.

use super::MAX_WAYS;
use pellucid_machine::outside;
use pellucid_sim::{check_range, rtl};

/// The most words that a line can have.
pub const MAX_LINE: u32 = 16;

/// Parameters. The cache holds no more words than the memory.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The port of the client and of the memory; a whole number of lines.
    pub port: outside::Config,
    /// How many sets; a power of two.
    pub sets: u32,
    /// Lines of a set, 1..=[`MAX_WAYS`]; a power of two.
    pub ways: u32,
    /// Words of a line, 1..=[`MAX_LINE`]; a power of two.
    pub line: u32,
    /// Writes stay in the cache until their line makes room; else they go through to memory.
    pub write_back: bool,
}

impl Config {
    /// Holds every number to its range.
    pub(crate) fn check(&self) {
        let Config { port, sets, ways, line, .. } = *self;
        check_lines("cache", port, line);
        let lines = port.words / line;
        check_range("the number of ways of a cache", ways, 1..=(MAX_WAYS as u32).min(lines));
        check_range("the number of sets of a cache", sets, 1..=lines / ways);
        check_power_of_two("ways of a cache", ways);
        check_power_of_two("sets of a cache", sets);
    }

    pub(crate) fn line_bits(&self) -> u32 {
        self.line.trailing_zeros()
    }
    pub(crate) fn set_bits(&self) -> u32 {
        self.sets.trailing_zeros()
    }
    pub(crate) fn way_bits(&self) -> u32 {
        self.ways.trailing_zeros()
    }
    pub(crate) fn tag_bits(&self) -> u32 {
        self.port.address_bits() - self.set_bits() - self.line_bits()
    }
}

/// Holds the port of a `block` and the words of its lines to their ranges.
pub(crate) fn check_lines(block: &str, port: outside::Config, line: u32) {
    check_range(&format!("the number of words behind a {block}"), port.words, 1..);
    check_range(&format!("the number of bits of a {block}'s word"), port.bits, 1..=128);
    let words = format!("words of a {block}'s line");
    check_range(&format!("the number of {words}"), line, 1..=MAX_LINE.min(port.words));
    check_power_of_two(&words, line);
    assert!(
        port.words.is_multiple_of(line),
        "the number of words behind a {block} is {}: expected a multiple of its line's {line}",
        port.words
    );
}

/// Holds the number of `what` to powers of two.
pub(crate) fn check_power_of_two(what: &str, value: u32) {
    assert!(value.is_power_of_two(), "the number of {what} is {value}: expected a power of two");
}

// An address is its tag, its set and its word of a line, from the top.
#[rtl]
impl Config {
    #[inline(always)]
    pub(crate) fn tag_of(&self, address: u32) -> u32 {
        address >> (self.set_bits() + self.line_bits())
    }
    #[inline(always)]
    pub(crate) fn set_of(&self, address: u32) -> u32 {
        (address >> self.line_bits()) & (self.sets - 1)
    }
    #[inline(always)]
    pub(crate) fn word_of(&self, address: u32) -> u32 {
        address & (self.line - 1)
    }
    #[inline(always)]
    pub(crate) fn address(&self, tag: u32, set: u32, word: u32) -> u32 {
        (((tag << self.set_bits()) | set) << self.line_bits()) | word
    }
    /// Which line an address is in.
    #[inline(always)]
    pub(crate) fn line_in(&self, address: u32) -> u32 {
        address >> self.line_bits()
    }
    /// The word so many words on in the same line, the first behind the last.
    #[inline(always)]
    pub(crate) fn on(&self, address: u32, words: u32) -> u32 {
        let word = self.word_of(self.word_of(address) + words);
        (self.line_in(address) << self.line_bits()) | word
    }
    /// Whether a word of a line is among the first `words` from an address of it on, or the next one is, too.
    #[inline(always)]
    pub(crate) fn after(&self, word: u32, from: u32, words: u32, next: bool) -> bool {
        let behind = word.wrapping_sub(from) & (self.line - 1);
        behind < words || (behind == words && next)
    }
    /// The number of a line among the cache's own.
    #[inline(always)]
    pub(crate) fn line_at(&self, set: u32, way: u32) -> u32 {
        (set << self.way_bits()) | way
    }
    /// Where a word of that line is among the cache's own words.
    #[inline(always)]
    pub(crate) fn word_at(&self, line: u32, word: u32) -> u32 {
        (line << self.line_bits()) | word
    }
    /// The same of a word of a set and a way.
    #[inline(always)]
    pub(crate) fn place(&self, set: u32, way: u32, word: u32) -> u32 {
        self.word_at(self.line_at(set, way), word)
    }
}
