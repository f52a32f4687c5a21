use super::*;
use crate::cache::test_util::{Events, Reference};
use crate::test_util::{Behind, Pattern, Source, at_first, pattern, word};
use pellucid_machine::outside;
use pellucid_sim::stream::valid_ignores_ready;
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;

/// Entries of the small tables of these tests.
const WORDS: u32 = 64;

/// A cache of that shape, of words of 70 bits.
pub(super) fn config(sets: u32, ways: u32, line: u32, in_flight: u32, misses: u32) -> Config {
    let port = outside::Config { words: WORDS, bits: 70 };
    Config { port, sets, ways, line, in_flight, misses, flushes: false }
}

/// A cache between a user and a memory.
struct Bench {
    sim: Sim<TableCache>,
    memory: Behind,
    from_user: StreamMonitor<u32>,
    to_user: StreamMonitor<Entry>,
    to_memory: StreamMonitor<Request>,
    events: Events,
}

impl Bench {
    fn new(cfg: Config, memory: Behind) -> Bench {
        Bench {
            sim: Sim::new(cfg),
            memory,
            from_user: StreamMonitor::new("ask", "user", "cache"),
            to_user: StreamMonitor::new("entry", "cache", "user"),
            to_memory: StreamMonitor::new("request", "cache", "memory"),
            events: Events::default(),
        }
    }
    /// In front of a memory that is always ready and answers after `latency` cycles, and ready itself.
    fn ready(cfg: Config, latency: u64) -> Bench {
        let mut bench =
            Bench::new(cfg, Behind::new(cfg.port.words, Pattern::always(), vec![latency]));
        for _ in 0..cfg.sets {
            assert!(!bench.sim.moore().ready && !bench.sim.moore().idle);
            bench.cycle(In::default());
        }
        assert!(bench.sim.moore().ready && bench.sim.moore().idle);
        bench
    }
    /// A cycle; the entry that was taken.
    fn cycle(&mut self, i: In) -> Option<Entry> {
        let cycle = self.sim.cycle();
        let Moore { ready, entry, .. } = self.sim.moore();
        self.from_user.observe(i.ask.with(ready)).unwrap();
        self.to_user.observe(entry.with(i.taken)).unwrap();
        let i = In { memory: self.memory.shows(cycle), ..i };
        let out = self.sim.clock(i).unwrap().out;
        self.to_memory.observe(out.request.with(i.memory.ready)).unwrap();
        self.memory.edge(cycle, out.request);
        self.events.hits += u32::from(out.hit);
        self.events.misses += u32::from(out.miss);
        self.events.written_back += u32::from(out.write_back);
        self.events.filled += u32::from(i.memory.response.valid);
        (entry.valid && i.taken).then_some(entry.payload)
    }
    /// A user that asks and takes whenever it can, and writes `number` everywhere, if any: in which cycle, from the first ask
    /// on, each entry was taken, and the entries.
    fn play(&mut self, asks: &[u32], number: Option<u64>) -> Vec<(u64, Entry)> {
        let first = self.sim.cycle();
        let mut source = Source::new(asks.iter().copied(), Pattern::always());
        let mut entries = vec![];
        let write = number.map_or(Stream::idle(), |number| Stream::offer(word(number)));
        while entries.len() < asks.len() {
            let cycle = self.sim.cycle();
            assert!(cycle < first + 1_000_000, "not all is done");
            let ask = source.offer(cycle);
            source.edge(self.sim.moore().ready);
            let entry = self.cycle(In { ask, taken: true, write, ..In::default() });
            entries.extend(entry.map(|entry| (cycle - first, entry)));
        }
        entries
    }
    /// Writes all that is asked for, which takes so many words of the memory, one a cycle but for pauses before the first word comes
    /// and where there is nothing more to fetch.
    fn keeps_the_memory_at_work(&mut self, latency: u64, asks: &[u32], words: u64) {
        self.rest();
        self.to_memory.transfers = 0;
        let first = self.sim.cycle();
        self.play(asks, Some(3));
        self.rest();
        let found = self.sim.cycle() - first;
        assert_eq!(self.to_memory.transfers, words);
        let Config { line, misses, .. } = *self.sim.config();
        let pauses = 8 + latency + u64::from(misses);
        assert!(
            (words..words + pauses).contains(&found),
            "line {line}, latency {latency}: {found} for {words}"
        );
    }
    /// Cycles until it is idle.
    fn rest(&mut self) {
        while !self.sim.moore().idle {
            assert!(self.cycle(In::default()).is_none());
        }
    }
    /// Cycles from the ask for an entry until it is shown, if nothing else is under way.
    fn latency(&mut self, address: u32) -> u64 {
        let (cycles, entry) = self.play(&[address], None)[0];
        assert_eq!(entry.address, address);
        cycles
    }
}

