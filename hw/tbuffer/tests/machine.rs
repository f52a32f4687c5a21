//! The T-buffer against the golden model.

use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine::{Failure, Fragments};
use pellucid_machine_properties::frames::{
    Setup, check_drops, effort, from_line_to_line, one_frame, some_frames, tried, without_place,
};
use pellucid_machine_properties::machine_properties;
use pellucid_machine_properties::presets::{assert_rate, papers_frames_at_the_target_rate};
use pellucid_sim::Label;
use pellucid_tbuffer::architecture::ARCHITECTURE;
use pellucid_testbench::bench::{Bench, BenchError};
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

fn sections(on_chip: u32, outside: u32) -> Parameterised {
    vec![("sections", on_chip.to_string()), ("outside_sections", outside.to_string())]
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn a_full_machine_drops_what_finds_no_section(
        (setup, frame) in one_frame(&ARCHITECTURE), on_chip in 1..20u32, outside in 0..20u32,
    ) {
        let setup = setup.with(sections(on_chip, outside));
        let capacity = setup.number("section_capacity");
        let dropped = without_place(setup.screen(), &frame, on_chip + outside, capacity, false);
        check_drops(&setup, &frame, &dropped)?;
    }

    /// A frame has all sections back before the next one begins, and takes none outside while one on chip is
    /// free.
    #[test]
    fn as_many_sections_as_the_largest_frame_takes_are_enough(
        (setup, frames) in some_frames(&ARCHITECTURE, 3), on_chip: prop::sample::Index,
    ) {
        let capacity = u64::from(setup.number("section_capacity"));
        let taken = |frame: &Vec<Fragment>| -> u64 {
            setup.golden(frame).census().layers().map(|(n, i)| n * i.div_ceil(capacity)).sum()
        };
        let most = frames.iter().map(taken).max().unwrap();
        let on_chip = 1 + on_chip.index(most.max(1) as usize) as u32;
        let outside = (most as u32).saturating_sub(on_chip);
        let setup = setup.with(sections(on_chip, outside));
        setup.judged(&frames, || {
            let run = tried(setup.run(&frames))?;
            prop_assert_eq!(run.tally.fragments.dropped, 0);
            let peaks = ["peak_sections", "peak_outside_sections"].map(|name| run.tally.figure(name));
            prop_assert_eq!(peaks, [most, outside.into()]);
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
    let mut parameters = sections(layers, 0);
    parameters.push(("section_capacity", "1".into()));
    parameters.push(("sorter_depth", layers.to_string()));
    let setup = Setup::free(&ARCHITECTURE, screen, parameters);
    let run = setup.run(&[frame.clone(), frame]).unwrap();
    let Fragments { stored, dropped, .. } = run.tally.fragments;
    assert_eq!([stored, dropped], [2 * u64::from(layers), 0]);
}

/// Whatever the latency, as long as so many reads are in flight: what counts are the words that the port moves, those of a
/// line in and out for each pixel of a frame that comes back to none of its lines.
#[test]
fn an_ssa_table_outside_costs_words_and_no_latency() {
    let screen = Screen { width: 64, height: 48, background: 0 };
    let (pixels, line) = (screen.pixels(), 4);
    let frame = from_line_to_line(screen, line);
    let cycles = |latency: u32| {
        let mut parameters = sections(pixels, 0);
        parameters.extend([
            ("ssa", "cached".to_string()),
            ("ssa_sets", "128".to_string()),
            ("ssa_ways", "4".to_string()),
            ("ssa_line", line.to_string()),
            ("outside_latency", latency.to_string()),
            ("reads_in_flight", latency.max(2).to_string()),
        ]);
        let setup = Setup::free(&ARCHITECTURE, screen, parameters);
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.tally.figure("ssa_misses"), u64::from(pixels + pixels / line));
        run.tally.cycles.of("store").unwrap()
    };
    // The first lines of all leave clean ones, or none; then each that comes sends one away.
    let words = u64::from(2 * pixels * line - 512 * line);
    for latency in [1, 64, 256] {
        let cycles = cycles(latency);
        assert!(
            (words..=words + words / 20).contains(&cycles),
            "{latency}: {cycles}, {words} words"
        );
    }
}

#[test]
fn a_display_that_takes_nothing_is_named() {
    let screen = Screen { width: 4, height: 4, background: 0 };
    let mut bench = Bench::new(&*Setup::free(&ARCHITECTURE, screen, vec![]).model);
    bench.set_display(|_| false);
    bench.send(&Fragment { x: 1, y: 2, z: 3, rgba: 0x80, label: Label::NONE }.into()).unwrap();
    let error = bench.end_frame().unwrap_err();
    let BenchError::Failure(failure) = &error else { panic!("{error}") };
    assert!(matches!(**failure, Failure::Deadlock(_)), "{error}");
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
    let setup = Setup::free(&ARCHITECTURE, screen, vec![]);
    let run = setup.run(std::slice::from_ref(&frame)).unwrap();
    assert_eq!(run.images[0], setup.golden_image(&frame));
    let store = run.tally.cycles.of("store").unwrap();
    assert_rate("stored", run.tally.fragments.stored, store, 0.98);
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    papers_frames_at_the_target_rate(&ARCHITECTURE, "fast");
}

/// A frame buffer outside, that covers the latency.
fn framebuffer(screen: Screen, latency: u32) -> Setup {
    let mut parameters = sections(8 * screen.pixels(), 0);
    parameters.extend([
        ("framebuffer", "cached".to_string()),
        ("framebuffer_sets", "64".to_string()),
        ("outside_latency", latency.to_string()),
        ("reads_in_flight", (latency + 8).to_string()),
    ]);
    Setup::free(&ARCHITECTURE, screen, parameters)
}

/// Pixels that hold nothing are not read: without opaque fragments words go for the pixels that are written, once, and come as they
/// are shown, and cycles are those on chip but for the latency of the first word.
#[test]
fn a_frame_buffer_outside_is_not_read_where_nothing_is_opaque() {
    let screen = Screen { width: 64, height: 48, background: 0x10_20_30 };
    let frame: Vec<Fragment> = (0..5000u32)
        .map(|k| {
            let pixel = k * 7919 % 2048;
            Fragment { x: pixel % 64, y: pixel / 64, z: k, rgba: k << 8 | 0x70, label: Label::NONE }
        })
        .collect();
    // Either bank is used again after it was shown.
    const FRAMES: u64 = 4;
    let frames = vec![frame.clone(); FRAMES as usize];
    for latency in [1, 64, 256] {
        let setup = framebuffer(screen, latency);
        let run = setup.run(&frames).unwrap();
        assert_eq!(run.images, vec![setup.golden_image(&frame); FRAMES as usize]);
        let info = run.tally.memory("front.pixels.outside").unwrap().info;
        // Both banks are cleared after the reset.
        let cleared = 2 * u64::from(screen.pixels());
        assert_eq!([info.reads, info.writes - cleared], [FRAMES * 2048; 2], "{latency}");
        assert_eq!(run.tally.figure("framebuffer_misses"), 0);
        let of = |phase| run.tally.cycles.of(phase).unwrap();
        let free = FRAMES * 5000;
        assert!((free..free + 10 * FRAMES).contains(&of("store")), "{latency}: {}", of("store"));
        let late = FRAMES * 60;
        assert!((free..free + late).contains(&of("resolve")), "{latency}: {}", of("resolve"));
    }
}

/// What is opaque costs words of the port, and no latency: fragments of several pixels wait together, as long as the cache's 256 lines
/// are enough for them.
#[test]
fn a_frame_buffer_outside_costs_words_and_no_latency() {
    let screen = Screen { width: 64, height: 48, background: 0 };
    let frame: Vec<Fragment> = (0..20_000u32)
        .map(|k| {
            let pixel = k * 7919 % 3072;
            let alpha = if k % 2 == 0 { 0xff } else { 0x70 };
            let z = k * 7907 % 65_536;
            Fragment { x: pixel % 64, y: pixel / 64, z, rgba: k << 8 | alpha, label: Label::NONE }
        })
        .collect();
    let cycles = |latency: u32| {
        let setup = framebuffer(screen, latency);
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame), "{latency}");
        let of = |phase| run.tally.cycles.of(phase).unwrap();
        of("store") + of("resolve")
    };
    let least = cycles(1);
    for latency in [16, 64] {
        let more = cycles(latency);
        assert!(more < least + least / 20 + 4 * u64::from(latency), "{latency}: {least}, {more}");
    }
}
