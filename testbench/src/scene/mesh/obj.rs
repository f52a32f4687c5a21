//! Wavefront OBJ with its material libraries.
//!
//! Each run of faces of one object, group and material is a part. Text is read as the programs that write it mean it: in
//! UTF-8 or UTF-16, lines that go on in the next, numbers as C reads them. What does not concern the picture is passed over.

mod faces;
mod material;
mod painter;

use super::Reading;
use super::lines::Lines;
use crate::scene::SceneError;
use crate::scene::geometry::Part;
use faces::Faces;
use glam::{Vec2, Vec3};
use material::{Library, number};
use std::io::BufRead;

/// Statements that say nothing of the picture.
const PASSED_OVER: [&str; 10] = [
    "s",
    "mg",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "usemap",
    "maplib",
];
/// Most kinds of statement that a note names.
const MOST_NAMED: usize = 8;

/// Loads an OBJ file.
pub(super) fn load(file: &mut Reading, text: &mut dyn BufRead) -> Result<Vec<Part>, SceneError> {
    let mut lines = Lines::new(text);
    let mut reader = Reader::default();
    while file.read_joined(&mut lines)? {
        let line = lines.number();
        let text = String::from_utf8_lossy(lines.text());
        reader.statement(file, line, &text)?;
    }
    let Reader { faces, mut library, unknown } = reader;
    let parts = faces.parts(file, &mut library)?;
    library.tell(file);
    if !unknown.is_empty() {
        file.note(format!("statements that are not known are passed over: {}", unknown.join(", ")));
    }
    Ok(parts)
}

/// What has been read so far.
#[derive(Default)]
struct Reader {
    faces: Faces,
    library: Library,
    /// Keywords that are not known, the first few.
    unknown: Vec<String>,
}

impl Reader {
    /// Takes one line.
    fn statement(&mut self, file: &mut Reading, line: usize, text: &str) -> Result<(), SceneError> {
        let mut words = text.split_whitespace().take_while(|word| !word.starts_with('#'));
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        // A name may have blanks, and signs that start a comment elsewhere.
        let name = text.trim_start()[keyword.len()..].trim();
        let bad = |file: &Reading, what: &str| Err(file.bad(Some(line), what));
        match keyword {
            "v" => {
                let numbers: Option<Vec<f32>> = words.map(number).collect();
                match vertex(numbers.as_deref().unwrap_or_default()) {
                    Ok((position, colour)) => self.faces.vertex(file, position, colour),
                    Err(what) => bad(file, what),
                }
            }
            "vn" => match vector(words) {
                Some(normal) => self.faces.normal(file, normal),
                None => bad(file, "expected a normal as vn X Y Z"),
            },
            "vt" => {
                let numbers: Option<Vec<f32>> = words.take(2).map(number).collect();
                match numbers.as_deref() {
                    Some(&[u]) => self.faces.place(file, Vec2::new(u, 0.0)),
                    Some(&[u, v]) => self.faces.place(file, Vec2::new(u, v)),
                    _ => bad(file, "expected a texture coordinate as vt U V"),
                }
            }
            "f" | "fo" => self.faces.face(file, line, words),
            "p" | "l" => {
                self.faces.pass_over(line, keyword == "p");
                Ok(())
            }
            "o" | "g" => {
                self.faces.name(name);
                Ok(())
            }
            "usemtl" => {
                self.faces.material(name);
                Ok(())
            }
            "mtllib" => self.library.load(file, name),
            _ => {
                let known =
                    PASSED_OVER.contains(&keyword) || self.unknown.iter().any(|k| k == keyword);
                if !known && self.unknown.len() < MOST_NAMED {
                    self.unknown.push(keyword.chars().take(20).collect());
                }
                Ok(())
            }
        }
    }
}

/// Three numbers, what follows them aside.
fn vector<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let numbers: Vec<f32> = words.take(3).map(number).collect::<Option<_>>()?;
    Some(Vec3::from(<[f32; 3]>::try_from(numbers).ok()?))
}

/// A vertex and its colour, from the numbers of its line, or what was expected.
fn vertex(numbers: &[f32]) -> Result<(Vec3, Option<Vec3>), &'static str> {
    match *numbers {
        [x, y, z] => Ok((Vec3::new(x, y, z), None)),
        [.., 0.0] if numbers.len() == 4 => {
            Err("expected a vertex as v X Y Z W with W other than 0")
        }
        [x, y, z, w] => match Vec3::new(x, y, z) / w {
            position if position.is_finite() => Ok((position, None)),
            _ => Err("the vertex is not finite"),
        },
        [x, y, z, r, g, b] => {
            let colour = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE);
            Ok((Vec3::new(x, y, z), Some(colour)))
        }
        _ => Err("expected a vertex as v X Y Z, v X Y Z W or v X Y Z R G B, of finite numbers"),
    }
}
