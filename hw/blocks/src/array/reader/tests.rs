use super::*;
use crate::array::config::Shape;
use crate::chains::config::Link;
use crate::chains::test_util::{Pixel, Stored, meaning, reference};
use crate::test_util::{Pattern, Source, arrays, edge, holding, pattern, screen};
use pellucid_sim::{ReadDuringWrite, Sim, StreamMonitor};
use proptest::prelude::*;

const ON_CHIP: u32 = 60;
const OUTSIDE: u32 = 60;

/// When things come and go.
#[derive(Clone, Debug)]
struct Timing {
    starts: Pattern,
    arrived_ready: Pattern,
    outside_ready: Pattern,
}

impl Timing {
    fn free_running() -> Timing {
        let always = Pattern::always;
        Timing { starts: always(), arrived_ready: always(), outside_ready: always() }
    }
}

/// What came of some pixels.
struct Seen {
    /// What arrived, with its cycles.
    arrivals: Vec<(u64, Marked<Arrived>)>,
    /// Reads of a second pass or later.
    again: usize,
    /// Fragments that were told to be hidden.
    culled: usize,
}

/// Reads the pixels, which lie side by side from slot `first` on.
fn read(shape: Shape, pixels: &[Pixel], first: u32, timing: &Timing) -> Seen {
    let cfg = Config::new(screen(8, 8), Shape { on_chip: ON_CHIP, outside: OUTSIDE, ..shape });
    let slots: Vec<u32> = (first..ON_CHIP + OUTSIDE).collect();
    let mut stored = Stored::new(&cfg.fragments, pixels, &slots);
    let mut next = first;
    let mut extents = vec![];
    for (number, pixel) in (0..).zip(pixels) {
        let count = pixel.layers.len() as u32;
        extents.push(Marked::item(Extent { pixel: number, first: next, count }));
        next += count;
    }
    extents.push(Marked::end());
    let mut source = Source::new(extents, timing.starts.clone());
    let depths: Vec<u32> = pixels.iter().map(|pixel| pixel.depth).chain([0]).collect();
    let mut depth = holding(&depths, Z_BITS, ReadDuringWrite::Forbidden);
    let mut sim = Sim::<Reader>::new(cfg);
    let mut monitor = StreamMonitor::new("arrived", "Reader", "test");
    let (mut arrivals, mut reads, mut again, mut culled) = (vec![], 0, 0, 0);
    for cycle in 0.. {
        assert!(cycle < 100_000, "the band does not end: {arrivals:?}");
        let moore = sim.moore();
        let arrived = moore.arrived.with(timing.arrived_ready.at(cycle));
        monitor.observe(arrived).unwrap();
        let i = In {
            extent: source.offer(cycle),
            word: stored.words.answer(cycle),
            depth: depth.q(),
            arrived_ready: arrived.ready,
            outside_ready: timing.outside_ready.at(cycle),
        };
        source.edge(moore.ready);
        let out = sim.clock(i).unwrap().out;
        depth.pass_read(out.depth_read);
        edge(&mut depth);
        culled += usize::from(out.culled);
        if out.read.valid {
            let section = out.read.payload.section;
            assert!(i.outside_ready || !cfg.fragments.is_outside(section), "nothing is taken");
            stored.words.ask(cycle, out.read.payload);
            reads += 1;
            again += usize::from(out.read_again);
        }
        if arrived.fires() {
            arrivals.push((cycle, meaning(arrived.payload)));
            if arrived.payload.end {
                break;
            }
        }
        let waiting = reads - arrivals.len();
        assert!(waiting <= cfg.shape.reads_in_flight as usize, "{waiting} reads in flight");
    }
    Seen { arrivals, again, culled }
}

fn pixel_of(count: u32) -> Pixel {
    Pixel { layers: (0..count).collect(), depth: 1000 }
}

#[test]
fn one_fragment_a_cycle_across_pixels_and_passes_on_chip_and_outside() {
    let shape =
        Shape { count_bits: 4, reads_in_flight: 40, outside_latency: 20, ..arrays(4, true).shape };
    let pixels: Vec<Pixel> = [1, 1, 1, 5, 2, 4, 9, 1, 3, 3].map(pixel_of).to_vec();
    // 5 are read twice, 9 three times.
    let reads = 30 + 5 + 2 * 9;
    for first in [0, ON_CHIP] {
        let Seen { arrivals, again, .. } = read(shape, &pixels, first, &Timing::free_running());
        assert_eq!(again, 5 + 2 * 9);
        let begin = arrivals[0].0;
        let cycles: Vec<u64> =
            arrivals.iter().map(|(cycle, _)| cycle - begin).take(reads).collect();
        assert_eq!(cycles, (0..reads as u64).collect::<Vec<_>>(), "from slot {first}");
    }
}

