//! Polygons worked by hand, and any polygon against a test of every pixel.

use super::*;
use crate::golden::primitive::fragments;
use crate::scene::raster::Corner;
use crate::scene::set_up::SetUp;
use glam::{DVec4, vec3};
use proptest::prelude::*;

fn cut(corners: &[Vec3]) -> (Cut, Vec<[u32; 3]>) {
    let mut cutter = Cutter::default();
    let (what, triangles) = cutter.cut(corners);
    (what, triangles.to_vec())
}

fn flat(corners: &[(i32, i32)]) -> Vec<Vec3> {
    corners.iter().map(|&(x, y)| vec3(x as f32, y as f32, 0.0)).collect()
}

/// Twice the signed area of each triangle, seen from +z.
fn areas(corners: &[(i32, i32)], triangles: &[[u32; 3]]) -> Vec<i32> {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| corners[i as usize]);
        (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
    };
    triangles.iter().map(area).collect()
}

#[test]
fn a_convex_polygon_is_a_fan_in_either_sense_also_with_corners_on_a_line() {
    let square = [(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)];
    let fan = vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]];
    assert_eq!(cut(&flat(&square)), (Cut::Whole, fan.clone()));
    let back: Vec<_> = square.into_iter().rev().collect();
    assert_eq!(cut(&flat(&back)), (Cut::Whole, fan));
}

#[test]
fn ears_keep_the_sense_of_the_polygon() {
    // An arrowhead: area 2 * 2 / 2 on either side of the middle.
    let head = [(0, 0), (2, -2), (0, 4), (-2, -2)];
    for (corners, sign) in [(head.to_vec(), 1), (head.iter().copied().rev().collect(), -1)] {
        let (what, triangles) = cut(&flat(&corners));
        assert_eq!((what, triangles.len()), (Cut::Whole, 2));
        assert_eq!(areas(&corners, &triangles), [sign * 8; 2]);
    }
}

#[test]
fn a_hole_that_is_joined_by_a_bridge_stays_open() {
    // A square of side 6 with a hole of side 2.
    let keyhole = [(0, 0), (6, 0), (6, 6), (0, 6), (0, 0), (2, 2), (2, 4), (4, 4), (4, 2), (2, 2)];
    let (what, triangles) = cut(&flat(&keyhole));
    let areas = areas(&keyhole, &triangles);
    assert!(areas.iter().all(|area| *area >= 0), "{areas:?}");
    assert_eq!((what, areas.iter().sum::<i32>()), (Cut::Whole, 2 * (36 - 4)));
}

#[test]
fn what_has_no_area_and_what_crosses_itself_is_told_of() {
    for corners in [&[][..], &[(1, 1)], &[(1, 1), (2, 2)], &[(0, 0), (1, 1), (3, 3), (2, 2)]] {
        let (what, triangles) = cut(&flat(corners));
        assert_eq!(
            (what, triangles.len()),
            (Cut::Flat, corners.len().saturating_sub(2)),
            "{corners:?}"
        );
        assert_eq!(areas(corners, &triangles).iter().sum::<i32>(), 0);
    }
    let bow_tie = [(0, 0), (4, 0), (0, 3), (5, 4)];
    let even = [(0, 0), (4, 0), (0, 4), (4, 4)];
    let star = [(0, 10), (-6, -8), (10, 3), (-10, 3), (6, -8)];
    let loop_in_loop =
        [(0, 0), (8, 0), (8, 8), (0, 8), (0, 1), (7, 1), (7, 7), (1, 7), (1, -1), (0, -1)];
    let eight = [(0, 0), (1, 1), (2, 3), (2, 0), (1, 1), (0, 2)];
    let twice = [(0, 0), (4, 0), (4, 3), (0, 3), (0, 0), (4, 0), (4, 3), (0, 3)];
    // Round the lower half, then round all: they have half of a vertical side in common.
    let half_twice = [(0, 0), (4, 0), (4, 3), (0, 3), (0, 0), (4, 0), (4, 6), (0, 6)];
    for corners in [&bow_tie[..], &even, &star, &loop_in_loop, &eight, &twice, &half_twice] {
        assert_eq!(cut(&flat(corners)).0, Cut::Crossed, "{corners:?}");
    }
}

/// Side of the screen in pixels, and of a pixel in steps.
const SIDE: i64 = 24;
const STEP: i64 = 256;

/// How often each pixel is covered by the triangles of a polygon on the screen.
fn coverage(corners: &[(i64, i64)], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut counts = vec![0; (SIDE * SIDE) as usize];
    for triangle in triangles {
        let corner = |i: u32| {
            let (x, y) = corners[i as usize];
            Corner { x, y, z: 0.5, inv_w: 1.0, colour_over_w: DVec4::ZERO }
        };
        let set_up = SetUp::new(triangle.map(corner), SIDE as u32, SIDE as u32);
        for primitive in set_up.iter().flat_map(SetUp::primitives) {
            for f in fragments(primitive, SIDE as u32) {
                counts[(f.y * SIDE as u32 + f.x) as usize] += 1;
            }
        }
    }
    counts
}

/// Whether a polygon has the centre of a pixel inside, by the sides to the right of it. The centre is moved to the
/// right by an infinitesimal step and down by a smaller one, so that it is on no side.
fn is_inside(corners: &[(i64, i64)], pixel: (i64, i64)) -> bool {
    let (px, py) = (pixel.0 * STEP + STEP / 2, pixel.1 * STEP + STEP / 2);
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let to_the_right = sides.filter(|((ax, ay), (bx, by))| {
        if (*ay <= py) == (*by <= py) {
            return false;
        }
        // How far the side is to the right of the centre, times its height.
        let (height, right) = (by - ay, (ax - px) * (by - ay) + (py - ay) * (bx - ax));
        // On the side: moved to the right of it.
        right != 0 && (right > 0) == (height > 0)
    });
    to_the_right.count() % 2 == 1
}

/// A polygon whose outline does not cross itself: a way through all points, turned round between any two sides that
/// cross, which makes it shorter.
fn untangled(mut corners: Vec<(i64, i64)>) -> Vec<(i64, i64)> {
    let turn = |a: (i64, i64), b: (i64, i64), c: (i64, i64)| {
        ((b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)).signum()
    };
    let count = corners.len();
    let crossing = |corners: &[(i64, i64)]| {
        (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))).find(|&(i, j)| {
            let [a, b, c, d] = [i, i + 1, j, j + 1].map(|i| corners[i % count]);
            turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0
        })
    };
    while let Some((i, j)) = crossing(&corners) {
        corners[i + 1..=j].reverse();
    }
    corners
}

proptest! {
    #[test]
    fn a_polygon_in_any_plane_covers_the_pixels_inside_once(
        points in prop::collection::vec((0..SIDE * STEP, 0..SIDE * STEP), 3..14),
        (slope_x, slope_y) in (-3i64..=3, -3i64..=3),
    ) {
        let corners = untangled(points);
        let in_space = |&(x, y): &(i64, i64)| vec3(x as f32, y as f32, (slope_x * x + slope_y * y) as f32);
        let (what, triangles) = cut(&corners.iter().map(in_space).collect::<Vec<_>>());
        prop_assert_ne!(what, Cut::Crossed);
        for (at, count) in (0i64..).zip(coverage(&corners, &triangles)) {
            let pixel = (at % SIDE, at / SIDE);
            prop_assert_eq!(count, u32::from(is_inside(&corners, pixel)), "pixel {:?}", pixel);
        }
    }
}
