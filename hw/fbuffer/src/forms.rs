//! What a run must have counted, in closed form.

use crate::config::{Config, VERTICES};
use pellucid_blocks::bitonic;
use pellucid_machine::{Census, Check, Tally};

/// What is known of a frame: N fragments that get a place, in so many windows, which come in so many rounds.
#[derive(Clone, Copy)]
struct Frame {
    fragments: u64,
    windows: u64,
    rounds: u64,
}

impl Frame {
    fn new(cfg: &Config, frame: &Census) -> Frame {
        let visible = (0..).zip(&frame.visible).map(|(layers, pixels)| layers * pixels).sum();
        let fragments = if cfg.early { visible } else { frame.transparent };
        let places = u64::from(cfg.window().places());
        let windows = if cfg.window().counts() { fragments.div_ceil(places).max(1) } else { 1 };
        // Each round of a sort blends as many as a window has places.
        Frame { fragments, windows, rounds: if cfg.plays.sorts { windows } else { 1 } }
    }
}

/// See the module's description.
pub fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
    let figure = |name| tally.figure(name);
    let check = |what, expected, found| Check { what, expected, found };
    let frames: Vec<Frame> = frames.iter().map(|frame| Frame::new(cfg, frame)).collect();
    let sum = |of: fn(&Frame) -> u64| frames.iter().map(of).sum::<u64>();
    let passes = u64::from(cfg.plays.passes);
    let background = if cfg.plays.background { frames.len() as u64 } else { 0 };
    let wasted = figure("wasted_passes");
    let shaded = sum(|frame| frame.fragments * frame.rounds);
    let mut checks = vec![
        check("fragments that get a place, N", sum(|frame| frame.fragments), figure("fragments")),
        check(
            "submissions, one for each pass of each window, each pass that was wasted and each background",
            figure("windows") * passes + wasted + background,
            figure("submissions"),
        ),
        check(
            "fragments shaded, N * passes in each round, and those of wasted passes",
            shaded * passes + figure("wasted_fragments"),
            figure("shaded"),
        ),
    ];
    if !cfg.plays.batches() {
        checks.extend([
            check(
                "windows, ceil(N / S) of each frame in each round",
                sum(|frame| frame.windows * frame.rounds),
                figure("windows"),
            ),
            check(
                "fragments discarded, N * (ceil(N / S) - 1) * passes of each frame in each round",
                passes * sum(|frame| frame.fragments * (frame.windows - 1) * frame.rounds),
                figure("discarded"),
            ),
            check("wasted passes", 0, wasted),
        ]);
        if let [_] = frames[..] {
            checks.push(check(
                "vertices, three for each primitive of each submission",
                u64::from(VERTICES) * figure("primitives") * figure("submissions"),
                figure("vertices"),
            ));
        }
    }
    if let Some(buffer) = tally.memory("buffer.words") {
        let stored = shaded * (passes - 1);
        checks.extend([
            check(
                "words written, N * (passes - 1) in each round, and those of wasted passes",
                stored + figure("wasted_fragments"),
                buffer.info.writes,
            ),
            check("words read, N * (passes - 1) in each round", stored, buffer.info.reads),
        ]);
    }
    if !cfg.plays.sorts {
        checks.push(check("passes of a sort", 0, figure("sort_passes")));
    } else if frames.iter().all(|frame| frame.windows == 1) {
        checks.push(check(
            "passes of the sort, k (k + 1) / 2 for N fragments padded to 2^k",
            sum(|frame| bitonic::passes(frame.fragments)),
            figure("sort_passes"),
        ));
    }
    // Neither vertices nor fragments come faster than they can; the last fragment of a play need not wait for another.
    let cycles = tally.cycles.total;
    let vertices = u64::from(cfg.params.vertex_cycles) * figure("vertices");
    let apart = figure("shaded").saturating_sub(figure("submissions"));
    let fragments = u64::from(cfg.params.fragment_cycles) * apart + figure("discarded");
    for least in [vertices, fragments] {
        checks.push(check("cycles, at least the larger term", least, least.min(cycles)));
    }
    checks
}
