//! Triangles as an engine takes them: set up, so that adders alone walk them row by row.
//!
//! Which pixels a row has is exact. An edge is a function that is linear in column and row, and a pixel
//! is inside where all three are at least 0. In a given row, an edge is thus a bound for the columns:
//! `floor(N / |a|)`, where N is linear in the row. An [`Edge`] keeps that quotient with its remainder, and
//! from row to row both are added to, with a carry, as Bresenham did for lines.
//!
//! Depth and colour are linear on the screen, in fixed point. A sum wraps: what it is far from the triangle
//! does not matter.

use crate::pixel::{Screen, Z_BITS, Z_FAR};
use pellucid_sim::{Label, Signals, rtl};

/// Bits behind the point of depth and colour on their way over a triangle.
pub const FRACTION_BITS: u32 = 16;
/// Bits of a depth on its way: its sign, one to spare, and [`Z_BITS`] before the point.
pub const Z_PLANE_BITS: u32 = Z_BITS + FRACTION_BITS + 2;
/// Bits of a colour's channel on its way: its sign, one to spare, and 8 before the point.
pub const CHANNEL_PLANE_BITS: u32 = 8 + FRACTION_BITS + 2;
/// Bits of an edge's bound, its sign included: an edge that is nearly level leaves the screen by far.
pub const BOUND_BITS: u32 = 44;
/// Bits of the divisor of an edge: its height in 1/256 pixel.
pub const HEIGHT_BITS: u32 = 25;
const BOUND_RANGE: u64 = 1 << BOUND_BITS;
const Z_MASK: u64 = (1 << Z_PLANE_BITS) - 1;
const CHANNEL_MASK: u32 = (1 << CHANNEL_PLANE_BITS) - 1;
/// The most alpha of a primitive that is not opaque.
pub const MOST_TRANSPARENT: u32 = 254;

/// What an edge bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Side {
    /// Nothing: it is level, and the rows are chosen with regard to it.
    #[default]
    Level,
    /// Columns from minus the bound on.
    Left,
    /// Columns up to the bound.
    Right,
}

/// An edge in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Edge {
    /// What it bounds.
    pub side: Side,
    /// The bound in this row, two's complement.
    #[width(BOUND_BITS)]
    pub bound: u64,
    /// What the bound gains from row to row, two's complement.
    #[width(BOUND_BITS)]
    pub bound_step: u64,
    /// The remainder of the bound, below `height`.
    #[width(HEIGHT_BITS)]
    pub rest: u32,
    /// What the remainder gains from row to row, below `height`.
    #[width(HEIGHT_BITS)]
    pub rest_step: u32,
    /// The divisor, at least 1 unless the edge is level.
    #[width(HEIGHT_BITS)]
    pub height: u32,
}

/// What a triangle has in a pixel, or gains from one to the next: in fixed point, two's complement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Attributes {
    /// Depth.
    #[width(Z_PLANE_BITS)]
    pub z: u64,
    /// Red.
    #[width(CHANNEL_PLANE_BITS)]
    pub red: u32,
    /// Green.
    #[width(CHANNEL_PLANE_BITS)]
    pub green: u32,
    /// Blue.
    #[width(CHANNEL_PLANE_BITS)]
    pub blue: u32,
    /// Alpha.
    #[width(CHANNEL_PLANE_BITS)]
    pub alpha: u32,
}

/// What hardware has of a primitive, and on which screen.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// The screen.
    pub screen: Screen,
    /// Whether it is opaque.
    pub opaque: bool,
    /// How many pixels it has.
    pub area: bool,
}

impl Format {
    /// Everything.
    pub fn whole(screen: Screen) -> Format {
        Format { screen, opaque: true, area: true }
    }
    /// What it takes to draw it.
    pub fn drawn(screen: Screen) -> Format {
        Format { area: false, ..Format::whole(screen) }
    }
    /// What it takes to draw one that is known to be transparent.
    pub fn transparent(screen: Screen) -> Format {
        Format { opaque: false, ..Format::drawn(screen) }
    }
}

/// A triangle, from one of its rows on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Format)]
pub struct Primitive {
    /// The row.
    #[width(cfg.screen.y_bits())]
    pub row: u32,
    /// Its last row, not before `row`.
    #[width(cfg.screen.y_bits())]
    pub last_row: u32,
    /// Its edges in the row.
    pub edges: [Edge; 3],
    /// What it has in column 0 of the row.
    pub at: Attributes,
    /// What that gains with each column.
    pub per_column: Attributes,
    /// What that gains with each row.
    pub per_row: Attributes,
    /// All of it hides what lies behind it.
    #[exists(cfg.opaque)]
    pub opaque: bool,
    /// How many pixels it has, about.
    #[width(cfg.screen.pixel_bits())]
    #[exists(cfg.area)]
    pub area: u32,
    /// Which primitive it is, in waveforms.
    pub label: Label,
}

