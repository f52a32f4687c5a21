//! Set-up: triangles on the screen as engines take them, see [`pellucid_machine::primitive`].
//!
//! There is one truth for the fragments of a triangle: the walk of what it is set up as. An engine makes it pixel by pixel,
//! and for machines that take fragments the golden model's walk does. All of it is in whole numbers. Depth and colour are
//! linear over a primitive, rounded to 2^-16 in its corners and in what they gain from pixel to pixel. Where colours with
//! perspective are too far from that, a triangle comes in pieces, each a part of a row. No corner lies at the far plane, where
//! it could not be seen.

use super::order::Order;
use super::perspective::{Shade, is_plane};
use super::raster::{Corner, PIXEL, Placed, centre, cross, owns_its_points};
use crate::golden::primitive::{columns, fragment};
use pellucid_machine::pixel::{Fragment, Z_FAR};
use pellucid_machine::primitive::{
    Attributes, BOUND_BITS, CHANNEL_PLANE_BITS, Edge, FRACTION_BITS, Primitive, Side, Z_PLANE_BITS,
    plus, times,
};
use pellucid_sim::Label;
use std::ops::RangeInclusive;

/// One, in fixed point.
const ONE: f64 = (1u32 << FRACTION_BITS) as f64;
/// Half of it: what comes before the point is rounded down.
const HALF: i64 = 1 << (FRACTION_BITS - 1);
/// The most depth of a corner. Over the sides of the largest screen, what is rounded adds up to 1/8 at most.
const DEEPEST: f64 = Z_FAR as f64 - 0.5;
/// The least alpha that is rounded to 255.
const OPAQUE: f64 = 254.5;

/// A number in two's complement.
fn bits(value: i64, bits: u32) -> u64 {
    value as u64 & ((1 << bits) - 1)
}

/// An attribute's value per corner, or what it gains.
type Channels = [i64; 5];

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

/// A value that is not negative in fixed point, rounded to nearest.
fn fixed(value: f64) -> i64 {
    (value * ONE + 0.5) as i64
}

fn channels(corner: &Corner, shade: &Shade) -> Channels {
    let [red, green, blue, alpha] = shade.colour.to_array().map(|channel| fixed(channel) + HALF);
    [fixed((corner.z * f64::from(Z_FAR)).clamp(0.0, DEEPEST)), red, green, blue, alpha]
}

/// A quotient, rounded to nearest, two's complement. Most dividends fit into 64 bits, which takes a fraction of the time.
fn divided(dividend: i128, divisor: i64) -> i64 {
    let dividend = dividend + i128::from(divisor / 2);
    match i64::try_from(dividend) {
        Ok(dividend) => dividend.div_euclid(divisor),
        Err(_) => dividend.div_euclid(divisor.into()) as i64,
    }
}

/// A triangle on the screen, set up.
#[derive(Clone, Debug)]
pub(super) struct SetUp {
    /// All of it, with its colours as a plane.
    whole: Primitive,
    /// Parts of its rows, row by row from left to right, if its colours are no plane.
    spans: Vec<Primitive>,
    width: u32,
}

impl SetUp {
    /// The triangle on a screen of this size; nothing if it has no pixel.
    pub fn new(corners: [Corner; 3], width: u32, height: u32) -> Option<SetUp> {
        let triangle = Placed::new(corners, width, height)?;
        let shades = triangle.corners.each_ref().map(Shade::of);
        let whole = whole(&triangle, &shades, width, height)?;
        let mut spans = vec![];
        if !is_plane(&shades) {
            for row in whole.row..=whole.last_row {
                let columns = columns(&whole, row, width);
                if !columns.is_empty() {
                    bend(&triangle, &whole, row, columns.start..=columns.end - 1, &mut spans);
                }
            }
        }
        Some(SetUp { whole, spans, width })
    }

    /// As an engine takes it: one primitive after the other.
    pub fn primitives(&self) -> &[Primitive] {
        if self.spans.is_empty() { std::slice::from_ref(&self.whole) } else { &self.spans }
    }

    /// Sends the fragments of its primitives.
    pub fn draw<E>(
        &self,
        order: Order,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let of = |primitive: &Primitive, row| columns(primitive, row, self.width);
        let rows = self.whole.row..self.whole.last_row + 1;
        order.runs(rows, |row| of(&self.whole, row), &mut |row, mut run| {
            if self.spans.is_empty() {
                return run.try_for_each(|column| sink(fragment(&self.whole, column, row)));
            }
            let before = |span: &Primitive| (span.row, of(span, span.row).end) <= (row, run.start);
            for span in &self.spans[self.spans.partition_point(before)..] {
                let end = of(span, row).end.min(run.end);
                (run.start..end).try_for_each(|column| sink(fragment(span, column, row)))?;
                run.start = end;
                if run.is_empty() {
                    break;
                }
            }
            Ok(())
        })
    }
}

