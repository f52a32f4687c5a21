//! A pointer to the next section: all sections are granted in order, and from the first again once all that
//! were granted are back.
//!
//! ```text
//!             +------+
//!   take ---->|      |---> grant
//!  release -->| Bump |---> exhausted
//!             +------+
//! ```
//! One grant and one release a cycle, and no memory: two counters. For a frame that is stored as a whole and
//! given back as a whole; what comes back while others are out cannot be granted again until those are back
//! too ([`Reuse::Together`]). In which order sections come back does not matter, and which ones is not looked
//! at.

use super::{Allocator, Config, Contract, In, Lent, Moore, Reuse};
use pellucid_sim::Block;
use pellucid_sim::{Signals, Stream, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Bump;

impl Contract for Bump {
    const REUSE: Reuse = Reuse::Together;
}

impl Allocator for Bump {}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The section that is granted next; the number of sections once all were.
    #[width(cfg.count_bits())]
    pub next: u32,
    /// Sections that are out.
    #[width(cfg.count_bits())]
    pub out: u32,
}

#[rtl(check(Bump, Config { sections: 1 }), check(Bump, Config { sections: 6 }))]
impl Block for Bump {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { next: 0, out: 0 }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let some = q.next < cfg.sections;
        // Past the last section the counter is no section's number, and may be too wide for one.
        let payload = if some { q.next } else { 0 };
        Moore { grant: Stream { valid: some, payload }, exhausted: !some }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Lent {
        let taken = i.take && q.next < cfg.sections;
        let last_back = i.release.valid && q.out == 1 && !taken;
        if last_back {
            d.next = 0;
        } else if taken {
            d.next = q.next + 1;
        }
        if taken && !i.release.valid {
            d.out = q.out + 1;
        }
        if i.release.valid && !taken {
            d.out = q.out.saturating_sub(1);
        }
        Lent::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::clock;
    use super::*;
    use pellucid_sim::Sim;

    #[test]
    fn it_begins_again_once_all_are_back() {
        let mut sim = Sim::<Bump>::new(Config { sections: 3 });
        for id in 0..2 {
            assert_eq!(sim.moore().grant, Stream::offer(id));
            clock(&mut sim, true, None);
        }
        clock(&mut sim, false, Some(0));
        assert_eq!(sim.moore().grant, Stream::offer(2), "one is out yet");
        clock(&mut sim, true, Some(1));
        assert!(sim.moore().exhausted && !sim.moore().grant.valid, "the last one is out");
        clock(&mut sim, false, Some(2));
        assert_eq!(sim.moore().grant, Stream::offer(0));
    }
}
