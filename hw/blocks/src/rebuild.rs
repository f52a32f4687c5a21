//! Rebuilding: what a frame may use of a memory grows until the frame fits, and each time the frame is played again.
//!
//! ```text
//!  lacking, asked --->+---------+
//!  ended, resolved -->| Rebuild |---> step, limit, replay
//!  an item comes ---->|         |---> clear (entry by entry), again, begins
//!  clear_ready ------>+---------+
//! ```
//! A play in which something lacked is not resolved while the limit can grow: the entries of the machine's table are cleared,
//! one after the other as the table takes them, and the frame is asked for again. `replay` is high until its first item comes. What lacked in a play
//! that is resolved is lost. The limit stays where it has come to, for the frames that follow.

use pellucid_machine::{PhaseInfo, choice};
use pellucid_sim::{Block, Signals, Stream, bits_for, check_range, rtl};

choice! {
    /// What happens to fragments for which there is no room.
    pub enum Overflow {
        /// The frame is played again with more room, while there is more.
        Rebuild = "rebuild",
        /// They are dropped.
        Drop = "drop",
    }
}

choice! {
    /// How much may be used once something lacked.
    pub enum Growth {
        /// Twice as much as before.
        Double = "double",
        /// Twice what the last play asked for.
        Needed = "needed",
    }
}

/// What a machine is at while entries are cleared.
pub const PHASE: PhaseInfo = PhaseInfo {
    name: "rebuild",
    about: "Clearing the table of a frame that did not fit, before it comes again with more room.",
    works: true,
    counts: true,
};

/// See the module's description.
pub struct Rebuild;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// How much may be used to begin with, at least 1.
    pub begin: u32,
    /// The most that may be used, at least as much. Where it is no more nothing is ever rebuilt.
    pub most: u32,
    /// How it grows.
    pub growth: Growth,
    /// Entries to clear before the frame comes again, at least 1.
    pub entries: u32,
}

impl Config {
    /// Whether the limit can grow at all.
    #[inline]
    pub fn rebuilds(&self) -> bool {
        self.most > self.begin
    }
    /// Bits of the limit.
    #[inline]
    pub fn limit_bits(&self) -> u32 {
        bits_for(u64::from(self.most))
    }
    /// Bits of an entry's number.
    #[inline]
    pub fn entry_bits(&self) -> u32 {
        bits_for(u64::from(self.entries - 1))
    }
}

#[rtl]
impl Config {
    /// The limit after `limit`, where `asked` was asked for.
    #[inline(always)]
    fn grown(&self, limit: u32, asked: u32) -> u32 {
        let half = if self.growth == Growth::Double { limit } else { asked };
        if half > self.most / 2 { self.most } else { half * 2 }
    }
}

