use super::*;
use crate::plays::Play;
use crate::test_util::{Pattern, Source, compacting, pattern};
use crate::window::{self, Placed, Window};
use pellucid_machine::pixel::{Fragment, Marked};
use pellucid_sim::Sim;
use proptest::prelude::*;
use std::collections::VecDeque;

/// Which fragments a pass of a window has shaded.
#[derive(Debug, PartialEq)]
struct Seen {
    first: u32,
    pass: u32,
    shaded: Vec<u32>,
}

/// A window with its survivors, a shader of some stages, and an F-buffer that holds numbers.
struct Machine {
    window: Sim<Window>,
    survivors: Sim<Survivors>,
    stages: usize,
    buffer: Vec<u32>,
}

impl Machine {
    fn new(place_bits: u32, stages: usize) -> Machine {
        let cfg = compacting(place_bits);
        let buffer = vec![u32::MAX; cfg.places() as usize];
        Machine { window: Sim::new(cfg), survivors: Sim::new(cfg), stages, buffer }
    }

    /// A play of `count` fragments, of which `kills` says which are killed; the number behind the window, and whether there are any
    /// behind it.
    fn play(
        &mut self,
        play: Play,
        last: bool,
        count: u32,
        kills: impl Fn(u32) -> bool,
        starts: Pattern,
        advance: &Pattern,
    ) -> (Vec<u32>, u32, bool) {
        let items = (0..count).map(|z| Marked::item(Fragment { z, ..Fragment::default() }));
        let mut source = Source::new(items.chain([Marked::end()]), starts);
        let mut line: VecDeque<Option<Marked<Placed>>> = vec![None; self.stages].into();
        let mut shaded = vec![];
        let mut over = false;
        for cycle in 0.. {
            assert!(cycle < 20_000, "the end of the play does not come");
            let (survivors, moore) = (self.survivors.moore(), self.window.moore());
            let advance = advance.at(cycle);
            let mut leaves = None;
            if advance {
                line.push_back(moore.placed.valid.then_some(moore.placed.payload));
                leaves = line.pop_front().flatten();
            }
            let ended = leaves.is_some_and(|item| item.end);
            let leaves = leaves.filter(|item| !item.end).map(|item| item.item.number);
            let left = leaves.filter(|number| !last && !kills(*number));
            let i = window::In {
                fragment: source.offer(cycle),
                play,
                survivors,
                there: true,
                advance,
                over,
            };
            let out = self.window.clock(i).unwrap().out;
            let number = i.fragment.payload.item.z;
            if out.shaded {
                shaded.push(number);
                assert_eq!(out.read.valid, play.reads);
            }
            if out.read.valid {
                assert_eq!(self.buffer[out.read.payload as usize], number);
            }
            if let Some(number) = left {
                self.buffer[survivors.free as usize] = number;
            }
            let of_survivors = In {
                enters: out.shaded,
                leaves: leaves.is_some(),
                survives: left.map_or(Stream::idle(), Stream::offer),
                over,
            };
            self.survivors.clock(of_survivors).unwrap();
            source.edge(out.taken);
            if over {
                let beyond = window::beyond(self.window.config(), play.window, moore);
                return (shaded, moore.end, beyond);
            }
            over = ended;
        }
        unreachable!()
    }

    /// All plays of a frame in windows: fragment `n` is killed in pass `killed_in[n]`, if there is such a pass.
    fn frame(
        &mut self,
        passes: u32,
        killed_in: &[u32],
        starts: Pattern,
        advance: &Pattern,
    ) -> Vec<Seen> {
        let (mut all, mut first) = (vec![], 0);
        loop {
            let mut behind = (0, false);
            for pass in 0..passes {
                let play = Play { draws: false, shades: true, reads: pass > 0, window: first };
                let kills = |number: u32| killed_in[number as usize] == pass;
                let (shaded, end, beyond) = self.play(
                    play,
                    pass + 1 == passes,
                    killed_in.len() as u32,
                    kills,
                    starts.clone(),
                    advance,
                );
                all.push(Seen { first, pass, shaded });
                behind = (end, beyond);
            }
            let (end, beyond) = behind;
            if !beyond {
                return all;
            }
            first = end;
        }
    }
}

proptest! {
    /// A window ends with the fragment that takes the last place; each of its fragments is in every pass up to the one that kills it, and
    /// finds there what the pass before has left of it.
    #[test]
    fn no_survivor_is_shaded_twice_or_never(
        killed_in in prop::collection::vec(0..5u32, 0..60),
        place_bits in 0..4u32,
        passes in 2..4u32,
        stages in 1..=12usize,
        starts in pattern(),
        advance in pattern(),
    ) {
        let count = killed_in.len() as u32;
        let (mut expected, mut first) = (vec![], 0);
        loop {
            let (mut end, mut left) = (first, 0);
            while end < count && left < 1 << place_bits {
                left += u32::from(killed_in[end as usize] > 0);
                end += 1;
            }
            for pass in 0..passes {
                let of_pass = |number: &u32| killed_in[*number as usize] >= pass;
                let shaded = (first..end).filter(of_pass).collect();
                expected.push(Seen { first, pass, shaded });
            }
            if end == count {
                break;
            }
            first = end;
        }
        let mut machine = Machine::new(place_bits, stages);
        prop_assert_eq!(&machine.frame(passes, &killed_in, starts.clone(), &advance), &expected);
        // And of a frame after it.
        prop_assert_eq!(machine.frame(passes, &killed_in, starts, &advance), expected);
    }
}

/// Four places and three stages: a fragment leaves four cycles after it has entered, and its place is free in the next one.
#[test]
fn one_waits_only_for_a_place_that_may_be_needed() {
    let cycles = |killed: bool| {
        let (mut machine, always) = (Machine::new(2, 3), Pattern::always());
        let play = Play { draws: false, shades: true, reads: false, window: 0 };
        let (shaded, ..) = machine.play(play, false, 8, |_| killed, always.clone(), &always);
        (shaded.len(), machine.window.cycle())
    };
    // Four enter in cycles 0 to 3, the others as those are killed, in 5 to 8; the end in 9 leaves in 13, and is told in 14.
    assert_eq!(cycles(true), (8, 15));
    // In cycle 8 it is known that the last place is taken, and the others are discarded in 8 to 11; the end comes in 12.
    assert_eq!(cycles(false), (4, 18));
}