/// A triangle with its colours as a plane; nothing if it has no pixel.
fn whole(triangle: &Placed, shades: &[Shade; 3], width: u32, height: u32) -> Option<Primitive> {
    let Placed { corners, edges, area, .. } = triangle;
    let mut rows = triangle.rows.clone();
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
            bound: bits(at.div_euclid(height), BOUND_BITS),
            bound_step: bits(b.div_euclid(height), BOUND_BITS),
            rest: at.rem_euclid(height) as u32,
            rest_step: b.rem_euclid(height) as u32,
            height: height as u32,
        }
    };
    let [a, b, c] = [0, 1, 2].map(|i| channels(&corners[i], &shades[i]));
    // How far a mean of the corners' values, weighted by each edge's `[_, b, c]` over the area, is from the first one's.
    let mean = |[_, of_b, of_c]: [i64; 3]| {
        let from_a = |k: usize| {
            i128::from(b[k] - a[k]) * i128::from(of_b) + i128::from(c[k] - a[k]) * i128::from(of_c)
        };
        [0, 1, 2, 3, 4].map(|channel| divided(from_a(channel), *area))
    };
    let gain = |weights| attributes(mean(weights));
    let at = mean(lines.map(|(_, b, c, _)| b * PIXEL * first + c));
    let pixels = u64::from(width) * u64::from(height);
    Some(Primitive {
        row: first as u32,
        last_row: rows.end as u32 - 1,
        edges: lines.map(edge),
        at: attributes([0, 1, 2, 3, 4].map(|channel| a[channel].wrapping_add(at[channel]))),
        per_column: gain(lines.map(|(a, ..)| a * PIXEL)),
        per_row: gain(lines.map(|(_, b, ..)| b * PIXEL)),
        opaque: shades.iter().all(|shade| shade.colour.w >= OPAQUE),
        area: ((area / (2 * PIXEL * PIXEL)) as u64).min(pixels - 1) as u32,
        label: Label::NONE,
    })
}

/// Adds the columns of a row of a triangle, whose depth `whole` has, in parts in which its colours are straight.
fn bend(
    triangle: &Placed,
    whole: &Primitive,
    row: u32,
    columns: RangeInclusive<u32>,
    spans: &mut Vec<Primitive>,
) {
    let (first, last) = columns.into_inner();
    let [from, to] = [first, last].map(|column| Shade::at(triangle, column, row));
    if first < last && !from.is_straight_to(&to) {
        let middle = (first + last) / 2;
        bend(triangle, whole, row, first..=middle, spans);
        return bend(triangle, whole, row, middle + 1..=last, spans);
    }
    let [from, to] = [from, to].map(|shade| shade.colour.to_array().map(fixed));
    let gain = |k: usize| divided((to[k] - from[k]).into(), i64::from(last - first).max(1));
    let gains = [0, 1, 2, 3].map(gain);
    let [red, green, blue, alpha] = gains;
    let z = whole.per_column.z;
    let per_column = Attributes { z, ..attributes([0, red, green, blue, alpha]) };
    let before = |k: usize| from[k] + HALF - gains[k] * i64::from(first);
    let [red, green, blue, alpha] = [0, 1, 2, 3].map(before);
    let z = plus(whole.at, times(whole.per_row, row - whole.row)).z;
    let at = Attributes { z, ..attributes([0, red, green, blue, alpha]) };
    let area = last - first;
    let opaque = whole.opaque;
    spans.push(Primitive { at, per_column, area, opaque, ..span(row, first..=last) });
}

/// Columns of a row as a primitive, without anything in them.
fn span(row: u32, columns: RangeInclusive<u32>) -> Primitive {
    let bound = |side, bound: i64| Edge {
        side,
        bound: bits(bound, BOUND_BITS),
        height: 1,
        ..Edge::default()
    };
    let (first, last) = columns.into_inner();
    let left = bound(Side::Left, -i64::from(first));
    let edges = [left, bound(Side::Right, last.into()), Edge::default()];
    Primitive { row, last_row: row, edges, ..Primitive::default() }
}

/// A primitive without a pixel in its row: it ends before it begins.
pub(super) fn without_pixel(row: u32) -> Primitive {
    span(row, RangeInclusive::new(1, 0))
}

/// A fragment as a primitive that has just that pixel.
pub fn point(fragment: Fragment) -> Primitive {
    let Fragment { x, y, z, rgba, label } = fragment;
    let [red, green, blue, alpha] = rgba.to_be_bytes().map(|c| i64::from(c) << FRACTION_BITS);
    Primitive {
        at: attributes([i64::from(z) << FRACTION_BITS, red, green, blue, alpha]),
        opaque: fragment.is_opaque(),
        label,
        ..span(y, x..=x)
    }
}

#[cfg(test)]
mod tests;
