use super::*;
use crate::chains::config::{Link, Shape};
use crate::chains::tables::SsaEntry;
use crate::chains::test_util::{Pixel, Stored, meaning, reference};
use crate::test_util::{Pattern, Source, edge, pattern, screen, shape, traffic};
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;
use proptest::sample::select;
use std::collections::{BTreeSet, VecDeque};

const ON_CHIP: u32 = 60;
const OUTSIDE: u32 = 60;
const NULL: u32 = ON_CHIP + OUTSIDE;
const LINKS: [Link; 3] = [Link::Walk, Link::Tail, Link::Head];

/// The reader beside models of what it reads, and of the release queue.
struct Bench {
    sim: Sim<ChainReader>,
    stored: Stored,
    chains: Vec<Chain>,
}

/// When things come and go.
#[derive(Clone, Debug)]
struct Timing {
    starts: Pattern,
    arrived_ready: Pattern,
    release_pop: Pattern,
    outside_ready: Pattern,
}

impl Timing {
    fn free_running() -> Timing {
        let always = Pattern::always;
        Timing {
            starts: always(),
            arrived_ready: always(),
            release_pop: always(),
            outside_ready: always(),
        }
    }
}

/// What a frame came to.
#[derive(Debug, Default)]
struct Seen {
    arrived: Vec<(u64, Marked<Arrived>)>,
    /// In the order in which they were let go.
    released: Vec<u32>,
    begun: usize,
    culled: usize,
    read: usize,
    read_again: usize,
}

impl Bench {
    /// The pixels' fragments are laid into `sections`, in that order.
    fn new(shape: Shape, pixels: &[Pixel], sections: &[u32]) -> Bench {
        let shape = Shape { on_chip: ON_CHIP, outside: OUTSIDE, ..shape };
        let cfg = Config::new(screen(8, 8), shape);
        let stored = Stored::new(&cfg, pixels, sections);
        let chain = |(number, (pixel, entry)): (usize, (&Pixel, &SsaEntry))| Chain {
            pixel: number as u32,
            depth: pixel.depth,
            entry: *entry,
        };
        let chains = pixels.iter().zip(&stored.entries).enumerate().map(chain).collect();
        Bench { sim: Sim::new(cfg), stored, chains }
    }

    /// Reads all chains as one frame.
    fn read(&mut self, timing: &Timing) -> Seen {
        let cfg = *self.sim.config();
        let frame = self.chains.iter().copied().map(Marked::item).chain([Marked::end()]);
        let mut source = Source::new(frame, timing.starts.clone());
        let mut monitor = StreamMonitor::new("arrived", "ChainReader", "test");
        let (mut open, mut committed) = (vec![], VecDeque::new());
        let (mut read_from, mut let_go) = (BTreeSet::new(), BTreeSet::new());
        let mut seen = Seen::default();
        let mut ended = false;
        for cycle in 0.. {
            assert!(cycle < 100_000, "the frame does not end: {seen:?}");
            let word = self.stored.words.answer(cycle);
            let release_ready = ((open.len() + committed.len()) as u32) < cfg.release.depth;
            let moore = self.sim.moore();
            let arrived = moore.arrived.with(timing.arrived_ready.at(cycle));
            monitor.observe(arrived).unwrap();
            let i = In {
                chain: source.offer(cycle),
                nsa: self.stored.nsa.q(),
                word,
                arrived_ready: arrived.ready,
                release_ready,
                outside_ready: timing.outside_ready.at(cycle),
            };
            source.edge(moore.ready);
            let out = self.sim.clock(i).unwrap().out;
            self.stored.nsa.pass(out.nsa);
            edge(&mut self.stored.nsa);

            if out.read.valid {
                let section = out.read.payload.section;
                assert!(i.outside_ready || !cfg.is_outside(section), "the port takes nothing");
                self.stored.words.ask(cycle, out.read.payload);
                assert!(
                    !let_go.contains(&section),
                    "cycle {cycle}: section {section} was released"
                );
                read_from.insert(section);
                seen.read += 1;
                seen.read_again += usize::from(out.read_again);
            }
            seen.begun += usize::from(out.begins);
            seen.culled += usize::from(out.culled);
            if arrived.fires() {
                assert!(!ended, "something follows the end");
                ended = arrived.payload.end;
                seen.arrived.push((cycle, meaning(arrived.payload)));
            }
            let waiting = seen.read - (seen.arrived.len() - usize::from(ended));
            assert!(waiting <= cfg.shape.reads_in_flight as usize, "{waiting} reads in flight");

            if timing.release_pop.at(cycle) {
                seen.released.extend(committed.pop_front());
            }
            assert!(!(out.release.abort && (out.release.commit || out.release.push.valid)));
            if out.release.push.valid {
                assert!(release_ready, "a section is pushed where there is no room");
                open.push(out.release.push.payload);
            }
            if out.release.commit {
                for section in open.drain(..) {
                    assert!(read_from.contains(&section), "section {section} was never read");
                    assert!(let_go.insert(section), "section {section} is released twice");
                    committed.push_back(section);
                }
            }
            if out.release.abort {
                open.clear();
            }
            if ended && committed.is_empty() {
                break;
            }
        }
        assert!(open.is_empty(), "sections are left open");
        seen
    }
}

