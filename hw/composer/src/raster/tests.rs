use super::*;
use crate::test_util::{Pattern, pattern, screen};
use pellucid_sim::Sim;
use proptest::prelude::*;

/// A frame from the cycle after its start on: of each cycle whether a pixel is due, the row, and whether the row
/// and the frame are done.
fn frame(sim: &mut Sim<Raster>, moves: &Pattern) -> Vec<(bool, u32, bool, bool)> {
    assert!(!sim.moore().runs && !sim.moore().pixel);
    let started = sim.clock(In { start: true, moves: false }).unwrap().out;
    assert!(!started.line_done && !started.frame_done);
    let mut seen = vec![];
    while sim.moore().runs {
        assert!(seen.len() < 10_000, "the frame does not end");
        let Moore { pixel, row, .. } = sim.moore();
        let i = In { start: false, moves: pixel && moves.at(seen.len() as u64) };
        let Out { line_done, frame_done } = sim.clock(i).unwrap().out;
        seen.push((pixel, row, line_done, frame_done));
    }
    seen
}

fn config(width: u32, height: u32, beta: u32) -> Config {
    Config { screen: screen(width, height), beta }
}

#[test]
fn by_hand() {
    let mut sim = Sim::new(config(2, 2, 1));
    let expected = [
        (true, 0, false, false),
        (true, 0, false, false),
        (false, 0, true, false),
        (true, 1, false, false),
        (true, 1, false, false),
        (false, 1, true, true),
    ];
    assert_eq!(frame(&mut sim, &Pattern::always()), expected);
    assert_eq!(frame(&mut sim, &Pattern::always()), expected, "the next frame");
}

#[test]
fn without_overhead_the_last_pixels_cycle_is_the_lines_last() {
    let mut sim = Sim::new(config(1, 2, 0));
    let expected = [(true, 0, true, false), (true, 1, true, true)];
    assert_eq!(frame(&mut sim, &Pattern::always()), expected);
}

#[test]
fn a_frame_that_never_waits_takes_width_and_overhead_times_height() {
    for (width, height, beta) in [(1, 1, 0), (5, 4, 0), (5, 4, 3), (1, 7, 9), (8, 1, 1)] {
        let mut sim = Sim::new(config(width, height, beta));
        let cycles = frame(&mut sim, &Pattern::always()).len() as u32;
        assert_eq!(cycles, (width + beta) * height, "{width} x {height}, {beta}");
    }
}

#[test]
fn without_a_start_no_pixel_is_due() {
    let mut sim = Sim::<Raster>::new(config(2, 2, 1));
    for _ in 0..5 {
        let Out { line_done, frame_done } =
            sim.clock(In { start: false, moves: true }).unwrap().out;
        assert!(!line_done && !frame_done);
        assert!(!sim.moore().runs && !sim.moore().pixel);
    }
}

proptest! {
    /// A pixel waits until it moves, overhead for nobody.
    #[test]
    fn pixels_wait_and_overhead_does_not(
        width in 1..6_u32,
        height in 1..5_u32,
        beta in 0..4_u32,
        moves in pattern(),
    ) {
        let mut sim = Sim::new(config(width, height, beta));
        let mut expected = vec![];
        for row in 0..height {
            for column in 0..width + beta {
                let pixel = column < width;
                while pixel && !moves.at(expected.len() as u64) {
                    expected.push((true, row, false, false));
                }
                let line_done = column + 1 == width + beta;
                expected.push((pixel, row, line_done, line_done && row + 1 == height));
            }
        }
        prop_assert_eq!(frame(&mut sim, &moves), expected);
    }
}

#[test]
#[should_panic(expected = "the width of a screen is 0: expected 1 to 8192")]
fn a_screen_without_columns_is_none() {
    Raster::reset(&config(0, 3, 1));
}
