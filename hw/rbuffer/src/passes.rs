//! The passes: sends all that is in the queue through the selector, again and again until nothing is left.
//!
//! ```text
//!  start -------->+--------+
//!  count -------->| Passes |---> items, end (what may be sent), parity, first
//!  taken, ended ->|        |---> done
//!                 +--------+
//! ```
//! A pass of `n` fragments takes `n` cycles and a few to let the last one through. How many there are is
//! looked at when the one before has ended, so that what it pushes back waits for the next.

use super::queue;
use pellucid_sim::Block;
use pellucid_sim::{Signals, rtl};

/// See the module's description.
pub struct Passes;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for the end of a frame's arrivals.
    Idle,
    /// About to begin a pass.
    Begin,
    /// Sending the fragments of a pass, then its end.
    Send,
    /// All are sent; the last ones go through.
    Drain,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(queue::Config)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// Fragments that the pass still has to send.
    #[width(cfg.count_bits())]
    pub left: u32,
    /// Parity of the pass.
    pub parity: bool,
    /// It is the frame's first.
    pub first: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(queue::Config)]
pub struct In {
    /// The frame's arrivals have ended.
    pub start: bool,
    /// How many fragments are in the queue.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// What was offered is taken.
    pub taken: bool,
    /// The pass's end has come through the selector.
    pub ended: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The queue's front is to be sent.
    pub items: bool,
    /// The end of the pass is to be sent.
    pub end: bool,
    /// Parity of the pass.
    pub parity: bool,
    /// It is the frame's first.
    pub first: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// A pass begins with the next cycle.
    pub begins: bool,
    /// Nothing is left.
    pub done: bool,
}

#[rtl(moore = (), output = (), check(Passes, crate::test_util::queue(2, 5, 3)))]
impl Block for Passes {
    type Config = queue::Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(_: &queue::Config) -> State {
        State { fsm: Fsm::Idle, left: 0, parity: false, first: false }
    }

    fn memories(_: &queue::Config) {}

    fn moore(_: &queue::Config, q: &State, (): &()) -> Moore {
        let send = q.fsm == Fsm::Send;
        Moore {
            items: send && q.left > 0,
            end: send && q.left == 0,
            parity: q.parity,
            first: q.first,
        }
    }

    fn next(_: &queue::Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let (mut begins, mut done) = (false, false);
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Begin;
                    d.first = true;
                }
            }
            Fsm::Begin => {
                if i.count == 0 {
                    done = true;
                    d.fsm = Fsm::Idle;
                } else {
                    begins = true;
                    d.left = i.count;
                    d.parity = !q.parity;
                    d.fsm = Fsm::Send;
                }
            }
            Fsm::Send => {
                if i.taken {
                    if q.left == 0 {
                        d.fsm = Fsm::Drain;
                    } else {
                        d.left = q.left - 1;
                    }
                }
            }
            Fsm::Drain => {
                if i.ended {
                    d.fsm = Fsm::Begin;
                    d.first = false;
                }
            }
        }
        Out { begins, done }
    }
}

#[cfg(test)]
mod tests;
