//! Reads keys of a part's file, and says what is wrong with one.

use super::PartError;
use pellucid_machine::architecture::quoted;
use pellucid_machine::params::nearest;
use std::str::FromStr;
use toml::{Table, Value};

/// Who reads: the file, for messages.
#[derive(Clone, Copy)]
pub struct Keys<'a> {
    pub file: &'a str,
}

impl Keys<'_> {
    fn value(&self, key: &str, found: Option<&Value>, expected: String) -> PartError {
        let found = match found {
            None => "missing".to_string(),
            Some(Value::Table(_)) => "a table".to_string(),
            Some(Value::String(text)) => format!("`{text}`"),
            Some(value) => format!("`{value}`"),
        };
        PartError::Value { file: self.file.to_string(), key: key.to_string(), found, expected }
    }

    /// That no key of `table` is other than `known`; `section` stands before it, with a dot.
    pub fn known(
        &self,
        section: &str,
        table: &Table,
        known: &[&'static str],
    ) -> Result<(), PartError> {
        match table.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(PartError::Unknown {
                file: self.file.to_string(),
                key: format!("{section}{key}"),
                nearest: nearest(key, known.iter().copied()),
                known: quoted(known),
            }),
        }
    }

    /// A text of at least one character.
    pub fn text<'t>(&self, key: &str, value: Option<&'t Value>) -> Result<&'t str, PartError> {
        match value {
            Some(Value::String(text)) if !text.is_empty() => Ok(text),
            found => Err(self.value(key, found, "a text".to_string())),
        }
    }
}

/// A section of the file.
pub struct Section<'a> {
    keys: Keys<'a>,
    name: &'static str,
    table: &'a Table,
}

impl<'a> Section<'a> {
    /// The section `name` of the whole file.
    pub fn new(
        keys: Keys<'a>,
        name: &'static str,
        file: &'a Table,
    ) -> Result<Section<'a>, PartError> {
        match file.get(name) {
            Some(Value::Table(table)) => Ok(Section { keys, name, table }),
            found => Err(keys.value(name, found, format!("a section `[{name}]`"))),
        }
    }

    /// That it has no key but these.
    pub fn known(&self, known: &[&'static str]) -> Result<(), PartError> {
        self.keys.known(&format!("{}.", self.name), self.table, known)
    }

    /// Whether it has that key.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    fn wrong(&self, key: &str, expected: String) -> PartError {
        self.keys.value(&format!("{}.{key}", self.name), self.table.get(key), expected)
    }

    /// A whole number in a range.
    pub fn number(&self, key: &str, min: u64, max: u64) -> Result<u64, PartError> {
        self.table
            .get(key)
            .and_then(Value::as_integer)
            .and_then(|n| u64::try_from(n).ok())
            .filter(|n| (min..=max).contains(n))
            .ok_or_else(|| self.wrong(key, format!("a whole number from {min} to {max}")))
    }

    /// A power of two in a range.
    pub fn size(&self, key: &str, min: u32, max: u32) -> Result<u32, PartError> {
        self.table
            .get(key)
            .and_then(Value::as_integer)
            .and_then(|n| u32::try_from(n).ok())
            .filter(|n| (min..=max).contains(n) && n.is_power_of_two())
            .ok_or_else(|| self.wrong(key, format!("a power of two from {min} to {max}")))
    }

    /// One of a few names.
    pub fn choice<T: FromStr>(&self, key: &str, known: &[&'static str]) -> Result<T, PartError> {
        self.table
            .get(key)
            .and_then(Value::as_str)
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| self.wrong(key, format!("one of {}", quoted(known))))
    }
}
