use super::*;
use crate::chains::config::{Link, Passes, Shape};
use crate::chains::occupancy::Occupancy;
use crate::chains::test_util::{Pixel, Stored, meaning, reference};
use crate::test_util::{Clocked, Pattern, contents, edge, holding, pattern, screen, shape};
use pellucid_sim::{Ram1R1W, ReadDuringWrite, Sim, StreamMonitor};
use proptest::prelude::*;
use std::collections::BTreeSet;

const SECTIONS: u32 = 100;
/// The screen: 150 pixels, of which three words of the bitmap know.
const SCREEN: (u32, u32) = (15, 10);

/// The read-back beside models of the tables.
struct Bench {
    sim: Sim<ReadBack>,
    occupancy: Clocked<Occupancy>,
    ssa: Ram1R1W<SsaEntry>,
    depth: Ram1R1W<u32>,
    stored: Stored,
}

/// What a frame came to.
#[derive(Debug, Default)]
struct Seen {
    arrived: Vec<(u64, Marked<Arrived>)>,
    released: Vec<u32>,
    begun: usize,
    read: usize,
    read_again: usize,
    culled: usize,
}

impl Bench {
    /// After a frame was stored: the first pixels of the screen have these fragments, in sections of any order.
    fn new(shape: Shape, pixels: &[Pixel], sections: &[u32]) -> Bench {
        let cfg = Config::new(screen(SCREEN.0, SCREEN.1), shape);
        let stored = Stored::new(&cfg, pixels, sections);
        let null = SsaEntry { head: cfg.null, tail: 0, fill: 0 };
        let mut ssa = vec![null; cfg.screen.pixels() as usize];
        let mut depth = vec![0; cfg.screen.pixels() as usize];
        let mut occupancy = Clocked::new(cfg);
        let idle = occupancy::In::default();
        // Without a bitmap there is nothing to clear, and nothing to set.
        for word in 0..if shape.bitmap { cfg.occupancy_words() } else { 0 } {
            occupancy.clock(occupancy::In { clear: Stream::offer(word), ..idle }).unwrap();
        }
        for (number, pixel) in pixels.iter().enumerate() {
            ssa[number] = stored.entries[number];
            depth[number] = pixel.depth;
            if shape.bitmap && !pixel.layers.is_empty() {
                let this = Stream::offer(number as u32);
                occupancy.clock(occupancy::In { ask: this, ..idle }).unwrap();
                occupancy.clock(occupancy::In { set: this, ..idle }).unwrap();
            }
        }
        let ssa = holding(&ssa, cfg, ReadDuringWrite::New);
        let depth = holding(&depth, Z_BITS, ReadDuringWrite::Forbidden);
        Bench { sim: Sim::new(cfg), occupancy, ssa, depth, stored }
    }

    /// Reads a frame back, until every section is released.
    fn read(&mut self, ready: &Pattern) -> Seen {
        let mut seen = Seen::default();
        let mut monitor = StreamMonitor::new("arrived", "ReadBack", "test");
        let mut ended = false;
        for cycle in 0.. {
            assert!(cycle < 100_000, "the frame does not end: {seen:?}");
            let moore = self.sim.moore();
            let arrived = moore.arrived.with(ready.at(cycle));
            monitor.observe(arrived).unwrap();
            if ended && moore.released {
                break;
            }
            let i = In {
                depth_ready: true,
                ssa_ready: true,
                start: cycle == 0,
                ssa: self.ssa.q(),
                nsa: self.stored.nsa.q(),
                occupancy: self.occupancy.moore(),
                word: self.stored.words.answer(cycle),
                depth: self.depth.q(),
                arrived_ready: arrived.ready,
                outside_ready: true,
            };
            let out = self.sim.clock(i).unwrap().out;
            let scan::Out { summary_read, summary_clear, word_read, word_clear } = out.scan;
            let ports = occupancy::In {
                summary_read,
                summary_clear,
                word_read,
                word_clear,
                ..occupancy::In::default()
            };
            self.occupancy.clock(ports).unwrap();
            self.ssa.pass_read(out.ssa_read);
            self.ssa.pass_write(out.ssa_write);
            self.depth.pass_read(out.depth_read);
            self.stored.nsa.pass(out.nsa);
            edge(&mut self.ssa);
            edge(&mut self.depth);
            edge(&mut self.stored.nsa);
            if out.read.valid {
                let section = out.read.payload.section;
                assert!(!seen.released.contains(&section), "section {section} was given back");
                self.stored.words.ask(cycle, out.read.payload);
                seen.read += 1;
                seen.read_again += usize::from(out.read_again);
            }
            seen.released.extend(out.release.valid.then_some(out.release.payload));
            seen.begun += usize::from(out.chain_begun);
            seen.culled += usize::from(out.culled);
            if arrived.fires() {
                assert!(!ended, "something follows the end");
                ended = arrived.payload.end;
                seen.arrived.push((cycle, meaning(arrived.payload)));
            }
        }
        seen
    }