fn entries(of: impl IntoIterator<Item = (u32, Word)>) -> Vec<Entry> {
    of.into_iter().map(|(address, word)| Entry { address, word }).collect()
}

#[test]
fn an_entry_that_is_asked_for_again_shows_what_was_written() {
    let mut bench = Bench::ready(config(4, 2, 4, 8, 2), 5);
    bench.latency(16);
    // One entry, then two in turns, an entry a cycle.
    let asks = [16, 16, 16, 17, 16, 17, 16, 17];
    let mut source = Source::new(asks, Pattern::always());
    let mut shown = vec![];
    let first = bench.sim.cycle();
    for number in 0..12 {
        let ask = source.offer(number);
        source.edge(bench.sim.moore().ready);
        let write = Stream::offer(word(number));
        shown.extend(bench.cycle(In { ask, taken: true, write, ..In::default() }));
    }
    assert_eq!(bench.sim.cycle() - first, 4 + 8);
    let (a, b) = (at_first(16), at_first(17));
    let words = [a, word(4), word(5), b, word(6), word(7), word(8), word(9)];
    assert_eq!(shown, entries(asks.into_iter().zip(words)));
}

#[test]
fn an_entry_stays_until_it_is_taken_and_is_written_only_then() {
    let mut bench = Bench::ready(config(2, 1, 2, 4, 1), 3);
    bench.latency(6);
    bench.cycle(In { ask: Stream::offer(6), ..In::default() });
    for _ in 0..3 {
        bench.cycle(In::default());
    }
    for number in 0..5 {
        let entry = Entry { address: 6, word: at_first(6) };
        assert_eq!(bench.sim.moore().entry, Stream::offer(entry));
        bench.cycle(In { write: Stream::offer(word(number)), ..In::default() });
    }
    bench.cycle(In { taken: true, ..In::default() });
    assert!(!bench.sim.moore().entry.valid && bench.sim.moore().idle);
    assert_eq!(bench.play(&[6], None)[0].1, Entry { address: 6, word: at_first(6) });
}

#[test]
fn four_more_asks_than_wait_are_on_their_way() {
    for in_flight in [1, 4, 7] {
        let mut bench = Bench::ready(config(2, 1, 2, in_flight, 1), 3);
        let mut asked = 0;
        for _ in 0..50 {
            asked += u32::from(bench.sim.moore().ready);
            bench.cycle(In { ask: Stream::offer(6), ..In::default() });
        }
        assert_eq!(asked, in_flight + 4);
    }
}

#[test]
fn of_a_set_the_line_that_was_asked_for_least_recently_makes_room() {
    let mut bench = Bench::ready(config(1, 4, 1, 9, 2), 2);
    // After the four have come, 10 is asked for again, so that 11 goes, then 12: 10 and 13 stay.
    bench.play(&[10, 11, 12, 13, 10, 20, 21], Some(5));
    assert_eq!(bench.events, Events { hits: 1, misses: 6, written_back: 2, filled: 6 });
    assert_eq!(
        [10, 11, 12, 13].map(|k| bench.memory.words[k] == word(5)),
        [false, true, true, false]
    );
    bench.play(&[10, 13, 21], None);
    assert_eq!(bench.events.misses, 6);
    bench.play(&[11], None);
    assert_eq!(bench.events.misses, 7);
}

