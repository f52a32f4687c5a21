use super::*;
use crate::bench::Bench;
use pellucid_machine::architecture::Setting;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine::{Cycles, Model};
use pellucid_sim::{Label, Ports, ReadDuringWrite};
use proptest::prelude::*;

/// A memory of 32768 words of 64 bits with one port, whose price at 22 nm is a row of the table: 0.579749 ns, 0.00993381 nJ a read,
/// 0.00754251 a write, 35.1424 mW, 0.208251 mm2.
fn memory(name: &str, reads: u64, writes: u64) -> MemoryTally {
    let info = StorageInfo {
        ports: Ports::One,
        read_during_write: ReadDuringWrite::Forbidden,
        latency: 1,
        outside: false,
        words: 32768,
        bits_per_word: 64,
        reads,
        writes,
        peak_words: None,
    };
    MemoryTally { name: name.to_string(), info, peak_words: 32768 }
}

fn tally(memories: Vec<MemoryTally>) -> Tally {
    let cycles = Cycles { total: 4000, ..Cycles::default() };
    Tally { cycles, memories, ..Tally::default() }
}

fn costs(tally: &Tally, settings: &[(String, Value)], frames: u32) -> Costs {
    Costs::new(&Technology::default(), settings, tally, frames, None)
}

fn given(mhz: u32) -> Vec<(String, Value)> {
    vec![("sections".to_string(), Value::Number(7)), (CLOCK.to_string(), Value::Number(mhz))]
}

fn near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} and {expected}");
}

#[test]
fn a_frame_by_hand() {
    let costs = costs(&tally(vec![memory("a", 3000, 1000)]), &given(500), 1);
    near(costs.reads_nj(), 29.80143);
    near(costs.writes_nj(), 7.54251);
    // 4000 cycles of 2 ns.
    near(costs.leakage_nj(), 35.1424 * 8000.0 / 1000.0);
    near(costs.area_mm2(), 0.208251);
    let clock = costs.clock.as_ref().unwrap();
    near(clock.frame_ns, 8000.0);
    // One access a clock: the slower of access and cycle, 0.795423 ns at 45 nm and less here.
    near(clock.fastest_mhz, 1000.0 / 0.579749);
    assert!(clock.given);
    near(costs.total_nj().unwrap(), costs.reads_nj() + costs.writes_nj() + costs.leakage_nj());
}

#[test]
fn the_slowest_memory_gives_the_clock() {
    let mut large = memory("large", 0, 0);
    large.info.words *= 4;
    let slow = costs(&tally(vec![memory("a", 1, 1), large.clone()]), &[], 1).clock.unwrap();
    assert_eq!((slow.slowest.as_str(), slow.given), ("large", false));
    near(slow.mhz, 1000.0 / (2.0 * 0.579749));
    near(slow.frame_ns, 4000.0 * 2.0 * 0.579749);
    // With a word after two cycles, it may take two.
    large.info.latency = 2;
    near(costs(&tally(vec![large]), &[], 1).clock.unwrap().mhz, 1000.0 / 0.579749);
}

#[test]
fn energy_is_that_of_one_frame() {
    let one = costs(&tally(vec![memory("a", 3000, 1000)]), &given(500), 1);
    let mut twice = tally(vec![memory("a", 6000, 2000)]);
    twice.cycles.total *= 2;
    let two = costs(&twice, &given(500), 2);
    assert_eq!(one.memories, two.memories);
    assert_eq!(one.clock, two.clock);
}

#[test]
fn what_is_apart_adds_up() {
    let [a, b] = [memory("a", 5, 7), memory("b", 11, 13)];
    let alone = [&a, &b].map(|m| costs(&tally(vec![m.clone()]), &given(500), 1));
    let both = costs(&tally(vec![a, b]), &given(500), 1);
    for of in [Costs::area_mm2, Costs::reads_nj, Costs::writes_nj, Costs::leakage_nj] {
        near(of(&both), of(&alone[0]) + of(&alone[1]));
    }
    near(both.on_chip_nj(), alone[0].on_chip_nj() + alone[1].on_chip_nj());
}

