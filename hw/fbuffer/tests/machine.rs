//! The F-buffer against the golden model.

use pellucid_fbuffer::architecture::ARCHITECTURE;
use pellucid_fbuffer::golden;
use pellucid_fbuffer::program::{Kind, Program};
use pellucid_machine::architecture::Parameterised;
use pellucid_machine::arithmetic::Unshaded;
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine::{Item, Tally};
use pellucid_machine_properties::framebuffers::lines_come_once;
use pellucid_machine_properties::frames::{Setup, effort, one_frame, opaque_depth, tried};
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

/// While one is shaded, those that were killed before are passed over.
#[test]
fn what_is_discarded_comes_while_another_one_is_shaded() {
    let settings =
        [("program", "sieve"), ("kill", "compact"), ("size", "64"), ("fragment_cycles", "7")];
    let tally = tally(&settings, &points(2000));
    let [shaded, discarded] = figures(&tally, ["shaded", "discarded"]);
    assert!(discarded > 300, "{discarded}");
    assert!(tally.cycles.total < 7 * shaded + discarded, "{shaded} {discarded}");
}

/// With the F-buffer outside there is a third term: what its port moves. A word of `sieve` has 129 bits, of `glass` with three targets 384.
#[test]
fn a_play_is_bound_by_the_port_too() {
    let cycles = |count: u32, program, vertex: u32, latency: u32, in_flight: u32| {
        let numbers = [vertex, latency, in_flight].map(|number| number.to_string());
        let settings = [
            ("program", program),
            ("buffer", "outside"),
            ("targets", if program == "glass" { "3" } else { "1" }),
            ("size", "32"),
            ("vertex_cycles", numbers[0].as_str()),
            ("outside_latency", numbers[1].as_str()),
            ("reads_in_flight", numbers[2].as_str()),
        ];
        tally(&settings, &points(count)).cycles.total
    };
    for (program, parts) in [("sieve", 2), ("glass", 3)] {
        for vertex in [1, 3] {
            for latency in [1, 100] {
                let of = |count| cycles(count, program, vertex, latency, latency + 8);
                let more = of(1000) - of(500);
                // The first pass writes, the second one reads and writes, the last one reads.
                let of_pass = |ways: u64| (3 * u64::from(vertex)).max(ways * parts);
                let expected = 500 * (of_pass(1) + of_pass(2) + of_pass(1));
                // The latency is not among it, but for where a pass begins and ends.
                let around = u64::from(latency) + 8;
                assert!(more.abs_diff(expected) <= around, "{more}: {program} {vertex} {latency}");
            }
        }
    }
    // Two reads in flight bring two words in a latency.
    let more = cycles(1000, "glass", 1, 200, 2) - cycles(500, "glass", 1, 200, 2);
    assert!(more > 2 * 500 * 100, "{more}");
}

