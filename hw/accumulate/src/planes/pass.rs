//! A pass: a sweep of the screen that merges a frame or a node with planes outside.

use crate::config::Config;
use crate::level::Fill;
use crate::tree::MOST_LEVELS;
use pellucid_sim::{Signals, Stream, bits_for, rtl};

/// A sweep of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct Pass {
    /// It is of a node, and begins with what is in the top.
    #[exists(cfg.has_top())]
    pub own: bool,
    /// It ends the image.
    pub closes: bool,
    /// The first level at which it merges.
    #[width(cfg.level_bits())]
    #[exists(cfg.has_top())]
    pub from: u32,
    /// The level that its result comes to: what is below merges.
    #[width(if cfg.levels() == 0 { 0 } else { bits_for(u64::from(cfg.levels())) })]
    pub to: u32,
    /// The planes that it reads, a bit for each.
    #[width(cfg.planes())]
    pub reads: u32,
    /// The one that it writes.
    #[width(cfg.plane_number_bits())]
    pub writes: u32,
    /// It gives the image, and writes none.
    pub shows: bool,
}

/// What waits in the top.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct Top {
    /// The level whose node it completes.
    #[width(cfg.level_bits())]
    pub level: u32,
    /// It ends the image.
    #[exists(cfg.has_top())]
    pub closes: bool,
}

impl Config {
    /// The first plane of a level.
    fn plane_of(&self, level: u32) -> u32 {
        let below = (0..level).map(|k| self.tree.level(k).planes()).sum::<u32>();
        below + u32::from(self.has_top())
    }
}

/// The pass that comes next, of a tree.
#[inline(always)]
#[rtl]
pub fn of_tree(cfg: &Config, levels: [Fill; MOST_LEVELS], frame: u32, top: Stream<Top>) -> Pass {
    let own = cfg.has_top() && top.valid;
    let closes = if own { top.payload.closes } else { frame == cfg.frames() - 1 };
    let from = if own { top.payload.level } else { 0 };
    // How far what it gives carries.
    let mut to = 0;
    if cfg.has_top() {
        if own {
            to = top.payload.level + 1;
        }
    } else {
        let mut carries = true;
        for k in 0..cfg.levels() {
            carries &= closes || levels[k as usize].filled == cfg.tree.level(k).planes();
            if carries {
                to = k + 1;
            }
        }
    }
    let mut reads = if own { 1 } else { 0 };
    let mut writes = 0;
    for k in 0..cfg.levels() {
        let filled = levels[k as usize].filled;
        let full = filled == cfg.tree.level(k).planes();
        if k >= from && k < to {
            for plane in 0..cfg.tree.level(k).planes() {
                if plane < filled {
                    reads |= 1 << (cfg.plane_of(k) + plane);
                }
            }
        }
        if k == to && !(cfg.has_top() && (full || closes)) {
            writes = cfg.plane_of(k) + filled;
        }
    }
    Pass { own, closes, from, to, reads, writes, shows: to == cfg.levels() }
}

/// The pass that comes next, of sums.
#[inline(always)]
#[rtl]
pub fn of_sums(cfg: &Config, frame: u32) -> Pass {
    let closes = frame == cfg.frames() - 1;
    let reads = if frame == 0 { 0 } else { 1 };
    Pass { own: false, closes, from: 0, to: 0, reads, writes: 0, shows: closes }
}
