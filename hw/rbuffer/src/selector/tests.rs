use super::*;
use crate::test_util::{Pattern, Source, contents, edge, holding, pattern, small_rbuffer};
use pellucid_machine::pixel::Z_FAR;
use pellucid_sim::{Label, ReadDuringWrite, Sim, StreamMonitor};
use proptest::prelude::*;

/// What a fragment came to; one that is passed over or thrown away leaves no trace.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Pushed(PixelFragment),
    Picked(PixelFragment),
    Culled,
    Dropped,
    Overflowed,
}
use Fate::{Culled, Dropped, Overflowed, Picked, Pushed};

/// How fragments come.
#[derive(Clone, Debug)]
struct Course {
    starts: Pattern,
    room: Pattern,
    full: bool,
    round: rounds::Moore,
}

/// All in every cycle, and room for all of the screen's.
fn free_running() -> Course {
    let (failed, smallest, again, replay) = (false, true, false, false);
    let round = rounds::Moore { from: 0, to: 21, failed, smallest, again, replay };
    Course { starts: Pattern::always(), room: Pattern::always(), full: false, round }
}

/// The selector beside the depth buffer and a queue.
struct Bench {
    sim: Sim<Selector>,
    depth: Ram1R1W<u32>,
    queue: Vec<PixelFragment>,
    parity: bool,
}

impl Bench {
    /// After reset, with the opaque depths of the first pixels; the others are at the far plane.
    fn new(opaque: &[u32]) -> Bench {
        let cfg = small_rbuffer(4, None);
        let mut depths = vec![Z_FAR; 21];
        depths[..opaque.len()].copy_from_slice(opaque);
        let depth = holding(&depths, Z_BITS, ReadDuringWrite::New);
        let mut bench = Bench { sim: Sim::new(cfg), depth, queue: vec![], parity: false };
        for pixel in 0..21 {
            bench.clock(Stream::idle(), false, false, &free_running(), 0, Stream::offer(pixel));
        }
        bench
    }

    fn clock(
        &mut self,
        fragment: Stream<Marked<PixelFragment>>,
        arrival: bool,
        first_pass: bool,
        course: &Course,
        cycle: u64,
        clear: Stream<u32>,
    ) -> Out {
        let i = In {
            fragment,
            arrival,
            first_pass,
            parity: self.parity,
            depth: self.depth.q(),
            colour: 0,
            pushed_ready: course.room.at(cycle),
            full: course.full,
            round: course.round,
            clear,
        };
        let out = self.sim.clock(i).unwrap().out;
        self.depth.pass_read(out.depth_read);
        self.depth.pass_write(out.depth_write);
        edge(&mut self.depth);
        out
    }

    /// Sends fragments, then the end; gives what they came to with the cycles, and the end's.
    fn send(
        &mut self,
        fragments: &[PixelFragment],
        arrival: bool,
        first_pass: bool,
        course: &Course,
    ) -> (Vec<(u64, Fate)>, u64) {
        let items = fragments.iter().copied().map(Marked::item).chain([Marked::end()]);
        let mut source = Source::new(items, course.starts.clone());
        let mut monitor = StreamMonitor::new("pushed", "Selector", "test");
        let mut fates = vec![];
        for cycle in 0.. {
            assert!(cycle < 10_000, "the end does not come through: {fates:?}");
            let offer = source.offer(cycle);
            source.edge(self.sim.moore().ready);
            let out = self.clock(offer, arrival, first_pass, course, cycle, Stream::idle());
            let pushed = out.pushed.with(course.room.at(cycle));
            monitor.observe(pushed).unwrap();
            if pushed.fires() {
                self.queue.push(pushed.payload);
                fates.push((cycle, Pushed(pushed.payload)));
            }
            if out.picked.valid {
                let Marked { end, item: Sorted { pixel, rgba, last, label } } = out.picked.payload;
                assert!(
                    last && !end,
                    "each is blended by itself, and the end is not the selector's"
                );
                let of = |f: &&PixelFragment| (f.pixel, f.rgba, f.label) == (pixel, rgba, label);
                fates.push((cycle, Picked(*fragments.iter().find(of).unwrap())));
            }
            let flags =
                [(out.culled, Culled), (out.dropped, Dropped), (out.overflowed, Overflowed)];
            fates.extend(flags.iter().filter(|(seen, _)| *seen).map(|(_, fate)| (cycle, *fate)));
            if out.ended {
                return (fates, cycle);
            }
        }
        unreachable!("the loop ends by return")
    }

    fn arrive(&mut self, fragments: &[PixelFragment], course: &Course) -> Vec<Fate> {
        let (fates, _) = self.send(fragments, true, false, course);
        fates.into_iter().map(|(_, fate)| fate).collect()
    }

    /// All that is in the queue, once round.
    fn pass(&mut self, first: bool, course: &Course) -> Vec<Fate> {
        self.parity = !self.parity;
        let queue = std::mem::take(&mut self.queue);
        let (fates, _) = self.send(&queue, false, first, course);
        fates.into_iter().map(|(_, fate)| fate).collect()
    }
}

