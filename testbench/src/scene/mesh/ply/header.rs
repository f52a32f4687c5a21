//! The header of a PLY: what the file has, in which order and form.

use crate::scene::SceneError;
use crate::scene::mesh::lines::Lines;
use crate::scene::mesh::reading::{Reading, line_error};

/// Most bytes of a header.
const MOST_HEADER: usize = 1 << 20;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    BigEndian,
    LittleEndian,
}

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// One thing that each element of a kind has.
pub(super) struct Property {
    pub name: String,
    /// The type of how many items there are, if it is a list.
    pub count: Option<Scalar>,
    /// The type of the number, or of the items.
    pub scalar: Scalar,
}

/// A kind of elements.
pub(super) struct Element {
    pub name: String,
    /// How many of them there are.
    pub count: u64,
    pub properties: Vec<Property>,
}

/// See the module's description.
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl Scalar {
    fn named(name: &str) -> Option<Scalar> {
        match name {
            "char" | "int8" => Some(Scalar::I8),
            "uchar" | "uint8" => Some(Scalar::U8),
            "short" | "int16" => Some(Scalar::I16),
            "ushort" | "uint16" => Some(Scalar::U16),
            "int" | "int32" => Some(Scalar::I32),
            "uint" | "uint32" => Some(Scalar::U32),
            "float" | "float32" => Some(Scalar::F32),
            "double" | "float64" => Some(Scalar::F64),
            _ => None,
        }
    }

    /// What stands for 1.0 in a colour of this type.
    pub fn full_scale(self) -> f64 {
        match self {
            Scalar::I8 => i8::MAX.into(),
            Scalar::U8 => u8::MAX.into(),
            Scalar::I16 => i16::MAX.into(),
            Scalar::U16 => u16::MAX.into(),
            Scalar::I32 => i32::MAX.into(),
            Scalar::U32 => u32::MAX.into(),
            Scalar::F32 | Scalar::F64 => 1.0,
        }
    }
}

impl Element {
    /// Whether it has a number of that name.
    pub fn has_number(&self, name: &str) -> bool {
        self.properties.iter().any(|property| property.name == name && property.count.is_none())
    }
}

impl Header {
    /// The elements of that name.
    pub fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }

    /// Reads the header, up to and with its last line.
    ///
    /// # Errors
    /// It ends early or is too long, has a line that is none of a header, or no format.
    pub fn read(file: &mut Reading, lines: &mut Lines) -> Result<Header, SceneError> {
        let (mut encoding, mut elements) = (None, vec![]);
        let (mut bytes, mut in_comment) = (0, false);
        loop {
            let more =
                lines.read().map_err(|error| line_error(file.path, lines.number(), error))?;
            if !more {
                let what = "the file ends in the header, expected `end_header`";
                return Err(file.bad(None, what));
            }
            bytes += lines.text().len();
            let text = String::from_utf8_lossy(lines.text());
            let line = text.trim();
            let bad = |what: String| Err(file.bad(Some(lines.number()), what));
            if lines.number() == 1 {
                if line != "ply" {
                    return bad("expected `ply` as the first line".into());
                }
                continue;
            }
            if bytes > MOST_HEADER {
                return bad(format!(
                    "the header goes on, expected at most {MOST_HEADER} bytes of it"
                ));
            }
            let words: Vec<&str> = line.split_whitespace().collect();
            let known = match words[..] {
                [] => true,
                ["end_header"] => break,
                ["comment", ..] => {
                    in_comment = true;
                    continue;
                }
                ["obj_info", ..] => true,
                ["format", name, _] => {
                    encoding = self::encoding(name);
                    encoding.is_some()
                }
                ["element", name, count] => match count.parse() {
                    Ok(_) if elements.iter().any(|element: &Element| element.name == name) => {
                        return bad(format!("the header has the element `{name}` a second time"));
                    }
                    Ok(count) => {
                        elements.push(Element { name: name.into(), count, properties: vec![] });
                        true
                    }
                    Err(_) => false,
                },
                ["property", ..] => match (elements.last_mut(), property(&words[1..])) {
                    (Some(element), Some(property)) => {
                        element.properties.push(property);
                        true
                    }
                    _ => false,
                },
                // Some programs break a comment over lines without a keyword, or leave its keyword out.
                _ => in_comment || elements.is_empty(),
            };
            if !known {
                let line: String = line.chars().take(60).collect();
                return bad(format!("`{line}` is no line of a PLY header"));
            }
            in_comment &=
                !matches!(words[..], ["format" | "element" | "property" | "obj_info", ..]);
        }
        let expected = "the header has no line `format ascii 1.0`, or of one of the binary formats";
        let encoding = encoding.ok_or_else(|| file.bad(None, expected))?;
        Ok(Header { encoding, elements })
    }
}

fn encoding(name: &str) -> Option<Encoding> {
    match name {
        "ascii" => Some(Encoding::Ascii),
        "binary_big_endian" => Some(Encoding::BigEndian),
        "binary_little_endian" => Some(Encoding::LittleEndian),
        _ => None,
    }
}

/// The property that the words after its keyword declare.
fn property(words: &[&str]) -> Option<Property> {
    let (count, scalar, name) = match *words {
        [scalar, name] => (None, scalar, name),
        ["list", count, scalar, name] => (Some(Scalar::named(count)?), scalar, name),
        _ => return None,
    };
    Some(Property { name: name.into(), count, scalar: Scalar::named(scalar)? })
}
