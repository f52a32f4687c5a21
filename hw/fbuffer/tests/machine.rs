//! The F-buffer against the golden model.

use pellucid_fbuffer::architecture::ARCHITECTURE;
use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine::{Item, Tally};
use pellucid_machine_properties::frames::{Setup, effort, one_frame, tried};
use pellucid_machine_properties::machine_properties;
use pellucid_sim::Label;
use pellucid_test_util::{Triangle, primitive};
use pellucid_testbench::bench::Bench;
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

const SCREEN: Screen = Screen { width: 5, height: 4, background: 0 };

fn with(settings: &[(&'static str, &str)]) -> Parameterised {
    settings.iter().map(|(name, value)| (*name, (*value).to_string())).collect()
}

fn setup(settings: &[(&'static str, &str)]) -> Setup {
    Setup::free(&ARCHITECTURE, SCREEN, with(settings))
}

/// So many transparent points, one after the other over the screen.
fn points(count: u32) -> Vec<Fragment> {
    let point = |k: u32| Fragment {
        x: k % SCREEN.width,
        y: k / SCREEN.width % SCREEN.height,
        z: k * 977 % Z_FAR,
        rgba: (k * 0x10_4f_21) << 8 | 0x60,
        label: Label::NONE,
    };
    (0..count).map(point).collect()
}

fn tally(settings: &[(&'static str, &str)], frame: &[Fragment]) -> Tally {
    let setup = setup(settings);
    let run = setup.run(&[frame.to_vec()]).unwrap();
    let verdict = setup.verdict(&run, &[setup.golden(frame)]);
    assert!(verdict.is_right(), "{:?}", verdict.faults());
    run.tally
}

fn figures<const N: usize>(tally: &Tally, names: [&str; N]) -> [u64; N] {
    names.map(|name| tally.figure(name))
}

/// The paper's Figure 1: a cyan triangle behind a yellow one, each half transparent, drawn in two passes of which the first stores the
/// colour. Stored at its pixel, the yellow one's takes the place of the cyan one's where they overlap.
#[test]
fn two_triangles_in_two_passes() {
    const HALF: u32 = 128;
    let (cyan, yellow) = (0x00_ff_ff_00 | HALF, 0xff_ff_00_00 | HALF);
    let at = |x, z, rgba| Fragment { x, y: 0, z, rgba, label: Label::NONE };
    let frame = [at(0, 20, cyan), at(1, 20, cyan), at(1, 10, yellow), at(2, 10, yellow)];
    let image = |store| {
        let setup = setup(&[("program", "restore"), ("store", store)]);
        setup.image(&frame).unwrap().pixels[..3].to_vec()
    };
    // Half of 255 is 128; yellow over that is 128 + 127 * 0/255, 128 + 127 * 128/255 = 191.7, 127 * 128/255 = 63.7.
    let (cyan, yellow) = (0x00_80_80, 0x80_80_00);
    assert_eq!(image("fbuffer"), [cyan, 0x80_c0_40, yellow]);
    // Yellow over yellow.
    assert_eq!(image("framebuffer"), [cyan, 0xc0_c0_00, yellow]);
}

#[test]
fn a_scene_from_back_to_front_is_exact() {
    let mut frame = points(70);
    frame.sort_by_key(|f| Z_FAR - f.z);
    for program in ["tint", "restore"] {
        let setup = setup(&[("program", program), ("size", "4")]);
        assert_eq!(setup.image(&frame).unwrap(), setup.golden(&frame).image);
    }
}

#[test]
fn a_submission_for_each_pass_of_each_window() {
    let names = ["fragments", "windows", "submissions", "vertices", "shaded", "discarded"];
    for (count, windows) in [(0, 1), (1, 1), (16, 1), (17, 2), (100, 7)] {
        let tally = tally(&[("size", "4"), ("program", "glass")], &points(count as u32));
        let submissions = 3 * windows;
        let expected = [
            count,
            windows,
            submissions,
            3 * count * submissions,
            3 * count,
            3 * count * (windows - 1),
        ];
        assert_eq!(figures(&tally, names), expected, "{count} fragments");
    }
    // One pass: no window, and the background comes before.
    let tally = tally(&[("size", "4"), ("program", "tint")], &points(100));
    assert_eq!(figures(&tally, names), [100, 1, 2, 600, 100, 0]);
}

/// Each play takes as long as the larger of its two terms, point by point, and a few cycles in which its end goes through.
#[test]
fn a_play_is_bound_by_vertices_or_by_fragments() {
    let cycles = |count: u32, vertex: u32, fragment: u32| {
        let (vertex, fragment) = (vertex.to_string(), fragment.to_string());
        let settings = [
            ("program", "glass"),
            ("size", "4"),
            ("vertex_cycles", vertex.as_str()),
            ("fragment_cycles", fragment.as_str()),
        ];
        let cycles = tally(&settings, &points(count)).cycles;
        [cycles.total, cycles.of("store").unwrap(), cycles.of("resolve").unwrap()]
    };
    for (vertex, fragment) in [(1, 1), (2, 1), (1, 7), (2, 9)] {
        // Eight points more, in two passes that store and in the last one.
        let of_point = u64::from((3 * vertex).max(fragment));
        let (many, few) = (cycles(16, vertex, fragment), cycles(8, vertex, fragment));
        let more = [0, 1, 2].map(|k| many[k] - few[k]);
        assert_eq!(more, [3, 2, 1].map(|plays| plays * 8 * of_point), "{vertex} {fragment}");
    }
}

#[test]
fn early_depth_saves_windows() {
    // Half of them are behind an opaque plane.
    let opaque = (0..SCREEN.width * SCREEN.height).map(|pixel| Fragment {
        x: pixel % SCREEN.width,
        y: pixel / SCREEN.width,
        z: 50,
        rgba: 0x40_40_40_ff,
        label: Label::NONE,
    });
    let transparent = points(80)
        .into_iter()
        .zip(0..)
        .map(|(f, k)| Fragment { z: if k % 2 == 0 { 10 } else { 60 }, ..f });
    let frame: Vec<Fragment> = transparent.chain(opaque).collect();
    let names = ["fragments", "windows", "submissions"];
    let of = |early| {
        let settings = [("size", "4"), ("program", "glass"), ("early_depth", early)];
        figures(&tally(&settings, &frame), names)
    };
    assert_eq!(of("off"), [80, 5, 15]);
    // And a play for the opaque ones.
    assert_eq!(of("before_window"), [40, 3, 10]);
}

/// Plays of batches, by their definition.
fn batches(primitives: &[bool], places: usize) -> (u64, u64) {
    let (mut first, mut length, mut batches, mut wasted) = (0, usize::MAX, 0, 0);
    loop {
        let end = primitives.len().min(usize::saturating_add(first, length));
        let transparent = primitives[first..end].iter().filter(|transparent| **transparent).count();
        if transparent > places && end - first > 1 {
            length = (end - first).div_ceil(2);
            wasted += 1;
            continue;
        }
        batches += 1;
        first = end;
        if first == primitives.len() {
            return (batches, wasted);
        }
    }
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn batches_are_halved_until_they_fit((setup, frame) in one_frame(&ARCHITECTURE), side in 2..4u32) {
        let setup = setup.with(with(&[
            ("program", "glass"), ("overflow", "batch"), ("mode", "shade"), ("store", "fbuffer"), ("early_depth", "off"),
            ("size", &(1 << side).to_string()),
        ]));
        let transparent: Vec<bool> = frame.iter().map(|f| !f.is_opaque()).collect();
        let (windows, wasted) = batches(&transparent, 1 << (2 * side));
        let frames = [frame];
        setup.judged(&frames, || {
            let run = tried(setup.run(&frames))?;
            let found = figures(&run.tally, ["windows", "wasted_passes", "submissions"]);
            prop_assert_eq!(found, [windows, wasted, 3 * windows + wasted]);
            Ok(())
        })?;
    }
}

/// A triangle of 6 pixels and 4 places: the last two fragments of it are lost, and the run says so.
#[test]
fn a_primitive_with_more_fragments_than_places_loses_some() {
    let triangle = Triangle {
        corners: [(0, 0), (4 * 256, 0), (0, 4 * 256)],
        colour: [255, 255, 255, 128].map(|channel| [channel << 16, 0, 0]),
        ..Triangle::default()
    };
    let item = Item::from(primitive(SCREEN, &triangle));
    let drawn = |overflow| {
        let setup = setup(&[("program", "restore"), ("size", "2"), ("overflow", overflow)]);
        let mut bench = Bench::new(&*setup.model);
        bench.frame(|bench| bench.send(&item)).unwrap();
        bench.wait_for(1, |_, _| Ok(())).unwrap();
        let image = bench.take_images().remove(0);
        let tally = bench.tally();
        let lit = image.pixels.iter().filter(|pixel| **pixel == 0x80_80_80).count();
        (lit as u64, tally.fragments.blended, tally.fragments.dropped)
    };
    let (lit, blended, dropped) = drawn("window");
    assert_eq!((lit, dropped), (blended, 0));
    assert!(blended > 4);
    assert_eq!(drawn("batch"), (4, 4, blended - 4));
}

/// Sorted, any order of arrival gives the exact image; in one window with the passes of the network, or in as many rounds as
/// there are windows.
#[test]
fn a_sort_is_exact_whatever_the_order() {
    let names = ["windows", "submissions", "sort_passes"];
    // 100 fragments are padded to 128: 7 * 8 / 2 passes.
    for (size, windows, rounds) in [("16", 1, 1), ("8", 2, 2), ("4", 7, 7)] {
        for program in ["tint", "restore"] {
            let frame = points(100);
            let settings =
                [("mode", "sort"), ("program", program), ("size", size), ("sorter_lanes", "2")];
            let setup = setup(&settings);
            assert_eq!(setup.image(&frame).unwrap(), setup.golden(&frame).image);
            let [found, submissions, sort_passes] = figures(&tally(&settings, &frame), names);
            assert_eq!(found, windows * rounds);
            let passes = if program == "tint" { 1 } else { 2 };
            assert_eq!(submissions, 1 + found * passes);
            if windows == 1 {
                assert_eq!(sort_passes, 28);
            }
        }
    }
}
