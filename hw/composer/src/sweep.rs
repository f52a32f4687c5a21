//! A sweep over positions: at each, the items that are active there, in the order in which they came.
//!
//! ```text
//!              +---------+          +------+
//!  insert ---->| Buckets | (front)  | Fifo | active items
//!  full <------|         |          +------+
//!              +---------+           |    ^
//!  swap ------------><               v    | back
//!              +---------+ begin   +---------+
//!              | Buckets |-------->|  merge  |---> item (Stream), last
//!              +---------+ (back)  |         |<--- take, back, next
//!                                  +---------+
//! ```
//! There are two sets of buckets: one is filled while the other is swept. At a position, the items that are
//! active since before and those that begin there are given in one order, an item a cycle, and whoever takes
//! one says what of it is to stay active. After the last one the position may be gone through again, or the
//! `next` one begins, at once.

use super::buckets::{self, Buckets, Insert, Ordered, Size};
use pellucid_sim::{Block, Fifo, Memory, Signals, Stream, fifo, rtl};
use std::marker::PhantomData;

pub use super::buckets::Config;

/// See the module's description. `T` is what an item is.
pub struct Sweep<T>(PhantomData<T>);

impl<C: Copy> Config<C> {
    /// All items may be active, and one come while another one goes.
    fn active(&self) -> fifo::Config<Config<C>> {
        fifo::Config { depth: self.size.capacity + 1, item: *self }
    }
}

/// Whether an item that is active since before comes next, though one may begin here: the one that came first.
#[inline(always)]
#[rtl]
fn goes_on(before: u32, active: u32, begins: bool, beginner: u32) -> bool {
    before > 0 && (!begins || active < beginner)
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Size)]
pub struct State {
    /// The second set of buckets is filled, the first one swept.
    pub second_is_front: bool,
    /// The sets of buckets.
    #[with(*cfg)]
    pub buckets: [buckets::State; 2],
    /// A sweep is under way.
    pub runs: bool,
    /// A position is open.
    pub open: bool,
    /// Positions that were opened.
    #[width(cfg.positions_bits())]
    pub opened: u32,
    /// Active items that are to be given in this round.
    #[width(cfg.count_bits())]
    pub before: u32,
    /// Active items.
    #[with(cfg.capacity + 1)]
    pub active: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct In<T: Signals> {
    /// An item for the next sweep; without effect while there is no room.
    #[with(*cfg)]
    pub insert: Stream<Insert<T>>,
    /// The sets change places on the coming edge, and the sweep begins. Only while none runs.
    pub swap: bool,
    /// The item is taken.
    pub take: bool,
    /// What of it stays active.
    #[with(cfg.item)]
    pub back: Stream<T>,
    /// Goes to the next position. With the last item, or where there is none.
    pub next: bool,
    /// A position's lists are emptied, after reset.
    #[with(cfg.size.position_bits())]
    pub clear: Stream<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<T::Config>)]
pub struct Moore<T: Signals> {
    /// There is no room for an item.
    pub full: bool,
    /// A sweep is under way.
    pub runs: bool,
    /// A position is open.
    pub open: bool,
    /// Items that are active in it and still to be given in this round.
    #[width(cfg.size.sum_bits())]
    pub count: u32,
    /// The next item.
    #[with(cfg.item)]
    pub item: Stream<T>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<T: Signals + Default>
where
    T::Config: Copy,
{
    /// The sets of buckets.
    pub buckets: Vec<buckets::Mem<T>>,
    /// Active items.
    pub active: <Active<T> as Block>::Mem,
}

type Active<T> = Fifo<Ordered<T>>;

#[rtl(
    state = cfg.size,
    check(Sweep<u32>, Config { size: Size { positions: 3, capacity: 5 }, item: 7 })
)]
impl<T> Block for Sweep<T>
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
        State {
            second_is_front: false,
            buckets: [Buckets::<T>::reset(cfg); 2],
            runs: false,
            open: false,
            opened: 0,
            before: 0,
            active: Active::<T>::reset(&cfg.active()),
        }
    }

    fn memories(cfg: &Self::Config) -> Mem<T> {
        Mem {
            buckets: vec![Buckets::<T>::memories(cfg), Buckets::<T>::memories(cfg)],
            active: Active::<T>::memories(&cfg.active()),
        }
    }

    fn moore(cfg: &Self::Config, q: &State, m: &Self::Mem) -> Moore<T> {
        let first = Buckets::<T>::moore(cfg, &q.buckets[0], &m.buckets[0]);
        let second = Buckets::<T>::moore(cfg, &q.buckets[1], &m.buckets[1]);
        let full = if q.second_is_front { second.full } else { first.full };
        let begins = if q.second_is_front { first.first } else { second.first };
        let left = if q.second_is_front { first.left } else { second.left };
        let active = Active::<T>::moore(&cfg.active(), &q.active, &m.active).front.payload;
        let old = goes_on(q.before, active.order, begins.valid, begins.payload.order);
        let item = if old { active.item } else { begins.payload.item };
        Moore {
            full,
            runs: q.runs,
            open: q.open,
            count: q.before + left,
            item: Stream { valid: q.open && (q.before > 0 || begins.valid), payload: item },
        }
    }

    fn next(cfg: &Self::Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In<T>) {
        let first = Buckets::<T>::moore(cfg, &q.buckets[0], &m.buckets[0]);
        let second = Buckets::<T>::moore(cfg, &q.buckets[1], &m.buckets[1]);
        let back = if q.second_is_front { first } else { second };
        let active = Active::<T>::moore(&cfg.active(), &q.active, &m.active);

        // Of the items that are active since before and those that begin here, the one that came first.
        let begins = back.first;
        let (here, beginner) = (active.front.payload.order, begins.payload.order);
        let old = goes_on(q.before, here, begins.valid, beginner);
        let order = if old { here } else { beginner };
        let take = i.take && q.open && (q.before > 0 || begins.valid);
        let last = q.before + back.left == 1;
        let stays = take && i.back.valid;
        let to_active = fifo::In {
            push: Stream { valid: stays, payload: Ordered { order, item: i.back.payload } },
            pop: take && old,
        };
        Active::<T>::next(&cfg.active(), &q.active, &mut d.active, &mut m.active, to_active);
        let count = active.count + u32::from(stays) - u32::from(take && old);

        // To the next position, or through this one again.
        let ends = i.next && q.open;
        let opens = q.runs && (!q.open || ends) && back.count.valid;
        if take && old {
            d.before = q.before - 1;
        }
        if opens || (take && last) {
            d.before = count;
        }
        if opens {
            d.open = true;
            d.opened = q.opened + 1;
        } else if ends {
            d.open = false;
            if q.opened == cfg.size.positions {
                d.runs = false;
            }
        }
        if i.swap {
            d.second_is_front = !q.second_is_front;
            d.runs = true;
            d.opened = 0;
        }

        for k in 0..2 {
            let is_front = q.second_is_front == (k == 1);
            let to_buckets = buckets::In {
                insert: Stream { valid: i.insert.valid && is_front, payload: i.insert.payload },
                empties: q.runs && !is_front,
                open: opens && !is_front,
                take: take && !old && !is_front,
                restart: i.swap && !is_front,
                clear: i.clear,
            };
            Buckets::<T>::next(
                cfg,
                &q.buckets[k],
                &mut d.buckets[k],
                &mut m.buckets[k],
                to_buckets,
            );
        }
    }
}

#[cfg(test)]
mod tests;
