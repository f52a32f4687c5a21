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

use super::config::Config;
use super::walk::{self, BitWalk};
use crate::bits::WORD_BITS;
use pellucid_machine::pixel::Marked;
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, WritePort, bits_for, rtl};

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
    #[exists(cfg.shape.bitmap)]
    pub words: walk::State,
    /// Finds occupied pixels in a word.
    #[with(*cfg)]
    #[exists(cfg.shape.bitmap)]
    pub pixels: walk::State,
}

impl Config {
    /// How far the scanner counts: pixels or summary words.
    pub fn scan_end(&self) -> u32 {
        if self.shape.bitmap { self.summary_words() } else { self.screen.pixels() }
    }
    /// Bits of the number of an occupancy word.
    pub fn word_bits(&self) -> u32 {
        bits_for(u64::from(self.screen.pixels() / WORD_BITS))
    }
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame is stored. Only while idle.
    pub start: bool,
    /// The summary word that was asked for.
    #[with(WORD_BITS)]
    pub summary: Read<u64>,
    /// The occupancy word that was asked for.
    #[with(WORD_BITS)]
    pub word: Read<u64>,
    /// The receiver takes a pixel.
    pub pixel_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Pixels to visit.
    #[with(cfg.screen.pixel_bits())]
    pub pixel: Stream<Marked<u32>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a summary word.
    #[with(cfg.word_bits())]
    pub summary_read: ReadPort,
    /// Clears a summary word.
    #[with(cfg.word_bits(), WORD_BITS)]
    pub summary_clear: WritePort<u64>,
    /// Reads an occupancy word.
    #[with(cfg.word_bits())]
    pub word_read: ReadPort,
    /// Clears an occupancy word.
    #[with(cfg.word_bits(), WORD_BITS)]
    pub word_clear: WritePort<u64>,
}

