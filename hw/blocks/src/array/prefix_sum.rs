//! The prefix sum: from how many fragments pixels have to where their arrays lie in the buffer.
//!
//! ```text
//!                        +-----------+
//!  start --------------->|           |---> counters: read, write
//!  counts -------------->| PrefixSum |---> band, slots
//!  index, walk: reads -->|           |---> sums, word, occupied
//!                        +-----------+
//! ```
//! A word of counters a cycle goes through a tree of adders that makes the sum up to each of its lanes; to these is added the sum
//! up to the word. Sums are kept up to the pixel itself, which is the end of its array, where slots are found by counting
//! down, and up to the one before it, which is its base, where by counting up. A sweep over `n` words takes `n + 1` cycles.
//! With `sweeps` it takes one for each doubling of the words in a sum, and works in the memory of the sums: in the sweep for
//! `2^s` words, those of the upper half of each group of twice as many get the sum of the lower half's last one.
//!
//! What has no slot begins the next band: the first pixel whose end lies beyond the last slot. With bands the last sweep ends
//! there, and the next start begins with it. Sums do not grow beyond what shows that.
//!
//! The last sweep clears counters: where fragments are counted up again those of the band, where there is but one band
//! those behind it. It lists the words that have a fragment, if they have several lanes.
//!
//! Where counters and sums lie outside, words are asked for ahead, and each waits until it is there; there is no list. What was
//! asked for behind the end of a band is passed over before the band is done. A word of [`Sums`] is an
//! [`Entry`](cached_table::Entry) of a table there.

use super::config::{Band, Config, MAX_LANES};
use super::counters::Counts;
use crate::cached_table;
use pellucid_machine::outside;
use pellucid_sim::Block;
use pellucid_sim::{
    Label, Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort, rtl,
};

/// See the module's description.
pub struct PrefixSum;

/// A word: sums of counters, for pixels that follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Sums {
    /// Each one's.
    #[width(cfg.sum_bits())]
    #[len(cfg.shape.lanes)]
    pub of: [u32; MAX_LANES],
}

#[rtl]
impl Sums {
    /// The first one lowest.
    #[inline(always)]
    fn word(cfg: &Config, sums: Sums) -> outside::Word {
        let mut low: u64 = 0;
        for lane in 0..cfg.shape.lanes {
            low |= u64::from(sums.of[lane as usize]) << (lane * cfg.sum_bits());
        }
        outside::Word { low, high: 0, label: Label::NONE }
    }
    #[inline(always)]
    fn of_word(cfg: &Config, word: outside::Word) -> Sums {
        let mut of = [0; MAX_LANES];
        for lane in 0..cfg.shape.lanes {
            of[lane as usize] = (word.low >> (lane * cfg.sum_bits()) & cfg.sum_mask()) as u32;
        }
        Sums { of }
    }
}

cached_table::entry!(Sums, Config, |_| Sums::default());

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for counters.
    Idle,
    /// Going over them.
    Sweep,
    /// Passing over words that were asked for.
    Pass,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The band.
    #[with(*cfg)]
    pub band: Band,
    /// The word that comes to hand next.
    #[width(cfg.word_bits())]
    pub next: u32,
    /// The word at hand, once it is there.
    #[with(cfg.word_bits())]
    pub asked: Stream<u32>,
    /// The word that is asked for ahead.
    #[width(cfg.word_bits())]
    #[exists(cfg.caches())]
    pub ahead: u32,
    /// Words of the lower half of a group.
    #[width(cfg.word_bits())]
    #[exists(cfg.shape.sweeps)]
    pub half: u32,
    /// What is added to a word.
    #[width(cfg.sum_bits())]
    pub carry: u32,
    /// The sum up to the word before.
    #[width(cfg.sum_bits())]
    #[exists(cfg.shape.sweeps)]
    pub before: u32,
    /// Words in the list.
    #[width(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub occupied: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// The frame is counted, or the band before is read back. Only while idle.
    pub start: bool,
    /// The counters that were asked for.
    #[with(*cfg)]
    pub counts: Read<Counts>,
    /// The sums that were asked for, where they lie outside.
    #[with(*cfg)]
    #[exists(cfg.caches())]
    pub sums: Read<Sums>,
    /// Words may be asked for ahead.
    #[exists(cfg.caches())]
    pub ready: bool,
    /// Reads sums for a fragment's slot.
    #[with(cfg.word_bits())]
    pub index_read: ReadPort,
    /// Reads sums as fragments are read back.
    #[with(cfg.word_bits())]
    pub walk_read: ReadPort,
    /// Reads the list of words.
    #[with(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub occupied_read: ReadPort,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The band.
    #[with(*cfg)]
    pub band: Band,
    /// The sums that were asked for.
    #[with(*cfg)]
    pub sums: Read<Sums>,
    /// Words in the list.
    #[width(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub occupied: u32,
    /// The word of it that was asked for.
    #[with(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub word: Read<u32>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Reads counters.
    #[with(cfg.word_bits())]
    pub read: ReadPort,
    /// Clears counters.
    #[with(cfg.word_bits(), *cfg)]
    pub write: WritePort<Counts>,
    /// A word of counters is asked for ahead.
    #[with(cfg.word_bits())]
    #[exists(cfg.caches())]
    pub counts_ahead: Stream<u32>,
    /// A word of sums is.
    #[with(cfg.word_bits())]
    #[exists(cfg.caches())]
    pub sums_ahead: Stream<u32>,
    /// The counters at hand are done with.
    #[exists(cfg.caches())]
    pub counts_taken: bool,
    /// The sums at hand are.
    #[exists(cfg.caches())]
    pub sums_taken: bool,
    /// Writes sums, where they lie outside.
    #[with(cfg.word_bits(), *cfg)]
    #[exists(cfg.caches())]
    pub sums_write: WritePort<Sums>,
    /// Slots that the band takes up to the word at hand.
    #[with(cfg.sum_bits())]
    pub slots: Stream<u32>,
    /// The band is summed up.
    pub done: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The sums.
    pub sums: Ram1R1W<Sums>,
    /// The list of words of the band that have a fragment.
    pub occupied: Ram1R1W<u32>,
}

