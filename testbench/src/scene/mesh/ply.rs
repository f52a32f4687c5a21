//! PLY, ASCII and binary: positions, colours and polygons of any number of sides.
//!
//! Colours are `red`, `green`, `blue` and `alpha`, integers of the type's full range or floats of 0..=1.

mod elements;

use super::bad;
use crate::scene::SceneError;
use crate::scene::geometry::Part;
use elements::{FACE_LISTS, Face, Ignored, Vertex};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, Header, PropertyAccess, PropertyType};
use std::io::ErrorKind;
use std::path::Path;

/// Loads the content of a PLY file as one part with the name of the file.
pub(super) fn load(path: &str, bytes: Vec<u8>) -> Result<Vec<Part>, SceneError> {
    let file = File { path, bytes: &bytes };
    let mut reader = Reader::new(&bytes[..]);
    let header =
        Parser::<DefaultElement>::new().read_header(&mut reader).map_err(|e| file.in_header(&e))?;
    check(path, &header)?;
    let ascii = header.encoding == Encoding::Ascii;

    let mut part = Part::new(vec![stem(path)]);
    let colours = ["red", "green", "blue"]
        .iter()
        .all(|name| header.elements["vertex"].properties.contains_key(*name));
    let mut faces = (0, Vec::new());
    for element in header.elements.values() {
        let first_line = reader.line();
        match element.name.as_str() {
            "vertex" => {
                let vertices: Vec<Vertex> = file.read(&mut reader, element, &header)?;
                part.positions = vertices.iter().map(|vertex| vertex.position).collect();
                if colours {
                    part.colours = vertices.iter().map(|vertex| vertex.colour).collect();
                }
                if let Some(i) = part.positions.iter().position(|position| !position.is_finite()) {
                    let line = ascii.then_some(first_line + i);
                    return Err(bad(path, line, format!("vertex {i} is not finite")));
                }
            }
            "face" => faces = (first_line, file.read::<Face>(&mut reader, element, &header)?),
            _ => drop(file.read::<Ignored>(&mut reader, element, &header)?),
        }
    }

    let (first_line, faces) = faces;
    part.triangles.reserve(faces.len());
    for (i, Face(corners)) in faces.iter().enumerate() {
        let in_face =
            |what| bad(path, ascii.then_some(first_line + i), format!("face {i} has {what}"));
        part.triangles.extend(fan(corners, part.positions.len()).map_err(in_face)?);
    }
    Ok(vec![part])
}

/// A polygon's triangles around its first corner, or what is wrong with its indices into `vertices` vertices.
fn fan(corners: &[i32], vertices: usize) -> Result<impl Iterator<Item = [u32; 3]>, String> {
    if corners.len() < 3 {
        return Err(format!("{} corners, expected 3 or more", corners.len()));
    }
    let known = |index: i32| usize::try_from(index).is_ok_and(|index| index < vertices);
    if let Some(index) = corners.iter().find(|&&index| !known(index)) {
        return Err(format!("the vertex index {index}, expected one below {vertices}"));
    }
    let triangle = |pair: &[i32]| [corners[0], pair[0], pair[1]].map(|index| index as u32);
    Ok(corners[1..].windows(2).map(triangle))
}

/// The name of the file without its extension.
fn stem(path: &str) -> String {
    let name = Path::new(path).file_name().unwrap_or_default().to_string_lossy();
    let without = |extension: &str| {
        let at = name.len().checked_sub(extension.len())?;
        name.get(at..)?.eq_ignore_ascii_case(extension).then(|| name[..at].to_owned())
    };
    without(".ply.gz").or_else(|| without(".ply")).unwrap_or_else(|| name.to_string())
}

/// Refuses a header without the elements and properties that a mesh needs, and elements that take no bytes: the file
/// would not say where they end.
fn check(path: &str, header: &Header) -> Result<(), SceneError> {
    let nothing = |element: &&ElementDef| element.count > 0 && element.properties.is_empty();
    if let Some(ElementDef { name, count, .. }) = header.elements.values().find(nothing) {
        let what = format!(
            "the header declares {count} of the element `{name}` without a property, expected one or more"
        );
        return Err(bad(path, None, what));
    }
    let element = |name: &str| {
        let missing = || bad(path, None, format!("the header has no element `{name}`"));
        header.elements.get(name).ok_or_else(missing)
    };
    let vertex = element("vertex")?;
    for axis in ["x", "y", "z"] {
        if !vertex
            .properties
            .get(axis)
            .is_some_and(|p| matches!(p.data_type, PropertyType::Scalar(_)))
        {
            return Err(bad(
                path,
                None,
                format!("the header has no number `{axis}` in the element `vertex`"),
            ));
        }
    }
    let list = FACE_LISTS.iter().find_map(|name| element("face").ok()?.properties.get(*name));
    match (element("face")?, list.map(|list| &list.data_type)) {
        (_, Some(PropertyType::List(..))) => Ok(()),
        _ => Err(bad(path, None, "the header has no list `vertex_indices` in the element `face`")),
    }
}

struct File<'a> {
    path: &'a str,
    bytes: &'a [u8],
}

impl File<'_> {
    fn read<E: PropertyAccess>(
        &self,
        reader: &mut Reader<&[u8]>,
        element: &ElementDef,
        header: &Header,
    ) -> Result<Vec<E>, SceneError> {
        Parser::<E>::new()
            .read_payload_for_element(reader, element, header)
            .map_err(|error| self.in_body(&error, element, header.encoding == Encoding::Ascii))
    }

    fn in_header(&self, error: &ParseError) -> SceneError {
        let what = match (error.line(), error.kind()) {
            (_, ErrorKind::UnexpectedEof) => {
                "the file ends in the header, expected `end_header`".into()
            }
            (Some(1), _) => "expected `ply` as the first line".into(),
            (Some(line), _) => format!("`{}` is no line of a PLY header", self.line(line)),
            (None, _) => {
                "expected a PLY header with a line `format ascii 1.0`, or one of the binary formats"
                    .into()
            }
        };
        bad(self.path, error.line(), what)
    }

    fn in_body(&self, error: &ParseError, element: &ElementDef, ascii: bool) -> SceneError {
        let ElementDef { name, count, .. } = element;
        let line = error.line().filter(|_| ascii);
        let what = match (error.kind(), line) {
            (ErrorKind::UnexpectedEof, _) => {
                format!("the file ends early: the header declares {count} of the element `{name}`")
            }
            (_, Some(line)) => {
                format!("`{}` is no element `{name}` as the header declares it", self.line(line))
            }
            (_, None) => format!("an element `{name}` is not as the header declares it"),
        };
        bad(self.path, line, what)
    }

    /// A line's text, from 1.
    fn line(&self, line: usize) -> String {
        let text = self.bytes.split(|&byte| byte == b'\n').nth(line - 1).unwrap_or_default();
        String::from_utf8_lossy(&text[..text.len().min(60)]).trim().to_owned()
    }
}
