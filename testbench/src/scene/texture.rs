//! Textures: images with their mip levels, sampled with a filter.
//!
//! A sample mixes the four texels around a point on each of two neighbouring mip levels, whatever filter a file asks for.
//! The level is the binary logarithm of the most texels along an axis of the image that a step to the next pixel goes.

mod decode;

pub(super) use decode::Encoded;

use super::contents::least_and_most;
use super::srgb::{decoded_byte, encoded};
use glam::{Vec2, Vec4};

/// What lies beyond an image's edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wrap {
    /// The image again.
    Repeat,
    /// The image mirrored, then again.
    Mirror,
    /// The texel at the edge.
    Clamp,
}

impl Wrap {
    /// The texel of `0..count` at a position.
    fn texel(self, at: i64, count: u32) -> usize {
        let count = i64::from(count);
        let texel = match self {
            Wrap::Repeat => at.rem_euclid(count),
            Wrap::Mirror => {
                let at = at.rem_euclid(2 * count);
                at.min(2 * count - 1 - at)
            }
            Wrap::Clamp => at.clamp(0, count - 1),
        };
        texel as usize
    }
}

/// A texel: red, green, blue in sRGB, and alpha.
type Texel = [u8; 4];

/// Colour as light, 0..=1, and alpha.
fn light([r, g, b, a]: Texel) -> Vec4 {
    Vec4::new(decoded_byte(r), decoded_byte(g), decoded_byte(b), f32::from(a) / 255.0)
}

/// The channels as they are, 0..=1.
fn values(texel: Texel) -> Vec4 {
    Vec4::from(texel.map(f32::from)) / 255.0
}

/// An image of one size, rows from the top.
#[derive(Debug)]
struct Level {
    width: u32,
    height: u32,
    texels: Vec<Texel>,
}

/// An image and smaller ones of it, each half as wide and high, down to one texel.
#[derive(Debug)]
pub(super) struct Image(Vec<Level>);

impl Image {
    fn new(level: Level) -> Image {
        let mut levels = vec![level];
        while let Some(smaller) = levels.last().and_then(Level::halved) {
            levels.push(smaller);
        }
        Image(levels)
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.0[0].width, self.0[0].height]
    }

    /// The least and the most that its texels, all channels as they are, 0..=1, make of something.
    pub fn least_and_most(&self, of: impl Fn(Vec4) -> f32) -> [f32; 2] {
        let made = self.0[0].texels.iter().map(|texel| of(values(*texel)));
        least_and_most(made).unwrap_or_default()
    }

    /// Whether a texel is not opaque.
    pub fn has_alpha(&self) -> bool {
        self.0[0].texels.iter().any(|texel| texel[3] < 255)
    }

    /// Colour as light, mixed as light, and alpha at a point, all 0..=1. The image lies on the unit square, its first row at
    /// `y` = 0. `footprint` is how far the next pixel is along each axis.
    pub fn light(&self, point: Vec2, footprint: Vec2, wraps: [Wrap; 2]) -> Vec4 {
        self.sample(point, footprint, wraps, light)
    }

    /// All channels as they are, 0..=1, at a point.
    pub fn values(&self, point: Vec2, footprint: Vec2, wraps: [Wrap; 2]) -> Vec4 {
        self.sample(point, footprint, wraps, values)
    }

    fn sample(
        &self,
        point: Vec2,
        footprint: Vec2,
        wraps: [Wrap; 2],
        of: fn(Texel) -> Vec4,
    ) -> Vec4 {
        let Level { width, height, .. } = self.0[0];
        let texels = footprint * Vec2::new(width as f32, height as f32);
        let coarsest = (self.0.len() - 1) as f32;
        // A footprint without bound, as that of a triangle seen edge-on, takes the coarsest level.
        let level = texels.max_element().log2();
        let level = if level.is_nan() { coarsest } else { level.clamp(0.0, coarsest) };
        let finer = self.0[level as usize].sample(point, wraps, of);
        match level.fract() {
            0.0 => finer,
            part => mix(finer, self.0[level as usize + 1].sample(point, wraps, of), part),
        }
    }
}

/// Part of the way from one to the other; of equal ones, each of them exactly.
fn mix(from: Vec4, to: Vec4, part: f32) -> Vec4 {
    from + (to - from) * part
}

impl Level {
    /// The mean of every two by two texels; an odd last row or column is left out.
    fn halved(&self) -> Option<Level> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mean = |x: u32, y: u32| {
            let texel = |i: u32| {
                let (x, y) = (2 * x + i % 2, 2 * y + i / 2);
                light(self.texel(x.min(self.width - 1) as usize, y.min(self.height - 1) as usize))
            };
            let mean = (0..4).map(texel).sum::<Vec4>() / 4.0;
            let level = mean.truncate().to_array().map(encoded);
            [level[0], level[1], level[2], mean.w].map(|level| (255.0 * level).round() as u8)
        };
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Some(Level { width, height, texels: texels.map(|(x, y)| mean(x, y)).collect() })
    }

    fn texel(&self, x: usize, y: usize) -> Texel {
        self.texels[y * self.width as usize + x]
    }

    /// Mixes the four texels around a point.
    fn sample(&self, point: Vec2, wraps: [Wrap; 2], of: fn(Texel) -> Vec4) -> Vec4 {
        let place = point * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let first = place.floor();
        // What is so far away, or nowhere, that it lies between no two texels, is taken to lie on one.
        let part = place - first;
        let part = Vec2::select(part.is_nan_mask(), Vec2::ZERO, part);
        let (x, y) = (first.x as i64, first.y as i64);
        let columns = [x, x.saturating_add(1)].map(|x| wraps[0].texel(x, self.width));
        let rows = [y, y.saturating_add(1)].map(|y| wraps[1].texel(y, self.height));
        let row = |y| mix(of(self.texel(columns[0], y)), of(self.texel(columns[1], y)), part.x);
        mix(row(rows[0]), row(rows[1]), part.y)
    }
}

#[cfg(test)]
mod tests;
