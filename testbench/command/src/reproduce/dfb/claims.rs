//! What the paper says, and whether it is so in clocked hardware.

use super::contender::{B3D, Contender, DFB, DFB_PAPER, PLL, PPLL4};
use super::need::Need;
use super::plan::Figure;
use super::runs::{Entry, Played, Run};
use crate::reproduce::claims::{Claim, Verdict};
use std::collections::BTreeMap;

/// The Dynamic Fragment Buffers that are compared.
const DFBS: [Contender; 2] = [DFB, DFB_PAPER];
/// What each is compared with.
const OTHERS: [Contender; 3] = [B3D, PPLL4, PLL];
const LISTS: [Contender; 2] = [PPLL4, PLL];

/// The claim of every sentence.
pub fn claims(entries: &[Entry]) -> Vec<Claim> {
    let each = |machines: &[Contender], verdict: &dyn Fn(Contender) -> Verdict| {
        machines.iter().map(|m| (m.name.to_string(), verdict(*m))).collect()
    };
    let against = |other: Contender| format!("against {}", other.name);
    let claim = |sentence, cases, verdicts, why| Claim { sentence, cases, verdicts, why };
    let (frames, screens, walks) = ("sets of frames", "screens", "walks");
    vec![
        claim(
            "DFB takes the least memory, always",
            frames,
            OTHERS.map(|other| (against(other), least_memory(entries, other))).to_vec(),
            "DFB has two tables, 8 bytes for each pixel of the screen. Lists have one, and 4 bytes a page: less where there are \
             fewer pages than pixels. An array has none: it takes less where nearly every pixel has as many fragments as the deepest.",
        ),
        claim(
            "On Table I's model B3D is twice as fast as DFB",
            screens,
            each(&DFBS, &|dfb| {
                table(entries, |entry| Some(2 * entry.total(B3D)? <= entry.total(dfb)?))
            }),
            "B3D takes each fragment twice, to store and to resolve it; DFB takes it three times, and scans. Three to two \
             is what is left where memory gives a word each cycle and geometry costs nothing.",
        ),
        claim(
            "On Table I's model dfb:fast is at least as fast as lists",
            screens,
            each(&LISTS, &|list| {
                table(entries, |entry| Some(entry.total(DFB)? <= entry.total(list)?))
            }),
            "On the card lists pay for a counter that all fragments share, and for links. Here the counter gives a page a \
             cycle, the links are on chip, and a list that does not overflow takes each fragment once where DFB takes it twice.",
        ),
        claim(
            "B3D is the fastest where it fits",
            frames,
            each(&[B3D], &|_| b3d_fastest(entries)),
            "Another machine took fewer cycles.",
        ),
        claim(
            "Above 25 % coverage DFB is the second",
            frames,
            each(&DFBS, &|dfb| second(entries, dfb)),
            "A list whose frame fits at once takes each fragment once where DFB takes it twice, and a pointer costs \
             nothing while tables are on chip: rebuilds alone make a list slower.",
        ),
        claim(
            "Without B3D, DFB is the fastest in 8 of 9 walks around models",
            walks,
            each(&DFBS, &|dfb| fastest_walks(entries, dfb)),
            "Once lists have room a frame comes to them once, and to DFB twice; a rebuild, if there is one, is paid by one frame for \
             all that follow.",
        ),
        claim(
            "Lists peak where frames are rebuilt",
            walks,
            each(&LISTS, &|list| peaks(entries, list)),
            "No frame of a walk was rebuilt, or those that were took no more for a fragment than others.",
        ),
        claim(
            "The scan is DFB's dearest step",
            frames,
            each(&DFBS, &|dfb| dearest(entries, dfb)),
            "On the card the scan is a library's kernel of its own; here it takes a word of counters a cycle. dfb:fast has 16 \
             counters in a word, so that the scan is dearest only where there are fewer fragments than words. dfb:paper has one, and \
             its resolve looks at every pixel, too.",
        ),
        claim(
            "What the scan takes depends on the resolution alone",
            screens,
            each(&DFBS, &|dfb| screen_alone(entries, dfb)),
            "Frames of one screen took different numbers of cycles.",
        ),
        claim(
            "DFB's cost grows smoothly with the resolution: by no more than a quarter for each pixel",
            "numbers of quads and coverages",
            each(&DFBS, &|dfb| smooth(entries, dfb)),
            "What a pixel costs differs between resolutions.",
        ),
        claim(
            "B3D cannot hold the power plant in 1.5 GB at 800x600, by the deepest pixel of Figure 8's walk",
            walks,
            each(&[B3D], &|_| too_deep(entries)),
            "The frames of this walk have no pixel of so many layers.",
        ),
    ]
}

fn with(entries: &[Entry], machine: Contender) -> impl Iterator<Item = (&Entry, &Run)> {
    entries.iter().filter_map(move |entry| Some((entry, entry.run(machine)?)))
}

