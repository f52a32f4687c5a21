//! The golden model: what the exact image of a frame is, in plain software.
//!
//! It shares no line with the hardware, on purpose: a mistake in a common function would hide itself.
//! The rules are these, per pixel.
//!
//! 1. The depth buffer starts at the far plane. An opaque fragment is visible if its depth is less than
//!    what the depth buffer holds, so the first arrival wins a tie.
//! 2. A transparent fragment counts if its depth is less than the *final* opaque depth, whatever came first.
//! 3. Those that count are blended far to near; at equal depth the earlier arrival is blended first.
//! 4. A blend is `c' = (a*s + (255-a)*c) / 255` per channel, rounded to nearest at each step.
//!
//! A machine may make its colours by another arithmetic than this blend. For such a one the golden model
//! gives a second image, by that arithmetic, and says how far it may be from the first: see [`weights`].
//!
//! Memory: 12 bytes per pixel, and 12 bytes per transparent fragment that lies in front of the opaque
//! depth at its arrival (one that does not can never come to count, since that depth only decreases).

pub mod primitive;
pub mod weights;

use crate::image::Image;
use pellucid_hw::machine::{Arithmetic, Census};
use pellucid_hw::pixel::{Fragment, Screen, Z_FAR};

/// No record: the end of a pixel's chain. It bounds the records, whose indices are below it.
const NONE: u32 = u32::MAX;

/// Records per block of the store. Blocks never move, so growing copies nothing.
const BLOCK: usize = 1 << 16;

/// Pixels whose chains are followed side by side: one chain alone would wait for memory at every step.
const GROUP: usize = 32;

/// A fragment that the golden model cannot take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GoldenError {
    /// The fragment lies outside the frame or beyond the far plane.
    #[error(
        "fragment {number} at x={} y={} z={} is outside the frame of {width}x{height} pixels and 24 bits of depth",
        fragment.x, fragment.y, fragment.z
    )]
    Outside {
        /// The fragment's number in arrival order, from 1.
        number: u64,
        /// The fragment.
        fragment: Fragment,
        /// Width of the frame in pixels.
        width: u32,
        /// Height of the frame in pixels.
        height: u32,
    },
    /// The frame has more transparent fragments than indices.
    #[error("fragment {number} does not fit: the golden model holds {limit} transparent fragments")]
    TooMany {
        /// The fragment's number in arrival order, from 1.
        number: u64,
        /// How many transparent fragments fit.
        limit: u32,
    },
}

/// A transparent fragment that may come to count.
#[derive(Clone, Copy)]
struct Record {
    /// Index of the pixel's record before this one, or [`NONE`].
    previous: u32,
    z: u32,
    rgba: u32,
}

/// A record that counts.
#[derive(Clone, Copy, Debug)]
struct Layer {
    /// Number of the pixel in its group.
    pixel: u32,
    z: u32,
    rgba: u32,
}

/// One pixel while fragments arrive.
#[derive(Clone, Copy)]
struct Pixel {
    /// Depth of the nearest opaque fragment so far.
    z: u32,
    /// Its colour, `0xRRGGBB`.
    colour: u32,
    /// Index of the latest record, or [`NONE`].
    latest: u32,
}

/// The golden model of one frame: takes fragments in arrival order, then gives the [`Reference`].
pub struct Golden {
    info: Screen,
    /// Whether the image by weights is wanted too.
    weighted: bool,
    pixels: Vec<Pixel>,
    blocks: Vec<Vec<Record>>,
    /// Records in `blocks`.
    stored: u32,
    limit: u32,
    fragments: u64,
    opaque: u64,
}

/// The exact image of a frame, and what every architecture must count.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reference {
    /// The image by the exact blend.
    pub image: Image,
    /// The image by [`Arithmetic::Weights`], if the golden model was made [`Golden::with`] it.
    pub weighted: Option<Image>,
    /// Fragments that arrived.
    pub fragments: u64,
    /// Of these, with alpha 255.
    pub opaque: u64,
    /// Of these, with alpha below 255.
    pub transparent: u64,
    /// Transparent fragments not in front of the final opaque depth.
    pub culled: u64,
    /// Transparent fragments in front of it, each counted once. `culled + blended = transparent`.
    pub blended: u64,
    /// Pixels with at least one blended fragment.
    pub transparent_pixels: u64,
    /// Most blended fragments in one pixel.
    pub max_layers: u32,
    /// Blended fragments of each pixel; that of `x, y` is at `y * width + x`.
    pub layers: Vec<u32>,
    /// `[i]` is the number of pixels with exactly `i` blended fragments, `i` from 0 to `max_layers`.
    pub layer_histogram: Vec<u64>,
    /// Transparent fragments in front of the opaque depth at their arrival: what an early depth test lets
    /// through, hence what an architecture with one has to store. At least `blended`.
    pub stored: u64,
    /// Pixels with at least one stored fragment.
    pub stored_pixels: u64,
    /// `[i]` is the number of pixels with exactly `i` stored fragments, `i` from 0 to the most in one pixel.
    pub stored_histogram: Vec<u64>,
}

