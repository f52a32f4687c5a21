use super::*;
use crate::test_util::{Clocked, Pattern, pattern, queue};
use proptest::prelude::*;

/// What is seen in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Nothing,
    Begins,
    Item,
    End,
    Done,
}
use Seen::{Begins, Done, End, Item, Nothing};

/// The passes beside a queue and a selector, each a few numbers.
struct Bench {
    passes: Clocked<Passes>,
    /// Cycles from a pass's end being taken to its being through.
    through: u64,
}

impl Bench {
    fn new(through: u64) -> Bench {
        Bench { passes: Clocked::new(queue(2, 5, 3)), through }
    }

    /// A frame: of each pass how many fragments are in the queue as it begins. Gives each cycle from `start` on,
    /// with the parity, and whether it belongs to a first pass.
    fn frame(&mut self, counts: &[u32], taken: &Pattern) -> Vec<(Seen, bool, bool)> {
        let (mut seen, mut due, mut pass) = (vec![], None, 0);
        for cycle in 0.. {
            assert!(cycle < 10_000, "the frame does not end: {seen:?}");
            let Moore { items, end, parity, first } = self.passes.moore();
            assert!(!(items && end));
            let offered = items || end;
            let i = In {
                start: cycle == 0,
                count: counts.get(pass).copied().unwrap_or(0),
                taken: offered && taken.at(cycle),
                ended: due == Some(cycle),
            };
            if end && i.taken {
                due = Some(cycle + self.through);
            }
            let Out { begins, done } = self.passes.clock(i).unwrap();
            // What is pushed back in the pass is in the queue from its first cycle on.
            pass += usize::from(begins);
            let now = match (begins, done, i.taken && items, i.taken && end) {
                (true, false, false, false) => Begins,
                (false, true, false, false) => Done,
                (false, false, true, false) => Item,
                (false, false, false, true) => End,
                _ => Nothing,
            };
            seen.push((now, parity, first));
            if done {
                return seen;
            }
        }
        unreachable!("the loop ends by return")
    }
}

fn kinds(seen: &[(Seen, bool, bool)]) -> Vec<Seen> {
    seen.iter().map(|(seen, ..)| *seen).collect()
}

#[test]
fn without_a_start_nothing_is_sent() {
    let mut passes = Clocked::<Passes>::new(queue(2, 5, 3));
    for _ in 0..5 {
        let out = passes.clock(In { start: false, count: 3, taken: false, ended: false }).unwrap();
        assert!(!out.begins && !out.done);
        let Moore { items, end, .. } = passes.moore();
        assert!(!items && !end);
    }
}

#[test]
fn an_empty_queue_takes_no_pass() {
    assert_eq!(kinds(&Bench::new(2).frame(&[], &Pattern::always())), [Nothing, Done]);
}

#[test]
fn each_pass_sends_what_was_there_as_it_began_then_its_end() {
    let seen = Bench::new(2).frame(&[3, 1], &Pattern::always());
    let expected = [
        Nothing, Begins, Item, Item, Item, End, Nothing, Nothing, //
        Begins, Item, End, Nothing, Nothing, Done,
    ];
    assert_eq!(kinds(&seen), expected);
    // The parity changes as a pass begins.
    let of = |pass: std::ops::Range<usize>| {
        seen[pass].iter().map(|(_, parity, first)| (*parity, *first))
    };
    assert!(of(2..8).all(|seen| seen == (true, true)));
    assert!(of(9..13).all(|seen| seen == (false, false)));
}

#[test]
fn parity_goes_on_from_frame_to_frame_and_each_has_a_first_pass() {
    let mut bench = Bench::new(1);
    let first_items = |seen: Vec<(Seen, bool, bool)>| {
        let items = seen.into_iter().filter(|(seen, ..)| *seen == Item);
        items.map(|(_, parity, first)| (parity, first)).collect::<Vec<_>>()
    };
    let always = Pattern::always();
    assert_eq!(
        first_items(bench.frame(&[1, 1, 1], &always)),
        [(true, true), (false, false), (true, false)]
    );
    assert_eq!(first_items(bench.frame(&[1], &always)), [(false, true)]);
    assert_eq!(first_items(bench.frame(&[1], &always)), [(true, true)]);
}

proptest! {
    /// As many as were there, whatever the receiver does, and not a cycle more than it makes them wait.
    #[test]
    fn a_receiver_that_stalls_gets_all(
        counts in proptest::collection::vec(1..=7_u32, 0..5),
        taken in pattern(),
        through in 1..6_u64,
    ) {
        let seen = kinds(&Bench::new(through).frame(&counts, &taken));
        let mut expected = vec![Nothing];
        for count in counts {
            expected.push(Begins);
            let mut left = count + 1;
            while left > 0 {
                let takes = taken.at(expected.len() as u64);
                left -= u32::from(takes);
                expected.push(match (takes, left) {
                    (false, _) => Nothing,
                    (true, 0) => End,
                    (true, _) => Item,
                });
            }
            expected.extend(vec![Nothing; through as usize]);
        }
        expected.push(Done);
        prop_assert_eq!(seen, expected);
    }
}
