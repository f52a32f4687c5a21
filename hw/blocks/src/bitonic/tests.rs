use super::*;
use crate::test_util::{Pattern, Source, pattern, refusal};
use pellucid_sim::{StreamMonitor, width_of};
use proptest::prelude::*;

type Sorted = Marked<Item<u32>>;

fn sorter(capacity_bits: u32, lane_bits: u32) -> Config<u32> {
    Config { capacity_bits, lane_bits, key_bits: 64, number_bits: 32, payload: 32 }
}

/// Items of these keys, numbered in their order, each with a payload of its own.
fn items(keys: &[u64]) -> Vec<Item<u32>> {
    let numbered = keys.iter().zip(0..);
    numbered.map(|(&key, number)| Item { key, number, payload: !number }).collect()
}

/// What a run showed.
struct Run {
    /// What left, with its cycles.
    sorted: Vec<(u64, Sorted)>,
    /// The cycles of the starts.
    starts: Vec<u64>,
    /// Passes that were complete, and the cycle of the last.
    passes: (u64, u64),
}

/// Sorts `loads` one after the other: items are offered and taken by patterns, and a load is started with its last item where
/// `at_once`, else in a cycle after it.
fn play(
    cfg: Config<u32>,
    loads: &[Vec<Item<u32>>],
    at_once: bool,
    offers: &Pattern,
    ready: &Pattern,
) -> Run {
    let (mut q, mut m) = (BitonicSorter::<u32>::reset(&cfg), BitonicSorter::memories(&cfg));
    let mut run = Run { sorted: vec![], starts: vec![], passes: (0, 0) };
    let mut monitor = StreamMonitor::new("sorted", "BitonicSorter", "test");
    let mut cycle = 0;
    for load in loads {
        let mut source = Source::new(load.iter().copied(), offers.clone());
        let (mut taken, mut started, mut ended) = (0, false, false);
        while !ended {
            assert!(cycle < 1_000_000, "the end does not come");
            let seen = BitonicSorter::moore(&cfg, &q, &m);
            assert_eq!(seen.idle, !started, "in cycle {cycle}");
            let offer = source.offer(cycle);
            let takes = offer.valid && seen.ready;
            source.edge(seen.ready);
            taken += usize::from(takes);
            let all = if at_once { taken } else { taken - usize::from(takes) };
            let start = !started && all == load.len();
            let sorted = seen.sorted.with(ready.at(cycle));
            monitor.observe(sorted).unwrap();
            let inputs = In { load: offer, start, sorted_ready: sorted.ready };
            let mut d = q;
            let out = BitonicSorter::next(&cfg, &q, &mut d, &mut m, inputs);
            assert!(!m.clock(), "a memory is misused in cycle {cycle}");
            d.check(&cfg.capacity_bits).unwrap();
            q = d;
            if start {
                started = true;
                run.starts.push(cycle);
            }
            if out.pass {
                run.passes = (run.passes.0 + 1, cycle);
            }
            if sorted.fires() {
                ended = sorted.payload.end;
                let seen = if ended { Marked::end() } else { sorted.payload };
                run.sorted.push((cycle, seen));
            }
            cycle += 1;
        }
    }
    run
}

/// What a plain sort gives.
fn reference(loads: &[Vec<Item<u32>>]) -> Vec<Sorted> {
    let sorted = |load: &Vec<Item<u32>>| {
        let mut load = load.clone();
        load.sort_by_key(|item| (item.key, item.number));
        load.into_iter().map(Marked::item).chain([Marked::end()])
    };
    loads.iter().flat_map(sorted).collect()
}

fn free_running(cfg: Config<u32>, keys: &[u64]) -> Run {
    let run = play(cfg, &[items(keys)], false, &Pattern::always(), &Pattern::always());
    assert_eq!(given(&run), reference(&[items(keys)]));
    run
}

fn given(run: &Run) -> Vec<Sorted> {
    run.sorted.iter().map(|(_, item)| *item).collect()
}

#[test]
fn items_of_one_key_leave_by_their_number() {
    let run = free_running(sorter(3, 1), &[7, 3, 7, 3, 7]);
    let numbers = given(&run).into_iter().map(|sorted| sorted.item.number);
    assert_eq!(numbers.collect::<Vec<_>>(), [1, 3, 0, 2, 4, 0]);
}

#[test]
fn passes_are_those_of_the_padded_length() {
    // Worked by hand from k(k+1)/2: 2 items are a pass, 3 and 4 are three, 5 to 8 six.
    let found: Vec<u64> = (0..10).map(passes).collect();
    assert_eq!(found, [0, 0, 1, 3, 3, 6, 6, 6, 6, 10]);
    assert_eq!((passes(1 << 16), passes(1 << 20)), (136, 210));
}

