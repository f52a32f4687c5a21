//! Cuts triangles at the near and far planes, and at a guard band around the screen.
//!
//! The guard band keeps screen coordinates small enough for exact fixed-point arithmetic; what lies between the
//! screen and the band is left to the rasteriser's bounding box, so that most triangles are never cut. An edge that two
//! triangles share is cut at the same point in both, because the point is always computed from the inner vertex.

use glam::{DVec4, Vec4};

/// Half-width of the guard band, in half-widths of the screen.
pub(super) const GUARD: f64 = 4.0;

/// A vertex before the division by `w`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vertex {
    /// Clip coordinates; inside the frustum `-w..=w` for x and y, `0..=w` for z.
    pub clip: DVec4,
    /// Red, green, blue and alpha, 0..=255.
    pub colour: Vec4,
}

/// A plane as the dot product that is not negative inside.
const PLANES: [DVec4; 6] = [
    DVec4::new(0.0, 0.0, 1.0, 0.0),
    DVec4::new(0.0, 0.0, -1.0, 1.0),
    DVec4::new(1.0, 0.0, 0.0, GUARD),
    DVec4::new(-1.0, 0.0, 0.0, GUARD),
    DVec4::new(0.0, 1.0, 0.0, GUARD),
    DVec4::new(0.0, -1.0, 0.0, GUARD),
];
/// A cut adds one corner to a convex polygon. Where rounding has bent the polygon it can add half as many as there are:
/// 3, 4, 6, 9, 13, 19, 28.
const MAX_CORNERS: usize = 28;

/// A convex polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    corners: [Vertex; MAX_CORNERS],
    count: usize,
}

impl Polygon {
    /// The corners in order, none if the triangle was cut away.
    pub fn corners(&self) -> &[Vertex] {
        &self.corners[..self.count]
    }

    fn push(&mut self, vertex: Vertex) {
        self.corners[self.count] = vertex;
        self.count += 1;
    }

    fn cut(&self, plane: DVec4) -> Polygon {
        let mut kept = Polygon { corners: self.corners, count: 0 };
        let mut from = self.count.wrapping_sub(1);
        for to in 0..self.count {
            let (a, b) = (self.corners[from], self.corners[to]);
            let (inside_a, inside_b) = (plane.dot(a.clip), plane.dot(b.clip));
            if inside_a >= 0.0 && inside_b < 0.0 {
                kept.push(crossing(a, b, inside_a, inside_b));
            } else if inside_a < 0.0 && inside_b >= 0.0 {
                kept.push(crossing(b, a, inside_b, inside_a));
            }
            if inside_b >= 0.0 {
                kept.push(b);
            }
            from = to;
        }
        kept
    }
}

/// The point between an inner and an outer vertex whose distance from the plane is 0.
fn crossing(inner: Vertex, outer: Vertex, inside: f64, outside: f64) -> Vertex {
    let t = inside / (inside - outside);
    Vertex {
        clip: inner.clip.lerp(outer.clip, t),
        colour: inner.colour.lerp(outer.colour, t as f32),
    }
}

/// Whether nothing of a triangle is to be cut away.
pub(super) fn is_inside(triangle: &[Vertex; 3]) -> bool {
    triangle.iter().all(|vertex| PLANES.iter().all(|plane| plane.dot(vertex.clip) >= 0.0))
}

/// The part of a triangle between the near and far planes and inside the guard band.
pub(super) fn clip(triangle: [Vertex; 3]) -> Polygon {
    let mut polygon = Polygon { corners: [Vertex::default(); MAX_CORNERS], count: 3 };
    polygon.corners[..3].copy_from_slice(&triangle);
    for plane in PLANES {
        if triangle.iter().any(|vertex| plane.dot(vertex.clip) < 0.0) {
            polygon = polygon.cut(plane);
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vertex(x: f64, y: f64, z: f64, w: f64) -> Vertex {
        Vertex { clip: DVec4::new(x, y, z, w), colour: Vec4::splat(x as f32) }
    }

    #[test]
    fn what_is_inside_stays_as_it_is() {
        let triangle =
            [vertex(-2.0, 0.0, 0.0, 1.0), vertex(2.0, 0.0, 1.0, 1.0), vertex(0.0, 3.9, 0.5, 1.0)];
        assert_eq!(clip(triangle).corners(), triangle);
    }

    #[test]
    fn what_is_outside_of_one_plane_vanishes() {
        assert!(
            clip([vertex(0.0, 0.0, -1.0, 1.0); 3]).corners().is_empty(),
            "nearer than the near plane"
        );
        assert!(
            clip([vertex(0.0, 0.0, 2.0, 1.0); 3]).corners().is_empty(),
            "farther than the far plane"
        );
        assert!(
            clip([vertex(9.0, 0.0, 0.5, 1.0); 3]).corners().is_empty(),
            "right of the guard band"
        );
    }

    #[test]
    fn the_near_plane_cuts_one_corner_into_two() {
        let polygon = clip([
            vertex(0.0, 0.0, -1.0, 1.0),
            vertex(2.0, 0.0, 1.0, 1.0),
            vertex(0.0, 2.0, 1.0, 1.0),
        ]);
        let expected = [
            vertex(0.0, 1.0, 0.0, 1.0),
            vertex(1.0, 0.0, 0.0, 1.0),
            vertex(2.0, 0.0, 1.0, 1.0),
            vertex(0.0, 2.0, 1.0, 1.0),
        ];
        assert_eq!(polygon.corners(), expected);
    }

    proptest! {
        #[test]
        fn nothing_outside_is_left(corners in prop::array::uniform3(prop::array::uniform4(-10.0..10.0))) {
            let triangle = corners.map(|c: [f64; 4]| vertex(c[0], c[1], c[2], c[3]));
            for corner in clip(triangle).corners() {
                for plane in PLANES {
                    prop_assert!(plane.dot(corner.clip) > -1e-9);
                }
            }
        }
    }
}
