//! Each claim on frames for which it is plain whether it holds.

use super::super::runs::Outcome;
use super::*;
use crate::reproduce::frames::Frames;
use pellucid_testbench::scene::{CameraPath, Sequence, Walk};
use serde_json::{Value as Json, json};

/// Frames that need this much, on a screen of 100 pixels.
fn entry(figure: Figure, need: Need, runs: &[(Contender, Json)]) -> Entry {
    let outcomes = runs.iter().map(|(_, json)| match json {
        Json::Null => Outcome::Lacks("room"),
        json => Outcome::Run(Run::read(json).unwrap()),
    });
    let walk = Sequence::Walk(Walk { path: CameraPath::Orbit, frames: 2 });
    let frames = Frames {
        scene: "a scene".to_string(),
        screen: (10, 10),
        instances: None,
        camera: None,
        sequence: matches!(figure, Figure::Walk(_) | Figure::Tour).then_some(walk),
    };
    let contenders = runs.iter().map(|(machine, _)| *machine).collect();
    Entry { figure, frames, need, contenders, outcomes: outcomes.collect() }
}

const NEED: Need = Need { pixels: 100, fragments: 200, layers: 4, pages: [200, 80] };

/// A run of frames that each took these cycles, in all and to scan, the others to store, and came so often; each has 10
/// fragments.
fn run(frames: &[(u64, u64, u64)]) -> Json {
    let cycles =
        |total: u64, scan: u64| json!({ "total": total, "scan": scan, "store": total - scan });
    let total = frames.iter().map(|frame| frame.0).sum();
    let scan = frames.iter().map(|frame| frame.1).sum();
    let each = frames.iter().map(|(total, scan, plays)| {
        json!({ "cycles": cycles(*total, *scan), "plays": plays, "stored": 10, "layer_histogram": [] })
    });
    let each: Vec<Json> = each.collect();
    json!({
        "command": "", "faults": [], "cycles": cycles(total, scan), "accesses": { "seed": 0, "full": 0 },
        "storage": { "seed_bytes_used": 0 }, "energy": { "reads": 1, "writes": 2, "leakage": 3 }, "area": { "memories": 4 },
        "frames": each
    })
}

fn once(total: u64) -> Json {
    run(&[(total, 1, 1)])
}

fn verdict(held: u64, cases: u64) -> Verdict {
    Verdict { held, cases, spared: 0 }
}

#[test]
fn what_has_no_case_does_not_hold() {
    assert!(!Verdict::of([]).holds());
    assert!(Verdict::of([true, true]).holds());
    assert!(!Verdict::of([true, false]).holds());
    assert!(claims(&[]).iter().all(|claim| !claim.holds() && claim.objection().is_some()));
}

/// By hand, with 16 bytes a fragment: DFB takes 200 * 16 + 800, B3D 100 * 4 * 16, PPLL4 80 * 68 + 400, PLL 200 * 20 + 400. With 50
/// fragments, one at every other pixel, DFB takes 1,600, and so does B3D; PPLL4 3,800 and PLL 1,400.
#[test]
fn the_least_memory_is_that_of_the_formulas() {
    let sparse = Need { pixels: 100, fragments: 50, layers: 1, pages: [50, 50] };
    let entries = [NEED, sparse].map(|need| entry(Figure::Table, need, &[]));
    assert_eq!(
        OTHERS.map(|other| least_memory(&entries, other)),
        [verdict(2, 2), verdict(2, 2), verdict(1, 2)]
    );
    let table = Need { layers: 2, ..NEED };
    assert_eq!(least_memory(&[entry(Figure::Table, table, &[])], B3D), verdict(0, 1));
}

