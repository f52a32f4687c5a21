//! Settings as users write them: `NAME=VALUE`, and TOML files of lines `name = value`. The parameters of a part of an
//! architecture have its name before a dot; in a file they may be a table of that name.

use crate::output::reason;
use pellucid_machine::architecture::Setting;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Most bytes of a file.
const MOST_BYTES: u64 = 1 << 20;

/// A text or a file that is no settings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingsError {
    /// The text does not name a parameter and its value.
    #[error("{origin}: expected NAME=VALUE")]
    Form {
        /// Where it was given.
        origin: String,
    },
    /// The file is missing, cannot be read, or is no text.
    #[error("cannot read `{}`: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The file is no TOML.
    #[error("`{}`, line {line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// A value in the file is neither a number nor a string, nor a table of such.
    #[error("`{}`, key `{name}`: found {found}, expected a number or a string", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// The key.
        name: String,
        /// What its value is.
        found: &'static str,
    },
}

/// The setting that `text` gives, `NAME=VALUE`.
///
/// # Errors
/// It has no `=`, or no name before it.
pub fn parse(text: &str, origin: String) -> Result<Setting, SettingsError> {
    match text.split_once('=').map(|(name, value)| (name.trim(), value.trim())) {
        Some((name, value)) if !name.is_empty() => {
            Ok(Setting { name: name.to_string(), value: value.to_string(), origin })
        }
        _ => Err(SettingsError::Form { origin }),
    }
}

/// The same, where a value `@FILE` stands for what is in the file, its lines one after the other.
///
/// # Errors
/// As [`parse`]; the file cannot be read, is no text, or is too long.
pub fn given(text: &str, origin: String) -> Result<Setting, SettingsError> {
    let setting = parse(text, origin)?;
    let Some(path) = setting.value.strip_prefix('@') else { return Ok(setting) };
    let text = self::text(Path::new(path))?;
    let value = text.split_whitespace().collect::<Vec<_>>().join(" ");
    Ok(Setting { value, ..setting })
}

/// The number of the line, from 1, in which a byte of a text stands; that of the first one where there is no such byte.
pub fn line_of(text: &str, byte: usize) -> usize {
    text.get(..byte).unwrap_or_default().matches('\n').count() + 1
}

/// The text of a file of settings.
///
/// # Errors
/// The file cannot be read, is no text, or is too long.
pub fn text(path: &Path) -> Result<String, SettingsError> {
    let refused = |reason| SettingsError::Read { path: path.to_owned(), reason };
    let mut text = String::new();
    let file = File::open(path).map_err(|error| refused(reason(&error)))?;
    // What has no end is not read to it.
    let read = file.take(MOST_BYTES + 1).read_to_string(&mut text);
    if read.map_err(|error| refused(reason(&error)))? as u64 > MOST_BYTES {
        return Err(refused(format!("it is longer than {MOST_BYTES} bytes")));
    }
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// The settings of a TOML file of lines `name = value`, in tables or not.
///
/// # Errors
/// The file cannot be read, or has anything but numbers and strings.
pub fn read(path: &Path) -> Result<Vec<Setting>, SettingsError> {
    let text = text(path)?;
    let table: toml::Table =
        text.parse().map_err(|error: toml::de::Error| SettingsError::Line {
            path: path.to_owned(),
            line: line_of(&text, error.span().unwrap_or_default().start),
            problem: error.message().to_string(),
        })?;
    let mut settings = vec![];
    flatten(path, "", table, &mut settings)?;
    Ok(settings)
}

/// Adds the settings of a table, whose keys come after `before`.
fn flatten(
    path: &Path,
    before: &str,
    table: toml::Table,
    settings: &mut Vec<Setting>,
) -> Result<(), SettingsError> {
    for (key, value) in table {
        let name = format!("{before}{key}");
        let value = match value {
            toml::Value::Integer(n) => n.to_string(),
            toml::Value::String(s) => s,
            toml::Value::Table(table) if !table.is_empty() => {
                flatten(path, &format!("{name}."), table, settings)?;
                continue;
            }
            other => {
                let (path, found) = (path.to_owned(), other.type_str());
                return Err(SettingsError::Kind { path, name, found });
            }
        };
        let origin = format!("`{}`, key `{name}`", path.display());
        settings.push(Setting { name, value, origin });
    }
    Ok(())
}
