//! A library of standard cells in the Liberty format, as far as areas and a driving cell go.

use flate2::read::MultiGzDecoder;
use std::collections::HashMap;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What is wrong with a library's file.
#[derive(Debug, thiserror::Error)]
pub enum LibertyError {
    /// The file could not be read.
    #[error("{file}: {error}")]
    Read {
        /// Its path.
        file: String,
        /// Why.
        error: std::io::Error,
    },
    /// A line that is no Liberty.
    #[error("{file}: line {line}: {problem}")]
    Syntax {
        /// The file's path.
        file: String,
        /// The line's number, from 1.
        line: usize,
        /// What was found, and what was expected.
        problem: String,
    },
    /// Something that a library has is not there.
    #[error("{file}: {problem}")]
    Missing {
        /// The file's path.
        file: String,
        /// What, and what was expected.
        problem: String,
    },
}

/// A group: `name (arguments) { ... }`.
#[derive(Debug, Default)]
struct Group {
    name: String,
    arguments: String,
    attributes: Vec<(String, String)>,
    groups: Vec<Group>,
    /// Where it stands in its text.
    span: Range<usize>,
}

impl Group {
    fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.attribute(name)?.parse().ok().filter(|number: &f64| number.is_finite())
    }

    /// Its text.
    fn text<'a>(&self, of: &'a str) -> &'a str {
        &of[self.span.clone()]
    }

    fn all(&self, name: &str) -> impl Iterator<Item = &Group> {
        self.groups.iter().filter(move |group| group.name == name)
    }
}

/// A library.
#[derive(Clone, Debug)]
pub struct Library {
    /// The file's path.
    pub file: String,
    /// Its text, unpacked.
    pub text: String,
    /// Area of each cell, um2.
    areas: HashMap<String, f64>,
    /// A unit of time, ns.
    pub time_ns: f64,
    /// The cell that drives each input of a block: an inverter.
    pub driver: String,
    /// What each output of a block drives, fF: four inputs of that cell.
    pub load_ff: f64,
}

/// Reads tokens: words, numbers, texts in quotes, and single characters.
struct Tokens<'a> {
    rest: &'a str,
    line: usize,
    /// Bytes of the whole text.
    length: usize,
}

#[derive(Debug, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    Sign(char),
    End,
}

impl<'a> Tokens<'a> {
    fn new(text: &'a str) -> Tokens<'a> {
        Tokens { rest: text, line: 1, length: text.len() }
    }

    /// Where it is.
    fn at(&self) -> usize {
        self.length - self.rest.len()
    }

    fn skip(&mut self, bytes: usize) {
        self.line += self.rest[..bytes].matches('\n').count();
        self.rest = &self.rest[bytes..];
    }

    fn next(&mut self) -> Result<Token<'a>, String> {
        loop {
            let blank = |c: char| c.is_whitespace() || c == '\\';
            let from = self.rest.find(|c| !blank(c)).unwrap_or(self.rest.len());
            self.skip(from);
            let end = match self.rest {
                rest if rest.starts_with("/*") => rest.find("*/").map(|at| at + 2),
                rest if rest.starts_with("//") => Some(rest.find('\n').unwrap_or(rest.len())),
                _ => break,
            };
            self.skip(end.ok_or("a comment without an end: expected `*/`")?);
        }
        let Some(first) = self.rest.chars().next() else { return Ok(Token::End) };
        if first == '"' {
            let end = self.rest[1..].find('"').ok_or("a text without an end: expected `\"`")?;
            let text = &self.rest[1..=end];
            self.skip(end + 2);
            return Ok(Token::Word(text));
        }
        let of_word = |c: char| c.is_alphanumeric() || "_.+-!&|^'*[]<>$%/=".contains(c);
        let end = self.rest.find(|c| !of_word(c)).unwrap_or(self.rest.len());
        if end == 0 {
            self.skip(first.len_utf8());
            return Ok(Token::Sign(first));
        }
        let word = &self.rest[..end];
        self.skip(end);
        Ok(Token::Word(word))
    }

    /// What stands between parentheses, up to the closing one.
    fn arguments(&mut self) -> Result<String, String> {
        let mut words = vec![];
        loop {
            match self.next()? {
                Token::Sign(')') => return Ok(words.join(",")),
                Token::Word(word) => words.push(word),
                Token::Sign(',' | '(' | ':') => {}
                other => return Err(format!("{}: expected `)`", shown(&other))),
            }
        }
    }