#[test]
fn ranks_are_those_of_cycles() {
    let ranked = |[b3d, dfb, ppll4, pll]: [u64; 4], figure| {
        let [b3d, dfb, ppll4, pll] = [b3d, dfb, ppll4, pll].map(once);
        entry(figure, NEED, &[(B3D, b3d), (DFB, dfb), (PPLL4, ppll4), (PLL, pll)])
    };
    let (half, quarter) = (Figure::Quads(1, 50), Figure::Quads(1, 25));
    let entries = [
        ranked([10, 20, 30, 40], half),
        ranked([10, 30, 30, 40], half),
        ranked([10, 41, 30, 40], half),
        // No more than a quarter is covered.
        ranked([10, 41, 30, 40], quarter),
    ];
    assert_eq!(second(&entries, DFB), verdict(2, 3));
    assert_eq!(b3d_fastest(&entries), verdict(4, 4));
    assert_eq!(b3d_fastest(&[ranked([10, 9, 30, 40], half)]), verdict(0, 1));
    let without = entry(half, NEED, &[(B3D, Json::Null), (DFB, once(1))]);
    assert_eq!(b3d_fastest(&[without]), verdict(0, 0));

    let walks = |slow: usize| {
        let walk = |k| ranked([1, if k < slow { 40 } else { 20 }, 30, 30], Figure::Walk(1));
        (0..9).map(walk).collect::<Vec<_>>()
    };
    for (slow, holds) in [(0, true), (1, true), (2, false)] {
        let verdict = fastest_walks(&walks(slow), DFB);
        assert_eq!((verdict.held, verdict.cases, verdict.holds()), (9 - slow as u64, 9, holds));
    }

    let of_table = |[b3d, dfb, list]: [u64; 3]| {
        let claims = claims(&[ranked([b3d, dfb, list, list], Figure::Table)]);
        let holds = |what: &str| {
            let claim = claims.iter().find(|claim| claim.sentence.contains(what)).unwrap();
            claim.verdicts[0].1.holds()
        };
        (holds("twice as fast"), holds("at least as fast as lists"))
    };
    assert_eq!(of_table([10, 20, 20]), (true, true));
    assert_eq!(of_table([10, 19, 18]), (false, false));
}

#[test]
fn a_peak_is_where_fragments_cost_more_in_frames_that_came_again() {
    let walk = |frames: &[(u64, u64, u64)]| entry(Figure::Tour, NEED, &[(PLL, run(frames))]);
    let entries = [
        walk(&[(30, 0, 2), (20, 0, 1)]),
        walk(&[(20, 0, 2), (30, 0, 1)]),
        // Nothing to compare.
        walk(&[(30, 0, 1), (20, 0, 1)]),
        walk(&[(30, 0, 2), (20, 0, 3)]),
    ];
    assert_eq!(peaks(&entries, PLL), verdict(1, 2));
}

#[test]
fn a_scan_is_compared_with_other_steps_and_with_other_scans() {
    let with_scan = |scan| entry(Figure::Table, NEED, &[(DFB, run(&[(100, scan, 1)]))]);
    assert_eq!(dearest(&[with_scan(51), with_scan(50)], DFB), verdict(1, 2));
    assert_eq!(screen_alone(&[with_scan(7), with_scan(7)], DFB), verdict(1, 1));
    assert_eq!(screen_alone(&[with_scan(7), with_scan(8)], DFB), verdict(0, 1));
    let mut other = with_scan(8);
    other.frames.screen = (20, 5);
    assert_eq!(screen_alone(&[with_scan(7), with_scan(7), other], DFB), verdict(1, 1));
}

#[test]
fn a_cost_is_smooth_if_a_pixel_costs_no_more_than_a_quarter_more() {
    let on = |screen: (u32, u32), total| {
        let mut entry = entry(Figure::Quads(1, 50), NEED, &[(DFB, once(total))]);
        entry.frames.screen = screen;
        entry
    };
    assert_eq!(smooth(&[on((10, 10), 400), on((20, 20), 2000)], DFB), verdict(1, 1));
    assert_eq!(smooth(&[on((10, 10), 400), on((20, 20), 2001)], DFB), verdict(0, 1));
}

/// 16 bytes for each of 800 x 600 pixels: 195 layers are 1,497,600,000 bytes.
#[test]
fn the_plant_is_too_deep_from_196_layers_on() {
    let tour = |layers| [entry(Figure::Tour, Need { layers, ..NEED }, &[])];
    assert_eq!(too_deep(&tour(195)), verdict(0, 1));
    assert_eq!(too_deep(&tour(196)), verdict(1, 1));
}
