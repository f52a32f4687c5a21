//! What a table cache knows of a set: its lines, and what they made room for.

use super::config::{Config, Old};
use crate::cache::tags::{self, MAX_WAYS};
use pellucid_sim::{Signals, rtl};

/// The line that was in a way before the one that is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Before {
    /// Which it was.
    #[with(*cfg)]
    pub old: Old,
    /// The miss for which it made room.
    #[width(cfg.number_bits())]
    pub miss: u32,
}

/// A set: a word of the tags. Its lines are those that will be there when all asks so far have had their turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Set {
    /// Its lines.
    #[with(cfg.cache())]
    pub now: tags::Set,
    /// Those before them.
    #[with(*cfg)]
    #[len(cfg.ways)]
    pub before: [Before; MAX_WAYS],
}

/// Misses under way: their numbers follow each other, and begin again after the largest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Misses {
    /// The number of the next one.
    #[width(cfg.number_bits())]
    pub next: u32,
    /// The oldest one whose turn has still to come.
    #[width(cfg.number_bits())]
    pub waits: u32,
    /// The oldest one whose line is not all there.
    #[width(cfg.number_bits())]
    pub fills: u32,
}

#[rtl]
impl Config {
    /// By how many misses one comes after another.
    #[inline(always)]
    pub(super) fn after(&self, number: u32, other: u32) -> u32 {
        number.wrapping_sub(other) & self.last_number()
    }
    /// The number of the miss after another.
    #[inline(always)]
    pub(super) fn next(&self, number: u32) -> u32 {
        number.wrapping_add(1) & self.last_number()
    }
}

impl Config {
    fn last_number(&self) -> u32 {
        u32::MAX >> (u32::BITS - self.number_bits())
    }
}

/// A set without lines.
pub fn empty(cfg: &Config) -> Set {
    Set { now: tags::empty(&cfg.cache()), ..Set::default() }
}

/// Whether a line cannot be asked for yet, to lie in that way: it has still to make room itself, or another line has, of
/// the way.
#[inline(always)]
#[rtl]
pub fn waits(cfg: &Config, set: Set, misses: Misses, tag: u32, way: u32) -> bool {
    let waiting = cfg.after(misses.next, misses.waits);
    let mut waits = false;
    for k in 0..cfg.ways {
        let Before { old, miss } = set.before[k as usize];
        let stays = old.valid && cfg.after(miss, misses.waits) < waiting;
        waits = waits || (stays && (old.tag == tag || way == k));
    }
    waits
}

/// A set of which a line will be used.
#[inline(always)]
#[rtl]
pub fn used(cfg: &Config, set: Set, way: u32) -> Set {
    Set { now: tags::used(&cfg.cache(), set.now, way, false), before: set.before }
}

/// A set in which the line `tag` takes a way, for miss number `miss`.
#[inline(always)]
#[rtl]
pub fn taken(cfg: &Config, set: Set, way: u32, tag: u32, miss: u32) -> Set {
    let was = set.now.lines[way as usize];
    let mut next = set;
    for k in 0..cfg.ways {
        if way == k {
            let old = Old { valid: was.valid, tag: was.tag };
            next.before[k as usize] = Before { old, miss };
        }
    }
    next.now = tags::fetched(&cfg.cache(), set.now, way, tag);
    next
}
