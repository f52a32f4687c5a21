//! The free list as a queue: the numbers of sections that came back wait in a memory, oldest first.
//!
//! ```text
//!             +----------+
//!   take ---->|          |---> grant
//!  release -->| FreeList |---> exhausted
//!             +----------+
//! ```
//! One grant and one release a cycle. A released section is granted again after every section that
//! was free before it. A counter grants the sections that were never used, so that nothing need be
//! put into the queue after reset.

use super::{Allocator, Config, Contract, In, Lent, Moore};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Signals, Stream, fifo, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct FreeList;

impl Contract for FreeList {}

impl Allocator for FreeList {}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The lowest section that was never granted; the number of sections once all were.
    #[width(cfg.count_bits())]
    pub fresh: u32,
    /// Sections that came back.
    #[with(queue(cfg).depth)]
    pub queue: fifo::State,
}

type Queue = Fifo<u32>;

#[inline]
fn queue(cfg: &Config) -> fifo::Config<u32> {
    fifo::Config { depth: cfg.sections.max(1), item: cfg.id_bits() }
}

#[rtl(check(FreeList, Config { sections: 1 }), check(FreeList, Config { sections: 6 }))]
impl Block for FreeList {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = <Queue as Block>::Mem;

    fn reset(cfg: &Config) -> State {
        State { fresh: 0, queue: Queue::reset(&queue(cfg)) }
    }

    /// No word where there is no section.
    fn memories(cfg: &Config) -> Self::Mem {
        Queue::memories(&fifo::Config { depth: cfg.sections, ..queue(cfg) })
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let front = Queue::moore(&queue(cfg), &q.queue, m).front;
        let fresh = q.fresh < cfg.sections;
        let payload = if fresh { q.fresh } else { front.payload };
        Moore {
            grant: Stream { valid: fresh || front.valid, payload },
            exhausted: !fresh && !front.valid,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Lent {
        let fresh = q.fresh < cfg.sections;
        if i.take && fresh {
            d.fresh = q.fresh + 1;
        }
        let to_queue = fifo::In { push: i.release, pop: i.take && !fresh };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, m, to_queue);
        Lent::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    fn list(sections: u32) -> Sim<FreeList> {
        Sim::new(Config { sections })
    }

    #[test]
    fn grants_one_a_cycle_until_exhausted() {
        let mut sim = list(5);
        for id in 0..5 {
            assert_eq!(sim.moore().grant, Stream::offer(id));
            assert!(!sim.moore().exhausted);
            sim.clock(In { take: true, ..In::default() }).unwrap();
        }
        assert!(sim.moore().exhausted && !sim.moore().grant.valid);
        sim.clock(In { release: Stream::offer(3), ..In::default() }).unwrap();
        assert_eq!(sim.moore().grant, Stream::offer(3));
    }

    proptest! {
        /// Against a plain queue: nothing is out twice, nothing is lost.
        #[test]
        fn behaves_as_a_free_list(
            sections in 1u32..9,
            steps in proptest::collection::vec((any::<bool>(), any::<Option<prop::sample::Index>>()), 0..300),
        ) {
            let mut sim = list(sections);
            let mut free: VecDeque<u32> = (0..sections).collect();
            let mut out: Vec<u32> = vec![];
            for (take, release) in steps {
                let seen = sim.moore();
                prop_assert_eq!(seen.grant.valid, !free.is_empty());
                prop_assert_eq!(seen.exhausted, free.is_empty());
                let release = release.filter(|_| !out.is_empty()).map(|k| {
                    let at = k.index(out.len());
                    out.swap_remove(at)
                });
                if take && let Some(id) = free.pop_front() {
                    prop_assert_eq!(seen.grant.payload, id);
                    out.push(id);
                }
                free.extend(release);
                let release = release.map_or(Stream::idle(), Stream::offer);
                sim.clock(In { take, release, ..In::default() }).unwrap();
            }
        }
    }
}
