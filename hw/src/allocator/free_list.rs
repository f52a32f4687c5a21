//! The free list as a queue: every free section's number waits in a memory, oldest release first.
//!
//! ```text
//!             +----------+
//!   take ---->|          |---> grant
//!             | FreeList |---> exhausted
//!  release -->|          |---> ready
//!             +----------+
//! ```
//! One grant and one release a cycle. A released section is granted again after every section that
//! was free before it. After reset it takes one cycle per section to fill the queue.

use super::{Allocator, Config, In, Moore};
use pellucid_sim::block::{Block, D, Q};
use pellucid_sim::{Fifo, Signals, Stream, bits_for, fifo};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct FreeList;

impl Allocator for FreeList {}

/// What the free list is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Putting every section's number into the queue.
    Fill,
    /// Granting.
    Ready,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The next number to put into the queue.
    #[width(bits_for(u64::from(cfg.sections)))]
    pub fill: u32,
    /// The queue.
    #[with(queue(cfg).depth)]
    pub queue: fifo::State,
}

fn queue(cfg: &Config) -> fifo::Config<u32> {
    fifo::Config { depth: cfg.sections.max(1), item: cfg.id_bits() }
}

impl Block for FreeList {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = <Fifo<u32> as Block>::Mem;

    fn reset(cfg: &Config) -> State {
        let fsm = if cfg.sections == 0 { Fsm::Ready } else { Fsm::Fill };
        State { fsm, fill: 0, queue: Fifo::<u32>::reset(&queue(cfg)) }
    }

    fn memories(cfg: &Config) -> Self::Mem {
        Fifo::<u32>::memories(&queue(cfg))
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Q<Self>) -> Moore {
        let ready = q.fsm == Fsm::Ready;
        let front = Fifo::<u32>::moore(&queue(cfg), &q.queue, m).front;
        Moore {
            grant: Stream { valid: ready && front.valid, payload: front.payload },
            exhausted: ready && !front.valid,
            ready,
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: State, m: Q<Self>, i: In) -> (State, (), D<Self>) {
        let mut d = q;
        let mut push = i.release;
        let mut pop = i.take;
        if q.fsm == Fsm::Fill {
            push = Stream::offer(q.fill);
            pop = false;
            d.fill = q.fill + 1;
            if d.fill == cfg.sections {
                d.fsm = Fsm::Ready;
            }
        }
        let (queue, (), mem) = Fifo::next(&queue(cfg), q.queue, m, fifo::In { push, pop });
        d.queue = queue;
        (d, (), mem)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    const NOTHING: In = In { take: false, release: Stream { valid: false, payload: 0 } };

    fn ready(sections: u32) -> Sim<FreeList> {
        let mut sim = Sim::<FreeList>::new(Config { sections });
        for cycle in 0..sections {
            assert!(!sim.moore().ready, "ready in cycle {cycle}");
            sim.clock(NOTHING).unwrap();
        }
        assert!(sim.moore().ready);
        sim
    }

    #[test]
    fn fills_in_one_cycle_per_section() {
        ready(1);
        ready(17);
    }

    #[test]
    fn without_sections_it_is_exhausted_at_once() {
        let seen = Sim::<FreeList>::new(Config { sections: 0 }).moore();
        assert!(seen.ready && seen.exhausted && !seen.grant.valid);
    }

    #[test]
    fn grants_one_a_cycle_until_exhausted() {
        let mut sim = ready(5);
        for id in 0..5 {
            assert_eq!(sim.moore().grant, Stream::offer(id));
            assert!(!sim.moore().exhausted);
            sim.clock(In { take: true, ..NOTHING }).unwrap();
        }
        assert!(sim.moore().exhausted && !sim.moore().grant.valid);
        sim.clock(In { release: Stream::offer(3), ..NOTHING }).unwrap();
        assert_eq!(sim.moore().grant, Stream::offer(3));
    }

    proptest! {
        /// Against a plain queue: nothing is out twice, nothing is lost.
        #[test]
        fn behaves_as_a_free_list(
            sections in 1u32..9,
            steps in proptest::collection::vec((any::<bool>(), any::<Option<prop::sample::Index>>()), 0..300),
        ) {
            let mut sim = ready(sections);
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
                sim.clock(In { take, release }).unwrap();
            }
        }
    }
}
