//! The walk: finds the pixels of a band that have fragments, and where these lie.
//!
//! ```text
//!                      +------+
//!  start, band ------->|      |---> extent (Stream), then the end of the band
//!  word (of the list)->| Walk |<--- extent_ready
//!  counts, sums ------>|      |---> list: read; counters: read, write; sums: read
//!                      +------+
//! ```
//! One pixel a cycle, in rising order, across words; a word without one takes a cycle. Where there is a
//! [list](Config::lists), words without a counted fragment are not in it, and take none; words come in its order. Counters of the band that are not 0
//! are cleared as their word is left.
//!
//! Where slots are found by counting up a pixel's counter says how many fragments it has, from its base on. Where by counting
//! down the counter says how many are missing at its end, and it begins where the one before it ends. Where arrays are of one
//! length the base is the pixel's number times that.

use super::config::{Band, Config};
use super::counters::Counts;
use super::prefix_sum::Sums;
use crate::pixels::Resolve;
use pellucid_machine::pixel::Marked;
use pellucid_sim::Block;
use pellucid_sim::{Read, ReadPort, Signals, Stream, WritePort, bits_for, rtl};

/// See the module's description.
pub struct Walk;

/// A pixel's fragments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Extent {
    /// The pixel.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// The slot of the first one.
    #[width(cfg.sum_bits())]
    pub first: u32,
    /// How many there are.
    #[width(cfg.layer_bits())]
    pub count: u32,
}

/// What is asked and told of pixels that lie outside: each is asked for as it goes to the reader, and its fragments arrive.
#[inline(always)]
#[rtl]
pub fn visited(extent: Stream<Marked<Extent>>, ready: bool, taken: bool) -> Resolve {
    let Marked { end, item } = extent.payload;
    Resolve {
        ask: Stream { valid: extent.valid && ready && !end, payload: item.pixel },
        taken,
        kept: true,
        comes: false,
        visible: false,
        last: false,
    }
}

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for a band.
    Idle,
    /// Sending pixels.
    Walk,
    /// Sending the end of the band.
    End,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The word, or place in the list, that is asked for next.
    #[width(cfg.word_bits())]
    pub next: u32,
    /// A place in the list was asked for.
    #[exists(cfg.lists())]
    pub listed: bool,
    /// The word that was asked for.
    #[with(cfg.word_bits())]
    pub asked: Stream<u32>,
    /// The word that is asked for ahead.
    #[width(cfg.word_bits())]
    #[exists(cfg.caches())]
    pub ahead: u32,
    /// Lanes of it that are done with.
    #[width(if cfg.shape.lanes > 1 { bits_for(u64::from(cfg.shape.lanes)) } else { 0 })]
    pub lane: u32,
    /// Where the array before the word ends.
    #[width(cfg.sum_bits())]
    #[exists(cfg.shape.down)]
    pub before: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A band is stored. Only while idle.
    pub start: bool,
    /// The band.
    #[with(*cfg)]
    #[exists(!cfg.is_fixed())]
    pub band: Band,
    /// Slots of every array.
    #[width(cfg.layer_bits())]
    #[exists(cfg.is_fixed())]
    pub length: u32,
    /// How many words the list has.
    #[width(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub occupied: u32,
    /// The one that was asked for.
    #[with(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub word: Read<u32>,
    /// The counters that were asked for.
    #[with(*cfg)]
    pub counts: Read<Counts>,
    /// The sums that were asked for.
    #[with(*cfg)]
    #[exists(!cfg.is_fixed())]
    pub sums: Read<Sums>,
    /// Words may be asked for ahead.
    #[exists(cfg.caches())]
    pub ready: bool,
    /// The receiver takes a pixel.
    pub extent_ready: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Pixels with their fragments, then the end of the band.
    #[with(*cfg)]
    pub extent: Stream<Marked<Extent>>,
    /// Reads the list.
    #[with(cfg.word_bits())]
    #[exists(cfg.lists())]
    pub occupied_read: ReadPort,
    /// Reads counters and sums.
    #[with(cfg.word_bits())]
    pub read: ReadPort,
    /// A word of them is asked for ahead.
    #[with(cfg.word_bits())]
    #[exists(cfg.caches())]
    pub ahead: Stream<u32>,
    /// Those at hand are done with.
    #[exists(cfg.caches())]
    pub taken: bool,
    /// Clears counters.
    #[with(cfg.word_bits(), *cfg)]
    pub write: WritePort<Counts>,
}