#[test]
fn one_ask_in_flight_is_enough() {
    for cfg in [config(1, 1, 1, 1, 1), config(1, 1, 8, 1, 1), config(2, 2, 4, 1, 1)] {
        let taken = Pattern::of(vec![true, false, false, true]);
        let mut bench = Bench::new(cfg, Behind::new(WORDS, taken, vec![3, 1, 9]));
        let asks: Vec<u32> = (0..WORDS).chain((0..WORDS).map(|k| k * 29 % WORDS)).collect();
        for (address, (_, entry)) in asks.iter().zip(bench.play(&asks, Some(7))) {
            assert_eq!(entry.address, *address);
        }
        let kept = bench.play(&asks, None).into_iter().map(|(_, entry)| entry).collect::<Vec<_>>();
        assert_eq!(kept, entries(asks.iter().map(|address| (*address, word(7)))));
    }
}

#[test]
fn entries_are_cleared_before_the_first_is_asked_for() {
    let mut bench = Bench::ready(config(4, 1, 4, 8, 2), 7);
    // A word a cycle, while the cache still forgets, too.
    bench.sim.reset();
    for address in 0..WORDS {
        assert!(bench.sim.moore().clear_ready);
        let clear = Stream::offer(Entry { address, word: word(9) });
        bench.cycle(In { clear, ..In::default() });
    }
    assert!(bench.memory.words.iter().all(|kept| *kept == word(9)));
    assert!(bench.sim.moore().idle);
    // What is asked for while the last one is cleared is cleared.
    let clear = Stream::offer(Entry { address: 30, word: word(8) });
    bench.cycle(In { ask: Stream::offer(30), clear, taken: true, ..In::default() });
    for _ in 1..4 + 7 {
        assert!(!bench.sim.moore().clear_ready && !bench.sim.moore().entry.valid);
        bench.cycle(In { clear, ..In::default() });
    }
    assert_eq!(bench.sim.moore().entry, Stream::offer(Entry { address: 30, word: word(8) }));
}

#[test]
fn what_is_cleared_later_is_forgotten_first() {
    let mut bench = Bench::ready(config(4, 1, 4, 8, 2), 7);
    bench.play(&[0, 17, 33], Some(1));
    bench.rest();
    let clear = |address| Stream::offer(Entry { address, word: word(9) });
    assert!(!bench.sim.moore().clear_ready);
    bench.cycle(In { clear: clear(0), ..In::default() });
    for address in 0..WORDS {
        // Four sets are forgotten meanwhile.
        assert!(bench.sim.moore().clear_ready && bench.sim.moore().ready == (address >= 4));
        bench.cycle(In { clear: clear(address), ..In::default() });
    }
    bench.rest();
    let shown = bench.play(&[0, 17, 33], None);
    let shown: Vec<Entry> = shown.into_iter().map(|(_, entry)| entry).collect();
    assert_eq!(shown, entries([0, 17, 33].map(|address| (address, word(9)))));
}

#[test]
fn a_reset_loses_what_is_in_the_cache() {
    let mut bench = Bench::ready(config(2, 1, 2, 4, 1), 3);
    bench.play(&[0, 1, 2, 3], Some(1));
    bench.play(&[4], Some(2));
    bench.sim.reset();
    let shown = bench.play(&[0, 1, 2, 4], None);
    let words = [word(1), word(1), at_first(2), at_first(4)];
    let shown: Vec<Entry> = shown.into_iter().map(|(_, entry)| entry).collect();
    assert_eq!(shown, entries([0, 1, 2, 4].into_iter().zip(words)));
}

#[test]
fn numbers_out_of_range_are_refused() {
    let refused = |cfg: Config| {
        let made = std::panic::catch_unwind(|| TableCache::reset(&cfg));
        *made.expect_err("it is made").downcast::<String>().unwrap()
    };
    for (cfg, expected) in [
        (config(4, 3, 4, 1, 1), "ways of a cache is 3: expected a power of two"),
        (config(4, 2, 4, 0, 1), "asks in flight of a table cache is 0: expected at least 1"),
        (config(4, 2, 4, 1, 0), "misses in flight of a table cache is 0: expected 1 to 268435455"),
    ] {
        assert_eq!(refused(cfg), format!("the number of {expected}"));
    }
}

/// The latencies of the memories.
const LATENCIES: [u64; 4] = [1, 8, 64, 256];

/// Entries of the tables.
const TABLE: u32 = 1 << 14;