    /// The statements of a group, up to its end.
    fn group(&mut self, name: &str, arguments: String, outermost: bool) -> Result<Group, String> {
        let mut group = Group { name: name.to_string(), arguments, ..Group::default() };
        loop {
            let name = match self.next()? {
                Token::Sign('}') if !outermost => return Ok(group),
                Token::End if outermost => return Ok(group),
                Token::Sign(';') => continue,
                Token::Word(word) => word,
                Token::End => return Err(format!("the file ends within `{name}`: expected `}}`")),
                other => return Err(format!("{}: expected a name", shown(&other))),
            };
            let from = self.at() - name.len();
            match self.next()? {
                Token::Sign(':') => {
                    let value = self.value()?;
                    group.attributes.push((name.to_string(), value));
                }
                Token::Sign('(') => {
                    let arguments = self.arguments()?;
                    let mut ahead = Tokens { ..*self };
                    if ahead.next()? == Token::Sign('{') {
                        *self = ahead;
                        let inner = self.group(name, arguments, false)?;
                        group.groups.push(Group { span: from..self.at(), ..inner });
                    } else {
                        group.attributes.push((name.to_string(), arguments));
                    }
                }
                other => {
                    return Err(format!("{} behind `{name}`: expected `:` or `(`", shown(&other)));
                }
            }
        }
    }

    /// A value, up to the semicolon or the line's end.
    fn value(&mut self) -> Result<String, String> {
        let Token::Word(first) = self.next()? else {
            return Err("no value: expected one behind `:`".into());
        };
        let mut value = first.to_string();
        // An expression such as `VDD + 0.5`.
        let end = self.rest.find([';', '\n', '}']).unwrap_or(self.rest.len());
        value += self.rest[..end].trim_end();
        self.skip(end);
        Ok(value)
    }
}

fn shown(token: &Token) -> String {
    match token {
        Token::Word(word) => format!("`{word}`"),
        Token::Sign(sign) => format!("`{sign}`"),
        Token::End => "the end of the file".to_string(),
    }
}

/// `1ns` and its like, in ns.
fn nanoseconds(unit: &str) -> Option<f64> {
    let scale = [("ps", 1e-3), ("ns", 1.0), ("us", 1e3)];
    let (number, scale) =
        scale.iter().find_map(|(name, scale)| Some((unit.strip_suffix(name)?, scale)))?;
    let number: f64 = number.trim().parse().ok()?;
    (number > 0.0).then_some(number * scale)
}

/// `1,pf` and its like, in fF.
fn femtofarads(unit: &str) -> Option<f64> {
    let (number, name) = unit.split_once(',')?;
    let scale = match name.to_lowercase().as_str() {
        "ff" => 1.0,
        "pf" => 1e3,
        _ => return None,
    };
    Some(number.parse::<f64>().ok()? * scale)
}

/// Capacitance of the input of a cell that is an inverter.
fn inverter(cell: &Group) -> Option<f64> {
    let pins: Vec<&Group> = cell.all("pin").collect();
    let of = |direction: &str| {
        let those = pins.iter().filter(|pin| pin.attribute("direction") == Some(direction));
        those.copied().collect::<Vec<_>>()
    };
    let ([input], [output]) = (&of("input")[..], &of("output")[..]) else { return None };
    let function: String =
        output.attribute("function")?.chars().filter(|c| !" ()".contains(*c)).collect();
    let name = &input.arguments;
    let inverts = [format!("!{name}"), format!("{name}'")].contains(&function);
    inverts.then(|| input.number("capacitance")).flatten().filter(|load| *load > 0.0)
}

/// A file's path as errors call it, and its text, unpacked.
fn read(path: &Path) -> Result<(String, String), LibertyError> {
    let file = path.display().to_string();
    let unpacked = || -> std::io::Result<String> {
        let bytes = std::fs::read(path)?;
        let mut text = String::new();
        match bytes.starts_with(&[0x1f, 0x8b]) {
            true => MultiGzDecoder::new(&bytes[..]).read_to_string(&mut text)?,
            false => (&bytes[..]).read_to_string(&mut text)?,
        };
        Ok(text)
    };
    match unpacked() {
        Ok(text) => Ok((file, text)),
        Err(error) => Err(LibertyError::Read { file, error }),
    }
}

/// The group of the library in a text.
fn library_of(file: &str, text: &str) -> Result<Group, LibertyError> {
    let mut tokens = Tokens::new(text);
    let whole = tokens.group("file", String::new(), true);
    let whole = whole.map_err(|problem| LibertyError::Syntax {
        file: file.to_string(),
        line: tokens.line,
        problem,
    })?;
    let mut groups = whole.groups.into_iter();
    groups.find(|group| group.name == "library").ok_or_else(|| LibertyError::Missing {
        file: file.to_string(),
        problem: "no `library`: expected one".to_string(),
    })
}

