//! The scanner: finds the pixels that resolve must visit.
//!
//! ```text
//!             +------+
//!  start ---->|      |---> pixel (Stream), then the end of the frame
//!  word ----->| Scan |<--- pixel_ready
//!             |      |---> occupancy read, write
//!             +------+
//! ```
//! One pixel a cycle, in rising order. With `scan=bitmap` it sends the pixels whose occupancy bit is
//! set, passes over a word without any in one cycle, and clears what it has read. With `scan=linear`
//! it sends every pixel.

use super::config::{Config, OCCUPANCY_BITS};
use crate::pixel::Marked;
use pellucid_sim::Block;
use pellucid_sim::{Read, ReadPort, Signals, Stream, WritePort, bits_for};

/// See the module's description.
pub struct Scan;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for a frame.
    Idle,
    /// Sending pixels.
    Scan,
    /// Sending the end of the frame.
    End,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// Pixels of the word at hand that are yet to be sent.
    #[width(OCCUPANCY_BITS)]
    pub bits: u64,
    /// Number of the word at hand.
    #[width(word_bits(cfg))]
    pub word: u32,
    /// The word that the occupancy bitmap shows.
    #[with(word_bits(cfg))]
    pub asked: Stream<u32>,
    /// The next word to ask for.
    #[width(word_bits(cfg))]
    pub next: u32,
}

fn word_bits(cfg: &Config) -> u32 {
    bits_for(u64::from(cfg.occupancy_words()))
}

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// A frame is stored. Only while idle.
    pub start: bool,
    /// The occupancy word that was asked for.
    pub occupancy: Read<u64>,
    /// The receiver takes a pixel.
    pub pixel_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug)]
pub struct Moore {
    /// Pixels to visit.
    pub pixel: Stream<Marked<u32>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug)]
pub struct Out {
    /// Reads an occupancy word.
    pub read: ReadPort,
    /// Clears an occupancy word.
    pub write: WritePort<u64>,
}

/// All pixels of a word: fewer in the last one.
#[inline(always)]
fn every_pixel(cfg: &Config, word: u32) -> u64 {
    let left = cfg.screen.pixels() - word * OCCUPANCY_BITS;
    if left >= OCCUPANCY_BITS { u64::MAX } else { (1 << left) - 1 }
}