/// A cache that has just what it needs in flight for `latency`, and lines enough.
fn covering(line: u32, latency: u64) -> Config {
    let port = outside::Config { words: TABLE, bits: 70 };
    let in_flight = latency as u32 + 2 * line;
    let misses = (latency as u32 + 2).div_ceil(line) + 1;
    let sets = misses.next_power_of_two();
    Config { port, sets, ways: 2, line, in_flight, misses, flushes: false }
}

fn cycles(entries: &[(u64, Entry)]) -> Vec<u64> {
    entries.iter().map(|(cycle, _)| *cycle).collect()
}

/// Lines in an order in which none comes twice, and a word of each.
fn scattered(line: u32) -> Vec<u32> {
    let lines = TABLE / line;
    (0..2000).map(|k| (k * 0x9e35 % lines) * line + k * 7 % line).collect()
}

#[test]
fn a_hit_takes_four_cycles_and_a_miss_the_memory_too() {
    for latency in LATENCIES {
        for line in [1, 4] {
            let mut bench = Bench::ready(covering(line, latency), latency);
            for word in 0..line {
                let miss = 3 * line * word + word;
                assert_eq!(bench.latency(miss), 4 + latency);
            }
            assert_eq!(bench.latency(0), 4);
        }
    }
}

#[test]
fn entries_in_a_row_come_one_a_cycle() {
    for latency in LATENCIES {
        for line in [1, 2, 8] {
            let mut bench = Bench::ready(covering(line, latency), latency);
            let asks: Vec<u32> = (0..2000).collect();
            let found = cycles(&bench.play(&asks, None));
            let expected: Vec<u64> = (0..2000).map(|k| 4 + latency + k).collect();
            assert_eq!(found, expected, "line {line}, latency {latency}");
        }
    }
}

#[test]
fn entries_in_a_row_that_are_written_take_two_cycles() {
    for latency in LATENCIES {
        for line in [1, 2, 8] {
            let cfg = covering(line, latency);
            let mut bench = Bench::ready(cfg, latency);
            // All lines of the cache become dirty; each first word comes beside no write.
            let asks: Vec<u32> = (0..TABLE / 2).collect();
            let (before, asks) = asks.split_at((cfg.sets * cfg.ways * line) as usize);
            let found = cycles(&bench.play(before, Some(3)));
            let at = |k: &u32| 4 + latency + u64::from(k + k / line);
            let expected: Vec<u64> = before.iter().map(at).collect();
            assert_eq!(found, expected, "line {line}, latency {latency}");
            bench.keeps_the_memory_at_work(latency, asks, 2 * asks.len() as u64);
        }
    }
}

#[test]
fn scattered_entries_take_a_line_each() {
    for latency in LATENCIES {
        for line in [1, 2, 8] {
            let mut bench = Bench::ready(covering(line, latency), latency);
            let asks = scattered(line);
            let found = cycles(&bench.play(&asks, None));
            let at = |k: u32| 4 + latency + u64::from(k * line);
            let expected: Vec<u64> = (0..).take(asks.len()).map(at).collect();
            assert_eq!(found, expected, "line {line}, latency {latency}");
        }
    }
}

#[test]
fn scattered_entries_that_are_written_keep_the_memory_at_work() {
    for latency in LATENCIES {
        for line in [1, 2, 8] {
            let cfg = covering(line, latency);
            let mut bench = Bench::ready(cfg, latency);
            let asks = scattered(line);
            // All lines of the cache become dirty.
            let (before, asks) = asks.split_at((cfg.sets * cfg.ways) as usize);
            let found = cycles(&bench.play(before, Some(3)));
            let at = |k: u32| 4 + latency + u64::from(k * line.max(2));
            let expected: Vec<u64> = (0..).take(before.len()).map(at).collect();
            assert_eq!(found, expected, "line {line}, latency {latency}");
            bench.keeps_the_memory_at_work(latency, asks, 2 * asks.len() as u64 * u64::from(line));
        }
    }
}

