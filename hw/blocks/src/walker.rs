//! Set-up and edge walk: primitives become fragments, row by row from left to right.
//!
//! ```text
//!                +--------+
//!  primitive --->|        |---> fragment (Stream)
//!  ready <-------| Walker |<--- fragment_ready
//!                +--------+
//! ```
//! A primitive is set up for `set_up_cycles`, beside the walk of the one before; the numbers that it comes
//! with are those of [`primitive`](pellucid_machine::primitive) already, so that of this unit just the time is
//! modelled. Then it gives a fragment every `fragment_cycles` cycles, without a break between rows, nor behind a
//! primitive that takes `set_up_cycles` or more; a row without pixels takes a cycle.

use pellucid_machine::pixel::{Fragment, Marked, Screen};
use pellucid_machine::primitive::{
    Attributes, Format, Primitive, Span, colour, depth, next_row, plus, span, times,
};
use pellucid_sim::{Block, Label, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct Walker;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Cycles that a primitive's set-up takes, at least 1.
    pub set_up_cycles: u32,
    /// Cycles from fragment to fragment, at least 1.
    pub fragment_cycles: u32,
}

impl Config {
    fn set_up_bits(&self) -> u32 {
        bits_for(u64::from(self.set_up_cycles - 1))
    }
    fn fragment_bits(&self) -> u32 {
        bits_for(u64::from(self.fragment_cycles - 1))
    }
}

/// What is being walked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Walk {
    /// The row.
    #[width(cfg.y_bits())]
    pub row: u32,
    /// The column.
    #[width(cfg.x_bits())]
    pub column: u32,
    /// The row's last column.
    #[width(cfg.x_bits())]
    pub last: u32,
    /// What the primitive has there.
    pub at: Attributes,
    /// What that gains with each column.
    pub per_column: Attributes,
    /// All of it hides what lies behind it.
    pub opaque: bool,
    /// Which primitive it is, in waveforms.
    pub label: Label,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The primitive that is being set up.
    #[with(Format::drawn(cfg.screen))]
    pub next: Stream<Marked<Primitive>>,
    /// Cycles that its set-up still takes.
    #[width(cfg.set_up_bits())]
    pub set_up: u32,
    /// The primitive at hand, from the row after the present one on, if there is one.
    #[with(Format::drawn(cfg.screen))]
    pub rows: Stream<Primitive>,
    /// The fragment at hand, or the end of the frame.
    #[with(cfg.screen)]
    pub walk: Stream<Marked<Walk>>,
    /// Cycles until it is given.
    #[width(cfg.fragment_bits())]
    pub pause: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Primitives, then the end of the frame.
    #[with(Format::drawn(cfg.screen))]
    pub primitive: Stream<Marked<Primitive>>,
    /// The receiver takes a fragment.
    pub fragment_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Fragments, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<Fragment>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The primitive is taken.
    pub taken: bool,
}

#[rtl(
    output = (),
    check(Walker, Config {
        screen: crate::test_util::screen(7, 5), set_up_cycles: 1, fragment_cycles: 1
    }),
    check(Walker, Config {
        screen: crate::test_util::screen(7, 5), set_up_cycles: 4, fragment_cycles: 3
    })
)]
impl Block for Walker {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        cfg.screen.check();
        check_range("the number of cycles of a set-up", cfg.set_up_cycles, 1..);
        check_range("the number of cycles of a fragment", cfg.fragment_cycles, 1..);
        State {
            next: Stream::idle(),
            set_up: 0,
            rows: Stream::idle(),
            walk: Stream::idle(),
            pause: 0,
        }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        let Marked { end, item: walk } = q.walk.payload;
        let item = Fragment {
            x: walk.column,
            y: walk.row,
            z: depth(walk.at),
            rgba: colour(walk.at, walk.opaque),
            label: walk.label,
        };
        let valid = q.walk.valid && q.pause == 0;
        Moore { fragment: Stream { valid, payload: Marked { end, item } } }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        // Along the row.
        let Marked { end, item: walk } = q.walk.payload;
        let given = q.walk.valid && q.pause == 0 && i.fragment_ready;
        let ends = given && (end || walk.column == walk.last);
        if given {
            d.pause = cfg.fragment_cycles - 1;
            d.walk.payload.item.column = if ends { 0 } else { walk.column + 1 };
            d.walk.payload.item.at = plus(walk.at, walk.per_column);
        } else if q.pause > 0 {
            d.pause = q.pause - 1;
        }

        // To the next row, of this primitive or of the next one.
        let wants = !q.walk.valid || ends;
        let next = q.next.payload.item;
        let is_set_up = q.next.valid && q.set_up == 0;
        let begins = wants && !q.rows.valid && is_set_up;
        if wants {
            let ends_frame = begins && q.next.payload.end;
            let primitive = if q.rows.valid { q.rows.payload } else { next };
            let there = q.rows.valid || (begins && !q.next.payload.end);
            let Span { empty, first, last } = span(primitive.edges, cfg.screen.width);
            let Primitive { row, last_row, at, per_column, opaque, label, .. } = primitive;
            let at = plus(at, times(per_column, first));
            let item = Walk { row, column: first, last, at, per_column, opaque, label };
            d.walk = Stream {
                valid: ends_frame || (there && !empty),
                payload: Marked { end: ends_frame, item },
            };
            d.rows = Stream { valid: there && row != last_row, payload: next_row(primitive) };
        }

        // Set-up.
        let free = !q.next.valid || begins;
        if free {
            d.next = i.primitive;
            d.set_up = cfg.set_up_cycles - 1;
        } else if q.set_up > 0 {
            d.set_up = q.set_up - 1;
        }
        Out { taken: free }
    }
}

#[cfg(test)]
mod tests;
