//! A skid buffer: keeps an offer that the receiver does not take yet, so that the sender need not.
//!
//! ```text
//!            +------+
//!   push --->|      |---> offer (Stream)
//!   ready <--| Skid |<--- taken
//!            +------+
//! ```
//! No latency: what is pushed is offered in the same cycle. Throughput 1 while the receiver takes; after a cycle in which
//! it does not, `ready` is low until what is kept has gone. Where a sender has more than one item to get rid of, use
//! [`Fifo`](pellucid_sim::Fifo). A receiver that looks at an offer before it knows whether it takes it finds it with
//! [`offered`].

use pellucid_sim::{Block, Signals, Stream, rtl};
use std::marker::PhantomData;

/// See the module's description. `T` is what is offered.
pub struct Skid<T>(PhantomData<T>);

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(T::Config)]
pub struct State<T: Signals> {
    /// What the receiver did not take.
    #[with(*cfg)]
    pub held: Stream<T>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(T::Config)]
pub struct In<T: Signals> {
    /// What is to be offered, taken where `ready` is high.
    #[with(*cfg)]
    pub push: Stream<T>,
    /// The receiver takes what is offered.
    pub taken: bool,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(T::Config)]
pub struct Moore<T: Signals> {
    /// Something may be pushed.
    pub ready: bool,
    /// What is kept.
    #[with(*cfg)]
    pub held: Stream<T>,
}

/// What is offered while `held` is kept and `push` is pushed.
#[inline(always)]
#[rtl]
pub fn offered<T: Copy>(held: Stream<T>, push: Stream<T>) -> Stream<T> {
    if held.valid { held } else { push }
}

#[rtl(check(Skid<u32>, 5), check(Skid<Stream<u64>>, 64))]
impl<T> Block for Skid<T>
where
    T: Signals + Default,
    T::Config: Copy,
{
    type Config = T::Config;
    type State = State<T>;
    type In = In<T>;
    type Moore = Moore<T>;
    type Out = Stream<T>;
    type Mem = ();

    fn reset(_: &T::Config) -> State<T> {
        State { held: Stream::idle() }
    }

    fn memories(_: &T::Config) {}

    fn moore(_: &T::Config, q: &State<T>, (): &()) -> Moore<T> {
        Moore { ready: !q.held.valid, held: q.held }
    }

    fn next(_: &T::Config, q: &State<T>, d: &mut State<T>, (): &mut (), i: In<T>) -> Stream<T> {
        let offer = offered(q.held, i.push);
        if offer.valid {
            d.held = Stream { valid: !i.taken, payload: offer.payload };
        }
        offer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::{Sim, StreamMonitor};
    use proptest::prelude::*;

    proptest! {
        /// Everything comes out in order, at once if it is taken, and an offer stays.
        #[test]
        fn nothing_is_lost_or_late(steps in proptest::collection::vec(any::<(bool, bool)>(), 0..200)) {
            let mut sim = Sim::<Skid<u32>>::new(8);
            let mut monitor = StreamMonitor::new("offer", "Skid", "test");
            let (mut pushed, mut gone) = (0, 0);
            for (push, taken) in steps {
                let push = push && sim.moore().ready;
                prop_assert_eq!(sim.moore().ready, pushed == gone, "one item is kept at most");
                let item = if push { Stream::offer(pushed) } else { Stream::idle() };
                pushed += u32::from(push);
                let offer = sim.clock(In { push: item, taken }).unwrap().out;
                monitor.observe(offer.with(taken)).unwrap();
                let expected = (gone < pushed).then_some(gone);
                prop_assert_eq!(offer.valid.then_some(offer.payload), expected);
                gone += u32::from(offer.valid && taken);
            }
        }
    }
}
