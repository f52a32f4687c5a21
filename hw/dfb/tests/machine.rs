//! The Dynamic Fragment Buffer against the golden model.

use pellucid_dfb::architecture::ARCHITECTURE;
use pellucid_machine::Tally;
use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine_properties::frames::{
    Setup, check_drops, check_place, effort, from_line_to_line, one_frame, some_frames, tried,
};
use pellucid_machine_properties::machine_properties;
use pellucid_machine_properties::presets::{assert_rate, papers_frames_at_the_target_rate, preset};
use pellucid_sim::Label;
use pellucid_testbench::scene::Options;
use proptest::prelude::*;

machine_properties!(&ARCHITECTURE);

/// Counters of a word outside, as of a pixel's sum there are so many in 64 bits.
const LANES: u32 = 2;

/// A buffer of so many fragments, on chip and outside.
fn buffer(on_chip: u32, outside: u32, overflow: &str) -> Parameterised {
    vec![
        ("fragments", on_chip.to_string()),
        ("outside_fragments", outside.to_string()),
        ("overflow", overflow.to_string()),
    ]
}

/// Which fragments of a frame find no slot, if a pixel has `limit` of them at most, and only pixels are stored whose arrays, in
/// the order of the pixels, end within `slots`: all if there are none.
fn without_slot(screen: Screen, frame: &[Fragment], limit: u32, slots: Option<u32>) -> Vec<bool> {
    let pixels = screen.pixels() as usize;
    let number = |f: &Fragment| (f.y * screen.width + f.x) as usize;
    let (mut nearest, mut counted) = (vec![Z_FAR; pixels], vec![0; pixels]);
    for f in frame.iter().filter(|f| f.z < Z_FAR) {
        let pixel = number(f);
        if f.z < nearest[pixel] && f.is_opaque() {
            nearest[pixel] = f.z;
        } else if f.z < nearest[pixel] {
            counted[pixel] = limit.min(counted[pixel] + 1);
        }
    }
    let mut end = 0;
    let stored: Vec<bool> = counted
        .iter()
        .map(|count| {
            end += count;
            slots.is_none_or(|slots| end <= slots)
        })
        .collect();
    let mut of_pixel = vec![0; pixels];
    let mut dropped = vec![];
    for f in frame {
        let pixel = number(f);
        let visible = !f.is_opaque() && f.z < nearest[pixel];
        of_pixel[pixel] += u32::from(visible);
        dropped.push(visible && !(stored[pixel] && of_pixel[pixel] <= limit));
    }
    dropped
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn a_full_buffer_drops_the_pixels_behind_it(
        (setup, frame) in one_frame(&ARCHITECTURE), on_chip in 1..40u32, outside in 0..200u32,
    ) {
        let slots = on_chip + outside;
        let setup = setup.with(buffer(on_chip, outside, "drop"));
        let most = 1_u64 << setup.number("count_bits");
        let limit = slots.min((most - 1) as u32);
        let dropped = without_slot(setup.screen(), &frame, limit, Some(slots));
        check_drops(&setup, &frame, &dropped)?;
    }

    /// With what is opaque before what is transparent, all that is counted is visible: there is no hole.
    #[test]
    fn a_frame_that_comes_opaque_first_has_no_holes((setup, mut frame) in one_frame(&ARCHITECTURE)) {
        let setup = setup.with(vec![("count_bits", "32".to_string())]);
        frame.sort_by_key(|fragment| !fragment.is_opaque());
        let run = tried(setup.run(std::slice::from_ref(&frame)))?;
        prop_assert_eq!(run.tally.figure("holes"), 0);
        prop_assert_eq!(&run.images[0], &setup.golden_image(&frame));
    }

    /// With bands just what a pixel has beyond its counter, or beyond the whole buffer, is dropped.
    #[test]
    fn a_pixel_that_does_not_fit_at_all_is_cut(
        (setup, frame) in one_frame(&ARCHITECTURE),
        on_chip in 1..8u32,
        outside in 0..8u32,
        count_bits in 1..=4u32,
    ) {
        let mut parameters = buffer(on_chip, outside, "bands");
        parameters.push(("count_bits", count_bits.to_string()));
        let setup = setup.with(parameters);
        let limit = (on_chip + outside).min((1 << count_bits) - 1);
        let dropped = without_slot(setup.screen(), &frame, limit, None);
        check_drops(&setup, &frame, &dropped)?;
    }
}

fn fragment(x: u32, y: u32, z: u32, rgba: u32) -> Fragment {
    Fragment { x, y, z, rgba, label: Label::NONE }
}

