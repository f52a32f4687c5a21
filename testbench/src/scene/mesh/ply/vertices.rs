//! The vertices of a PLY.

use super::header::{Element, Property};
use super::values::Values;
use crate::scene::SceneError;
use crate::scene::geometry::{DEFAULT_ALPHA, Part, VERTEX_BYTES};
use crate::scene::mesh::Reading;
use glam::{Vec3, Vec4};

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
pub(super) fn fraction(property: &Property, value: f64) -> f32 {
    let fraction = value / property.scalar.full_scale();
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
    let axis = |property: &Property| ["x", "y", "z"].iter().position(|axis| property.name == *axis);
    let fields: Vec<_> = element
        .properties
        .iter()
        .map(|p| (p, axis(p).filter(|_| p.count.is_none()), channel(p)))
        .collect();
    let (has_colour, _) = has_colour(element);
    for i in 0..element.count {
        values.begin(file, element)?;
        let (mut position, mut colour) = (Vec3::ZERO, NO_COLOUR);
        for (property, axis, channel) in &fields {
            let (None, None) = (axis, channel) else {
                let value = values.number(file, element, property, property.scalar)?;
                axis.iter().for_each(|axis| position[*axis] = value as f32);
                channel.iter().for_each(|channel| colour[*channel] = fraction(property, value));
                continue;
            };
            values.skip(file, element, property)?;
        }
        if !position.is_finite() {
            return Err(file.bad(values.line(), format!("vertex {i} is not finite")));
        }
        values.end(file, element)?;
        part.positions.push(position);
        if has_colour {
            part.colours.push(colour);
        }
    }
    Ok(())
}
