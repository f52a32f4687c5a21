//! The depth sorter: an insertion sorter that holds K fragments of a pixel, takes pixel after pixel and gives
//! each one's fragments far to near.
//!
//! ```text
//!                +--------+
//!  arrived ----->|        |---> sorted (Stream, far first)
//!  ready <-------| Sorter |<--- sorted_ready
//!                +--------+
//! ```
//! The registers are kept in leaving order. Those of pixels that are complete (`closed` of them)
//! leave one a cycle, while the fragments of the pixel at hand are inserted behind them, one a
//! cycle: each goes behind every fragment that is as far or farther, so that equal depths leave in
//! arrival order. There are K + 1 registers: the next pixel's first fragment comes in beside a complete pixel of K.
//!
//! A pixel with more than K fragments comes in several passes. In each, the K farthest that have not
//! left yet stay and the others fall off the end. The pass's last fragment sets the threshold of the
//! next: its depth, and how many fragments of that depth have left. So any number of layers is exact,
//! at the price of `ceil(n / K)` passes.
//!
//! Where a pixel's fragments come from the newest to the oldest each goes before those that are as far, so that equal depths
//! still leave from the oldest on. Then the threshold's count is of those of its depth that fell off the end: in the next pass they
//! are the first to come.
//!
//! A fragment is taken in every cycle, unless the receiver stalls: then at most K fragments wait at the begin of each.
//! The last fragment of a pass closes it for the next cycle. From there on, or from when those before have left, one
//! leaves a cycle.

use crate::blender::Sorted;
use pellucid_machine::pixel::{Arrived, MOST_PIXEL_BITS, Marked, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Label, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct Sorter;

/// The most fragments that a sorter can sort in one pass.
pub const MAX_DEPTH: usize = 64;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// K: fragments sorted in one pass, 1..=[`MAX_DEPTH`].
    pub depth: u32,
    /// Bits of a pixel's number, 0 if its turn tells which it is.
    pub pixel_bits: u32,
    /// Bits of how many fragments a pixel may have.
    pub layer_bits: u32,
    /// A pixel's fragments come from the newest to the oldest, in every pass.
    pub newest_first: bool,
}

impl Config {
    fn registers(&self) -> u32 {
        self.depth + 1
    }
    fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.registers()))
    }
}

/// A fragment that waits in a register.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Entry {
    /// Its pixel.
    #[width(cfg.pixel_bits)]
    pub pixel: u32,
    /// Its depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// The last of its pixel.
    pub last: bool,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Entries in use.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// Entries, from the first, whose pass is complete.
    #[width(cfg.count_bits())]
    pub closed: u32,
    /// The pixel at hand is in its second pass or later.
    pub again: bool,
    /// Depth of the last fragment of the pass before.
    #[width(Z_BITS)]
    pub threshold: u32,
    /// Fragments of that depth that left in earlier passes. Where the newest come first, those that did not.
    #[width(cfg.layer_bits)]
    pub left: u32,
    /// Fragments of that depth that came in so far in this pass.
    #[width(cfg.layer_bits)]
    pub came: u32,
    /// Depth of the farthest fragments that fell off the end in this pass.
    #[width(Z_BITS)]
    #[exists(cfg.newest_first)]
    pub fell_z: u32,
    /// How many of that depth did.
    #[width(cfg.layer_bits)]
    #[exists(cfg.newest_first)]
    pub fell: u32,
    /// The end of the frame has come in.
    pub end: bool,
    /// The fragments; the first leaves first.
    #[with(*cfg)]
    #[len(cfg.registers())]
    pub entries: [Entry; MAX_DEPTH + 1],
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments of one pixel after the other, then the end of the frame.
    #[with(cfg.pixel_bits, 0)]
    pub arrived: Stream<Marked<Arrived>>,
    /// The receiver takes what is sorted.
    pub sorted_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// What leaves.
    #[with(cfg.pixel_bits)]
    pub sorted: Stream<Marked<Sorted>>,
}