/// What is done with a play of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Step {
    /// It is stored.
    #[default]
    Store,
    /// Something lacked: the table's entries are cleared.
    Clear,
    /// It is resolved.
    Resolve,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What is done.
    pub step: Step,
    /// Something lacked in this play.
    #[exists(cfg.rebuilds())]
    pub lacked: bool,
    /// How much may be used.
    #[width(cfg.limit_bits())]
    #[exists(cfg.rebuilds())]
    pub limit: u32,
    /// The entry that is cleared next.
    #[width(cfg.entry_bits())]
    #[exists(cfg.rebuilds())]
    pub entry: u32,
    /// The frame is asked for again.
    #[exists(cfg.rebuilds())]
    pub replay: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct In {
    /// There was no room for a fragment.
    pub lacking: bool,
    /// What the play has asked for in all, more than the limit if something lacked. Looked at when it has ended, where the
    /// limit grows by what is [`Needed`](Growth::Needed).
    #[width(32)]
    pub asked: u32,
    /// All fragments of the play have come.
    pub ended: bool,
    /// The frame's last pixel is written.
    pub resolved: bool,
    /// An item of the frame comes.
    pub comes: bool,
    /// The entry that is to be cleared is.
    pub clear_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What is done.
    pub step: Step,
    /// How much may be used.
    #[width(cfg.limit_bits())]
    pub limit: u32,
    /// What comes next is the same frame again, from its first item.
    pub replay: bool,
    /// The entry that is cleared.
    #[with(cfg.entry_bits())]
    pub clear: Stream<u32>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Out {
    /// The frame is to be sent again.
    pub again: bool,
    /// The play has ended and is resolved.
    pub begins: bool,
}

#[rtl(
    check(Rebuild, Config { begin: 3, most: 10, growth: Growth::Double, entries: 5 }),
    check(Rebuild, Config { begin: 1, most: 7, growth: Growth::Needed, entries: 1 }),
    check(Rebuild, Config { begin: 4, most: 4, growth: Growth::Double, entries: 5 })
)]
impl Block for Rebuild {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        check_range("what may be used to begin with", cfg.begin, 1..=cfg.most);
        check_range("the number of entries to clear", cfg.entries, 1..);
        State { step: Step::Store, lacked: false, limit: cfg.begin, entry: 0, replay: false }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        if cfg.rebuilds() {
            let clear = Stream { valid: q.step == Step::Clear, payload: q.entry };
            Moore { step: q.step, limit: q.limit, replay: q.replay, clear }
        } else {
            Moore { step: q.step, limit: cfg.begin, replay: false, clear: Stream::idle() }
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out { again: false, begins: false };
        match q.step {
            Step::Store => {
                let lacked = cfg.rebuilds() && (q.lacked || i.lacking);
                d.lacked = lacked && !i.ended;
                if i.ended && lacked && q.limit < cfg.most {
                    d.step = Step::Clear;
                    d.limit = cfg.grown(q.limit, i.asked);
                    d.entry = 0;
                } else if i.ended {
                    d.step = Step::Resolve;
                    o.begins = true;
                }
            }
            Step::Clear => {
                o.again = cfg.rebuilds() && i.clear_ready && q.entry == cfg.entries - 1;
                if o.again {
                    d.step = Step::Store;
                } else if i.clear_ready {
                    d.entry = q.entry + 1;
                }
            }
            Step::Resolve => {
                if i.resolved {
                    d.step = Step::Store;
                }
            }
        }
        d.replay = o.again || (q.replay && !i.comes);
        o
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;
    use proptest::prelude::*;

    const NOTHING: In = In {
        lacking: false,
        asked: 0,
        ended: false,
        resolved: false,
        comes: false,
        clear_ready: true,
    };

    #[test]
    fn a_frame_that_fits_the_second_time_goes_its_course_cycle_by_cycle() {
        let comes = In { comes: true, ..NOTHING };
        let lacking = In { lacking: true, ..NOTHING };
        let ended = In { ended: true, ..NOTHING };
        let resolved = In { resolved: true, ..NOTHING };
        let waits = In { clear_ready: false, ..NOTHING };
        let cfg = Config { begin: 3, most: 10, growth: Growth::Double, entries: 2 };
        let mut sim = Sim::<Rebuild>::new(cfg);
        for (cycle, (i, step, limit, replay, clear, (again, begins))) in [
            (comes, Step::Store, 3, false, None, (false, false)),
            (lacking, Step::Store, 3, false, None, (false, false)),
            (NOTHING, Step::Store, 3, false, None, (false, false)),
            (ended, Step::Store, 3, false, None, (false, false)),
            (NOTHING, Step::Clear, 6, false, Some(0), (false, false)),
            (NOTHING, Step::Clear, 6, false, Some(1), (true, false)),
            (NOTHING, Step::Store, 6, true, None, (false, false)),
            (comes, Step::Store, 6, true, None, (false, false)),
            (ended, Step::Store, 6, false, None, (false, true)),
            (NOTHING, Step::Resolve, 6, false, None, (false, false)),
            (resolved, Step::Resolve, 6, false, None, (false, false)),
            // The next frame begins with what the one before has come to.
            (comes, Step::Store, 6, false, None, (false, false)),
            (In { lacking: true, ..ended }, Step::Store, 6, false, None, (false, false)),
            (waits, Step::Clear, 10, false, Some(0), (false, false)),
            (NOTHING, Step::Clear, 10, false, Some(0), (false, false)),
            (waits, Step::Clear, 10, false, Some(1), (false, false)),
            (NOTHING, Step::Clear, 10, false, Some(1), (true, false)),
            // There is no more: what lacks now is lost.
            (In { lacking: true, ..comes }, Step::Store, 10, true, None, (false, false)),
            (ended, Step::Store, 10, false, None, (false, true)),
            (resolved, Step::Resolve, 10, false, None, (false, false)),
            (ended, Step::Store, 10, false, None, (false, true)),
        ]
        .into_iter()
        .enumerate()
        {
            let seen = sim.moore();
            let out = sim.clock(i).unwrap().out;
            let cleared = seen.clear.valid.then_some(seen.clear.payload);
            assert_eq!(
                (seen.step, seen.limit, seen.replay, cleared, (out.again, out.begins)),
                (step, limit, replay, clear, (again, begins)),
                "in cycle {cycle}"
            );
        }
    }

    /// The limits of the plays of a frame that needs `need`.
    fn limits(cfg: Config, need: u32) -> Vec<u32> {
        let mut sim = Sim::<Rebuild>::new(cfg);
        let mut limits = Vec::new();
        loop {
            let limit = sim.moore().limit;
            limits.push(limit);
            let ended = In { lacking: need > limit, asked: need, ended: true, ..NOTHING };
            if sim.clock(ended).unwrap().out.begins {
                return limits;
            }
            while !sim.clock(NOTHING).unwrap().out.again {}
        }
    }

    proptest! {
        #[test]
        fn doubling_takes_the_logarithm_of_what_is_missing(
            begin in 1_u32..50, more in 0_u32..1000, need in 1_u32..1200,
        ) {
            let most = begin + more;
            let cfg = Config { begin, most, growth: Growth::Double, entries: 3 };
            let enough = need.min(most);
            let rebuilds = (f64::from(enough) / f64::from(begin)).log2().ceil().max(0.0) as usize;
            let found = limits(cfg, need);
            let last = *found.last().unwrap();
            prop_assert!(last >= enough);
            prop_assert_eq!(found.len() - 1, rebuilds);
        }

        #[test]
        fn what_is_needed_is_there_at_the_second_play(
            begin in 1_u32..50, more in 0_u32..1000, need in 1_u32..1200,
        ) {
            let most = begin + more;
            let cfg = Config { begin, most, growth: Growth::Needed, entries: 3 };
            let expected = match need > begin && most > begin {
                true => vec![begin, most.min(2 * need)],
                false => vec![begin],
            };
            prop_assert_eq!(limits(cfg, need), expected);
        }
    }
}