proptest! {
    /// Order, marks and passes, with slots on chip and outside.
    #[test]
    fn behaves_as_plain_passes_over_arrays(
        layers in proptest::collection::vec(proptest::collection::vec(0u32..8, 1..14), 0..8),
        first in 0..ON_CHIP,
        depth in 1u32..=6,
        outside_latency in 1u32..=20,
        reads_in_flight in 2u32..=12,
        patterns in (pattern(), pattern(), pattern()),
    ) {
        let shape = Shape {
            count_bits: 4, depth, outside_latency, reads_in_flight, ..arrays(4, true).shape
        };
        let pixels: Vec<Pixel> =
            layers.into_iter().map(|layers| Pixel { layers, depth: 8 }).collect();
        let total: usize = pixels.iter().map(|pixel| pixel.layers.len()).sum();
        prop_assume!(total as u32 + first <= ON_CHIP + OUTSIDE);
        let (starts, arrived_ready, outside_ready) = patterns;
        let timing = Timing { starts, arrived_ready, outside_ready };
        let Seen { arrivals, again, culled } = read(shape, &pixels, first, &timing);
        prop_assert_eq!(culled, 0);
        let expected = reference(&pixels, depth, Link::Tail);
        prop_assert_eq!(again, expected.len() - 1 - total);
        let arrivals: Vec<_> = arrivals.into_iter().map(|(_, arrived)| arrived).collect();
        prop_assert_eq!(arrivals, expected);
    }

    /// With arrays of one length some fragments are hidden, and passes are as many as those take that are not.
    #[test]
    fn what_the_opaque_depth_hides_is_marked_and_takes_no_pass(
        pixels in proptest::collection::vec(
            (proptest::collection::vec(0u32..8, 1..14), 0u32..=8), 0..8,
        ),
        first in 0..ON_CHIP,
        depth in 1u32..=6,
        outside_latency in 1u32..=20,
        reads_in_flight in 2u32..=12,
        patterns in (pattern(), pattern(), pattern()),
    ) {
        let shape = Shape {
            count_bits: 4,
            depth,
            outside_latency,
            reads_in_flight,
            fixed: 15,
            ..arrays(4, false).shape
        };
        let pixels: Vec<Pixel> =
            pixels.into_iter().map(|(layers, depth)| Pixel { layers, depth }).collect();
        let total: usize = pixels.iter().map(|pixel| pixel.layers.len()).sum();
        prop_assume!(total as u32 + first <= ON_CHIP + OUTSIDE);
        let (starts, arrived_ready, outside_ready) = patterns;
        let timing = Timing { starts, arrived_ready, outside_ready };
        let Seen { arrivals, again, culled } = read(shape, &pixels, first, &timing);
        let expected = reference(&pixels, depth, Link::Tail);
        prop_assert_eq!(again, expected.len() - 1 - total);
        let hidden = |pixel: &Pixel| pixel.layers.len() - pixel.visible() as usize;
        prop_assert_eq!(culled, pixels.iter().map(hidden).sum::<usize>());
        let arrivals: Vec<_> = arrivals.into_iter().map(|(_, arrived)| arrived).collect();
        prop_assert_eq!(arrivals, expected);
    }
}

/// Of 5 fragments and 2 in a pass: a second pass begins once the first is there, a third one at once.
#[test]
fn a_deep_pixel_waits_once() {
    let shape = Shape { count_bits: 4, depth: 2, fixed: 8, ..arrays(4, false).shape };
    let pixels = [pixel_of(2), pixel_of(5), pixel_of(1)];
    let Seen { arrivals, again, .. } = read(shape, &pixels, 0, &Timing::free_running());
    assert_eq!(again, 10);
    let begin = arrivals[0].0;
    let cycles: Vec<u64> = arrivals.iter().map(|(cycle, _)| cycle - begin).take(18).collect();
    // Asked for in cycle 6 of these, the last of the first pass is known two cycles later.
    let expected: Vec<u64> = (0..7).chain(9..20).collect();
    assert_eq!(cycles, expected);
}
