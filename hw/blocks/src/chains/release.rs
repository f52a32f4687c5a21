//! The release queue: sections on their way back to the pool.
//!
//! ```text
//!            +--------------+
//!  push ---->|              |---> front (Stream)
//!  commit -->| ReleaseQueue |<--- pop
//!  abort --->|              |---> ready
//!            +--------------+
//! ```
//! Sections of a chain are pushed as they are read, but whether the chain must be read again is
//! known only at its end. So a push stays open until `commit` lets all open ones go, those of the
//! same cycle included, or `abort` takes them back. One push and one pop a cycle.

use pellucid_sim::Block;
use pellucid_sim::fifo::after;
use pellucid_sim::{Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct ReleaseQueue;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// How many sections it holds, open ones included; at least 1.
    pub depth: u32,
    /// Bits of a section number.
    pub id_bits: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Where the front is.
    #[width(bits_for(u64::from(cfg.depth - 1)))]
    pub head: u32,
    /// Where the next push goes.
    #[width(bits_for(u64::from(cfg.depth - 1)))]
    pub tail: u32,
    /// Sections that may go.
    #[width(bits_for(u64::from(cfg.depth)))]
    pub committed: u32,
    /// Sections pushed behind them and not decided yet.
    #[width(bits_for(u64::from(cfg.depth)))]
    pub open: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A section, taken where `ready` is high.
    #[with(cfg.id_bits)]
    pub push: Stream<u32>,
    /// All open sections may go.
    pub commit: bool,
    /// All open sections are taken back. Not with a push or `commit`.
    pub abort: bool,
    /// The front is taken.
    pub pop: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// There is room.
    pub ready: bool,
    /// A section that may go.
    #[with(cfg.id_bits)]
    pub front: Stream<u32>,
    /// Nothing is in.
    pub empty: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The sections.
    pub queue: Ram1R1W<u32>,
}

#[rtl(check(ReleaseQueue, Config { depth: 5, id_bits: 4 }))]
impl Block for ReleaseQueue {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the depth of a release queue", cfg.depth, 1..);
        State { head: 0, tail: 0, committed: 0, open: 0 }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { queue: Ram1R1W::new(cfg.depth, cfg.id_bits, 1, ReadDuringWrite::New) }
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        Moore {
            ready: q.committed + q.open < cfg.depth,
            front: Stream { valid: q.committed > 0, payload: m.queue.q().data },
            empty: q.committed + q.open == 0,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) {
        if i.push.valid && q.committed + q.open < cfg.depth {
            m.queue.write(q.tail, i.push.payload);
            d.tail = after(cfg.depth, q.tail);
            d.open += 1;
        }
        if i.commit {
            d.committed += d.open;
            d.open = 0;
        }
        if i.abort {
            d.tail = if q.tail >= q.open { q.tail - q.open } else { q.tail + cfg.depth - q.open };
            d.open = 0;
        }
        m.queue.holds(d.committed + d.open);
        let pop = i.pop && q.committed > 0;
        if pop {
            d.head = after(cfg.depth, q.head);
            d.committed -= 1;
        }
        if d.committed > 0 && (pop || q.committed == 0) {
            m.queue.read(d.head);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    proptest! {
        /// Against two plain queues: what is committed comes out in order, what is aborted does not.
        #[test]
        fn behaves_as_a_queue_with_commit(
            depth in 1u32..7,
            steps in proptest::collection::vec((any::<Option<u8>>(), 0..4, any::<bool>()), 0..300),
        ) {
            let mut sim = Sim::<ReleaseQueue>::new(Config { depth, id_bits: 8 });
            let (mut committed, mut open) = (VecDeque::new(), VecDeque::new());
            for (push, what, pop) in steps {
                let (commit, abort) = (what == 1, what == 2);
                let push = push.filter(|_| !abort).map(u32::from);
                let seen = sim.moore();
                prop_assert_eq!(seen.ready, committed.len() + open.len() < depth as usize);
                prop_assert_eq!(seen.front.valid, !committed.is_empty());
                prop_assert_eq!(seen.empty, committed.is_empty() && open.is_empty());
                if let Some(front) = committed.front() {
                    prop_assert_eq!(seen.front.payload, *front);
                }
                if pop {
                    committed.pop_front();
                }
                if seen.ready {
                    open.extend(push);
                }
                if commit {
                    committed.append(&mut open);
                }
                if abort {
                    open.clear();
                }
                let push = push.map_or(Stream::idle(), Stream::offer);
                sim.clock(In { push, commit, abort, pop }).unwrap();
            }
        }
    }

    #[test]
    #[should_panic(expected = "the depth of a release queue is 0: expected at least 1")]
    fn a_depth_of_0_is_none() {
        ReleaseQueue::reset(&Config { depth: 0, id_bits: 8 });
    }
}
