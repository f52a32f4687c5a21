//! What a paper says, and whether it is so in clocked hardware.

use pellucid_testbench::html::escaped;
use serde_json::{Value as Json, json};

/// A sentence of the paper.
pub struct Claim {
    /// The sentence.
    pub sentence: &'static str,
    /// What a case is.
    pub cases: &'static str,
    /// For each machine that it is about, or that it is against, in how many of how many cases it is so.
    pub verdicts: Vec<(String, Verdict)>,
    /// What speaks against it, where it does not hold.
    pub why: &'static str,
}

/// In how many cases something is so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// In so many it is.
    pub held: u64,
    /// Of so many.
    pub cases: u64,
    /// In so many it may not be.
    pub spared: u64,
}

impl Verdict {
    /// Of what is so in each case.
    pub fn of(cases: impl IntoIterator<Item = bool>) -> Verdict {
        let mut verdict = Verdict::default();
        for held in cases {
            verdict.cases += 1;
            verdict.held += u64::from(held);
        }
        verdict
    }

    /// Whether it is so: in every case but those that are spared. What has no case does not hold.
    pub fn holds(&self) -> bool {
        self.cases > 0 && self.held + self.spared >= self.cases
    }
}

impl Claim {
    /// Whether it holds for every machine that it is about.
    pub fn holds(&self) -> bool {
        self.verdicts.iter().all(|(_, verdict)| verdict.holds())
    }

    /// The verdicts in words, and what speaks against it if something does.
    pub fn words(&self) -> String {
        let verdicts = self.verdicts.iter().map(|(name, verdict)| {
            let holds = if verdict.holds() { "holds" } else { "does not hold" };
            format!("{name}: {holds}, {} of {} {}", verdict.held, verdict.cases, self.cases)
        });
        verdicts.collect::<Vec<_>>().join("; ")
    }

    /// What speaks against it, if something does.
    pub fn objection(&self) -> Option<&'static str> {
        (!self.holds()).then_some(self.why)
    }

    /// As an object.
    pub fn json(&self) -> Json {
        let verdicts = self.verdicts.iter().map(|(machine, v)| {
            json!({ "of": machine, "holds": v.holds(), "held": v.held, "cases": v.cases })
        });
        let verdicts: Vec<Json> = verdicts.collect();
        json!({ "claim": self.sentence, "cases_are": self.cases, "holds": self.holds(), "verdicts": verdicts, "why_not": self.objection() })
    }
}

/// Claims as text.
pub fn text(claims: &[Claim]) -> String {
    let mut text = String::from("WHAT THE PAPER SAYS\n");
    for claim in claims {
        text += &format!("- {}.\n  {}.\n", claim.sentence, claim.words());
        if let Some(objection) = claim.objection() {
            text += &format!("  {objection}\n");
        }
    }
    text
}

/// Claims as a part of a page.
pub fn html(claims: &[Claim]) -> String {
    let mut text = String::from(
        "<h2>What the paper says</h2>\n<table>\n<tr><th>claim</th><th>here</th></tr>\n",
    );
    for claim in claims {
        let objection = claim.objection().map(|why| format!("<small>{}</small>", escaped(why)));
        text += &format!(
            "<tr><td>{}{}</td><td>{}</td></tr>\n",
            escaped(claim.sentence),
            objection.unwrap_or_default(),
            escaped(&claim.words()).replace("; ", "<br/>")
        );
    }
    text + "</table>\n"
}
