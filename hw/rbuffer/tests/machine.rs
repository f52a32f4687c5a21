//! The R-buffer against the golden model.

use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine_properties::framebuffers::lines_come_once;
use pellucid_machine_properties::frames::{
    ENOUGH, Setup, check_drops, effort, fragments, one_frame, screens, tried,
};
use pellucid_machine_properties::machine_properties;
use pellucid_machine_properties::presets::preset;
use pellucid_rbuffer::architecture::ARCHITECTURE;
use pellucid_sim::Label;
use pellucid_testbench::scene::{Options, built_in};
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

/// A queue of so many places, on chip and outside.
fn queue(on_chip: u32, outside: u32) -> Parameterised {
    vec![
        ("queue", on_chip.to_string()),
        ("outside_queue", outside.to_string()),
        ("overflow", "outside".to_string()),
    ]
}

/// A machine that asks for a frame again.
fn replaying(screen: Screen, queue: u32) -> Setup {
    Setup::free(&ARCHITECTURE, screen, with_replay(queue))
}

fn with_replay(queue: u32) -> Parameterised {
    vec![("queue", queue.to_string()), ("overflow", "replay".to_string())]
}

/// Which fragments of a frame find no place in a queue of `places`.
fn without_place(screen: Screen, frame: &[Fragment], places: u32) -> Vec<bool> {
    let mut nearest = vec![Z_FAR; screen.pixels() as usize];
    let mut free = places;
    let mut dropped = vec![];
    for f in frame {
        let nearest = &mut nearest[(f.y * screen.width + f.x) as usize];
        let visible = f.z < *nearest;
        if visible && f.is_opaque() {
            *nearest = f.z;
        }
        let stored = visible && !f.is_opaque();
        dropped.push(stored && free == 0);
        free -= u32::from(stored && free > 0);
    }
    dropped
}

/// What the transition table of the R-buffer does to a frame, pass after pass on plain lists: how many
/// passes there are, and how many fragments are popped.
fn passes(screen: Screen, frame: &[Fragment]) -> (u64, u64) {
    let mut opaque = vec![Z_FAR; screen.pixels() as usize];
    let mut queue = vec![];
    for f in frame {
        let pixel = (f.y * screen.width + f.x) as usize;
        if f.z >= opaque[pixel] {
        } else if f.is_opaque() {
            opaque[pixel] = f.z;
        } else {
            queue.push((pixel, f.z));
        }
    }
    let (mut passes, mut popped) = (0, 0);
    while !queue.is_empty() {
        let farthest = |pixel| queue.iter().filter(|f| f.0 == pixel).map(|f| f.1).max();
        let z1: Vec<Option<u32>> = (0..opaque.len()).map(farthest).collect();
        let mut blended = vec![false; opaque.len()];
        popped += queue.len() as u64;
        passes += 1;
        let first = passes == 1;
        queue.retain(|(pixel, z)| {
            // An opaque fragment that came later hides the farthest: this pass only culls.
            let hides = first && z1[*pixel] >= Some(opaque[*pixel]);
            let blend = !hides && !blended[*pixel] && z1[*pixel] == Some(*z);
            blended[*pixel] |= blend;
            !(blend || (hides && *z >= opaque[*pixel]))
        });
    }
    (passes, popped)
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn a_full_queue_drops_what_finds_no_room(
        (setup, frame) in one_frame(&ARCHITECTURE), on_chip in 2..40u32, outside in 0..40u32,
    ) {
        let setup = setup.with(queue(on_chip, outside));
        let dropped = without_place(setup.screen(), &frame, on_chip + outside);
        check_drops(&setup, &frame, &dropped)?;
    }

    #[test]
    fn passes_are_those_of_the_transition_table((setup, frame) in one_frame(&ARCHITECTURE)) {
        let setup = setup.with(vec![("queue", ENOUGH.to_string())]);
        let run = tried(setup.run(std::slice::from_ref(&frame)))?;
        let expected = passes(setup.screen(), &frame);
        prop_assert_eq!((run.tally.figure("passes"), run.tally.figure("popped")), expected);
    }

    /// A pass takes a cycle for each fragment and four more; a frame two more in all.
    #[test]
    fn one_fragment_leaves_the_queue_in_each_cycle(
        (screen, frame) in screens().prop_flat_map(|screen| (Just(screen), fragments(screen)))
    ) {
        let setup = Setup::free(&ARCHITECTURE, screen, queue(ENOUGH, 0));
        let run = tried(setup.run(std::slice::from_ref(&frame)))?;
        let (passes, popped) = passes(screen, &frame);
        prop_assert_eq!(run.tally.cycles.of("resolve"), Some(popped + 4 * passes + 2));
        prop_assert_eq!(&run.images[0], &setup.golden_image(&frame));
    }
}

