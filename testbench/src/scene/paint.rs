//! Paint: what gives each fragment of a part its colour, where the colours of its corners do not tell it.
//!
//! Colours are multiplied as light and come out in sRGB, as all levels of a frame do. Where a pixel lies on a texture is
//! interpolated with perspective over the triangle as it was before it was cut or rounded to the screen: over a plane, what
//! is linear in space, divided by w, is linear on the screen.

use super::clip::Vertex;
use super::contents::least_and_most;
use super::raster::packed;
use super::srgb::encoded;
use super::texture::{Image, Wrap};
use glam::{DMat3, DVec3, Vec2, Vec3, Vec4, Vec4Swizzles};
use pellucid_machine::pixel::{Fragment, Screen};
use std::ops::{Add, Mul, Sub};
use std::sync::Arc;

/// Bytes that a vertex takes beside those of its part.
pub(super) const PAINT_BYTES: usize = size_of::<[Vec4; 2]>();

/// An image and how it goes on beyond its edges.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    /// The image.
    pub image: Arc<Image>,
    /// Beyond its left and right edge, and beyond its upper and lower one.
    pub wraps: [Wrap; 2],
}

/// What multiplies alpha: a number, plus an image's channels as they are, 0..=1, times their weights.
#[derive(Clone, Debug)]
pub(super) struct Veil {
    /// The number, 0..=1.
    pub plain: f32,
    /// The image and the weights.
    pub image: Option<(Texture, Vec4)>,
}

/// What gives the fragments of a part their colour and opacity.
#[derive(Clone, Debug, Default)]
pub(super) struct Paint {
    /// Colour of each vertex as light, and its alpha, all 0..=1.
    pub colours: Vec<Vec4>,
    /// Where each vertex lies on the images: the first two on that of `colour`, the last two on that of `veil`.
    pub places: Vec<Vec4>,
    /// Multiplies colour and alpha.
    pub colour: Option<Texture>,
    /// Alpha, 0..=1, below which a fragment is discarded.
    pub cutoff: Option<f32>,
    /// Whether all fragments that are left are opaque, but for the veil.
    pub is_solid: bool,
    /// Multiplies alpha of what is left.
    pub veil: Option<Veil>,
    /// Alpha, 0..=1, of what is left instead of all that, if a rule states it.
    pub alpha: Option<f32>,
}

impl Paint {
    /// The least and the most alpha, 0..=1, that fragments can have.
    pub fn opacity(&self) -> [f32; 2] {
        if let Some(alpha) = self.alpha {
            return [alpha; 2];
        }
        let mut alpha = [1.0; 2];
        if !self.is_solid {
            alpha = least_and_most(self.colours.iter().map(|colour| colour.w)).unwrap_or(alpha);
            let texture = self
                .colour
                .as_ref()
                .map_or([1.0; 2], |texture| texture.image.least_and_most(|texel| texel.w));
            alpha = [alpha[0] * texture[0], alpha[1] * texture[1]];
        }
        let veil = self.veil.as_ref().map_or([1.0; 2], Veil::least_and_most);
        [alpha[0] * veil[0], alpha[1] * veil[1]]
    }

    /// Paints the fragments of a triangle and passes on those that are not discarded. `corners` are the numbers of its
    /// `vertices` here; the colour of these multiplies the sRGB levels.
    pub fn paint<'a, E>(
        &'a self,
        corners: [usize; 3],
        vertices: &[Vertex; 3],
        screen: Screen,
        sink: &'a mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> impl FnMut(Fragment) -> Result<(), E> + 'a {
        let colours = corners.map(|i| self.colours[i]);
        let places = corners.map(|i| self.places[i]);
        let light = vertices.each_ref().map(|vertex| vertex.colour.truncate());
        let plane = Plane::new(vertices, screen);
        move |fragment| {
            let at = plane.at(fragment.x, fragment.y);
            let [right, below] = [at.right, at.below].map(|step| gained(places, step).abs());
            let place = (mix(places, at.weights), right.max(below));
            let Some(colour) = self.colour(mix(colours, at.weights), place) else {
                return Ok(());
            };
            let level = Vec3::from(colour.truncate().to_array().map(encoded));
            let level = (level * mix(light, at.weights)).min(Vec3::ONE);
            sink(Fragment { rgba: packed(255.0 * level.extend(colour.w)), ..fragment })
        }
    }

