//! What must hold of a design, and what counts.

use super::reading::{File, Section, StudyError, Value, scalar};
use crate::amount::amount;
use pellucid_testbench::report::grouped;
use serde_json::json;
use std::fmt;
use std::ops::Range;
use toml::de::DeValue;

/// A figure of every point that must be within a bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// `group.name`.
    pub figure: String,
    /// File and line.
    pub place: String,
    /// The bound as the study says it.
    text: String,
    relation: Relation,
    bound: f64,
}

impl fmt::Display for Constraint {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} {}", self.figure, self.text)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    AtMost,
    AtLeast,
    Below,
    Above,
}

/// A figure that is to be as small as it can be, or as large.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// `group.name`.
    pub figure: String,
    /// File and line; nothing where the study states no objective.
    pub place: String,
    /// As large as it can be.
    pub most: bool,
    /// How scenes are brought together.
    pub rule: Rule,
}

/// What a design has where its scenes have one figure each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The mean.
    Mean,
    /// The geometric mean; 0 where a scene has 0.
    Geomean,
    /// The sum.
    Sum,
    /// The smallest.
    Min,
    /// The largest.
    Max,
}

const RULES: [(&str, Rule); 5] = [
    ("mean", Rule::Mean),
    ("geomean", Rule::Geomean),
    ("sum", Rule::Sum),
    ("min", Rule::Min),
    ("max", Rule::Max),
];

/// A key, where it is, and its value.
pub type Entry<'a> = (String, Range<usize>, Value<'a>);

impl Constraint {
    /// `"figure" = "<= 1 MiB"`.
    ///
    /// # Errors
    /// The value is nothing of the kind.
    pub fn read(file: &File, (figure, span, value): Entry) -> Result<Constraint, StudyError> {
        let text = scalar(file, &figure, &value)?;
        let relations = [
            ("<=", Relation::AtMost),
            (">=", Relation::AtLeast),
            ("<", Relation::Below),
            (">", Relation::Above),
        ];
        let found = relations.iter().find_map(|(sign, relation)| {
            let bound = amount(text.trim().strip_prefix(sign)?)?;
            Some((*relation, bound))
        });
        let Some((relation, bound)) = found else {
            let problem = format!(
                "`{figure}` is `{text}`: expected `<=`, `>=`, `<` or `>`, a number and perhaps KiB, MiB, GiB, k, M or \
                 G, as `<= 1 MiB`"
            );
            return Err(file.wrong(&value.span(), problem));
        };
        let place = file.place(&span);
        Ok(Constraint { figure, place, text: text.trim().to_string(), relation, bound })
    }

    /// The sentence about a figure that is not within it.
    pub fn broken(&self, value: f64) -> String {
        format!("`{}` is {}: expected {}", self.figure, written(value), self.text)
    }

    /// Whether a figure is within the bound.
    pub fn holds(&self, value: f64) -> bool {
        match self.relation {
            Relation::AtMost => value <= self.bound,
            Relation::AtLeast => value >= self.bound,
            Relation::Below => value < self.bound,
            Relation::Above => value > self.bound,
        }
    }
}

/// A figure as a table shows it: whole numbers in groups of three digits, others with four behind the point.
pub fn written(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        return grouped(&json!(value as u64));
    }
    format!("{value:.4}")
}

impl Objective {
    /// The one of that figure where the study states none: as small as it can be.
    pub fn least(figure: &str) -> Objective {
        let figure = figure.to_string();
        Objective { figure, place: String::new(), most: false, rule: Rule::Mean }
    }

