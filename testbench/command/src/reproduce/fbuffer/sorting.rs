//! Section 5.1: fragments are sorted in the F-buffer, as many as it has places for, or more.

use crate::reproduce::claims::{Claim, Verdict};
use crate::reproduce::frames::Frames;
use crate::reproduce::kept::{Kept, Machine};
use crate::reproduce::number;
use rayon::prelude::*;
use serde_json::{Value as Json, json};

/// Compare-exchanges that the sort does in a cycle.
const LANES: u64 = 4;
/// Passes that follow from the paper's `log2 n` merges of a bitonic sort: for 64 Ki fragments, and for 1 Mi.
const PRINTED: [(u64, u64); 2] = [(1 << 16, 136), (1 << 20, 210)];

/// A frame whose fragments are sorted.
#[derive(Clone, Debug)]
pub struct Sorted {
    /// The frame: a fragment for each pixel.
    pub frames: Frames,
    /// Places along the buffer's side.
    pub size: u32,
}

impl Sorted {
    /// As many fragments as a screen of that side has pixels.
    fn new(side: u32, size: u32) -> Sorted {
        Sorted { frames: Frames::square("quads-1-100", side), size }
    }

    fn machine(&self) -> Machine {
        let settings = [
            ("mode", "sort".to_string()),
            ("program", "tint".to_string()),
            ("size", self.size.to_string()),
            ("sorter_lanes", LANES.to_string()),
        ];
        Machine {
            name: format!("sorted in {0}x{0}", self.size),
            arch: "fbuffer",
            preset: Some("x800"),
            settings: settings.to_vec(),
        }
    }

    /// Windows that the fragments need.
    fn windows(&self) -> u64 {
        let size = u64::from(self.size);
        self.frames.pixels().div_ceil(size * size)
    }
}

