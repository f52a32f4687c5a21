use super::*;
use crate::test_util::{Pattern, pattern, screen};
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;
use std::collections::VecDeque;

/// A transparent primitive's part of the line: its columns, its depth in the first and what that gains with each.
#[derive(Clone, Copy, Debug)]
struct Part {
    first: u32,
    last: u32,
    z: u32,
    z_step: u32,
}

/// What a pixel has: the depth of each of its transparent fragments and which part it is of.
fn fragments(parts: &[Part], column: u32) -> Vec<(u32, u32)> {
    let here = |(number, part): (usize, &Part)| {
        let is_there = part.first <= column && column <= part.last;
        is_there.then(|| (part.z + part.z_step * (column - part.first), number as u32))
    };
    parts.iter().enumerate().filter_map(here).collect()
}

/// The segment of a part at its first column: red is the part's number, and gains one with each column.
fn segment(number: usize, part: &Part) -> Segment {
    let plane = |value: u32| u64::from(value) << 16;
    let at = Attributes {
        z: plane(part.z),
        red: (number as u32) << 16,
        alpha: 100 << 16,
        ..Attributes::default()
    };
    let per_column = Attributes { z: plane(part.z_step), red: 1 << 16, ..Attributes::default() };
    Segment { last: part.last, at, per_column, label: Label::new(number as u32, 0, 0) }
}

/// What came of a line.
#[derive(Debug, Default, PartialEq)]
struct Seen {
    /// Fragments for the sorter, with the cycles in which they were taken.
    arrived: Vec<(u64, Arrived)>,
    /// Transparent ones that were given for the last time, and those of them that are hidden.
    given: u32,
    hidden: u32,
    cycles: u64,
}

/// The layers beside a plain list of what is active in each column.
struct Bench {
    sim: Sim<Layers>,
}

impl Bench {
    fn new(width: u32, sorter_depth: u32) -> Bench {
        Bench { sim: Sim::new(Config { line: screen(width, 1), sorter_depth, layers: 15 }) }
    }

    /// A line; the opaque pixels are there in the cycles of `merged`.
    fn line(&mut self, opaque: &[u32], parts: &[Part], merged: &Pattern, ready: &Pattern) -> Seen {
        let mut seen = Seen::default();
        let mut monitor = StreamMonitor::new("arrived", "Layers", "test");
        let (mut active, mut column) = (VecDeque::new(), 0);
        let begin = |active: &mut VecDeque<(usize, Segment)>, column: u32| {
            let parts = parts.iter().enumerate().filter(|(_, part)| part.first == column);
            active.extend(parts.map(|(number, part)| (number, segment(number, part))));
            active.make_contiguous().sort_by_key(|(number, _)| *number);
        };
        begin(&mut active, 0);
        let (mut left, mut there) = (active.len(), false);
        for cycle in 0.. {
            assert!(cycle < 10_000, "the line does not end: {seen:?}");
            there |= merged.at(cycle);
            let pixel = Opaque { z: opaque[column as usize], colour: 0x0a_0b_00 | column };
            let i = In {
                opaque: if there { Stream::offer(pixel) } else { Stream::idle() },
                open: true,
                count: left as u32,
                item: active
                    .front()
                    .filter(|_| left > 0)
                    .map_or(Stream::idle(), |(_, item)| Stream::offer(*item)),
                arrived_ready: ready.at(cycle),
            };
            let out = self.sim.clock(i).unwrap().out;
            let arrived = out.arrived.with(i.arrived_ready);
            monitor.observe(arrived).unwrap();
            if arrived.fires() {
                assert!(!arrived.payload.end);
                seen.arrived.push((cycle, arrived.payload.item));
            }
            seen.given += u32::from(out.fragment);
            seen.hidden += u32::from(out.hidden);
            if out.take {
                let (number, _) = active.pop_front().unwrap();
                active.extend(out.back.valid.then_some((number, out.back.payload)));
                left -= 1;
            }
            if out.next {
                assert_eq!(left, 0, "a pixel is complete with fragments left");
                if column as usize + 1 == opaque.len() {
                    assert!(active.is_empty(), "something goes on behind the line: {active:?}");
                    seen.cycles = cycle + 1;
                    return seen;
                }
                column += 1;
                begin(&mut active, column);
                (left, there) = (active.len(), false);
            } else {
                // The round goes over into the next one after the last of its fragments.
                let round_ends = left == 0 && (out.take || (arrived.fires() && i.count == 0));
                left = if round_ends { active.len() } else { left };
            }
        }
        unreachable!("the loop ends by return")
    }
}

