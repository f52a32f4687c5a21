use super::*;
use crate::array::config::{MAX_LANES, Shape};
use crate::test_util::{Pattern, arrays, contents, edge, holding, pattern, screen};
use pellucid_sim::{Ram1R1W, ReadDuringWrite, Sim, StreamMonitor};
use proptest::prelude::*;

/// A pixel: fragments that were counted, and those of them that were stored.
type Pixel = (u32, u32);

/// The walk beside what it reads.
struct Bench {
    sim: Sim<Walk>,
    counts: Ram1R1W<Counts>,
    sums: Ram1R1W<Sums>,
    list: Ram1R1W<u32>,
    listed: u32,
    band: Band,
    /// Slots of every array, where these are of one length.
    length: u32,
}

fn words<T: Copy>(lanes: usize, of: &[u32], make: fn([u32; MAX_LANES]) -> T) -> Vec<T> {
    let word = |word: &[u32]| {
        let mut lanes = [0; MAX_LANES];
        lanes[..word.len()].copy_from_slice(word);
        make(lanes)
    };
    of.chunks(lanes).map(word).collect()
}

impl Bench {
    fn new(shape: Shape, pixels: &[Pixel], band: (u32, u32)) -> Bench {
        let cfg = Config::new(screen(pixels.len() as u32, 1), shape);
        let (mut sum, mut sums, mut counts, mut list) = (0, vec![], vec![], vec![]);
        for (pixel, (counted, stored)) in (0..).zip(pixels) {
            let inside = (band.0..band.1).contains(&pixel);
            let ends = if inside { sum + counted } else { 0 };
            sums.push(if !inside || shape.down { ends } else { sum });
            sum = ends;
            let left = if shape.down { counted - stored } else { *stored };
            // What comes before the band is done with.
            counts.push(if pixel < band.0 { 0 } else { left });
            if inside && *counted > 0 {
                list.push(cfg.word_of(pixel));
            }
        }
        list.dedup();
        let listed = list.len() as u32;
        let lanes = shape.lanes as usize;
        Bench {
            counts: holding(&words(lanes, &counts, |of| Counts { of }), cfg, ReadDuringWrite::New),
            sums: holding(&words(lanes, &sums, |of| Sums { of }), cfg, ReadDuringWrite::New),
            list: holding(&list, cfg.word_bits(), ReadDuringWrite::New),
            sim: Sim::new(cfg),
            listed,
            band: Band { from: band.0, to: band.1 },
            length: 0,
        }
    }

    /// The same where arrays have `length` slots each, and words with a fragment are listed in that order.
    fn fixed(shape: Shape, pixels: &[Pixel], length: u32, order: &[u32]) -> Bench {
        let mut bench = Bench::new(shape, pixels, (0, pixels.len() as u32));
        let word_bits = bench.sim.config().word_bits();
        bench.list = holding(order, word_bits, ReadDuringWrite::New);
        bench.listed = order.len() as u32;
        bench.length = length;
        bench
    }

    /// Gives what was sent, with its cycles from the start on, and the cycle of the end.
    fn walk(&mut self, ready: &Pattern) -> (Vec<(u64, Extent)>, u64) {
        let lists = self.sim.config().lists();
        let mut monitor = StreamMonitor::new("extent", "Walk", "test");
        let mut sent = vec![];
        for cycle in 0.. {
            assert!(cycle < 10_000, "the end of the band does not come");
            let i = In {
                start: cycle == 0,
                band: self.band,
                length: self.length,
                occupied: self.listed,
                word: self.list.q(),
                counts: self.counts.q(),
                sums: self.sums.q(),
                ready: true,
                extent_ready: ready.at(cycle),
            };
            let out = self.sim.clock(i).unwrap().out;
            if lists {
                self.list.pass_read(out.occupied_read);
            }
            self.counts.pass_read(out.read);
            self.sums.pass_read(out.read);
            self.counts.pass_write(out.write);
            edge(&mut self.list);
            edge(&mut self.counts);
            edge(&mut self.sums);
            let extent = out.extent.with(i.extent_ready);
            monitor.observe(extent).unwrap();
            if extent.fires() && extent.payload.end {
                return (sent, cycle);
            }
            sent.extend(extent.fires().then_some((cycle, extent.payload.item)));
        }
        unreachable!("the loop ends by return")
    }
}

fn shape(lanes: u32, down: bool) -> Shape {
    Shape { on_chip: 500, ..arrays(lanes, down).shape }
}

