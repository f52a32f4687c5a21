//! Colour with perspective: where a plane does for the colours of a triangle, and what they are where it does not.
//!
//! Colour over w and 1/w are linear on the screen, and colour is their quotient. On the way between two pixels, or two
//! corners, with the colours `a` and `b` and with 1/w `p` and `q`, it is off the straight line by at most
//!
//! > |a - b| · |√p - √q| / (√p + √q).
//!
//! Where 1/w is constant, colour is linear. So no pixel of a triangle is off the plane through its corners by more than
//! some point of an edge.

use super::raster::{Corner, Placed, centre, cross};
use glam::DVec4;

/// How far colours may be off what they are with perspective, in levels of 255: rounded, they are equal or neighbours.
const MOST_BEND: f64 = 0.5;

/// A colour with perspective.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shade {
    /// 0..=255 per channel.
    pub colour: DVec4,
    /// 1 / w.
    inv_w: f64,
}

impl Shade {
    fn new(colour_over_w: DVec4, inv_w: f64) -> Shade {
        let colour = (colour_over_w / inv_w).clamp(DVec4::ZERO, DVec4::splat(255.0));
        Shade { colour, inv_w }
    }

    /// That of a corner.
    pub fn of(corner: &Corner) -> Shade {
        Shade::new(corner.colour_over_w, corner.inv_w)
    }

    /// That of a pixel of a triangle.
    pub fn at(triangle: &Placed, x: u32, y: u32) -> Shade {
        let (x, y) = (centre(x.into()), centre(y.into()));
        let (mut colour_over_w, mut inv_w) = (DVec4::ZERO, 0.0);
        for (corner, (from, to)) in triangle.corners.iter().zip(triangle.edges) {
            let weight = cross(from, to, x, y) as f64 / triangle.area as f64;
            colour_over_w += weight * corner.colour_over_w;
            inv_w += weight * corner.inv_w;
        }
        Shade::new(colour_over_w, inv_w)
    }

    /// Whether colours on the way to another place are on the straight line, near enough.
    pub fn is_straight_to(&self, other: &Shade) -> bool {
        let change = (self.colour - other.colour).abs().max_element();
        let [p, q] = [self.inv_w, other.inv_w].map(f64::sqrt);
        change * (p - q).abs() <= MOST_BEND * (p + q)
    }
}

/// Whether the colours of a triangle are on the plane through its corners, near enough.
pub(super) fn is_plane([a, b, c]: &[Shade; 3]) -> bool {
    a.is_straight_to(b) && b.is_straight_to(c) && c.is_straight_to(a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 0 at w = 1 to 200 at w = 9: 100 at most, as the rule says, where 1/w is the geometric mean.
    #[test]
    fn the_most_bend_is_reached() {
        let shade = |part: f64| {
            Shade::new(DVec4::ZERO.lerp(DVec4::splat(200.0 / 9.0), part), 1.0 - part * 8.0 / 9.0)
        };
        let off = |part: f64| (200.0 * part - shade(part).colour.x).abs();
        let most = (0..=10_000).map(|k| off(f64::from(k) / 1e4)).fold(0.0, f64::max);
        assert!((most - 100.0).abs() < 1e-6, "{most}");
        assert!((off(0.75) - 100.0).abs() < 1e-12, "1/w is 1/3");
    }

    #[test]
    fn colours_bend_where_they_change_and_w_does() {
        let shade = |colour: f64, w: f64| Shade::new(DVec4::splat(colour / w), 1.0 / w);
        assert!(shade(0.0, 1.0).is_straight_to(&shade(255.0, 1.0)));
        assert!(shade(99.0, 1.0).is_straight_to(&shade(99.0, 1e6)));
        // Half of the change.
        assert!(shade(10.0, 1.0).is_straight_to(&shade(10.99, 9.0)));
        assert!(!shade(10.0, 1.0).is_straight_to(&shade(11.01, 9.0)));
        assert!(is_plane(&[shade(1.0, 1.0), shade(1.9, 9.0), shade(1.5, 4.0)]));
        assert!(!is_plane(&[shade(1.0, 1.0), shade(1.9, 9.0), shade(2.5, 9.0)]));
    }
}
