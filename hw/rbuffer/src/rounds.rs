//! The rounds: what part of the screen is blended each time that a frame is sent.
//!
//! ```text
//!  overflowed ------->+--------+
//!  stored, roomy ---->| Rounds |---> from, to (the band of pixels), failed
//!  passes done ------>|        |---> ends, done
//!  an item comes ---->|        |---> replay
//!                     +--------+
//! ```
//! With `overflow=replay` a round takes the fragments of a band of pixels, at first of all. If they do not
//! fit into the queue the round has failed: the rest of it is passed over, what is in the queue is thrown
//! away, and the frame is asked for again with a band of half as many pixels. Once a band is blended, the
//! frame is asked for again for the next one, of as many pixels, or of twice as many if half of the queue
//! was free; until there is none. `replay` is high until its first item comes. Of a band of one pixel what does not fit is dropped. With
//! `overflow=outside` there is one round ([`once`]) and nothing of this block.

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
    /// It is asked for again.
    pub replay: bool,
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
    /// An item of the frame comes.
    pub comes: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Moore {
    /// The band's first pixel.
    #[width(cfg.band_bits())]
    pub from: u32,
    /// The pixel behind its last.
    #[width(cfg.band_bits())]
    pub to: u32,
    /// The band's fragments do not fit: the rest of the round is passed over.
    pub failed: bool,
    /// The band cannot be made smaller: what does not fit is dropped.
    pub smallest: bool,
    /// The frame came before.
    pub again: bool,
    /// What comes next is the same frame again, from its first item.
    pub replay: bool,
}

/// What is seen where the frame is sent once: all pixels are the band, and what does not fit is dropped.
pub fn once(cfg: &Config) -> Moore {
    let to = cfg.screen.pixels();
    Moore { from: 0, to, failed: false, smallest: true, again: false, replay: false }
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The round ends, and the frame is to be sent again.
    pub ends: bool,
    /// The frame's last band is blended.
    pub done: bool,
}

#[rtl(
    input = (),
    output = (),
    check(Rounds, crate::test_util::small_rbuffer(4, None))
)]
impl Block for Rounds {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let to = cfg.screen.pixels();
        State { from: 0, to, failed: false, roomy: false, again: false, replay: false }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        let smallest = q.from + 1 == q.to;
        let State { from, to, failed, again, replay, .. } = *q;
        Moore { from, to, failed, smallest, again, replay }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let whole = q.to == cfg.screen.pixels();
        let ends = i.emptied && (q.failed || !whole);
        d.replay = ends || (q.replay && !i.comes);
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
            d.again = ends;
        }
        Out { ends, done: i.emptied && !ends }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::small_rbuffer;
    use pellucid_sim::Sim;

    /// A round: whether its fragments fit, and whether half of the queue stays free; gives its band, and
    /// whether the frame is asked for again.
    fn round(sim: &mut Sim<Rounds>, fits: bool, roomy: bool) -> (u32, u32, bool) {
        let Moore { from, to, failed, .. } = sim.moore();
        assert!(!failed, "a round begins without a fault");
        let nothing = In { overflowed: false, stored: false, roomy, emptied: false, comes: false };
        // The frame is asked for until its first item comes.
        let asks = sim.moore().again;
        for comes in [false, true] {
            assert_eq!(sim.moore().replay, asks);
            sim.clock(In { comes, ..nothing }).unwrap();
        }
        assert!(!sim.moore().replay);
        sim.clock(In { overflowed: !fits, comes: true, ..nothing }).unwrap();
        assert_eq!((sim.moore().failed, sim.moore().replay), (!fits, false));
        sim.clock(In { stored: true, ..nothing }).unwrap();
        let Out { ends, done } = sim.clock(In { emptied: true, ..nothing }).unwrap().out;
        assert_ne!(ends, done);
        assert_eq!((sim.moore().again, sim.moore().replay), (ends, ends));
        (from, to, ends)
    }

    #[test]
    fn bands_are_halved_until_they_fit_and_grow_where_there_is_room() {
        // 21 pixels.
        let mut sim = Sim::<Rounds>::new(small_rbuffer(4, None));
        for frame in 0..2 {
            assert_eq!(round(&mut sim, false, false), (0, 21, true), "frame {frame}");
            assert_eq!(round(&mut sim, false, false), (0, 10, true));
            assert_eq!(round(&mut sim, true, true), (0, 5, true));
            assert_eq!(round(&mut sim, false, false), (5, 15, true));
            assert_eq!(round(&mut sim, true, false), (5, 10, true));
            assert_eq!(round(&mut sim, true, false), (10, 15, true));
            assert_eq!(round(&mut sim, true, false), (15, 20, true));
            assert_eq!(round(&mut sim, true, false), (20, 21, false));
        }
    }

    #[test]
    fn one_pixel_is_the_smallest_band() {
        let mut sim = Sim::<Rounds>::new(small_rbuffer(4, None));
        for _ in 0..4 {
            assert!(!sim.moore().smallest);
            round(&mut sim, false, false);
        }
        let Moore { from, to, smallest, .. } = sim.moore();
        assert_eq!((from, to, smallest), (0, 1, true));
    }
}
