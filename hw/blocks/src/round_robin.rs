//! Round robin: who of a few that ask is next.

use pellucid_sim::{Stream, rtl};

/// The most that there can be.
pub const MOST: usize = 8;

/// The first of those that ask, of `count`, counted round from the one whose turn it is.
#[inline(always)]
#[rtl]
pub fn first(count: &u32, asks: [bool; MOST], turn: u32) -> Stream<u32> {
    let mut lowest = Stream { valid: false, payload: 0 };
    let mut next = Stream { valid: false, payload: 0 };
    for k in 0..*count {
        let at = *count - 1 - k;
        if asks[at as usize] {
            lowest = Stream { valid: true, payload: at };
        }
        if asks[at as usize] && turn <= at {
            next = Stream { valid: true, payload: at };
        }
    }
    if next.valid { next } else { lowest }
}

/// Whose turn it is after one of `count`.
#[inline(always)]
#[rtl]
pub fn behind(count: &u32, one: u32) -> u32 {
    if one == *count - 1 { 0 } else { one + 1 }
}
