//! PLY, ASCII and binary: positions, colours of vertices or faces, polygons of any number of sides, strips, and
//! Gaussian splats.
//!
//! Colours are `red`, `green`, `blue` and `alpha`, integers of the type's full range or floats of 0..=1. Numbers are read
//! as they come, whether an element goes over one line or several.

mod faces;
mod header;
mod splats;
mod values;
mod vertices;

use super::Reading;
use super::lines::Lines;
use crate::scene::SceneError;
use crate::scene::geometry::Part;
use header::{Element, Header};
use std::io::BufRead;
use std::path::Path;
use values::Values;

/// Elements with corners, and whether each is a strip of triangles instead of a polygon.
const FACES: [(&str, bool); 2] = [("face", false), ("tristrips", true)];
/// Names of the list with a face's vertices.
const FACE_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Loads a PLY file as one part with the name of the file.
pub(super) fn load(file: &mut Reading, text: &mut dyn BufRead) -> Result<Vec<Part>, SceneError> {
    let mut lines = Lines::new(text);
    let header = Header::read(file, &mut lines)?;
    check(file, &header)?;
    let mut values = Values::new(&mut lines, header.encoding);
    let mut part = Part::new(vec![stem(file.path)]);
    let is_empty =
        |(name, _): &(&str, bool)| header.element(name).is_none_or(|element| element.count == 0);
    let has_no_faces = FACES.iter().all(is_empty);
    for element in &header.elements {
        match FACES.iter().find(|(name, _)| element.name == *name) {
            Some((_, is_strip)) => faces::read(file, &mut values, element, *is_strip, &mut part)?,
            None if element.name == "vertex" && has_no_faces && splats::are_splats(element) => {
                splats::read(file, &mut values, element, &mut part)?;
            }
            None if element.name == "vertex" => {
                vertices::read(file, &mut values, element, &mut part)?;
            }
            None => skip(file, &mut values, element)?,
        }
    }
    if has_no_faces && part.splats.is_empty() {
        let points = format!("{} points", part.positions.len());
        file.not_seen(Some((points, "no face".into())));
    }
    let has_alpha = |element: &Element| vertices::has_colour(element) == (true, true);
    if part.splats.is_empty() && !header.elements.iter().any(has_alpha) {
        file.has_no_opacity();
    }
    Ok(vec![part])
}

/// Reads elements of no interest.
fn skip(file: &Reading, values: &mut Values, element: &Element) -> Result<(), SceneError> {
    for _ in 0..element.count {
        values.begin(file, element)?;
        element.properties.iter().try_for_each(|property| values.skip(file, element, property))?;
        values.end(file, element)?;
    }
    Ok(())
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
fn check(file: &Reading, header: &Header) -> Result<(), SceneError> {
    let bad = |what: String| Err(file.bad(None, what));
    let nothing = |element: &&Element| element.count > 0 && element.properties.is_empty();
    if let Some(Element { name, count, .. }) = header.elements.iter().find(nothing) {
        return bad(format!(
            "the header declares {count} of the element `{name}` without a property, expected one or more"
        ));
    }
    let Some(vertex) = header.element("vertex") else {
        return bad("the header has no element `vertex`".into());
    };
    if let Some(axis) = ["x", "y", "z"].iter().find(|axis| !vertex.has_number(axis)) {
        return bad(format!("the header has no number `{axis}` in the element `vertex`"));
    }
    for (name, _) in FACES {
        let Some(element) = header.element(name) else { continue };
        if element.count > 0 && faces::list(element).is_none() {
            return bad(format!("the header has no list `vertex_indices` in the element `{name}`"));
        }
        let before = header.elements.iter().take_while(|element| element.name != "vertex");
        if before.into_iter().any(|element| element.name == name) {
            return bad(format!("the header has the element `{name}` before the element `vertex`"));
        }
    }
    Ok(())
}
