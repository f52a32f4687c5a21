//! The Utah teapot: Bezier patches to triangles.

use super::patches::{PATCHES, POINTS, Patch};
use crate::scene::geometry::Part;
use glam::{Vec3, vec3};

/// Steps along each side of a patch.
const STEPS: u32 = 12;
/// How far from a patch's border its normals are taken, since the sides that shrink to a point have none there.
const NORMAL_INSET: f32 = 1e-3;

/// The teapot, y up, standing on y = 0 with its spout along x; parts in the order of the stored patches.
pub(in crate::scene) fn parts() -> Vec<Part> {
    PATCHES.iter().map(part).collect()
}

fn part(patch: &Patch) -> Part {
    let mut part = Part::new(vec!["teapot".into(), patch.name.into()]);
    for x in if patch.quarter { &[1.0, -1.0][..] } else { &[1.0] } {
        for y in [1.0, -1.0] {
            tessellate(
                patch.points.map(|i| Vec3::from(POINTS[usize::from(i)]) * vec3(*x, y, 1.0)),
                &mut part,
            );
        }
    }
    part
}

/// Appends a grid of triangles over one patch, turned from z up to y up.
fn tessellate(points: [Vec3; 16], part: &mut Part) {
    let first = part.positions.len() as u32;
    let upright = |p: Vec3| vec3(p.x, p.z, -p.y);
    for row in 0..=STEPS {
        for column in 0..=STEPS {
            let [u, v] = [column, row].map(|step| step as f32 / STEPS as f32);
            part.positions.push(upright(at(&points, bernstein(u), bernstein(v))));
            let [u, v] = [u, v].map(|t| t.clamp(NORMAL_INSET, 1.0 - NORMAL_INSET));
            let along = at(&points, bernstein_slope(u), bernstein(v));
            let across = at(&points, bernstein(u), bernstein_slope(v));
            part.normals.push(upright(along.cross(across)));
        }
    }
    for row in 0..STEPS {
        for column in 0..STEPS {
            let a = first + row * (STEPS + 1) + column;
            let b = a + STEPS + 1;
            part.triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
        }
    }
}

fn at(points: &[Vec3; 16], u: [f32; 4], v: [f32; 4]) -> Vec3 {
    (0..16).map(|i| points[i] * u[i % 4] * v[i / 4]).sum()
}

fn bernstein(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

fn bernstein_slope(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirror_images_make_32_patches() {
        let triangles: usize = parts().iter().map(|part| part.triangles.len()).sum();
        assert_eq!(triangles, 32 * (2 * STEPS * STEPS) as usize);
    }

    #[test]
    fn the_teapot_has_its_known_extent() {
        let points: Vec<Vec3> = parts().into_iter().flat_map(|part| part.positions).collect();
        let low = points.iter().copied().reduce(Vec3::min).unwrap();
        let high = points.iter().copied().reduce(Vec3::max).unwrap();
        assert!(low.abs_diff_eq(vec3(-3.0, 0.0, -2.0), 1e-5), "{low}");
        assert!(high.abs_diff_eq(vec3(3.434, 3.15, 2.0), 5e-3), "{high}");
    }

    #[test]
    fn neighbouring_body_patches_meet_smoothly() {
        let parts = parts();
        let (upper, lower) = (&parts[1], &parts[2]);
        for column in 0..=STEPS as usize {
            let last_row = (STEPS * (STEPS + 1)) as usize + column;
            assert_eq!(upper.positions[last_row], lower.positions[column]);
            let angle = upper.normals[last_row].angle_between(lower.normals[column]);
            assert!(angle < 0.01, "{angle}");
        }
    }
}
