//! Pixels of which a fragment is being weighed, so that no other one of theirs is before that is done.
//!
//! ```text
//!  ask (pixel) ---------->+----------+
//!  begins, ends (mark) -->| UnderWay |---> busy, turn
//!  clear ---------------->+----------+
//! ```
//! Two tables of bits, by the lower bits of a pixel's number. One changes its bit when a fragment begins, the other one makes
//! it the same when that ends: while they differ one is under way, and no other one of that number begins. Of pixels that have
//! the same number one waits for the other, without need but seldom: there are 256 numbers or more for each fragment that may be
//! under way, and pixels near to each other have numbers of their own.
//!
//! Asked for in cycle `t`, shown from `t + 1` on, what begins or ends in `t` included. It exists where weights are kept in memory.

use super::config::Config;
use pellucid_sim::{Block, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, rtl};

/// See the module's description.
pub struct UnderWay;

/// A fragment as these tables know it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Mark {
    /// The lower bits of its pixel's number.
    #[width(cfg.mark_bits())]
    pub number: u32,
    /// What the bit of the number becomes with it.
    pub turn: bool,
}

/// Inputs; nothing is asked by default.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// A pixel that is looked up.
    #[with(cfg.screen.pixel_bits())]
    pub ask: Stream<u32>,
    /// A fragment is under way from now on.
    #[with(*cfg)]
    pub begins: Stream<Mark>,
    /// One is no more.
    #[with(*cfg)]
    pub ends: Stream<Mark>,
    /// A number that has none under way.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
}

/// What is known of the pixel that was asked for last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A fragment of its number is under way.
    pub busy: bool,
    /// If none is: what the bit becomes with the next.
    pub turn: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Changes with each that begins.
    pub began: Ram1R1W<bool>,
    /// Follows with each that ends.
    pub ended: Ram1R1W<bool>,
}

#[rtl]
impl Config {
    /// The number by which a pixel is known here.
    #[inline(always)]
    pub fn mark_number(&self, pixel: u32) -> u32 {
        pixel & ((1 << self.mark_bits()) - 1)
    }
}

impl Config {
    /// Bits of such a number.
    #[inline]
    pub fn mark_bits(&self) -> u32 {
        self.screen.pixel_bits().min(bits_for(u64::from(self.shape.reads_in_flight)) + 8)
    }
}

#[rtl(check(UnderWay, crate::test_util::small_owned(true)))]
impl Block for UnderWay {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let words = if cfg.weighs() { cfg.screen.pixels().min(1 << cfg.mark_bits()) } else { 0 };
        let bits = || Ram1R1W::new(words, (), 1, ReadDuringWrite::New);
        Mem { began: bits(), ended: bits() }
    }

    fn moore(_: &Config, (): &(), m: &Mem) -> Moore {
        let (began, ended) = (m.began.q().data, m.ended.q().data);
        Moore { busy: began != ended, turn: !began }
    }

    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Mem, i: In) {
        if i.ask.valid {
            m.began.read(cfg.mark_number(i.ask.payload));
            m.ended.read(cfg.mark_number(i.ask.payload));
        }
        if i.begins.valid {
            m.began.write(i.begins.payload.number, i.begins.payload.turn);
        }
        if i.ends.valid {
            m.ended.write(i.ends.payload.number, i.ends.payload.turn);
        }
        if i.clear.valid {
            m.began.write(cfg.mark_number(i.clear.payload), false);
            m.ended.write(cfg.mark_number(i.clear.payload), false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chains::config::Shape;
    use crate::test_util::{Clocked, screen, small_owned};

    /// Of 2 fragments that may be under way, so that numbers have 10 bits.
    fn tables() -> Clocked<UnderWay> {
        let shape = Shape { reads_in_flight: 2, ..small_owned(true).shape };
        let cfg = Config::new(screen(64, 64), shape);
        let mut tables = Clocked::new(cfg);
        for pixel in 0..4096 {
            tables.clock(In { clear: Stream::offer(pixel), ..In::default() }).unwrap();
        }
        tables
    }

    fn asked(tables: &mut Clocked<UnderWay>, pixel: u32, i: In) -> Moore {
        tables.clock(In { ask: Stream::offer(pixel), ..i }).unwrap();
        tables.moore()
    }

    #[test]
    fn a_pixel_is_busy_from_when_one_begins_until_it_ends() {
        let mut tables = tables();
        for turn in [true, false, true] {
            let free = asked(&mut tables, 5, In::default());
            assert_eq!(free, Moore { busy: false, turn });
            let mark = Stream::offer(Mark { number: 5, turn });
            // What begins or ends in the cycle of the ask is seen.
            let begins = In { begins: mark, ..In::default() };
            assert!(asked(&mut tables, 5, begins).busy);
            assert!(!asked(&mut tables, 6, In::default()).busy);
            assert!(asked(&mut tables, 5, In::default()).busy);
            let ends = In { ends: mark, ..In::default() };
            assert!(!asked(&mut tables, 5, ends).busy);
        }
    }

    #[test]
    fn pixels_that_are_1024_apart_have_one_number() {
        let mut tables = tables();
        let mark = Mark { number: 5, turn: true };
        asked(&mut tables, 0, In { begins: Stream::offer(mark), ..In::default() });
        for (pixel, busy) in [(5, true), (1029, true), (2053, true), (4, false), (1028, false)] {
            assert_eq!(asked(&mut tables, pixel, In::default()).busy, busy, "{pixel}");
        }
    }

    #[test]
    fn what_a_reset_left_under_way_is_cleared() {
        let mut tables = tables();
        let mark = Stream::offer(Mark { number: 7, turn: true });
        assert!(asked(&mut tables, 7, In { begins: mark, ..In::default() }).busy);
        let clear = In { clear: Stream::offer(7), ..In::default() };
        assert_eq!(asked(&mut tables, 7, clear), Moore { busy: false, turn: true });
    }
}