/// The sums up to each of the lanes.
#[inline(always)]
#[rtl]
fn tree(cfg: &Config, lanes: [u64; MAX_LANES]) -> [u64; MAX_LANES] {
    let mut sums = lanes;
    for level in 0..cfg.lane_bits() {
        for lane in 0..cfg.shape.lanes {
            if lane >> level & 1 == 1 {
                sums[lane as usize] += sums[(lane >> level << level) as usize - 1];
            }
        }
    }
    sums
}

#[rtl(
    check(PrefixSum, crate::test_util::arrays(4, true)),
    check(PrefixSum, crate::test_util::arrays(1, false)),
    check(PrefixSum, crate::test_util::sweeping(2, true, true)),
    check(PrefixSum, crate::test_util::sweeping(1, false, false)),
    check(PrefixSum, crate::test_util::caching_arrays(2, true)),
    check(PrefixSum, crate::test_util::caching_arrays(1, false))
)]
impl Block for PrefixSum {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            fsm: Fsm::Idle,
            band: Band { from: 0, to: cfg.screen.pixels() },
            next: 0,
            asked: Stream::idle(),
            ahead: 0,
            half: 0,
            carry: 0,
            before: 0,
            occupied: 0,
        }
    }

    fn memories(cfg: &Config) -> Mem {
        let listed = if cfg.lists() { cfg.words() } else { 0 };
        let words = if cfg.caches() { 0 } else { cfg.words() };
        Mem {
            sums: Ram1R1W::new(words, *cfg, 1, ReadDuringWrite::Forbidden),
            occupied: Ram1R1W::new(listed, cfg.word_bits(), 1, ReadDuringWrite::Forbidden),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let mut word = Read::default();
        if cfg.lists() {
            word = m.occupied.q();
        }
        Moore { band: q.band, sums: m.sums.q(), occupied: q.occupied, word }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let mut o = Out {
            read: ReadPort::default(),
            write: WritePort::default(),
            counts_ahead: Stream::idle(),
            sums_ahead: Stream::idle(),
            counts_taken: false,
            sums_taken: false,
            sums_write: WritePort::default(),
            slots: Stream::idle(),
            done: false,
        };
        let mut sums_at_hand = i.sums;
        if !cfg.caches() {
            sums_at_hand = m.sums.q();
            m.sums.pass_read(i.index_read);
            m.sums.pass_read(i.walk_read);
        }
        if cfg.lists() {
            m.occupied.pass_read(i.occupied_read);
        }
        let pixels = cfg.screen.pixels();
        let slots = cfg.slots();
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    // After the last band the next frame's first one begins.
                    let from = if cfg.is_last(q.band) { 0 } else { q.band.to };
                    d.band = Band { from, to: pixels };
                    d.next = cfg.word_of(from);
                    d.ahead = cfg.word_of(from);
                    d.half = 1;
                    d.carry = 0;
                    d.before = 0;
                    d.occupied = 0;
                    d.fsm = Fsm::Sweep;
                }
            }
            Fsm::Sweep => {
                let first_word = cfg.word_of(q.band.from);
                let word = q.asked.payload;
                let mut first = true;
                let mut last = true;
                let mut upper = true;
                let mut before = q.carry;
                if cfg.shape.sweeps {
                    first = q.half == 1;
                    last = q.half >= cfg.words() - first_word - q.half;
                    upper = word.wrapping_sub(first_word) & q.half != 0;
                    before = q.before;
                }

                // Counters are looked at in the first sweep and in the last.
                let counters = first || last;
                let there = cfg.is_there(sums_at_hand.valid && (i.counts.valid || !counters));
                let at_hand = q.asked.valid && there;
                let waits = q.asked.valid && !there;

                // Second stage: the sums up to each pixel of the word.
                let mut lanes = [0; MAX_LANES];
                for lane in 0..cfg.shape.lanes {
                    let before_band = (word << cfg.lane_bits()) + lane < q.band.from;
                    let count = i.counts.data.of[lane as usize];
                    lanes[lane as usize] = if before_band { 0 } else { u64::from(count) };
                }
                lanes = tree(cfg, lanes);
                let mut ends = [0; MAX_LANES];
                let mut fit = 0;
                for lane in 0..cfg.shape.lanes {
                    let so_far = u64::from(sums_at_hand.data.of[lane as usize]);
                    let sum = if first { lanes[lane as usize] } else { so_far };
                    let sum = if upper { sum + u64::from(q.carry) } else { sum };
                    ends[lane as usize] = sum.min(u64::from(cfg.too_many())) as u32;
                    fit += u32::from(ends[lane as usize] <= slots);
                }
                let all = ends[(cfg.shape.lanes - 1) as usize];
                let cut = last && fit < cfg.shape.lanes;

                if at_hand {
                    // Each lane gets the sum up to it, or that up to the one before it.
                    let mut sums = Sums { of: ends };
                    let mut counts = i.counts.data;
                    let mut comes_before = before;
                    let mut some = false;
                    for lane in 0..cfg.shape.lanes {
                        let end = ends[lane as usize];
                        let fits = end <= slots;
                        some |= fits && end != comes_before;
                        if !cfg.shape.down && last {
                            sums.of[lane as usize] = comes_before;
                        }
                        if (fits && !cfg.shape.down) || !(fits || cfg.shape.bands) {
                            counts.of[lane as usize] = 0;
                        }
                        if fits {
                            o.slots = Stream { valid: last, payload: end };
                        }
                        comes_before = end;
                    }
                    if cfg.caches() {
                        o.sums_write.write(word, sums);
                    } else {
                        m.sums.write(word, sums);
                    }
                    if last && (!cfg.shape.down || (cut && !cfg.shape.bands)) {
                        o.write.write(word, counts);
                    }
                    if cfg.lists() && last && some {
                        m.occupied.write(q.occupied, word);
                        d.occupied = q.occupied + 1;
                    }
                    if !cfg.shape.sweeps || !upper {
                        d.carry = all;
                    }
                    d.before = all;
                    if cut && q.band.to == pixels {
                        d.band.to = (word << cfg.lane_bits()) + fit;
                    }
                }

                // First stage: ask for the next word.
                let asks = q.next < cfg.words();
                if !waits {
                    d.asked = Stream { valid: asks, payload: q.next };
                }
                if asks && !waits {
                    if counters && !cfg.caches() {
                        o.read.read(q.next);
                    }
                    if cfg.shape.sweeps && !first && !cfg.caches() {
                        m.sums.read(q.next);
                    }
                    d.next = q.next + 1;
                }
                let asks_ahead = cfg.caches() && i.ready && q.ahead < cfg.words();
                if asks_ahead {
                    o.counts_ahead = Stream { valid: counters, payload: q.ahead };
                    o.sums_ahead = Stream::offer(q.ahead);
                    d.ahead = q.ahead + 1;
                }
                o.counts_taken = at_hand && counters;
                o.sums_taken = at_hand;

                let whole = word == cfg.words() - 1;
                if at_hand && (whole || (cut && cfg.shape.bands)) {
                    d.asked = Stream::idle();
                    d.next = first_word;
                    if whole {
                        d.ahead = first_word;
                    }
                    d.carry = 0;
                    d.before = 0;
                    d.half = q.half << 1;
                    if last {
                        o.done = whole || !cfg.caches();
                        d.fsm = Fsm::Idle;
                        d.half = 0;
                    }
                    if cfg.caches() && last && !whole {
                        d.fsm = Fsm::Pass;
                        d.next = word + 1;
                    }
                }
            }
            Fsm::Pass => {
                if cfg.caches() {
                    let passes = q.next < q.ahead && i.counts.valid && i.sums.valid;
                    o.counts_taken = passes;
                    o.sums_taken = passes;
                    if passes {
                        d.next = q.next + 1;
                    }
                    if q.next == q.ahead {
                        o.done = true;
                        d.fsm = Fsm::Idle;
                    }
                }
            }
        }
        o
    }
}

#[cfg(test)]
mod tests;