/// An opaque fragment that comes late hides one that is counted, and its slot stays empty.
#[test]
fn holes_are_counted_and_do_no_harm() {
    let screen = Screen { width: 3, height: 1, background: 0 };
    let frame = [
        fragment(0, 0, 9, 0x80),
        fragment(1, 0, 9, 0xff00_0080),
        fragment(1, 0, 5, 0x00ff_0080),
        fragment(2, 0, 9, 0x0000_ff80),
        fragment(1, 0, 7, 0x1020_30ff),
        fragment(1, 0, 3, 0x0000_ff80),
        fragment(1, 0, 8, 0x80),
    ];
    for index in ["up", "down"] {
        for scan_width in ["1", "4"] {
            let parameters = [("index", index), ("scan_width", scan_width)];
            let parameters = parameters.map(|(name, value)| (name, value.to_string()));
            let setup = Setup::free(&ARCHITECTURE, screen, parameters.to_vec());
            let run = setup.run(&[frame.to_vec()]).unwrap();
            assert_eq!(run.images[0], setup.golden_image(&frame));
            let counted = ["counted", "holes", "fragments_used", "fragments_read", "culled_early"];
            assert_eq!(counted.map(|name| run.tally.figure(name)), [5, 1, 5, 4, 1]);
        }
    }
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

#[test]
fn bands_are_cut_where_the_buffer_is_full() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let frame = layers(screen, 6);
    // 7200 fragments, 6 a pixel.
    for (slots, bands) in [(7200, 1), (7199, 2), (3600, 2), (900, 8), (905, 8), (60, 120)] {
        for index in ["up", "down"] {
            for scan in ["adders", "passes"] {
                let mut parameters = buffer(slots - slots / 3, slots / 3, "bands");
                parameters.push(("index", index.to_string()));
                parameters.push(("scan", scan.to_string()));
                let setup = Setup::free(&ARCHITECTURE, screen, parameters);
                let run = setup.run(std::slice::from_ref(&frame)).unwrap();
                assert_eq!(run.images[0], setup.golden_image(&frame), "{slots} slots");
                assert_eq!(run.tally.fragments.dropped, 0);
                let counted = ["bands", "replayed", "fragments_used"];
                let counted = counted.map(|name| run.tally.figure(name));
                let used = u64::from(slots - slots % 6);
                assert_eq!(counted, [bands, 7200 * bands, used], "{slots} slots");
            }
        }
    }
}

#[test]
fn long_runs_of_one_pixel_are_counted_and_stored_one_a_cycle() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let mut frame = layers(screen, 32);
    frame.sort_by_key(|f| (f.y, f.x));
    for index in ["up", "down"] {
        let setup = Setup::free(&ARCHITECTURE, screen, vec![("index", index.to_string())]);
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame));
        for phase in ["count", "store"] {
            let spent = run.tally.cycles.of(phase).unwrap();
            assert_rate(phase, run.tally.fragments.stored, spent, 0.98);
        }
    }
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    papers_frames_at_the_target_rate(&ARCHITECTURE, "fast");
}

/// The T-buffer takes 25 cycles more than it has stored fragments.
#[test]
fn glass_is_resolved_at_a_fragment_a_cycle() {
    let Tally { fragments, cycles, .. } =
        preset(&ARCHITECTURE, "glass", &Options::default(), "fast");
    for phase in ["count", "store"] {
        assert_rate(phase, fragments.arrived, cycles.of(phase).unwrap(), 0.98);
    }
    let resolve = cycles.of("resolve").unwrap();
    assert_rate("resolve", fragments.blended, resolve, 0.999);
    assert!(resolve <= fragments.stored + 25, "{resolve} cycles of {}", fragments.stored);
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
        let mut parameters = buffer(screen.pixels(), 0, "drop");
        parameters.extend([
            ("counters", "cached".to_string()),
            ("counters_sets", "32".to_string()),
            ("counters_line", line.to_string()),
            ("fragments", screen.pixels().to_string()),
            ("outside_latency", latency.to_string()),
            ("reads_in_flight", latency.max(2).to_string()),
        ]);
        let run = Setup::free(&ARCHITECTURE, screen, parameters).run(std::slice::from_ref(&frame));
        let cycles = run.unwrap().tally.cycles;
        let words = [
            // A line of counters in and out for each fragment.
            ("count", 2 * line * pixels),
            // Counters and sums in, sums out.
            ("scan", 3 * (pixels / LANES)),
            // As to count, and a line of sums in.
            ("store", 3 * line * pixels),
        ];
        for (phase, words) in words {
            let (cycles, words) = (cycles.of(phase).unwrap(), u64::from(words));
            let off = cycles.abs_diff(words);
            assert!(off <= words / 20, "{latency}: {phase} {cycles}, {words} words");
        }
    }
}
