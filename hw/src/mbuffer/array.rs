//! The weight array: a line of cells through which a pixel's fragments go, each to be compared with every
//! other one.
//!
//! ```text
//!             +------+    +------+           +------+
//!  arrived -->| cell |--->| cell |--> ... -->| cell |---> term (Stream)
//!             +------+    +------+           +------+
//! ```
//! A fragment goes from cell to cell, one a cycle, and settles in the first that is free. In each cell
//! that it passes it meets the fragment that settled there before: the weight of the farther one is
//! multiplied by what the nearer one lets through, so each cell has one multiplier for weights. Of equal
//! depths the later one is nearer. A token follows a pixel's last fragment, a cell behind it: it adds up
//! weight times colour of the settled fragments, whose weights are final, and frees their cells. The next
//! pixel's first fragment follows at once: one fragment a cycle, whatever the pixels have.
//!
//! A pixel with more fragments than there are cells is read again and again, see [`Passes`]: those that
//! found no cell in the first pass are loaded, so many as there are cells, then all fragments go by; one
//! that was loaded takes note when it goes by itself, since of equal depths those after it are nearer. So
//! each weight is multiplied in the order of the arrivals, however many cells there are.
//!
//! [`Passes`]: crate::chains::config::Passes

use super::sum::{Term, plus};
use crate::pixel::{Arrived, Marked, Screen, Z_BITS};
use crate::weights::{WEIGHT_BITS, behind, own_weight};
use pellucid_sim::{Block, Signals, Stream, bits_for, rtl};

/// See the module's description.
pub struct Array;

/// The most cells that an array can have.
pub const MAX_CELLS: usize = 32;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Cells, 1..=[`MAX_CELLS`].
    pub cells: u32,
    /// The screen.
    pub screen: Screen,
    /// Bits of how many fragments a pixel may have.
    pub layer_bits: u32,
}

impl Config {
    /// Bits of how many visible fragments are counted: there may be one group more than fragments.
    fn count_bits(&self) -> u32 {
        bits_for((1 << self.layer_bits) + u64::from(self.cells))
    }
}

/// Why a pixel is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Pass {
    /// For the first time: fragments settle, as long as there are cells.
    Settle,
    /// To load the next fragments into the cells.
    Load,
    /// To compare the loaded ones with all.
    Compare,
}

/// A fragment on its way through the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Traveller {
    /// There is one.
    pub valid: bool,
    /// It looks for a cell: one that is free, or its own.
    pub seeks: bool,
    /// It is being loaded: it meets no other.
    pub loads: bool,
    /// Its depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// Its weight so far.
    #[width(WEIGHT_BITS)]
    pub weight: u32,
}

/// What a cell holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Settled {
    /// There is one.
    pub valid: bool,
    /// It is among those that came before the next to pass.
    pub came: bool,
    /// Its depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// Its weight so far.
    #[width(WEIGHT_BITS)]
    pub weight: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Why the pixel at hand is read.
    pub pass: Pass,
    /// Visible fragments of it that came in this pass.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// Those of them that were done with, or loaded, in passes before.
    #[width(cfg.count_bits())]
    pub from: u32,
    /// The token that follows the last fragment.
    #[with(cfg.screen)]
    pub follows: Stream<Marked<Term>>,
    /// Something moves.
    pub busy: bool,
    /// In front of each cell, the fragment that comes to it.
    #[len(cfg.cells)]
    pub travellers: [Traveller; MAX_CELLS],
    /// In front of each cell, the token that comes to it.
    #[with(cfg.screen)]
    #[len(cfg.cells)]
    pub tokens: [Stream<Marked<Term>>; MAX_CELLS],
    /// What the cells hold.
    #[len(cfg.cells)]
    pub cells: [Settled; MAX_CELLS],
    /// What leaves.
    #[with(cfg.screen)]
    pub leaves: Stream<Marked<Term>>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments of one pixel after the other, then the end of the frame; always taken.
    #[with(cfg.screen, 0)]
    pub arrived: Stream<Marked<Arrived>>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Sums of a pixel's fragments, one for each pass, then the end of the frame.
    #[with(cfg.screen)]
    pub term: Stream<Marked<Term>>,
}

