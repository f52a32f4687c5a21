//! Words of 64 bits, of which each stands for something: sections, pixels, or further words.

use pellucid_sim::rtl;

/// Bits of a word.
pub const WORD_BITS: u32 = 64;
/// How far a bit's number is shifted to get that of its word.
pub const WORD_SHIFT: u32 = WORD_BITS.ilog2();

/// The place of the lowest bit; 0 if there is none.
#[inline(always)]
#[rtl]
pub fn lowest(word: u64) -> u32 {
    word.trailing_zeros() & (WORD_BITS - 1)
}

/// The bit at place `at`, counted round.
#[inline(always)]
#[rtl]
pub fn bit(at: u32) -> u64 {
    1u64 << (at & (WORD_BITS - 1))
}

/// The word but for its lowest bit.
#[inline(always)]
#[rtl]
pub fn rest(word: u64) -> u64 {
    word & word.wrapping_sub(1)
}