#[test]
fn few_random_entries_wait_for_others_of_their_set() {
    for latency in [8, 64] {
        let port = outside::Config { words: 1 << 20, bits: 70 };
        let cfg = Config { port, sets: 64, ways: 4, ..covering(4, latency) };
        // xorshift
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 44) as u32
        };
        for (number, each) in [(None, 4), (Some(3), 8)] {
            let mut bench = Bench::ready(cfg, latency);
            // All lines of the cache are in use.
            let (before, asks): (Vec<u32>, Vec<u32>) =
                ((0..2000).map(|_| next()).collect(), (0..4000).map(|_| next()).collect());
            bench.play(&before, number);
            let found = bench.play(&asks, number)[3999].0;
            assert!(found < each * 4000 * 101 / 100, "latency {latency}: {found}");
        }
    }
}

fn any_config() -> impl Strategy<Value = Config> {
    (0u32..4, 0u32..4, 0u32..5, 1u32..12, 1u32..5)
        .prop_map(|(sets, ways, line, in_flight, misses)| {
            config(1 << sets, 1 << ways, 1 << line, in_flight, misses)
        })
        .prop_filter("larger than the memory", |c| c.sets * c.ways * c.line <= WORDS)
}

/// Asks, and whether the entry is written: any, some few, or one after the other.
fn any_asks() -> impl Strategy<Value = Vec<(u32, bool)>> {
    let run = prop_oneof![
        proptest::collection::vec(0..WORDS, 0..20),
        proptest::collection::vec((0..4u32).prop_map(|k| k * 16), 0..20),
        (0..WORDS, 1..20u32).prop_map(|(from, n)| (from..WORDS.min(from + n)).collect()),
        (0..WORDS, 1usize..8).prop_map(|(address, n)| vec![address; n]),
    ];
    proptest::collection::vec(run, 0..8).prop_flat_map(|runs| {
        let asks = runs.concat();
        let written = proptest::collection::vec(any::<bool>(), asks.len());
        written.prop_map(move |written| asks.iter().copied().zip(written).collect())
    })
}

#[test]
fn a_flush_takes_two_cycles_for_a_line_one_if_it_is_in_use_and_its_words_if_it_is_dirty() {
    for (sets, ways, line) in [(1, 1, 1), (4, 2, 4), (2, 1, 8), (1, 4, 2)] {
        let cfg = Config { flushes: true, ..config(sets, ways, line, 8, 2) };
        let mut bench = Bench::ready(cfg, 3);
        let flush = |bench: &mut Bench| {
            let first = bench.sim.cycle();
            bench.cycle(In { flush: true, ..In::default() });
            assert!(!bench.sim.moore().ready && !bench.sim.moore().idle);
            bench.rest();
            bench.sim.cycle() - first
        };
        // Before the first ask nothing can be dirty.
        assert_eq!(flush(&mut bench), 2);
        bench.play(&[0], Some(5));
        bench.rest();
        for dirty in [1, 0] {
            let lines = u64::from(2 * sets * ways + 1 + dirty * line);
            assert_eq!(flush(&mut bench), 2 + lines, "{cfg:?}, {dirty} dirty");
        }
        assert_eq!(bench.memory.words[0], word(5));
        // The line is there still.
        bench.play(&[0], None);
        assert_eq!(bench.events.misses, 1);
    }
}