/// Frames that fit, of more and more fragments; then one that does not, in smaller and smaller buffers.
pub fn plan(full: bool) -> Vec<Sorted> {
    let most = if full { 1024 } else { 256 };
    let fitting = (4..).map(|bits| 1 << bits).take_while(|side| *side <= most);
    let overflowed = [32, 16].map(|size| Sorted::new(64, size));
    fitting.map(|side| Sorted::new(side, side)).chain(overflowed).collect()
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Run {
    /// The command that does the same.
    pub command: String,
    /// Fragments.
    pub fragments: u64,
    /// Windows, in all rounds.
    pub windows: u64,
    /// How often the geometry was sent.
    pub submissions: u64,
    /// Passes over the sort's memory.
    pub sort_passes: u64,
    /// Cycles of sorts, and of giving what is sorted.
    pub sort_cycles: u64,
    /// All cycles.
    pub cycles: u64,
}

impl Run {
    fn read(json: &Json) -> Option<Run> {
        let own = |name: &str| json["fbuffer"][name].as_u64();
        Some(Run {
            command: json["command"].as_str()?.to_string(),
            fragments: own("fragments")?,
            windows: own("windows")?,
            submissions: own("submissions")?,
            sort_passes: own("sort_passes")?,
            sort_cycles: json["cycles"]["sort"].as_u64()?,
            cycles: json["cycles"]["total"].as_u64()?,
        })
    }
}

/// Every frame with what came of it; nothing if a machine is at fault.
///
/// # Errors
/// Frames cannot be read, or a file not be written.
pub fn play(plan: Vec<Sorted>, kept: &Kept) -> anyhow::Result<Option<Vec<(Sorted, Run)>>> {
    let each = plan.into_par_iter().map(|sorted| {
        let runs = kept.play_all(&[sorted.machine()], &sorted.frames, Run::read)?;
        Ok(runs.and_then(|mut runs| runs.pop()).map(|run| (sorted, run)))
    });
    each.collect()
}

/// Passes for so many fragments that fit: `k (k + 1) / 2`, where they are padded to `2^k`.
fn passes(fragments: u64) -> u64 {
    let k = u64::from(fragments.next_power_of_two().ilog2());
    k * (k + 1) / 2
}

/// Cycles: each pass does a half of the padded fragments, so many at a time, and a cycle goes by until the last is written; then the
/// fragments leave one a cycle, and their end; and a cycle ends the loading.
fn cycles(fragments: u64) -> u64 {
    let exchanges = fragments.next_power_of_two() / 2;
    passes(fragments) * (exchanges.div_ceil(LANES) + 1) + fragments + 2
}

/// Runs whose fragments fit into one window.
fn fitting(all: &[(Sorted, Run)]) -> impl Iterator<Item = &(Sorted, Run)> {
    all.iter().filter(|(sorted, _)| sorted.windows() == 1)
}

/// Those whose fragments do not, and before them the one in which as many do.
fn overflowing(all: &[(Sorted, Run)]) -> impl Iterator<Item = &(Sorted, Run)> {
    let several = |(sorted, _): &&(Sorted, Run)| sorted.windows() > 1;
    let pixels = all.iter().find(several).map(|(sorted, _)| sorted.frames.pixels());
    all.iter().filter(move |(sorted, _)| Some(sorted.frames.pixels()) == pixels)
}

/// What is said of sorts.
pub fn claims(all: &[(Sorted, Run)]) -> Vec<Claim> {
    let claim = |sentence, cases, of: &str, verdict, why| Claim {
        sentence,
        cases,
        verdicts: vec![(of.to_string(), verdict)],
        why,
    };
    let printed = PRINTED.iter().filter_map(|(fragments, passes)| {
        let (_, run) = fitting(all).find(|(_, run)| run.fragments == *fragments)?;
        Some(run.sort_passes == *passes)
    });
    vec![
        claim(
            "A bitonic sort of n fragments takes k (k + 1) / 2 passes, k = log2 n: 136 for 64 Ki, 210 for 1 Mi",
            "numbers of fragments",
            "sorts",
            Verdict::of(
                fitting(all)
                    .map(|(_, run)| run.sort_passes == passes(run.fragments))
                    .chain(printed),
            ),
            "The sort took more passes, or fewer.",
        ),
        claim(
            "It takes the cycles of its closed form, whatever the fragments",
            "numbers of fragments",
            "sorts",
            Verdict::of(fitting(all).map(|(_, run)| run.sort_cycles == cycles(run.fragments))),
            "The sort waited.",
        ),
        claim(
            "Fragments that need w windows are sorted within them and between them in w rounds of w windows",
            "buffers that are too small",
            "sorts",
            Verdict::of(
                overflowing(all)
                    .filter(|(sorted, _)| sorted.windows() > 1)
                    .map(|(sorted, run)| run.windows == sorted.windows() * sorted.windows()),
            ),
            "There were more windows, or fewer.",
        ),
    ]
}

/// What the columns of [`rows`] are.
pub const COLUMNS: [&str; 8] = [
    "fragments",
    "buffer",
    "windows",
    "submissions",
    "sort passes",
    "sort cycles",
    "closed form",
    "all cycles",
];

/// A table's head, and its rows.
pub struct Rows {
    /// What it shows.
    pub head: &'static str,
    /// A row for each run.
    pub rows: Vec<[String; 8]>,
}

/// Runs as tables show them: those that fit, and those that do not.
pub fn rows(all: &[(Sorted, Run)]) -> [Rows; 2] {
    let row = |(sorted, run): &(Sorted, Run)| {
        let closed_form = (sorted.windows() == 1).then(|| number(cycles(run.fragments)));
        [
            number(run.fragments),
            format!("{0}x{0}", sorted.size),
            number(run.windows),
            number(run.submissions),
            number(run.sort_passes),
            number(run.sort_cycles),
            closed_form.unwrap_or_default(),
            number(run.cycles),
        ]
    };
    [
        Rows {
            head: "Section 5.1: a sort of fragments that fit",
            rows: fitting(all).map(row).collect(),
        },
        Rows {
            head: "Section 5.1: a sort of fragments that do not fit, and of as many that do",
            rows: overflowing(all).map(row).collect(),
        },
    ]
}

/// Fragments of each run that fits, its cycles of the sort, and those of the closed form.
pub fn series(all: &[(Sorted, Run)]) -> (Vec<String>, [Vec<f64>; 2]) {
    let fits: Vec<&Run> = fitting(all).map(|(_, run)| run).collect();
    let each = |of: &dyn Fn(&Run) -> u64| {
        fits.iter().map(|run| of(run) as f64 / run.fragments as f64).collect()
    };
    let labels = fits.iter().map(|run| number(run.fragments)).collect();
    (labels, [each(&|run| run.sort_cycles), each(&|run| cycles(run.fragments))])
}

/// Every run as an object.
pub fn json(all: &[(Sorted, Run)]) -> Vec<Json> {
    let of = |(sorted, run): &(Sorted, Run)| {
        let fits = sorted.windows() == 1;
        json!({
            "size": sorted.size,
            "command": run.command,
            "fragments": run.fragments,
            "windows": { "counted": run.windows, "closed_form": sorted.windows().pow(2) },
            "submissions": run.submissions,
            "sort_passes": {
                "counted": run.sort_passes,
                "closed_form": fits.then(|| passes(run.fragments)),
            },
            "cycles": {
                "counted": run.cycles,
                "sort": run.sort_cycles,
                "sort_closed_form": fits.then(|| cycles(run.fragments)),
            },
        })
    };
    all.iter().map(of).collect()
}

/// Every run as a line behind those of [`super::figures::csv`], in its columns.
pub fn csv(all: &[(Sorted, Run)]) -> String {
    let line = |(sorted, run): &(Sorted, Run)| {
        let (width, height) = sorted.frames.screen;
        let Run { fragments, windows, submissions, sort_passes, sort_cycles, cycles, .. } = run;
        let (scene, size) = (&sorted.frames.scene, sorted.size);
        format!(
            "Section 5.1,{scene},{width},{height},{size},1,1,1,{fragments},{windows},{submissions},,,,,{cycles},,,,,,,{sort_passes},{sort_cycles}\n"
        )
    };
    all.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight fragments: three stages of 1, 2 and 3 passes, each of four compare-exchanges in one cycle and one more; eight leave.
    #[test]
    fn a_sort_by_hand() {
        assert_eq!((passes(8), cycles(8)), (6, 6 * 2 + 8 + 2));
        // Five are padded to as many.
        assert_eq!((passes(5), cycles(5)), (6, 6 * 2 + 5 + 2));
        for (fragments, printed) in PRINTED {
            assert_eq!(passes(fragments), printed);
        }
    }

    #[test]
    fn one_frame_overflows_and_fits_too() {
        for full in [false, true] {
            let windows: Vec<u64> = plan(full)
                .iter()
                .filter(|s| s.frames.screen.0 == 64)
                .map(Sorted::windows)
                .collect();
            assert_eq!(windows, [1, 4, 16]);
            let largest = plan(full).iter().map(|sorted| sorted.frames.pixels()).max();
            assert_eq!(largest, Some(PRINTED[usize::from(full)].0));
        }
    }
}
