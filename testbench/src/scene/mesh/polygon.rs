//! Polygons to triangles: a convex one as a fan around its first corner, any other by ear clipping.
//!
//! A polygon is cut as it is seen along its normal, so that one that is bent a little is cut as well. The triangles keep
//! its sense of rotation.

use earcut::{Earcut, deviation};
use glam::{DVec2, DVec3, Vec3};

/// Most corners of a polygon.
pub(super) const MOST_CORNERS: usize = 1 << 16;
/// The part of an area that is lost or gained by rounding, at most.
const ROUNDING: f64 = 1e-6;

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// Its triangles cover it once.
    Whole,
    /// Its outline crosses itself or goes round twice: its triangles may cover some of it twice, or leave some out.
    Crossed,
    /// It has fewer than three corners, or all of them lie on a line: none of its triangles has an area.
    Flat,
}

/// Cuts polygons into triangles.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    outline: Vec<DVec2>,
    ears: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of the polygon with corners at these positions, at most [`MOST_CORNERS`], as numbers of them.
    pub fn cut(&mut self, corners: &[Vec3]) -> (Cut, &[[u32; 3]]) {
        self.triangles.clear();
        let normal = normal(corners);
        self.outline.clear();
        self.outline.extend(corners.iter().map(|corner| seen_along(normal, corner.as_dvec3())));
        let is_flat = normal == DVec3::ZERO;
        if is_flat || is_convex(&self.outline) {
            self.triangles.extend((2..corners.len() as u32).map(|i| [0, i - 1, i]));
            return (if is_flat { Cut::Flat } else { Cut::Whole }, &self.triangles);
        }
        let points = || self.outline.iter().map(|point| point.to_array());
        self.earcut.earcut(points(), &[], &mut self.ears);
        self.triangles.extend(self.ears.as_chunks().0.iter().map(|&[a, b, c]| {
            let turn = turn([a, b, c].map(|i| self.outline[i as usize]));
            if turn < 0.0 { [a, c, b] } else { [a, b, c] }
        }));
        let lost = deviation(points(), &[], &self.ears) > ROUNDING;
        let is_crossed = lost || crosses_itself(&self.outline);
        (if is_crossed { Cut::Crossed } else { Cut::Whole }, &self.triangles)
    }
}

/// Whether a triangle has an area.
pub(super) fn has_area(corners: [Vec3; 3]) -> bool {
    normal(&corners) != DVec3::ZERO
}

/// Twice the area of a polygon along its normal, by Newell's method (Tampieri, Graphics Gems III). Where parts of the
/// polygon cancel, that of its largest triangle with the first corner; zero if all corners lie on a line.
fn normal(corners: &[Vec3]) -> DVec3 {
    let Some(first) = corners.first() else {
        return DVec3::ZERO;
    };
    let from_first = |corner: &Vec3| corner.as_dvec3() - first.as_dvec3();
    let triangles = corners.windows(2).map(|pair| from_first(&pair[0]).cross(from_first(&pair[1])));
    match triangles.clone().sum() {
        DVec3::ZERO => {
            let larger = |a: DVec3, b: DVec3| if a.length() < b.length() { b } else { a };
            triangles.fold(DVec3::ZERO, larger)
        }
        normal => normal,
    }
}

/// A point without the coordinate along which the normal is longest; the polygon turns counter-clockwise.
fn seen_along(normal: DVec3, DVec3 { x, y, z }: DVec3) -> DVec2 {
    let size = normal.abs();
    let (along, seen) = if size.z >= size.x.max(size.y) {
        (normal.z, DVec2::new(x, y))
    } else if size.y >= size.x {
        (normal.y, DVec2::new(z, x))
    } else {
        (normal.x, DVec2::new(y, z))
    };
    if along < 0.0 { DVec2::new(-seen.x, seen.y) } else { seen }
}

/// Twice the signed area of a triangle: positive if it turns counter-clockwise.
fn turn([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The sides of an outline, each with the corner after it.
fn sides(outline: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    outline.iter().copied().zip(outline.iter().copied().cycle().skip(1))
}

/// Whether an outline turns nowhere to the right, and once round in all.
fn is_convex(outline: &[DVec2]) -> bool {
    let next = |i: usize| outline[i % outline.len()];
    let left = (0..outline.len()).all(|i| turn([next(i), next(i + 1), next(i + 2)]) >= 0.0);
    // A way that always turns left goes to and fro as often as it goes round.
    let ways: Vec<bool> = sides(outline)
        .map(|(a, b)| b - a)
        .filter(|way| *way != DVec2::ZERO)
        .map(is_upward)
        .collect();
    let back_and_forth = ways.iter().zip(ways.iter().cycle().skip(1)).filter(|(a, b)| a != b);
    left && back_and_forth.count() == 2
}

/// Whether a way goes up, or straight to the right.
fn is_upward(way: DVec2) -> bool {
    way.y > 0.0 || (way.y == 0.0 && way.x > 0.0)
}

/// Whether two sides of an outline cross at a point that is no corner, or run along each other the same way, as those of
/// one that goes round twice do.
fn crosses_itself(outline: &[DVec2]) -> bool {
    let mut sides: Vec<(DVec2, DVec2)> = sides(outline).collect();
    let left = |(a, b): &(DVec2, DVec2)| a.x.min(b.x);
    let right = |(a, b): &(DVec2, DVec2)| a.x.max(b.x);
    sides.sort_by(|a, b| left(a).total_cmp(&left(b)));
    let apart = |(a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)| {
        let (c, d) = (turn([a, b, c]), turn([a, b, d]));
        (c < 0.0 && d > 0.0) || (c > 0.0 && d < 0.0)
    };
    sides.iter().enumerate().any(|(i, one)| {
        let mut near = sides[i + 1..].iter().take_while(|other| left(other) <= right(one));
        near.any(|other| (apart(*one, *other) && apart(*other, *one)) || run_together(*one, *other))
    })
}

/// Whether two sides lie on one line, have more than a point in common, and the same direction.
fn run_together((a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)) -> bool {
    let along = |point: DVec2| (point - a).dot(b - a);
    let on_one_line = turn([a, b, c]) == 0.0 && turn([a, b, d]) == 0.0;
    on_one_line && along(c) < along(d) && along(c) < along(b) && along(d) > 0.0
}

#[cfg(test)]
mod tests;