impl Block for Scan {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { fsm: Fsm::Idle, bits: 0, word: 0, asked: Stream::idle(), next: 0 }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        let pixel = q.word * OCCUPANCY_BITS + (q.bits.trailing_zeros() & (OCCUPANCY_BITS - 1));
        let end = q.fsm == Fsm::End;
        Moore { pixel: Stream { valid: q.bits != 0 || end, payload: Marked { end, item: pixel } } }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out { read: ReadPort::default(), write: WritePort::default() };
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Scan;
                    d.next = 0;
                }
            }
            Fsm::Scan => {
                // The pixel that leaves is the lowest bit.
                let rest = if i.pixel_ready { q.bits & q.bits.wrapping_sub(1) } else { q.bits };
                let refill = rest == 0;
                d.bits = rest;
                if refill && q.asked.valid {
                    let word = q.asked.payload;
                    d.word = word;
                    if cfg.bitmap {
                        d.bits = i.occupancy.data;
                        if i.occupancy.data != 0 {
                            o.write.write(word, 0);
                        }
                    } else {
                        d.bits = every_pixel(cfg, word);
                    }
                    d.asked.valid = false;
                }
                // The next word is asked for ahead of its use.
                if (refill || !q.asked.valid) && q.next < cfg.occupancy_words() {
                    if cfg.bitmap {
                        o.read.read(q.next);
                    }
                    d.asked = Stream::offer(q.next);
                    d.next = q.next + 1;
                }
                if refill && !q.asked.valid && q.next == cfg.occupancy_words() {
                    d.fsm = Fsm::End;
                }
            }
            Fsm::End => {
                if i.pixel_ready {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        o
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tbuffer::config::{self, Params};
    use crate::test_util::{Pattern, contents, edge, holding, pattern, screen, traffic};
    use pellucid_sim::{Ram1R1W, ReadDuringWrite, Sim, StreamMonitor};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// A scanner beside the occupancy bitmap, if it has one.
    struct Bench {
        sim: Sim<Scan>,
        words: u32,
        bitmap: Ram1R1W<u64>,
    }

    impl Bench {
        fn new(scan: config::Scan, width: u32, height: u32) -> Bench {
            let params = Params { scan, ..Params::default() };
            let cfg = Config::new(screen(width, height), params).unwrap();
            let words = if cfg.bitmap { cfg.occupancy_words() } else { 0 };
            let bitmap = holding(&vec![0; words as usize], ReadDuringWrite::New);
            Bench { sim: Sim::new(cfg), words, bitmap }
        }

        /// Scans a frame in which the pixels of `set` have fragments; gives the pixels that were
        /// sent, with their cycles counted from the start, and the cycle of the end.
        fn scan(&mut self, set: &BTreeSet<u32>, ready: &Pattern) -> (Vec<(u64, u32)>, u64) {
            let mut words = vec![0u64; self.words as usize];
            for pixel in set {
                words[(pixel / 64) as usize] |= 1 << (pixel % 64);
            }
            for (addr, word) in words.iter().enumerate() {
                self.bitmap.write(addr as u32, *word);
                edge(&mut self.bitmap);
            }
            let before = traffic(&mut self.bitmap);
            let mut monitor = StreamMonitor::new("pixel", "Scan", "test");
            let mut sent = vec![];
            for cycle in 0.. {
                assert!(cycle < 100_000, "the end of the frame does not come");
                let pixel = self.sim.moore().pixel.with(ready.at(cycle));
                monitor.observe(pixel).unwrap();
                let occupancy = self.bitmap.q();
                let i = In { start: cycle == 0, occupancy, pixel_ready: pixel.ready };
                let out = *self.sim.clock(i).unwrap().out;
                self.bitmap.pass_read(out.read);
                self.bitmap.pass_write(out.write);
                edge(&mut self.bitmap);
                if pixel.fires() && pixel.payload.end {
                    let (reads, writes) = traffic(&mut self.bitmap);
                    let used = words.iter().filter(|word| **word != 0).count() as u64;
                    assert_eq!(reads - before.0, words.len() as u64, "words read");
                    assert_eq!(writes - before.1, used, "words cleared");
                    let left = contents(&mut self.bitmap, words.len() as u32);
                    assert_eq!(left, vec![0; words.len()]);
                    assert!(!self.sim.moore().pixel.valid, "something follows the end");
                    return (sent, cycle);
                }
                sent.extend(pixel.fires().then_some((cycle, pixel.payload.item)));
            }
            unreachable!("the loop ends by return")
        }
    }

    fn pixels(sent: Vec<(u64, u32)>) -> Vec<u32> {
        sent.into_iter().map(|(_, pixel)| pixel).collect()
    }

    #[test]
    fn linear_visits_every_pixel_one_a_cycle() {
        for (width, height) in [(1, 1), (9, 7), (64, 1), (16, 8), (13, 11)] {
            let mut bench = Bench::new(config::Scan::Linear, width, height);
            let (sent, _) = bench.scan(&BTreeSet::new(), &Pattern::always());
            let first = sent[0].0;
            let expected: Vec<(u64, u32)> =
                (0..width * height).map(|pixel| (first + u64::from(pixel), pixel)).collect();
            assert_eq!(sent, expected, "{width} x {height}");
        }
    }

    #[test]
    fn full_words_give_one_pixel_a_cycle() {
        let mut bench = Bench::new(config::Scan::Bitmap, 50, 4);
        let (sent, _) = bench.scan(&(0..200).collect(), &Pattern::always());
        let first = sent[0].0;
        let expected: Vec<(u64, u32)> = (0..200).map(|k| (first + u64::from(k), k)).collect();
        assert_eq!(sent, expected);
    }

    #[test]
    fn an_empty_word_takes_one_cycle() {
        // Between the last pixel of word 0 and the first of word 5 lie four empty words.
        let mut bench = Bench::new(config::Scan::Bitmap, 64, 8);
        let (sent, _) =
            bench.scan(&BTreeSet::from([3, 63, 5 * 64, 6 * 64 + 1]), &Pattern::always());
        let first = sent[0].0;
        let after: Vec<u64> = sent.iter().map(|(cycle, _)| cycle - first).collect();
        assert_eq!(after, [0, 1, 6, 7]);
    }

    #[test]
    fn an_empty_frame_takes_a_cycle_a_word() {
        let ends = |words| {
            let mut bench = Bench::new(config::Scan::Bitmap, 64, words);
            bench.scan(&BTreeSet::new(), &Pattern::always()).1
        };
        assert_eq!(ends(40) - ends(10), 30);
    }

    proptest! {
        /// Exactly the set bits in rising order, frame after frame, and a clean bitmap behind.
        #[test]
        fn sends_the_pixels_that_have_fragments(
            (width, height, frames) in (1u32..30, 1u32..16).prop_flat_map(|(width, height)| {
                let dense = proptest::collection::btree_set(0..width * height, 0..100);
                let sparse = proptest::collection::btree_set(0..width * height, 0..4);
                let set = prop_oneof![dense, sparse];
                (Just(width), Just(height), proptest::collection::vec(set, 1..4))
            }),
            ready in pattern(),
        ) {
            let mut bench = Bench::new(config::Scan::Bitmap, width, height);
            for set in frames {
                let sent = pixels(bench.scan(&set, &ready).0);
                prop_assert_eq!(sent, set.into_iter().collect::<Vec<_>>());
            }
        }

        /// Every pixel, frame after frame, with a receiver that stalls.
        #[test]
        fn linear_loses_nothing(width in 1u32..20, height in 1u32..20, ready in pattern()) {
            let mut bench = Bench::new(config::Scan::Linear, width, height);
            for _ in 0..2 {
                let sent = pixels(bench.scan(&BTreeSet::new(), &ready).0);
                prop_assert_eq!(sent, (0..width * height).collect::<Vec<_>>());
            }
        }
    }
}
