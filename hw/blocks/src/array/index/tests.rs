use super::*;
use crate::array::config::{MAX_LANES, Shape};
use crate::array::counters::{self, Counters};
use crate::test_util::{Clocked, Pattern, Source, arrays, edge, holding, pattern, screen};
use pellucid_sim::{Ram1R1W, ReadDuringWrite, Sim};
use proptest::prelude::*;

const PIXELS: u32 = 10;

/// The unit beside its counters, and sums for a band of pixels.
struct Bench {
    sim: Sim<Index>,
    counters: Clocked<Counters>,
    sums: Ram1R1W<Sums>,
    band: Band,
    /// Slots of every array, where these are of one length.
    length: u32,
}

/// What became of a frame.
#[derive(Debug, Default, PartialEq)]
struct Seen {
    counted: u32,
    dropped: u32,
    /// Slots in the order of the writes, with the depth that is written.
    placed: Vec<(u32, u32)>,
    /// Words of counters that got their first fragment.
    words: Vec<u32>,
    /// Cycles from the first offer to the end of the frame.
    cycles: u64,
}

fn fragment(pixel: u32, z: u32) -> PixelFragment {
    PixelFragment { pixel, z, ..PixelFragment::default() }
}

impl Bench {
    fn new(shape: Shape) -> Bench {
        let cfg = Config::new(screen(PIXELS, 1), shape);
        let mut counters = Clocked::<Counters>::new(cfg);
        for word in 0..cfg.words() {
            let clear = Stream::offer(word);
            counters.clock(counters::In { clear, ..Default::default() }).unwrap();
        }
        let sums = holding(&[], cfg, ReadDuringWrite::Forbidden);
        Bench { sim: Sim::new(cfg), counters, sums, band: Band::default(), length: 0 }
    }

    fn counts(&mut self) -> Vec<u32> {
        let cfg = *self.sim.config();
        let count = |pixel| {
            let mut i = counters::In::default();
            i.index_read.read(cfg.word_of(pixel));
            self.counters.clock(i).unwrap();
            self.counters.moore().data.of[cfg.lane_of(pixel) as usize]
        };
        (0..PIXELS).map(count).collect()
    }

    /// Gives each pixel of the band its sum, and counters as they are to begin with.
    fn sum_up(&mut self, band: Band) {
        let cfg = *self.sim.config();
        let counts = self.counts();
        let mut sum = 0;
        let mut sums = vec![Sums::default(); cfg.words() as usize];
        for pixel in band.from..band.to {
            let count = counts[pixel as usize];
            let lane = cfg.lane_of(pixel) as usize;
            sums[cfg.word_of(pixel) as usize].of[lane] =
                if cfg.shape.down { sum + count } else { sum };
            sum += count;
        }
        self.sums = holding(&sums, cfg, ReadDuringWrite::Forbidden);
        self.band = band;
        if !cfg.shape.down {
            for word in 0..cfg.words() {
                let mut i = counters::In::default();
                i.sum_write.write(word, Counts { of: [0; MAX_LANES] });
                self.counters.clock(i).unwrap();
            }
        }
    }

    fn play(
        &mut self,
        frame: &[PixelFragment],
        counting: bool,
        starts: &Pattern,
        outside: &Pattern,
    ) -> Seen {
        let cfg = *self.sim.config();
        let items = frame.iter().copied().map(Marked::item).chain([Marked::end()]);
        let mut source = Source::new(items, starts.clone());
        let mut seen = Seen::default();
        for cycle in 0.. {
            assert!(cycle < 10_000, "the frame does not end");
            let i = In {
                counting,
                fragment: source.offer(cycle),
                counts: self.counters.moore(),
                bases: self.sums.q(),
                band: self.band,
                length: self.length,
                outside_ready: outside.at(cycle),
            };
            source.edge(self.sim.moore().ready);
            let out = self.sim.clock(i).unwrap().out;
            let ports = counters::In {
                index_read: out.count_read,
                index_write: out.count_write,
                ..Default::default()
            };
            self.counters.clock(ports).unwrap();
            self.sums.pass_read(out.base_read);
            edge(&mut self.sums);
            seen.counted += u32::from(out.counted);
            seen.dropped += u32::from(out.dropped);
            if out.place.valid {
                let section = out.place.payload.section;
                assert!(i.outside_ready || !cfg.fragments.is_outside(section));
                seen.placed.push((section, out.word.z));
            }
            seen.words.extend(out.first_of_word.valid.then_some(out.first_of_word.payload));
            if out.ended {
                seen.cycles = cycle;
                break;
            }
        }
        seen
    }
}

#[test]
fn one_fragment_a_cycle_whatever_the_pixels() {
    for down in [false, true] {
        let shape = Shape { count_bits: 32, on_chip: 100, ..arrays(4, down).shape };
        let mut bench = Bench::new(shape);
        let pixels = [3, 3, 3, 2, 3, 2, 9, 9, 0, 3];
        let frame: Vec<_> = (0..).zip(pixels).map(|(z, pixel)| fragment(pixel, z)).collect();
        let always = Pattern::always();
        let counted = bench.play(&frame, true, &always, &always);
        assert_eq!((counted.counted, counted.cycles), (10, 10 + 2));
        assert_eq!(bench.counts(), [1, 0, 2, 5, 0, 0, 0, 0, 0, 2]);
        bench.sum_up(Band { from: 0, to: PIXELS });
        let stored = bench.play(&frame, false, &always, &always);
        assert_eq!(stored.cycles, 10 + 2);
        // Pixel 0 has slot 0, pixel 2 slots 1 and 2, pixel 3 five from 3 on, pixel 9 two.
        let slots = [3, 4, 5, 1, 6, 2, 8, 9, 0, 7];
        let expected: Vec<_> = slots.into_iter().zip(0..).collect();
        assert_eq!(stored.placed, expected, "down: {down}");
    }
}

