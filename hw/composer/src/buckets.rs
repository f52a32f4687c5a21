//! Buckets: items sorted by the position where they begin, in the order in which they came.
//!
//! ```text
//!              +---------+
//!  insert ---->|         |---> count (of the next position)
//!  full <------| Buckets |---> first (Stream: items of the open position)
//!              |         |<--- open, take
//!              +---------+
//! ```
//! First they are filled, an item a cycle. Each position has a list: how many items, the first and the
//! last; each item knows the next of its list. Then they are emptied, position by position from 0 on: `open`
//! goes to the next one, whose items are then given, one a cycle. Lists are read ahead, and left empty for
//! the next filling.

use pellucid_sim::{
    Block, Fifo, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, check_range, fifo,
    rtl,
};
use std::marker::PhantomData;

/// See the module's description. `T` is what an item is.
pub struct Buckets<T>(PhantomData<T>);

/// How large they are.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Positions, at least 1.
    pub positions: u32,
    /// Items that they hold, at least 1.
    pub capacity: u32,
}

impl Size {
    /// Bits of a position.
    pub fn position_bits(&self) -> u32 {
        bits_for(u64::from(self.positions - 1))
    }
    /// Bits of how many positions are done with.
    pub fn positions_bits(&self) -> u32 {
        bits_for(u64::from(self.positions))
    }
    /// Bits of an item's number in the order of their coming.
    pub fn order_bits(&self) -> u32 {
        bits_for(u64::from(self.capacity - 1))
    }
    /// Bits of how many items there are.
    pub fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.capacity))
    }
    /// Bits of a sum of two such numbers.
    pub fn sum_bits(&self) -> u32 {
        self.count_bits() + 1
    }
    fn lists(&self) -> fifo::Config<Size> {
        fifo::Config { depth: READ_AHEAD, item: *self }
    }
}

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// How large they are.
    pub size: Size,
    /// What an item's widths depend on.
    pub item: C,
}

/// Lists that are read before they are opened.
const READ_AHEAD: u32 = 3;

/// The items of a position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Size)]
pub struct List {
    /// How many there are.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// The number of the first one, if there is one.
    #[width(cfg.order_bits())]
    pub first: u32,
    /// The number of the last one, if there is one.
    #[width(cfg.order_bits())]
    pub last: u32,
}

/// The items of a position, as they are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Size)]
pub struct Ahead {
    /// How many there are.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// The number of the first one, if there is one.
    #[width(cfg.order_bits())]
    pub first: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Size)]
pub struct State {
    /// Items that came.
    #[width(cfg.count_bits())]
    pub filled: u32,
    /// The position of the one that came last, whose list was asked for.
    #[with(cfg.position_bits())]
    pub joins: Stream<u32>,
    /// Positions whose lists were asked for, to be emptied.
    #[width(cfg.positions_bits())]
    pub ahead: u32,
    /// The position whose list was asked for last.
    #[with(cfg.position_bits())]
    pub asked: Stream<u32>,
    /// Lists that were read ahead.
    #[with(READ_AHEAD)]
    pub lists: fifo::State,
    /// Items of the open position that are not taken.
    #[width(cfg.count_bits())]
    pub left: u32,
    /// The number of the first of them.
    #[width(cfg.order_bits())]
    pub first: u32,
}

/// An item with the position where it begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config<T::Config>)]
pub struct Insert<T: Signals> {
    /// The position.
    #[width(cfg.size.position_bits())]
    pub position: u32,
    /// The item.
    #[with(cfg.item)]
    pub item: T,
}

