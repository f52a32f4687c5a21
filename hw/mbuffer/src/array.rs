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
//! [`Passes`]: pellucid_blocks::chains::config::Passes

use super::sum::{Term, plus};
use pellucid_blocks::weights::{WEIGHT_BITS, behind, own_weight};
use pellucid_machine::pixel::{Arrived, Marked, Screen, Z_BITS};
use pellucid_sim::{Block, Label, Signals, Stream, bits_for, check_range, rtl};

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
    /// Which fragment it is, in waveforms.
    pub label: Label,
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
    /// Which fragment it is, in waveforms.
    pub label: Label,
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
    #[with(cfg.screen.pixel_bits(), 0)]
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

    fn reset(cfg: &Config) -> State {
        check_range("the number of cells of an array", cfg.cells, 1..=MAX_CELLS as u32);
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

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { term: q.leaves }
    }

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
            label: item.label,
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
                    let Traveller { z, rgba, weight, loads, label, .. } = came;
                    d.cells[k as usize] =
                        Settled { valid: true, came: !loads, z, rgba, weight, label };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sum::Weighted;
    use crate::test_util::{Pattern, Source, pattern, screen};
    use pellucid_sim::Sim;
    use proptest::prelude::*;

    const PIXELS: u32 = 6;

    /// A fragment: depth, colour with alpha, and whether it is visible.
    type Layer = (u32, u32, bool);

    /// A pixel as the chains give it: once, and for each further group of `cells` visible fragments twice.
    fn passes(cells: u32, pixel: u32, layers: &[Layer]) -> Vec<Marked<Arrived>> {
        let visible = layers.iter().filter(|(.., visible)| *visible).count() as u32;
        let groups = visible.div_ceil(cells).max(1);
        let pass = |last_pass: bool| {
            layers.iter().enumerate().map(move |(k, &(z, rgba, visible))| {
                let last = k + 1 == layers.len();
                let item =
                    Arrived { pixel, z, rgba, visible, last, last_pass, ..Arrived::default() };
                Marked::item(item)
            })
        };
        let mut all: Vec<_> = pass(groups == 1).collect();
        for group in 1..groups {
            all.extend(pass(false));
            all.extend(pass(group + 1 == groups));
        }
        all
    }

    /// What a fragment lets through, rounded to nearest.
    fn lets_through(rgba: u32) -> u64 {
        (2 * 65536 * u64::from(255 - (rgba & 0xff)) + 255) / 510
    }

    /// The sums by plain loops over all pairs, in the order of the arrivals.
    fn reference(layers: &[Layer]) -> [u64; 4] {
        let seen: Vec<&Layer> = layers.iter().filter(|(.., visible)| *visible).collect();
        let mut sums = [0; 4];
        for (i, &&(z, rgba, _)) in seen.iter().enumerate() {
            let mut weight = (65536 - lets_through(rgba)) << 8;
            for (j, &&(other, over, _)) in seen.iter().enumerate() {
                if other < z || (other == z && j > i) {
                    weight = (weight * lets_through(over)) >> 16;
                }
            }
            for (sum, shift) in sums.iter_mut().zip([24, 16, 8]) {
                *sum += weight * u64::from(rgba >> shift & 0xff);
            }
            sums[3] += weight;
        }
        sums
    }

    /// The sums of each pixel, with the cycle of its last term and that of the end.
    fn play(cells: u32, pixels: &[Vec<Layer>], starts: Pattern) -> (Vec<[u64; 4]>, u64) {
        let cfg = Config { cells, screen: screen(PIXELS, 1), layer_bits: 6 };
        let mut sim = Sim::<Array>::new(cfg);
        let frame = (0..).zip(pixels).flat_map(|(pixel, layers)| passes(cells, pixel, layers));
        let mut source = Source::new(frame.chain([Marked::end()]), starts);
        let (mut all, mut sums) = (vec![], [0; 4]);
        for cycle in 0.. {
            assert!(cycle < 20_000, "the end of the frame does not come");
            let Stream { valid, payload: Marked { end, item } } = sim.moore().term;
            if valid && end {
                return (all, cycle);
            }
            if valid {
                assert_eq!(item.pixel as usize, all.len());
                let Weighted { r, g, b, weight } = item.sum;
                for (sum, part) in sums.iter_mut().zip([r, g, b, weight]) {
                    *sum += u64::from(part);
                }
                if item.last {
                    all.push(std::mem::take(&mut sums));
                }
            }
            let arrived = source.offer(cycle);
            source.edge(true);
            sim.clock(In { arrived }).unwrap();
        }
        unreachable!()
    }

    #[test]
    fn one_fragment_a_cycle_whatever_the_pixels_have() {
        let layer = |k: u32| (k * 7 % 5, k << 8 | 0x60, true);
        for sizes in [[1, 1, 1, 1, 1, 1], [5, 1, 3, 1, 2, 5]] {
            let pixels: Vec<Vec<Layer>> = sizes.map(|n| (0..n).map(layer).collect()).to_vec();
            let fragments: u32 = sizes.iter().sum();
            let (sums, end) = play(5, &pixels, Pattern::always());
            assert_eq!(sums, pixels.iter().map(|p| reference(p)).collect::<Vec<_>>());
            // The end comes in behind the last fragment, and goes through five cells.
            assert_eq!(end, u64::from(fragments) + 5 + 2);
        }
    }

    proptest! {
        /// Against plain loops over all pairs, with fewer and with more cells than fragments.
        #[test]
        fn weighs_as_plain_loops_do(
            cells in 1u32..10,
            pixels in proptest::collection::vec(
                proptest::collection::vec(
                    (0u32..6, any::<u32>().prop_map(|rgba| rgba & !1), prop::bool::weighted(0.8)),
                    1..24,
                ),
                0..PIXELS as usize,
            ),
            starts in pattern(),
        ) {
            let expected: Vec<[u64; 4]> = pixels.iter().map(|layers| reference(layers)).collect();
            prop_assert_eq!(play(cells, &pixels, starts).0, expected);
        }
    }

    #[test]
    #[should_panic(expected = "the number of cells of an array is 33: expected 1 to 32")]
    fn more_cells_than_registers_are_too_many() {
        Array::reset(&Config { cells: 33, screen: screen(PIXELS, 1), layer_bits: 6 });
    }
}
