//! What a study asks of a machine: its parameters with the values that each may have.

use super::reading::{File, Section, StudyError, Value, expected, scalar};
use exmex::{Express, FlatEx};
use pellucid_machine::architecture::Setting;
use std::ops::Range;
use toml::de::DeValue;

/// The most values of a range that are tried one by one.
const MOST_STEPS: u32 = 10_000;

/// A parameter, and where a study says what it may be.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The parameter's name.
    pub name: String,
    /// File and line.
    pub place: String,
    /// Its values.
    pub values: Values,
}

/// The values of a parameter.
#[derive(Clone, Debug)]
pub enum Values {
    /// One of these.
    List(Vec<String>),
    /// A whole number from the first to the last, both included.
    Span {
        /// The first.
        from: u32,
        /// The last.
        to: u32,
        /// How many a grid has of them.
        steps: Option<u32>,
        /// Whether steps are factors.
        log2: bool,
    },
    /// What the other parameters give.
    Formula(Box<FlatEx<f64>>),
}

impl Values {
    /// A list, range, formula or a single value.
    fn read(file: &File, name: &str, value: Value) -> Result<Values, StudyError> {
        let span = value.span();
        if let DeValue::Table(_) = value.get_ref() {
            return Values::span(Section::of(file, name, value)?);
        }
        if let DeValue::Array(each) = value.get_ref() {
            if each.is_empty() {
                let problem = format!("`{name}` has no values: expected at least one");
                return Err(file.wrong(&span, problem));
            }
            let list: Vec<String> =
                each.iter().map(|value| scalar(file, name, value)).collect::<Result<_, _>>()?;
            let twice = list.iter().enumerate().find(|(k, value)| list[..*k].contains(value));
            if let Some((_, twice)) = twice {
                return Err(file.wrong(&span, format!("`{name}` has the value `{twice}` twice")));
            }
            return Ok(Values::List(list));
        }
        let text = scalar(file, name, &value).map_err(|_| {
            let what = "a number, a string, a list of such, or a range with `from` and `to`";
            file.wrong(&span, expected(name, value.get_ref(), what))
        })?;
        let Some(formula) = text.strip_prefix('=') else { return Ok(Values::List(vec![text])) };
        let formula = FlatEx::parse(formula.trim()).map_err(|error| {
            let error = error.to_string();
            file.wrong(&span, format!("`{name}`: `{text}` is no formula: {error}"))
        })?;
        Ok(Values::Formula(Box::new(formula)))
    }

    fn span(mut section: Section) -> Result<Values, StudyError> {
        let number = |text: &str| {
            text.parse::<u32>()
                .map_err(|_| format!("expected a whole number from 0 to {}", u32::MAX))
        };
        let steps = |text: &str| {
            let steps = text.parse().ok().filter(|steps| (2..=MOST_STEPS).contains(steps));
            steps.ok_or_else(|| format!("expected a whole number from 2 to {MOST_STEPS}"))
        };
        let scale = |text: &str| match text {
            "linear" => Ok(false),
            "log2" => Ok(true),
            _ => Err("expected `linear` or `log2`".to_string()),
        };
        let from = section.parse("from", number)?;
        let to = section.parse("to", number)?;
        let steps = section.parse("steps", steps)?;
        let log2 = section.parse("scale", scale)?.unwrap_or(false);
        let (file, span) = (section.file, section.span.clone());
        section.end()?;
        let (Some(from), Some(to)) = (from, to) else {
            return Err(file.wrong(&span, "a range has `from` and `to`".into()));
        };
        if from >= to {
            let problem =
                format!("the range from {from} to {to} is empty: expected `from` below `to`");
            return Err(file.wrong(&span, problem));
        }
        if log2 && from == 0 {
            let problem = "a range by `log2` cannot begin at 0".to_string();
            return Err(file.wrong(&span, problem));
        }
        Ok(Values::Span { from, to, steps, log2 })
    }

    /// All that a grid tries; nothing for a range without steps. A formula adds nothing to a grid.
    pub fn grid(&self) -> Option<Vec<String>> {
        match self {
            Values::List(list) => Some(list.clone()),
            Values::Span { steps: None, .. } => None,
            Values::Span { steps: Some(steps), .. } => {
                let last = f64::from(steps - 1);
                let mut all: Vec<String> =
                    (0..*steps).filter_map(|k| self.on_span(f64::from(k) / last)).collect();
                all.dedup();
                Some(all)
            }
            Values::Formula(_) => Some(vec![String::new()]),
        }
    }

