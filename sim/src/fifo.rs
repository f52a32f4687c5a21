//! A queue in a memory.
//!
//! ```text
//!            +------+
//!   push --->|      |---> front (Stream)
//!   ready <--| Fifo |<--- pop
//!            +------+
//! ```
//! Latency 1: what is pushed in cycle `t` is at the front in `t + 1` at the earliest. Throughput 1
//! in and 1 out a cycle for any depth of at least 2. `ready` is low while it is full, even if
//! something leaves in the same cycle (rule 4). Order is kept; nothing is lost or doubled.

use crate::{Block, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, check_range, rtl};
use std::marker::PhantomData;

/// The queue; `T` is what it holds.
pub struct Fifo<T>(PhantomData<T>);

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// How many items it holds; of 0 it takes none.
    pub depth: u32,
    /// What an item's widths depend on.
    pub item: C,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(u32)]
pub struct State {
    /// Where the front is.
    #[width(bits_for(u64::from(cfg.saturating_sub(1))))]
    pub head: u32,
    /// Where the next push goes.
    #[width(bits_for(u64::from(cfg.saturating_sub(1))))]
    pub tail: u32,
    /// How many items are in.
    #[width(bits_for(u64::from(*cfg)))]
    pub count: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct In<T: Signals> {
    /// What is pushed, taken where `ready` is high.
    #[with(cfg.item)]
    pub push: Stream<T>,
    /// The front is taken. Without effect while nothing is at the front.
    pub pop: bool,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct Moore<T: Signals> {
    /// There is room.
    pub ready: bool,
    /// How many items are in.
    #[width(bits_for(u64::from(cfg.depth)))]
    pub count: u32,
    /// The oldest item.
    #[with(cfg.item)]
    pub front: Stream<T>,
}

/// The place after `at` in a ring of `depth` places.
#[inline(always)]
#[rtl]
pub fn after(depth: u32, at: u32) -> u32 {
    if at + 1 == depth { 0 } else { at + 1 }
}

#[rtl(
    state = cfg.depth,
    check(Fifo<u32>, Config { depth: 1, item: 5 }),
    check(Fifo<Stream<u64>>, Config { depth: 5, item: 64 })
)]
impl<T> Block for Fifo<T>
where
    T: Signals + Default,
    T::Config: Copy,
{
    type Config = Config<T::Config>;
    type State = State;
    type In = In<T>;
    type Moore = Moore<T>;
    type Out = ();
    type Mem = Ram1R1W<T>;

    fn reset(cfg: &Self::Config) -> State {
        check_range("the depth of a FIFO", cfg.depth, 1..);
        State { head: 0, tail: 0, count: 0 }
    }

    fn memories(cfg: &Self::Config) -> Ram1R1W<T> {
        Ram1R1W::new(cfg.depth, cfg.item, 1, ReadDuringWrite::New)
    }

    fn moore(cfg: &Self::Config, q: &State, m: &Self::Mem) -> Moore<T> {
        Moore {
            ready: q.count < cfg.depth,
            count: q.count,
            front: Stream { valid: q.count > 0, payload: m.q().data },
        }
    }

    fn next(cfg: &Self::Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In<T>) {
        let push = i.push.valid && q.count < cfg.depth;
        let pop = i.pop && q.count > 0;
        if push {
            m.write(q.tail, i.push.payload);
            d.tail = after(cfg.depth, q.tail);
        }
        if pop {
            d.head = after(cfg.depth, q.head);
        }
        d.count = q.count + u32::from(push) - u32::from(pop);
        m.holds(d.count);
        // The memory holds the front in its read register: it is read when the front changes.
        if d.count > 0 && (pop || q.count == 0) {
            m.read(d.head);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Memory;

    /// The registers, clocked by hand since their widths depend on the depth alone.
    struct Clocked {
        cfg: Config<u32>,
        q: State,
        mem: Ram1R1W<u32>,
    }

    impl Clocked {
        fn new(depth: u32) -> Clocked {
            let cfg = Config { depth, item: 32 };
            Clocked { q: Fifo::<u32>::reset(&cfg), mem: Fifo::<u32>::memories(&cfg), cfg }
        }
        fn step(&mut self, push: Option<u32>, pop: bool) -> Moore<u32> {
            let seen = Fifo::<u32>::moore(&self.cfg, &self.q, &self.mem);
            let push = push.map_or(Stream::idle(), Stream::offer);
            let mut d = self.q;
            Fifo::next(&self.cfg, &self.q, &mut d, &mut self.mem, In { push, pop });
            assert!(!self.mem.clock());
            d.check(&self.cfg.depth).unwrap();
            self.q = d;
            seen
        }
    }

    #[test]
    fn an_item_is_at_the_front_one_cycle_after_its_push() {
        let mut fifo = Clocked::new(2);
        assert!(!fifo.step(Some(7), false).front.valid);
        assert_eq!(fifo.step(None, false).front, Stream::offer(7));
    }

    #[test]
    #[should_panic(expected = "the depth of a FIFO is 0: expected at least 1")]
    fn a_depth_of_0_is_none() {
        Clocked::new(0);
    }

    #[test]
    fn depth_2_passes_an_item_every_cycle() {
        let mut fifo = Clocked::new(2);
        for k in 0..100 {
            let seen = fifo.step(Some(k), true);
            assert!(seen.ready);
            assert_eq!(seen.front.valid.then_some(seen.front.payload), k.checked_sub(1));
        }
    }
}
