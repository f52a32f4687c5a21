//! What a cache knows of the lines of a set: which they are, and in which order they were used.

use super::Config;
use pellucid_sim::{Signals, Stream, rtl};

/// The most lines that a set can have.
pub const MAX_WAYS: usize = 16;

/// A line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Line {
    /// There is one.
    pub valid: bool,
    /// It holds what memory does not.
    #[exists(cfg.write_back)]
    pub dirty: bool,
    /// The upper bits of its words' addresses.
    #[width(cfg.tag_bits())]
    pub tag: u32,
    /// How many lines of the set were used since.
    #[width(cfg.way_bits())]
    pub age: u32,
}

/// A set: a word of the tags. The ages of its lines are all different, and those that are not valid are the oldest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Set {
    /// Its lines.
    #[with(*cfg)]
    #[len(cfg.ways)]
    pub lines: [Line; MAX_WAYS],
}

/// A set without lines.
pub fn empty(cfg: &Config) -> Set {
    let mut set = Set::default();
    for k in 0..cfg.ways {
        set.lines[k as usize].age = k;
    }
    set
}

/// The way of the line with that tag, if there is one.
#[inline(always)]
#[rtl]
pub fn hit(cfg: &Config, set: Set, tag: u32) -> Stream<u32> {
    let mut hit = Stream::idle();
    for k in 0..cfg.ways {
        let line = set.lines[k as usize];
        if line.valid && line.tag == tag {
            hit = Stream::offer(k);
        }
    }
    hit
}

/// The way of the line that was used least recently: one that is not valid, as long as there is one.
#[inline(always)]
#[rtl]
pub fn oldest(cfg: &Config, set: Set) -> u32 {
    let mut way = 0;
    for k in 0..cfg.ways {
        if set.lines[k as usize].age == cfg.ways - 1 {
            way = k;
        }
    }
    way
}

/// The way of a dirty line, if there is one.
#[inline(always)]
#[rtl]
pub fn dirty(cfg: &Config, set: Set) -> Stream<u32> {
    let mut dirty = Stream::idle();
    for k in 0..cfg.ways {
        if set.lines[k as usize].dirty {
            dirty = Stream::offer(k);
        }
    }
    dirty
}

/// A set of which a line was read or written.
#[inline(always)]
#[rtl]
pub fn used(cfg: &Config, set: Set, way: u32, write: bool) -> Set {
    let age = set.lines[way as usize].age;
    let mut next = set;
    for k in 0..cfg.ways {
        let mut line = set.lines[k as usize];
        if way == k {
            line.age = 0;
            line.dirty = line.dirty || (cfg.write_back && write);
        } else if line.age < age {
            line.age += 1;
        }
        next.lines[k as usize] = line;
    }
    next
}

/// A set of which a line was written to memory.
#[inline(always)]
#[rtl]
pub fn clean(cfg: &Config, set: Set, way: u32) -> Set {
    let mut next = set;
    for k in 0..cfg.ways {
        if way == k {
            next.lines[k as usize].dirty = false;
        }
    }
    next
}

/// A set of which a line was fetched.
#[inline(always)]
#[rtl]
pub fn fetched(cfg: &Config, set: Set, way: u32, tag: u32) -> Set {
    let mut next = set;
    for k in 0..cfg.ways {
        if way == k {
            let age = set.lines[k as usize].age;
            next.lines[k as usize] = Line { valid: true, dirty: false, tag, age };
        }
    }
    next
}