proptest! {
    /// Counts and places as plain lists do, with limits, a band, holes, pauses and stalls.
    #[test]
    fn behaves_as_plain_lists(
        pixels in proptest::collection::vec((0..PIXELS, any::<bool>()), 0..60),
        lanes in 0u32..=4,
        down: bool,
        bands: bool,
        count_bits in 1u32..5,
        borders in (0..PIXELS, 0..PIXELS),
        patterns in (pattern(), pattern(), pattern()),
    ) {
        let shape = Shape {
            lanes: 1 << lanes, down, bands, count_bits, on_chip: 20, outside: 40, ..arrays(1, true).shape
        };
        let limit = (1 << count_bits) - 1;
        let mut bench = Bench::new(shape);
        let all: Vec<_> = (0..).zip(&pixels).map(|(z, (pixel, _))| fragment(*pixel, z)).collect();
        let (before, starts, outside) = patterns;
        let counted = bench.play(&all, true, &before, &Pattern::always());
        let number = |pixel| all.iter().filter(|f| f.pixel == pixel).count() as u32;
        let counts: Vec<u32> = (0..PIXELS).map(|pixel| number(pixel).min(limit)).collect();
        prop_assert_eq!(bench.counts(), counts.clone());
        prop_assert_eq!((counted.counted, counted.dropped), (counts.iter().sum(), 0));
        prop_assert!(counted.placed.is_empty());

        let from = if bands { borders.0.min(borders.1) } else { 0 };
        let to = borders.0.max(borders.1) + 1;
        bench.sum_up(Band { from, to });
        // Some do not come again.
        let kept = all.iter().zip(&pixels).filter(|(_, (_, comes))| *comes);
        let again: Vec<_> = kept.map(|(fragment, _)| *fragment).collect();
        let stored = bench.play(&again, false, &starts, &outside);
        let mut expected = Seen { cycles: stored.cycles, ..Seen::default() };
        let mut left = counts.clone();
        for PixelFragment { pixel, z, .. } in again {
            let inside = (from..to).contains(&pixel);
            let base: u32 = counts[..pixel as usize].iter().skip(from as usize).sum();
            let (count, left) = (counts[pixel as usize], &mut left[pixel as usize]);
            if inside && *left > 0 {
                expected.placed.push((base + count - *left, z));
                *left -= 1;
            } else if inside || !bands {
                expected.dropped += 1;
            }
        }
        prop_assert_eq!(stored, expected);
    }

    /// Without a count: each pixel's fragments from its number times the length on, as many as there is room for.
    #[test]
    fn fills_arrays_of_one_length(
        pixels in proptest::collection::vec(0..PIXELS, 0..60),
        lanes in 0u32..=4,
        most in 1u32..6,
        shorter in 0u32..5,
        patterns in (pattern(), pattern()),
    ) {
        let shape = Shape {
            lanes: 1 << lanes,
            count_bits: 3,
            bands: false,
            on_chip: 20,
            outside: 40,
            fixed: most,
            ..arrays(1, false).shape
        };
        let mut bench = Bench::new(shape);
        bench.length = most - shorter % most;
        let cfg = *bench.sim.config();
        let all: Vec<_> = (0..).zip(&pixels).map(|(z, pixel)| fragment(*pixel, z)).collect();
        let stored = bench.play(&all, false, &patterns.0, &patterns.1);
        let mut expected = Seen { cycles: stored.cycles, ..Seen::default() };
        let mut counts = [0; PIXELS as usize];
        for PixelFragment { pixel, z, .. } in all {
            let count = &mut counts[pixel as usize];
            if *count < bench.length {
                expected.placed.push((pixel * bench.length + *count, z));
                *count += 1;
                let word = cfg.word_of(pixel);
                if !expected.words.contains(&word) {
                    expected.words.push(word);
                }
            } else {
                expected.dropped += 1;
            }
        }
        prop_assert_eq!(stored, expected);
        prop_assert_eq!(bench.counts(), counts);
    }
}

#[test]
fn a_run_on_one_pixel_fills_its_array_one_a_cycle() {
    let shape = Shape { count_bits: 4, on_chip: 100, fixed: 8, ..arrays(16, false).shape };
    let mut bench = Bench::new(shape);
    bench.length = 8;
    let pixels = [3, 3, 3, 3, 3, 9, 3, 3, 3, 3];
    let frame: Vec<_> = (0..).zip(pixels).map(|(z, pixel)| fragment(pixel, z)).collect();
    let always = Pattern::always();
    let stored = bench.play(&frame, false, &always, &always);
    let slots = [24, 25, 26, 27, 28, 72, 29, 30, 31];
    let placed = slots.into_iter().zip(0..).collect();
    let expected = Seen { dropped: 1, placed, words: vec![0], cycles: 10 + 2, ..Seen::default() };
    assert_eq!(stored, expected);
}
