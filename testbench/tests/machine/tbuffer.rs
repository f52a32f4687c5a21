//! The T-buffer.

use crate::frames::{
    ENOUGH, Setup, Tested, allocator, check_drops, effort, one_frame, properties, some_frames,
    tried, without_place,
};
use crate::presets::{assert_rate, papers_frames_at_the_target_rate};
use pellucid_hw::allocator::{Allocator, Chosen};
use pellucid_hw::machine::{Fragments, Tally};
use pellucid_hw::pixel::{Fragment, Marked, Screen};
use pellucid_hw::tbuffer::TBuffer;
use pellucid_hw::tbuffer::config::{Append, Config, Params, Scan};
use pellucid_sim::Label;
use pellucid_testbench::bench::{Bench, BenchError};
use proptest::prelude::*;

type Buffer = TBuffer<Chosen>;

impl<A: Allocator> Tested for TBuffer<A> {
    fn machines(screen: Screen) -> BoxedStrategy<Config> {
        params().prop_map(move |params| Config::new(screen, params).unwrap()).boxed()
    }

    fn resolved(tally: &Tally) -> [u64; 2] {
        [tally.fragments.blended, tally.figure("blender_idle")]
    }
}

properties!(Buffer);

/// Parameters with which no fragment of a random frame is dropped.
fn params() -> impl Strategy<Value = Params> {
    let flags = (any::<bool>(), any::<bool>(), allocator());
    let depths = (1..=5u32, prop_oneof![1..=9u32, Just(64)]);
    let sections = prop_oneof![
        3 => (1..=30u32).prop_map(|s| (s, ENOUGH)),
        1 => Just((ENOUGH, 0)),
    ];
    (flags, depths, sections, (1..=20u32, 2..=9u32)).prop_map(
        |((tail, bitmap, allocator), (section_capacity, sorter_depth), sections, outside)| Params {
            append: if tail { Append::Tail } else { Append::Walk },
            scan: if bitmap { Scan::Bitmap } else { Scan::Linear },
            allocator,
            section_capacity,
            sorter_depth,
            sections: sections.0,
            outside_sections: sections.1,
            outside_latency: outside.0,
            reads_in_flight: outside.1,
        },
    )
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn a_full_machine_drops_what_finds_no_section(
        (mut setup, frame) in one_frame::<Buffer>(), sections in 1..20u32, outside in 0..20u32,
    ) {
        let Config { screen, params, .. } = setup.cfg;
        let params = Params { sections, outside_sections: outside, ..params };
        setup.cfg = Config::new(screen, params).unwrap();
        let capacity = params.section_capacity;
        let dropped = without_place(screen, &frame, sections + outside, capacity, false);
        check_drops(&setup, &frame, &dropped)?;
    }

    /// A frame has all sections back before the next one begins, and takes none outside while one on chip is
    /// free.
    #[test]
    fn as_many_sections_as_the_largest_frame_takes_are_enough(
        (mut setup, frames) in some_frames::<Buffer>(), on_chip: prop::sample::Index,
    ) {
        let Config { screen, params, .. } = setup.cfg;
        let capacity = u64::from(params.section_capacity);
        let taken = |frame: &Vec<Fragment>| -> u64 {
            setup.golden(frame).census().layers().map(|(n, i)| n * i.div_ceil(capacity)).sum()
        };
        let most = frames.iter().map(taken).max().unwrap();
        let sections = 1 + on_chip.index(most.max(1) as usize) as u32;
        let outside_sections = (most as u32).saturating_sub(sections);
        setup.cfg = Config::new(screen, Params { sections, outside_sections, ..params }).unwrap();
        setup.judged(&frames, || {
            let run = tried(setup.run(&frames))?;
            prop_assert_eq!(run.tally.fragments.dropped, 0);
            let peaks = ["peak_sections", "peak_outside_sections"].map(|name| run.tally.figure(name));
            prop_assert_eq!(peaks, [most, outside_sections.into()]);
            Ok(())
        })?;
    }
}

/// What a later opaque fragment hides is not sorted, so the pixel is written at once; its sections still go
/// back one a cycle.
#[test]
fn the_sections_of_hidden_fragments_are_back_for_the_next_frame() {
    let screen = Screen { width: 1, height: 1, background: 0 };
    let layers = 32;
    let fragment = |z, rgba| Fragment { x: 0, y: 0, z, rgba, label: Label::NONE };
    let hidden = (1..=layers).map(|z| fragment(z, 0x80));
    let frame: Vec<Fragment> = hidden.chain([fragment(0, 0xff)]).collect();
    let params = Params {
        sections: layers,
        outside_sections: 0,
        section_capacity: 1,
        sorter_depth: layers,
        ..Params::default()
    };
    let setup = Setup::<Buffer>::free(Config::new(screen, params).unwrap());
    let run = setup.run(&[frame.clone(), frame]).unwrap();
    let Fragments { stored, dropped, .. } = run.tally.fragments;
    assert_eq!([stored, dropped], [2 * u64::from(layers), 0]);
}

#[test]
fn a_display_that_takes_nothing_is_named() {
    let screen = Screen { width: 4, height: 4, background: 0 };
    let mut bench = Bench::<Buffer>::new(Config::new(screen, Params::default()).unwrap());
    bench.set_display(|_| false);
    bench
        .send(Marked::item(Fragment { x: 1, y: 2, z: 3, rgba: 0x80, label: Label::NONE }))
        .unwrap();
    let error = bench.end_frame().unwrap_err();
    assert!(matches!(error, BenchError::Deadlock(_)), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("the simulation stands still, cycle "), "{text}");
    assert!(
        text.ends_with("\n  scanout (state Run) waits for display to take from `image`"),
        "{text}"
    );
}

#[test]
fn long_runs_of_one_pixel_are_stored_one_a_cycle() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let frame: Vec<Fragment> = (0..screen.pixels())
        .flat_map(|pixel| {
            let (x, y) = (pixel % screen.width, pixel / screen.width);
            (0..32).map(move |k| Fragment {
                x,
                y,
                z: k * 7919 % 32,
                rgba: k << 8 | 0x7f,
                label: Label::NONE,
            })
        })
        .collect();
    let cfg = Config::new(screen, Params::default()).unwrap();
    let setup = Setup::<Buffer>::free(cfg);
    let run = setup.run(std::slice::from_ref(&frame)).unwrap();
    assert_eq!(run.images[0], setup.golden_image(&frame));
    assert_rate("stored", run.tally.fragments.stored, run.tally.cycles.store, 0.98);
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    papers_frames_at_the_target_rate("tbuffer", "fast");
}
