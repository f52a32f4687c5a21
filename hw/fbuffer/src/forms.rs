//! What a run must have counted, in closed form.

use crate::config::{Config, VERTICES};
use pellucid_blocks::bitonic;
use pellucid_blocks::front::monitor::framebuffer_form;
use pellucid_machine::{Census, Check, Tally};

/// What is known of a frame: N fragments that get a place, in so many windows, which come in so many rounds.
#[derive(Clone, Copy)]
struct Frame {
    fragments: u64,
    windows: u64,
    rounds: u64,
    /// Those that are sorted.
    sorted: u64,
}

impl Frame {
    /// A frame of whose fragments the program kills so many.
    fn new(cfg: &Config, frame: &Census, killed: u64) -> Frame {
        let visible = (0..).zip(&frame.visible).map(|(layers, pixels)| layers * pixels).sum();
        let fragments = if cfg.early { visible } else { frame.transparent };
        let sorted = fragments.saturating_sub(killed);
        let places = u64::from(cfg.window().places());
        let windows = |fragments: u64| {
            if cfg.window().counts() { fragments.div_ceil(places).max(1) } else { 1 }
        };
        // Each round of a sort blends as many as a window has places.
        let rounds = if cfg.plays.sorts { windows(sorted) } else { 1 };
        Frame { fragments, windows: windows(fragments), rounds, sorted }
    }
}

/// See the module's description.
pub fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
    let figure = |name| tally.figure(name);
    let check = |what, expected, found| Check { what, expected, found };
    let killed = tally.fragments.killed;
    let compacts = cfg.window().compacts;
    let single = frames.len() == 1;
    let frames: Vec<Frame> = frames.iter().map(|frame| Frame::new(cfg, frame, killed)).collect();
    let sum = |of: fn(&Frame) -> u64| frames.iter().map(of).sum::<u64>();
    let passes = u64::from(cfg.plays.passes);
    let background = if cfg.plays.background { frames.len() as u64 } else { 0 };
    let wasted = figure("wasted_passes");
    let mut checks = vec![
        check("fragments that get a place, N", sum(|frame| frame.fragments), figure("fragments")),
        check(
            "submissions, one for each pass of each window, each pass that was wasted and each background",
            figure("windows") * passes + wasted + background,
            figure("submissions"),
        ),
    ];
    if !cfg.plays.batches() {
        checks.push(check("wasted passes", 0, wasted));
        if single {
            checks.push(check(
                "vertices, three for each primitive of each submission",
                u64::from(VERTICES) * figure("primitives") * figure("submissions"),
                figure("vertices"),
            ));
        }
    }
    // How many of each frame were killed is not known, and so neither how many rounds it took.
    if single || !cfg.shader.program.kills || !(cfg.plays.sorts || compacts) {
        checks.extend(of_windows(cfg, tally, &frames));
    }
    checks.extend(framebuffer_form(&cfg.front, tally));
    if !cfg.plays.sorts {
        checks.push(check("passes of a sort", 0, figure("sort_passes")));
    } else if frames.iter().all(|frame| frame.windows == 1) && (single || killed == 0) {
        checks.push(check(
            "passes of the sort, k (k + 1) / 2 for N fragments that are not killed, padded to 2^k",
            sum(|frame| bitonic::passes(frame.sorted)),
            figure("sort_passes"),
        ));
    }
    // Neither vertices nor fragments come faster than they can; the last fragment of a play need not wait for another, and
    // fragments that are discarded come while a shaded one lasts. Outside memory takes a request a cycle.
    let cycles = tally.cycles.total;
    let vertices = u64::from(cfg.params.vertex_cycles) * figure("vertices");
    let apart = figure("shaded").saturating_sub(figure("submissions"));
    let shaded = u64::from(cfg.params.fragment_cycles) * apart;
    let come = apart + figure("discarded");
    let mut requests = match tally.memory(cfg.memory().0) {
        Some(buffer) if cfg.outside() => buffer.info.reads + buffer.info.writes,
        _ => 0,
    };
    if cfg.front.outside() {
        let lines = figure("framebuffer_misses") * u64::from(cfg.params.framebuffer_line);
        let moved = requests + lines + figure("framebuffer_written_back");
        // The cache is flushed while the machine waits, which the total leaves out.
        requests = moved.saturating_sub(tally.cycles.of("wait").unwrap_or(0));
    }
    for least in [vertices, shaded, come, requests] {
        checks.push(check("cycles, at least the largest term", least, least.min(cycles)));
    }
    checks
}

/// What follows from windows and rounds.
fn of_windows(cfg: &Config, tally: &Tally, frames: &[Frame]) -> Vec<Check> {
    let figure = |name| tally.figure(name);
    let check = |what, expected, found| Check { what, expected, found };
    let sum = |of: fn(&Frame) -> u64| frames.iter().map(of).sum::<u64>();
    let passes = u64::from(cfg.plays.passes);
    let wasted_fragments = figure("wasted_fragments");
    let entered = sum(|frame| frame.fragments * frame.rounds);
    let mut checks = vec![check(
        "fragments shaded or spared, N * passes in each round, and those of wasted passes",
        entered * passes + wasted_fragments,
        figure("shaded") + figure("spared"),
    )];
    if !cfg.plays.batches() {
        let most = sum(|frame| frame.windows * frame.rounds);
        let windows = figure("windows");
        checks.push(match cfg.window().compacts {
            false => check("windows, ceil(N / S) of each frame in each round", most, windows),
            true => check("windows, at most ceil(N / S) in each round", windows.min(most), windows),
        });
        // All fragments of a frame come in each pass of each of its windows.
        let come = match frames {
            [frame] => frame.fragments * windows,
            _ => sum(|frame| frame.fragments * frame.windows * frame.rounds),
        };
        checks.push(check(
            "fragments shaded or discarded, N * windows * passes of each frame",
            come * passes,
            figure("shaded") + figure("discarded"),
        ));
    }
    let (path, parts) = cfg.memory();
    if let Some(buffer) = tally.memory(path) {
        let read = figure("shaded").saturating_sub(entered + wasted_fragments);
        checks.push(check(
            "words read, one for each fragment in each pass but the first",
            read * parts,
            buffer.info.reads,
        ));
        // Of those that a wasted pass kills none is written.
        if !cfg.window().compacts || wasted_fragments == 0 {
            checks.push(check(
                "words written, as many as are read, and those of wasted passes",
                (read + wasted_fragments) * parts,
                buffer.info.writes,
            ));
        }
    }
    checks
}
