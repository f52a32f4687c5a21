//! The scoreboard: holds a run to the golden model, to the conservation of fragments and to the
//! closed forms.

use crate::golden::Reference;
use crate::image::{Difference, Image};
use pellucid_hw::machine::{Check, Tally};

/// The judgement of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// How far the image is from the golden model's.
    pub image: Difference,
    /// Fragments for which the machine had no place.
    pub dropped: u64,
    /// Why it has none for them.
    pub dropped_since: &'static str,
    /// Every figure that is not what it must be.
    pub wrong: Vec<Check>,
}

impl Verdict {
    /// Judges a run of one frame. `closed_forms` are those of its architecture.
    pub fn new(
        reference: &Reference,
        image: &Image,
        tally: &Tally,
        closed_forms: Vec<Check>,
    ) -> Verdict {
        let f = &tally.fragments;
        let check = |what, expected, found| Check { what, expected, found };
        let mut checks = vec![
            check("fragments that came in", reference.fragments, f.arrived),
            check("opaque fragments, drawn or hidden", reference.opaque, f.drawn + f.hidden),
            check(
                "transparent fragments, blended, culled or dropped",
                reference.transparent,
                f.blended + f.culled + f.dropped,
            ),
        ];
        if f.dropped == 0 {
            checks.push(check("fragments stored", reference.stored, f.stored));
            checks.push(check("fragments blended", reference.blended, f.blended));
            checks.push(check("fragments culled", reference.culled, f.culled));
            checks.extend(closed_forms);
        }
        Verdict {
            image: image.compare(&reference.image),
            dropped: f.dropped,
            dropped_since: tally.dropped_since,
            wrong: checks.into_iter().filter(|c| c.expected != c.found).collect(),
        }
    }

    /// Whether the image and all counts are what they must be.
    pub fn is_exact(&self) -> bool {
        self.dropped == 0 && self.image.mismatched_pixels == 0 && self.wrong.is_empty()
    }

    /// Whether the run is right but for fragments that it dropped and said so.
    pub fn is_exact_but_for_drops(&self) -> bool {
        self.wrong.is_empty() && (self.dropped > 0 || self.image.mismatched_pixels == 0)
    }

    /// One sentence per fault; empty if there is none.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = vec![];
        let difference = self.image.first.map(|(x, y)| {
            format!(
                "{} pixels differ from the golden model, by {} at most, the first at x={x} y={y}",
                self.image.mismatched_pixels, self.image.max_error
            )
        });
        if self.dropped > 0 {
            let difference = difference.map(|text| format!("; {text}")).unwrap_or_default();
            let (dropped, since) = (self.dropped, self.dropped_since);
            faults.push(format!("{dropped} fragments were dropped, {since}{difference}"));
        } else {
            faults.extend(difference);
        }
        for Check { what, expected, found } in &self.wrong {
            faults.push(format!("{what}: expected {expected}, the run counted {found}"));
        }
        faults
    }
}
