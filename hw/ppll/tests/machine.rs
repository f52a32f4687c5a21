//! Per-pixel linked lists against the golden model.

use pellucid_machine::Tally;
use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine_properties::frames::{
    Run, Setup, check_drops, effort, one_frame, opaque_depth, tried, without_place,
};
use pellucid_machine_properties::machine_properties;
use pellucid_machine_properties::presets::{assert_rate, papers_frames_at_the_target_rate, preset};
use pellucid_ppll::architecture::ARCHITECTURE;
use pellucid_sim::Label;
use pellucid_testbench::scene::Options;
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

fn parameters<const N: usize>(all: [(&'static str, &str); N]) -> Parameterised {
    all.map(|(name, value)| (name, value.to_string())).to_vec()
}

/// Which fragments find no page in the play that is resolved: the first one, or one of a replay, in which just those come that
/// are visible in the end.
fn without_page(setup: &Setup, frame: &[Fragment], overflow: &str) -> Vec<bool> {
    let (begin, most) = (setup.number("pages"), setup.number("most_pages"));
    let at = |pages: u32, frame: &[Fragment]| {
        without_place(setup.screen(), frame, pages, setup.number("page"), false)
    };
    let first = at(begin, frame);
    if overflow == "drop" || !first.contains(&true) || begin == most {
        return first;
    }
    // What comes again meets the final depth, which the opaque fragments have that come before it now.
    let opaque_first = |f: &Fragment| f.is_opaque() || f.z >= opaque_depth(frame, f).min(Z_FAR);
    let comes: Vec<Fragment> = frame.iter().filter(|f| !opaque_first(f)).copied().collect();
    let mut lost = at(most, &comes).into_iter();
    frame.iter().map(|f| !opaque_first(f) && lost.next().unwrap()).collect()
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn a_full_machine_drops_what_finds_no_page(
        (setup, frame) in one_frame(&ARCHITECTURE), pages in 1..60u32, more in 0..60u32, rebuild: bool,
    ) {
        let overflow = if rebuild { "rebuild" } else { "drop" };
        let (pages, most) = (pages.to_string(), (pages + more).to_string());
        let setup = setup.with(parameters([
            ("pages", &pages), ("most_pages", &most), ("overflow", overflow),
        ]));
        let dropped = without_page(&setup, &frame, overflow);
        check_drops(&setup, &frame, &dropped)?;
    }

    /// Whatever the machine has to begin with, the image is the same, and a frame that comes opaque first takes as many pages.
    #[test]
    fn a_frame_that_is_played_again_takes_the_pages_that_it_needs(
        (setup, mut frame) in one_frame(&ARCHITECTURE), begin in 1..20u32,
    ) {
        frame.sort_by_key(|fragment| !fragment.is_opaque());
        let begin = begin.to_string();
        let few = setup.with(parameters([("pages", &begin), ("overflow", "rebuild")]));
        let runs = [&setup, &few].map(|setup| setup.run(std::slice::from_ref(&frame)));
        let [once, again] = runs;
        let (once, again) = (tried(once)?, tried(again)?);
        prop_assert_eq!(&once.images, &again.images);
        for figure in ["pages_used", "slots_wasted"] {
            prop_assert_eq!(once.tally.figure(figure), again.tally.figure(figure));
        }
        prop_assert_eq!(once.tally.seed_bytes_used, again.tally.seed_bytes_used);
    }
}

fn fragment(x: u32, y: u32, z: u32, rgba: u32) -> Fragment {
    Fragment { x, y, z, rgba, label: Label::NONE }
}

/// A frame of which the fragments come layer by layer.
fn layers(screen: Screen, layers: u32) -> Vec<Fragment> {
    let layer = |k: u32| {
        (0..screen.pixels()).map(move |pixel| {
            let (x, y) = (pixel % screen.width, pixel / screen.width);
            fragment(x, y, (k * 7 + pixel) % 40, (pixel + k) << 8 | 0x80)
        })
    };
    (0..layers).flat_map(layer).collect()
}

fn played(setup: &Setup, frame: &[Fragment]) -> Run {
    let run = setup.run(&[frame.to_vec()]).unwrap();
    assert_eq!(run.images[0], setup.golden_image(frame));
    let verdict = setup.verdict(&run, &[setup.golden(frame)]);
    assert!(verdict.is_right(), "{:?}", verdict.faults());
    run
}

/// A pixel of five layers, one of one, one of four and one that is empty: two pages, one and one.
#[test]
fn pages_are_taken_and_wasted_as_counted_by_hand() {
    let screen = Screen { width: 4, height: 1, background: 0x10_2030 };
    let mut frame: Vec<Fragment> =
        (0..5).map(|z| fragment(0, 0, 10 + z % 2, z << 8 | 0x90)).collect();
    frame.push(fragment(1, 0, 7, 0x1122_3344));
    frame.extend((0..4).map(|z| fragment(2, 0, 30 - z, z << 16 | 0x70)));
    for (page, pages, wasted, bytes) in [
        ("4", 4, 6, 4 * (4 * 16 + 4) + 4 * 4),
        ("1", 10, 0, 10 * (16 + 4) + 4 * 4),
        ("3", 5, 5, 5 * (3 * 16 + 4) + 4 * 4),
    ] {
        let setup = Setup::free(&ARCHITECTURE, screen, parameters([("page", page)]));
        let tally = played(&setup, &frame).tally;
        let counted = ["pages_used", "slots_wasted", "rebuilds"].map(|name| tally.figure(name));
        assert_eq!(counted, [pages, wasted, 0], "page={page}");
        assert_eq!(tally.seed_bytes_used, bytes, "page={page}");
        assert_eq!(tally.seed_accesses, 3 * 10 + 3 * pages + 2 * 4, "page={page}");
    }
}

/// 40 x 30 pixels of 6 layers: two pages of 4 each, or six of one.
#[test]
fn a_frame_is_played_again_until_it_fits() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let frame = layers(screen, 6);
    for (page, growth, pages, rebuilds, allowed) in [
        ("4", "double", 2400, 0, 2400),
        ("4", "double", 2399, 1, 4798),
        ("4", "double", 1200, 1, 2400),
        ("4", "double", 600, 2, 2400),
        ("4", "double", 599, 3, 4792),
        ("4", "double", 1, 12, 4096),
        ("1", "double", 450, 4, 7200),
        ("1", "needed", 7199, 1, 14_400),
        ("1", "needed", 1, 1, 14_400),
        // Four layers find 1199 pages, and the last pixel asks with each of them; with the two others all ask.
        ("4", "needed", 1199, 1, 2 * (1199 + 4 + 2 * 1200)),
    ] {
        let begin = pages.to_string();
        let setup = Setup::free(
            &ARCHITECTURE,
            screen,
            parameters([("page", page), ("growth", growth), ("pages", &begin)]),
        );
        let run = played(&setup, &frame);
        let counted = ["rebuilds", "pages_allowed", "replayed"].map(|name| run.tally.figure(name));
        assert_eq!(counted, [rebuilds, allowed, 7200 * rebuilds], "page={page}, {pages}, {growth}");
        assert_eq!(run.tally.cycles.of("rebuild"), Some(1200 * rebuilds));
        assert_eq!(run.tally.fragments.dropped, 0);
    }
}

/// What may be used stays for the frames that follow.
#[test]
fn the_second_frame_has_the_pages_that_the_first_one_needed() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let setup = Setup::free(&ARCHITECTURE, screen, parameters([("pages", "300")]));
    let frames = [layers(screen, 6), layers(screen, 2), layers(screen, 9)];
    let run = setup.run(&frames).unwrap();
    // 300, 600, 1200, 2400 pages; then 3600 of which 2400 are there.
    let counted = ["rebuilds", "replayed", "pages_used"].map(|name| run.tally.figure(name));
    assert_eq!(counted, [3 + 1, 3 * 7200 + 10_800, 3600]);
    for (image, frame) in run.images.iter().zip(&frames) {
        assert_eq!(image, &setup.golden_image(frame));
    }
}

