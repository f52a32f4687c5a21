//! The depth sorter: an insertion sorter of K registers that takes pixel after pixel and gives each
//! one's fragments far to near.
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
//! arrival order.
//!
//! A pixel with more than K fragments comes in several passes. In each, the K farthest that have not
//! left yet stay and the others fall off the end; the pass's last fragment left sets the threshold
//! (depth, then position in the chain) behind which the next pass begins. So any number of layers is
//! exact, at the price of `ceil(n / K)` passes.

use crate::blender::Sorted;
use crate::pixel::{Marked, Screen, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Signals, Stream, bits_for};

/// See the module's description.
pub struct Sorter;

/// The most registers that a sorter can have.
pub const MAX_DEPTH: usize = 64;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// K: fragments sorted in one pass, 1..=[`MAX_DEPTH`].
    pub depth: u32,
    /// The screen.
    pub screen: Screen,
    /// Bits of a fragment's position in its pixel's chain.
    pub position_bits: u32,
}

impl Config {
    fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.depth))
    }
}

/// A fragment as it is read back from storage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Arrived {
    /// Its pixel.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// Its depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// How many of the pixel's fragments arrived before it.
    #[width(cfg.position_bits)]
    pub position: u32,
    /// It is in front of the pixel's opaque depth. Hidden ones only carry the two marks below.
    pub visible: bool,
    /// The last of the pass.
    pub last: bool,
    /// This is the pixel's last pass.
    pub last_pass: bool,
}

/// Registers. Entry 0 leaves first.
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
    pub threshold_z: u32,
    /// Position of the last fragment of the pass before.
    #[width(cfg.position_bits)]
    pub threshold_position: u32,
    /// The end of the frame has come in.
    pub end: bool,
    /// Depth of each entry.
    #[width(Z_BITS)]
    #[len(cfg.depth)]
    pub z: [u32; MAX_DEPTH],
    /// Position in the chain of each entry.
    #[width(cfg.position_bits)]
    #[len(cfg.depth)]
    pub position: [u32; MAX_DEPTH],
    /// Colour of each entry.
    #[width(32)]
    #[len(cfg.depth)]
    pub rgba: [u32; MAX_DEPTH],
    /// Pixel of each entry.
    #[width(cfg.screen.pixel_bits())]
    #[len(cfg.depth)]
    pub pixel: [u32; MAX_DEPTH],
    /// Whether each entry is the last of its pixel.
    #[len(cfg.depth)]
    pub last: [bool; MAX_DEPTH],
}

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Fragments of one pixel after the other, then the end of the frame.
    pub arrived: Stream<Marked<Arrived>>,
    /// The receiver takes what is sorted.
    pub sorted_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// A fragment is taken: there is room, or one may fall off the end.
    pub ready: bool,
    /// What leaves.
    pub sorted: Stream<Marked<Sorted>>,
}

impl Block for Sorter {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(_: &Config) -> State {
        State {
            count: 0,
            closed: 0,
            again: false,
            threshold_z: 0,
            threshold_position: 0,
            end: false,
            z: [0; MAX_DEPTH],
            position: [0; MAX_DEPTH],
            rgba: [0; MAX_DEPTH],
            pixel: [0; MAX_DEPTH],
            last: [false; MAX_DEPTH],
        }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let item = Sorted { pixel: q.pixel[0], rgba: q.rgba[0], last: q.last[0] };
        let end = q.end && q.count == 0;
        Moore {
            ready: !q.end && (q.count < cfg.depth || q.closed == 0),
            sorted: Stream { valid: q.closed > 0 || end, payload: Marked { end, item } },
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) {
        let Moore { ready, sorted } = Self::moore(cfg, q, &());
        let pop = i.sorted_ready && q.closed > 0;
        if i.sorted_ready && sorted.valid && sorted.payload.end {
            d.end = false;
        }
        let take = i.arrived.valid && ready;
        let Marked { end, item } = i.arrived.payload;
        let behind = item.z < q.threshold_z
            || (item.z == q.threshold_z && item.position > q.threshold_position);
        let insert = take && !end && item.visible && (!q.again || behind);
        if take && end {
            d.end = true;
        }

        // The entries move one place towards the exit when one leaves.
        let mut count = q.count;
        let mut closed = q.closed;
        if pop {
            for k in 1..cfg.depth as usize {
                d.z[k - 1] = q.z[k];
                d.position[k - 1] = q.position[k];
                d.rgba[k - 1] = q.rgba[k];
                d.pixel[k - 1] = q.pixel[k];
                d.last[k - 1] = q.last[k];
            }
            count -= 1;
            closed -= 1;
        }
        // The new one goes behind all that are closed and all that are as far or farther; the others
        // make room, and the last falls off if all registers are in use.
        if insert {
            let e = *d;
            let mut at = 0;
            for k in 0..cfg.depth {
                let before = k < closed || (k < count && e.z[k as usize] >= item.z);
                at += u32::from(before);
            }
            for k in 0..cfg.depth as usize {
                let behind = k > at as usize;
                let from = if behind { k - 1 } else { k };
                d.z[k] = e.z[from];
                d.position[k] = e.position[from];
                d.rgba[k] = e.rgba[from];
                d.pixel[k] = e.pixel[from];
                d.last[k] = e.last[from];
            }
            if at < cfg.depth {
                let at = at as usize;
                d.z[at] = item.z;
                d.position[at] = item.position;
                d.rgba[at] = item.rgba;
                d.pixel[at] = item.pixel;
                d.last[at] = false;
            }
            if count < cfg.depth {
                count += 1;
            }
        }
        d.count = count;
        d.closed = closed;

        // The end of a pass closes what is in.
        if take && !end && item.last {
            let newest = (d.count.max(1) - 1) as usize;
            if item.last_pass {
                if d.count > closed {
                    d.last[newest] = true;
                }
                d.again = false;
            } else {
                d.threshold_z = d.z[newest];
                d.threshold_position = d.position[newest];
                d.again = true;
            }
            d.closed = d.count;
        }
    }
}