impl Reference {
    /// Several frames of one size as if they were one, each below the one before.
    pub fn stacked<'a>(frames: impl IntoIterator<Item = &'a Reference> + Clone) -> Reference {
        let images = frames.clone().into_iter().map(|frame| &frame.image);
        let weighted: Option<Vec<&Image>> =
            frames.clone().into_iter().map(|frame| frame.weighted.as_ref()).collect();
        let mut all = Reference {
            image: Image::stacked(images),
            weighted: weighted.map(Image::stacked),
            ..Reference::default()
        };
        for frame in frames {
            all.fragments += frame.fragments;
            all.opaque += frame.opaque;
            all.transparent += frame.transparent;
            all.culled += frame.culled;
            all.blended += frame.blended;
            all.transparent_pixels += frame.transparent_pixels;
            all.max_layers = all.max_layers.max(frame.max_layers);
            all.layers.extend(&frame.layers);
            add(&mut all.layer_histogram, &frame.layer_histogram);
            all.stored += frame.stored;
            all.stored_pixels += frame.stored_pixels;
            add(&mut all.stored_histogram, &frame.stored_histogram);
        }
        all
    }

    /// What a machine cannot change about the frame.
    pub fn census(&self) -> Census {
        Census { stored: self.stored, histogram: self.stored_histogram.clone() }
    }

    /// The image that a machine of that arithmetic must give, bit for bit.
    ///
    /// # Panics
    /// The golden model was made without that arithmetic.
    pub fn image_by(&self, arithmetic: Arithmetic) -> &Image {
        match (arithmetic, &self.weighted) {
            (Arithmetic::Blend, _) => &self.image,
            (Arithmetic::Weights, Some(image)) => image,
            (Arithmetic::Weights, None) => panic!("the golden model was made without weights"),
        }
    }
}

/// How far a channel of a pixel with `layers` blended fragments may be from the exact blend, in levels.
pub fn error_bound(arithmetic: Arithmetic, layers: u32) -> u32 {
    match arithmetic {
        Arithmetic::Blend => 0,
        Arithmetic::Weights => weights::error_bound(layers),
    }
}

impl Golden {
    /// An empty frame, of which the exact image is wanted.
    pub fn new(info: Screen) -> Golden {
        let clear = Pixel { z: Z_FAR, colour: info.background, latest: NONE };
        Golden {
            info,
            weighted: false,
            pixels: vec![clear; info.width as usize * info.height as usize],
            blocks: Vec::new(),
            stored: 0,
            limit: NONE,
            fragments: 0,
            opaque: 0,
        }
    }

    /// The same, with the image by `arithmetic` beside the exact one.
    #[must_use]
    pub fn with(self, arithmetic: Arithmetic) -> Golden {
        Golden { weighted: self.weighted || arithmetic == Arithmetic::Weights, ..self }
    }

    /// Takes the next fragment in arrival order.
    ///
    /// # Errors
    /// The fragment is outside the frame, or there are more than 2^32-1 to store.
    pub fn push(&mut self, fragment: Fragment) -> Result<(), GoldenError> {
        let Screen { width, height, .. } = self.info;
        let number = self.fragments + 1;
        if fragment.x >= width || fragment.y >= height || fragment.z > Z_FAR {
            return Err(GoldenError::Outside { number, fragment, width, height });
        }
        let pixel = &mut self.pixels[fragment.y as usize * width as usize + fragment.x as usize];
        if fragment.rgba & 0xff == 255 {
            self.opaque += 1;
            if fragment.z < pixel.z {
                pixel.z = fragment.z;
                pixel.colour = fragment.rgba >> 8;
            }
        } else if fragment.z < pixel.z {
            if self.stored == self.limit {
                let limit = self.limit;
                return Err(GoldenError::TooMany { number, limit });
            }
            let record = Record { previous: pixel.latest, z: fragment.z, rgba: fragment.rgba };
            pixel.latest = self.stored;
            self.stored += 1;
            match self.blocks.last_mut() {
                Some(block) if block.len() < BLOCK => block.push(record),
                _ => {
                    let mut block = Vec::with_capacity(BLOCK);
                    block.push(record);
                    self.blocks.push(block);
                }
            }
        }
        self.fragments = number;
        Ok(())
    }

