use super::*;
use crate::cache::test_util::{Events, Reference};
use crate::test_util::{
    Behind, Bench, Counted, Pattern, at_first, pattern, read, refusal, requests, word, write,
};
use proptest::prelude::*;

/// Words behind the caches of these tests.
const WORDS: u32 = 64;

/// A cache of that shape, of words of 70 bits.
pub(super) fn config(sets: u32, ways: u32, line: u32, write_back: bool) -> Config {
    Config { port: outside::Config { words: WORDS, bits: 70 }, sets, ways, line, write_back }
}

impl Counted for Cache {
    type Events = Events;
    const ANSWERED: bool = true;
    fn count(out: &Out, events: &mut Events) {
        events.hits += u32::from(out.hit);
        events.misses += u32::from(out.miss);
        events.written_back += u32::from(out.write_back);
        events.filled += u32::from(out.fill);
    }
}

/// A cache in front of a memory that is always ready and answers after `latency` cycles, and ready itself.
fn ready(cfg: Config, latency: u64) -> Bench<Cache> {
    let mut bench = Bench::<Cache>::new(cfg, Behind::new(WORDS, Pattern::always(), vec![latency]));
    for _ in 0..cfg.sets {
        assert!(!bench.sim.moore().client.ready && !bench.sim.moore().idle);
        bench.cycle(Stream::idle(), false);
    }
    assert!(bench.sim.moore().client.ready && bench.sim.moore().idle);
    bench
}

#[test]
fn hits_are_answered_two_cycles_later_one_a_cycle() {
    let mut bench = ready(config(4, 2, 4, true), 9);
    bench.latency(16);
    assert_eq!(bench.latency(17), 2);
    bench.answers.clear();
    let first = bench.sim.cycle();
    // A word that was written in the cycle before is read, too.
    let requests =
        [read(16), write(18, 5), read(18), write(16, 6), write(16, 7), read(16), read(19)];
    for (at, request) in (first..).zip(requests) {
        assert_eq!(bench.ask(request), at);
    }
    bench.rest();
    let expected = [(0, at_first(16)), (2, word(5)), (5, word(7)), (6, at_first(19))]
        .map(|(k, word)| (first + k + 2, word));
    assert_eq!(bench.answers, expected);
}

#[test]
fn a_miss_takes_the_line_the_memory_and_three_cycles() {
    // Words of a line, the memory's latency, cycles of a miss, and of one that a dirty line makes room for.
    for (line, latency, clean, dirty) in
        [(1, 1, 5, 6), (1, 6, 10, 11), (4, 1, 8, 12), (4, 6, 13, 17)]
    {
        let mut bench = ready(config(1, 1, line, true), latency);
        assert_eq!(bench.latency(0), clean, "line {line}, latency {latency}");
        assert_eq!(bench.latency(32), clean, "line {line}, latency {latency}");
        bench.ask(write(32, 1));
        assert_eq!(bench.latency(0), dirty, "line {line}, latency {latency}");
        assert_eq!(bench.memory.words[32], word(1));
        assert_eq!(bench.events.written_back, line);
        assert_eq!(bench.events.filled, 3 * line);
    }
}

#[test]
fn what_comes_behind_a_miss_waits() {
    let mut bench = ready(config(1, 1, 4, true), 6);
    let first = bench.ask(read(0));
    // This one comes in the cycle in which the miss is seen. It goes on as the first one is looked up again, and the next one
    // is taken in the cycle after that, in which the first one is answered.
    assert_eq!(bench.ask(read(1)), first + 1);
    assert_eq!(bench.ask(read(2)), first + 13);
    bench.rest();
    let times: Vec<u64> = bench.answers.iter().map(|(at, _)| at - first).collect();
    assert_eq!(times, [13, 14, 15]);
}

#[test]
fn of_a_set_the_line_that_was_used_least_recently_makes_room() {
    let mut bench = ready(config(1, 4, 1, true), 2);
    // After the four have come, 10 is used again, so that 11 goes, then 12: 10 and 13 stay.
    for address in [10, 11, 12, 13, 10, 20, 21] {
        bench.latency(address);
    }
    assert_eq!(bench.events.misses, 6);
    let there = |bench: &mut Bench<Cache>, address| bench.latency(address) == 2;
    assert!(there(&mut bench, 10) && there(&mut bench, 13) && there(&mut bench, 21));
    assert!(!there(&mut bench, 11));
    assert_eq!(bench.events, Events { hits: 4, misses: 7, written_back: 0, filled: 7 });
}

