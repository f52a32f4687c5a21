//! Opacity by the name of a mesh, group or material.

use super::SceneError;
use super::geometry::Part;
use pellucid_machine::params::nearest;
use std::fmt;
use std::str::FromStr;

/// Sets the opacity of all parts of a scene, or of those of one name: `0.4` or `NAME=0.4`.
///
/// Opacity is 0..=1 and rounded to 255ths; 1 makes a part opaque, so that it hides what lies behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaRule {
    name: Option<String>,
    alpha: f32,
}

/// A text that is no alpha rule.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
#[error("`{0}` is not an alpha: expected ALPHA or NAME=ALPHA with ALPHA in 0..=1")]
pub struct AlphaRuleError(String);

impl fmt::Display for AlphaRule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "{name}={}", self.alpha),
            None => self.alpha.fmt(f),
        }
    }
}

impl FromStr for AlphaRule {
    type Err = AlphaRuleError;

    fn from_str(text: &str) -> Result<AlphaRule, AlphaRuleError> {
        let (name, alpha) = match text.rsplit_once('=') {
            Some((name, alpha)) => (Some(name), alpha),
            None => (None, text),
        };
        match alpha.parse() {
            Ok(alpha) if (0.0..=1.0).contains(&alpha) && name != Some("") => {
                Ok(AlphaRule { name: name.map(str::to_owned), alpha })
            }
            _ => Err(AlphaRuleError(text.into())),
        }
    }
}

/// Applies the rules in their order to the parts of the scene `scene`.
pub(super) fn apply(
    scene: &str,
    parts: &mut [Part],
    rules: &[AlphaRule],
) -> Result<(), SceneError> {
    for rule in rules {
        let mut found = false;
        for part in &mut *parts {
            if rule.name.as_ref().is_none_or(|name| part.names.contains(name)) {
                part.set_alpha(rule.alpha);
                found = true;
            }
        }
        if let (Some(name), false) = (&rule.name, found) {
            return Err(unknown(scene, name, parts));
        }
    }
    Ok(())
}

fn unknown(scene: &str, name: &str, parts: &[Part]) -> SceneError {
    let mut names: Vec<&str> =
        parts.iter().flat_map(|part| &part.names).map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    let nearest = nearest(name, names.iter().copied());
    SceneError::UnknownPart {
        scene: scene.into(),
        name: name.into(),
        nearest: nearest.map(Into::into),
        known: names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_a_number_or_a_name_and_a_number() {
        assert_eq!("0.4".parse(), Ok(AlphaRule { name: None, alpha: 0.4 }));
        assert_eq!("a=b=1".parse(), Ok(AlphaRule { name: Some("a=b".into()), alpha: 1.0 }));
        for text in ["0.4", "a=b=1"] {
            assert_eq!(text.parse::<AlphaRule>().unwrap().to_string(), text);
        }
        for bad in ["", "x", "1.1", "-0.1", "nan", "=0.5", "lid=", "lid=2"] {
            let error = bad.parse::<AlphaRule>().unwrap_err().to_string();
            assert_eq!(
                error,
                format!(
                    "`{bad}` is not an alpha: expected ALPHA or NAME=ALPHA with ALPHA in 0..=1"
                )
            );
        }
    }
}
