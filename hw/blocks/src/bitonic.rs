//! The bitonic sorter: sorts all that is loaded into its memory, in passes of compare-exchanges whose order no key changes.
//!
//! ```text
//!           +---------------+
//!  load --->|               |---> sorted (Stream, least first, then the end)
//!  ready <--| BitonicSorter |<--- sorted_ready
//!  start -->|               |
//!           +---------------+
//! ```
//! An item a cycle is loaded, up to the capacity; `start` sorts what is in, what is taken in the same cycle among it; then the items
//! leave, one a cycle, and their end. The next ones are loaded once the end is taken.
//!
//! The network is Batcher's for `n` items and as many that are behind all others as make `2^k` of them: stage `s` of `k` merges blocks
//! of `2^s` that rise where bit `s` of their place is 0 and fall where it is 1, with compare-exchanges over strides of `2^(s-1)` down to 1. That
//! is `k(k+1)/2` passes of `2^k / 2` compare-exchanges. With `lanes` of them at work a pass takes `max(2^k / 2 / lanes, 1) + 1` cycles: a cycle
//! each for what is read, and one until the last is written. What pads is never loaded, and never leaves.
//!
//! A bitonic sort is not stable: items of one key leave by their `number`, which must differ among them if their order is to be known.
//!
//! Words of `lanes` items lie in two banks, a word in the one that the parity of its number names: the words of a stride differ in one bit of
//! their numbers, so that they are in different banks, and both are read and both written in every cycle. Strides within a word take two
//! words that follow each other.
//!
//! The sort takes as long whatever the keys. For a few items at a time, one of which leaves while the next is taken, use the
//! [`crate::sorter`].

use pellucid_machine::pixel::Marked;
use pellucid_sim::{Block, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, check_range, rtl};
use std::marker::PhantomData;

/// See the module's description. `P` is what items carry beside their key.
pub struct BitonicSorter<P>(PhantomData<P>);

/// The most bits of the number of lanes.
pub const MAX_LANE_BITS: u32 = 4;
const MAX_LANES: usize = 1 << MAX_LANE_BITS;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config<C> {
    /// It holds up to 2 to the power of so many items, 1 to 24, and more than `lane_bits`.
    pub capacity_bits: u32,
    /// 2 to the power of so many compare-exchanges a cycle, at most [`MAX_LANE_BITS`].
    pub lane_bits: u32,
    /// Bits of a key, at most 64.
    pub key_bits: u32,
    /// Bits of what orders items of one key, at most 32; 0 if it does not matter.
    pub number_bits: u32,
    /// What the widths of that which items carry depend on.
    pub payload: C,
}

/// `k` for so many items: they are padded to `2^k`.
fn stages(items: u64) -> u32 {
    items.next_power_of_two().ilog2()
}

/// Passes for so many items: `k(k+1)/2`, where they are padded to `2^k`.
pub fn passes(items: u64) -> u64 {
    let k = u64::from(stages(items));
    k * (k + 1) / 2
}

impl<C> Config<C> {
    /// Cycles from the one after the start to the last write, for so many items.
    pub fn cycles(&self, items: u64) -> u64 {
        passes(items) * ((1 << stages(items) >> 1 >> self.lane_bits).max(1) + 1)
    }
    fn capacity(&self) -> u32 {
        1 << self.capacity_bits
    }
    fn lanes(&self) -> u32 {
        1 << self.lane_bits
    }
    /// Of the items that are read in a cycle, the first one of a compare-exchange over a stride of `2^stride`.
    fn first(&self, exchange: u32, stride: u32) -> usize {
        let below = exchange & ((1 << stride) - 1);
        (2 * exchange - below) as usize
    }
}

/// What is sorted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config<P::Config>)]
pub struct Item<P: Signals> {
    /// Least first.
    #[width(cfg.key_bits)]
    pub key: u64,
    /// Orders items of one key, least first.
    #[width(cfg.number_bits)]
    pub number: u32,
    /// What goes with it.
    #[with(cfg.payload)]
    pub payload: P,
}

/// A place in the memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config<P::Config>)]
pub struct Entry<P: Signals> {
    /// It is behind all items; the item is without meaning.
    pub pads: bool,
    /// The item.
    #[with(*cfg)]
    pub item: Item<P>,
}

/// Whether `a` must leave after `b`.
#[inline(always)]
#[rtl]
fn is_after<P: Signals>(a: Entry<P>, b: Entry<P>) -> bool {
    let later = a.item.key == b.item.key && a.item.number > b.item.number;
    !b.pads && (a.pads || a.item.key > b.item.key || later)
}

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Takes items.
    Load,
    /// Sorts them.
    Sort,
    /// Gives them.
    Give,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(u32)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// Items that are in.
    #[width(cfg + 1)]
    pub count: u32,
    /// Items of a block that is merged.
    #[width(cfg + 1)]
    pub block: u32,
    /// How far the items of a compare-exchange are from each other.
    #[width(*cfg)]
    pub stride: u32,
    /// What is read next: compare-exchanges, `lanes` at a time, or an item that leaves.
    #[width(cfg + 1)]
    pub next: u32,
    /// What was read.
    #[with(*cfg)]
    pub asked: Stream<u32>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<P::Config>)]