#[test]
fn by_hand() {
    // The second pixel has a hole at its end, the third nothing but holes, the fourth nothing.
    let pixels = [(2, 2), (3, 2), (2, 0), (0, 0), (1, 1)];
    for down in [false, true] {
        for lanes in [1, 2, 8] {
            let mut bench = Bench::new(shape(lanes, down), &pixels, (0, 5));
            let sent = bench.walk(&Pattern::always()).0;
            let extent = |pixel, first, count| Extent { pixel, first, count };
            let sent: Vec<Extent> = sent.into_iter().map(|(_, extent)| extent).collect();
            assert_eq!(sent, [extent(0, 0, 2), extent(1, 2, 2), extent(4, 7, 1)]);
        }
    }
}

#[test]
fn a_pixel_a_cycle_across_words_and_nothing_for_words_that_are_not_listed() {
    for lanes in [2, 4, 16] {
        let mut pixels = vec![(1, 1); 64];
        pixels[16..48].fill((0, 0));
        let mut bench = Bench::new(shape(lanes, true), &pixels, (0, 64));
        let (sent, _) = bench.walk(&Pattern::always());
        let first = sent[0].0;
        let after: Vec<u64> = sent.iter().map(|(cycle, _)| cycle - first).collect();
        assert_eq!(after, (0..32).collect::<Vec<_>>(), "{lanes} lanes");
    }
}

#[test]
fn a_word_of_one_lane_takes_a_cycle() {
    let mut pixels = vec![(0, 0); 40];
    (pixels[0], pixels[39]) = ((1, 1), (1, 1));
    let (sent, _) = Bench::new(shape(1, false), &pixels, (0, 40)).walk(&Pattern::always());
    assert_eq!(sent[1].0 - sent[0].0, 39);
}

proptest! {
    /// Exactly the pixels of the band that have fragments, in rising order, and no counter of it is left.
    #[test]
    fn sends_the_pixels_that_have_fragments(
        pixels in proptest::collection::vec(
            prop_oneof![Just((0, 0)), (0u32..=7).prop_flat_map(|n| (Just(n), 0..=n))], 1..70,
        ),
        lanes in 0u32..=4,
        down: bool,
        borders: (prop::sample::Index, prop::sample::Index),
        ready in pattern(),
    ) {
        let borders = [borders.0.index(pixels.len()) as u32, borders.1.index(pixels.len()) as u32];
        let (from, to) = (borders[0].min(borders[1]), borders[0].max(borders[1]) + 1);
        let mut bench = Bench::new(shape(1 << lanes, down), &pixels, (from, to));
        let cfg = *bench.sim.config();
        let before = contents(&mut bench.counts, cfg.words());
        let sent: Vec<Extent> =
            bench.walk(&ready).0.into_iter().map(|(_, extent)| extent).collect();
        let (mut first, mut expected) = (0, vec![]);
        for pixel in from..to {
            let (counted, count) = pixels[pixel as usize];
            expected.extend((count > 0).then_some(Extent { pixel, first, count }));
            first += counted;
        }
        prop_assert_eq!(sent, expected);
        let after = contents(&mut bench.counts, cfg.words());
        for pixel in 0..pixels.len() as u32 {
            let at = |of: &[Counts]| of[cfg.word_of(pixel) as usize].of[cfg.lane_of(pixel) as usize];
            let inside = (from..to).contains(&pixel);
            prop_assert_eq!(at(&after), if inside { 0 } else { at(&before) }, "pixel {}", pixel);
        }
    }

    /// Arrays of one length: the pixels of the words in the order of these, each from its number times the length on.
    #[test]
    fn finds_arrays_of_one_length(
        counts in proptest::collection::vec(prop_oneof![Just(0), 0u32..=7], 1..70),
        lanes in 1u32..=4,
        seed: u64,
        ready in pattern(),
    ) {
        let pixels: Vec<Pixel> = counts.iter().map(|n| (*n, *n)).collect();
        let shape = Shape { fixed: 7, ..shape(1 << lanes, false) };
        let chunks: Vec<&[u32]> = counts.chunks(1 << lanes).collect();
        let mut order: Vec<u32> = (0..chunks.len() as u32).collect();
        order.retain(|word| chunks[*word as usize].iter().any(|n| *n > 0));
        order.sort_by_key(|word| seed.wrapping_mul(u64::from(*word) * 2 + 1) >> 40);
        let mut bench = Bench::fixed(shape, &pixels, 7, &order);
        let cfg = *bench.sim.config();
        let sent: Vec<Extent> =
            bench.walk(&ready).0.into_iter().map(|(_, extent)| extent).collect();
        let mut expected = vec![];
        for word in order {
            let first = word << lanes;
            for (pixel, count) in (first..).zip(chunks[word as usize]) {
                let extent = Extent { pixel, first: pixel * 7, count: *count };
                expected.extend((*count > 0).then_some(extent));
            }
        }
        prop_assert_eq!(sent, expected);
        let left = contents(&mut bench.counts, cfg.words());
        prop_assert!(left.iter().all(|word| *word == Counts::default()));
    }
}
