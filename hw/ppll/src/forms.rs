//! The closed forms: what a run must have counted, told from how many fragments pixels have.

use super::config::Config;
use pellucid_blocks::rebuild::Growth;
use pellucid_machine::{Census, Check, Tally};

/// Pages that so many fragments of a pixel take.
pub fn pages_of(cfg: &Config, fragments: u64) -> u64 {
    fragments.div_ceil(cfg.params.page.into())
}

/// The same of all pixels, by how many of them have how many fragments.
fn pages(cfg: &Config, histogram: &[u64]) -> u64 {
    histogram.iter().zip(0..).map(|(pixels, n)| pixels * pages_of(cfg, n)).sum()
}

fn fragments(histogram: &[u64]) -> u64 {
    histogram.iter().zip(0..).map(|(pixels, n)| pixels * n).sum()
}

/// What the plays of some frames come to.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Plays {
    /// Plays that were not resolved.
    pub rebuilds: u64,
    /// Pages that they took: all that they were allowed to.
    pub pages_discarded: u64,
    /// Pages and fragments of each frame in the play that was resolved.
    pub resolved: Vec<(u64, u64)>,
    /// Whether in all of these just what is visible was stored.
    pub visible_alone: bool,
    /// Between how many and how many pages are allowed in the end.
    pub allowed: (u64, u64),
}

impl Plays {
    /// Of frames that all fit in the end. Nothing where what they come to depends on the order in which fragments come: with
    /// `growth=needed` a fragment that finds no page asks for one though the next of its pixel will ask for the same, so that what
    /// was asked for is known within bounds alone.
    pub fn of(cfg: &Config, frames: &[Census]) -> Option<Plays> {
        let most = u64::from(cfg.rebuild.most);
        let begin = u64::from(cfg.rebuild.begin);
        let mut plays = Plays { visible_alone: true, allowed: (begin, begin), ..Plays::default() };
        for frame in frames {
            // As it first comes, and as it comes again.
            let mut stored = &frame.histogram;
            loop {
                let need = pages(cfg, stored);
                let (low, high) = plays.allowed;
                if need <= low || low == most {
                    plays.resolved.push((need, fragments(stored)));
                    plays.visible_alone &= *stored == frame.visible;
                    break;
                }
                if need <= high || low != high {
                    return None;
                }
                plays.rebuilds += 1;
                plays.pages_discarded += low;
                let (low, high) = match cfg.rebuild.growth {
                    Growth::Double => (low, high),
                    Growth::Needed => (need, fragments(stored)),
                };
                plays.allowed = (most.min(2 * low), most.min(2 * high));
                stored = &frame.visible;
            }
        }
        Some(plays)
    }
}