pub struct In<P: Signals> {
    /// An item.
    #[with(*cfg)]
    pub load: Stream<Item<P>>,
    /// All are loaded. Only while idle.
    pub start: bool,
    /// The receiver takes what is sorted.
    pub sorted_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<P::Config>)]
pub struct Moore<P: Signals> {
    /// It waits for items, or for the start.
    pub idle: bool,
    /// An item is taken.
    pub ready: bool,
    /// What is sorted, then its end.
    #[with(*cfg)]
    pub sorted: Stream<Marked<Item<P>>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// A pass is complete.
    pub pass: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<P: Signals + Default> {
    /// The lanes of the first bank, then those of the second.
    pub lanes: Vec<Ram1R1W<Entry<P>>>,
}

/// Which bank a word is in, of the two.
#[inline(always)]
#[rtl]
fn bank(capacity_bits: &u32, word: u32) -> u32 {
    let mut parity = word & 1;
    for bit in 1..*capacity_bits {
        parity ^= word >> bit & 1;
    }
    parity
}

/// Which memory a place is in: the lane of its word in the bank of it.
#[inline(always)]
#[rtl]
fn memory(capacity_bits: &u32, lane_bits: &u32, place: u32) -> u32 {
    let lane = place & ((1 << *lane_bits) - 1);
    bank(capacity_bits, place >> *lane_bits) << *lane_bits | lane
}

/// The items that there are with those that pad, at least 2.
#[inline(always)]
#[rtl]
fn padded(capacity_bits: &u32, count: u32) -> u32 {
    let mut length = 2;
    for bit in 1..*capacity_bits {
        if count > 1 << bit {
            length = 2 << bit;
        }
    }
    length
}

/// The two words of a number of compare-exchanges over a stride of so many words.
#[inline(always)]
#[rtl]
fn words(number: u32, stride: u32) -> (u32, u32) {
    let below = number & (stride - 1);
    let first = 2 * number - below;
    (first, first + stride)
}

#[rtl(
    state = cfg.capacity_bits,
    output = (),
    check(BitonicSorter<u32>, Config { capacity_bits: 4, lane_bits: 0, key_bits: 3, number_bits: 4, payload: 5 }),
    check(BitonicSorter<u32>, Config { capacity_bits: 5, lane_bits: 2, key_bits: 9, number_bits: 0, payload: 5 }),
    check(BitonicSorter<()>, Config { capacity_bits: 2, lane_bits: 1, key_bits: 0, number_bits: 3, payload: () })
)]
impl<P> Block for BitonicSorter<P>
where
    P: Signals + Default,
    P::Config: Copy,
{
    type Config = Config<P::Config>;
    type State = State;
    type In = In<P>;
    type Moore = Moore<P>;
    type Out = Out;
    type Mem = Mem<P>;

    fn reset(cfg: &Self::Config) -> State {
        check_range("the bits of the lanes of a bitonic sorter", cfg.lane_bits, ..=MAX_LANE_BITS);
        let capacity = cfg.lane_bits + 1..=24;
        check_range("the bits of the capacity of a bitonic sorter", cfg.capacity_bits, capacity);
        check_range("the bits of a key", cfg.key_bits, ..=64);
        check_range("the bits of an item's number", cfg.number_bits, ..=32);
        State { fsm: Fsm::Load, count: 0, block: 0, stride: 0, next: 0, asked: Stream::idle() }
    }

    fn memories(cfg: &Self::Config) -> Mem<P> {
        let words = cfg.capacity() >> cfg.lane_bits >> 1;
        let lane = |_| Ram1R1W::new(words, *cfg, 1, ReadDuringWrite::Forbidden);
        Mem { lanes: (0..2 * cfg.lanes()).map(lane).collect() }
    }

    fn moore(cfg: &Self::Config, q: &State, m: &Self::Mem) -> Moore<P> {
        let gives = q.fsm == Fsm::Give;
        let end = gives && !q.asked.valid && q.next == q.count;
        let shown = memory(&cfg.capacity_bits, &cfg.lane_bits, q.asked.payload);
        let mut item = m.lanes[0].q().data.item;
        for k in 1..2 * cfg.lanes() {
            if shown == k {
                item = m.lanes[k as usize].q().data.item;
            }
        }
        Moore {
            idle: q.fsm == Fsm::Load,
            ready: q.fsm == Fsm::Load && q.count < cfg.capacity(),
            sorted: Stream {
                valid: gives && (q.asked.valid || end),
                payload: Marked { end, item },
            },
        }
    }

    fn next(cfg: &Self::Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In<P>) -> Out {
        let Moore { ready, sorted, .. } = Self::moore(cfg, q, m);
        let mut pass = false;
        match q.fsm {
            Fsm::Load => {
                if i.load.valid && ready {
                    let to = memory(&cfg.capacity_bits, &cfg.lane_bits, q.count);
                    for k in 0..2 * cfg.lanes() {
                        if to == k {
                            let entry = Entry { pads: false, item: i.load.payload };
                            m.lanes[k as usize].write(q.count >> cfg.lane_bits >> 1, entry);
                        }
                    }
                    d.count = q.count + 1;
                }
                if i.start {
                    d.fsm = if d.count > 1 { Fsm::Sort } else { Fsm::Give };
                    d.block = 2;
                    d.stride = 1;
                }
            }
            Fsm::Sort => {
                let stride = (q.stride >> cfg.lane_bits).max(1);
                let first_pass = q.block == 2;

                // Second stage: what was read is compared, exchanged and written.
                let (first, second) = words(q.asked.payload, stride);
                let in_second = bank(&cfg.capacity_bits, first) == 1;
                let mut read = [Entry::default(); 2 * MAX_LANES];
                let mut falls = [false; 2 * MAX_LANES];
                for lane in 0..cfg.lanes() {
                    let mut a = m.lanes[lane as usize].q().data;
                    let mut b = m.lanes[(lane + cfg.lanes()) as usize].q().data;
                    a.pads |= !m.lanes[lane as usize].q().valid;
                    b.pads |= !m.lanes[(lane + cfg.lanes()) as usize].q().valid;
                    read[lane as usize] = if in_second { b } else { a };
                    read[(lane + cfg.lanes()) as usize] = if in_second { a } else { b };
                    falls[lane as usize] = (first << cfg.lane_bits | lane) & q.block != 0;
                    falls[(lane + cfg.lanes()) as usize] =
                        (second << cfg.lane_bits | lane) & q.block != 0;
                }
                let mut sorted = read;
                for exchange in 0..cfg.lanes() {
                    let mut low = read[cfg.first(exchange, 0)];
                    let mut high = read[cfg.first(exchange, 0) + 1];
                    let mut fall = falls[cfg.first(exchange, 0)];
                    for bit in 1..cfg.lane_bits + 1 {
                        if q.stride >> bit != 0 {
                            low = read[cfg.first(exchange, bit)];
                            high = read[cfg.first(exchange, bit) + (1 << bit)];
                            fall = falls[cfg.first(exchange, bit)];
                        }
                    }
                    let exchanged = is_after(low, high) != fall;
                    let (low, high) = if exchanged { (high, low) } else { (low, high) };
                    for bit in 0..cfg.lane_bits + 1 {
                        let here = q.stride >> bit;
                        if here == 1 || (bit == cfg.lane_bits && here != 0) {
                            sorted[cfg.first(exchange, bit)] = low;
                            sorted[cfg.first(exchange, bit) + (1 << bit)] = high;
                        }
                    }
                }
                if q.asked.valid {
                    for lane in 0..cfg.lanes() {
                        let (a, b) = (sorted[lane as usize], sorted[(lane + cfg.lanes()) as usize]);
                        let (here, there) =
                            if in_second { (second, first) } else { (first, second) };
                        let (to_here, to_there) = if in_second { (b, a) } else { (a, b) };
                        m.lanes[lane as usize].write(here >> 1, to_here);
                        m.lanes[(lane + cfg.lanes()) as usize].write(there >> 1, to_there);
                    }
                }

                // First stage: the next ones are read, in the first pass those that are loaded.
                let asks = q.next << cfg.lane_bits << 1 < padded(&cfg.capacity_bits, q.count);
                d.asked = Stream { valid: asks, payload: q.next };
                if asks {
                    let (first, second) = words(q.next, stride);
                    let in_second = bank(&cfg.capacity_bits, first) == 1;
                    let (here, there) = if in_second { (second, first) } else { (first, second) };
                    for lane in 0..cfg.lanes() {
                        if !first_pass || here << cfg.lane_bits | lane < q.count {
                            m.lanes[lane as usize].read(here >> 1);
                        }
                        if !first_pass || there << cfg.lane_bits | lane < q.count {
                            m.lanes[(lane + cfg.lanes()) as usize].read(there >> 1);
                        }
                    }
                    d.next = q.next + 1;
                } else {
                    pass = true;
                    d.next = 0;
                    d.stride = q.stride >> 1;
                    if q.stride == 1 {
                        d.stride = q.block;
                        d.block = q.block << 1;
                        if q.block >= q.count {
                            d.stride = 0;
                            d.block = 0;
                            d.fsm = Fsm::Give;
                        }
                    }
                }
            }
            Fsm::Give => {
                if !q.asked.valid || i.sorted_ready {
                    let asks = q.next < q.count;
                    d.asked = Stream { valid: asks, payload: if asks { q.next } else { 0 } };
                    if asks {
                        let from = memory(&cfg.capacity_bits, &cfg.lane_bits, q.next);
                        for k in 0..2 * cfg.lanes() {
                            if from == k {
                                m.lanes[k as usize].read(q.next >> cfg.lane_bits >> 1);
                            }
                        }
                        d.next = q.next + 1;
                    }
                }
                if sorted.payload.end && i.sorted_ready {
                    d.fsm = Fsm::Load;
                    d.count = 0;
                    d.next = 0;
                }
            }
        }
        Out { pass }
    }
}

#[cfg(test)]
mod tests;