    /// Blends every pixel and counts.
    pub fn finish(self) -> Reference {
        let mut colours = Vec::with_capacity(self.pixels.len());
        let mut weighted = Vec::with_capacity(if self.weighted { self.pixels.len() } else { 0 });
        let mut layers_of = Vec::with_capacity(self.pixels.len());
        let mut layer_histogram = vec![0];
        let mut stored_histogram = vec![0];
        let mut blended = 0;
        let mut layers = Vec::new();
        for group in self.pixels.chunks(GROUP) {
            let stored = self.layers(group, &mut layers);
            let mut rest = &mut layers[..];
            for ((number, pixel), stored) in (0..).zip(group).zip(stored) {
                let own = rest.iter().take_while(|layer| layer.pixel == number);
                let (own, others) = rest.split_at_mut(own.count());
                rest = others;
                if self.weighted {
                    weighted.push(weights::colour(own, pixel.colour));
                }
                // The sort is stable, so equal depths keep arrival order.
                own.sort_by_key(|layer| Z_FAR - layer.z);
                colours
                    .push(own.iter().fold(pixel.colour, |below, layer| blend(layer.rgba, below)));
                blended += own.len() as u64;
                layers_of.push(own.len() as u32);
                count(&mut layer_histogram, own.len());
                count(&mut stored_histogram, stored);
            }
        }
        let transparent = self.fragments - self.opaque;
        let image = |pixels| Image { width: self.info.width, height: self.info.height, pixels };
        Reference {
            image: image(colours),
            weighted: self.weighted.then(|| image(weighted)),
            fragments: self.fragments,
            opaque: self.opaque,
            transparent,
            culled: transparent - blended,
            blended,
            transparent_pixels: layer_histogram[1..].iter().sum(),
            max_layers: (layer_histogram.len() - 1) as u32,
            layers: layers_of,
            layer_histogram,
            stored: u64::from(self.stored),
            stored_pixels: stored_histogram[1..].iter().sum(),
            stored_histogram,
        }
    }

    /// Fills `layers` with the records that count, pixel by pixel in arrival order. Returns how many each stored.
    fn layers(&self, group: &[Pixel], layers: &mut Vec<Layer>) -> [usize; GROUP] {
        layers.clear();
        let mut stored = [0; GROUP];
        let mut chains: Vec<(u32, u32)> = (0..)
            .zip(group.iter().map(|pixel| pixel.latest))
            .filter(|&(_, index)| index != NONE)
            .collect();
        while !chains.is_empty() {
            chains.retain_mut(|(pixel, index)| {
                let record = self.blocks[*index as usize / BLOCK][*index as usize % BLOCK];
                stored[*pixel as usize] += 1;
                if record.z < group[*pixel as usize].z {
                    layers.push(Layer { pixel: *pixel, z: record.z, rgba: record.rgba });
                }
                *index = record.previous;
                *index != NONE
            });
        }
        // A chain runs from the latest to the earliest; the sort is stable, so each pixel keeps arrival order.
        layers.reverse();
        layers.sort_by_key(|layer| layer.pixel);
        stored
    }
}

/// Adds a histogram to a sum of such.
fn add(sum: &mut Vec<u64>, histogram: &[u64]) {
    sum.resize(sum.len().max(histogram.len()), 0);
    for (sum, pixels) in sum.iter_mut().zip(histogram) {
        *sum += pixels;
    }
}

/// Counts one pixel with `fragments` fragments.
fn count(histogram: &mut Vec<u64>, fragments: usize) {
    if histogram.len() <= fragments {
        histogram.resize(fragments + 1, 0);
    }
    histogram[fragments] += 1;
}

/// A colour `0xRRGGBBAA` over a colour `0xRRGGBB`: `(a*s + (255-a)*c) / 255` per channel, rounded to nearest.
fn blend(rgba: u32, below: u32) -> u32 {
    let [r, g, b, a] = rgba.to_be_bytes().map(u32::from);
    let [_, below_r, below_g, below_b] = below.to_be_bytes().map(u32::from);
    let channel = |s, c| divide_by_255(a * s + (255 - a) * c);
    channel(r, below_r) << 16 | channel(g, below_g) << 8 | channel(b, below_b)
}

/// `t / 255` rounded to nearest, for `t` in 0..=65025. A tie cannot occur, since 255 is odd.
fn divide_by_255(t: u32) -> u32 {
    (t + 128 + ((t + 128) >> 8)) >> 8
}

#[cfg(test)]
mod tests;
