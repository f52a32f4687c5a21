//! A TOML file of which every complaint names the line.

use pellucid_machine::params::{did_you_mean, nearest};
use pellucid_testbench::settings::{self, SettingsError};
use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What is wrong with a study, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] SettingsError),
    /// Something in it.
    #[error("{place}: {problem}")]
    Line {
        /// File and line, as a user knows them.
        place: String,
        /// What is wrong there, and what was expected.
        problem: String,
    },
}

/// The text of a study.
pub struct File {
    path: PathBuf,
    text: String,
}

/// A value with its place.
pub type Value<'a> = Spanned<DeValue<'a>>;

impl File {
    /// Reads it.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(path: &Path) -> Result<File, StudyError> {
        let text = settings::text(path)?;
        Ok(File { path: path.to_owned(), text })
    }

    /// A text that stands in no file.
    #[cfg(test)]
    pub fn of(name: &str, text: &str) -> File {
        File { path: name.into(), text: text.into() }
    }

    /// Its tables.
    ///
    /// # Errors
    /// It is no TOML.
    pub fn table(&self) -> Result<Section<'_>, StudyError> {
        let table = DeTable::parse(&self.text).map_err(|error| {
            self.wrong(&error.span().unwrap_or_default(), error.message().to_string())
        })?;
        let span = table.span();
        Ok(Section::new(self, String::new(), span, table.into_inner()))
    }

    /// File and line of a place.
    pub fn place(&self, span: &Range<usize>) -> String {
        let line = settings::line_of(&self.text, span.start);
        format!("`{}`, line {line}", self.path.display())
    }

    /// An error there.
    pub fn wrong(&self, span: &Range<usize>, problem: String) -> StudyError {
        StudyError::Line { place: self.place(span), problem }
    }
}

/// A table whose keys are taken one by one: what is left at the end is unknown.
pub struct Section<'a> {
    /// The file.
    pub file: &'a File,
    /// Where it is.
    pub span: Range<usize>,
    name: String,
    left: Vec<(String, Range<usize>, Value<'a>)>,
    known: Vec<&'static str>,
}

impl<'a> Section<'a> {
    fn new(file: &'a File, name: String, span: Range<usize>, table: DeTable<'a>) -> Section<'a> {
        let entry = |(key, value): (Spanned<_>, _)| {
            let span = key.span();
            let key: Cow<str> = key.into_inner();
            (key.into_owned(), span, value)
        };
        let mut left: Vec<_> = table.into_iter().map(entry).collect();
        left.sort_by_key(|(_, span, _)| span.start);
        Section { file, span, name, left, known: vec![] }
    }

    /// The table that a value is; its name is for messages.
    ///
    /// # Errors
    /// It is none.
    pub fn of(file: &'a File, name: &str, value: Value<'a>) -> Result<Section<'a>, StudyError> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Ok(Section::new(file, name.to_string(), span, table)),
            other => Err(file.wrong(&span, expected(name, &other, "a table"))),
        }
    }

    /// Takes a key out, if it is there.
    pub fn take(&mut self, key: &'static str) -> Option<Value<'a>> {
        self.known.push(key);
        let at = self.left.iter().position(|(name, ..)| name == key)?;
        Some(self.left.remove(at).2)
    }

    /// Takes out a key whose value is read from its text, as it is read from a command line.
    ///
    /// # Errors
    /// The value is not what `read` wants, or neither a number nor a text.
    pub fn parse<T>(
        &mut self,
        key: &'static str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, StudyError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let text = scalar(self.file, &self.path(key), &value)?;
        let parsed = read(&text).map_err(|problem| {
            self.file.wrong(&value.span(), format!("`{}` is `{text}`: {problem}", self.path(key)))
        })?;
        Ok(Some(parsed))
    }

    /// Takes out a list of tables; none where the key is not there.
    ///
    /// # Errors
    /// It is anything else.
    pub fn tables(&mut self, key: &'static str) -> Result<Vec<Section<'a>>, StudyError> {
        let Some(value) = self.take(key) else { return Ok(vec![]) };
        let span = value.span();
        match value.into_inner() {
            DeValue::Array(each) => {
                each.into_iter().map(|value| Section::of(self.file, key, value)).collect()
            }
            other => {
                let tables = format!("tables, each under `[[{key}]]`");
                Err(self.file.wrong(&span, expected(key, &other, &tables)))
            }
        }
    }

    /// Everything that is left, in the order of the file.
    pub fn rest(self) -> Vec<(String, Range<usize>, Value<'a>)> {
        self.left
    }

    /// Nothing must be left.
    ///
    /// # Errors
    /// Something is.
    pub fn end(self) -> Result<(), StudyError> {
        let Some((key, span, _)) = self.left.first() else { return Ok(()) };
        let known: Vec<String> = self.known.iter().map(|known| format!("`{known}`")).collect();
        let hint = did_you_mean(&nearest(key, self.known.iter().copied()));
        let problem =
            format!("unknown key `{}`{hint}; known are {}", self.path(key), known.join(", "));
        Err(self.file.wrong(span, problem))
    }

    fn path(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_string() } else { format!("{}.{key}", self.name) }
    }
}

/// The text of a number, a truth value or a string.
///
/// # Errors
/// The value is something else.
pub fn scalar(file: &File, name: &str, value: &Value) -> Result<String, StudyError> {
    match value.get_ref() {
        DeValue::Integer(n) if n.radix() == 10 => Ok(n.as_str().replace('_', "")),
        DeValue::Float(x) => Ok(x.as_str().replace('_', "")),
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Boolean(is) => Ok(is.to_string()),
        other => Err(file.wrong(&value.span(), expected(name, other, "a number or a string"))),
    }
}

/// The sentence about a value of the wrong kind.
pub fn expected(name: &str, found: &DeValue, expected: &str) -> String {
    format!("`{name}` is of type {}: expected {expected}", found.type_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complaints_name_the_line() {
        let file = File::of("a.toml", "x = 1\n[b]\ny = \"no\"\nyy = 2\n");
        let mut table = file.table().unwrap();
        let number = |text: &str| text.parse::<u32>().map_err(|_| "expected a number".to_string());
        assert_eq!(table.parse("x", number), Ok(Some(1)));
        assert_eq!(table.parse("z", number), Ok(None));
        let b = table.take("b").unwrap();
        table.end().unwrap();
        let mut b = Section::of(&file, "b", b).unwrap();
        assert_eq!(
            b.parse("y", number).unwrap_err().to_string(),
            "`a.toml`, line 3: `b.y` is `no`: expected a number"
        );
        assert_eq!(
            b.end().unwrap_err().to_string(),
            "`a.toml`, line 4: unknown key `b.yy` (did you mean `y`?); known are `y`"
        );
        let broken = File::of("b.toml", "x = 1\nx = = 2\n");
        let message = broken.table().err().unwrap().to_string();
        assert!(message.starts_with("`b.toml`, line 2: "), "{message}");
    }
}