    /// The value at a share of the way, 0 or more and below 1. What a formula gives is filled in later.
    pub fn at(&self, share: f64) -> String {
        match self {
            Values::List(list) => {
                list[((share * list.len() as f64) as usize).min(list.len() - 1)].clone()
            }
            Values::Span { .. } => self.on_span(share).unwrap_or_default(),
            Values::Formula(_) => String::new(),
        }
    }

    /// A value that was asked for; the only one if none was.
    ///
    /// # Errors
    /// It is none of these, as a sentence that begins with a verb.
    pub fn checked(&self, asked: Option<&str>) -> Result<String, String> {
        match (self, asked) {
            (Values::Formula(_), None) => Ok(String::new()),
            (Values::Formula(_), Some(_)) => Err("is what its formula gives".to_string()),
            (Values::List(list), None) if list.len() == 1 => Ok(list[0].clone()),
            (Values::List(list), Some(asked)) if list.iter().any(|value| value == asked) => {
                Ok(asked.to_string())
            }
            (Values::Span { from, to, .. }, Some(asked))
                if asked.parse().is_ok_and(|value: u32| (*from..=*to).contains(&value)) =>
            {
                Ok(asked.to_string())
            }
            (_, None) => Err(format!("is missing: expected {}", self.expected())),
            (_, Some(asked)) => Err(format!("is `{asked}`: expected {}", self.expected())),
        }
    }

    fn expected(&self) -> String {
        match self {
            Values::List(list) => format!("one of `{}`", list.join("`, `")),
            Values::Span { from, to, .. } => format!("a whole number from {from} to {to}"),
            Values::Formula(_) => "nothing".to_string(),
        }
    }

    /// A whole number of a range, where 0 is its first and 1 its last.
    fn on_span(&self, share: f64) -> Option<String> {
        let Values::Span { from, to, log2, .. } = *self else { return None };
        let [first, last] = [from, to].map(f64::from);
        let value = match log2 {
            true => first * (last / first).powf(share),
            false => first + (last - first) * share,
        };
        Some((value.round() as u32).clamp(from, to).to_string())
    }
}

/// The parameters of a table, with those of its parts, in the order of the file.
///
/// # Errors
/// A value is none that a parameter can have.
pub fn axes(
    file: &File,
    before: &str,
    entries: Vec<(String, Range<usize>, Value)>,
) -> Result<Vec<Axis>, StudyError> {
    let mut axes = vec![];
    for (key, span, value) in entries {
        let name = format!("{before}{key}");
        let is_part = match value.get_ref() {
            DeValue::Table(table) => !table.contains_key("from") && !table.contains_key("to"),
            _ => false,
        };
        if is_part {
            let part = Section::of(file, &name, value)?;
            axes.extend(self::axes(file, &format!("{name}."), part.rest())?);
        } else {
            let values = Values::read(file, &name, value)?;
            axes.push(Axis { name, place: file.place(&span), values });
        }
    }
    Ok(axes)
}

/// A formula stands on parameters of the same machine whose values are numbers, and that are no formulas themselves.
///
/// # Errors
/// One does not.
pub fn check_formulas(axes: &[Axis]) -> Result<(), StudyError> {
    let is_number = |name: &String| {
        axes.iter().any(|axis| match &axis.values {
            Values::List(list) => {
                axis.name == *name && list.iter().all(|v| v.parse::<f64>().is_ok())
            }
            Values::Span { .. } => axis.name == *name,
            Values::Formula(_) => false,
        })
    };
    for axis in axes {
        let Values::Formula(formula) = &axis.values else { continue };
        if let Some(name) = formula.var_names().iter().find(|name| !is_number(name)) {
            let problem = format!(
                "the formula of `{}` stands on `{name}`: expected a parameter that this machine gives numbers, and no formula",
                axis.name
            );
            return Err(StudyError::Line { place: axis.place.clone(), problem });
        }
    }
    Ok(())
}

