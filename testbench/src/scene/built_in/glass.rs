//! Tinted panes and spheres that stand in each other, opaque things among them, all on a checkered floor.
//!
//! The submission order is a stress test as much as the picture: opaque and transparent parts alternate, and the floor
//! and the boxes arrive after glass that they hide.

use super::shapes::{checkers, cuboid, panel, sphere};
use super::teapot;
use crate::scene::camera::Camera;
use crate::scene::geometry::Part;
use glam::{Vec3, Vec4, vec3, vec4};

/// Background, `0xRRGGBB`.
pub(in crate::scene) const BACKGROUND: u32 = 0xdfe7ee;

/// The view that the scene is made for.
pub(in crate::scene) fn camera() -> Camera {
    Camera::new(vec3(2.6, 4.0, 9.8), vec3(-0.05, 0.98, 0.0), 32.0)
}

/// The scene's parts in order of submission.
pub(in crate::scene) fn parts() -> Vec<Part> {
    let mut parts = vec![
        pane(vec3(-3.0, 0.0, -1.0), vec3(3.5, 0.0, 1.3), 2.6, vec4(1.0, 0.30, 0.24, 0.44)),
        cuboid(
            "boxes",
            vec3(2.5, 0.0, -1.9),
            vec3(1.0, 2.3, 1.0),
            0.5,
            vec4(0.98, 0.80, 0.34, 1.0),
        ),
        bubble(vec3(-1.6, 0.85, 0.3), 0.5, vec4(1.0, 0.45, 0.55, 0.34)),
        bubble(vec3(-1.75, 1.0, 0.2), 1.0, vec4(0.30, 0.78, 0.98, 0.26)),
        pane(vec3(-2.7, 0.0, 1.3), vec3(2.2, 0.0, -3.2), 2.1, vec4(0.14, 0.72, 0.46, 0.44)),
    ];
    parts.extend(teapot::parts().into_iter().map(porcelain));
    parts.extend([
        bubble(vec3(2.15, 0.8, 0.95), 0.8, vec4(1.0, 0.60, 0.16, 0.32)),
        cuboid(
            "boxes",
            vec3(-3.3, 0.0, -2.5),
            vec3(1.2, 1.5, 1.2),
            -0.35,
            vec4(0.36, 0.48, 0.80, 1.0),
        ),
        pane(vec3(1.0, 0.0, 1.7), vec3(2.2, 0.0, -2.3), 1.8, vec4(0.20, 0.38, 0.98, 0.42)),
        bubble(vec3(0.9, 0.45, 2.5), 0.45, vec4(0.92, 0.30, 0.80, 0.34)),
        checkers("floor", 18, 0.0, [vec4(0.95, 0.94, 0.91, 1.0), vec4(0.44, 0.49, 0.56, 1.0)]),
        pane(vec3(-1.1, 0.0, -2.6), vec3(4.4, 0.0, 0.6), 2.9, vec4(0.64, 0.38, 0.90, 0.36)),
        bubble(vec3(1.55, 2.25, -0.9), 0.62, vec4(0.98, 0.92, 0.30, 0.30)),
        cuboid(
            "boxes",
            vec3(-1.0, 0.0, 2.75),
            vec3(0.55, 0.42, 0.55),
            0.9,
            vec4(0.94, 0.44, 0.36, 1.0),
        ),
    ]);
    parts
}

fn pane(corner: Vec3, right: Vec3, height: f32, colour: Vec4) -> Part {
    Part { gloss: 0.35, rim: 0.5, ..panel("panes", corner, right, Vec3::Y * height, colour) }
}

fn bubble(centre: Vec3, radius: f32, colour: Vec4) -> Part {
    Part { gloss: 0.9, rim: 0.9, ..sphere("spheres", centre, radius, colour) }
}

/// The teapot at about half its size, in opaque white.
fn porcelain(part: Part) -> Part {
    let mut part = part.painted(vec4(0.93, 0.91, 0.88, 1.0));
    part.positions.iter_mut().for_each(|p| *p = *p * 0.46 + vec3(0.1, 0.0, 0.5));
    Part { gloss: 0.55, ..part }
}
