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
    // Five cycles to fill and empty the pipeline, one for the first fragment.
    let near_to_far: u64 = 5 + 1 + (1..6).map(|i| i + 2).sum::<u64>();
    let far_to_near: u64 = 5 + 1 + (1..6).map(|i| i + 2 + i - 1).sum::<u64>();
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