/// A fragment that no other is like.
fn fragment(number: u32, pixel: u32, z: u32) -> PixelFragment {
    PixelFragment { pixel, z, rgba: 0xabcd_0000 | number, label: Label::new(number, 0, 0) }
}

/// Fragments of one pixel at these depths.
fn at<const N: usize>(pixel: u32, depths: [u32; N]) -> [PixelFragment; N] {
    std::array::from_fn(|k| fragment(k as u32, pixel, depths[k]))
}

#[test]
fn a_pixels_farthest_is_blended_in_each_pass() {
    let mut bench = Bench::new(&[]);
    let free = free_running();
    let [near, far, middle] = at(3, [3, 9, 5]);
    let all = [near, far, middle];
    assert_eq!(bench.arrive(&all, &free), all.map(Pushed));
    assert_eq!(bench.pass(true, &free), [Pushed(near), Picked(far), Pushed(middle)]);
    assert_eq!(bench.pass(false, &free), [Pushed(near), Picked(middle)]);
    assert_eq!(bench.pass(false, &free), [Picked(near)]);
}

#[test]
fn of_equal_depths_one_a_pass_in_the_order_of_arrival() {
    let mut bench = Bench::new(&[]);
    let free = free_running();
    let [first, second, third] = at(0, [7, 7, 7]);
    bench.arrive(&[first, second, third], &free);
    assert_eq!(bench.pass(true, &free), [Picked(first), Pushed(second), Pushed(third)]);
    assert_eq!(bench.pass(false, &free), [Picked(second), Pushed(third)]);
    assert_eq!(bench.pass(false, &free), [Picked(third)]);
}

#[test]
fn a_first_pass_with_hidden_fragments_only_culls() {
    let mut bench = Bench::new(&[Z_FAR, 6]);
    let free = free_running();
    let [in_front, level, behind] = at(1, [3, 6, 9]);
    bench.arrive(&[in_front, level, behind], &free);
    assert_eq!(bench.pass(true, &free), [Pushed(in_front), Culled, Culled]);
    // Nothing was blended: the depth is the opaque one still.
    assert_eq!(contents(&mut bench.depth, 2), [Z_FAR, 6]);
    assert_eq!(bench.pass(false, &free), [Picked(in_front)]);
}

#[test]
fn the_depth_buffer_has_the_depth_that_is_blended_from_the_first_pass_on() {
    let mut bench = Bench::new(&[8, 20]);
    let free = free_running();
    bench.arrive(&at(1, [3, 9]), &free);
    assert_eq!(contents(&mut bench.depth, 3), [8, 20, Z_FAR]);
    bench.pass(true, &free);
    assert_eq!(contents(&mut bench.depth, 3), [8, 9, Z_FAR]);
    bench.pass(false, &free);
    assert_eq!(contents(&mut bench.depth, 3), [8, 3, Z_FAR]);
}

#[test]
fn pixels_outside_the_band_are_passed_over_on_arrival() {
    let mut bench = Bench::new(&[]);
    let mut band = free_running();
    (band.round.from, band.round.to) = (2, 4);
    let f: [PixelFragment; 4] = std::array::from_fn(|k| fragment(k as u32, k as u32 + 1, 5));
    assert_eq!(bench.arrive(&f, &band), [Pushed(f[1]), Pushed(f[2])]);
    assert_eq!(bench.pass(true, &band), [Picked(f[1]), Picked(f[2])]);
}

#[test]
fn what_finds_no_room_leaves_no_trace_at_its_pixel() {
    for (smallest, fate) in [(true, Dropped), (false, Overflowed)] {
        let mut bench = Bench::new(&[]);
        let [stays, lost] = at(4, [5, 9]);
        let mut full = Course { full: true, ..free_running() };
        full.round.smallest = smallest;
        assert_eq!(bench.arrive(&[stays], &free_running()), [Pushed(stays)]);
        assert_eq!(bench.arrive(&[lost], &full), [fate]);
        // Were its depth the pixel's farthest, the one that stays would not be blended.
        assert_eq!(bench.pass(true, &free_running()), [Picked(stays)]);
    }
}

#[test]
fn in_a_pass_a_full_queue_drops_nothing() {
    let mut bench = Bench::new(&[]);
    let [near, far] = at(4, [5, 9]);
    let full = Course { full: true, ..free_running() };
    bench.arrive(&[near, far], &free_running());
    assert_eq!(bench.pass(true, &full), [Pushed(near), Picked(far)]);
}

