//! Bands by a plain sum.

use pellucid_blocks::array::config::Config;
use std::ops::Range;

/// What a band must come to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Due {
    /// Its pixels.
    pub(super) pixels: Range<u32>,
    /// The sum of each.
    pub(super) sums: Vec<u64>,
    /// Slots that it takes.
    pub(super) slots: u64,
    /// The words that are listed, and how many are gone over.
    pub(super) listed: Vec<u32>,
    pub(super) gone_over: u32,
    /// All counters after it.
    pub(super) counters: Vec<u64>,
}

impl Due {
    /// The band that begins at a pixel, where the counters are these.
    pub(super) fn of(cfg: &Config, counters: &[u64], from: u32) -> Due {
        let (shape, lanes) = (&cfg.shape, cfg.shape.lanes);
        let mut due = Due { pixels: from..from, ..Due::default() };
        for count in &counters[from as usize..] {
            let end = due.slots + count;
            if end > u64::from(cfg.slots()) {
                break;
            }
            due.sums.push(if shape.down { end } else { due.slots });
            if *count > 0 && lanes > 1 {
                due.listed.push(due.pixels.end / lanes);
            }
            (due.slots, due.pixels.end) = (end, due.pixels.end + 1);
        }
        due.listed.dedup();
        // Where there is but one band all is gone over, and what is behind it has no slot.
        let end = if shape.bands { due.pixels.end + 1 } else { u32::MAX };
        due.gone_over = end.min(cfg.screen.pixels()).div_ceil(lanes) - from / lanes;
        let left = |(pixel, count): (u32, &u64)| {
            let of_band = due.pixels.contains(&pixel);
            if of_band && !shape.down || !of_band && !shape.bands { 0 } else { *count }
        };
        due.counters = (0..).zip(counters).map(left).collect();
        due
    }
}