    /// `"figure" = "min"`, or `{ goal = "min", scenes = "max" }`.
    ///
    /// # Errors
    /// The value is nothing of the kind.
    pub fn read(file: &File, (figure, span, value): Entry) -> Result<Objective, StudyError> {
        let goal = |text: &str| match text {
            "min" => Ok(false),
            "max" => Ok(true),
            _ => Err("expected `min` or `max`".to_string()),
        };
        let rule = |text: &str| {
            let rule = RULES.iter().find(|(name, _)| *name == text).map(|(_, rule)| *rule);
            rule.ok_or_else(|| "expected `mean`, `geomean`, `sum`, `min` or `max`".to_string())
        };
        let (most, rule) = if let DeValue::Table(_) = value.get_ref() {
            let at = value.span();
            let mut section = Section::of(file, &figure, value)?;
            let goal = section.parse("goal", goal)?;
            let rule = section.parse("scenes", rule)?.unwrap_or(Rule::Mean);
            section.end()?;
            let missing =
                || file.wrong(&at, format!("`{figure}` has no `goal`: expected `min` or `max`"));
            (goal.ok_or_else(missing)?, rule)
        } else {
            let text = scalar(file, &figure, &value)?;
            let goal = goal(&text);
            let wrong =
                |problem| file.wrong(&value.span(), format!("`{figure}` is `{text}`: {problem}"));
            (goal.map_err(wrong)?, Rule::Mean)
        };
        Ok(Objective { figure, place: file.place(&span), most, rule })
    }

    /// What it is called where people read it.
    pub fn name(&self) -> String {
        let rule = RULES.iter().find(|(_, rule)| *rule == self.rule).map_or("", |(name, _)| name);
        format!("{}, {rule} over scenes", self.figure)
    }
}

impl Rule {
    /// What a design has, of the figures of its scenes.
    pub fn of(self, values: &[f64]) -> f64 {
        let n = values.len() as f64;
        match self {
            Rule::Mean => values.iter().sum::<f64>() / n,
            Rule::Geomean => (values.iter().map(|value| value.ln()).sum::<f64>() / n).exp(),
            Rule::Sum => values.iter().sum(),
            Rule::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Rule::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

/// Of designs with these objectives, each as small as it can be, those that no other one is as good as in all and better in one:
/// the Pareto front.
pub fn front(designs: &[Vec<f64>]) -> Vec<bool> {
    let better = |a: &[f64], b: &[f64]| {
        a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
    };
    designs.iter().map(|design| !designs.iter().any(|other| better(other, design))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn constraint(text: &str) -> Result<Constraint, String> {
        let file = File::of("s.toml", &format!("\"a.b\" = \"{text}\""));
        let entry = file.table().unwrap().rest().remove(0);
        Constraint::read(&file, entry).map_err(|error| error.to_string())
    }

    #[test]
    fn bounds_with_units() {
        for (text, inside, outside) in [
            ("<= 1 MiB", 1_048_576.0, 1_048_577.0),
            ("<1.5e3", 1499.0, 1500.0),
            (">= 2k", 2000.0, 1999.0),
            ("> 0", 1.0, 0.0),
        ] {
            let constraint = constraint(text).unwrap();
            assert!(constraint.holds(inside) && !constraint.holds(outside), "{text}");
        }
        for text in ["1 MiB", "<= one", "<= 1 MB", "== 1", "<= inf", ""] {
            let message = constraint(text).unwrap_err();
            assert!(
                message.starts_with(&format!("`s.toml`, line 1: `a.b` is `{text}`: ")),
                "{message}"
            );
        }
    }

    #[test]
    fn rules_over_scenes() {
        let values = [1.0, 4.0, 16.0];
        let all = RULES.map(|(_, rule)| rule.of(&values));
        assert_eq!(all.map(|value| (value * 1e9).round() / 1e9), [7.0, 4.0, 21.0, 1.0, 16.0]);
        assert_eq!(Rule::Geomean.of(&[0.0, 5.0]), 0.0);
    }

    proptest! {
        /// Whoever is off the front is beaten by one on it; nobody on it is beaten.
        #[test]
        fn the_front_is_what_nothing_beats(designs in prop::collection::vec(prop::collection::vec(0u8..5, 2), 1..40)) {
            let designs: Vec<Vec<f64>> =
                designs.iter().map(|d| d.iter().map(|x| f64::from(*x)).collect()).collect();
            let on = front(&designs);
            for (k, a) in designs.iter().enumerate() {
                let beats = |b: &Vec<f64>| b[0] <= a[0] && b[1] <= a[1] && b != a;
                let beaten = designs.iter().zip(&on).any(|(b, on)| *on && beats(b));
                prop_assert_eq!(beaten, !on[k]);
            }
        }
    }
}
