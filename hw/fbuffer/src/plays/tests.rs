use super::*;
use crate::test_util::{compacting, plays};
use pellucid_sim::Sim;
use proptest::prelude::*;

/// A play as it was: its pass and window, the primitives that were submitted, and whether it was wasted.
#[derive(Debug, PartialEq)]
struct Seen {
    pass: u32,
    window: u32,
    primitives: Vec<u32>,
    wasted: bool,
}

/// Inputs while nothing happens.
const NOTHING: In = In {
    comes: false,
    end: false,
    over: false,
    beyond: false,
    next_window: 0,
    left: false,
    done: false,
};

/// All plays of a frame whose primitives have so many fragments; and whether it was as at reset in the end.
fn frame(cfg: Config, fragments: &[u32]) -> Vec<Seen> {
    let mut sim = Sim::<Plays>::new(cfg);
    let mut seen = vec![];
    loop {
        assert!(seen.len() < 1000, "the frame does not end");
        let (mut primitives, mut counted) = (vec![], 0);
        for (number, fragments) in (0..).zip(fragments) {
            let moore = sim.moore();
            assert!(moore.open && !moore.finished);
            assert_eq!(moore.replay, number == 0 && !seen.is_empty());
            if !moore.skips {
                primitives.push(number);
                counted += if moore.play.shades { *fragments } else { 0 };
            }
            sim.clock(In { comes: true, ..NOTHING }).unwrap();
        }
        sim.clock(In { comes: true, end: true, ..NOTHING }).unwrap();
        let Moore { play, pass, last, open, .. } = sim.moore();
        assert!(!open);
        assert_eq!(last, play.shades && pass + 1 == cfg.passes);
        assert_eq!((play.draws, play.reads), (seen.is_empty(), pass > 0));
        let before = if cfg.window.windows { play.window * cfg.window.places() } else { 0 };
        let beyond = counted > before + cfg.window.places();
        let out = sim.clock(In { over: true, beyond, ..NOTHING }).unwrap().out;
        seen.push(Seen { pass, window: play.window, primitives, wasted: out.wasted });
        if out.finished {
            assert!(!out.again);
            sim.clock(NOTHING).unwrap();
            assert!(sim.moore().finished && sim.moore().busy);
            sim.clock(In { done: true, ..NOTHING }).unwrap();
            let Moore { busy, open, replay, finished, .. } = sim.moore();
            assert_eq!((busy, open, replay, finished), (false, true, false, false));
            return seen;
        }
        assert!(out.again);
    }
}

fn all(count: usize) -> Vec<u32> {
    (0..count as u32).collect()
}

proptest! {
    /// `ceil(N / S)` windows, each in all passes, before the next one.
    #[test]
    fn windows_follow_each_other(
        fragments in prop::collection::vec(0..5u32, 0..9), passes in 2..4u32,
    ) {
        let places = 4;
        let sum: u32 = fragments.iter().sum();
        let mut expected = vec![];
        for window in 0..sum.div_ceil(places).max(1) {
            for pass in 0..passes {
                let primitives = all(fragments.len());
                expected.push(Seen { pass, window, primitives, wasted: false });
            }
        }
        prop_assert_eq!(frame(plays(passes, true, false), &fragments), expected);
    }

    /// A batch is halved until it fits or is one primitive; the next one is no longer than that.
    #[test]
    fn batches_are_halved_until_they_fit(
        fragments in prop::collection::vec(0..6u32, 0..12), passes in 2..4u32,
    ) {
        let (mut expected, mut first, mut length) = (vec![], 0, usize::MAX);
        loop {
            let batch = first..fragments.len().min(usize::saturating_add(first, length));
            let sum: u32 = fragments[batch.clone()].iter().sum();
            let primitives: Vec<u32> = batch.clone().map(|number| number as u32).collect();
            if sum > 4 && batch.len() > 1 {
                length = batch.len().div_ceil(2);
                expected.push(Seen { pass: 0, window: 0, primitives, wasted: true });
                continue;
            }
            for pass in 0..passes {
                let primitives = primitives.clone();
                expected.push(Seen { pass, window: 0, primitives, wasted: false });
            }
            first = batch.end;
            if first == fragments.len() {
                break;
            }
        }
        prop_assert_eq!(frame(plays(passes, false, false), &fragments), expected);
    }
}

/// Each window begins where the one before has ended; the next frame's at 0.
#[test]
fn a_window_begins_where_the_one_before_has_ended() {
    let cfg = Config { window: compacting(2), ..plays(2, true, false) };
    let mut sim = Sim::<Plays>::new(cfg);
    for _ in 0..2 {
        let mut seen = vec![];
        for (beyond, next_window) in [(true, 7), (true, 7), (true, 30), (true, 30), (false, 41)] {
            seen.push((sim.moore().pass, sim.moore().play.window));
            let out = sim.clock(In { over: true, beyond, next_window, ..NOTHING }).unwrap().out;
            assert!(out.again);
        }
        assert_eq!(seen, [(0, 0), (1, 0), (0, 7), (1, 7), (0, 30)]);
        assert_eq!((sim.moore().pass, sim.moore().play.window), (1, 30));
        let last = In { over: true, next_window: 41, ..NOTHING };
        assert!(sim.clock(last).unwrap().out.finished);
        sim.clock(In { done: true, ..NOTHING }).unwrap();
    }
}

#[test]
fn a_background_comes_first() {
    let primitives = all(2);
    let of = |pass| Seen { pass, window: 0, primitives: primitives.clone(), wasted: false };
    assert_eq!(frame(plays(2, true, true), &[1, 2]), [of(0), of(0), of(1)]);
}
