//! Orders worked by hand, and any shape's against a sort by where the order says that a pixel comes.

use super::*;
use proptest::prelude::*;
use std::convert::Infallible;

/// The pixels of a shape, column and row, in an order.
fn pixels(order: Order, first: u32, rows: &[Range<u32>]) -> Vec<(u32, u32)> {
    let mut pixels = vec![];
    let columns = |row: u32| rows[(row - first) as usize].clone();
    let mut each = |row: u32, columns: Range<u32>| -> Result<(), Infallible> {
        assert!(!columns.is_empty());
        pixels.extend(columns.map(|column| (column, row)));
        Ok(())
    };
    let Ok(()) = order.runs(first..first + rows.len() as u32, columns, &mut each);
    pixels
}

/// The upper left half of a square of 4x4 pixels at column 6 and row 1.
#[test]
fn orders_of_a_triangle_by_hand() {
    let triangle = |order| pixels(order, 1, &[6..10, 6..9, 6..8, 6..7]);
    assert_eq!(
        triangle(Order::ScanLine),
        [(6, 1), (7, 1), (8, 1), (9, 1), (6, 2), (7, 2), (8, 2), (6, 3), (7, 3), (6, 4)]
    );
    // Tiles part at column 8.
    assert_eq!(
        triangle(Order::Tile8x8),
        [(6, 1), (7, 1), (6, 2), (7, 2), (6, 3), (7, 3), (6, 4), (8, 1), (9, 1), (8, 2)]
    );
    // Quads of rows 0 and 1, of 2 and 3, of 4 and 5.
    assert_eq!(
        triangle(Order::Quad),
        [(6, 1), (7, 1), (8, 1), (9, 1), (6, 2), (7, 2), (6, 3), (7, 3), (8, 2), (6, 4)]
    );
    // The square of 8x8 pixels to the left of column 8 in whole, then what is to the right of it.
    assert_eq!(
        triangle(Order::Morton),
        [(6, 1), (7, 1), (6, 2), (7, 2), (6, 3), (7, 3), (6, 4), (8, 1), (9, 1), (8, 2)]
    );
}

/// A square of 4x4 pixels in which tiles and the curve differ.
#[test]
fn the_curve_is_a_z_of_zs() {
    let curve = pixels(Order::Morton, 4, &[8..12, 8..12, 8..12, 8..12]);
    let upper = [(8, 4), (9, 4), (8, 5), (9, 5), (10, 4), (11, 4), (10, 5), (11, 5)];
    let lower = upper.map(|(x, y)| (x, y + 2));
    assert_eq!(curve, [upper, lower].concat());
}

#[test]
fn orders_have_names() {
    for order in Order::ALL {
        assert_eq!(order.to_string().parse(), Ok(order));
    }
    assert_eq!(
        "Morton".parse::<Order>().unwrap_err().to_string(),
        "`Morton` is not an order: expected scan-line, tile-8x8, morton or quad"
    );
}

#[test]
fn a_receiver_that_has_enough_stops_every_order() {
    for order in Order::ALL {
        let mut left = 3;
        let mut each = |_, _| {
            left -= 1;
            if left == 0 { Err("enough") } else { Ok(()) }
        };
        assert_eq!(order.runs(3..40, |_| 5..50, &mut each), Err("enough"), "{order}");
        assert_eq!(left, 0);
    }
}

/// Where a pixel comes: the bits of row and column by turns.
fn on_curve((x, y): (u32, u32)) -> u64 {
    (0..32)
        .map(|bit| u64::from(x >> bit & 1) << (2 * bit) | u64::from(y >> bit & 1) << (2 * bit + 1))
        .sum()
}

proptest! {
    #[test]
    fn every_order_is_the_rows_sorted(
        first in 0u32..40,
        rows in prop::collection::vec((0u32..60, 0u32..30).prop_map(|(start, columns)| start..start + columns), 0..30),
    ) {
        let by_rows = pixels(Order::ScanLine, first, &rows);
        let mut sorted = by_rows.clone();
        prop_assert!(by_rows.is_sorted_by_key(|&(x, y)| (y, x)));
        prop_assert_eq!(by_rows.len(), rows.iter().map(|columns| columns.len()).sum::<usize>());
        for (order, side) in [(Order::Tile8x8, 8), (Order::Quad, 2)] {
            sorted.sort_by_key(|&(x, y)| (y / side, x / side, y, x));
            prop_assert_eq!(&pixels(order, first, &rows), &sorted, "{}", order);
        }
        sorted.sort_by_key(|pixel| on_curve(*pixel));
        prop_assert_eq!(pixels(Order::Morton, first, &rows), sorted);
    }
}
