//! In which order a rasteriser goes through the pixels of a triangle, a splat or a particle.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// An order of the pixels of a shape. Tiles, quads and squares lie at multiples of their side from the upper left of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Row by row, from left to right.
    #[default]
    ScanLine,
    /// Tiles of 8x8 pixels row by row, and within a tile its pixels row by row.
    Tile8x8,
    /// Along the Z-order curve: of each square of 2^n pixels a side its upper left quarter, the upper right, the lower left and
    /// the lower right one.
    Morton,
    /// Quads of 2x2 pixels row by row, and within a quad its pixels row by row.
    Quad,
}

impl Order {
    /// All of them.
    pub const ALL: [Order; 4] = [Order::ScanLine, Order::Tile8x8, Order::Morton, Order::Quad];

    fn name(self) -> &'static str {
        match self {
            Order::ScanLine => "scan-line",
            Order::Tile8x8 => "tile-8x8",
            Order::Morton => "morton",
            Order::Quad => "quad",
        }
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no order.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
#[error("`{0}` is not an order: expected scan-line, tile-8x8, morton or quad")]
pub struct OrderError(String);

impl FromStr for Order {
    type Err = OrderError;

    fn from_str(text: &str) -> Result<Order, OrderError> {
        let order = Order::ALL.into_iter().find(|order| order.name() == text);
        order.ok_or_else(|| OrderError(text.into()))
    }
}

impl Order {
    /// Sends the pixels of a shape in this order, in runs of a row: the row, and columns of it, at least one. `columns`
    /// tells which columns the shape has in one of its `rows`.
    pub(super) fn runs<E>(
        self,
        mut rows: Range<u32>,
        columns: impl Fn(u32) -> Range<u32>,
        each: &mut dyn FnMut(u32, Range<u32>) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Order::ScanLine => rows.try_for_each(|row| match columns(row) {
                columns if columns.is_empty() => Ok(()),
                columns => each(row, columns),
            }),
            Order::Tile8x8 => Shape::new(rows, columns).by_squares(8, each),
            Order::Quad => Shape::new(rows, columns).by_squares(2, each),
            Order::Morton => Shape::new(rows, columns).along_z(each),
        }
    }
}

/// The columns of a shape, row by row.
struct Shape {
    /// The row of the first.
    first: u32,
    rows: Vec<Range<u32>>,
}

impl Shape {
    fn new(rows: Range<u32>, columns: impl Fn(u32) -> Range<u32>) -> Shape {
        Shape { first: rows.start, rows: rows.map(columns).collect() }
    }

    /// Its part of a square: each of its rows there with the columns there, where there are any.
    fn part(&self, (left, top): (u32, u32), side: u32) -> impl Iterator<Item = (u32, Range<u32>)> {
        let end = self.first + self.rows.len() as u32;
        let part = (top.max(self.first)..end.min(top + side)).map(move |row| {
            let Range { start, end } = self.rows[(row - self.first) as usize];
            (row, start.max(left)..end.min(left + side))
        });
        part.filter(|(_, columns)| !columns.is_empty())
    }

    /// The columns from its first to its last in rows from `top` on.
    fn columns(&self, top: u32, rows: u32) -> Range<u32> {
        let end = self.first + self.rows.len() as u32;
        let rows = top.max(self.first)..end.min(top + rows);
        let rows = rows.map(|row| self.rows[(row - self.first) as usize].clone());
        let rows = rows.filter(|columns| !columns.is_empty());
        rows.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or_default()
    }

    /// Squares row by row, and so the pixels of each.
    fn by_squares<E>(
        &self,
        side: u32,
        each: &mut dyn FnMut(u32, Range<u32>) -> Result<(), E>,
    ) -> Result<(), E> {
        let end = self.first + self.rows.len() as u32;
        for top in (self.first / side * side..end).step_by(side as usize) {
            let columns = self.columns(top, side);
            for left in (columns.start / side * side..columns.end).step_by(side as usize) {
                let mut part = self.part((left, top), side);
                part.try_for_each(|(row, columns)| each(row, columns))?;
            }
        }
        Ok(())
    }

    /// The Z-order curve through the least square of the curve that it lies in.
    fn along_z<E>(&self, each: &mut dyn FnMut(u32, Range<u32>) -> Result<(), E>) -> Result<(), E> {
        let rows = self.rows.len() as u32;
        let columns = self.columns(self.first, rows);
        if columns.is_empty() {
            return Ok(());
        }
        let (right, bottom) = (columns.end - 1, self.first + rows - 1);
        let differ = (columns.start ^ right) | (self.first ^ bottom);
        let bits = u32::BITS - differ.leading_zeros();
        self.square((columns.start >> bits << bits, self.first >> bits << bits), 1 << bits, each)
    }

    /// A square of the Z-order curve.
    fn square<E>(
        &self,
        (left, top): (u32, u32),
        side: u32,
        each: &mut dyn FnMut(u32, Range<u32>) -> Result<(), E>,
    ) -> Result<(), E> {
        let Some((row, columns)) = self.part((left, top), side).next() else { return Ok(()) };
        if side == 1 {
            return each(row, columns);
        }
        let half = side / 2;
        for (right, down) in [(0, 0), (half, 0), (0, half), (half, half)] {
            self.square((left + right, top + down), half, each)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
