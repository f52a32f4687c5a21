//! Simple bodies to furnish a scene with.

use crate::scene::geometry::Part;
use glam::{Vec3, Vec4, vec3};
use std::f32::consts::{PI, TAU};

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
    let mut part = Part::new(vec![name.into()]);
    sphere_of(&mut part, centre, radius, SPHERE_STEPS);
    part.painted(colour)
}

/// Appends a sphere with so many steps around it; half as many from pole to pole.
pub(super) fn sphere_of(part: &mut Part, centre: Vec3, radius: f32, steps: u32) {
    grid(part, steps, steps / 2, |u, v| {
        let normal = on_sphere(u, v);
        (centre + radius * normal, normal)
    });
}

/// Appends a sphere of radius 1 around the origin whose poles lie on the z axis, ring by ring from the farther one.
pub(super) fn sphere_along_z(part: &mut Part, steps: u32) {
    grid(part, steps, steps / 2, |u, v| {
        let Vec3 { x, y, z } = on_sphere(u, v);
        let normal = vec3(x, z, -y);
        (normal, normal)
    });
}

/// The point of the sphere of radius 1 that is so much of the way around it, and from its upper pole down.
fn on_sphere(u: f32, v: f32) -> Vec3 {
    let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
    vec3(sin_v * cos_u, cos_v, sin_v * sin_u)
}

/// Appends a tube without ends, from a point on, with so many steps around and along it.
pub(super) fn tube(part: &mut Part, from: Vec3, way: Vec3, radius: f32, steps: (u32, u32)) {
    let (right, up) = way.normalize().any_orthonormal_pair();
    grid(part, steps.0, steps.1, |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        let normal = cos * right + sin * up;
        (from + v * way + radius * normal, normal)
    });
}

/// Appends a box around its centre, its sides along the axes, of twelve triangles.
pub(super) fn box_of(part: &mut Part, centre: Vec3, size: Vec3) {
    faces(part, centre, [Vec3::X, Vec3::Y, Vec3::Z], size, 1);
}

/// A box that stands on its base's centre, turned around the vertical by `turn` radians.
pub(super) fn cuboid(name: &str, base: Vec3, size: Vec3, turn: f32, colour: Vec4) -> Part {
    let mut part = Part::new(vec![name.into()]);
    let (sin, cos) = turn.sin_cos();
    let axes = [vec3(cos, 0.0, sin), Vec3::Y, vec3(-sin, 0.0, cos)];
    faces(&mut part, base + Vec3::Y * size.y / 2.0, axes, size, PANEL_STEPS);
    part.painted(colour)
}

/// Appends the faces of a box around its centre, each with so many steps along its sides.
fn faces(part: &mut Part, centre: Vec3, axes: [Vec3; 3], size: Vec3, steps: u32) {
    for axis in 0..3 {
        let [out, right, up] = [axis, (axis + 1) % 3, (axis + 2) % 3].map(|i| axes[i] * size[i]);
        for side in [-0.5, 0.5] {
            let corner = centre + side * out - 0.5 * (right + up);
            grid(part, steps, steps, |u, v| (corner + u * right + v * up, side * out));
        }
    }
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