/// What must arrive at the sorter, and in how many cycles if nothing waits.
fn reference(opaque: &[u32], parts: &[Part], sorter_depth: u32) -> (Vec<Arrived>, u64) {
    let (mut arrived, mut cycles) = (vec![], 0);
    for (column, &z_opaque) in (0..).zip(opaque) {
        let transparent = fragments(parts, column);
        let visible = transparent.iter().filter(|(z, _)| *z < z_opaque).count() as u32;
        let count = transparent.len() as u32;
        let one_round = count < sorter_depth;
        let passes = if one_round { 1 } else { (visible + 1).div_ceil(sorter_depth) };
        cycles += if one_round { 0 } else { u64::from(count) };
        for pass in 1..=passes {
            let last_pass = pass == passes;
            let below = Arrived {
                pixel: 0,
                z: Z_FAR,
                rgba: 0x0a_0b_00_ff | column << 8,
                visible: true,
                last: count == 0,
                last_pass,
                ..Arrived::default()
            };
            let above = (1..).zip(&transparent).map(|(at, &(z, number))| Arrived {
                pixel: 0,
                z,
                rgba: (number + column - parts[number as usize].first) << 24 | 100,
                visible: z < z_opaque,
                last: at == count,
                last_pass,
                label: Label::new(number, 0, 0),
                ..Arrived::default()
            });
            arrived.push(below);
            arrived.extend(above);
            cycles += u64::from(count) + 1;
        }
    }
    (arrived, cycles)
}

fn items(seen: &Seen) -> Vec<Arrived> {
    seen.arrived.iter().map(|(_, arrived)| *arrived).collect()
}

const fn part(first: u32, last: u32, z: u32, z_step: u32) -> Part {
    Part { first, last, z, z_step }
}

/// Cycles of a line of one pixel with so many visible and hidden transparent fragments, and how often its opaque
/// one is given.
fn one_pixel(sorter_depth: u32, visible: usize, hidden: usize) -> (u64, usize) {
    let parts = [vec![part(0, 0, 3, 0); visible], vec![part(0, 0, 5, 0); hidden]].concat();
    let always = Pattern::always();
    let seen = Bench::new(1, sorter_depth).line(&[5], &parts, &always, &always);
    assert_eq!((seen.given as usize, seen.hidden as usize), (visible + hidden, hidden));
    (seen.cycles, items(&seen).iter().filter(|arrived| arrived.z == Z_FAR).count())
}

#[test]
fn a_fragment_a_cycle_the_opaque_one_first() {
    let always = Pattern::always();
    let parts = [part(0, 1, 7, 1), part(1, 1, 2, 0)];
    let seen = Bench::new(2, 4).line(&[8, 8], &parts, &always, &always);
    let of = |z, red: u32, last, visible| Arrived {
        z,
        rgba: red << 24 | 100,
        visible,
        last,
        last_pass: true,
        ..Arrived::default()
    };
    let opaque = |column: u32, last| Arrived {
        rgba: 0x0a_0b_00_ff | column << 8,
        ..of(Z_FAR, 0, last, true)
    };
    let second = |number, arrived| Arrived { label: Label::new(number, 0, 0), ..arrived };
    let first = Arrived { label: Label::new(0, 0, 0), ..of(7, 0, true, true) };
    // In the second column the first part is at depth 8, as far as what hides it.
    let expected = [
        (0, opaque(0, false)),
        (1, first),
        (2, opaque(1, false)),
        (3, second(0, of(8, 1, false, false))),
        (4, second(1, of(2, 1, true, true))),
    ];
    assert_eq!(seen, Seen { arrived: expected.to_vec(), given: 3, hidden: 1, cycles: 5 });
}