#[rtl(
    moore = (),
    check(Walk, crate::test_util::arrays(4, true)),
    check(Walk, crate::test_util::arrays(4, false)),
    check(Walk, crate::test_util::arrays(1, true)),
    check(Walk, crate::test_util::sweeping(1, false, false)),
    check(Walk, crate::test_util::fixed().arrays),
    check(Walk, crate::test_util::caching_arrays(2, true)),
    check(Walk, crate::test_util::caching_fixed(true).arrays)
)]
impl Block for Walk {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = ();

    fn reset(_: &Config) -> State {
        State {
            fsm: Fsm::Idle,
            next: 0,
            listed: false,
            asked: Stream::idle(),
            ahead: 0,
            lane: 0,
            before: 0,
        }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, _: &State, _: &()) {}

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out::default();

        let there = cfg.is_there(i.counts.valid && (cfg.is_fixed() || i.sums.valid));
        let at_hand = q.asked.valid && there;

        // Last stage: of the pixels of the word at hand that have fragments, the first that was not sent.
        let mut extent = Extent::default();
        let (mut some, mut more, mut used) = (false, false, false);
        let mut lane_after = 0;
        let mut cleared = i.counts.data;
        let mut begin = q.before;
        for lane in 0..cfg.shape.lanes {
            let pixel = (q.asked.payload << cfg.lane_bits()) + lane;
            let counter = i.counts.data.of[lane as usize];
            let sum = i.sums.data.of[lane as usize];
            let mut count = 0;
            if at_hand && cfg.has(i.band, pixel) {
                count = if cfg.shape.down { sum - begin - counter } else { counter };
                used |= counter > 0;
                cleared.of[lane as usize] = 0;
            }
            let here = count > 0 && lane >= q.lane;
            more |= some && here;
            if here && !some {
                let first = if cfg.shape.down { begin } else { sum };
                extent = Extent { pixel, first, count };
                lane_after = lane + 1;
            }
            some |= here;
            begin = sum;
        }
        if cfg.is_fixed() {
            extent.first = extent.pixel * i.length;
        }
        let ended = q.fsm == Fsm::End;
        o.extent = Stream { valid: some || ended, payload: Marked { end: ended, item: extent } };
        let leaves = !q.asked.valid || (there && (!some || (i.extent_ready && !more)));
        if some && i.extent_ready && cfg.shape.lanes > 1 {
            d.lane = lane_after;
        }

        // Middle stage: the next word, from the list if there is one.
        let asks = q.fsm == Fsm::Walk;
        let mut end = cfg.words();
        if cfg.lists() {
            end = i.occupied;
        } else if !cfg.is_fixed() {
            end = cfg.word_of(i.band.to + (cfg.shape.lanes - 1));
        }
        let left = asks && q.next < end;
        let mut next = Stream { valid: left, payload: q.next };
        if cfg.lists() {
            next = Stream { valid: q.listed, payload: i.word.data };
        }
        if leaves {
            if q.asked.valid && used {
                o.write.write(q.asked.payload, cleared);
            }
            if q.asked.valid {
                d.before = begin;
            }
            d.lane = 0;
            d.asked = next;
            if next.valid && !cfg.caches() {
                o.read.read(next.payload);
            }
        }
        o.taken = at_hand && leaves;
        let asks_ahead = cfg.caches() && asks && i.ready && q.ahead < end;
        if asks_ahead {
            o.ahead = Stream::offer(q.ahead);
            d.ahead = q.ahead + 1;
        }

        // First stage: the next place of the list.
        let free = if cfg.lists() { leaves || !q.listed } else { leaves };
        if free {
            if left {
                if cfg.lists() {
                    o.occupied_read.read(q.next);
                }
                d.next = q.next + 1;
            }
            d.listed = left;
        }

        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Walk;
                    let begins_inside = !cfg.lists() && !cfg.is_fixed();
                    let first = if begins_inside { cfg.word_of(i.band.from) } else { 0 };
                    d.next = first;
                    d.ahead = first;
                    d.before = 0;
                }
            }
            Fsm::Walk => {
                if !left && !next.valid && leaves {
                    d.fsm = Fsm::End;
                }
            }
            Fsm::End => {
                if i.extent_ready {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        o
    }
}

#[cfg(test)]
mod tests;