    /// Nothing of the frame is left in the tables.
    fn assert_clean(&mut self) {
        let cfg = *self.sim.config();
        for entry in contents(&mut self.ssa, cfg.screen.pixels()) {
            assert_eq!(entry.head, cfg.null, "an SSA entry stays");
        }
        let words = if cfg.shape.bitmap { cfg.occupancy_words() } else { 0 };
        for word in 0..words {
            let mut i = occupancy::In::default();
            i.word_read.read(word);
            i.summary_read.read(0);
            self.occupancy.clock(i).unwrap();
            let occupancy::Moore { summary, word } = self.occupancy.moore();
            assert_eq!((summary.data, word.data), (0, 0), "a bit stays");
        }
    }
}

fn pixel_of(count: u32) -> Pixel {
    Pixel { layers: (0..count).collect(), depth: 1000 }
}

fn config(fast: bool) -> Shape {
    Shape {
        on_chip: SECTIONS,
        outside: 0,
        link: if fast { Link::Tail } else { Link::Walk },
        bitmap: fast,
        passes: Passes::Each(4),
        ..shape()
    }
}

#[test]
fn one_fragment_a_cycle_from_end_to_end() {
    let counts = [1, 1, 3, 4, 2, 1, 4, 4, 1];
    let total: u32 = counts.iter().sum();
    for fast in [false, true] {
        let pixels = counts.map(pixel_of);
        let sections: Vec<u32> = (0..SECTIONS).rev().collect();
        let mut bench = Bench::new(config(fast), &pixels, &sections);
        let seen = bench.read(&Pattern::always());
        let cycles: Vec<u64> =
            seen.arrived.iter().filter(|(_, a)| !a.end).map(|(cycle, _)| *cycle).collect();
        let first = cycles[0];
        assert_eq!(cycles, (first..first + u64::from(total)).collect::<Vec<_>>(), "{fast}");
    }
}

#[test]
fn a_frame_without_fragments_has_just_an_end() {
    for fast in [false, true] {
        let seen = Bench::new(config(fast), &[], &[]).read(&Pattern::always());
        let arrived: Vec<_> = seen.arrived.iter().map(|(_, arrived)| *arrived).collect();
        assert_eq!((arrived, seen.begun, seen.read), (vec![Marked::end()], 0, 0));
        // A linear scan looks at each of the 150 pixels, a bitmap's at one word of its summary.
        assert_eq!(seen.arrived[0].0 >= 150, !fast);
    }
}

fn pixel() -> impl Strategy<Value = Pixel> {
    let layers = prop_oneof![2 => Just(0_usize), 3 => 1..4_usize, 1 => 4..12_usize];
    let layers = layers.prop_flat_map(|n| proptest::collection::vec(0..8_u32, n));
    (layers, prop_oneof![2 => Just(8_u32), 1 => 0..9_u32])
        .prop_map(|(layers, depth)| Pixel { layers, depth })
}

proptest! {
    /// Each pixel's fragments in the order of pixels and chains; all sections back, all tables clean.
    #[test]
    fn gives_back_what_was_stored(
        pixels in proptest::collection::vec(pixel(), 0..16),
        sections in Just((0..SECTIONS).collect::<Vec<u32>>()).prop_shuffle(),
        on_chip in 1..SECTIONS,
        fast in any::<bool>(),
        sorter_depth in 1..=6_u32,
        capacity in 2..=4_u32,
        newest_first in any::<bool>(),
        ready in pattern(),
    ) {
        let passes = Passes::Each(sorter_depth);
        let outside = SECTIONS - on_chip;
        let link = if newest_first { Link::Head } else { config(fast).link };
        let shape =
            Shape { on_chip, outside, outside_latency: 7, passes, capacity, link, ..config(fast) };
        let mut bench = Bench::new(shape, &pixels, &sections);
        let seen = bench.read(&ready);
        let arrived: Vec<_> = seen.arrived.iter().map(|(_, arrived)| *arrived).collect();
        prop_assert_eq!(&arrived, &reference(&pixels, sorter_depth, link));
        let used = pixels.iter().filter(|p| !p.layers.is_empty());
        prop_assert_eq!(seen.begun, used.clone().count());
        let fragments: usize = used.clone().map(|p| p.layers.len()).sum();
        prop_assert_eq!((seen.read, seen.read - seen.read_again), (arrived.len() - 1, fragments));
        let visible: u32 = used.map(Pixel::visible).sum();
        prop_assert_eq!(seen.culled, fragments - visible as usize);
        let released: BTreeSet<u32> = seen.released.iter().copied().collect();
        prop_assert_eq!(released.len(), seen.released.len(), "a section is given back twice");
        let used = bench.stored.used.iter().copied().filter(|_| link != Link::Head);
        prop_assert_eq!(released, used.collect::<BTreeSet<_>>());
        bench.assert_clean();

        // The next frame finds nothing.
        let next = bench.read(&ready);
        prop_assert_eq!((next.arrived.len(), next.begun, next.released.len()), (1, 0, 0));
    }
}