/// What a run must have counted.
pub fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
    let check = |what, expected, found| Check { what, expected, found };
    let (page, depth) = (u64::from(cfg.params.page), u64::from(cfg.params.sorter_depth));
    let pixels = u64::from(cfg.screen.pixels());
    let all = Census::together(frames);
    let figure = |name| tally.figure(name);
    let traffic = |path: &str| tally.memory(path).map_or((0, 0), |m| (m.info.reads, m.info.writes));
    let (on_chip, outside) =
        (traffic("chains.sections.on_chip"), traffic("chains.sections.outside"));
    let (links_read, links_written) = traffic("chains.nsa.table");
    let visible = fragments(&all.visible);
    let mut checks = vec![check(
        "accesses as the paper counts them, 3 for each visible fragment and each page of them, 2WH a frame",
        3 * visible + 3 * pages(cfg, &all.visible) + 2 * pixels * frames.len() as u64,
        tally.seed_accesses,
    )];
    // Heads that lie outside are cleared as the memory takes them.
    if !cfg.chains.caches_ssa() {
        let cycles = tally.cycles.of("rebuild").unwrap_or(0);
        let all = pixels * figure("rebuilds");
        checks.push(check("cycles of rebuild, one a pixel each time", all, cycles));
    }
    let Some(plays) = Plays::of(cfg, frames) else { return checks };
    let (low, high) = plays.allowed;
    let allowed = figure("pages_allowed");
    let (used, of_fullest) = plays
        .resolved
        .iter()
        .fold((0, 0), |most: (u64, u64), frame| if frame.0 > most.0 { *frame } else { most });
    let taken: u64 = plays.resolved.iter().map(|(pages, _)| pages).sum();
    let stored: u64 = plays.resolved.iter().map(|(_, fragments)| fragments).sum();
    let again = figure("fragments_read_again");
    checks.extend([
        check("frames that are played again, while pages are too few", plays.rebuilds, figure("rebuilds")),
        check("pages that may be used in the end", allowed.clamp(low, high), allowed),
        check("pages of the fullest frame, sum of N_i * ceil(i / page)", used, figure("pages_used")),
        check("slots of them that stay empty", used * page - of_fullest, figure("slots_wasted")),
        check(
            "fragments written to pages, those of plays that are resolved and those that are discarded",
            stored + figure("discarded"),
            on_chip.1 + outside.1,
        ),
        check("fragments read from pages, and those read again", stored + again, on_chip.0 + outside.0),
        check("links written, one a page", taken + plays.pages_discarded, links_written),
    ]);
    if page == 1 {
        checks.push(check(
            "fragments discarded, one a page",
            plays.pages_discarded,
            figure("discarded"),
        ));
    }
    // How often a pixel is read hangs on how many of its fragments are visible.
    if plays.visible_alone {
        let passes = |n: u64| n.div_ceil(depth);
        let of_all = |of: &dyn Fn(u64) -> u64| -> u64 {
            all.visible.iter().zip(0..).map(|(pixels, n)| pixels * passes(n) * of(n)).sum()
        };
        checks.extend([
            check("links read, one a page and pass", of_all(&|n| pages_of(cfg, n)), links_read),
            check("fragments read again, in each further pass", of_all(&|n| n) - stored, again),
        ]);
    } else if again == 0 {
        checks.push(check("links read, one a page", taken, links_read));
    }
    checks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::small_ppll;

    /// A frame of which so many pixels have 0, 1, 2... fragments when they come, and in the end.
    fn frame(histogram: &[u64], visible: &[u64]) -> Census {
        let (histogram, visible) = (histogram.to_vec(), visible.to_vec());
        let stored = fragments(&histogram);
        Census { transparent: stored, stored, histogram, visible }
    }

    fn plays(growth: Growth, frames: &[Census]) -> Option<Plays> {
        let mut cfg = small_ppll("ppll4", "rebuild");
        cfg.rebuild.growth = growth;
        Plays::of(&cfg, frames)
    }

    /// 5 pages of 4 to begin with, 13 at most.
    #[test]
    fn the_limit_is_doubled_until_all_have_a_page() {
        // 2 + 3 * 2 pages, of which the last pixel is hidden in the end.
        let one = frame(&[0, 2, 0, 0, 0, 3], &[1, 2, 0, 0, 0, 2]);
        let expected = Plays {
            rebuilds: 1,
            pages_discarded: 5,
            resolved: vec![(6, 12)],
            visible_alone: true,
            allowed: (10, 10),
        };
        assert_eq!(plays(Growth::Double, std::slice::from_ref(&one)), Some(expected));
        // It fits at once the second time, with what is hidden; a third frame needs all there are.
        let twelve = frame(&[0, 12], &[0, 12]);
        let expected = Plays {
            rebuilds: 2,
            pages_discarded: 15,
            resolved: vec![(6, 12), (8, 17), (12, 12)],
            visible_alone: false,
            allowed: (13, 13),
        };
        assert_eq!(plays(Growth::Double, &[one.clone(), one, twelve]), Some(expected));
    }

    #[test]
    fn what_is_needed_is_known_within_bounds() {
        let one = frame(&[0, 2, 0, 0, 1], &[0, 2, 0, 0, 1]);
        let fits = Plays {
            resolved: vec![(3, 6)],
            visible_alone: true,
            allowed: (5, 5),
            ..Plays::default()
        };
        assert_eq!(plays(Growth::Needed, std::slice::from_ref(&one)), Some(fits));
        // 6 pages of 6 fragments: 12 are allowed then, whatever the order.
        let six = frame(&[0, 6], &[0, 6]);
        let again = Plays {
            rebuilds: 1,
            pages_discarded: 5,
            resolved: vec![(6, 6)],
            visible_alone: true,
            allowed: (12, 12),
        };
        assert_eq!(plays(Growth::Needed, std::slice::from_ref(&six)), Some(again));
        let full = frame(&[0, 13], &[0, 13]);
        assert_eq!(plays(Growth::Needed, &[six, full]).unwrap().rebuilds, 2);
        // 6 pages of 7 fragments: 12 or 13.
        let seven = frame(&[0, 5, 1], &[0, 5, 1]);
        assert_eq!(plays(Growth::Needed, std::slice::from_ref(&seven)).unwrap().allowed, (12, 13));
        let thirteen = frame(&[0, 13], &[0, 13]);
        assert_eq!(plays(Growth::Needed, &[seven, thirteen]), None);
    }
}
