//! A double buffer: one bank is filled while the other is read in order, once or several times.
//!
//! ```text
//!             +--------------+
//!  insert --->| DoubleBuffer |---> item (Stream), empty
//!  full <-----|              |<--- take, again
//!             +--------------+
//!  swap ------------^
//! ```
//! An item is written a cycle, and one read a cycle: they are read ahead, so that the first one is there two
//! cycles after `swap` or `again`.

use pellucid_sim::{
    Block, Fifo, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, check_range, fifo,
    rtl,
};
use std::marker::PhantomData;

/// See the module's description. `T` is what an item is.
pub struct DoubleBuffer<T>(PhantomData<T>);

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// Items that a bank holds, at least 1.
    pub capacity: u32,
    /// What an item's widths depend on.
    pub item: C,
}

impl<C: Copy> Config<C> {
    fn ahead(&self) -> fifo::Config<C> {
        fifo::Config { depth: READ_AHEAD, item: self.item }
    }
}

/// Bits of how many items there are.
fn count_bits(capacity: u32) -> u32 {
    bits_for(u64::from(capacity))
}

/// Items that are read before they are needed.
const READ_AHEAD: u32 = 3;

/// Registers; their widths depend on how many items a bank holds.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(u32)]
pub struct State {
    /// The second bank is filled, the first one read.
    pub second_is_front: bool,
    /// Items of the bank that is filled.
    #[width(count_bits(*cfg))]
    pub filled: u32,
    /// Items of the bank that is read.
    #[width(count_bits(*cfg))]
    pub held: u32,
    /// Of these, those that were asked for.
    #[width(count_bits(*cfg))]
    pub read: u32,
    /// One was asked for in the last cycle.
    pub asked: bool,
    /// Items that were read ahead.
    #[with(READ_AHEAD)]
    pub ahead: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct In<T: Signals> {
    /// An item to be held; without effect while there is no room.
    #[with(cfg.item)]
    pub insert: Stream<T>,
    /// The banks change places on the coming edge. Only while `empty`, and without an item to be held.
    pub swap: bool,
    /// The item is taken.
    pub take: bool,
    /// The items are to be given once more. Only while `empty`.
    pub again: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct Moore<T: Signals> {
    /// There is no room for an item.
    pub full: bool,
    /// The next item.
    #[with(cfg.item)]
    pub item: Stream<T>,
    /// All items were given.
    pub empty: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<T: Signals + Default>
where
    T::Config: Copy,
{
    /// Items, first bank.
    pub first: Ram1R1W<T>,
    /// Items, second bank.
    pub second: Ram1R1W<T>,
    /// Items that were read ahead.
    pub ahead: <Fifo<T> as Block>::Mem,
}

#[rtl(
    state = cfg.capacity,
    check(DoubleBuffer<u32>, Config { capacity: 5, item: 7 })
)]
impl<T> Block for DoubleBuffer<T>
where
    T: Signals + Default,
    T::Config: Copy,
{
    type Config = Config<T::Config>;
    type State = State;
    type In = In<T>;
    type Moore = Moore<T>;
    type Out = ();
    type Mem = Mem<T>;

    fn reset(cfg: &Self::Config) -> State {
        check_range("the capacity of a double buffer", cfg.capacity, 1..);
        State {
            second_is_front: false,
            filled: 0,
            held: 0,
            read: 0,
            asked: false,
            ahead: Fifo::<T>::reset(&cfg.ahead()),
        }
    }

    fn memories(cfg: &Self::Config) -> Mem<T> {
        let bank = || Ram1R1W::new(cfg.capacity, cfg.item, 1, ReadDuringWrite::Forbidden);
        Mem { first: bank(), second: bank(), ahead: Fifo::<T>::memories(&cfg.ahead()) }
    }

    fn moore(cfg: &Self::Config, q: &State, m: &Self::Mem) -> Moore<T> {
        let ahead = Fifo::<T>::moore(&cfg.ahead(), &q.ahead, &m.ahead);
        Moore {
            full: q.filled == cfg.capacity,
            item: ahead.front,
            empty: q.read == q.held && !q.asked && !ahead.front.valid,
        }
    }

    fn next(cfg: &Self::Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In<T>) {
        if i.insert.valid && q.filled < cfg.capacity {
            d.filled = q.filled + 1;
            if q.second_is_front {
                m.second.write(q.filled, i.insert.payload);
            } else {
                m.first.write(q.filled, i.insert.payload);
            }
        }

        // What was asked for finds room, and so must what is asked for now.
        let ahead = Fifo::<T>::moore(&cfg.ahead(), &q.ahead, &m.ahead);
        let asks = q.read < q.held && ahead.count + u32::from(q.asked) < READ_AHEAD;
        d.asked = asks;
        if asks {
            d.read = q.read + 1;
            if q.second_is_front {
                m.first.read(q.read);
            } else {
                m.second.read(q.read);
            }
        }
        let word = if q.second_is_front { m.first.q() } else { m.second.q() };
        let push = Stream { valid: q.asked, payload: word.data };
        let to_ahead = fifo::In { push, pop: i.take };
        Fifo::<T>::next(&cfg.ahead(), &q.ahead, &mut d.ahead, &mut m.ahead, to_ahead);

        if i.again || i.swap {
            d.read = 0;
        }
        if i.swap {
            d.second_is_front = !q.second_is_front;
            d.held = q.filled;
            d.filled = 0;
        }
    }
}

#[cfg(test)]
mod tests;
