//! How a design stands: what it has of each objective, or why it is out; and which designs are on the front.

use super::criteria::front;
use super::points::{Outcome, Status};
use super::study::Study;
use super::work::Candidate;

/// See the module's description.
#[derive(Clone, Debug, PartialEq)]
pub enum Standing {
    /// Not all of its points are there.
    Open,
    /// It is out.
    Out {
        /// Of which kind that is, as many other designs may be.
        kind: String,
        /// Why.
        why: String,
    },
    /// What it has of each objective.
    In(Vec<f64>),
}

impl Standing {
    /// That of a design.
    pub fn of(study: &Study, candidate: &Candidate) -> Standing {
        let outcomes: Option<Vec<&Outcome>> =
            candidate.outcomes.iter().map(Option::as_ref).collect();
        let Some(outcomes) = outcomes else { return Standing::Open };
        let out = |kind: String, why: String| Standing::Out { kind, why };
        let on = |k: usize, what: String| match outcomes.len() {
            1 => what,
            _ => format!("{}: {what}", study.scenes[k].arguments()),
        };
        let not_right = outcomes.iter().position(|outcome| outcome.status != Status::Right);
        if let Some(k) = not_right {
            let Outcome { status, reason, .. } = outcomes[k];
            return out(status.name().to_string(), on(k, format!("{}: {reason}", status.name())));
        }
        let lacks = |figure: &str| {
            let why = format!("it has no figure `{figure}`");
            out(why.clone(), why)
        };
        for constraint in &study.constraints {
            for (k, outcome) in outcomes.iter().enumerate() {
                let value = match outcome.figure(&constraint.figure) {
                    None => return lacks(&constraint.figure),
                    Some(value) if constraint.holds(value) => continue,
                    Some(value) => value,
                };
                return out(format!("not `{constraint}`"), on(k, constraint.broken(value)));
            }
        }
        match objectives(study, candidate) {
            Ok(values) => Standing::In(values),
            Err(figure) => lacks(figure),
        }
    }

    /// What it has of each objective.
    pub fn values(&self) -> Option<&[f64]> {
        match self {
            Standing::In(values) => Some(values),
            Standing::Open | Standing::Out { .. } => None,
        }
    }
}

/// What a design has of each objective, right or not.
///
/// # Errors
/// The figure that it lacks.
pub fn objectives<'a>(study: &'a Study, candidate: &Candidate) -> Result<Vec<f64>, &'a str> {
    let each = study.objectives.iter().map(|objective| {
        let figure = objective.figure.as_str();
        let outcomes = candidate.outcomes.iter();
        let values = outcomes.map(|outcome| outcome.as_ref()?.figure(figure));
        Ok(objective.rule.of(&values.collect::<Option<Vec<f64>>>().ok_or(figure)?))
    });
    each.collect()
}

/// What a design has of each objective, each as small as it can be; nothing if it is out.
pub fn small(study: &Study, standing: &Standing) -> Option<Vec<f64>> {
    let each = standing.values()?.iter().zip(&study.objectives);
    Some(each.map(|(value, objective)| if objective.most { -value } else { *value }).collect())
}

/// For each design how it stands, and whether it is on the front.
pub fn standings(study: &Study, candidates: &[Candidate]) -> Vec<(Standing, bool)> {
    let standings: Vec<Standing> = candidates.iter().map(|c| Standing::of(study, c)).collect();
    let inside: Vec<Vec<f64>> = standings.iter().filter_map(|s| small(study, s)).collect();
    let mut on = front(&inside).into_iter();
    let pair = |standing: Standing| {
        let is_on = standing.values().is_some() && on.next().unwrap_or(false);
        (standing, is_on)
    };
    standings.into_iter().map(pair).collect()
}