/// Groups of a library that areas and times come from.
const PARTS: [&str; 3] = ["cell", "lu_table_template", "type"];

/// The text of a library in several files: the first one, with what the others have beside it.
fn joined(files: &[(String, String)]) -> Result<String, LibertyError> {
    let (first, text) = &files[0];
    let mut whole = library_of(first, text)?;
    let known = |group: &Group, text: &str| {
        ((group.name.clone(), group.arguments.clone()), group.text(text).to_string())
    };
    let mut groups: HashMap<_, _> = whole.groups.iter().map(|g| known(g, text)).collect();
    let mut more = String::new();
    for (file, text) in &files[1..] {
        let wrong = |problem| LibertyError::Missing { file: file.clone(), problem };
        let library = library_of(file, text)?;
        for unit in ["time_unit", "capacitive_load_unit"] {
            let (expected, found) = (whole.attribute(unit), library.attribute(unit));
            if expected != found {
                let shown = |unit: Option<&str>| unit.unwrap_or("missing").to_string();
                let (expected, found) = (shown(expected), shown(found));
                return Err(wrong(format!(
                    "`{unit}` is {found}: expected {expected}, as in {first}"
                )));
            }
        }
        for group in &library.groups {
            let (name, text) = known(group, text);
            match groups.get(&name) {
                // What cells are made of must be one thing; of all else the first counts.
                Some(other) if *other != text && PARTS.contains(&&*name.0) => {
                    let (kind, name) = name;
                    return Err(wrong(format!(
                        "`{kind} ({name})` is not that of the files before: expected it once, or alike"
                    )));
                }
                Some(_) => {}
                None => {
                    more += &format!("{text}\n");
                    groups.insert(name, text);
                }
            }
        }
    }
    whole.span.end -= 1;
    let (before, after) = text.split_at(whole.span.end);
    Ok(format!("{before}{more}{after}"))
}

impl Library {
    /// The library of a file, or of several that belong together; each may be packed with gzip.
    ///
    /// # Errors
    /// One cannot be read, is no Liberty, or lacks what is needed; or two of them do not go together.
    ///
    /// # Panics
    /// There is no file.
    pub fn open(paths: &[PathBuf]) -> Result<Library, LibertyError> {
        let mut files =
            paths.iter().map(|path| read(path)).collect::<Result<Vec<_>, LibertyError>>()?;
        if let [_] = files[..] {
            let (file, text) = files.remove(0);
            return Library::parse(&file, text);
        }
        let names: Vec<&str> = files.iter().map(|(file, _)| file.as_str()).collect();
        Library::parse(&names.join(" + "), joined(&files)?)
    }

    /// The library of a text; `file` is what errors call it.
    ///
    /// # Errors
    /// As [`Library::open`].
    pub fn parse(file: &str, text: String) -> Result<Library, LibertyError> {
        let missing = |problem: &str| LibertyError::Missing {
            file: file.to_string(),
            problem: problem.to_string(),
        };
        let library = library_of(file, &text)?;
        let mut areas = HashMap::new();
        for cell in library.all("cell") {
            let name = &cell.arguments;
            let area = cell.number("area").filter(|area| *area >= 0.0);
            let area = area
                .ok_or_else(|| missing(&format!("cell `{name}` has no area: expected a number")))?;
            areas.insert(name.clone(), area);
        }
        let time = library.attribute("time_unit").and_then(nanoseconds);
        let time_ns =
            time.ok_or_else(|| missing("no `time_unit`: expected one such as \"1ns\""))?;
        let unit = library.attribute("capacitive_load_unit").and_then(femtofarads);
        let unit =
            unit.ok_or_else(|| missing("no `capacitive_load_unit`: expected one such as (1, pf)"))?;
        let usable = |cell: &&Group| cell.attribute("dont_use") != Some("true");
        let mut inverters: Vec<(&str, f64, f64)> = library
            .all("cell")
            .filter(usable)
            .filter_map(|cell| {
                Some((cell.arguments.as_str(), areas[&cell.arguments], inverter(cell)?))
            })
            .collect();
        inverters.sort_by(|a, b| a.2.total_cmp(&b.2));
        // One of middling strength: the third, where there are so many.
        let driver = inverters.get(2).or(inverters.last());
        let (driver, _, capacitance) = driver
            .ok_or_else(|| missing("no inverter: expected a cell with the function of one"))?;
        let (driver, load_ff) = (driver.to_string(), 4.0 * capacitance * unit);
        Ok(Library { file: file.to_string(), areas, time_ns, driver, load_ff, text })
    }