/// An opaque fragment that comes late hides one that took a page: as the frame comes again it takes none.
#[test]
fn what_is_hidden_takes_no_page_when_the_frame_comes_again() {
    let screen = Screen { width: 2, height: 1, background: 0 };
    let frame = [
        fragment(0, 0, 9, 0xff00_0080),
        fragment(1, 0, 9, 0x00ff_0080),
        fragment(1, 0, 8, 0x0000_ff80),
        fragment(1, 0, 8, 0x1020_30ff),
    ];
    for (pages, counted) in [("3", [0, 3, 0, 2]), ("2", [1, 1, 2, 0]), ("1", [1, 1, 1, 0])] {
        let all = parameters([("page", "1"), ("pages", pages), ("most_pages", "4")]);
        let setup = Setup::free(&ARCHITECTURE, screen, all);
        let tally = played(&setup, &frame).tally;
        let names = ["rebuilds", "pages_used", "discarded", "culled_late"];
        assert_eq!(names.map(|name| tally.figure(name)), counted, "{pages} pages");
        assert_eq!((tally.fragments.stored, tally.fragments.culled), (3, 2));
    }
}

#[test]
fn long_runs_of_one_pixel_are_stored_one_a_cycle() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let mut frame = layers(screen, 32);
    frame.sort_by_key(|f| (f.y, f.x));
    for page in ["1", "4"] {
        let setup = Setup::free(&ARCHITECTURE, screen, parameters([("page", page)]));
        let tally = played(&setup, &frame).tally;
        assert_rate("stored", tally.fragments.stored, tally.cycles.of("store").unwrap(), 0.98);
    }
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    for preset in ["ppll4", "pll"] {
        papers_frames_at_the_target_rate(&ARCHITECTURE, preset);
    }
}

/// As the T-buffer, and a cycle more, since it is known then that the frame is not played again.
#[test]
fn glass_is_resolved_at_a_fragment_a_cycle() {
    for name in ["ppll4", "pll"] {
        let Tally { fragments, cycles, .. } =
            preset(&ARCHITECTURE, "glass", &Options::default(), name);
        let resolve = cycles.of("resolve").unwrap();
        assert!(resolve <= fragments.stored + 26, "{name}: {resolve} of {}", fragments.stored);
    }
}
