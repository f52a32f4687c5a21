//! B3D against the golden model.

use pellucid_b3d::architecture::ARCHITECTURE;
use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine_properties::frames::{
    Setup, check_drops, check_place, effort, from_line_to_line, some_frames,
};
use pellucid_machine_properties::machine_properties;
use pellucid_machine_properties::presets::papers_frames_at_the_target_rate;
use pellucid_sim::Label;
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

/// Counters of a word outside, where pixels have 64 slots each.
const LANES: u32 = 8;

const SCREEN: Screen = Screen { width: 5, height: 4, background: 0x40_50_60 };

/// So many slots for each pixel, to begin with and at most.
fn slots(layers: u32, most: u32, overflow: &str) -> Parameterised {
    vec![
        ("layers", layers.to_string()),
        ("most_layers", most.to_string()),
        ("overflow", overflow.to_string()),
        ("fragments", "30".to_string()),
        ("sorter_depth", "4".to_string()),
    ]
}

/// A fragment at each pixel, and more at one, all transparent.
fn deep(pixel: u32, layers: u32) -> Vec<Fragment> {
    let fragment = |k: u32, pixel: u32| Fragment {
        x: pixel % SCREEN.width,
        y: pixel / SCREEN.width,
        z: k * 7 % 50 + 1,
        rgba: (k * 977) << 9 | 0x70,
        label: Label::NONE,
    };
    let all = (0..SCREEN.pixels()).map(|pixel| fragment(pixel, pixel));
    all.chain((1..layers).map(|k| fragment(k, pixel))).collect()
}

#[test]
fn slots_are_doubled_until_the_frame_fits() {
    // Of 20 pixels one has 7 fragments: 2 slots, 4, 8. Counters have 2 words.
    let frame = deep(13, 7);
    let setup = Setup::free(&ARCHITECTURE, SCREEN, slots(2, 64, "rebuild"));
    let run = setup.run(&[frame.clone(), frame.clone()]).unwrap();
    assert_eq!(run.images, vec![setup.golden_image(&frame); 2]);
    let figures = ["rebuilds", "layers_used", "fragments_used", "fragments_written", "replayed"];
    // The second frame has 8 from the start. 19 pixels have one, that one 2, 4, 7 and 7.
    let expected = [2, 8, 26, 21 + 23 + 26 + 26, 2 * 26];
    assert_eq!(figures.map(|name| run.tally.figure(name)), expected);
    assert_eq!(run.tally.cycles.of("rebuild"), Some(2 * 2));
    assert_eq!(run.tally.fragments.dropped, 0);
}

#[test]
fn they_grow_to_the_most_even_if_that_is_not_twice_as_many() {
    for (deepest, rebuilds, layers) in [(3, 0, 3), (4, 1, 6), (6, 1, 6), (7, 2, 10), (10, 2, 10)] {
        let frame = deep(0, deepest);
        let setup = Setup::free(&ARCHITECTURE, SCREEN, slots(3, 10, "rebuild"));
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame));
        let found = ["rebuilds", "layers_used"].map(|name| run.tally.figure(name));
        assert_eq!(found, [rebuilds, layers], "{deepest} layers");
    }
}

#[test]
fn what_finds_no_slot_at_last_is_dropped() {
    for (layers, most, overflow, kept) in [(2, 64, "drop", 2), (2, 5, "rebuild", 5)] {
        let frame = deep(13, 9);
        let mut of_pixel = 0;
        let mut dropped = vec![];
        for f in &frame {
            let deep = f.y * SCREEN.width + f.x == 13;
            dropped.push(deep && of_pixel >= kept);
            of_pixel += u32::from(deep);
        }
        assert_eq!(dropped.iter().filter(|dropped| **dropped).count(), 9 - kept as usize);
        let setup = Setup::free(&ARCHITECTURE, SCREEN, slots(layers, most, overflow));
        check_drops(&setup, &frame, &dropped).unwrap();
    }
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    papers_frames_at_the_target_rate(&ARCHITECTURE, "fast");
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn where_counters_lie_changes_cycles_and_traffic_alone(
        (setup, frames) in some_frames(&ARCHITECTURE, 3)
    ) {
        check_place(&setup, &frames, "counters")?;
    }
}

/// Whatever the latency, as long as so many reads are in flight: what counts are the words that the port moves.
#[test]
fn counters_outside_cost_words_and_no_latency() {
    let screen = Screen { width: 128, height: 96, background: 0 };
    let (pixels, line) = (screen.pixels(), 4);
    let frame = from_line_to_line(screen, line * LANES);
    for latency in [1, 64, 256] {
        let mut parameters = slots(64, 64, "drop");
        parameters.extend([
            ("counters", "cached".to_string()),
            ("counters_sets", "32".to_string()),
            ("counters_line", line.to_string()),
            ("fragments", (64 * screen.pixels()).to_string()),
            ("outside_latency", latency.to_string()),
            ("reads_in_flight", latency.max(2).to_string()),
        ]);
        let run = Setup::free(&ARCHITECTURE, screen, parameters).run(std::slice::from_ref(&frame));
        let cycles = run.unwrap().tally.cycles.of("store").unwrap();
        // A line in and out for each fragment.
        let words = u64::from(2 * line * pixels);
        assert!(cycles.abs_diff(words) <= words / 20, "{latency}: {cycles}, {words} words");
    }
}