    /// Colour as light and alpha of a fragment that is `base` without textures; nothing if it is discarded.
    fn colour(&self, base: Vec4, (place, footprint): (Vec4, Vec4)) -> Option<Vec4> {
        let mut colour = base;
        if let Some(Texture { image, wraps }) = &self.colour {
            colour *= image.light(place.xy(), footprint.xy(), *wraps);
        }
        if self.cutoff.is_some_and(|cutoff| colour.w < cutoff) {
            return None;
        }
        if self.is_solid {
            colour.w = 1.0;
        }
        if let Some(veil) = &self.veil {
            colour.w *= veil.at(place.zw(), footprint.zw());
        }
        colour.w = self.alpha.unwrap_or(colour.w);
        Some(colour)
    }
}

impl Veil {
    /// The least and the most of it anywhere.
    fn least_and_most(&self) -> [f32; 2] {
        let image = self.image.as_ref().map_or([0.0; 2], |(Texture { image, .. }, weights)| {
            image.least_and_most(|texel| texel.dot(*weights))
        });
        image.map(|image| (self.plain + image).clamp(0.0, 1.0))
    }

    fn at(&self, place: Vec2, footprint: Vec2) -> f32 {
        let image = self.image.as_ref().map_or(0.0, |(Texture { image, wraps }, weights)| {
            image.values(place, footprint, *wraps).dot(*weights)
        });
        (self.plain + image).clamp(0.0, 1.0)
    }
}

/// How a triangle lies under the pixels.
struct Plane {
    /// Weight of each corner, over w, at a pixel: a row of the matrix times (column, row, 1).
    weights: DMat3,
}

/// Where a pixel lies in its triangle.
struct Place {
    /// Weights of the corners, 0..=1 and 1 in all.
    weights: [f32; 3],
    /// What they gain to the next pixel on the right.
    right: [f32; 3],
    /// What they gain to the next pixel below.
    below: [f32; 3],
}

impl Plane {
    fn new(vertices: &[Vertex; 3], screen: Screen) -> Plane {
        let (width, height) = (f64::from(screen.width), f64::from(screen.height));
        // Column and row of a pixel's centre are whole numbers here.
        let corner = |vertex: &Vertex| {
            let clip = vertex.clip;
            let x = (clip.x + clip.w) / 2.0 * width - 0.5 * clip.w;
            let y = (clip.w - clip.y) / 2.0 * height - 0.5 * clip.w;
            DVec3::new(x, y, clip.w)
        };
        let [a, b, c] = vertices.each_ref().map(corner);
        Plane { weights: DMat3::from_cols(a, b, c).inverse() }
    }

    fn at(&self, x: u32, y: u32) -> Place {
        let weights = self.weights * DVec3::new(x.into(), y.into(), 1.0);
        // A pixel that rounding has moved out of the triangle stays on its edge; one of a triangle without area, at a corner.
        let inside = weights.max(DVec3::ZERO);
        let sum = inside.element_sum();
        let inside = if sum > 0.0 && sum.is_finite() { inside / sum } else { DVec3::X };
        let total = weights.element_sum();
        let gain = |axis: DVec3| {
            ((axis - inside * axis.element_sum()) / total).to_array().map(|gain| gain as f32)
        };
        Place {
            weights: inside.to_array().map(|weight| weight as f32),
            right: gain(self.weights.x_axis),
            below: gain(self.weights.y_axis),
        }
    }
}

/// What the mean of three gains as their weights gain so much. It is nothing at all where they are equal.
fn gained<T>([a, b, c]: [T; 3], [_, of_b, of_c]: [f32; 3]) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    (b - a) * of_b + (c - a) * of_c
}

/// The weighted mean of three; of equal ones, each of them exactly.
fn mix<T>(values: [T; 3], weights: [f32; 3]) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    values[0] + gained(values, weights)
}

#[cfg(test)]
mod tests;