    /// The area of a cell, um2.
    pub fn area(&self, cell: &str) -> Option<f64> {
        self.areas.get(cell).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "/* a library */\nlibrary (small) {\n  time_unit : \"10ps\";\n  \
        capacitive_load_unit (1, pf);\n  cell (INV1) { area : 2; pin (A) { direction : input; capacitance : 0.001; }\n    \
        pin (Y) { direction : output; function : \"(!A)\"; timing () { values ( \\\n \"1, 2\", \\\n \"3, 4\" ); } } }\n  \
        cell (\"NAND\") { area : 3.5 ; pin (A) { direction : input; capacitance : 0.002; } }\n  // the end\n}\n";

    #[test]
    fn areas_units_and_a_driver() {
        let library = Library::parse("small.lib", SMALL.to_string()).unwrap();
        assert_eq!(
            [library.area("INV1"), library.area("NAND"), library.area("INV2")],
            [Some(2.0), Some(3.5), None]
        );
        assert_eq!((library.driver.as_str(), library.load_ff), ("INV1", 4.0));
        assert!((library.time_ns - 0.01).abs() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let said = |old: &str, new: &str| {
            assert!(SMALL.contains(old), "{old}");
            Library::parse("my.lib", SMALL.replacen(old, new, 1)).unwrap_err().to_string()
        };
        assert_eq!(said("library (small)", "libary (small)"), "my.lib: no `library`: expected one");
        assert_eq!(
            said("area : 3.5 ", "area : x"),
            "my.lib: cell `NAND` has no area: expected a number"
        );
        assert_eq!(said("10ps", "fast"), "my.lib: no `time_unit`: expected one such as \"1ns\"");
        assert_eq!(
            said("(1, pf)", "(1, barn)"),
            "my.lib: no `capacitive_load_unit`: expected one such as (1, pf)"
        );
        assert_eq!(
            said("(!A)", "A"),
            "my.lib: no inverter: expected a cell with the function of one"
        );
        assert_eq!(
            said("  // the end\n}\n", ""),
            "my.lib: line 10: the file ends within `library`: expected `}`"
        );
        assert_eq!(
            said("/* a library */", "/* a library"),
            "my.lib: line 1: a comment without an end: expected `*/`"
        );
        assert_eq!(
            said("\"1, 2\", ", "\"1, 2, "),
            "my.lib: line 9: a text without an end: expected `\"`"
        );
        assert_eq!(
            said("cell (INV1) {", "cell INV1 {"),
            "my.lib: line 5: `INV1` behind `cell`: expected `:` or `(`"
        );
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let error = Library::open(&["none.lib".into()]).unwrap_err().to_string();
        assert_eq!(error, "none.lib: No such file or directory (os error 2)");
    }

    #[test]
    fn files_that_belong_together_are_one_library() {
        let folder = tempfile::tempdir().unwrap();
        let head = "library (more) { time_unit : \"10ps\";\n capacitive_load_unit (1, pf);\n";
        let template = "lu_table_template (t) { variable_1 : x; }\n";
        let open = |second: &str| {
            let paths = ["a.lib", "b.lib"].map(|name| folder.path().join(name));
            let first = SMALL.replacen("  cell (INV1)", &format!("  {template}  cell (INV1)"), 1);
            std::fs::write(&paths[0], first).unwrap();
            std::fs::write(&paths[1], second).unwrap();
            let folder = format!("{}/", folder.path().display());
            let shorter = |text: String| text.replace(&folder, "");
            Library::open(&paths).map_err(|error| shorter(error.to_string()))
        };
        let whole = open(&format!("{head}{template}cell (FF) {{ area : 9; }} }}\n")).unwrap();
        let areas = ["INV1", "NAND", "FF"].map(|cell| whole.area(cell));
        assert_eq!(areas, [Some(2.0), Some(3.5), Some(9.0)]);
        assert_eq!(whole.text.matches("lu_table_template").count(), 1);
        // What is one library now can be read as one.
        assert_eq!(library_of("whole", &whole.text).unwrap().all("cell").count(), 3);
        assert_eq!(
            open(&format!("{head}lu_table_template (t) {{ variable_1 : y; }} }}")).unwrap_err(),
            "b.lib: `lu_table_template (t)` is not that of the files before: expected it once, or alike"
        );
        assert_eq!(
            open(&head.replace("10ps", "1ps").replace("pf);", "pf); }")).unwrap_err(),
            "b.lib: `time_unit` is 1ps: expected 10ps, as in a.lib"
        );
    }
}
