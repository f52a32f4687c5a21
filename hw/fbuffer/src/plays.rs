//! From play to play: which pass of which window or batch a play of the frame is, and whether the frame is to come again.
//!
//! ```text
//!  an item comes ---->+-------+
//!  over, beyond ----->| Plays |---> play, open, skips, replay
//!  frame done ------->|       |---> again, wasted, finished
//!                     +-------+
//! ```
//! A frame is played once for each pass of each window, windows in order. How many windows there are is known once the
//! first pass of the first one is over, since all fragments are counted in each play. Where a sort leaves fragments for a further
//! round all windows come again. Where fragments come in batches of primitives
//! instead, a batch that has more fragments than places is halved, and its first pass was wasted; a primitive alone is not halved,
//! and what it has beyond the places is lost. All primitives are the first batch.
//!
//! What is opaque is drawn in a frame's first play. That is the first pass of the first window, unless `background` wants its
//! depth complete before: then it is a play of its own.

use crate::window;
use pellucid_sim::{Block, Signals, bits_for, check_range, rtl};

/// See the module's description.
pub struct Plays;

/// Bits of a primitive's number.
const PRIMITIVE_BITS: u32 = 32;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The window.
    pub window: window::Config,
    /// Passes, at least 1.
    pub passes: u32,
    /// What is opaque is drawn in a play of its own.
    pub background: bool,
    /// All windows come again, round after round, while a sort leaves fragments for a further one.
    pub sorts: bool,
}

impl Config {
    /// Bits of a pass's number.
    #[inline]
    pub fn pass_bits(&self) -> u32 {
        bits_for(u64::from(self.passes - 1))
    }
    /// Fragments for which there is no place come again in smaller batches.
    #[inline]
    pub fn batches(&self) -> bool {
        self.window.counts() && !self.window.windows
    }
}

/// What a play is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(window::Config)]
pub struct Play {
    /// Opaque fragments are drawn.
    pub draws: bool,
    /// Transparent fragments of the window are shaded.
    pub shades: bool,
    /// What the pass before has left is read.
    #[exists(cfg.stores())]
    pub reads: bool,
    /// The window: its number, or that of its first fragment where fragments that are killed leave no gap.
    #[width(cfg.window_bits())]
    pub window: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// A frame is at hand.
    pub busy: bool,
    /// The end of the play has come in.
    pub ended: bool,
    /// The frame has come before.
    pub later: bool,
    /// The pass.
    #[width(cfg.pass_bits())]
    pub pass: u32,
    /// The window.
    #[width(cfg.window.window_bits())]
    pub window: u32,
    /// Primitives of the play so far.
    #[width(PRIMITIVE_BITS)]
    #[exists(cfg.batches())]
    pub primitive: u32,
    /// The batch's first primitive.
    #[width(PRIMITIVE_BITS)]
    #[exists(cfg.batches())]
    pub first: u32,
    /// Primitives of a batch, at most.
    #[width(PRIMITIVE_BITS)]
    #[exists(cfg.batches())]
    pub length: u32,
    /// The frame is asked for again.
    pub replay: bool,
    /// The frame's last play is over.
    pub finished: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A primitive or the end of the frame is taken.
    pub comes: bool,
    /// It is the end.
    pub end: bool,
    /// All of the play went through.
    pub over: bool,
    /// It had transparent fragments behind its window.
    #[exists(cfg.window.counts())]
    pub beyond: bool,
    /// The number behind the last one of the window, with which the next one begins.
    #[width(window::COUNT_BITS)]
    #[exists(cfg.window.compacts)]
    pub next_window: u32,
    /// There are fragments for a further round.
    #[exists(cfg.sorts)]
    pub left: bool,
    /// The frame is complete and is shown from the next cycle on.
    pub done: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What the play is.
    #[with(cfg.window)]
    pub play: Play,
    /// Its pass.
    #[width(cfg.pass_bits())]
    pub pass: u32,
    /// It is the last pass: shaded fragments are tested and blended.
    pub last: bool,
    /// A frame is at hand.
    pub busy: bool,
    /// Primitives may come.
    pub open: bool,
    /// The primitive that comes next is not of the batch.
    #[exists(cfg.batches())]
    pub skips: bool,
    /// What comes next is the same frame again.
    pub replay: bool,
    /// The frame's last play was over before this cycle.
    pub finished: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The frame is to come again.
    pub again: bool,
    /// The batch did not fit.
    pub wasted: bool,
    /// The frame's last play is over.
    pub finished: bool,
}

#[rtl(
    output = (),
    check(Plays, crate::test_util::plays(3, true, false)),
    check(Plays, crate::test_util::plays(2, false, true)),
    check(Plays, crate::test_util::plays(1, true, true)),
    check(Plays, Config { window: crate::test_util::compacting(2), ..crate::test_util::plays(2, true, false) })
)]
impl Block for Plays {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        check_range("the number of passes", cfg.passes, 1..);
        State {
            busy: false,
            ended: false,
            later: false,
            pass: 0,
            window: 0,
            primitive: 0,
            first: 0,
            length: u32::MAX,
            replay: false,
            finished: false,
        }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let background = cfg.background && !q.later;
        let last = !background && q.pass + 1 == cfg.passes;
        let play =
            Play { draws: !q.later, shades: !background, reads: q.pass > 0, window: q.window };
        let behind = q.primitive >= q.first && q.primitive - q.first >= q.length;
        Moore {
            play,
            pass: q.pass,
            last,
            busy: q.busy,
            open: !q.ended,
            skips: cfg.batches() && (q.primitive < q.first || behind),
            replay: q.replay,
            finished: q.finished,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let Moore { last, play, .. } = Self::moore(cfg, q, &());
        if i.comes {
            d.busy = true;
            d.replay = false;
            if i.end {
                d.ended = true;
            } else if cfg.batches() {
                d.primitive = q.primitive + 1;
            }
        }

        // The batch, and whether it fits.
        let left = q.primitive.saturating_sub(q.first);
        let covered = left.min(q.length);
        let first_pass = play.shades && q.pass == 0;
        let wasted = i.over && cfg.batches() && first_pass && i.beyond && covered > 1;

        // What is left when its last pass is over.
        let further = if cfg.batches() { left > covered } else { i.beyond };
        let round = cfg.sorts && i.left && !further;
        let again = i.over && (!last || further || wasted || round);
        let finished = i.over && !again;
        if i.over {
            d.later = true;
            d.ended = finished;
            d.replay = again;
            d.finished = finished;
            d.primitive = 0;
            if wasted {
                d.length = covered - (covered >> 1);
            } else if play.shades && !last {
                d.pass = q.pass + 1;
            } else if last && (further || round) {
                d.pass = 0;
                if cfg.window.windows {
                    let behind = if cfg.window.compacts { i.next_window } else { q.window + 1 };
                    d.window = if round { 0 } else { behind };
                }
                d.first = q.first + covered;
            }
        }
        if i.done {
            d.busy = false;
            d.ended = false;
            d.later = false;
            d.pass = 0;
            d.window = 0;
            d.first = 0;
            d.length = u32::MAX;
            d.finished = false;
        }
        Out { again, wasted, finished }
    }
}

#[cfg(test)]
mod tests;
