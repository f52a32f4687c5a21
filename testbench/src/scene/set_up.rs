//! Set-up: triangles on the screen as engines take them, see [`pellucid_machine::primitive`].
//!
//! An engine's arithmetic is in whole numbers, and so is all of this: a triangle has the same pixels as when the
//! rasteriser draws it. Depth and colour are linear over it, rounded to 2^-16 in its corners and in what they gain from
//! pixel to pixel. Colour is so without perspective, which shows on triangles that are large and steep. No corner lies
//! at the far plane, where it could not be seen.

use super::raster::{Corner, PIXEL, Placed, centre, cross, owns_its_points};
use glam::DVec4;
use pellucid_machine::pixel::{Fragment, Z_FAR};
use pellucid_machine::primitive::{
    Attributes, BOUND_BITS, CHANNEL_PLANE_BITS, Edge, FRACTION_BITS, Primitive, Side, Z_PLANE_BITS,
};
use pellucid_sim::Label;

/// One, in fixed point.
const ONE: f64 = (1u32 << FRACTION_BITS) as f64;
/// Half of it: what comes before the point is rounded down.
const HALF: i128 = 1 << (FRACTION_BITS - 1);
/// The most depth of a corner. Over the sides of the largest screen, what is rounded adds up to 1/8 at most.
const DEEPEST: f64 = Z_FAR as f64 - 0.5;
/// The least alpha that is rounded to 255.
const OPAQUE: f64 = 254.5;

/// A number in two's complement.
fn bits(value: i128, bits: u32) -> u64 {
    (value & ((1 << bits) - 1)) as u64
}

/// An attribute's value per corner, or what it gains.
type Channels = [i128; 5];

fn attributes([z, red, green, blue, alpha]: Channels) -> Attributes {
    let channel = |value| bits(value, CHANNEL_PLANE_BITS) as u32;
    Attributes {
        z: bits(z, Z_PLANE_BITS),
        red: channel(red),
        green: channel(green),
        blue: channel(blue),
        alpha: channel(alpha),
    }
}

fn colour(corner: &Corner) -> DVec4 {
    (corner.colour_over_w / corner.inv_w).clamp(DVec4::ZERO, DVec4::splat(255.0))
}

fn channels(corner: &Corner) -> Channels {
    let z = ((corner.z * f64::from(Z_FAR)).clamp(0.0, DEEPEST) * ONE).round() as i128;
    let [red, green, blue, alpha] =
        colour(corner).to_array().map(|c| (c * ONE).round() as i128 + HALF);
    [z, red, green, blue, alpha]
}

/// A triangle on a screen of this size, set up; nothing if it has no pixel.
pub(super) fn set_up(corners: [Corner; 3], width: u32, height: u32) -> Option<Primitive> {
    let Placed { corners, edges, area, mut rows, .. } = Placed::new(corners, width, height)?;
    // The function of each edge is `PIXEL * (a * column + b * row) + c`.
    let lines = edges.map(|(from, to)| {
        let (a, b) = (from.y - to.y, to.x - from.x);
        let c = cross(from, to, centre(0), centre(0));
        (a, b, c, (c - i64::from(!owns_its_points(from, to))).div_euclid(PIXEL))
    });
    for (a, b, _, inside) in lines {
        match (a, b.signum()) {
            (0, 1) => rows.start = rows.start.max(-inside.div_euclid(b)),
            (0, -1) => rows.end = rows.end.min(inside.div_euclid(-b) + 1),
            _ => {}
        }
    }
    if rows.is_empty() {
        return None;
    }
    let first = rows.start;
    let edge = |(a, b, _, inside): (i64, i64, i64, i64)| {
        let height = a.abs();
        let side = match a.signum() {
            1 => Side::Left,
            -1 => Side::Right,
            _ => return Edge::default(),
        };
        let at = b * first + inside;
        Edge {
            side,
            bound: bits(at.div_euclid(height).into(), BOUND_BITS),
            bound_step: bits(b.div_euclid(height).into(), BOUND_BITS),
            rest: at.rem_euclid(height) as u32,
            rest_step: b.rem_euclid(height) as u32,
            height: height as u32,
        }
    };
    let values = corners.each_ref().map(channels);
    // A mean of the corners' values, weighted by `weight` of each edge over the area.
    let mean = |weight: &dyn Fn(usize) -> i128| {
        let sum = |channel: usize| (0..3).map(|i| values[i][channel] * weight(i)).sum::<i128>();
        let area = i128::from(area);
        attributes([0, 1, 2, 3, 4].map(|channel| (sum(channel) + area / 2).div_euclid(area)))
    };
    let of = |i: usize| lines[i];
    let [per_column, per_row] =
        [mean(&|i| i128::from(of(i).0 * PIXEL)), mean(&|i| i128::from(of(i).1 * PIXEL))];
    let pixels = u64::from(width) * u64::from(height);
    Some(Primitive {
        row: first as u32,
        last_row: rows.end as u32 - 1,
        edges: lines.map(edge),
        at: mean(&|i| i128::from(of(i).1 * PIXEL * first + of(i).2)),
        per_column,
        per_row,
        opaque: corners.iter().all(|corner| colour(corner).w >= OPAQUE),
        area: ((area / (2 * PIXEL * PIXEL)) as u64).min(pixels - 1) as u32,
        label: Label::NONE,
    })
}

/// A fragment as a primitive that has just that pixel.
pub fn point(fragment: Fragment) -> Primitive {
    let Fragment { x, y, z, rgba, label } = fragment;
    let [red, green, blue, alpha] = rgba.to_be_bytes().map(|c| i128::from(c) << FRACTION_BITS);
    let bound = |side, bound: i64| Edge {
        side,
        bound: bits(bound.into(), BOUND_BITS),
        height: 1,
        ..Edge::default()
    };
    Primitive {
        row: y,
        last_row: y,
        edges: [bound(Side::Left, -i64::from(x)), bound(Side::Right, x.into()), Edge::default()],
        at: attributes([i128::from(z) << FRACTION_BITS, red, green, blue, alpha]),
        opaque: fragment.is_opaque(),
        area: 0,
        label,
        ..Primitive::default()
    }
}

#[cfg(test)]
mod tests;