/// An item with its number in the order of their coming.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config<T::Config>)]
pub struct Ordered<T: Signals> {
    /// The number.
    #[width(cfg.size.order_bits())]
    pub order: u32,
    /// The item.
    #[with(cfg.item)]
    pub item: T,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct In<T: Signals> {
    /// An item to be held; without effect while they are full.
    #[with(*cfg)]
    pub insert: Stream<Insert<T>>,
    /// They are emptied: lists are read ahead. They are filled no more, until all positions are open.
    pub empties: bool,
    /// Goes to the next position. Only while its count is there, and nothing of the open one is left.
    pub open: bool,
    /// The first item of the open position is taken.
    pub take: bool,
    /// They are to be filled from now on; nothing is in.
    pub restart: bool,
    /// A position's list is emptied, after reset.
    #[with(cfg.size.position_bits())]
    pub clear: Stream<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct Moore<T: Signals> {
    /// There is no room for an item.
    pub full: bool,
    /// How many items the next position has.
    #[with(cfg.size.count_bits())]
    pub count: Stream<u32>,
    /// The first item of the open position that is not taken.
    #[with(*cfg)]
    pub first: Stream<Ordered<T>>,
    /// How many are not taken.
    #[width(cfg.size.count_bits())]
    pub left: u32,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<T: Signals + Default> {
    /// Of each item what it is.
    pub items: Ram1R1W<T>,
    /// Of each item the number of the next one of its position, if there is one.
    pub next: Ram1R1W<u32>,
    /// Of each position its items.
    pub lists: Ram1R1W<List>,
    /// Lists that were read ahead.
    pub ahead: <Lists as Block>::Mem,
}

type Lists = Fifo<Ahead>;

#[rtl(
    state = cfg.size,
    check(Buckets<u32>, Config { size: Size { positions: 3, capacity: 5 }, item: 7 })
)]
impl<T> Block for Buckets<T>
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
        check_range("the number of positions of buckets", cfg.size.positions, 1..);
        check_range("the capacity of buckets", cfg.size.capacity, 1..);
        State {
            filled: 0,
            joins: Stream::idle(),
            ahead: 0,
            asked: Stream::idle(),
            lists: Lists::reset(&cfg.size.lists()),
            left: 0,
            first: 0,
        }
    }

    fn memories(cfg: &Self::Config) -> Mem<T> {
        let Size { positions, capacity } = cfg.size;
        Mem {
            items: Ram1R1W::new(capacity, cfg.item, 1, ReadDuringWrite::Forbidden),
            next: Ram1R1W::new(capacity, cfg.size.order_bits(), 1, ReadDuringWrite::Forbidden),
            // Two items of one position may come one after the other.
            lists: Ram1R1W::new(positions, cfg.size, 1, ReadDuringWrite::New),
            ahead: Lists::memories(&cfg.size.lists()),
        }
    }

    fn moore(cfg: &Self::Config, q: &State, m: &Self::Mem) -> Moore<T> {
        let next = Lists::moore(&cfg.size.lists(), &q.lists, &m.ahead).front;
        let first = Ordered { order: q.first, item: m.items.q().data };
        Moore {
            full: q.filled == cfg.size.capacity,
            count: Stream { valid: next.valid, payload: next.payload.count },
            first: Stream { valid: q.left > 0, payload: first },
            left: q.left,
        }
    }

    fn next(cfg: &Self::Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In<T>) {
        let ahead = Lists::moore(&cfg.size.lists(), &q.lists, &m.ahead);

        // An item comes: its position's list is asked for, and in the next cycle it joins it.
        d.joins.valid = false;
        if i.insert.valid && q.filled < cfg.size.capacity {
            let Insert { position, item } = i.insert.payload;
            m.items.write(q.filled, item);
            m.lists.read(position);
            d.filled = q.filled + 1;
            d.joins = Stream::offer(position);
        }
        if q.joins.valid {
            let list = m.lists.q().data;
            let number = q.filled - 1;
            if list.count > 0 {
                m.next.write(list.last, number);
            }
            let first = if list.count > 0 { list.first } else { number };
            let joined = List { count: list.count + 1, first, last: number };
            m.lists.write(q.joins.payload, joined);
        }

        // Lists are read ahead and emptied. What was asked for finds room, and so must what is asked for now.
        d.asked.valid = false;
        let room = ahead.count + u32::from(q.asked.valid) < READ_AHEAD;
        if i.empties && q.ahead < cfg.size.positions && room {
            m.lists.read(q.ahead);
            d.asked = Stream::offer(q.ahead);
            d.ahead = q.ahead + 1;
        }
        if q.asked.valid {
            m.lists.write(q.asked.payload, List::default());
        }
        if i.clear.valid {
            m.lists.write(i.clear.payload, List::default());
        }
        let List { count, first, .. } = m.lists.q().data;
        let push = Stream { valid: q.asked.valid, payload: Ahead { count, first } };
        let to_ahead = fifo::In { push, pop: i.open };
        Lists::next(&cfg.size.lists(), &q.lists, &mut d.lists, &mut m.ahead, to_ahead);

        // The items of a position.
        let Ahead { count, first } = ahead.front.payload;
        let mut reads = Stream::idle();
        let mut left = q.left;
        if i.open {
            left = count;
            reads = Stream { valid: count > 0, payload: first };
        } else if i.take {
            left = q.left - 1;
            reads = Stream { valid: q.left > 1, payload: m.next.q().data };
        }
        d.left = left;
        if reads.valid {
            d.first = reads.payload;
            m.items.read(reads.payload);
            if left > 1 {
                m.next.read(reads.payload);
            }
        }

        if i.restart {
            d.filled = 0;
            d.ahead = 0;
        }
    }
}

#[cfg(test)]
mod tests;
