use super::*;
use crate::test_util::{
    Behind, Bench, Counted, Pattern, at_first, pattern, refusal, requests, word, write,
};
use proptest::prelude::*;
use std::collections::{BTreeSet, VecDeque};

/// Words behind the combiners of these tests.
const WORDS: u32 = 64;

/// A combiner of so many lines of `line` words of 70 bits.
pub(super) fn config(lines: u32, line: u32) -> Config {
    Config { port: outside::Config { words: WORDS, bits: 70 }, lines, line }
}

/// What the events came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    opened: u32,
    joined: u32,
    left: u32,
}

impl Counted for Combiner {
    type Events = Events;
    const ANSWERED: bool = false;
    fn count(out: &Out, events: &mut Events) {
        events.opened += u32::from(out.opens);
        events.joined += u32::from(out.joins);
        events.left += u32::from(out.leaves);
    }
}

/// A combiner in front of a memory that is always ready and answers after `latency` cycles.
fn ready(cfg: Config, latency: u64) -> Bench<Combiner> {
    Bench::new(cfg, Behind::new(WORDS, Pattern::always(), vec![latency]))
}

/// Which words the memory was asked for.
fn addresses(bench: &Bench<Combiner>) -> Vec<u32> {
    bench.asked.iter().map(|(_, request)| request.address).collect()
}

#[test]
fn neighbours_go_in_one_a_cycle_and_leave_as_many_without_a_gap() {
    for (lines, line) in [(1, 1), (1, 4), (2, 1), (2, 4), (16, 2), (4, 16)] {
        let mut bench = ready(config(lines, line), 3);
        for k in 0..WORDS {
            assert_eq!(bench.ask(write(k, k.into())), u64::from(k), "{lines} lines of {line}");
        }
        bench.rest();
        let first = u64::from(line) + 1;
        let expected: Vec<(u64, Request)> =
            (0..WORDS).map(|k| (first + u64::from(k), write(k, k.into()))).collect();
        assert_eq!(bench.asked, expected, "{lines} lines of {line}");
        let opened = WORDS / line;
        assert_eq!(bench.events, Events { opened, joined: WORDS - opened, left: opened });
    }
}

#[test]
fn words_of_several_lines_wait_for_each_other() {
    let mut bench = ready(config(4, 4), 3);
    // Four lines are written in turn, each from its last word on.
    for k in 0..16 {
        assert_eq!(bench.ask(write(4 * (k % 4) + 3 - k / 4, 100)), u64::from(k));
    }
    bench.rest();
    // They are full from cycle 13 to 16 on, and each leaves as the one before has left.
    let expected: Vec<(u64, Request)> =
        (0..16).map(|k| (14 + u64::from(k), write(k, 100))).collect();
    let mut asked = bench.asked.clone();
    asked.sort_by_key(|(_, request)| request.address);
    let (when, what): (Vec<u64>, Vec<Request>) = bench.asked.iter().copied().unzip();
    assert_eq!(when, expected.iter().map(|(at, _)| *at).collect::<Vec<_>>());
    assert_eq!(
        asked.iter().map(|(_, r)| *r).collect::<Vec<_>>(),
        expected.iter().map(|(_, r)| *r).collect::<Vec<_>>()
    );
    assert!(what.chunks(4).all(|line| line.windows(2).all(|w| w[0].address + 1 == w[1].address)));
}

#[test]
fn lines_of_one_word_make_room_for_one_a_cycle() {
    for lines in [1, 2, 4] {
        let mut bench = ready(config(lines, 4), 3);
        for k in 0..16 {
            assert_eq!(bench.ask(write(4 * k, 7)), u64::from(k));
        }
        bench.flush();
        // Each begins to leave as the one that is opened `lines` later comes; the last ones on the flush, in any order.
        let left = 16 - lines as usize;
        let expected: Vec<(u64, Request)> =
            (0..left as u32).map(|k| (u64::from(k + lines + 1), write(4 * k, 7))).collect();
        assert_eq!(bench.asked[..left], expected);
        assert_eq!(bench.asked.len(), 16);
    }
}

