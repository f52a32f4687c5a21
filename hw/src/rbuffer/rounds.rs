//! The rounds: what part of the screen is blended each time that a frame is sent.
//!
//! ```text
//!  overflowed ------->+--------+
//!  stored, roomy ---->| Rounds |---> from, to (the band of pixels), failed
//!  passes done ------>|        |---> replay, done
//!                     +--------+
//! ```
//! With `overflow=replay` a round takes the fragments of a band of pixels, at first of all. If they do not
//! fit into the queue the round has failed: the rest of it is passed over, what is in the queue is thrown
//! away, and the frame is asked for again with a band of half as many pixels. Once a band is blended, the
//! frame is asked for again for the next one, of as many pixels, or of twice as many if half of the queue
//! was free; until there is none. Of a band of one pixel what does not fit is dropped. With
//! `overflow=outside` there is one round.

use super::config::Config;
use pellucid_sim::{Block, Signals, rtl};

/// See the module's description.
pub struct Rounds;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The band's first pixel.
    #[width(cfg.band_bits())]
    pub from: u32,
    /// The pixel behind its last.
    #[width(cfg.band_bits())]
    pub to: u32,
    /// The band's fragments do not fit.
    pub failed: bool,
    /// They took half of the queue at most.
    pub roomy: bool,
    /// The frame came before.
    pub again: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A fragment of the band does not fit.
    pub overflowed: bool,
    /// The frame's arrivals have ended.
    pub stored: bool,
    /// Half of the queue is free.
    pub roomy: bool,
    /// Nothing is left in the queue.
    pub emptied: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The band's first pixel.
    #[width(cfg.band_bits())]
    pub from: u32,
    /// The pixel behind its last.
    #[width(cfg.band_bits())]
    pub to: u32,
    /// The band's fragments do not fit: the rest of the round is passed over.
    pub failed: bool,
    /// The band cannot be made smaller, or need not: what does not fit is dropped.
    pub smallest: bool,
    /// The frame came before.
    pub again: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The frame is to be sent again.
    pub replay: bool,
    /// The frame's last band is blended.
    pub done: bool,
}

#[rtl(
    input = (),
    output = (),
    check(Rounds, crate::test_util::small_rbuffer(4, None)),
    check(Rounds, crate::test_util::small_rbuffer(4, Some(7)))
)]
impl Block for Rounds {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        State { from: 0, to: cfg.screen.pixels(), failed: false, roomy: false, again: false }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let smallest = !cfg.replay || q.from + 1 == q.to;
        Moore { from: q.from, to: q.to, failed: q.failed, smallest, again: q.again }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let whole = q.to == cfg.screen.pixels();
        let replay = i.emptied && (q.failed || !whole);
        if cfg.replay {
            d.failed = (q.failed || i.overflowed) && !i.emptied;
            if i.stored {
                d.roomy = i.roomy;
            }
            if i.emptied {
                let size = q.to - q.from;
                if q.failed {
                    d.to = q.from + (size >> 1);
                } else if whole {
                    d.from = 0;
                    d.to = cfg.screen.pixels();
                } else {
                    let next = if q.roomy { size << 1 } else { size };
                    d.from = q.to;
                    d.to = if next < cfg.screen.pixels() - q.to {
                        q.to + next
                    } else {
                        cfg.screen.pixels()
                    };
                }
                d.again = replay;
            }
        }
        Out { replay, done: i.emptied && !replay }
    }
}