/// The columns of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Span {
    /// There are none.
    pub empty: bool,
    /// The first one.
    #[width(cfg.x_bits())]
    pub first: u32,
    /// The last one.
    #[width(cfg.x_bits())]
    pub last: u32,
}

/// The columns of a primitive in its row.
#[inline(always)]
#[rtl]
pub fn span(edges: [Edge; 3], width: u32) -> Span {
    let (mut first, mut last) = (0, u64::from(width - 1));
    let mut empty = false;
    for edge in edges {
        let negative = edge.bound >> (BOUND_BITS - 1) == 1;
        match edge.side {
            Side::Level => {}
            Side::Left => {
                if negative {
                    let bound = BOUND_RANGE - edge.bound;
                    first = if bound > first { bound } else { first };
                }
            }
            Side::Right => {
                if negative {
                    empty = true;
                } else {
                    last = if edge.bound < last { edge.bound } else { last };
                }
            }
        }
    }
    if empty || first > last {
        Span { empty: true, first: 0, last: 0 }
    } else {
        Span { empty: false, first: first as u32, last: last as u32 }
    }
}

/// An edge in the next row.
#[inline(always)]
#[rtl]
pub fn below(edge: Edge) -> Edge {
    let mut below = edge;
    let rest = edge.rest + edge.rest_step;
    let carry = rest >= edge.height && edge.height > 0;
    below.rest = if carry { rest - edge.height } else { rest };
    below.bound = (edge.bound + edge.bound_step + u64::from(carry)) & (BOUND_RANGE - 1);
    below
}

/// A primitive with what it has in the row below: its rows are as they were.
#[inline(always)]
#[rtl]
pub fn moved_down(primitive: Primitive) -> Primitive {
    let mut next = primitive;
    let [a, b, c] = primitive.edges;
    next.edges = [below(a), below(b), below(c)];
    next.at = plus(primitive.at, primitive.per_row);
    next
}

/// A primitive from its next row on, if it has one.
#[inline(always)]
#[rtl]
pub fn next_row(primitive: Primitive) -> Primitive {
    let mut next = moved_down(primitive);
    if primitive.row < primitive.last_row {
        next.row = primitive.row + 1;
    }
    next
}

/// A sum, channel by channel.
#[inline(always)]
#[rtl]
pub fn plus(a: Attributes, b: Attributes) -> Attributes {
    Attributes {
        z: (a.z + b.z) & Z_MASK,
        red: (a.red + b.red) & CHANNEL_MASK,
        green: (a.green + b.green) & CHANNEL_MASK,
        blue: (a.blue + b.blue) & CHANNEL_MASK,
        alpha: (a.alpha + b.alpha) & CHANNEL_MASK,
    }
}

/// A channel times a column.
#[inline(always)]
#[rtl]
fn channel_times(channel: u32, column: u32) -> u32 {
    (u64::from(channel) * u64::from(column)) as u32 & CHANNEL_MASK
}

/// What is gained over so many columns.
#[inline(always)]
#[rtl]
pub fn times(a: Attributes, column: u32) -> Attributes {
    Attributes {
        z: (a.z * u64::from(column)) & Z_MASK,
        red: channel_times(a.red, column),
        green: channel_times(a.green, column),
        blue: channel_times(a.blue, column),
        alpha: channel_times(a.alpha, column),
    }
}

/// What is before the point, or the nearest of 0..=`most`.
#[inline(always)]
#[rtl]
fn channel(value: u32, most: u32) -> u32 {
    let negative = value >> (CHANNEL_PLANE_BITS - 1) == 1;
    if negative { 0 } else { (value >> FRACTION_BITS).min(most) }
}

/// A pixel's depth: 0 to [`Z_FAR`].
#[inline(always)]
#[rtl]
pub fn depth(at: Attributes) -> u32 {
    let negative = at.z >> (Z_PLANE_BITS - 1) == 1;
    let z = if negative { 0 } else { at.z >> FRACTION_BITS };
    (z as u32).min(Z_FAR)
}

/// A pixel's colour, `0xRRGGBBAA`.
#[inline(always)]
#[rtl]
pub fn colour(at: Attributes, opaque: bool) -> u32 {
    let alpha = if opaque { 255 } else { channel(at.alpha, MOST_TRANSPARENT) };
    channel(at.red, 255) << 24 | channel(at.green, 255) << 16 | channel(at.blue, 255) << 8 | alpha
}

/// Pixels of a primitive on a screen of this width, counted row by row.
pub fn pixels(primitive: &Primitive, width: u32) -> u64 {
    let mut at = *primitive;
    let mut pixels = 0;
    for _ in primitive.row..=primitive.last_row {
        let Span { empty, first, last } = span(at.edges, width);
        pixels += if empty { 0 } else { u64::from(last - first) + 1 };
        at = next_row(at);
    }
    pixels
}
