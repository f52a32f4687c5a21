//! Which fragments a primitive has, in closed form, row by row: what the golden model has for machines that take primitives,
//! and what a scene plays to machines that take fragments.
//!
//! As all of the golden model it shares no line with the hardware, which goes from row to row and from pixel to pixel by
//! adding. Here each row's columns are a quotient, and each pixel's depth and colour a product with its place.

use pellucid_machine::pixel::{Fragment, Z_FAR};
use pellucid_machine::primitive::{
    Attributes, BOUND_BITS, CHANNEL_PLANE_BITS, Edge, FRACTION_BITS, MOST_TRANSPARENT, Primitive,
    Side, Z_PLANE_BITS,
};
use pellucid_sim::Label;
use std::ops::Range;

/// A number in two's complement of so many bits, at most 64; what is above them is without meaning.
fn signed(value: i64, bits: u32) -> i64 {
    value << (64 - bits) >> (64 - bits)
}

/// The bound of an edge that is not level, so many rows down from where the primitive begins: within
/// `BOUND_BITS`, if the primitive is on the screen there.
pub(crate) fn bound(edge: &Edge, down: u32) -> i64 {
    let Edge { bound, bound_step, rest, rest_step, height, .. } = *edge;
    let [bound, step] = [bound, bound_step].map(|bits| signed(bits as i64, BOUND_BITS));
    let [rest, rest_step, height, down] = [rest, rest_step, height, down].map(i64::from);
    bound + step * down + (rest + rest_step * down) / height
}

/// The columns of a primitive in one of its rows, on a screen `width` pixels wide.
pub(crate) fn columns(primitive: &Primitive, row: u32, width: u32) -> Range<u32> {
    let (mut start, mut end) = (0, i64::from(width));
    for edge in &primitive.edges {
        let bound = || bound(edge, row - primitive.row);
        match edge.side {
            Side::Level => {}
            Side::Left => start = start.max(-bound()),
            Side::Right => end = end.min(bound() + 1),
        }
    }
    if start < end { start as u32..end as u32 } else { 0..0 }
}

/// The fragment of a primitive at a pixel that it has.
pub(crate) fn fragment(primitive: &Primitive, x: u32, y: u32) -> Fragment {
    let Primitive { at, per_column, per_row, opaque, .. } = primitive;
    let down = y - primitive.row;
    // Two's complement: what is above a plane's bits falls away.
    let plane = |of: fn(&Attributes) -> i64, bits: u32| {
        let sum = of(at) + of(per_column) * i64::from(x) + of(per_row) * i64::from(down);
        signed(sum, bits) >> FRACTION_BITS
    };
    let channel = |of: fn(&Attributes) -> i64, most: u32| {
        plane(of, CHANNEL_PLANE_BITS).clamp(0, most.into()) as u8
    };
    let z = plane(|at| at.z as i64, Z_PLANE_BITS).clamp(0, Z_FAR.into()) as u32;
    let colour = [
        channel(|at| at.red.into(), 255),
        channel(|at| at.green.into(), 255),
        channel(|at| at.blue.into(), 255),
        if *opaque { 255 } else { channel(|at| at.alpha.into(), MOST_TRANSPARENT) },
    ];
    Fragment { x, y, z, rgba: u32::from_be_bytes(colour), label: Label::NONE }
}

/// All fragments of a primitive on a screen `width` pixels wide, row by row from left to right. Their depth is at most
/// [`Z_FAR`]; their alpha is 255 if the primitive is opaque, and at most [`MOST_TRANSPARENT`] if it is not.
pub fn fragments(primitive: &Primitive, width: u32) -> impl Iterator<Item = Fragment> {
    (primitive.row..=primitive.last_row).flat_map(move |row| {
        columns(primitive, row, width).map(move |column| fragment(primitive, column, row))
    })
}