#[test]
fn writes_go_through_one_a_cycle_and_fetch_nothing() {
    let mut bench = ready(config(2, 2, 4, false), 3);
    bench.latency(0);
    let first = bench.sim.cycle();
    for (k, address) in [0, 40, 1, 41].into_iter().enumerate() {
        assert_eq!(bench.ask(write(address, k as u64)), first + k as u64);
    }
    // The last one is taken by the memory in this cycle.
    assert_eq!(bench.memory.words[41], at_first(41));
    bench.cycle(Stream::idle(), false);
    for (k, address) in [0, 40, 1, 41].into_iter().enumerate() {
        assert_eq!(bench.memory.words[address], word(k as u64));
    }
    assert_eq!(bench.events, Events { hits: 2, misses: 3, written_back: 0, filled: 4 });
    assert_eq!(bench.latency(1), 2);
    assert_eq!(bench.answers.last().unwrap().1, word(2));
    assert_eq!(bench.flush(), 2);
}

#[test]
fn a_flush_takes_a_cycle_a_set_and_the_words_of_dirty_lines() {
    let mut bench = ready(config(4, 2, 4, true), 3);
    assert_eq!(bench.flush(), 2 + 4);
    // Two lines of the second set and one of the last; a fourth is clean.
    for address in [4, 20, 15] {
        bench.ask(write(address, 9));
    }
    bench.latency(8);
    assert_eq!(bench.flush(), 2 + 4 + 3 * (1 + 4));
    assert_eq!(bench.events.written_back, 3 * 4);
    assert!([4, 20, 15].into_iter().all(|address| bench.memory.words[address] == word(9)));
    // The lines are still there, and clean.
    assert_eq!(bench.flush(), 2 + 4);
    assert!([4, 20, 15, 8].into_iter().all(|address| bench.latency(address) == 2));
}

#[test]
fn a_reset_loses_what_was_not_written_back() {
    let mut bench = ready(config(4, 2, 4, true), 3);
    bench.ask(write(5, 1));
    bench.flush();
    bench.ask(write(5, 2));
    bench.rest();
    bench.sim.reset();
    assert!(!bench.sim.moore().client.ready);
    assert_eq!(bench.latency(5), 10);
    assert_eq!(bench.answers.last().unwrap().1, word(1));
}

fn refused(change: impl FnOnce(&mut Config)) -> String {
    let mut cfg = config(4, 2, 4, true);
    change(&mut cfg);
    refusal::<Cache>(&cfg)
}

#[test]
fn numbers_out_of_range_are_refused() {
    let cases: [(String, &str); 9] = [
        (refused(|c| c.port.words = 0), "words behind a cache is 0: expected at least 1"),
        (
            refused(|c| c.port.words = 62),
            "words behind a cache is 62: expected a multiple of its line's 4",
        ),
        (refused(|c| c.port.bits = 129), "bits of a cache's word is 129: expected 1 to 128"),
        (refused(|c| c.line = 32), "words of a cache's line is 32: expected 1 to 16"),
        (refused(|c| c.line = 3), "words of a cache's line is 3: expected a power of two"),
        (refused(|c| c.ways = 17), "ways of a cache is 17: expected 1 to 16"),
        (refused(|c| c.ways = 3), "ways of a cache is 3: expected a power of two"),
        (refused(|c| c.sets = 16), "sets of a cache is 16: expected 1 to 8"),
        (refused(|c| c.sets = 6), "sets of a cache is 6: expected a power of two"),
    ];
    for (said, expected) in cases {
        assert_eq!(said, format!("the number of {expected}"));
    }
}

fn any_config() -> impl Strategy<Value = Config> {
    (0u32..4, 0u32..4, 0u32..5, any::<bool>())
        .prop_map(|(sets, ways, line, write_back)| {
            config(1 << sets, 1 << ways, 1 << line, write_back)
        })
        .prop_filter("larger than the memory", |c| c.sets * c.ways * c.line <= WORDS)
}

proptest! {
    /// Whatever is asked, and whenever the memory takes and answers: each read gives what was written last, in order and
    /// once; after a flush all is in memory; and the cache hits, misses, fetches and writes back as its lines say.
    #[test]
    fn behaves_as_a_plain_array(
        cfg in any_config(),
        requests in requests(0..WORDS, 150),
        starts in pattern(),
        ready in pattern(),
        latencies in proptest::collection::vec(1u64..9, 1..6),
        flushes in proptest::collection::vec(0u64..1500, 0..5),
    ) {
        let mut bench = Bench::<Cache>::new(cfg, Behind::new(WORDS, ready, latencies));
        let mut reference = Reference::new(cfg);
        bench.play(&requests, starts, &flushes, |told| match told {
            Some(request) => reference.request(request),
            None => reference.flush(),
        })?;
        prop_assert_eq!(bench.events, reference.events);
    }
}
