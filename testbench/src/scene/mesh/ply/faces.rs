//! The faces and strips of a PLY.

use super::FACE_LISTS;
use super::header::{Element, Property};
use super::values::Values;
use super::vertices::{NO_COLOUR, channel, fraction, has_colour};
use crate::scene::SceneError;
use crate::scene::geometry::{Part, TRIANGLE_BYTES, VERTEX_BYTES};
use crate::scene::mesh::polygon::MOST_CORNERS;
use crate::scene::mesh::{Polygons, Reading};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// The index in a strip after which it begins anew.
const RESTART: i64 = -1;

/// The list with the vertices of each element.
pub(super) fn list(element: &Element) -> Option<&Property> {
    let is_list = |p: &&Property| FACE_LISTS.contains(&p.name.as_str()) && p.count.is_some();
    element.properties.iter().find(is_list)
}

/// Reads faces, or strips of triangles, into a part that has the vertices.
pub(super) fn read(
    file: &mut Reading,
    values: &mut Values,
    element: &Element,
    is_strip: bool,
    part: &mut Part,
) -> Result<(), SceneError> {
    let Some(own) = list(element) else { return Ok(()) };
    // Colours of vertices go over those of faces.
    let has_colour = has_colour(element).0 && part.colours.is_empty() && part.triangles.is_empty();
    let mut painter = has_colour.then(|| Painter::new(std::mem::take(&mut part.positions)));
    let vertices = painter.as_ref().map_or(part.positions.len(), |painter| painter.positions.len());
    let mut polygons = Polygons::default();
    let (mut corners, mut outline, mut triangles) = (vec![], vec![], vec![]);
    for i in 0..element.count {
        values.begin(file, element)?;
        let mut colour = NO_COLOUR;
        for property in &element.properties {
            if std::ptr::eq(own, property) {
                read_corners(file, values, element, property, is_strip, &mut corners)?;
            } else if let Some(channel) = channel(property) {
                let value = values.number(file, element, property, property.scalar)?;
                colour[channel] = fraction(value, property.scalar.full_scale());
            } else {
                values.skip(file, element, property)?;
            }
        }
        let known = |index: i64| usize::try_from(index).is_ok_and(|index| index < vertices);
        let restarts = |index| is_strip && index == RESTART;
        if let Some(index) = corners.iter().find(|&&index| !known(index) && !restarts(index)) {
            let name = &element.name;
            let what =
                format!("{name} {i} has the vertex index {index}, expected one below {vertices}");
            return Err(file.bad(values.line(), what));
        }
        triangles.clear();
        if is_strip {
            file.take(corners.len() * size_of::<[u32; 3]>())?;
            triangles.extend(corners.split(|index| *index == RESTART).flat_map(strip));
        } else {
            let positions = painter.as_ref().map_or(&part.positions, |painter| &painter.positions);
            outline.clear();
            outline.extend(corners.iter().map(|&index| positions[index as usize]));
            let place = values.line().map_or(format!("face {i}"), |line| format!("line {line}"));
            let cut = polygons.cut(&outline, format_args!("{place}"));
            triangles
                .extend(cut.iter().map(|triangle| triangle.map(|i| corners[i as usize] as u32)));
        }
        for triangle in &mut triangles {
            file.take(TRIANGLE_BYTES)?;
            if let Some(painter) = &mut painter {
                for index in triangle {
                    *index = painter.vertex(file, *index, colour, part)?;
                }
            }
        }
        part.triangles.extend(&triangles);
        values.end(file, element)?;
    }
    polygons.tell(file);
    Ok(())
}

/// Reads the items of a list with vertices.
fn read_corners(
    file: &mut Reading,
    values: &mut Values,
    element: &Element,
    property: &Property,
    is_strip: bool,
    corners: &mut Vec<i64>,
) -> Result<(), SceneError> {
    corners.clear();
    let count = values.count(file, element, property)?;
    if !is_strip && count > MOST_CORNERS as u64 {
        let what = format!("a face has {count} corners, expected at most {MOST_CORNERS}");
        return Err(file.bad(values.line(), what));
    }
    for _ in 0..count {
        if is_strip {
            file.take(size_of::<i64>())?;
        }
        let index = values.number(file, element, property, property.scalar)?;
        if index.fract() != 0.0 {
            let what = format!("found the vertex index {index}, expected a whole number");
            return Err(file.bad(values.line(), what));
        }
        corners.push(index as i64);
    }
    Ok(())
}

/// The triangles of a strip, all in the sense of the first; without those that only lead on to others.
fn strip(corners: &[i64]) -> impl Iterator<Item = [u32; 3]> {
    let triangles = corners.windows(3).enumerate().map(|(i, w)| match i % 2 {
        0 => [w[0], w[1], w[2]],
        _ => [w[1], w[0], w[2]],
    });
    let is_one = |[a, b, c]: &[i64; 3]| a != b && b != c && c != a;
    triangles.filter(is_one).map(|corners| corners.map(|index| index as u32))
}

/// Gives the vertices of faces the faces' colours: a vertex of the file is one of the part for each colour.
struct Painter {
    positions: Vec<Vec3>,
    /// Vertices of the part, by that of the file and the bits of the colour.
    known: HashMap<(u32, [u32; 4]), u32>,
}

impl Painter {
    fn new(positions: Vec<Vec3>) -> Painter {
        Painter { positions, known: HashMap::new() }
    }

    /// The vertex of the part that the one of the file is in a face of that colour.
    fn vertex(
        &mut self,
        file: &mut Reading,
        vertex: u32,
        colour: Vec4,
        part: &mut Part,
    ) -> Result<u32, SceneError> {
        let key = (vertex, colour.to_array().map(f32::to_bits));
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        file.take(VERTEX_BYTES + 2 * size_of_val(&key))?;
        let new = part.positions.len() as u32;
        self.known.insert(key, new);
        part.positions.push(self.positions[vertex as usize]);
        part.colours.push(colour);
        Ok(new)
    }
}