#[test]
fn a_pixel_that_fits_the_sorter_takes_one_round() {
    // The opaque fragment is one of those that it takes.
    assert_eq!(one_pixel(4, 0, 0), (1, 1));
    assert_eq!(one_pixel(4, 3, 0), (4, 1));
    assert_eq!(one_pixel(4, 1, 2), (4, 1));
}

#[test]
fn any_other_is_counted_then_given_once_for_each_pass() {
    // Four to count, then twice five, since the opaque one is the fifth that is seen.
    assert_eq!(one_pixel(4, 4, 0), (4 + 2 * 5, 2));
    assert_eq!(one_pixel(4, 7, 0), (7 + 2 * 8, 2));
    assert_eq!(one_pixel(4, 8, 0), (8 + 3 * 9, 3));
    // Hidden ones take no place in the sorter.
    assert_eq!(one_pixel(4, 3, 6), (9 + 10, 1));
    assert_eq!(one_pixel(4, 0, 6), (6 + 7, 1));
    assert_eq!(one_pixel(1, 2, 0), (2 + 3 * 3, 3));
}

#[test]
fn without_an_opaque_pixel_or_an_open_column_nothing_moves() {
    let mut sim = Sim::<Layers>::new(Config { line: screen(2, 1), sorter_depth: 2, layers: 7 });
    let pixel = Opaque { z: 9, colour: 1 };
    let item = Stream::offer(segment(0, &part(0, 0, 3, 0)));
    for (opaque, open) in [(Stream::idle(), true), (Stream::offer(pixel), false)] {
        for count in [1, 5] {
            let i = In { opaque, open, count, item, arrived_ready: true };
            let out = sim.clock(i).unwrap().out;
            assert!(!out.arrived.valid && !out.take && !out.next && !out.fragment);
        }
    }
}

fn parts(width: u32) -> impl Strategy<Value = Vec<Part>> {
    let one = (0..width, 0..width, 0..6_u32, 0..3_u32)
        .prop_map(|(a, b, z, z_step)| part(a.min(b), a.max(b), z, z_step));
    proptest::collection::vec(one, 0..10)
}

proptest! {
    /// Line after line: each pixel's fragments in the order of their primitives, pass after pass.
    #[test]
    fn gives_each_pixels_fragments(
        (width, lines) in (1..5_u32).prop_flat_map(|width| {
            let opaque = proptest::collection::vec(prop_oneof![Just(Z_FAR), 0..9_u32], width as usize);
            (Just(width), proptest::collection::vec((opaque, parts(width)), 1..4))
        }),
        sorter_depth in 1..5_u32,
        merged in pattern(),
        ready in pattern(),
    ) {
        let mut bench = Bench::new(width, sorter_depth);
        let always = Pattern::always();
        for (opaque, parts) in lines {
            let (expected, cycles) = reference(&opaque, &parts, sorter_depth);
            let seen = bench.line(&opaque, &parts, &merged, &ready);
            prop_assert_eq!(items(&seen), expected.clone());
            let free = bench.line(&opaque, &parts, &always, &always);
            prop_assert_eq!((items(&free), free.cycles), (expected, cycles));
            let (given, hidden) = (0..width)
                .flat_map(|column| fragments(&parts, column).into_iter().map(move |f| (column, f)))
                .fold((0, 0), |(given, hidden), (column, (z, _))| {
                    (given + 1, hidden + u32::from(z >= opaque[column as usize]))
                });
            prop_assert_eq!((seen.given, seen.hidden), (given, hidden));
        }
    }
}

#[test]
#[should_panic(expected = "the number of fragments of a pass is 0: expected 1 to 64")]
fn a_pass_has_a_fragment() {
    Bench::new(3, 0);
}
