//! Simple bodies to furnish a scene with.

use crate::scene::geometry::Part;
use glam::{Vec3, Vec4, vec3};

/// Steps along each side of a panel, so that its highlight has a shape.
const PANEL_STEPS: u32 = 20;
/// Steps around a sphere; half as many from pole to pole.
const SPHERE_STEPS: u32 = 96;

/// A flat parallelogram with a corner and two sides.
pub(super) fn panel(name: &str, corner: Vec3, right: Vec3, up: Vec3, colour: Vec4) -> Part {
    let mut part = Part::new(vec![name.into()]);
    grid(&mut part, PANEL_STEPS, PANEL_STEPS, |u, v| {
        (corner + u * right + v * up, right.cross(up))
    });
    part.painted(colour)
}

/// A sphere.
pub(super) fn sphere(name: &str, centre: Vec3, radius: f32, colour: Vec4) -> Part {
    use std::f32::consts::{PI, TAU};
    let mut part = Part::new(vec![name.into()]);
    grid(&mut part, SPHERE_STEPS, SPHERE_STEPS / 2, |u, v| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
        let normal = vec3(sin_v * cos_u, cos_v, sin_v * sin_u);
        (centre + radius * normal, normal)
    });
    part.painted(colour)
}

/// A box that stands on its base's centre, turned around the vertical by `turn` radians.
pub(super) fn cuboid(name: &str, base: Vec3, size: Vec3, turn: f32, colour: Vec4) -> Part {
    let mut part = Part::new(vec![name.into()]);
    let (sin, cos) = turn.sin_cos();
    let axes = [vec3(cos, 0.0, sin), Vec3::Y, vec3(-sin, 0.0, cos)];
    let centre = base + Vec3::Y * size.y / 2.0;
    for axis in 0..3 {
        let [out, right, up] = [axis, (axis + 1) % 3, (axis + 2) % 3].map(|i| axes[i] * size[i]);
        for side in [-0.5, 0.5] {
            let corner = centre + side * out - 0.5 * (right + up);
            grid(&mut part, PANEL_STEPS, PANEL_STEPS, |u, v| {
                (corner + u * right + v * up, side * out)
            });
        }
    }
    part.painted(colour)
}

/// A horizontal checkerboard around the origin: `squares` squares of side 1 along each side, each of one colour.
pub(super) fn checkers(name: &str, squares: u32, height: f32, colours: [Vec4; 2]) -> Part {
    let mut part = Part::new(vec![name.into()]);
    let first = squares as f32 / -2.0;
    for row in 0..squares {
        for column in 0..squares {
            let corner = vec3(first + column as f32, height, first + row as f32);
            grid(&mut part, 2, 2, |u, v| (corner + vec3(u, 0.0, v), Vec3::Y));
            part.colours.resize(part.positions.len(), colours[((row + column) % 2) as usize]);
        }
    }
    part
}

/// Appends triangles over the unit square, mapped to positions and normals.
fn grid(part: &mut Part, columns: u32, rows: u32, map: impl Fn(f32, f32) -> (Vec3, Vec3)) {
    let first = part.positions.len() as u32;
    for row in 0..=rows {
        for column in 0..=columns {
            let (position, normal) = map(column as f32 / columns as f32, row as f32 / rows as f32);
            part.positions.push(position);
            part.normals.push(normal);
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = first + row * (columns + 1) + column;
            let b = a + columns + 1;
            part.triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
        }
    }
}
