//! The free list as a stack: of the sections that came back, the last one is granted first, so that few
//! sections are used again and again.
//!
//! ```text
//!             +-------+
//!   take ---->|       |---> grant
//!  release -->| Stack |---> exhausted
//!             +-------+
//! ```
//! One grant and one release a cycle. What is offered is held in a register until it is taken, so a section
//! that comes back is granted after that one, and before all others that are free. Sections that were never
//! used come last; a counter grants them, so that nothing need be put into the stack after reset.

use super::{Allocator, Config, Contract, In, Lent, Moore};
use pellucid_sim::Block;
use pellucid_sim::{Ram1RW, Signals, Stream, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Stack;

impl Contract for Stack {}

impl Allocator for Stack {}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What is offered; without meaning while it is on its way from the memory.
    #[with(cfg.id_bits())]
    pub offer: Stream<u32>,
    /// The memory shows what is offered.
    pub popped: bool,
    /// Sections in the memory.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// The lowest section that was never offered; the number of sections once all were.
    #[width(cfg.count_bits())]
    pub fresh: u32,
}

#[rtl(check(Stack, Config { sections: 1 }), check(Stack, Config { sections: 6 }))]
impl Block for Stack {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = Ram1RW<u32>;

    fn reset(cfg: &Config) -> State {
        let some = cfg.sections > 0;
        let offer = if some { Stream::offer(0) } else { Stream::idle() };
        State { offer, popped: false, count: 0, fresh: u32::from(some) }
    }

    fn memories(cfg: &Config) -> Self::Mem {
        Ram1RW::new(cfg.sections, cfg.id_bits(), 1)
    }

    fn moore(_: &Config, q: &State, m: &Self::Mem) -> Moore {
        let payload = if q.popped { m.q().data } else { q.offer.payload };
        Moore {
            grant: Stream { valid: q.offer.valid, payload },
            // The next one is offered at once, if there is any.
            exhausted: !q.offer.valid,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Lent {
        let offer = Self::moore(cfg, q, m).grant;
        d.offer = offer;
        d.popped = false;
        if i.take || !offer.valid {
            // The next one: what comes back, else the last that came back, else a new one.
            if i.release.valid {
                d.offer = i.release;
            } else if q.count > 0 {
                m.read(q.count - 1);
                d.count = q.count - 1;
                d.offer.valid = true;
                d.popped = true;
            } else if q.fresh < cfg.sections {
                d.offer = Stream { valid: true, payload: q.fresh };
                d.fresh = q.fresh + 1;
            } else {
                d.offer.valid = false;
            }
        } else if i.release.valid {
            m.write(q.count, i.release.payload);
            d.count = q.count + 1;
        }
        m.holds(d.count);
        Lent::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;

    fn stack(sections: u32) -> Sim<Stack> {
        Sim::new(Config { sections })
    }

    /// Takes so many; gives what was granted.
    fn take(sim: &mut Sim<Stack>, count: usize) -> Vec<Option<u32>> {
        (0..count)
            .map(|_| {
                let grant = sim.moore().grant;
                sim.clock(In { take: true, ..In::default() }).unwrap();
                grant.valid.then_some(grant.payload)
            })
            .collect()
    }

    #[test]
    fn the_last_that_came_back_goes_first() {
        let mut sim = stack(6);
        assert_eq!(take(&mut sim, 4), [0, 1, 2, 3].map(Some));
        for id in [2, 0, 3] {
            sim.clock(In { release: Stream::offer(id), ..In::default() }).unwrap();
        }
        // 4 was offered before they came back.
        assert_eq!(take(&mut sim, 6), [Some(4), Some(3), Some(0), Some(2), Some(5), None]);
        assert!(sim.moore().exhausted);
    }

    #[test]
    fn what_comes_back_with_a_take_is_offered_next() {
        let mut sim = stack(3);
        assert_eq!(take(&mut sim, 1), [Some(0)]);
        sim.clock(In { take: true, release: Stream::offer(0), ..In::default() }).unwrap();
        assert_eq!(take(&mut sim, 3), [Some(0), Some(2), None]);
        sim.clock(In { release: Stream::offer(1), ..In::default() }).unwrap();
        assert_eq!(take(&mut sim, 1), [Some(1)]);
    }
}