/// Through outside memory resolve goes as fast as its port takes requests, a cycle for each, but for the latency at the
/// beginning of a pass; storing goes as fast as on chip.
#[test]
fn the_port_to_outside_memory_is_never_idle() {
    for scene in built_in().iter().filter(|scene| scene.name.starts_with("paper-")) {
        let [on_chip, outside] = ["on-chip", "outside"]
            .map(|name| preset(&ARCHITECTURE, scene.name, &Options::default(), name));
        let [free, cycles] = [&on_chip, &outside].map(|run| run.cycles.of("resolve").unwrap());
        assert_eq!(outside.cycles.of("store"), on_chip.cycles.of("store"), "{}", scene.name);
        let info = outside.memory("queue.outside").unwrap().info;
        let requests = info.reads + info.writes - outside.fragments.spilled;
        let passes = outside.figure("passes");
        let (name, most) = (scene.name, requests.max(free) + passes * (64 + 6));
        println!("{name} {requests} {cycles} {free} {passes}");
        assert!(requests <= cycles && cycles <= most, "{name}: {cycles}, {requests} to {most}");
    }
}

proptest! {
    #![proptest_config(effort())]

    /// One pixel alone: what does not fit is dropped, and the run says so.
    #[test]
    fn a_pixel_that_does_not_fit_at_all_is_cut(queue in 2..40u32, seed: u64) {
        let screen = Screen { width: 1, height: 1, background: 0x10_20_30 };
        let fragment = |k: u64| {
            let n = (seed + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let rgba = (n >> 32) as u32;
            Fragment { x: 0, y: 0, z: n as u32 & Z_FAR, rgba: rgba & !1, label: Label::NONE }
        };
        let frame: Vec<Fragment> = (0..60).map(fragment).collect();
        let setup = replaying(screen, queue);
        check_drops(&setup, &frame, &without_place(screen, &frame, queue))?;
    }
}

/// A frame of which the fragments come layer by layer, so that no pixel is complete before the end.
#[test]
fn layer_by_layer_comes_out_in_few_rounds() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let layers = 6;
    let frame: Vec<Fragment> = (0..layers)
        .flat_map(|k| {
            (0..screen.pixels()).map(move |pixel| Fragment {
                x: pixel % screen.width,
                y: pixel / screen.width,
                z: (k * 7 + pixel) % 40,
                rgba: (pixel + k) << 8 | 0x80,
                label: Label::NONE,
            })
        })
        .collect();
    for (queue, failed, rounds) in [(7200, 0, 1), (3600, 1, 3), (900, 3, 11)] {
        let setup = replaying(screen, queue);
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame), "queue={queue}");
        assert_eq!(run.tally.fragments.dropped, 0);
        // A band of 150 pixels fits into 900 places: 8 of them, and each attempt at more fails.
        let counted = ["failed_rounds", "rounds"].map(|name| run.tally.figure(name));
        assert_eq!(counted, [failed, rounds], "queue={queue}");
        let again = (rounds - 1) * frame.len() as u64;
        assert_eq!(run.tally.figure("replayed"), again, "queue={queue}");
    }
}

/// Of 16 pixels the first 4 have as many fragments as half of the queue holds: the next band has 8.
#[test]
fn a_band_grows_if_just_half_of_the_queue_is_free() {
    let screen = Screen { width: 16, height: 1, background: 0 };
    let layers = [1, 1, 1, 1, 2, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1];
    let of_pixel = |(x, n): (u32, u32)| {
        (0..n).map(move |k| Fragment { x, y: 0, z: k + 1, rgba: 0x80, label: Label::NONE })
    };
    let frame: Vec<Fragment> = (0..).zip(layers).flat_map(of_pixel).collect();
    let setup = replaying(screen, 8);
    let run = setup.run(std::slice::from_ref(&frame)).unwrap();
    // 16 pixels have 15 fragments, 8 have 9: too many. Then come 4, 8 and 4 pixels, with 4, 7 and 4.
    let counted = ["failed_rounds", "rounds"].map(|name| run.tally.figure(name));
    assert_eq!(counted, [2, 5]);
}

/// One pixel among others has more fragments than the queue holds: in the round of its own the first ones
/// stay.
#[test]
fn a_pixel_among_others_that_does_not_fit_is_cut() {
    let screen = Screen { width: 5, height: 2, background: 0x40_50_60 };
    let fragment = |k: u32, x, y| Fragment {
        x,
        y,
        z: k * 7 % 50 + 1,
        rgba: k << 9 | 0x70,
        label: Label::NONE,
    };
    let many = (0..200).map(|k| fragment(k, k % 5, k / 5 % 2));
    let deep = (200..260).map(|k| fragment(k, 3, 1));
    let frame: Vec<Fragment> = many.chain(deep).collect();
    // 20 fragments at each pixel, 60 more at one.
    let queue = 25;
    let setup = replaying(screen, queue);
    let mut of_pixel = 0;
    let mut dropped = vec![];
    for f in &frame {
        let deep = (f.x, f.y) == (3, 1);
        dropped.push(deep && of_pixel >= queue);
        of_pixel += u32::from(deep);
    }
    assert_eq!(dropped.iter().filter(|dropped| **dropped).count(), 55);
    check_drops(&setup, &frame, &dropped).unwrap();
}

#[test]
fn a_frame_buffer_outside_costs_words_and_no_latency() {
    for (on_chip, outside) in [(2048, 0), (128, 2048)] {
        lines_come_once(&ARCHITECTURE, &queue(on_chip, outside));
    }
    lines_come_once(&ARCHITECTURE, &with_replay(512));
}