#[test]
fn a_pass_takes_half_its_items_over_the_lanes_and_a_cycle() {
    // (items, bits of the lanes): passes, cycles of one; the items are padded to 16, 64, 64, 64 and 8.
    let cases = [
        (9, 0, 10, 8 + 1),
        (64, 0, 21, 32 + 1),
        (33, 2, 21, 8 + 1),
        (64, 4, 21, 2 + 1),
        (5, 4, 6, 1 + 1),
    ];
    for (count, lane_bits, passes, cycles) in cases {
        let cfg = sorter(6, lane_bits);
        let keys: Vec<u64> = (0..count).map(|k| k * 37 % 23).collect();
        let run = free_running(cfg, &keys);
        let start = run.starts[0];
        assert_eq!(run.passes, (passes, start + passes * cycles), "{count} items");
        assert_eq!(cfg.cycles(count), passes * cycles);
        // The first is read in the next cycle, and one leaves in each from then on; then the end.
        let left: Vec<u64> = run.sorted.iter().map(|(cycle, _)| *cycle).collect();
        let first = start + passes * cycles + 2;
        assert_eq!(left, (first..=first + count).collect::<Vec<_>>());
    }
}

#[test]
fn nothing_and_one_item_are_sorted_without_a_pass() {
    for keys in [&[][..], &[5]] {
        let run = free_running(sorter(4, 1), keys);
        assert_eq!(run.passes, (0, 0));
        assert_eq!(run.sorted.len(), keys.len() + 1);
    }
}

/// A network of compare-exchanges that sorts all inputs of zeros and ones sorts all inputs (Knuth, the 0-1 principle).
#[test]
fn every_input_of_zeros_and_ones_is_sorted() {
    for lane_bits in 0..=2 {
        for count in 0..=9 {
            for pattern in 0..1u64 << count {
                let keys: Vec<u64> = (0..count).map(|k| pattern >> k & 1).collect();
                free_running(sorter(4, lane_bits), &keys);
            }
        }
    }
}

#[test]
fn it_takes_no_more_than_it_holds() {
    let cfg = sorter(1, 0);
    let (mut q, mut m) = (BitonicSorter::<u32>::reset(&cfg), BitonicSorter::memories(&cfg));
    for count in 0..4 {
        assert_eq!(BitonicSorter::moore(&cfg, &q, &m).ready, count < 2);
        let load = Stream::offer(Item::default());
        let mut d = q;
        let inputs = In::<u32> { load, start: false, sorted_ready: true };
        BitonicSorter::next(&cfg, &q, &mut d, &mut m, inputs);
        assert!(!m.clock());
        q = d;
    }
    assert_eq!(q.count, 2);
}

#[test]
fn a_word_is_key_number_payload_and_whether_it_pads() {
    let cfg = Config { key_bits: 43, number_bits: 16, ..sorter(16, 2) };
    assert_eq!(width_of::<Entry<u32>>(&cfg), 1 + 43 + 16 + 32);
}

#[test]
fn what_it_cannot_be_is_refused() {
    let says = |cfg| refusal::<BitonicSorter<u32>>(&cfg);
    let expected = "the bits of the capacity of a bitonic sorter is 2: expected 3 to 24";
    assert_eq!(says(sorter(2, 2)), expected);
    let expected = "the bits of the lanes of a bitonic sorter is 5: expected at most 4";
    assert_eq!(says(sorter(9, 5)), expected);
    let key = Config { key_bits: 65, ..sorter(4, 0) };
    assert_eq!(says(key), "the bits of a key is 65: expected at most 64");
    let number = Config { number_bits: 33, ..sorter(4, 0) };
    assert_eq!(says(number), "the bits of an item's number is 33: expected at most 32");
}

/// Keys of few values or of any.
fn keys(most: usize) -> impl Strategy<Value = Vec<u64>> {
    let key = prop_oneof![3 => 0..4u64, 1 => any::<u64>()];
    proptest::collection::vec(key, 0..=most)
}

proptest! {
    #[test]
    fn what_leaves_is_what_a_plain_sort_gives(
        lane_bits in 0..=MAX_LANE_BITS,
        loads in proptest::collection::vec(keys(70), 1..4),
        at_once: bool,
        (offers, ready) in (pattern(), pattern()),
    ) {
        let loads: Vec<_> = loads.iter().map(|keys| items(keys)).collect();
        let run = play(sorter(7, lane_bits), &loads, at_once, &offers, &ready);
        prop_assert_eq!(given(&run), reference(&loads));
        let expected: u64 = loads.iter().map(|load| passes(load.len() as u64)).sum();
        prop_assert_eq!(run.passes.0, expected);
    }
}