proptest! {
    /// Whatever was asked for and written before: all is in memory, and in the cache as it was.
    #[test]
    fn what_is_flushed_is_in_memory(
        cfg in any_config(),
        rounds in proptest::collection::vec(any_asks(), 1..4),
        ready in pattern(),
        latencies in proptest::collection::vec(1u64..30, 1..6),
    ) {
        let cfg = Config { flushes: true, ..cfg };
        let mut bench = Bench::new(cfg, Behind::new(WORDS, ready, latencies));
        let mut array: Vec<Word> = (0..WORDS).map(at_first).collect();
        for (asks, number) in rounds.into_iter().zip(1..) {
            let asks: Vec<u32> = asks.into_iter().map(|(address, _)| address).collect();
            for (_, entry) in bench.play(&asks, Some(number)) {
                prop_assert_eq!(entry.word, array[entry.address as usize]);
                array[entry.address as usize] = word(number);
            }
            // While lines still come, too.
            bench.cycle(In { flush: true, ..In::default() });
            bench.rest();
            prop_assert_eq!(&bench.memory.words, &array);
        }
    }

    /// Whatever was asked for and written before, and however the memory takes and answers.
    #[test]
    fn a_table_that_is_cleared_again_holds_nothing_else(
        cfg in any_config(),
        asks in any_asks(),
        ready in pattern(),
        latencies in proptest::collection::vec(1u64..30, 1..6),
    ) {
        let mut bench = Bench::new(cfg, Behind::new(WORDS, ready, latencies));
        let asks: Vec<u32> = asks.into_iter().map(|(address, _)| address).collect();
        bench.play(&asks, Some(1));
        for address in 0..WORDS {
            let clear = Stream::offer(Entry { address, word: word(u64::from(address) + 2) });
            while !bench.sim.moore().clear_ready {
                bench.cycle(In { clear, ..In::default() });
            }
            bench.cycle(In { clear, ..In::default() });
        }
        let all: Vec<u32> = (0..WORDS).collect();
        let shown = bench.play(&all, None).into_iter().map(|(_, entry)| entry);
        let cleared = all.iter().map(|address| (*address, word(u64::from(*address) + 2)));
        prop_assert_eq!(shown.collect::<Vec<_>>(), entries(cleared));
    }

    /// Whatever is asked for and written, whenever the user asks and takes, and whenever the memory takes and answers: each
    /// entry comes once, in order, and shows what was written last; and the cache hits, misses, fetches and writes back as
    /// its lines say.
    #[test]
    fn behaves_as_a_plain_array(
        cfg in any_config(),
        cleared in proptest::collection::vec(0..WORDS, 0..10),
        asks in any_asks(),
        starts in pattern(),
        takes in pattern(),
        ready in pattern(),
        latencies in proptest::collection::vec(1u64..30, 1..6),
    ) {
        let mut bench = Bench::new(cfg, Behind::new(WORDS, ready, latencies));
        let mut reference = Reference::new(crate::cache::Config { write_back: true, ..cfg.cache() });
        let mut array: Vec<Word> = (0..WORDS).map(at_first).collect();
        let clears: Vec<Entry> =
            cleared.into_iter().zip(5000..).map(|(address, n)| Entry { address, word: word(n) }).collect();
        let mut clearing = Source::new(clears.iter().copied(), starts.clone());
        for Entry { address, word } in &clears {
            array[*address as usize] = *word;
        }
        // In the end all are looked at.
        let asks: Vec<(u32, bool)> = asks.into_iter().chain((0..WORDS).map(|k| (k, false))).collect();
        let mut source = Source::new(asks.iter().map(|(address, _)| *address), starts);
        let (mut sent, mut taken, mut left) = (0, 0, clears.len());
        for cycle in 0u64.. {
            prop_assert!(cycle < 100_000, "not all is done");
            let Moore { ready, clear_ready, entry, idle } = bench.sim.moore();
            if idle {
                prop_assert_eq!(taken, sent);
            }
            if taken == asks.len() && idle {
                break;
            }
            let clear = clearing.offer(cycle);
            let ask = if left == 0 { source.offer(cycle) } else { Stream::idle() };
            let takes = takes.at(cycle);
            let mut write = Stream::idle();
            if entry.valid && takes {
                let (address, writes) = asks[taken];
                prop_assert_eq!(entry.payload, Entry { address, word: array[address as usize] });
                if writes {
                    array[address as usize] = word(cycle);
                    write = Stream::offer(word(cycle));
                }
                let word = write.payload;
                reference.request(Request { write: writes, address, word });
                taken += 1;
            }
            let memory = bench.memory.shows(cycle);
            let i = In { ask, taken: takes, write, clear, flush: false, memory };
            let honest = valid_ignores_ready::<TableCache, Request>(
                bench.sim.config(),
                bench.sim.state(),
                || TableCache::memories(bench.sim.config()),
                |ready| In { memory: outside::In { ready, ..i.memory }, ..i },
                |out| out.request,
            );
            prop_assert!(honest, "a request waits for the memory");
            bench.cycle(i);
            if idle && !(clear.valid && clear_ready) {
                prop_assert!(!bench.to_memory.last().0, "it is idle while it asks for something");
            }
            sent += usize::from(ask.valid && ready);
            if left == 0 {
                source.edge(ready);
            }
            left -= usize::from(clear.valid && clear_ready);
            clearing.edge(clear_ready);
        }
        prop_assert_eq!(bench.events, reference.events);
    }
}
