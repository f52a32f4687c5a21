//! One figure of a report, and several of them as an object.

use serde_json::{Map, Value as Json, json};

/// One figure: `group.name`.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) group: &'static str,
    pub(crate) name: &'static str,
    pub(crate) value: Json,
    pub(crate) unit: &'static str,
    pub(crate) about: &'static str,
    /// Of one that is not counted.
    pub(crate) basis: Option<Basis>,
}

/// Where a figure that is not counted comes from.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    /// The table or the setting.
    pub(crate) source: String,
    /// How far it may be off, in words.
    pub(crate) error: &'static str,
}

/// What a figure means, as `about` has it.
pub(super) fn meaning(unit: &str, about: &str, basis: Option<&Basis>) -> Json {
    let mut meaning = json!({ "unit": unit, "about": about });
    if let Some(Basis { source, error }) = basis {
        meaning["source"] = json!(source);
        meaning["error"] = json!(error);
    }
    meaning
}

impl Entry {
    /// `group.name`.
    pub(crate) fn key(&self) -> String {
        format!("{}.{}", self.group, self.name)
    }

    /// Its name within its group, where people read it.
    pub(crate) fn label(&self) -> &'static str {
        match self.name {
            "seed" | "seed_bytes" => "as the paper counts",
            "seed_bytes_used" => "as the paper counts, in use",
            name => name,
        }
    }

    /// Its name with its group, where people read it.
    pub(crate) fn full_label(&self) -> String {
        match self.label() {
            label if label == self.name => self.key(),
            label => format!("{} {label}", self.group),
        }
    }
}

/// Adds figures to `groups`, nested by group; unit and sentence of each, by its key.
pub(crate) fn nest<'a>(
    entries: impl IntoIterator<Item = &'a Entry>,
    groups: &mut Map<String, Json>,
) -> Map<String, Json> {
    let mut about = Map::new();
    for e in entries {
        let group = groups.entry(e.group).or_insert_with(|| json!({}));
        group[e.name] = e.value.clone();
        about.insert(e.key(), meaning(e.unit, e.about, e.basis.as_ref()));
    }
    about
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_people_read_says_by_whom_it_is_counted() {
        let entry =
            |group, name| Entry { group, name, value: json!(1), unit: "", about: "", basis: None };
        let label = |group, name| entry(group, name).full_label();
        assert_eq!(label("accesses", "seed"), "accesses as the paper counts");
        assert_eq!(label("storage", "seed_bytes_used"), "storage as the paper counts, in use");
        assert_eq!(label("accesses", "full"), "accesses.full");
        assert_eq!(entry("storage", "seed_bytes").key(), "storage.seed_bytes");
    }
}