/// Wherever it lies: the same image, the same passes, and as many words as the closed forms say, which `tally` holds them to.
#[test]
fn an_f_buffer_outside_is_as_one_on_chip() {
    let names = ["windows", "submissions", "shaded", "spared", "discarded", "wasted_passes"];
    for (program, settings) in [
        ("restore", &[][..]),
        ("glass", &[("early_depth", "before_window")][..]),
        ("glass", &[("overflow", "batch"), ("targets", "4")][..]),
        ("sieve", &[("component_bits", "8")][..]),
        ("sieve", &[("kill", "compact")][..]),
        ("sieve", &[("kill", "compact"), ("overflow", "batch"), ("targets", "2")][..]),
    ] {
        let of = |buffer| {
            let all =
                [&[("program", program), ("buffer", buffer), ("size", "4")], settings].concat();
            let frame = points(75);
            let image = setup(&all).image(&frame).unwrap();
            (image, figures(&tally(&all, &frame), names))
        };
        assert_eq!(of("outside"), of("on_chip"), "{program} {settings:?}");
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

/// Whether a program, or its first pass alone, kills a fragment.
fn is_killed(program: &Program, of: &Fragment) -> bool {
    let Fragment { x, y, z, rgba, .. } = *of;
    golden::run(program, 16, Unshaded { x, y, z, rgba }).is_none()
}

/// Windows over fragments of which the first pass kills some, by their definition: each ends where its survivors take the last place.
fn windows_of_survivors(killed: &[bool], places: usize) -> u64 {
    let (mut windows, mut left) = (1, 0);
    for killed in killed {
        if left == places {
            windows += 1;
            left = 0;
        }
        left += usize::from(!killed);
    }
    windows
}

proptest! {
    #![proptest_config(effort())]

    /// For any buffer, any fragments and any program: those that it kills as a whole are missing, and no other; and where they leave
    /// their places to others there are no more windows than these need.
    #[test]
    fn what_a_program_kills_is_missing(
        (setup, frame) in one_frame(&ARCHITECTURE),
        side in 1..4u32,
        seed in prop::option::of(0..1000u32),
        early: bool,
    ) {
        let (kind, name) = if seed.is_some() { (Kind::Random, "random") } else { (Kind::Sieve, "sieve") };
        let seed = seed.unwrap_or_default();
        let program = Program::new(kind, seed, 2);
        let visible = |f: &&Fragment| !early || f.z < opaque_depth(&frame, f);
        let come: Vec<&Fragment> =
            frame.iter().filter(|f| !f.is_opaque()).filter(visible).collect();
        let first = Program { count: 1, ..program };
        let killed_at_once: Vec<bool> = come.iter().map(|f| is_killed(&first, f)).collect();
        let killed = come.iter().filter(|f| is_killed(&program, f)).count() as u64;
        let places = 1 << (2 * side);
        let keeping = come.len().div_ceil(places).max(1) as u64;
        let compacting = windows_of_survivors(&killed_at_once, places);
        for (kill, windows) in [("keep", keeping), ("compact", compacting)] {
            let framebuffer = if early { vec![("framebuffer", "on_chip")] } else { vec![] };
            let setup = setup.with(with(&framebuffer)).with(with(&[
                ("program", name), ("seed", &seed.to_string()), ("targets", "2"), ("component_bits", "16"),
                ("mode", "shade"), ("store", "fbuffer"), ("overflow", "window"), ("kill", kill),
                ("early_depth", if early { "before_window" } else { "off" }),
                ("size", &(1 << side).to_string()),
            ]));
            let frames = [frame.clone()];
            setup.judged(&frames, || {
                let run = tried(setup.run(&frames))?;
                let verdict = setup.verdict(&run, &[setup.golden(&frame)]);
                prop_assert!(verdict.is_right(), "{:?}", verdict.faults());
                prop_assert_eq!(run.tally.fragments.killed, killed, "{}", kill);
                prop_assert_eq!(run.tally.figure("windows"), windows, "{}", kill);
                Ok(())
            })?;
        }
    }
}

/// `sieve` over a screen of one tile: 121 of 256 fragments are killed in the first pass, and those of an alpha below 32 in the second one.
#[test]
fn what_is_killed_leaves_its_place_to_others() {
    const TILE: Screen = Screen { width: 16, height: 16, background: 0 };
    let thin = |x: u32, y: u32| (x, y) == (0, 0) || (x, y) == (15, 15);
    let frame: Vec<Fragment> = (0..256)
        .map(|k| (k % 16, k / 16))
        .map(|(x, y)| {
            let alpha = if thin(x, y) { 31 } else { 200 };
            Fragment { x, y, z: 0, rgba: 0xff_80_40_00 | alpha, label: Label::NONE }
        })
        .collect();
    let names = ["windows", "submissions", "shaded", "spared", "discarded"];
    let of = |settings: &[(&'static str, &str)]| {
        let settings = [&[("program", "sieve"), ("size", "8")], settings].concat();
        let setup = Setup::free(&ARCHITECTURE, TILE, with(&settings));
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        let verdict = setup.verdict(&run, &[setup.golden(&frame)]);
        assert!(verdict.is_right(), "{:?}", verdict.faults());
        assert_eq!(run.tally.fragments.killed, 123);
        (figures(&run.tally, names), run.tally.memory("buffer.words").unwrap().info.writes)
    };
    // 64 places: 256 fragments take four windows, the 135 that are left after the first pass three.
    assert_eq!(of(&[]), ([4, 12, 768, 0, 2304], 512));
    let spared = 2 * 121 + 2;
    let shaded = 768 - spared;
    // After the first pass 135 words are written, after the second one 133.
    assert_eq!(of(&[("kill", "compact")]), ([3, 9, shaded, spared, 9 * 256 - shaded], 268));
    // Sorted: the 133 that are left take three rounds.
    let ([windows, ..], _) = of(&[("kill", "compact"), ("mode", "sort")]);
    assert_eq!(windows, 9);
    let ([windows, ..], _) = of(&[("mode", "sort")]);
    assert_eq!(windows, 12);
}

/// Of 18 fragments the first two are in the hole, at columns 3 and 4 of row 3: there are places for the 16 that are left, and not for all.
#[test]
fn a_batch_fits_by_what_is_left_of_it() {
    let frame: Vec<Fragment> =
        points(20).into_iter().rev().take(18).map(|f| Fragment { z: 0, ..f }).collect();
    let of = |kill| {
        let settings = [("program", "sieve"), ("size", "4"), ("overflow", "batch"), ("kill", kill)];
        let tally = tally(&settings, &frame);
        (figures(&tally, ["windows", "wasted_passes"]), tally.fragments.killed)
    };
    assert_eq!(of("keep"), ([2, 1], 2));
    assert_eq!(of("compact"), ([1, 0], 2));
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

#[test]
fn a_frame_buffer_outside_costs_words_and_no_latency() {
    for buffer in ["on_chip", "outside"] {
        lines_come_once(&ARCHITECTURE, &with(&[("buffer", buffer)]));
    }
}
