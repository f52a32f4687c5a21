//! The points of a table for one node and one kind of ports: sizes by widths.

use crate::Price;

/// Sizes by widths, with a price for each pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Bits of a word, rising.
    pub widths: Vec<u32>,
    /// Bytes of a memory, rising.
    pub sizes: Vec<u64>,
    /// `[width][size]`.
    pub prices: Vec<Vec<Price>>,
}

/// Between which two points of a rising axis a value lies: the number of the lower one, and how far it is on its way to the
/// next one between logarithms, from 0 up to below 1. Beyond an end it is at that end.
fn between(axis: impl Iterator<Item = f64> + Clone, value: f64) -> (usize, f64) {
    let lower = axis.clone().take_while(|point| *point <= value).count().saturating_sub(1);
    let mut from = axis.skip(lower);
    match (from.next(), from.next()) {
        (Some(low), Some(high)) if value > low => (lower, (value / low).ln() / (high / low).ln()),
        _ => (lower, 0.0),
    }
}

impl Grid {
    /// Bytes of the largest memory.
    pub fn largest(&self) -> u64 {
        self.sizes.last().copied().unwrap_or_default()
    }

    /// Bits of the widest word.
    pub fn widest(&self) -> u32 {
        self.widths.last().copied().unwrap_or_default()
    }

    /// The price of a memory of so many bytes with words of so many bits.
    pub fn at(&self, bytes: f64, bits: f64) -> Price {
        let (size, along) = between(self.sizes.iter().map(|bytes| *bytes as f64), bytes);
        let (width, across) = between(self.widths.iter().map(|bits| f64::from(*bits)), bits);
        let blend = |low: Price, high: Option<Price>, part: f64| match high {
            // A point of the table is as it stands there.
            Some(high) if part > 0.0 => low.with(high, |low, high| low * (high / low).powf(part)),
            _ => low,
        };
        let of_width =
            |prices: &Vec<Price>| blend(prices[size], prices.get(size + 1).copied(), along);
        blend(of_width(&self.prices[width]), self.prices.get(width + 1).map(of_width), across)
    }
}
