//! Bucket sort: transparent primitives by the first scan line that is this engine's.
//!
//! ```text
//!                +------------+
//!  primitive --->| BucketSort |---> insert (for the buckets), done
//!  ready <-------|            |
//!                +------------+
//! ```
//! Of `engines` scan-line engines the one with number `index` has the rows `index`, `index + engines`, and
//! so on: its lines 0, 1, ... A primitive is moved on to the first of them, and its steps from row to row
//! become steps from line to line, which are added up one row a cycle: so each takes `engines` cycles. A
//! primitive that has no such row is left out.

use crate::buckets::{self, Insert};
use pellucid_machine::pixel::{Marked, Screen};
use pellucid_machine::primitive::{
    BOUND_BITS, Edge, Format, HEIGHT_BITS, Primitive, below, moved_down, times,
};
use pellucid_sim::{Block, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct BucketSort;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Scan-line engines, 1 up to the rows of the screen.
    pub engines: u32,
    /// Which of them this is, below `engines`.
    pub index: u32,
    /// Primitives that the buckets hold, at least 1.
    pub capacity: u32,
}

/// Bits behind the point of a reciprocal: enough for the quotient of any row and any number of engines up to
/// half of the most rows to be exact.
const RECIPROCAL_BITS: u32 = 26;

impl Config {
    /// The engine's scan lines, at least 1.
    pub fn lines(&self) -> u32 {
        (self.screen.height - self.index).div_ceil(self.engines)
    }
    /// The buckets.
    pub fn buckets(&self) -> buckets::Config<Format> {
        let size = buckets::Size { positions: self.lines(), capacity: self.capacity };
        buckets::Config { size, item: Format::transparent(self.screen) }
    }
    fn reciprocal(&self) -> u64 {
        (1 << RECIPROCAL_BITS) / u64::from(self.engines) + 1
    }
    fn step_bits(&self) -> u32 {
        bits_for(u64::from(self.engines - 1))
    }
}

/// `row / engines`, rounded down.
#[inline(always)]
#[rtl]
fn quotient(row: u32, reciprocal: u64) -> u32 {
    ((u64::from(row) * reciprocal) >> RECIPROCAL_BITS) as u32
}

/// What an edge gains from line to line.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(())]
pub struct Gain {
    /// Its bound.
    #[width(BOUND_BITS)]
    pub bound: u64,
    /// The remainder of it.
    #[width(HEIGHT_BITS)]
    pub rest: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The primitive at hand, moved on as far as it is: its rows are the engine's lines.
    #[with(Format::transparent(cfg.screen))]
    pub primitive: Stream<Primitive>,
    /// It has a line.
    pub there: bool,
    /// Rows that it is still to be moved on by.
    #[width(cfg.step_bits())]
    pub rows: u32,
    /// What its edges gain, as far as it is added up.
    pub gain: [Gain; 3],
    /// Rows that are still to be added to that.
    #[width(cfg.step_bits())]
    pub steps: u32,
    /// The end of the frame has come.
    pub done: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Transparent primitives, then the end of the frame.
    #[with(Format::transparent(cfg.screen))]
    pub primitive: Stream<Marked<Primitive>>,
    /// The next frame may come. Only while `done`.
    pub restart: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A primitive is taken.
    pub ready: bool,
    /// A primitive from the engine's first line of it on: rows are the engine's lines.
    #[with(cfg.buckets())]
    pub insert: Stream<Insert<Primitive>>,
    /// The frame is sorted.
    pub done: bool,
}

/// What an edge gains in a row.
#[inline(always)]
#[rtl]
fn gained(edge: Edge) -> Gain {
    Gain { bound: edge.bound_step, rest: edge.rest_step }
}

/// What it gains in a row more.
#[inline(always)]
#[rtl]
fn more(edge: Edge, gain: Gain) -> Gain {
    let mut gained = edge;
    gained.bound = gain.bound;
    gained.rest = gain.rest;
    let gained = below(gained);
    Gain { bound: gained.bound, rest: gained.rest }
}

/// An edge that gains so much with each step.
#[inline(always)]
#[rtl]
fn gaining(edge: Edge, gain: Gain) -> Edge {
    let mut edge = edge;
    edge.bound_step = gain.bound;
    edge.rest_step = gain.rest;
    edge
}

#[rtl(
    check(BucketSort, Config {
        screen: crate::test_util::screen(7, 5), engines: 1, index: 0, capacity: 4
    }),
    check(BucketSort, Config {
        screen: crate::test_util::screen(3, 11), engines: 3, index: 1, capacity: 4
    })
)]
impl Block for BucketSort {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let Config { screen, engines, index, .. } = *cfg;
        screen.check();
        check_range("the number of scan-line engines", engines, 1..=screen.height);
        check_range("the index of a scan-line engine", index, ..=engines - 1);
        State {
            primitive: Stream::idle(),
            there: false,
            rows: 0,
            gain: [Gain::default(); 3],
            steps: 0,
            done: false,
        }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let mut item = q.primitive.payload;
        let [a, b, c] = item.edges;
        let [to_a, to_b, to_c] = q.gain;
        item.edges = [gaining(a, to_a), gaining(b, to_b), gaining(c, to_c)];
        item.per_row = times(item.per_row, cfg.engines);
        let is_ready = q.primitive.valid && q.steps == 0;
        Moore {
            ready: (!q.primitive.valid || is_ready) && !q.done,
            insert: Stream {
                valid: is_ready && q.there,
                payload: Insert { position: item.row, item },
            },
            done: q.done && !q.primitive.valid,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) {
        if q.primitive.valid && q.steps > 0 {
            let [a, b, c] = q.primitive.payload.edges;
            let [to_a, to_b, to_c] = q.gain;
            d.gain = [more(a, to_a), more(b, to_b), more(c, to_c)];
            d.steps = q.steps - 1;
            if q.rows > 0 {
                d.primitive.payload = moved_down(q.primitive.payload);
                d.rows = q.rows - 1;
            }
        } else {
            let Marked { end, item } = i.primitive.payload;
            let takes = i.primitive.valid && !q.done;
            d.primitive = Stream { valid: takes && !end, payload: item };
            d.done = q.done || (takes && end);
            if takes {
                // Rows are counted from the engine's own first one: one before it is in no line.
                let line = quotient(item.row, cfg.reciprocal());
                let past = item.row - line * cfg.engines;
                let first = if past > cfg.index { line + 1 } else { line };
                let before = item.last_row < cfg.index;
                let last =
                    if before { 0 } else { quotient(item.last_row - cfg.index, cfg.reciprocal()) };
                d.there = !before && first <= last;
                d.primitive.payload.row = first;
                d.primitive.payload.last_row = last;
                d.rows = if past > cfg.index {
                    cfg.engines + cfg.index - past
                } else {
                    cfg.index - past
                };
                let [a, b, c] = item.edges;
                d.gain = [gained(a), gained(b), gained(c)];
                d.steps = cfg.engines - 1;
            }
        }
        if i.restart {
            d.done = false;
        }
    }
}

#[cfg(test)]
mod tests;