fn arrivals(seen: &Seen) -> Vec<Marked<Arrived>> {
    seen.arrived.iter().map(|(_, arrived)| *arrived).collect()
}

fn pixel_of(count: u32) -> Pixel {
    Pixel { layers: (0..count).collect(), depth: 1000 }
}

#[test]
fn one_fragment_a_cycle_across_sections_and_pixels() {
    for link in LINKS {
        for capacity in 1..=4 {
            let shape = Shape { link, capacity, ..shape() };
            let pixels: Vec<Pixel> = [1, 1, 1, 5, 2, 4, 8, 1, 3, 3].map(pixel_of).to_vec();
            let sections: Vec<u32> = (0..ON_CHIP).rev().collect();
            let seen = Bench::new(shape, &pixels, &sections).read(&Timing::free_running());
            let first = seen.arrived[0].0;
            let cycles: Vec<u64> = seen.arrived.iter().map(|(c, _)| *c).take(29).collect();
            let expected: Vec<u64> = (first..first + 29).collect();
            assert_eq!(cycles, expected, "{link:?}, L = {capacity}");
        }
    }
}

#[test]
fn outside_sections_are_read_at_one_fragment_a_cycle_too() {
    let shape = Shape { outside_latency: 20, ..shape() };
    let pixels: Vec<Pixel> = [6, 6, 6].map(pixel_of).to_vec();
    let sections: Vec<u32> = (ON_CHIP..NULL).collect();
    let seen = Bench::new(shape, &pixels, &sections).read(&Timing::free_running());
    let first = seen.arrived[0].0;
    let cycles: Vec<u64> = seen.arrived.iter().map(|(cycle, _)| *cycle).take(18).collect();
    assert_eq!(cycles, (first..first + 18).collect::<Vec<_>>());
}

#[test]
fn sections_on_either_side_by_turns_are_read_at_one_fragment_a_cycle_too() {
    let shape = Shape { outside_latency: 20, reads_in_flight: 24, ..shape() };
    let pixels = vec![pixel_of(1); 60];
    let sections: Vec<u32> = (0..30).flat_map(|k| [k, ON_CHIP + k]).collect();
    let seen = Bench::new(shape, &pixels, &sections).read(&Timing::free_running());
    let cycles: Vec<u64> = seen.arrived.iter().map(|(cycle, _)| *cycle).take(60).collect();
    // The first fragment lies on chip; from the second one on, nothing is waited for.
    let second = cycles[1];
    assert_eq!(cycles[1..], (second..second + 59).collect::<Vec<_>>());
}

#[test]
fn as_many_visible_fragments_as_the_sorter_holds_take_one_pass() {
    let shape = Shape { passes: Passes::Each(4), ..shape() };
    let sections: Vec<u32> = (0..ON_CHIP).collect();
    let passes = |layers: Vec<u32>, depth| {
        let n = layers.len();
        let pixels = [Pixel { layers, depth }];
        Bench::new(shape, &pixels, &sections).read(&Timing::free_running()).read / n
    };
    assert_eq!(passes(vec![1; 4], 2), 1);
    assert_eq!(passes(vec![1; 5], 2), 2);
    assert_eq!(passes(vec![1; 8], 2), 2);
    assert_eq!(passes(vec![1; 9], 2), 3);
    assert_eq!(passes(vec![1, 2, 1, 2, 1, 2, 1, 2, 2], 2), 1, "hidden ones do not count");
    assert_eq!(passes(vec![2; 9], 2), 1, "one pass shows that nothing is visible");
}

