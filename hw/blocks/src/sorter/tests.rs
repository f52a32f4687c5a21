use super::*;
use crate::test_util::{Pattern, Source, pattern};
use pellucid_sim::{Label, Sim, StreamMonitor};
use proptest::prelude::*;

/// One fragment of a pixel: depth, and whether the opaque depth lets it be seen.
type Layer = (u32, bool);

const PIXELS: u32 = 64;
const LAYERS: u32 = 512;

/// A colour that no other fragment of the frame has.
fn colour(pixel: usize, layer: usize) -> u32 {
    (pixel as u32) << 16 | layer as u32
}

fn sorter(depth: u32, newest_first: bool) -> Config {
    Config {
        depth,
        pixel_bits: bits_for((PIXELS - 1).into()),
        layer_bits: bits_for(LAYERS.into()),
        newest_first,
    }
}

/// The frame as the reader of the chains sends it: each pixel in `ceil(visible / depth)` passes, at
/// least one. Layers are given in the order of their arrival.
fn passes(cfg: Config, pixels: &[Vec<Layer>]) -> Vec<Marked<Arrived>> {
    let mut frame = vec![];
    for (pixel, layers) in pixels.iter().enumerate() {
        let visible = layers.iter().filter(|layer| layer.1).count() as u32;
        let count = visible.div_ceil(cfg.depth).max(1);
        for pass in 0..count {
            for at in 0..layers.len() {
                let k = if cfg.newest_first { layers.len() - 1 - at } else { at };
                let (z, visible) = layers[k];
                frame.push(Marked::item(Arrived {
                    pixel: pixel as u32,
                    z,
                    rgba: colour(pixel, k),
                    weight: 0,
                    visible,
                    last: at + 1 == layers.len(),
                    last_pass: pass + 1 == count,
                    label: label(pixel, k),
                }));
            }
        }
    }
    frame.push(Marked::end());
    frame
}

/// Labels go with their fragments.
fn label(pixel: usize, k: usize) -> Label {
    Label::new(k as u32, pixel as u16, 0)
}

/// What must come out: each pixel's visible fragments by a stable sort, then the end.
fn reference(pixels: &[Vec<Layer>]) -> Vec<Marked<Sorted>> {
    let mut frame = vec![];
    for (pixel, layers) in pixels.iter().enumerate() {
        let mut visible: Vec<(u32, usize)> = vec![];
        visible.extend(layers.iter().enumerate().filter(|(_, l)| l.1).map(|(k, l)| (l.0, k)));
        visible.sort_by_key(|&(z, _)| std::cmp::Reverse(z));
        for (at, &(_, k)) in visible.iter().enumerate() {
            let last = at + 1 == visible.len();
            let rgba = colour(pixel, k);
            let label = label(pixel, k);
            frame.push(Marked::item(Sorted { pixel: pixel as u32, rgba, last, label }));
        }
    }
    frame.push(Marked::end());
    frame
}

/// Sorts `frames` one after the other; gives what came out, with its cycles.
fn play(
    cfg: Config,
    frames: &[Vec<Marked<Arrived>>],
    starts: Pattern,
    ready: &Pattern,
) -> Vec<(u64, Marked<Sorted>)> {
    let mut sim = Sim::<Sorter>::new(cfg);
    let mut source = Source::new(frames.concat(), starts);
    let mut monitor = StreamMonitor::new("sorted", "Sorter", "test");
    let (mut out, mut ends) = (vec![], 0);
    for cycle in 0.. {
        assert!(cycle < 200_000, "the end of the frame does not come");
        let seen = sim.moore();
        let sorted = seen.sorted.with(ready.at(cycle));
        monitor.observe(sorted).unwrap();
        let arrived = source.offer(cycle);
        source.edge(seen.ready);
        sim.clock(In { arrived, sorted_ready: sorted.ready }).unwrap();
        if sorted.fires() {
            let end = sorted.payload.end;
            out.push((cycle, if end { Marked::end() } else { sorted.payload }));
            ends += usize::from(end);
        }
        if ends == frames.len() {
            break;
        }
    }
    out
}

fn items(out: Vec<(u64, Marked<Sorted>)>) -> Vec<Marked<Sorted>> {
    out.into_iter().map(|(_, item)| item).collect()
}

fn free_running(cfg: Config, pixels: &[Vec<Layer>]) -> Vec<(u64, Marked<Sorted>)> {
    play(cfg, &[passes(cfg, pixels)], Pattern::always(), &Pattern::always())
}

#[test]
fn far_to_near_and_equal_depths_as_they_came() {
    let layers = vec![(5, true), (9, true), (5, true), (7, false), (9, true)];
    for newest_first in [false, true] {
        let sorted = items(free_running(sorter(8, newest_first), std::slice::from_ref(&layers)));
        let order: Vec<u32> = sorted.iter().map(|s| s.item.rgba).take(4).collect();
        assert_eq!(order, [1, 4, 0, 2]);
    }
}

#[test]
fn one_depth_over_several_passes() {
    let pixels = [vec![(3, true); 7], vec![(3, true); 2], vec![(3, true); 4]];
    for cfg in (1..=4).flat_map(|depth| [sorter(depth, false), sorter(depth, true)]) {
        assert_eq!(items(free_running(cfg, &pixels)), reference(&pixels), "{cfg:?}");
    }
}

