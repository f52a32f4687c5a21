//! Gaussian splats, as programs that make them from photographs write them.
//!
//! Colour is the part that does not depend on the direction, `f_dc_0` to `f_dc_2`; what does, `f_rest_*`, is left out.

use super::header::Element;
use super::values::Values;
use crate::scene::SceneError;
use crate::scene::geometry::{Part, VERTEX_BYTES};
use crate::scene::mesh::Reading;
use crate::scene::splat::covariance;
use glam::{Mat3, Quat, Vec3};
use std::f32::consts::PI;

/// What each splat has: a position, colour and opacity, the logarithms of its deviations, and its rotation.
const FIELDS: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
    "rot_0", "rot_1", "rot_2", "rot_3",
];

/// Whether elements are splats.
pub(super) fn are_splats(element: &Element) -> bool {
    FIELDS.iter().all(|name| element.has_number(name))
}

/// Reads splats into the part.
pub(super) fn read(
    file: &mut Reading,
    values: &mut Values,
    element: &Element,
    part: &mut Part,
) -> Result<(), SceneError> {
    let count = usize::try_from(element.count).unwrap_or(usize::MAX);
    file.take(count.saturating_mul(VERTEX_BYTES + size_of::<Mat3>()))?;
    let fields: Vec<Option<usize>> = (element.properties.iter())
        .map(|property| FIELDS.iter().position(|name| property.name == *name))
        .collect();
    for i in 0..element.count {
        let mut found = [0.0; FIELDS.len()];
        values.element(file, element, &fields, &mut found)?;
        let [x, y, z, red, green, blue, opacity, s0, s1, s2, w, rx, ry, rz] =
            found.map(|value| value as f32);
        // The first of the spherical harmonics, the same in all directions.
        let flat = 0.5 / PI.sqrt();
        let colour = Vec3::splat(0.5) + flat * Vec3::new(red, green, blue);
        let colour = colour.clamp(Vec3::ZERO, Vec3::ONE).extend(1.0 / (1.0 + (-opacity).exp()));
        let rotation = Quat::from_xyzw(rx, ry, rz, w);
        let deviations = Vec3::new(s0, s1, s2).exp();
        let (position, length) = (Vec3::new(x, y, z), rotation.length());
        let covariance = covariance(deviations, rotation / length);
        if !(position.is_finite() && covariance.is_finite() && colour.is_finite()) {
            return Err(file.bad(values.line(), format!("splat {i} is not finite")));
        }
        part.positions.push(position);
        part.colours.push(colour);
        part.splats.push(covariance);
    }
    Ok(())
}