#[test]
fn the_line_that_was_written_least_recently_makes_room() {
    let mut bench = ready(config(4, 4), 3);
    for address in [0, 4, 8, 12, 1, 16] {
        bench.ask(write(address, 1));
    }
    bench.rest();
    assert_eq!(addresses(&bench), [4]);
    bench.ask(write(20, 1));
    bench.rest();
    assert_eq!(addresses(&bench), [4, 8]);
    // The words of a line leave from the lowest on.
    for address in [17, 12, 23, 24] {
        bench.ask(write(address, 1));
    }
    bench.rest();
    assert_eq!(addresses(&bench), [4, 8, 0, 1]);
}

#[test]
fn a_word_is_not_written_over_before_it_has_left() {
    let mut bench = ready(config(1, 4), 3);
    for address in [0, 1, 2, 3] {
        bench.ask(write(address, 1));
    }
    assert!(!bench.sim.moore().idle, "a line is full");
    // In cycle 4 it begins to leave. Another line's last word has to wait for cycle 7, in which word 3 is read.
    assert_eq!(bench.ask(write(7, 2)), 4);
    assert_eq!(bench.ask(write(4, 2)), 8);
    bench.flush();
    assert_eq!(addresses(&bench), [0, 1, 2, 3, 4, 7]);
    assert_eq!([0, 3, 4, 7].map(|at: usize| bench.memory.words[at]), [1, 1, 2, 2].map(word));
}

#[test]
fn a_read_passes_unless_its_word_is_there() {
    for latency in [1, 5] {
        let mut bench = ready(config(4, 4), latency);
        for address in [9, 10, 4, 5, 6] {
            bench.ask(write(address, 1));
        }
        // Nothing of that line; another word of one that is open; a word that was written.
        assert_eq!(bench.latency(0), latency);
        assert_eq!(bench.latency(8), latency);
        assert_eq!(bench.latency(5), 3 + 1 + latency);
        assert_eq!(bench.latency(5), latency);
        let answers: Vec<Word> = bench.answers.iter().map(|(_, word)| *word).collect();
        assert_eq!(answers, [at_first(0), at_first(8), word(1), word(1)]);
        assert_eq!(addresses(&bench), [0, 8, 4, 5, 6, 5, 5]);
    }
}

#[test]
fn a_flush_takes_two_cycles_and_the_words_that_were_written() {
    let mut bench = ready(config(4, 4), 3);
    assert_eq!(bench.flush(), 2);
    for address in [9, 10, 4, 30, 9] {
        bench.ask(write(address, 1));
    }
    assert!(bench.sim.moore().idle);
    assert_eq!(bench.flush(), 2 + 4);
    assert!([9, 10, 4, 30].into_iter().all(|at: usize| bench.memory.words[at] == word(1)));
    assert_eq!(bench.flush(), 2);
}

#[test]
fn a_reset_loses_what_was_not_sent() {
    let mut bench = ready(config(4, 4), 3);
    bench.ask(write(5, 1));
    bench.sim.reset();
    assert_eq!(bench.latency(5), 3);
    assert_eq!(bench.answers[0].1, at_first(5));
}

fn refused(change: impl FnOnce(&mut Config)) -> String {
    let mut cfg = config(4, 4);
    change(&mut cfg);
    refusal::<Combiner>(&cfg)
}

#[test]
fn numbers_out_of_range_are_refused() {
    let cases: [(String, &str); 7] = [
        (refused(|c| c.port.words = 0), "words behind a combiner is 0: expected at least 1"),
        (
            refused(|c| c.port.words = 62),
            "words behind a combiner is 62: expected a multiple of its line's 4",
        ),
        (refused(|c| c.port.bits = 129), "bits of a combiner's word is 129: expected 1 to 128"),
        (refused(|c| c.line = 32), "words of a combiner's line is 32: expected 1 to 16"),
        (refused(|c| c.line = 3), "words of a combiner's line is 3: expected a power of two"),
        (refused(|c| c.lines = 17), "lines of a combiner is 17: expected 1 to 16"),
        (refused(|c| c.lines = 3), "lines of a combiner is 3: expected a power of two"),
    ];
    for (said, expected) in cases {
        assert_eq!(said, format!("the number of {expected}"));
    }
}

