//! What the paper says, and whether it is so in clocked hardware.

use super::pictures::Overlap;
use super::plan::{Buffer, Figure, PASSES, SIDE, SPHERES};
use super::runs::{Entry, Run, Terms};
use super::{Found, sorting};
use crate::reproduce::claims::{Claim, Verdict};

/// Submissions that are printed in section 4 and with Figure 3, each for a screen of so many times the side of the buffer.
const PRINTED: [(Figure, u32, u64); 3] =
    [(Figure::Counts, 16, 489), (Figure::Counts, 4, 33), (Figure::View, 4, 69)];

/// What is printed for a run, if something is; a smaller screen stands for the paper's.
pub fn printed(entry: &Entry, buffer: Buffer) -> Option<u64> {
    let (side, _) = entry.frames.screen;
    let figure = match entry.figure {
        // On the paper's own screen Figure 4 is what the text counts.
        Figure::Rates if side == SIDE => Figure::Counts,
        figure => figure,
    };
    let is_it = |(of, ratio, _): &&(Figure, u32, u64)| *of == figure && ratio * buffer.size == side;
    PRINTED.iter().find(is_it).map(|(_, _, submissions)| *submissions)
}

/// The claim of every sentence.
pub fn claims(Found { entries, sorted, overlap }: &Found) -> Vec<Claim> {
    let claim = |sentence, cases, verdicts: Vec<(&str, Verdict)>, why| {
        let verdicts = verdicts.into_iter().map(|(of, verdict)| (of.to_string(), verdict));
        Claim { sentence, cases, verdicts: verdicts.collect(), why }
    };
    let of_windows = [
        claim(
            "With an F-buffer transparent surfaces are right where they overlap; with one place for each pixel they are not",
            "ways to store",
            vec![("triangles", apart(overlap))],
            "Both are right, or the F-buffer is not.",
        ),
        claim(
            "The geometry is sent ceil(N / S) times for each pass, with N fragments and S places",
            "runs",
            vec![(
                "windows",
                all(entries, |buffer, run| {
                    run.submissions == PASSES * run.fragments.div_ceil(buffer.places())
                }),
            )],
            "The machine sent it more or less often.",
        ),
        claim(
            "That is 489 times with 64x64 places, 33 times with 256x256, and 69 times for Figure 3",
            "runs that it is printed for",
            vec![("spheres", as_printed(entries))],
            "The sphere has too few fragments, or too many.",
        ),
        claim(
            "Every fragment is shaded once, whatever the size of the buffer",
            "runs",
            vec![("windows", all(entries, |_, run| run.shaded == PASSES * run.fragments))],
            "A fragment was shaded twice, or never.",
        ),
        claim(
            "The fewer windows, the faster",
            "pairs of sizes",
            SPHERES.map(|sphere| (sphere, faster(entries, sphere))).to_vec(),
            "A larger buffer took more cycles.",
        ),
        claim(
            "Time is the larger of what vertices and what fragments take: within a tenth",
            "sizes",
            SPHERES.map(|sphere| (sphere, larger_term(entries, sphere))).to_vec(),
            "One primitive alone is set up ahead: where a triangle has more fragments than its vertices take cycles, vertex units wait, and \
             where it has fewer, the others do. So it is nearer to the sum of the larger term of each triangle.",
        ),
        claim(
            "The low sphere is bound by vertices with the smallest buffer, and by fragments with the largest",
            "ends",
            vec![(SPHERES[0], low_ends(entries))],
            "One of its two terms is always the larger one.",
        ),
        claim(
            "The high sphere is bound by vertices wherever it needs several windows",
            "sizes with several windows",
            vec![(SPHERES[1], high_bound(entries))],
            "Its fragments take longer than its vertices.",
        ),
        claim(
            "Four floats at 1024x1024 take 16 MB, and four targets of them 64 MB",
            "buffers",
            vec![("memory", memory(entries))],
            "A buffer has another number of bytes.",
        ),
    ];
    of_windows.into_iter().chain(sorting::claims(sorted)).collect()
}

/// With an F-buffer no pixel is wrong; with one place for each pixel just those in which surfaces overlap.
fn apart([fbuffer, framebuffer]: &[Overlap; 2]) -> Verdict {
    let wrong_there = framebuffer.overlapping > 0 && framebuffer.wrong == framebuffer.overlapping;
    Verdict::of([fbuffer.wrong == 0, wrong_there])
}

fn all(entries: &[Entry], holds: impl Fn(Buffer, &Run) -> bool) -> Verdict {
    let runs = entries.iter().flat_map(|entry| &entry.runs);
    Verdict::of(runs.map(|(buffer, run)| holds(*buffer, run)))
}

fn as_printed(entries: &[Entry]) -> Verdict {
    let runs = entries.iter().flat_map(|entry| entry.runs.iter().map(move |run| (entry, run)));
    Verdict::of(
        runs.filter_map(|(entry, (buffer, run))| Some(run.submissions == printed(entry, *buffer)?)),
    )
}

/// Figure 4's runs of a sphere, from the smallest buffer on.
pub fn rates<'a>(entries: &'a [Entry], sphere: &str) -> &'a [(Buffer, Run)] {
    let of = |entry: &&Entry| entry.figure == Figure::Rates && entry.frames.scene == sphere;
    entries.iter().find(of).map_or(&[], |entry| &entry.runs)
}