#[test]
fn a_failed_round_is_thrown_away() {
    let mut bench = Bench::new(&[6]);
    let free = free_running();
    let mut failed = free_running();
    failed.round.failed = true;
    let [near, far, later] = at(0, [3, 9, 5]);
    bench.arrive(&[near, far], &free);
    assert_eq!(bench.arrive(&[later], &failed), [], "it does not arrive any more");
    assert_eq!(bench.pass(true, &failed), []);
    assert_eq!(contents(&mut bench.depth, 1), [6], "the opaque depth stays");
    // Were the farther one's depth remembered, the pixel's first pass would only cull.
    assert_eq!(bench.arrive(&[later], &free), [Pushed(later)]);
    assert_eq!(bench.pass(true, &free), [Picked(later)]);
}

#[test]
fn a_pixel_that_is_cleared_has_no_farthest_fragment() {
    let mut bench = Bench::new(&[6]);
    let free = free_running();
    let [behind, later] = at(0, [9, 5]);
    bench.arrive(&[behind], &free);
    bench.queue.clear();
    bench.clock(Stream::idle(), false, false, &free, 0, Stream::offer(0));
    bench.arrive(&[later], &free);
    assert_eq!(bench.pass(true, &free), [Picked(later)]);
}

#[test]
fn one_fragment_a_cycle_three_cycles_from_input_to_output() {
    let mut bench = Bench::new(&[]);
    let free = free_running();
    // Runs of one pixel and changes between pixels.
    let pixels = [2, 2, 2, 5, 2, 5, 5, 1];
    let f: Vec<PixelFragment> = pixels
        .iter()
        .enumerate()
        .map(|(k, pixel)| fragment(k as u32, *pixel, 9 - k as u32))
        .collect();
    let cycles: Vec<u64> = (2..10).collect();
    let (arrived, end) = bench.send(&f, true, false, &free);
    assert_eq!(arrived.iter().map(|(cycle, _)| *cycle).collect::<Vec<_>>(), cycles);
    assert_eq!(end, 10);
    bench.parity = true;
    let (passed, end) = bench.send(&f, false, true, &free);
    assert_eq!(passed.iter().map(|(cycle, _)| *cycle).collect::<Vec<_>>(), cycles);
    let picked = passed.iter().filter(|(_, fate)| matches!(fate, Picked(_)));
    assert_eq!(picked.map(|(cycle, _)| *cycle).collect::<Vec<_>>(), [2, 5, 9]);
    assert_eq!(end, 10);
}

#[test]
fn a_queue_that_is_not_ready_stops_it_and_loses_nothing() {
    let mut bench = Bench::new(&[]);
    let mut room = vec![false; 8];
    room.push(true);
    let slow = Course { room: Pattern::of(room), ..free_running() };
    let f = at(3, [1, 2, 3, 4, 5]);
    let (fates, end) = bench.send(&f, true, false, &slow);
    let cycles = [8, 17, 26, 35, 44];
    assert_eq!(fates, cycles.into_iter().zip(f.map(Pushed)).collect::<Vec<_>>());
    assert_eq!(end, 45);
}

/// What each fragment of a pass comes to, from all that are left in it.
fn reference(left: &[PixelFragment], first: bool, opaque: &[u32]) -> Vec<Fate> {
    let hidden = |f: &PixelFragment| f.z >= opaque[f.pixel as usize];
    let of = |pixel| left.iter().filter(move |f| f.pixel == pixel);
    let fate = |f: &PixelFragment| {
        if first && of(f.pixel).any(hidden) {
            return if hidden(f) { Culled } else { Pushed(*f) };
        }
        let farthest = of(f.pixel).map(|f| f.z).max();
        let first_there = of(f.pixel).find(|f| Some(f.z) == farthest);
        if first_there == Some(f) { Picked(*f) } else { Pushed(*f) }
    };
    left.iter().map(fate).collect()
}

fn course() -> impl Strategy<Value = Course> {
    (pattern(), pattern()).prop_map(|(starts, room)| Course { starts, room, ..free_running() })
}

proptest! {
    /// Frame after frame, pass after pass until nothing is left.
    #[test]
    fn passes_are_those_over_plain_lists(
        frames in proptest::collection::vec(
            (
                proptest::collection::vec((0..4_u32, 0..5_u32), 0..24),
                proptest::collection::vec(prop_oneof![Just(Z_FAR), 0..6_u32], 4),
            ),
            1..4,
        ),
        course in course(),
    ) {
        let mut bench = Bench::new(&[]);
        for (fragments, opaque) in frames {
            bench.depth = holding(&[opaque.clone(), vec![Z_FAR; 17]].concat(), Z_BITS, ReadDuringWrite::New);
            let frame: Vec<PixelFragment> = fragments
                .iter()
                .enumerate()
                .map(|(number, (pixel, z))| fragment(number as u32, *pixel, *z))
                .collect();
            let arrived: Vec<Fate> = frame.iter().copied().map(Pushed).collect();
            prop_assert_eq!(bench.arrive(&frame, &course), arrived);
            let mut first = true;
            while !bench.queue.is_empty() {
                let expected = reference(&bench.queue, first, &opaque);
                prop_assert_eq!(bench.pass(first, &course), expected);
                first = false;
            }
        }
    }
}