#[rtl(
    check(Array, Config { cells: 1, screen: crate::test_util::screen(3, 3), layer_bits: 4 }),
    check(Array, Config { cells: 5, screen: crate::test_util::screen(3, 3), layer_bits: 5 })
)]
impl Block for Array {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(_: &Config) -> State {
        State {
            pass: Pass::Settle,
            count: 0,
            from: 0,
            follows: Stream::idle(),
            busy: false,
            travellers: [Traveller::default(); MAX_CELLS],
            tokens: [Stream::idle(); MAX_CELLS],
            cells: [Settled::default(); MAX_CELLS],
            leaves: Stream::idle(),
        }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { term: q.leaves }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) {
        // What comes in, and the token that is to follow it.
        let Marked { end, item } = i.arrived.payload;
        let fragment = i.arrived.valid && !end;
        let visible = fragment && item.visible;
        let in_group = q.count >= q.from && q.count < q.from + cfg.cells;
        let enters = visible && (q.pass != Pass::Load || in_group);
        let mut traveller = Traveller {
            valid: enters,
            seeks: q.pass == Pass::Settle || in_group,
            loads: q.pass == Pass::Load,
            z: item.z,
            rgba: item.rgba,
            weight: own_weight(item.rgba),
        };
        d.follows = Stream::idle();
        if visible {
            d.count = q.count + 1;
        }
        if i.arrived.valid && end {
            d.follows = Stream::offer(Marked::end());
        }
        if fragment && item.last {
            d.count = 0;
            if q.pass != Pass::Load {
                let term = Term { pixel: item.pixel, last: item.last_pass, ..Term::default() };
                d.follows = Stream::offer(Marked::item(term));
            }
            if q.pass == Pass::Load {
                d.pass = Pass::Compare;
            } else if item.last_pass {
                d.pass = Pass::Settle;
                d.from = 0;
            } else {
                d.pass = Pass::Load;
                d.from = q.from + cfg.cells;
            }
        }

        // From cell to cell. What stands still needs no clock.
        let mut moves = enters || q.follows.valid;
        if q.busy || moves {
            let mut token = q.follows;
            for k in 0..cfg.cells {
                let came = q.travellers[k as usize];
                let passing = q.tokens[k as usize];
                let cell = q.cells[k as usize];
                d.travellers[k as usize] = traveller;
                d.tokens[k as usize] = token;

                // The token takes what the cell holds.
                token = passing;
                if passing.valid && cell.valid {
                    token.payload.item = plus(passing.payload.item, cell.rgba, cell.weight);
                }
                let occupied = cell.valid && !passing.valid;
                d.cells[k as usize].valid = occupied;

                // The fragment settles, finds itself, or meets the one that is there.
                let meets = came.valid && occupied && !came.loads;
                let itself = meets && came.seeks && !cell.came;
                let settles = came.valid && came.seeks && !occupied;
                let nearer = came.z < cell.z || (came.z == cell.z && cell.came);
                let weight = if nearer { cell.weight } else { came.weight };
                let product = behind(weight, if nearer { came.rgba } else { cell.rgba });
                traveller = came;
                if settles {
                    let Traveller { z, rgba, weight, loads, .. } = came;
                    d.cells[k as usize] = Settled { valid: true, came: !loads, z, rgba, weight };
                    traveller.valid = false;
                } else if itself {
                    d.cells[k as usize].came = true;
                    traveller.seeks = false;
                } else if meets && nearer {
                    d.cells[k as usize].weight = product;
                } else if meets {
                    traveller.weight = product;
                }
                moves |= came.valid || passing.valid;
            }
            d.leaves = token;
        }
        d.busy = moves;
    }
}
