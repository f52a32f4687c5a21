//! The sort: brings the shaded fragments of a frame into the order in which they are blended, by a bitonic sort over memory within
//! each window and between windows.
//!
//! ```text
//!               +------+
//!  fragment --->|      |---> sorted (Stream)
//!  ready <------| Sort |---> left
//!  last ------->|      |<--- over
//!               +------+
//! ```
//! The key is row, column, depth (far first) and the fragment's number in the frame. With S places, the first S of what is sorted
//! are *kept* when a window is over, and come in before the next one, so that once a round of all windows is over the first S of
//! all fragments are at hand, and leave in order. Those beyond them come again in the next round, which passes over what has
//! left before. Where all fragments fit into one window there is one round, and nothing is kept.
//!
//! An item a cycle goes in and an item a cycle comes out; for the time between see the [sorter](pellucid_blocks::bitonic).

use pellucid_blocks::bitonic::{self, BitonicSorter, Item};
use pellucid_machine::pixel::{Marked, PixelFragment, Screen, Z_BITS, Z_FAR};
use pellucid_sim::{Block, Fifo, Label, Memory, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Sort;

/// Bits of a fragment's number in its frame.
pub const NUMBER_BITS: u32 = 32;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// A window has 2 to the power of so many places.
    pub place_bits: u32,
    /// 2 to the power of so many compare-exchanges a cycle.
    pub lane_bits: u32,
}

impl Config {
    /// The sorter: for a window and as many that are kept.
    pub fn sorter(&self) -> bitonic::Config<()> {
        bitonic::Config {
            capacity_bits: self.place_bits + 1,
            lane_bits: self.lane_bits,
            key_bits: self.screen.pixel_bits() + Z_BITS,
            number_bits: NUMBER_BITS,
            payload: (),
        }
    }
    fn places(&self) -> u32 {
        1 << self.place_bits
    }
    fn kept(&self) -> fifo::Config<bitonic::Config<()>> {
        fifo::Config { depth: self.places(), item: self.sorter() }
    }
}

/// What a fragment carries beside its key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Colour {
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

type Sorter = BitonicSorter<Colour>;
type Kept = Fifo<Item<Colour>>;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Takes in what was kept.
    Refill,
    /// Takes a window's fragments.
    Take,
    /// Sorts, and gives.
    Give,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    #[reset(Fsm::Take)]
    pub fsm: Fsm,
    /// Items of the window that were given.
    #[width(cfg.place_bits + 2)]
    pub given: u32,
    /// There are items beyond those that are kept.
    pub left: bool,
    /// The key of the last one that has left.
    #[with(cfg.screen.pixel_bits() + Z_BITS)]
    pub behind: Stream<u64>,
    /// Its number.
    #[width(NUMBER_BITS)]
    pub behind_number: u32,
    /// See [`bitonic`].
    #[with(cfg.place_bits + 1)]
    #[block(Sorter, cfg.sorter())]
    pub sorter: bitonic::State,
    /// Items that are kept.
    #[with(cfg.places())]
    #[block(Kept, cfg.kept())]
    pub kept: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments, then the end of the window.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The fragment's number in the frame.
    #[width(NUMBER_BITS)]
    pub number: u32,
    /// It is the last window. It stays until all that is sorted has left.
    pub last: bool,
    /// All that has left is blended.
    pub over: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// A window is sorted, and what is sorted leaves.
    pub gives: bool,
    /// There are fragments for a further round.
    pub left: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Fragments in blending order, of the last window; then its end. Whoever takes them is always ready.
    #[with(cfg.screen)]
    pub sorted: Stream<Marked<PixelFragment>>,
    /// A pass over memory is complete.
    pub pass: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`bitonic`].
    #[block(Sorter, cfg.sorter())]
    pub sorter: bitonic::Mem<Colour>,
    /// Items that are kept.
    #[block(Kept, cfg.kept())]
    pub kept: <Kept as Block>::Mem,
}

#[rtl(moore = (), check(Sort, crate::test_util::sort(2, 0)), check(Sort, crate::test_util::sort(3, 1)))]
impl Block for Sort {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(_: &Config, q: &State, _: &Mem) -> Moore {
        Moore { ready: q.fsm == Fsm::Take, gives: q.fsm == Fsm::Give, left: q.left }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let sorter = Sorter::moore(&cfg.sorter(), &q.sorter, &m.sorter);
        let kept = Kept::moore(&cfg.kept(), &q.kept, &m.kept).front;

        // What goes in: what was kept, or what is behind all that has left.
        let Marked { end, item: PixelFragment { pixel, z, rgba, label } } = i.fragment.payload;
        let key = u64::from(pixel) << Z_BITS | u64::from(Z_FAR - z);
        let same = key == q.behind.payload && i.number > q.behind_number;
        let behind = !q.behind.valid || key > q.behind.payload || same;
        let takes = q.fsm == Fsm::Take && i.fragment.valid;
        let refills = q.fsm == Fsm::Refill;
        let came = Item { key, number: i.number, payload: Colour { rgba, label } };
        let load = Stream {
            valid: (takes && !end && behind) || (refills && kept.valid),
            payload: if refills { kept.payload } else { came },
        };
        let start = takes && end;

        // What comes out: it leaves, is kept, or is left for another round.
        let gives = q.fsm == Fsm::Give && sorter.sorted.valid;
        let Marked { end: ends, item } = sorter.sorted.payload;
        let first = gives && !ends && q.given < cfg.places();
        let to_kept = fifo::In {
            push: Stream { valid: first && !i.last, payload: item },
            pop: refills && kept.valid,
        };
        Kept::next(&cfg.kept(), &q.kept, &mut d.kept, &mut m.kept, to_kept);
        let to_sorter = bitonic::In { load, start, sorted_ready: true };
        let sorted =
            Sorter::next(&cfg.sorter(), &q.sorter, &mut d.sorter, &mut m.sorter, to_sorter);
        if first {
            d.given = q.given + 1;
        } else if gives && !ends {
            d.left = true;
        }
        if first && i.last {
            d.behind = Stream::offer(item.key);
            d.behind_number = item.number;
        }

        if start {
            d.fsm = Fsm::Give;
        } else if gives && ends {
            d.fsm = Fsm::Refill;
            d.given = 0;
        } else if refills && !kept.valid {
            d.fsm = Fsm::Take;
        }
        if i.over && i.last {
            d.left = false;
            if !q.left {
                d.behind = Stream::idle();
            }
        }

        let leaves = PixelFragment {
            pixel: (item.key >> Z_BITS) as u32,
            z: Z_FAR - (item.key as u32 & Z_FAR),
            rgba: item.payload.rgba,
            label: item.payload.label,
        };
        Out {
            sorted: Stream {
                valid: gives && (ends || (first && i.last)),
                payload: Marked { end: ends, item: leaves },
            },
            pass: sorted.pass,
        }
    }
}

#[cfg(test)]
mod tests;
