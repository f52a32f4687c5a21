//! The M-buffer.

use crate::frames::{
    ENOUGH, Setup, Tested, allocator, check_drops, effort, one_frame, properties, tried,
    without_place,
};
use crate::presets::papers_frames_at_the_target_rate;
use pellucid_hw::allocator::{Allocator, Chosen};
use pellucid_hw::machine::Tally;
use pellucid_hw::mbuffer::MBuffer;
use pellucid_hw::mbuffer::config::{Config, Params, Weights};
use pellucid_hw::pixel::{Fragment, Screen};
use pellucid_hw::tbuffer::config::Scan;
use pellucid_sim::Label;
use proptest::prelude::*;

type Buffer = MBuffer<Chosen>;

impl<A: Allocator> Tested for MBuffer<A> {
    fn machines(screen: Screen) -> BoxedStrategy<Config> {
        params().prop_map(move |params| Config::new(screen, params).unwrap()).boxed()
    }

    fn resolved(tally: &Tally) -> [u64; 2] {
        let [read, again, idle] =
            ["fragments_read", "fragments_read_again", "array_idle"].map(|name| tally.figure(name));
        [read + again, idle]
    }
}

properties!(Buffer);

/// Parameters with which no fragment of a random frame is dropped.
fn params() -> impl Strategy<Value = Params> {
    let flags = (any::<bool>(), any::<bool>(), allocator());
    let depths = (1..=5u32, prop_oneof![1..=9u32, Just(32)]);
    let sections = prop_oneof![
        3 => (0..=30u32).prop_map(|s| (s, ENOUGH)),
        1 => Just((ENOUGH, 0)),
    ];
    (flags, depths, sections, (1..=20u32, 2..=9u32)).prop_map(
        |((memory, bitmap, allocator), (section_capacity, array), sections, outside)| Params {
            weights: if memory { Weights::Memory } else { Weights::Registers },
            allocator,
            scan: if bitmap { Scan::Bitmap } else { Scan::Linear },
            section_capacity,
            array,
            overflow_sections: sections.0,
            outside_sections: sections.1,
            outside_latency: outside.0,
            reads_in_flight: outside.1,
        },
    )
}

proptest! {
    #![proptest_config(effort())]

    /// Wherever the weights are kept and however many cells there are, the image is the same.
    #[test]
    fn weights_in_registers_and_in_memory_are_the_same(
        (setup, frame) in one_frame::<Buffer>(),
        array in 1..=32u32,
    ) {
        let screen = setup.screen();
        let params = |weights| Params { weights, array, ..setup.cfg.params };
        let images = [Weights::Registers, Weights::Memory].map(|weights| {
            let cfg = Config::new(screen, params(weights)).unwrap();
            Setup::<Buffer> { cfg, ..setup }.run(std::slice::from_ref(&frame))
        });
        let [registers, memory] = images.map(|run| tried(run).map(|run| run.images));
        prop_assert_eq!(registers?, memory?);
    }

    #[test]
    fn a_full_machine_drops_what_finds_no_section(
        (mut setup, frame) in one_frame::<Buffer>(), sections in 0..20u32, outside in 0..20u32,
    ) {
        let Config { screen, params, .. } = setup.cfg;
        let params = Params { overflow_sections: sections, outside_sections: outside, ..params };
        setup.cfg = Config::new(screen, params).unwrap();
        let capacity = params.section_capacity;
        let dropped = without_place(screen, &frame, sections + outside, capacity, true);
        check_drops(&setup, &frame, &dropped)?;
    }
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    papers_frames_at_the_target_rate("mbuffer", "registers");
}

/// Fragments of one pixel, far to near or near to far: how many cycles store takes with weights in memory.
#[test]
fn comparing_on_arrival_takes_the_cycles_that_it_is_said_to() {
    let screen = Screen { width: 4, height: 4, background: 0 };
    let params = Params { weights: Weights::Memory, ..Params::default() };
    let setup = Setup::<Buffer>::free(Config::new(screen, params).unwrap());
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
        assert_eq!(run.tally.cycles.store, store);
        let counted = ["compared", "weights_changed"].map(|name| run.tally.figure(name));
        assert_eq!(counted, [15, changed]);
    }
}