fn pixel() -> impl Strategy<Value = Pixel> {
    let layers = prop_oneof![3 => 1usize..5, 1 => 5usize..16];
    let layers = layers.prop_flat_map(|n| proptest::collection::vec(0u32..8, n));
    (layers, prop_oneof![2 => Just(8u32), 1 => 0u32..9])
        .prop_map(|(layers, depth)| Pixel { layers, depth })
}

fn timing() -> impl Strategy<Value = Timing> {
    (pattern(), pattern(), pattern(), pattern()).prop_map(
        |(starts, arrived_ready, release_pop, outside_ready)| Timing {
            starts,
            arrived_ready,
            release_pop,
            outside_ready,
        },
    )
}

proptest! {
    /// Order, marks, passes and releases, with sections on chip and outside mixed.
    #[test]
    fn behaves_as_plain_passes_over_lists(
        pixels in proptest::collection::vec(pixel(), 0..8),
        sections in Just((0..NULL).collect::<Vec<u32>>()).prop_shuffle(),
        link in select(&LINKS),
        section_capacity in 1u32..=4,
        sorter_depth in 1u32..=6,
        outside_latency in 1u32..=20,
        reads_in_flight in 2u32..=12,
        timing in timing(),
    ) {
        let shape = Shape {
            link,
            capacity: section_capacity,
            passes: Passes::Each(sorter_depth),
            outside_latency,
            reads_in_flight,
            ..shape()
        };
        let mut bench = Bench::new(shape, &pixels, &sections);
        let (nsa_reads, _) = traffic(&mut bench.stored.nsa);
        let seen = bench.read(&timing);
        // Each pass reads the NSA entry of each section once, and so does the releasing walk of a
        // pixel that does not fit the sorter, where sections are released. With kept tails a chain's last section has none.
        let releases = link != Link::Head;
        let deep = |p: &Pixel| p.layers.len() as u32 > sorter_depth;
        let walks = |p: &Pixel| p.passes(sorter_depth) + u32::from(deep(p) && releases);
        let last = u32::from(link == Link::Tail);
        let entries = |p: &Pixel| (p.layers.len() as u32).div_ceil(section_capacity) - last;
        let expected: u32 = pixels.iter().map(|p| walks(p) * entries(p)).sum();
        prop_assert_eq!(traffic(&mut bench.stored.nsa).0 - nsa_reads, u64::from(expected));
        let expected = reference(&pixels, sorter_depth, link);
        prop_assert_eq!(arrivals(&seen), expected.clone());
        prop_assert_eq!(arrivals(&bench.read(&timing)), expected, "the second frame");
        let (mut released, mut used) = (seen.released, bench.stored.used);
        released.sort();
        used.sort();
        if releases {
            prop_assert_eq!(released, used, "each section is released once");
        } else {
            prop_assert_eq!(released, vec![], "none is released");
        }
        let fragments: usize = pixels.iter().map(|p| p.layers.len()).sum();
        prop_assert_eq!(seen.begun, pixels.len());
        prop_assert_eq!(seen.read - seen.read_again, fragments);
        let visible: u32 = pixels.iter().map(Pixel::visible).sum();
        prop_assert_eq!(seen.culled, fragments - visible as usize);
    }

    /// A section that moves onto the chip makes nothing later.
    #[test]
    fn more_sections_on_chip_are_never_slower(
        pixels in proptest::collection::vec(pixel(), 1..8),
        sections in Just((0..NULL).collect::<Vec<u32>>()).prop_shuffle(),
        moved in any::<prop::sample::Index>(),
        outside_latency in 1u32..=20,
        reads_in_flight in 2u32..=24,
    ) {
        let shape = Shape { outside_latency, reads_in_flight, ..shape() };
        let at = |sections: &[u32]| {
            let seen = Bench::new(shape, &pixels, sections).read(&Timing::free_running());
            seen.arrived.iter().map(|(cycle, _)| *cycle).collect::<Vec<_>>()
        };
        let before = at(&sections);
        let mut other = sections.clone();
        // The first section of that list that lies outside changes places with one on chip that no pixel has.
        let used: usize = pixels.iter().map(|p| p.layers.len().div_ceil(3)).sum();
        let outside: Vec<usize> = (0..used).filter(|k| sections[*k] >= ON_CHIP).collect();
        let free = (used..sections.len()).find(|k| sections[*k] < ON_CHIP);
        if let (false, Some(free)) = (outside.is_empty(), free) {
            other.swap(outside[moved.index(outside.len())], free);
        }
        let after = at(&other);
        prop_assert!(after.iter().zip(&before).all(|(a, b)| a <= b), "{before:?}, then {after:?}");
    }
}
