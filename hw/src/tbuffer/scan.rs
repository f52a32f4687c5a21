//! The scanner: finds the pixels that resolve must visit.
//!
//! ```text
//!             +------+
//!  start ---->|      |---> pixel (Stream), then the end of the frame
//!  summary -->| Scan |<--- pixel_ready
//!  word ----->|      |---> summary and word: read, clear
//!             +------+
//! ```
//! One pixel a cycle, in rising order. With `scan=linear` it sends every pixel. With `scan=bitmap` it
//! sends those whose occupancy bit is set: one [`BitWalk`] finds the occupied words in the summary and
//! passes over a summary word without any in one cycle, a second one finds the occupied pixels in
//! those words. Both clear what they have read.

use super::config::{Config, OCCUPANCY_BITS};
use super::walk::{self, BitWalk};
use crate::pixel::Marked;
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, WritePort, bits_for};

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
    /// The next pixel (`scan=linear`) or summary word (`scan=bitmap`) to visit.
    #[width(bits_for(u64::from(cfg.scan_end())))]
    pub next: u32,
    /// Finds occupied words in the summary.
    #[with(*cfg)]
    pub words: walk::State,
    /// Finds occupied pixels in a word.
    #[with(*cfg)]
    pub pixels: walk::State,
}

impl Config {
    /// How far the scanner counts: pixels or summary words.
    pub fn scan_end(&self) -> u32 {
        if self.bitmap { self.summary_words() } else { self.screen.pixels() }
    }
    /// Bits of the number of an occupancy word.
    pub fn word_bits(&self) -> u32 {
        bits_for(u64::from(self.screen.pixels() / OCCUPANCY_BITS))
    }
}

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// A frame is stored. Only while idle.
    pub start: bool,
    /// The summary word that was asked for.
    pub summary: Read<u64>,
    /// The occupancy word that was asked for.
    pub word: Read<u64>,
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
#[derive(Clone, Copy, Debug, Default)]
pub struct Out {
    /// Reads a summary word.
    pub summary_read: ReadPort,
    /// Clears a summary word.
    pub summary_clear: WritePort<u64>,
    /// Reads an occupancy word.
    pub word_read: ReadPort,
    /// Clears an occupancy word.
    pub word_clear: WritePort<u64>,
}

impl Block for Scan {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let walk = BitWalk::reset(cfg);
        State { fsm: Fsm::Idle, next: 0, words: walk, pixels: walk }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let end = q.fsm == Fsm::End;
        let pixel = if cfg.bitmap {
            BitWalk::moore(cfg, &q.pixels, &()).bit
        } else {
            let left = q.fsm == Fsm::Scan && q.next < cfg.scan_end();
            Stream { valid: left, payload: q.next }
        };
        Moore {
            pixel: Stream {
                valid: pixel.valid || end,
                payload: Marked { end, item: pixel.payload },
            },
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut o = Out::default();
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Scan;
                    d.next = 0;
                }
            }
            Fsm::Scan => {
                let more = q.next < cfg.scan_end();
                let mut idle = true;
                let mut step = i.pixel_ready && more;
                if cfg.bitmap {
                    let words = BitWalk::moore(cfg, &q.words, &());
                    let to_pixels =
                        walk::In { word: words.bit, data: i.word, bit_ready: i.pixel_ready };
                    let pixels = BitWalk::next(cfg, &q.pixels, &mut d.pixels, &mut (), to_pixels);
                    let to_words = walk::In {
                        word: Stream { valid: more, payload: q.next },
                        data: i.summary,
                        bit_ready: pixels.take,
                    };
                    let summary = BitWalk::next(cfg, &q.words, &mut d.words, &mut (), to_words);
                    idle = words.idle && BitWalk::moore(cfg, &q.pixels, &()).idle;
                    step = summary.take;
                    o = Out {
                        summary_read: summary.read,
                        summary_clear: summary.clear,
                        word_read: pixels.read,
                        word_clear: pixels.clear,
                    };
                }
                if step {
                    d.next = q.next + 1;
                }
                if !more && idle {
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