#[rtl(check(Scan, crate::test_util::small(true)), check(Scan, crate::test_util::small(false)))]
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

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let end = q.fsm == Fsm::End;
        let pixel = if cfg.shape.bitmap {
            BitWalk::moore(cfg, &q.pixels, &()).bit
        } else {
            let left = q.fsm == Fsm::Scan && q.next < cfg.scan_end();
            Stream { valid: left, payload: if left { q.next } else { 0 } }
        };
        // After the last pixel the count names none: the mark carries 0.
        let item = if end { 0 } else { pixel.payload };
        Moore { pixel: Stream { valid: pixel.valid || end, payload: Marked { end, item } } }
    }

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
                if cfg.shape.bitmap {
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
    use crate::chains::config::Shape;
    use crate::chains::occupancy::{self, Occupancy};
    use crate::test_util::{Clocked, Pattern, pattern, screen, shape, traffic};
    use pellucid_sim::{Sim, StreamMonitor};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// A scanner beside the occupancy bitmap.
    struct Bench {
        sim: Sim<Scan>,
        occupancy: Clocked<Occupancy>,
    }

    impl Bench {
        fn new(bitmap: bool, width: u32, height: u32) -> Bench {
            let shape = Shape { bitmap, ..shape() };
            let cfg = Config::new(screen(width, height), shape);
            let mut occupancy = Clocked::new(cfg);
            // Without a bitmap there is nothing to clear, and nothing to set.
            for word in 0..if bitmap { cfg.occupancy_words() } else { 0 } {
                let clear = Stream::offer(word);
                occupancy.clock(occupancy::In { clear, ..occupancy::In::default() }).unwrap();
            }
            Bench { sim: Sim::new(cfg), occupancy }
        }

        /// Scans a frame in which the pixels of `set` have fragments; gives the pixels that were
        /// sent, with their cycles counted from the start, and the cycle of the end.
        fn scan(&mut self, set: &BTreeSet<u32>, ready: &Pattern) -> (Vec<(u64, u32)>, u64) {
            let bitmap = self.sim.config().shape.bitmap;
            for pixel in set.iter().filter(|_| bitmap).map(|pixel| Stream::offer(*pixel)) {
                self.occupancy
                    .clock(occupancy::In { ask: pixel, ..occupancy::In::default() })
                    .unwrap();
                self.occupancy
                    .clock(occupancy::In { set: pixel, ..occupancy::In::default() })
                    .unwrap();
            }
            let before = traffic(self.occupancy.memories());
            let mut monitor = StreamMonitor::new("pixel", "Scan", "test");
            let mut sent = vec![];
            for cycle in 0.. {
                assert!(cycle < 100_000, "the end of the frame does not come");
                let pixel = self.sim.moore().pixel.with(ready.at(cycle));
                monitor.observe(pixel).unwrap();
                let occupancy::Moore { summary, word } = self.occupancy.moore();
                let i = In { start: cycle == 0, summary, word, pixel_ready: pixel.ready };
                let Out { summary_read, summary_clear, word_read, word_clear } =
                    self.sim.clock(i).unwrap().out;
                let ports = occupancy::In {
                    summary_read,
                    summary_clear,
                    word_read,
                    word_clear,
                    ..occupancy::In::default()
                };
                self.occupancy.clock(ports).unwrap();
                if pixel.fires() && pixel.payload.end {
                    // The summary is read whole, of the bitmap only what is occupied; what is
                    // occupied is cleared.
                    let (reads, writes) = traffic(self.occupancy.memories());
                    let occupied = |bits: u32| {
                        set.iter().map(|pixel| pixel / bits).collect::<BTreeSet<_>>().len() as u64
                    };
                    let summary = u64::from(self.sim.config().summary_words());
                    let expected = if bitmap {
                        (summary + occupied(64), occupied(64) + occupied(64 * 64))
                    } else {
                        (0, 0)
                    };
                    assert_eq!((reads - before.0, writes - before.1), expected);
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
            let mut bench = Bench::new(false, width, height);
            let (sent, _) = bench.scan(&BTreeSet::new(), &Pattern::always());
            let first = sent[0].0;
            let expected: Vec<(u64, u32)> =
                (0..width * height).map(|pixel| (first + u64::from(pixel), pixel)).collect();
            assert_eq!(sent, expected, "{width} x {height}");
        }
    }

    #[test]
    fn full_words_give_one_pixel_a_cycle() {
        let mut bench = Bench::new(true, 50, 4);
        let (sent, _) = bench.scan(&(0..200).collect(), &Pattern::always());
        let first = sent[0].0;
        let expected: Vec<(u64, u32)> = (0..200).map(|k| (first + u64::from(k), k)).collect();
        assert_eq!(sent, expected);
    }

    #[test]
    fn empty_words_between_occupied_ones_take_no_time() {
        let mut bench = Bench::new(true, 64, 8);
        let (sent, _) =
            bench.scan(&BTreeSet::from([3, 63, 5 * 64, 6 * 64 + 1]), &Pattern::always());
        let first = sent[0].0;
        let after: Vec<u64> = sent.iter().map(|(cycle, _)| cycle - first).collect();
        assert_eq!(after, [0, 1, 2, 3]);
    }

    #[test]
    fn an_empty_frame_takes_a_cycle_a_word_of_the_summary() {
        let ends = |summary_words: u32| {
            let mut bench = Bench::new(true, 64, 64 * summary_words);
            bench.scan(&BTreeSet::new(), &Pattern::always()).1
        };
        assert_eq!(ends(40) - ends(10), 30);
    }

    proptest! {
        /// Exactly the set bits in rising order, frame after frame, and a clean bitmap behind.
        #[test]
        fn sends_the_pixels_that_have_fragments(
            (width, height, frames) in (1u32..90, 1u32..90).prop_flat_map(|(width, height)| {
                let dense = proptest::collection::btree_set(0..width * height, 0..100);
                let sparse = proptest::collection::btree_set(0..width * height, 0..4);
                let set = prop_oneof![dense, sparse];
                (Just(width), Just(height), proptest::collection::vec(set, 1..4))
            }),
            ready in pattern(),
        ) {
            let mut bench = Bench::new(true, width, height);
            for set in frames {
                let sent = pixels(bench.scan(&set, &ready).0);
                prop_assert_eq!(sent, set.into_iter().collect::<Vec<_>>());
            }
        }

        /// Every pixel, frame after frame, with a receiver that stalls.
        #[test]
        fn linear_loses_nothing(width in 1u32..20, height in 1u32..20, ready in pattern()) {
            let mut bench = Bench::new(false, width, height);
            for _ in 0..2 {
                let sent = pixels(bench.scan(&BTreeSet::new(), &ready).0);
                prop_assert_eq!(sent, (0..width * height).collect::<Vec<_>>());
            }
        }
    }
}
