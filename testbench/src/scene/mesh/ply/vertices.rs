//! The vertices of a PLY.

use super::header::{Element, Property};
use super::values::Values;
use crate::scene::SceneError;
use crate::scene::geometry::{DEFAULT_ALPHA, Part, VERTEX_BYTES};
use crate::scene::mesh::Reading;
use glam::{Vec3, Vec4};

/// The names of a position's coordinates.
const AXES: [&str; 3] = ["x", "y", "z"];
/// The names of a colour's channels; without the last the opacity is the default.
const CHANNELS: [[&str; 2]; 4] = [
    ["red", "diffuse_red"],
    ["green", "diffuse_green"],
    ["blue", "diffuse_blue"],
    ["alpha", "diffuse_alpha"],
];

/// Which channel of a colour a property is.
pub(super) fn channel(property: &Property) -> Option<usize> {
    let names = |names: &[&str; 2]| names.contains(&property.name.as_str());
    CHANNELS.iter().position(names).filter(|_| property.count.is_none())
}

/// Whether elements have a colour, and whether with an opacity.
pub(super) fn has_colour(element: &Element) -> (bool, bool) {
    let has = |i: usize| element.properties.iter().any(|property| channel(property) == Some(i));
    ((0..3).all(has), has(3))
}

/// Where no colour has been read.
pub(super) const NO_COLOUR: Vec4 = Vec4::new(0.0, 0.0, 0.0, DEFAULT_ALPHA);

/// The part of a channel's full scale that a number is.
pub(super) fn fraction(value: f64, full_scale: f64) -> f32 {
    let fraction = value / full_scale;
    if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) as f32 }
}

/// Reads positions and colours into the part.
pub(super) fn read(
    file: &mut Reading,
    values: &mut Values,
    element: &Element,
    part: &mut Part,
) -> Result<(), SceneError> {
    let bytes = usize::try_from(element.count).unwrap_or(usize::MAX);
    file.take(bytes.saturating_mul(VERTEX_BYTES))?;
    let axis = |property: &Property| AXES.iter().position(|axis| property.name == *axis);
    let field = |p: &Property| axis(p).or(channel(p).map(|channel| AXES.len() + channel));
    let fields: Vec<Option<usize>> = element.properties.iter().map(field).collect();
    let (has_colour, has_alpha) = has_colour(element);
    let scale = |field| {
        let property = fields.iter().position(|found| *found == Some(AXES.len() + field));
        property.map_or(1.0, |property| element.properties[property].scalar.full_scale())
    };
    let scales = [0, 1, 2, 3].map(scale);
    for i in 0..element.count {
        let mut found = [0.0; AXES.len() + CHANNELS.len()];
        values.element(file, element, &fields, &mut found)?;
        let [x, y, z, colour @ ..] = found;
        let position = Vec3::from([x, y, z].map(|value| value as f32));
        if !position.is_finite() {
            return Err(file.bad(values.line(), format!("vertex {i} is not finite")));
        }
        part.positions.push(position);
        if has_colour {
            let channel = |i: usize| fraction(colour[i], scales[i]);
            let alpha = if has_alpha { channel(3) } else { DEFAULT_ALPHA };
            part.colours.push(Vec4::new(channel(0), channel(1), channel(2), alpha));
        }
    }
    Ok(())
}