#[rtl(
    check(Sorter, Config { depth: 1, pixel_bits: 0, layer_bits: 3, newest_first: false }),
    check(Sorter, Config { depth: 7, pixel_bits: 4, layer_bits: 4, newest_first: false }),
    check(Sorter, Config { depth: 5, pixel_bits: 4, layer_bits: 4, newest_first: true })
)]
impl Block for Sorter {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        check_range("the depth of a sorter", cfg.depth, 1..=MAX_DEPTH as u32);
        check_range("the bits of a pixel's number", cfg.pixel_bits, ..=MOST_PIXEL_BITS);
        State {
            count: 0,
            closed: 0,
            again: false,
            threshold: 0,
            left: 0,
            came: 0,
            fell_z: 0,
            fell: 0,
            end: false,
            entries: [Entry::default(); MAX_DEPTH + 1],
        }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let Entry { pixel, rgba, last, label, .. } = q.entries[0];
        let item = Sorted { pixel, rgba, last, label };
        let end = q.end && q.count == 0;
        Moore {
            ready: !q.end && q.count < cfg.registers(),
            sorted: Stream { valid: q.closed > 0 || end, payload: Marked { end, item } },
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) {
        let Moore { ready, sorted } = Self::moore(cfg, q, &());
        let pop = i.sorted_ready && q.closed > 0;
        if i.sorted_ready && sorted.payload.end {
            d.end = false;
        }
        let take = i.arrived.valid && ready;
        let Marked { end, item } = i.arrived.payload;
        let fragment = take && !end;
        if take && end {
            d.end = true;
        }

        // Which fragments have not left in an earlier pass?
        let at_threshold = q.again && item.z == q.threshold;
        let before = if cfg.newest_first { q.came >= q.left } else { q.came < q.left };
        let left = q.again && (item.z > q.threshold || (at_threshold && before));
        let insert = fragment && item.visible && !left;
        if fragment && item.visible && at_threshold {
            d.came = q.came + 1;
        }

        // One leaves: the others move a place towards the exit. One comes: it goes behind all that
        // are closed and all that are as far or farther, and pushes those behind it one place back;
        // the last falls off if all registers are in use.
        let step = u32::from(pop);
        let count = q.count - step;
        let closed = q.closed - step;
        if pop || insert {
            let mut carry = Entry {
                pixel: item.pixel,
                z: item.z,
                rgba: item.rgba,
                last: false,
                label: item.label,
            };
            let mut placed = false;
            for k in 0..cfg.registers() {
                // The last register is free whenever one comes: what it holds behind the others does not matter.
                let last = k + 1 == cfg.registers();
                let here =
                    if pop && !last { q.entries[k as usize + 1] } else { q.entries[k as usize] };
                let nearer = if cfg.newest_first { here.z <= item.z } else { here.z < item.z };
                placed |= insert && (last || (k >= closed && (k >= count || nearer)));
                if placed {
                    d.entries[k as usize] = carry;
                    carry = here;
                } else {
                    d.entries[k as usize] = here;
                }
            }
        }
        d.closed = closed;
        d.count = if insert && count - closed < cfg.depth { count + 1 } else { count };

        // Where the newest come first, those that fall off and are as far as the last one that stays are for the passes to come.
        let mut fell = q.fell;
        let mut fell_z = q.fell_z;
        if cfg.newest_first && insert && count - closed == cfg.depth {
            let z = d.entries[cfg.depth as usize].z;
            if q.fell == 0 || z > q.fell_z {
                fell = 1;
                fell_z = z;
            } else if z == q.fell_z {
                fell = q.fell + 1;
            }
        }
        d.fell = fell;
        d.fell_z = fell_z;

        // The end of a pass closes what is in.
        if fragment && item.last {
            d.closed = d.count;
            d.again = !item.last_pass;
            d.came = 0;
            d.fell = 0;
            if !item.last_pass {
                // More than K of the pixel have come, so that K are in, and nothing of the ones before is left.
                let z = d.entries[cfg.depth as usize - 1].z;
                d.threshold = z;
                if cfg.newest_first {
                    d.left = if fell_z == z { fell } else { 0 };
                } else {
                    let mut same = if q.again && q.threshold == z { q.left } else { 0 };
                    for k in 0..cfg.depth {
                        same += u32::from(d.entries[k as usize].z == z);
                    }
                    d.left = same;
                }
            } else if d.count > 0 {
                // If nothing of the pixel is visible, this is an earlier pixel's last already.
                d.entries[(d.count - 1) as usize].last = true;
            }
        }
    }
}

#[cfg(test)]
mod tests;