fn quads(entry: &Entry) -> Option<(u32, u32)> {
    match entry.figure {
        Figure::Quads(number, percent) => Some((number, percent)),
        _ => None,
    }
}

/// By the paper's rules, for all frames.
fn least_memory(entries: &[Entry], other: Contender) -> Verdict {
    Verdict::of(entries.iter().map(|entry| DFB.bytes(&entry.need) <= other.bytes(&entry.need)))
}

/// For each screen of Table I.
fn table(entries: &[Entry], holds: impl Fn(&Entry) -> Option<bool>) -> Verdict {
    let entries = entries.iter().filter(|entry| entry.figure == Figure::Table);
    Verdict::of(entries.filter_map(holds))
}

fn b3d_fastest(entries: &[Entry]) -> Verdict {
    Verdict::of(with(entries, B3D).map(|(entry, b3d)| {
        let others = DFBS.iter().chain(&LISTS).filter_map(|other| entry.total(*other));
        others.min().is_none_or(|least| b3d.cycles.total <= least)
    }))
}

fn second(entries: &[Entry], dfb: Contender) -> Verdict {
    let covered = with(entries, dfb).filter(|(entry, _)| quads(entry).is_some_and(|(_, p)| p > 25));
    Verdict::of(covered.map(|(entry, run)| {
        let faster =
            |other: &&Contender| entry.total(**other).is_some_and(|t| t < run.cycles.total);
        OTHERS.iter().filter(faster).count() <= 1
    }))
}

/// In eight of nine, as in the paper.
fn fastest_walks(entries: &[Entry], dfb: Contender) -> Verdict {
    let walks = with(entries, dfb).filter(|(entry, _)| matches!(entry.figure, Figure::Walk(_)));
    let verdict = Verdict::of(walks.map(|(entry, run)| {
        let mut lists = LISTS.iter().filter_map(|list| entry.total(*list));
        lists.all(|list| run.cycles.total < list)
    }));
    Verdict { spared: 1, ..verdict }
}

/// For each walk with a rebuild: a fragment costs more in frames that were rebuilt than in those that were not.
fn peaks(entries: &[Entry], list: Contender) -> Verdict {
    let walks = with(entries, list).filter(|(entry, _)| entry.frames.walk().is_some());
    Verdict::of(walks.filter_map(|(_, run)| {
        let (again, once): (Vec<_>, Vec<_>) = run.frames.iter().partition(|frame| frame.plays > 1);
        let cost = |frames: &[&Played]| {
            let sum = |of: fn(&Played) -> u64| frames.iter().map(|f| of(f)).sum::<u64>();
            sum(|frame| frame.cycles.total) as f64 / sum(|frame| frame.stored).max(1) as f64
        };
        (!again.is_empty() && !once.is_empty()).then(|| cost(&again) > cost(&once))
    }))
}

fn dearest(entries: &[Entry], dfb: Contender) -> Verdict {
    Verdict::of(with(entries, dfb).map(|(_, run)| {
        let others = ["count", "store", "resolve"].iter().map(|phase| run.cycles.of(phase));
        others.max() < Some(run.cycles.of("scan"))
    }))
}

/// For each screen: whether all of its frames took the same.
fn screen_alone(entries: &[Entry], dfb: Contender) -> Verdict {
    let mut by_screen: BTreeMap<(u32, u32), Vec<u64>> = BTreeMap::new();
    for (entry, run) in with(entries, dfb) {
        let scans = run.frames.iter().map(|frame| frame.cycles.of("scan"));
        by_screen.entry(entry.frames.screen).or_default().extend(scans);
    }
    let several = by_screen.values().filter(|scans| scans.len() > 1);
    Verdict::of(several.map(|scans| scans.windows(2).all(|pair| pair[0] == pair[1])))
}

/// For each number of quads and coverage: the dearest pixel of a resolution against the cheapest.
fn smooth(entries: &[Entry], dfb: Contender) -> Verdict {
    let mut by_quads: BTreeMap<(u32, u32), Vec<f64>> = BTreeMap::new();
    for (entry, run) in with(entries, dfb) {
        let Some(key) = quads(entry) else { continue };
        let cost = run.cycles.total as f64 / entry.frames.pixels() as f64;
        by_quads.entry(key).or_default().push(cost);
    }
    Verdict::of(by_quads.values().map(|costs| {
        let (least, most) =
            costs.iter().fold((f64::MAX, 0.0_f64), |(a, b), c| (a.min(*c), b.max(*c)));
        most <= 1.25 * least
    }))
}

/// By the closed form, for the deepest pixel of the walk.
fn too_deep(entries: &[Entry]) -> Verdict {
    let tours = entries.iter().filter(|entry| entry.figure == Figure::Tour);
    Verdict::of(tours.map(|entry| {
        let need = Need { pixels: 800 * 600, ..entry.need };
        B3D.lacks(&need).is_some()
    }))
}

#[cfg(test)]
mod tests;
