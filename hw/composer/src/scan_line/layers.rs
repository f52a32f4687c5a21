//! The layers of a scan line's pixels: for each pixel its opaque fragment and the transparent ones, in as many
//! passes as the sorter needs.
//!
//! ```text
//!              +--------+
//!  opaque ---->|        |---> arrived (Stream, for the sorter)
//!  count ----->| Layers |<--- arrived_ready
//!  item ------>|        |---> take, back, next (for the sweep along the line)
//!              +--------+
//! ```
//! The opaque fragment goes first, at the far plane: it is blended first, and covers the pixel. Transparent
//! ones are visible if they are nearer than its depth. Where there are more than one pass of the sorter
//! takes, a round more goes before, in which the visible ones are counted.

use super::super::merging_unit::Opaque;
use pellucid_blocks::sorter;
use pellucid_machine::pixel::{Arrived, Marked, Screen, Z_FAR};
use pellucid_machine::primitive::{Attributes, colour, depth, plus};
use pellucid_sim::{Block, Label, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct Layers;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The scan line: a screen of one row.
    pub line: Screen,
    /// Fragments that the sorter takes in a pass, 1..=[`sorter::MAX_DEPTH`].
    pub sorter_depth: u32,
    /// Transparent fragments that a pixel may have.
    pub layers: u32,
}

impl Config {
    /// Bits of how many transparent fragments a pixel may have.
    pub fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.layers))
    }
    fn covered_bits(&self) -> u32 {
        bits_for(u64::from(self.layers) + sorter::MAX_DEPTH as u64)
    }
}

/// The columns of a primitive in a scan line, from one of them on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Segment {
    /// The last column.
    #[width(cfg.x_bits())]
    pub last: u32,
    /// What the primitive has in the column.
    pub at: Attributes,
    /// What that gains with each column.
    pub per_column: Attributes,
    /// Which primitive it is, in waveforms.
    pub label: Label,
}

/// Why a pixel's fragments are gone through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Round {
    /// For the first time.
    #[default]
    First,
    /// To count those that are visible.
    Count,
    /// In one of several passes.
    Pass,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The pixel's column.
    #[width(cfg.line.x_bits())]
    pub column: u32,
    /// Why its fragments are gone through.
    pub round: Round,
    /// The opaque fragment was given in this round.
    pub begun: bool,
    /// Transparent fragments that are visible, as far as they were counted.
    #[width(cfg.count_bits())]
    pub visible: u32,
    /// Fragments that the passes up to this one take.
    #[width(cfg.covered_bits())]
    pub covered: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// The pixel's opaque fragment.
    pub opaque: Stream<Opaque>,
    /// The sweep is at the pixel.
    pub open: bool,
    /// Transparent fragments that are still to be gone through in this round.
    #[width(cfg.count_bits() + 1)]
    pub count: u32,
    /// The next one of them.
    #[with(cfg.line)]
    pub item: Stream<Segment>,
    /// The receiver takes a fragment.
    pub arrived_ready: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Fragments, pixel by pixel.
    #[with(0, 0)]
    pub arrived: Stream<Marked<Arrived>>,
    /// The transparent fragment at hand is taken.
    pub take: bool,
    /// What stays of it.
    #[with(cfg.line)]
    pub back: Stream<Segment>,
    /// The pixel is complete.
    pub next: bool,
    /// A transparent fragment was given for the last time.
    pub fragment: bool,
    /// It is hidden.
    pub hidden: bool,
}

#[rtl(
    check(Layers, Config { line: crate::test_util::screen(5, 1), sorter_depth: 2, layers: 7 }),
    check(Layers, Config { line: crate::test_util::screen(1, 1), sorter_depth: 1, layers: 3 })
)]
impl Block for Layers {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let most = sorter::MAX_DEPTH as u32;
        check_range("the number of fragments of a pass", cfg.sorter_depth, 1..=most);
        State { column: 0, round: Round::First, begun: false, visible: 0, covered: 0 }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, _: &State, (): &()) {}

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let here = i.open && i.opaque.valid;
        let Segment { last, at, per_column, label } = i.item.payload;
        let z = depth(at);
        let visible = z < i.opaque.payload.z;
        let many = q.round == Round::First && !q.begun && i.count + 1 > cfg.sorter_depth;
        let counts = q.round == Round::Count || many;
        let last_pass = q.round == Round::First || q.covered > q.visible;

        // What is given: the opaque fragment, then the transparent ones.
        let opaque = Arrived {
            pixel: 0,
            z: Z_FAR,
            rgba: i.opaque.payload.colour << 8 | 0xff,
            weight: 0,
            visible: true,
            last: i.count == 0,
            last_pass,
            label: Label::NONE,
        };
        let transparent = Arrived {
            pixel: 0,
            z,
            rgba: colour(at, false),
            weight: 0,
            visible,
            last: i.count == 1,
            last_pass,
            label,
        };
        let item = if q.begun { transparent } else { opaque };
        let arrived = Stream { valid: here && !counts, payload: Marked { end: false, item } };
        let given = arrived.valid && i.arrived_ready;

        let take = here && (counts || (given && q.begun));
        let ends = (take && i.count == 1) || (given && i.count == 0);
        let next = ends && !counts && last_pass;
        if given && !q.begun {
            d.begun = true;
        }
        if counts && here {
            d.round = if ends { Round::Pass } else { Round::Count };
            d.covered = cfg.sorter_depth;
            if visible {
                d.visible = q.visible + 1;
            }
        } else if next {
            d.round = Round::First;
            d.begun = false;
            d.visible = 0;
            d.column = if q.column + 1 == cfg.line.width { 0 } else { q.column + 1 };
        } else if ends {
            d.begun = false;
            d.covered = q.covered + cfg.sorter_depth;
        }

        // In the last pass it goes on to the next column; in the others it stays as it is.
        let mut moved = i.item.payload;
        moved.at = plus(at, per_column);
        let goes_on = !counts && last_pass;
        Out {
            arrived,
            take,
            back: Stream {
                valid: !goes_on || last > q.column,
                payload: if goes_on { moved } else { i.item.payload },
            },
            next,
            fragment: take && goes_on,
            hidden: take && goes_on && !visible,
        }
    }
}

#[cfg(test)]
mod tests;
