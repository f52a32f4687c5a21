//! The M-buffer against the golden model of its weighted sum.

use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine_properties::frames::{
    Setup, check_drops, effort, one_frame, tried, without_place,
};
use pellucid_machine_properties::machine_properties;
use pellucid_machine_properties::presets::papers_frames_at_the_target_rate;
use pellucid_mbuffer::architecture::ARCHITECTURE;
use pellucid_sim::Label;
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

proptest! {
    #![proptest_config(effort())]

    /// Wherever the weights are kept and however many cells there are, the image is the same.
    #[test]
    fn weights_in_registers_and_in_memory_are_the_same(
        (setup, frame) in one_frame(&ARCHITECTURE), array in 1..=32u32,
    ) {
        let images = ["registers", "memory"].map(|weights| {
            let further = vec![("weights", weights.to_string()), ("array", array.to_string())];
            setup.with(further).run(std::slice::from_ref(&frame))
        });
        let [registers, memory] = images.map(|run| tried(run).map(|run| run.images));
        prop_assert_eq!(registers?, memory?);
    }

    #[test]
    fn a_full_machine_drops_what_finds_no_section(
        (setup, frame) in one_frame(&ARCHITECTURE), sections in 0..20u32, outside in 0..20u32,
    ) {
        let few = [("overflow_sections", sections), ("outside_sections", outside)];
        let setup = setup.with(few.map(|(name, value)| (name, value.to_string())).to_vec());
        let capacity = setup.number("section_capacity");
        let dropped = without_place(setup.screen(), &frame, sections + outside, capacity, true);
        check_drops(&setup, &frame, &dropped)?;
    }
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    papers_frames_at_the_target_rate(&ARCHITECTURE, "registers");
}

/// Fragments of one pixel, far to near or near to far: how many cycles store takes with weights in memory.
#[test]
fn comparing_on_arrival_takes_the_cycles_that_it_is_said_to() {
    let screen = Screen { width: 4, height: 4, background: 0 };
    let setup = Setup::free(&ARCHITECTURE, screen, vec![("weights", "memory".into())]);
    let layers = 6u32;
    let frame = |depth: fn(u32) -> u32| -> Vec<Fragment> {
        (0..layers)
            .map(|k| Fragment { x: 1, y: 2, z: depth(k), rgba: k << 8 | 0x80, label: Label::NONE })
            .collect()
    };
    // Five cycles to fill and empty the pipeline, one for the first fragment. One that finds i others has an access for each,
    // begins behind the one before, and is placed as the last is compared; or in the cycle after, where that one is written back
    // as all others are.
    let near_to_far: u64 = 5 + 1 + (1..6).map(|i| i + 1).sum::<u64>();
    let far_to_near: u64 = 5 + 1 + (1..6).map(|i| i + i + 1).sum::<u64>();
    for (frame, store, changed) in
        [(frame(|k| 10 + k), near_to_far, 0), (frame(|k| 90 - k), far_to_near, 15)]
    {
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame));
        assert_eq!(run.tally.cycles.of("store"), Some(store));
        let counted = ["compared", "weights_changed"].map(|name| run.tally.figure(name));
        assert_eq!(counted, [15, changed]);
    }
}

/// Layer after layer of all pixels, with weights in memory: wherever the sections are, and however far away, store takes the
/// cycles that the side with more accesses needs for a layer, or those of its comparisons.
#[test]
fn the_latency_of_outside_memory_is_hidden_on_arrival() {
    const LAYERS: u32 = 7;
    let screen = Screen { width: 24, height: 16, background: 0 };
    let depth = |x: u32, y: u32, layer: u32| 1 + (x * 31 + y * 17 + layer * layer * 53) % 97;
    let layer = |layer: u32| {
        let pixels = (0..16).flat_map(|y| (0..24).map(move |x| (x, y)));
        pixels.map(move |(x, y)| {
            let (z, rgba) = (depth(x, y, layer), (x * y) << 8 | 0x80);
            Fragment { x, y, z, rgba, label: Label::NONE }
        })
    };
    let frame: Vec<Fragment> = (0..LAYERS).flat_map(layer).collect();
    for (overflow, latency) in [(1200, 1), (600, 1), (600, 200), (0, 1), (0, 30), (0, 200)] {
        let settings = [
            ("weights", "memory".to_string()),
            ("overflow_sections", overflow.to_string()),
            ("outside_sections", "1200".to_string()),
            ("outside_latency", latency.to_string()),
            ("reads_in_flight", "256".to_string()),
        ];
        let setup = Setup::free(&ARCHITECTURE, screen, settings.to_vec());
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame));

        // Sections of two: the first is the pixel's own, and of all others those that are taken first are on chip.
        let outside =
            |pixel: u32, layer: u32| layer > 1 && (layer / 2 - 1) * 384 + pixel >= overflow;
        let mut least = 0;
        for layer in 0..LAYERS {
            let mut accesses = [0; 2];
            for Fragment { x, y, z, .. } in &frame[layer as usize * 384..][..384] {
                let pixel = y * 24 + x;
                for before in 0..layer {
                    let nearer = *z <= depth(*x, *y, before);
                    accesses[usize::from(outside(pixel, before))] += 1 + u64::from(nearer);
                }
                accesses[usize::from(outside(pixel, layer))] += 1;
            }
            least += accesses[0].max(accesses[1]).max(384 * u64::from(layer));
        }
        let store = run.tally.cycles.of("store").unwrap();
        let most = least + least / 20 + latency;
        assert!(
            (least..=most).contains(&store),
            "{store} cycles, {least} at least: {overflow}, {latency}"
        );
    }
}