#[test]
fn what_is_outside_has_no_area_and_no_total_unless_it_is_known() {
    let mut outside = memory("outside", 100, 100);
    outside.info.outside = true;
    let mut tally = tally(vec![memory("a", 1, 1), outside]);
    let unknown = costs(&tally, &given(500), 1);
    assert_eq!((unknown.memories[1], unknown.total_nj(), unknown.outside_nj()), (None, None, None));
    near(unknown.area_mm2(), 0.208251);
    // One that was not used took nothing.
    let unused = &mut tally.memories[1].info;
    (unused.reads, unused.writes) = (0, 0);
    near(costs(&tally, &given(500), 1).total_nj().unwrap(), unknown.on_chip_nj());
    let figure = |name, value| Figure { name, unit: "pJ", about: "", value };
    let figures = vec![figure("activates", 5000), figure("reads", 7000)];
    let clocks = Figure { name: "clocks", unit: "clocks", about: "", value: 9 };
    tally.outside = figures.into_iter().chain([clocks]).collect();
    let known = costs(&tally, &given(500), 2);
    near(known.outside_nj().unwrap(), 6.0);
    near(known.total_nj().unwrap(), known.on_chip_nj() + 6.0);
}

#[test]
fn a_machine_without_memories_has_no_clock() {
    let none = costs(&tally(vec![]), &given(500), 1);
    assert_eq!((&none.clock, none.total_nj()), (&None, Some(0.0)));
    assert!(none.memories.is_empty() && none.outside.is_empty());
}

/// What a machine counts of a frame that is played so many times, once it has run for a while.
fn played(model: &dyn Model, frame: &[Fragment], times: u32) -> Tally {
    let mut bench = Bench::new(model);
    for play in 0..2 + times {
        if play == 2 {
            bench.count_anew();
        }
        for fragment in frame {
            bench.send(&(*fragment).into()).unwrap();
        }
        bench.end_frame().unwrap();
    }
    bench.tally()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_doubled_frame_doubles_dynamic_energy(
        fragments in proptest::collection::vec((0u32..4, 0u32..3, 1u32..1000, any::<u32>()), 30..80),
    ) {
        let screen = Screen { width: 4, height: 3, background: 0 };
        let setting = |name: &str, value: &str| Setting {
            name: name.to_string(),
            value: value.to_string(),
            origin: String::new(),
        };
        let frame: Vec<Fragment> = fragments
            .into_iter()
            // Transparent, so that each takes a place.
            .map(|(x, y, z, rgba)| Fragment { x, y, z, rgba: rgba & !0x80, label: Label::NONE })
            .collect();
        for (architecture, sections) in [
            (&pellucid_tbuffer::architecture::ARCHITECTURE, "sections"),
            (&pellucid_mbuffer::architecture::ARCHITECTURE, "overflow_sections"),
        ] {
            // The allocator's pointer begins at the first section in each frame: each finds the machine as the one before.
            let settings =
                [(sections, "80"), ("outside_sections", "0"), ("allocator", "bump")];
            let settings = settings.map(|(name, value)| setting(name, value));
            let model = architecture.build(screen, None, &settings).unwrap();
            // The frame buffer has two banks, which take turns: each has its part in two frames.
            let [one, two] = [2, 4].map(|times| costs(&played(&*model, &frame, times), &given(500), 1));
            prop_assert!(one.reads_nj() > 0.0 && one.writes_nj() > 0.0);
            for (one, two) in one.memories.iter().flatten().zip(two.memories.iter().flatten()) {
                let twice = |one: f64, two: f64| (two - 2.0 * one).abs() <= 1e-12 * two;
                prop_assert!(twice(one.reads_nj, two.reads_nj), "{one:?} {two:?}");
                prop_assert!(twice(one.writes_nj, two.writes_nj), "{one:?} {two:?}");
            }
        }
    }
}

/// The slower of memories and logic says how fast the clock is.
#[test]
fn logic_may_be_slower_than_memories() {
    let tally = tally(vec![memory("a", 3000, 1000)]);
    for (period, slowest) in [(0.5, "a"), (0.6, "logic")] {
        let source = "cells".to_string();
        let logic = Logic { source, area_mm2: 0.25, period_ns: Some(period) };
        let costs = Costs::new(&Technology::default(), &[], &tally, 1, Some(&logic));
        let clock = costs.clock.as_ref().unwrap();
        assert_eq!(clock.slowest, slowest);
        near(clock.fastest_mhz, 1000.0 / period.max(0.579749));
        near(clock.frame_ns, 4000.0 * period.max(0.579749));
        near(costs.area_mm2(), 0.208251);
    }
}