/// The bursts that are made of writes of words, each once, sorted: a list of lines with the one that was written last in front.
fn bursts(cfg: Config, written: &[u32]) -> Vec<Vec<u32>> {
    let mut lines: VecDeque<BTreeSet<u32>> = VecDeque::new();
    let mut bursts = vec![];
    for address in written {
        let same = |line: &BTreeSet<u32>| line.iter().all(|at| at / cfg.line == address / cfg.line);
        let mut line = match lines.iter().position(same) {
            Some(at) => lines.remove(at).unwrap(),
            None => BTreeSet::new(),
        };
        if line.is_empty() && lines.len() == cfg.lines as usize {
            bursts.extend(lines.pop_back());
        }
        line.insert(*address);
        if line.len() == cfg.line as usize {
            bursts.push(line);
        } else {
            lines.push_front(line);
        }
    }
    bursts.extend(lines);
    let mut bursts: Vec<Vec<u32>> = bursts.into_iter().map(|b| b.into_iter().collect()).collect();
    bursts.sort();
    bursts
}

fn any_config() -> impl Strategy<Value = Config> {
    (0u32..5, 0u32..5)
        .prop_map(|(lines, line)| config(1 << lines, 1 << line))
        .prop_filter("larger than the memory", |c| c.lines * c.line <= WORDS)
}

proptest! {
    /// Whatever is asked, and whenever the memory takes and answers: each read gives what was written last, in order and
    /// once; after a flush all is in memory; and every line that is opened leaves once.
    #[test]
    fn behaves_as_a_plain_array(
        cfg in any_config(),
        requests in requests(0..WORDS, 150),
        starts in pattern(),
        ready in pattern(),
        latencies in proptest::collection::vec(1u64..9, 1..6),
        flushes in proptest::collection::vec(0u64..300, 0..5),
    ) {
        let mut bench = Bench::<Combiner>::new(cfg, Behind::new(WORDS, ready, latencies));
        bench.play(&requests, starts, &flushes, |_| ())?;
        let Events { opened, joined, left } = bench.events;
        let writes = requests.iter().filter(|request| request.write).count();
        prop_assert_eq!((opened + joined) as usize, writes);
        prop_assert_eq!(left, opened);
    }

    /// Whatever the memory's pauses, the same bursts are made as by a list of lines, and nothing comes between the words of one.
    #[test]
    fn makes_the_bursts_of_a_plain_list(
        cfg in any_config(),
        order in (0..=WORDS).prop_flat_map(|far| proptest::collection::vec(0..=far, WORDS as usize)),
        count in 0..=WORDS as usize,
        starts in pattern(),
        ready in pattern(),
    ) {
        // In order, but for so far as each is put behind.
        let mut words: Vec<u32> = (0..WORDS).collect();
        words.sort_by_key(|at| at + order[*at as usize]);
        words.truncate(count);
        let requests: Vec<Request> = words.iter().map(|at| write(*at, 1)).collect();
        let mut bench = Bench::<Combiner>::new(cfg, Behind::new(WORDS, ready.clone(), vec![1]));
        bench.play(&requests, starts, &[], |_| ())?;
        let mut made: Vec<Vec<u32>> = vec![];
        let mut before = None;
        for (cycle, Request { address, .. }) in &bench.asked {
            let goes_on = |(_, at): &(u64, u32)| at / cfg.line == address / cfg.line && at < address;
            match (before.filter(goes_on), made.last_mut()) {
                (Some((then, _)), Some(burst)) => {
                    prop_assert!(!(then + 1..*cycle).any(|cycle| ready.at(cycle)), "a gap");
                    burst.push(*address);
                }
                _ => made.push(vec![*address]),
            }
            before = Some((*cycle, *address));
        }
        prop_assert_eq!(bench.events.left as usize, made.len());
        made.sort();
        prop_assert_eq!(made, bursts(cfg, &words));
    }
}
