//! A part: how a device is organised, and its timing, as a table in a TOML file.
//!
//! The parts that are shipped are such files (`src/parts/`), which can be copied and changed. All keys must be there, but those
//! for the refresh of single banks and the section of energies. What contradicts itself is refused.

mod check;
mod energy;
mod keys;
mod organisation;
mod timing;

pub use energy::Energy;
pub use organisation::{CommandBuses, Organisation};
pub use timing::{BankRefresh, Timing};

use crate::names::NameError;
use keys::{Keys, Section};
use pellucid_machine::params::did_you_mean;
use std::path::Path;

/// What is wrong with a part's file.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// No part of that name is shipped.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The file could not be read.
    #[error("{file}: {error}")]
    Read {
        /// Its path.
        file: String,
        /// Why.
        error: std::io::Error,
    },
    /// It is no TOML.
    #[error("{file}: {error}")]
    Syntax {
        /// Its path.
        file: String,
        /// Where and why.
        error: toml::de::Error,
    },
    /// A key that no part has.
    #[error("{file}: unknown key `{key}`{}; known are {known}", did_you_mean(.nearest))]
    Unknown {
        /// The file's path.
        file: String,
        /// The key, with its section.
        key: String,
        /// The known key of that section that is most like it.
        nearest: Option<&'static str>,
        /// All of that section.
        known: String,
    },
    /// A key that is not there, or whose value cannot be.
    #[error("{file}: `{key}` is {found}: expected {expected}")]
    Value {
        /// The file's path.
        file: String,
        /// The key, with its section.
        key: String,
        /// What was found.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// Values that contradict each other.
    #[error("{file}: {text}")]
    Together {
        /// The file's path.
        file: String,
        /// Which, and what was expected.
        text: String,
    },
}

/// A DRAM device. One that is changed by a program must be one that a file could say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// How it is organised.
    pub organisation: Organisation,
    /// Its timing.
    pub timing: Timing,
    /// What its commands take, where that is known.
    pub energy: Option<Energy>,
}

const SHIPPED: [(&str, &str); 4] = [
    ("ddr4-3200", include_str!("parts/ddr4-3200.toml")),
    ("lpddr5-6400", include_str!("parts/lpddr5-6400.toml")),
    ("gddr6-14000", include_str!("parts/gddr6-14000.toml")),
    ("hbm3-6400", include_str!("parts/hbm3-6400.toml")),
];

/// A file's path as errors call it, and its text.
fn read(path: &Path) -> Result<(String, String), PartError> {
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => Ok((file, text)),
        Err(error) => Err(PartError::Read { file, error }),
    }
}

fn table(file: &str, text: &str) -> Result<toml::Table, PartError> {
    text.parse().map_err(|error| PartError::Syntax { file: file.to_string(), error })
}

impl Part {
    /// Names of the parts that are shipped.
    pub const NAMES: [&str; 4] = [SHIPPED[0].0, SHIPPED[1].0, SHIPPED[2].0, SHIPPED[3].0];

    /// The file of a part that is shipped, to copy and change.
    ///
    /// # Errors
    /// No part has that name.
    pub fn file(name: &str) -> Result<&'static str, PartError> {
        match SHIPPED.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Ok(text),
            None => Err(NameError::new("part", name, &Part::NAMES).into()),
        }
    }

    /// A part that is shipped.
    ///
    /// # Errors
    /// No part has that name.
    pub fn named(name: &str) -> Result<Part, PartError> {
        Part::parse(name, Part::file(name)?)
    }

    /// A part from a user's file.
    ///
    /// # Errors
    /// The file cannot be read, or [`Part::parse`] refuses it.
    pub fn open(path: &Path) -> Result<Part, PartError> {
        let (file, text) = read(path)?;
        Part::parse(&file, &text)
    }

    /// A part from the text of a file; `file` is what errors call it.
    ///
    /// # Errors
    /// The text is no TOML, a key is unknown or missing, a value is out of its range, or values contradict each other.
    pub fn parse(file: &str, text: &str) -> Result<Part, PartError> {
        let table = table(file, text)?;
        let keys = Keys { file };
        keys.known("", &table, &["name", "organisation", "timing", "energy"])?;
        let name = keys.text("name", table.get("name"))?.to_string();
        let section = |name| Section::new(keys, name, &table);
        let part = Part {
            name,
            organisation: Organisation::read(&section("organisation")?)?,
            timing: Timing::read(&section("timing")?)?,
            energy: match table.contains_key("energy") {
                true => Some(Energy::read(&section("energy")?)?),
                false => None,
            },
        };
        match check::contradiction(&part) {
            None => Ok(part),
            Some(text) => Err(PartError::Together { file: file.to_string(), text }),
        }
    }
}

#[cfg(test)]
mod tests;