fn faster(entries: &[Entry], sphere: &str) -> Verdict {
    let pairs = rates(entries, sphere).windows(2);
    Verdict::of(pairs.filter_map(|pair| {
        let [(_, small), (_, large)] = pair else { return None };
        (large.windows < small.windows).then_some(large.cycles < small.cycles)
    }))
}

fn larger_term(entries: &[Entry], sphere: &str) -> Verdict {
    Verdict::of(rates(entries, sphere).iter().map(|(buffer, run)| {
        let term = Terms::of(*buffer, run).larger();
        10 * run.cycles.abs_diff(term) <= term
    }))
}

/// Whether vertices take longer than fragments.
fn bound_by_vertices((buffer, run): &(Buffer, Run)) -> bool {
    let terms = Terms::of(*buffer, run);
    terms.vertices > terms.fragments
}

fn low_ends(entries: &[Entry]) -> Verdict {
    let runs = rates(entries, SPHERES[0]);
    let (first, last) = (runs.first().map(bound_by_vertices), runs.last().map(bound_by_vertices));
    Verdict::of([first, last.map(|bound| !bound)].into_iter().flatten())
}

fn high_bound(entries: &[Entry]) -> Verdict {
    let several = rates(entries, SPHERES[1]).iter().filter(|(_, run)| run.windows > 1);
    Verdict::of(several.map(bound_by_vertices))
}

fn memory(entries: &[Entry]) -> Verdict {
    let runs = entries.iter().filter(|entry| entry.figure == Figure::Memory);
    Verdict::of(
        runs.flat_map(|entry| &entry.runs)
            .map(|(buffer, run)| run.bytes == u64::from(buffer.targets) << 24),
    )
}

#[cfg(test)]
mod tests {
    use super::super::plan::{PASSES, plan};
    use super::*;
    use crate::reproduce::price::Price;

    /// A run of a frame of so many fragments and vertices that took so many cycles.
    fn run(buffer: Buffer, fragments: u64, vertices: u64, cycles: u64) -> (Buffer, Run) {
        let windows = fragments.div_ceil(buffer.places());
        let run = Run {
            command: String::new(),
            cycles,
            fragments,
            windows,
            submissions: PASSES * windows,
            vertices: vertices * PASSES * windows,
            shaded: PASSES * fragments,
            discarded: PASSES * fragments * (windows - 1),
            bytes: 16 * u64::from(buffer.targets) * buffer.places(),
            price: Price { accesses_nj: 1.0, leakage_nj: 2.0, area_mm2: 3.0 },
        };
        (buffer, run)
    }

    const SIDE_64: Buffer = Buffer { size: 64, targets: 1, vertex_cycles: 2, fragment_cycles: 5 };

    /// 10 000 fragments need three windows of 4096. Vertices: 100 * 9 * 2 cycles. Fragments: three passes of 5 cycles and of two in which
    /// they are discarded.
    #[test]
    fn terms_are_what_vertices_and_fragments_take() {
        let (buffer, run) = run(SIDE_64, 10_000, 100, 0);
        assert_eq!(run.windows, 3);
        let terms = Terms::of(buffer, &run);
        assert_eq!((terms.vertices, terms.fragments), (1800, 210_000));
        assert_eq!(terms.larger(), 210_000);
    }

    /// The middle of the fragments that the printed numbers allow.
    #[test]
    fn what_is_printed_comes_out_with_as_many_fragments_as_it_says() {
        for full in [false, true] {
            let entries = plan(full).into_iter().map(|planned| {
                let (side, _) = planned.frames.screen;
                let fragments = match planned.figure {
                    Figure::View => 368_640 * u64::from(side * side) / (512 * 512),
                    _ => 665_600 * u64::from(side * side) / (1024 * 1024),
                };
                let runs = planned.buffers.iter().map(|buffer| run(*buffer, fragments, 1, 1));
                Entry { figure: planned.figure, frames: planned.frames, runs: runs.collect() }
            });
            let entries: Vec<Entry> = entries.collect();
            let verdict = as_printed(&entries);
            let cases = if full { 5 } else { 4 };
            assert_eq!((verdict.held, verdict.cases), (cases, cases));
            let memory = memory(&entries);
            assert_eq!((memory.held, memory.cases), (2, 2));
        }
    }

    #[test]
    fn a_larger_buffer_that_is_slower_is_told() {
        let entry = |cycles: [u64; 3]| {
            let planned = plan(false).into_iter().find(|p| p.figure == Figure::Rates).unwrap();
            let buffers = [32, 64, 128].map(|size| Buffer { size, ..SIDE_64 });
            // Three windows, one and one: with the same number of windows nothing is said.
            let runs = buffers.into_iter().zip(cycles).map(|(b, cycles)| run(b, 3000, 1, cycles));
            Entry { figure: Figure::Rates, frames: planned.frames, runs: runs.collect() }
        };
        for (cycles, held) in [([9, 8, 8], 1), ([8, 9, 9], 0)] {
            let verdict = faster(&[entry(cycles)], SPHERES[0]);
            assert_eq!((verdict.held, verdict.cases), (held, 1));
        }
        assert_eq!(faster(&[entry([9, 8, 8])], SPHERES[1]).cases, 0);
    }
}
