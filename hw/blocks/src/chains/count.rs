//! The counter of sections: gives them out in order, up to a limit, and all of them anew once they are given back at once.
//!
//! ```text
//!             +-------+
//!   asked --->|       |---> grant
//!   limit --->| Count |---> count
//!   restart ->|       |
//!             +-------+
//! ```
//! One section a cycle and one register. It counts what it is asked for, beyond the limit too: what is missing can be told from
//! that, as long as it is not more than all sections. Where sections come back one by one, use [`super::pool`].

use super::config::Config;
use crate::allocator;
use pellucid_sim::{Block, Signals, Stream, rtl};

/// See the module's description.
pub struct Count;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Sections that were asked for, all there are at most. While it is below the limit it is the section that is granted next.
    #[width(cfg.id_bits())]
    pub count: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct In {
    /// A section is asked for: the one on offer is taken, or there is none.
    pub asked: bool,
    /// All are given back. Not with `asked`.
    pub restart: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Sections that were asked for, all there are at most.
    #[width(cfg.id_bits())]
    pub count: u32,
}

#[rtl]
impl Config {
    /// What is on offer after so many were asked for, while so many may be out.
    #[inline(always)]
    pub fn counted(&self, count: u32, limit: u32) -> allocator::Moore {
        let some = count < limit;
        let payload = if some { count } else { 0 };
        allocator::Moore { grant: Stream { valid: some, payload }, exhausted: !some }
    }
}

#[rtl(check(Count, crate::test_util::small_newest_first()))]
impl Block for Count {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { count: 0 }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { count: q.count }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) {
        if i.restart {
            d.count = 0;
        } else if i.asked && q.count < cfg.null {
            d.count = q.count + 1;
        }
    }
}