/// Fills in what formulas give, as whole numbers rounded down. The formulas are checked.
///
/// # Errors
/// A result that no parameter can have, as a sentence.
pub fn settle(axes: &[Axis], given: &[String]) -> Result<Vec<Setting>, String> {
    let number = |name: &String| {
        let at = axes.iter().position(|axis| axis.name == *name);
        at.and_then(|at| given[at].parse().ok()).unwrap_or(f64::NAN)
    };
    let each = axes.iter().zip(given).map(|(axis, given)| {
        let value = match &axis.values {
            Values::Formula(formula) => {
                let values: Vec<f64> = formula.var_names().iter().map(number).collect();
                let value = formula.eval(&values).unwrap_or(f64::NAN).floor();
                if !(0.0..=f64::from(u32::MAX)).contains(&value) {
                    return Err(format!(
                        "the formula of `{}` gives {value}: expected a whole number from 0 to {}",
                        axis.name,
                        u32::MAX
                    ));
                }
                (value as u32).to_string()
            }
            _ => given.clone(),
        };
        Ok(Setting { name: axis.name.clone(), value, origin: axis.place.clone() })
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Axis>, StudyError> {
        let file = File::of("s.toml", text);
        axes(&file, "", file.table()?.rest())
    }

    fn message(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn values_of_a_parameter() {
        let axes = read(
            "a = 3\nb = [\"x\", \"y\"]\nc = { from = 1, to = 64, steps = 4, scale = \"log2\" }\n\
             d = { from = 0, to = 10, steps = 3 }\ne = \"= a * floor(c / 2)\"\npart.f = 7\n\
             g = { from = 5, to = 6 }\n",
        )
        .unwrap();
        let grids: Vec<Option<Vec<String>>> = axes.iter().map(|axis| axis.values.grid()).collect();
        let list = |of: &[&str]| Some(of.iter().map(|s| s.to_string()).collect::<Vec<_>>());
        assert_eq!(
            axes.iter().map(|a| &*a.name).collect::<Vec<_>>(),
            ["a", "b", "c", "d", "e", "part.f", "g"]
        );
        assert_eq!(
            grids,
            [
                list(&["3"]),
                list(&["x", "y"]),
                list(&["1", "4", "16", "64"]),
                list(&["0", "5", "10"]),
                list(&[""]),
                list(&["7"]),
                None
            ]
        );
        assert_eq!(axes[2].values.at(0.999_999), "64");
        assert_eq!((axes[1].values.at(0.49), axes[1].values.at(0.5)), ("x".into(), "y".into()));
        let given = ["3", "x", "5", "0", "", "7", "5"].map(String::from);
        check_formulas(&axes).unwrap();
        let settings = settle(&axes, &given).unwrap();
        assert_eq!(settings[4].value, (3 * (5 / 2)).to_string());
        assert_eq!(settings[4].origin, "`s.toml`, line 5");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert_eq!(message("x = []"), "`s.toml`, line 1: `x` has no values: expected at least one");
        assert_eq!(message("\nx = [1, 2, 1]"), "`s.toml`, line 2: `x` has the value `1` twice");
        assert_eq!(
            message("x = { from = 4, to = 4 }"),
            "`s.toml`, line 1: the range from 4 to 4 is empty: expected `from` below `to`"
        );
        assert_eq!(
            message("x = { from = 0, to = 4, scale = \"log2\" }"),
            "`s.toml`, line 1: a range by `log2` cannot begin at 0"
        );
        assert_eq!(
            message("x = { from = 0, to = 4, step = 2 }"),
            "`s.toml`, line 1: unknown key `x.step` (did you mean `steps`?); known are `from`, `to`, `steps`, `scale`"
        );
        assert!(
            message("x = \"= 3 +\"").starts_with("`s.toml`, line 1: `x`: `= 3 +` is no formula: ")
        );
        for other in ["y = \"name\"", "y = \"= 3\"", "z = 3"] {
            let axes = read(&format!("x = \"= y\"\n{other}\n")).unwrap();
            let error = check_formulas(&axes).unwrap_err().to_string();
            assert!(
                error.starts_with("`s.toml`, line 1: the formula of `x` stands on `y`: "),
                "{error}"
            );
        }
        let axes = read("x = \"= 1 / 0\"\n").unwrap();
        let error = settle(&axes, &[String::new()]).unwrap_err();
        assert!(error.starts_with("the formula of `x` gives inf: "), "{error}");
    }
}
