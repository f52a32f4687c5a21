//! Triangles to fragments, exactly: every pixel centre inside a triangle once, on a shared edge once in all.
//!
//! Corners are rounded to 1/256 pixel, and from there on coverage is integer arithmetic: an edge function is the cross
//! product of the edge and the way to the pixel's centre. Inside the guard band a coordinate needs 24 bits with its sign and
//! an edge function 49, so `i64` holds it without rounding. A centre on an edge belongs to the triangle whose top or left edge
//! it is. What a pixel has of it is the work of `set_up`.

use super::Screen;
use super::clip::{GUARD, Vertex, clip, is_inside};
use super::order::Order;
use super::set_up::{SetUp, without_pixel};
use glam::{DVec4, Vec4};
use pellucid_machine::pixel::{Fragment, Z_FAR, rgba};
use pellucid_machine::primitive::Primitive;

/// Fraction bits of a screen coordinate.
const SUB_BITS: u32 = 8;
/// One pixel in screen coordinates.
pub(super) const PIXEL: i64 = 1 << SUB_BITS;

/// A corner on the screen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// Column in 1/256 pixel, from the left edge of the screen.
    pub x: i64,
    /// Row in 1/256 pixel, from the upper edge of the screen.
    pub y: i64,
    /// Depth, 0 near to 1 far.
    pub z: f64,
    /// 1 / w, above 0; of a mesh that is huge it is too small for an `f32`.
    pub inv_w: f64,
    /// Colour, 0..=255 per channel, divided by w.
    pub colour_over_w: DVec4,
}

/// Turns triangles in clip coordinates into the fragments of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raster {
    width: u32,
    height: u32,
    order: Order,
    sends_all: bool,
}

impl Raster {
    /// For a frame of this size; fragments come in this order.
    pub fn new(info: Screen, order: Order) -> Raster {
        Raster { width: info.width, height: info.height, order, sends_all: false }
    }

    /// The same that gives an engine triangles without a pixel too, whose vertices it then has to process.
    pub fn sending_all(self, sends_all: bool) -> Raster {
        Raster { sends_all, ..self }
    }

    /// Sends the fragments of one triangle, either side of it.
    pub fn draw<E>(
        &self,
        triangle: [Vertex; 3],
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        self.on_screen(triangle, &mut |triangle| match triangle {
            Ok(triangle) => triangle.draw(self.order, sink),
            Err(_) => Ok(()),
        })
    }

    /// Sends one triangle, either side of it, set up for an engine: as several where it had to be cut or its colours
    /// are no plane, as none where it has no pixel, unless all are sent. Their fragments, row by row, are those of [`Raster::draw`].
    pub fn set_up<E>(
        &self,
        triangle: [Vertex; 3],
        sink: &mut dyn FnMut(Primitive) -> Result<(), E>,
    ) -> Result<(), E> {
        self.on_screen(triangle, &mut |triangle| match triangle {
            Ok(triangle) => triangle.primitives().iter().try_for_each(|part| sink(*part)),
            Err(row) if self.sends_all => sink(without_pixel(row)),
            Err(_) => Ok(()),
        })
    }

    /// Cuts one triangle as far as it has to be, projects it and sets it up; of a part without a pixel it tells a row near it.
    fn on_screen<E>(
        &self,
        triangle: [Vertex; 3],
        each: &mut dyn FnMut(Result<SetUp, u32>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut each = |corners: [Corner; 3]| {
            let row = (corners[0].y / PIXEL).clamp(0, i64::from(self.height) - 1) as u32;
            each(SetUp::new(corners, self.width, self.height).ok_or(row))
        };
        if is_inside(&triangle) {
            return each(triangle.each_ref().map(|vertex| self.corner(vertex)));
        }
        let polygon = clip(triangle);
        let [first, rest @ ..] = polygon.corners() else {
            return Ok(());
        };
        let first = self.corner(first);
        for pair in rest.windows(2) {
            each([first, self.corner(&pair[0]), self.corner(&pair[1])])?;
        }
        Ok(())
    }

    fn corner(&self, vertex: &Vertex) -> Corner {
        let inv_w = 1.0 / vertex.clip.w;
        // Clamped because a cut through a triangle of astronomical size may miss the band by rounding.
        let screen = |ndc: f64, pixels: u32| {
            ((ndc.clamp(-GUARD, GUARD) + 1.0) / 2.0 * f64::from(pixels) * PIXEL as f64).round()
                as i64
        };
        Corner {
            x: screen(vertex.clip.x * inv_w, self.width),
            y: screen(-vertex.clip.y * inv_w, self.height),
            z: vertex.clip.z * inv_w,
            inv_w,
            colour_over_w: vertex.colour.as_dvec4() * inv_w,
        }
    }
}

/// A triangle that may have pixels.
pub(super) struct Placed {
    /// Its corners, clockwise on the screen.
    pub corners: [Corner; 3],
    /// Edge i lies opposite corner i, so that its function, over the area, is the weight of that corner.
    pub edges: [(Corner, Corner); 3],
    /// Twice its area, above 0.
    pub area: i64,
    /// Rows that it may have pixels in, at least one.
    pub rows: std::ops::Range<i64>,
}

impl Placed {
    /// The triangle of these corners, if it may have pixels.
    pub fn new([a, mut b, mut c]: [Corner; 3], width: u32, height: u32) -> Option<Placed> {
        let mut area = cross(a, b, c.x, c.y);
        if area < 0 {
            (b, c, area) = (c, b, -area);
        }
        let columns = covered([a.x, b.x, c.x], width);
        let rows = covered([a.y, b.y, c.y], height);
        let there = area > 0 && !columns.is_empty() && !rows.is_empty();
        let (corners, edges) = ([a, b, c], [(b, c), (c, a), (a, b)]);
        there.then_some(Placed { corners, edges, area, rows })
    }
}

/// Twice the signed area of `from`, `to` and the point: positive if they turn clockwise on the screen.
pub(super) fn cross(from: Corner, to: Corner, x: i64, y: i64) -> i64 {
    (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x)
}

/// Whether a clockwise triangle takes the points on this edge: it does on its left and top edges.
pub(super) fn owns_its_points(from: Corner, to: Corner) -> bool {
    to.y < from.y || (to.y == from.y && to.x > from.x)
}

/// Coordinate of a pixel's centre.
pub(super) fn centre(pixel: i64) -> i64 {
    pixel * PIXEL + PIXEL / 2
}

/// The pixels on the screen whose centres lie between the least and the greatest coordinate.
fn covered(corners: [i64; 3], pixels: u32) -> std::ops::Range<i64> {
    let [a, b, c] = corners;
    let first = (a.min(b).min(c) + PIXEL / 2 - 1) >> SUB_BITS;
    let last = (a.max(b).max(c) - PIXEL / 2) >> SUB_BITS;
    first.max(0)..(last + 1).min(i64::from(pixels))
}

/// A depth of 0 near to 1 far in 24 bits, below [`Z_FAR`] for all that the far plane does not cut away.
pub(super) fn depth(z: f64) -> u32 {
    ((z * f64::from(Z_FAR)).floor() as u32).min(Z_FAR - 1)
}

/// A colour of 0..=255 per channel, rounded to nearest.
pub(super) fn packed(colour: Vec4) -> u32 {
    let [r, g, b, a] = (colour + 0.5).to_array().map(|channel| channel as u8);
    rgba(r, g, b, a)
}

#[cfg(test)]
mod tests;