#[test]
fn a_pixel_of_which_nothing_is_seen_gives_nothing() {
    let hidden = vec![(1, false); 3];
    let pixels = [hidden.clone(), vec![(2, true)], hidden.clone(), hidden];
    assert_eq!(items(free_running(sorter(2, false), &pixels)), reference(&pixels));
}

#[test]
fn a_stalled_receiver_gets_the_pixel_before_a_hidden_one_unchanged() {
    // The hidden pixel is closed while the one before it still waits, and the next is not begun.
    let pixels = [vec![(2, true), (1, true)], vec![(1, false)], vec![(4, true)]];
    let cfg = sorter(4, false);
    let frame = passes(cfg, &pixels);
    for late in 1..12 {
        let cycles: Vec<bool> = (0..=late).map(|cycle| cycle == late).collect();
        let out = play(cfg, std::slice::from_ref(&frame), Pattern::always(), &Pattern::of(cycles));
        assert_eq!(items(out), reference(&pixels), "taken every {} cycles", late + 1);
    }
}

/// Passes of so many fragments each, of which so many leave: a pass's last fragment closes it for the next cycle,
/// from then on one fragment leaves a cycle.
fn leaving_cycles(passes: &[(u32, u32)]) -> Vec<u64> {
    let (mut closes, mut free, mut cycles) = (0, 0, vec![]);
    for &(come, leave) in passes {
        closes += u64::from(come);
        for _ in 0..leave {
            let leaves = closes.max(free);
            cycles.push(leaves);
            free = leaves + 1;
        }
    }
    // The end comes in behind the last fragment.
    cycles.push((closes + 1).max(free));
    cycles
}

/// The passes of pixels with so many visible fragments, at most `depth` of which leave in each.
fn passes_of(depth: u32, layers: &[u32]) -> Vec<(u32, u32)> {
    let of = |n: &u32| {
        let n = *n;
        (0..n.div_ceil(depth)).map(move |k| (n, depth.min(n - k * depth)))
    };
    layers.iter().flat_map(of).collect()
}

fn leaves_on_time(cfg: Config, layers: &[u32]) -> Result<(), TestCaseError> {
    let pixel = |n: &u32| (0..*n).map(|z| (z * 7 % 5, true)).collect();
    let pixels: Vec<Vec<Layer>> = layers.iter().map(pixel).collect();
    let out = free_running(cfg, &pixels);
    let cycles: Vec<u64> = out.iter().map(|(cycle, _)| *cycle).collect();
    prop_assert_eq!(
        cycles,
        leaving_cycles(&passes_of(cfg.depth, layers)),
        "{:?}, {:?}",
        cfg,
        layers
    );
    Ok(())
}

/// Those with exactly K fragments among them.
#[test]
fn pixels_pass_at_one_fragment_a_cycle() {
    for layers in [vec![1; 40], vec![3; 20], vec![1, 4, 2, 8, 1, 1, 5, 8, 3, 2, 2, 7]] {
        for depth in [1, 2, 3, 4, 8, 16] {
            leaves_on_time(sorter(depth, false), &layers).unwrap();
        }
    }
}

#[test]
fn a_pass_closes_while_the_one_before_leaves() {
    // 12 fragments through K = 4: three passes of 12, which come in in cycles 0 to 11, 12 to 23 and 24 to 35. Of each
    // the four farthest leave in the cycles after.
    let pixel: Vec<Layer> = (0..12).map(|z| (z, true)).collect();
    let cycles: Vec<u64> =
        free_running(sorter(4, false), &[pixel]).iter().map(|(cycle, _)| *cycle).collect();
    assert_eq!(cycles, [12, 13, 14, 15, 24, 25, 26, 27, 36, 37, 38, 39, 40]);
}

proptest! {
    /// Far beyond K, K = 64 included.
    #[test]
    fn deep_pixels_are_exact(
        depth in prop_oneof![Just(1u32), Just(5u32), Just(64u32)],
        newest_first in any::<bool>(),
        layers in proptest::collection::vec((0u32..12, prop::bool::weighted(0.9)), 130..300),
    ) {
        let pixels = [layers];
        let cfg = sorter(depth, newest_first);
        prop_assert_eq!(items(free_running(cfg, &pixels)), reference(&pixels));
    }
    /// Pixels of any number of layers, one after the other, whatever the receiver does.
    #[test]
    fn pixels_are_exact_and_on_time(
        depth in 1u32..9,
        newest_first in any::<bool>(),
        layers in proptest::collection::vec(1u32..20, 1..12),
        starts in pattern(),
        ready in pattern(),
    ) {
        let cfg = sorter(depth, newest_first);
        leaves_on_time(cfg, &layers)?;
        let pixel = |n: &u32| (0..*n).map(|z| (z * 7 % 5, z % 4 > 0)).collect();
        let pixels: Vec<Vec<Layer>> = layers.iter().map(pixel).collect();
        let frame = passes(cfg, &pixels);
        let out = play(cfg, &[frame.clone(), frame], starts, &ready);
        let once = reference(&pixels);
        prop_assert_eq!(items(out), [once.clone(), once].concat());
    }
}

#[test]
#[should_panic(expected = "the depth of a sorter is 65: expected 1 to 64")]
fn a_depth_beyond_its_registers_is_none() {
    Sorter::reset(&sorter(65, false));
}
