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
//! gives a further image, by that arithmetic: see [`Arithmetic`].
//!
//! Memory: 16 bytes per pixel, and 12 bytes per transparent fragment that it holds, 8,388,608 of them at most. If more
//! lie in front of the opaque depth at their arrival (one that does not can never come to count, since that depth only
//! decreases), it holds none at first and has the frame played again, for as many pixels at a time as it can hold all
//! fragments of. A single pixel is never divided: one that has more is held in whole.

pub mod accumulated;
pub mod primitive;

use crate::image::Image;
use accumulated::Accumulated;
use pellucid_machine::arithmetic::{Layer, Shading, Unshaded};
use pellucid_machine::census::add;
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine::{Arithmetic, Census};
use std::borrow::Cow;
use std::ops::Range;

/// No record: the end of a pixel's chain. It bounds the records, whose indices are below it.
const NONE: u32 = u32::MAX;

/// Records per block of the store. Blocks never move, so growing copies nothing.
const BLOCK: usize = 1 << 16;

/// The most records of several pixels that are held at once: 96 MiB.
const HELD: u64 = 1 << 23;

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
    /// A pixel has more transparent fragments than indices.
    #[error(
        "fragment {number} does not fit: the golden model holds {limit} transparent fragments of a pixel"
    )]
    TooMany {
        /// The fragment's number in arrival order, from 1.
        number: u64,
        /// How many transparent fragments of a pixel fit.
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

/// One pixel while fragments arrive.
#[derive(Clone, Copy)]
struct Pixel {
    /// Depth of the nearest opaque fragment so far.
    z: u32,
    /// Its colour, `0xRRGGBB`.
    colour: u32,
    /// Index of the latest record that is held, or [`NONE`].
    latest: u32,
    /// Transparent fragments in front of the opaque depth at their arrival.
    stored: u32,
}

/// The golden model of one frame: takes fragments in arrival order, then gives the [`Reference`].
///
/// ```
/// use pellucid_machine::pixel::{Fragment, Screen};
/// use pellucid_sim::Label;
/// use pellucid_testbench::golden::Golden;
///
/// let screen = Screen { width: 1, height: 1, background: 0x00_00ff };
/// let green = Fragment { x: 0, y: 0, z: 3, rgba: 0x00ff_0080, label: Label::NONE };
/// let reference = Golden::new(screen).of(&[green])?;
/// assert_eq!(reference.image.pixels, [0x00_807f]);
/// # Ok::<(), pellucid_testbench::golden::GoldenError>(())
/// ```
pub struct Golden {
    info: Screen,
    pixels: Vec<Pixel>,
    /// The pixels whose records are held; those before are done.
    held: Range<usize>,
    /// The most records that are held of several pixels.
    most_held: u64,
    blocks: Vec<Vec<Record>>,
    /// Records in `blocks`.
    records: u32,
    limit: u32,
    /// What is known so far: counts of fragments, and all of the pixels that are done.
    known: Reference,
}

/// The exact image of a frame, and what every architecture must count.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reference {
    /// The image by the exact blend.
    pub image: Image,
    /// What comes of it by other arithmetics that the golden model was made [`Golden::with`].
    pub further: Vec<By>,
    /// What a machine must give that makes one image of several frames: then `image` has their exact means.
    pub accumulated: Option<Accumulated>,
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

/// What comes of a frame by another arithmetic than the exact blend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct By {
    /// The arithmetic.
    pub arithmetic: Arithmetic,
    /// The image.
    pub image: Image,
    /// Transparent fragments in front of the final opaque depth that its program kills.
    pub killed: u64,
}

impl Reference {
    /// Several frames of one size as if they were one, each below the one before.
    pub fn stacked<'a>(frames: impl IntoIterator<Item = &'a Reference> + Clone) -> Reference {
        let mut all = Reference::counted(frames.clone());
        let images = |of: &dyn Fn(&'a Reference) -> &'a Image| {
            Image::stacked(frames.clone().into_iter().map(of))
        };
        all.image = images(&|frame| &frame.image);
        for by in &mut all.further {
            by.image = images(&|frame| frame.image_by(by.arithmetic));
        }
        all.layers = frames.into_iter().flat_map(|frame| &frame.layers).copied().collect();
        all
    }

    /// What was counted in several frames, without their pixels.
    fn counted<'a>(frames: impl IntoIterator<Item = &'a Reference> + Clone) -> Reference {
        let first = frames.clone().into_iter().next();
        let further = first.into_iter().flat_map(|frame| &frame.further).map(|by| {
            let arithmetic = by.arithmetic;
            let killed = frames.clone().into_iter().map(|frame| frame.killed_by(arithmetic));
            By { arithmetic, image: Image::default(), killed: killed.sum() }
        });
        let mut all = Reference { further: further.collect(), ..Reference::default() };
        for frame in frames {
            all.fragments += frame.fragments;
            all.opaque += frame.opaque;
            all.transparent += frame.transparent;
            all.culled += frame.culled;
            all.blended += frame.blended;
            all.transparent_pixels += frame.transparent_pixels;
            all.max_layers = all.max_layers.max(frame.max_layers);
            add(&mut all.layer_histogram, &frame.layer_histogram);
            all.stored += frame.stored;
            all.stored_pixels += frame.stored_pixels;
            add(&mut all.stored_histogram, &frame.stored_histogram);
        }
        all
    }

    /// What a machine cannot change about the frame.
    pub fn census(&self) -> Census {
        Census {
            transparent: self.transparent,
            stored: self.stored,
            histogram: self.stored_histogram.clone(),
            visible: self.layer_histogram.clone(),
        }
    }

    /// The image that a machine of that arithmetic must give, bit for bit, of each frame for itself.
    ///
    /// # Panics
    /// The golden model was made without that arithmetic.
    pub fn image_by(&self, arithmetic: Arithmetic) -> &Image {
        if arithmetic == Arithmetic::BLEND { &self.image } else { &self.by(arithmetic).image }
    }

    /// How many of the `blended` a machine of that arithmetic does not blend, since its program kills them.
    ///
    /// # Panics
    /// The golden model was made without that arithmetic.
    pub fn killed_by(&self, arithmetic: Arithmetic) -> u64 {
        if arithmetic == Arithmetic::BLEND { 0 } else { self.by(arithmetic).killed }
    }

    fn by(&self, arithmetic: Arithmetic) -> &By {
        let by = self.further.iter().find(|by| by.arithmetic == arithmetic);
        by.unwrap_or_else(|| panic!("the golden model was made without {arithmetic:?}"))
    }
}

impl Golden {
    /// An empty frame, of which the exact image is wanted.
    pub fn new(info: Screen) -> Golden {
        let clear = Pixel { z: Z_FAR, colour: info.background, latest: NONE, stored: 0 };
        let pixels = info.width as usize * info.height as usize;
        let image = Image { width: info.width, height: info.height, pixels: vec![] };
        Golden {
            info,
            pixels: vec![clear; pixels],
            held: 0..pixels,
            most_held: HELD,
            blocks: Vec::new(),
            records: 0,
            limit: NONE,
            known: Reference {
                image,
                layer_histogram: vec![0],
                stored_histogram: vec![0],
                ..Reference::default()
            },
        }
    }

    /// The same, with the image by `arithmetic` beside the exact one.
    #[must_use]
    pub fn with(mut self, arithmetic: Arithmetic) -> Golden {
        if arithmetic != Arithmetic::BLEND
            && !self.known.further.iter().any(|by| by.arithmetic == arithmetic)
        {
            let image = self.known.image.clone();
            self.known.further.push(By { arithmetic, image, killed: 0 });
        }
        self
    }

    /// What must come of a frame that `play` sends, the same each time: once, or several times if the frame has more
    /// transparent fragments than are held. Gives what the first play gave, too.
    ///
    /// # Errors
    /// The first error of `play`, a fragment that is outside the frame, or more than 2^32-1 to store at a pixel.
    pub fn judge<T, E: From<GoldenError>>(
        mut self,
        mut play: impl FnMut(&mut dyn FnMut(Fragment) -> Result<(), E>) -> Result<T, E>,
    ) -> Result<(Reference, T), E> {
        let played = play(&mut |fragment| Ok(self.push(fragment)?))?;
        while self.is_left() {
            play(&mut |fragment| {
                self.push_again(fragment);
                Ok(())
            })?;
        }
        Ok((self.known, played))
    }

    /// What must come of these fragments, in arrival order.
    ///
    /// # Errors
    /// As [`Golden::judge`].
    pub fn of(self, fragments: &[Fragment]) -> Result<Reference, GoldenError> {
        let judged = self.judge(|sink| fragments.iter().try_for_each(|f| sink(*f)));
        judged.map(|(reference, ())| reference)
    }

    /// Takes the next fragment in arrival order.
    fn push(&mut self, fragment: Fragment) -> Result<(), GoldenError> {
        let Screen { width, height, .. } = self.info;
        let number = self.known.fragments + 1;
        if fragment.x >= width || fragment.y >= height || fragment.z > Z_FAR {
            return Err(GoldenError::Outside { number, fragment, width, height });
        }
        let place = self.place(fragment);
        let pixel = &mut self.pixels[place];
        if fragment.rgba & 0xff == 255 {
            self.known.opaque += 1;
            if fragment.z < pixel.z {
                pixel.z = fragment.z;
                pixel.colour = fragment.rgba >> 8;
            }
        } else if fragment.z < pixel.z {
            if pixel.stored == self.limit {
                let limit = self.limit;
                return Err(GoldenError::TooMany { number, limit });
            }
            pixel.stored += 1;
            self.known.stored += 1;
            if self.known.stored <= self.most_held {
                self.hold(place, fragment);
            } else if !self.held.is_empty() {
                self.held = 0..0;
                self.let_go();
            }
        }
        self.known.fragments = number;
        Ok(())
    }

    /// Takes a fragment of a frame that is played again.
    fn push_again(&mut self, fragment: Fragment) {
        let place = self.place(fragment);
        let transparent = fragment.rgba & 0xff != 255;
        // The opaque depth is the final one by now.
        if transparent && self.held.contains(&place) && fragment.z < self.pixels[place].z {
            self.hold(place, fragment);
        }
    }

    /// Which pixel a fragment is at.
    fn place(&self, fragment: Fragment) -> usize {
        fragment.y as usize * self.info.width as usize + fragment.x as usize
    }

    /// Adds a record to a pixel.
    fn hold(&mut self, place: usize, fragment: Fragment) {
        let pixel = &mut self.pixels[place];
        let record = Record { previous: pixel.latest, z: fragment.z, rgba: fragment.rgba };
        pixel.latest = self.records;
        self.records += 1;
        match self.blocks.last_mut() {
            Some(block) if block.len() < BLOCK => block.push(record),
            _ => {
                let mut block = Vec::with_capacity(BLOCK);
                block.push(record);
                self.blocks.push(block);
            }
        }
    }

    /// Forgets all records.
    fn let_go(&mut self) {
        self.blocks.clear();
        self.records = 0;
        self.pixels.iter_mut().for_each(|pixel| pixel.latest = NONE);
    }

    /// Ends a play of the frame. Whether it has to be played again, for pixels of which nothing was held.
    fn is_left(&mut self) -> bool {
        self.blend();
        self.let_go();
        let from = self.held.end;
        let mut sum = 0;
        let fit = self.pixels[from..].iter().take_while(|pixel| {
            sum += u64::from(pixel.stored);
            sum <= self.most_held
        });
        let to = from + fit.count();
        // One pixel at least, however many it has.
        self.held = from..to.max(from + 1).min(self.pixels.len());
        !self.held.is_empty()
    }

    /// Blends the pixels whose records are held, and counts.
    fn blend(&mut self) {
        let mut known = std::mem::take(&mut self.known);
        let (mut layers, mut own): (Vec<(u32, Layer)>, Vec<Layer>) = (vec![], vec![]);
        let width = self.info.width;
        for (first, group) in
            self.held.clone().step_by(GROUP).zip(self.pixels[self.held.clone()].chunks(GROUP))
        {
            self.layers(group, &mut layers);
            let mut rest = &layers[..];
            for (number, pixel) in (0..).zip(group) {
                let count_of = rest.iter().take_while(|(pixel, _)| *pixel == number).count();
                let (of_pixel, others) = rest.split_at(count_of);
                rest = others;
                own.clear();
                own.extend(of_pixel.iter().map(|(_, layer)| *layer));
                for By { arithmetic, image, killed } in &mut known.further {
                    let place = (first as u32) + number;
                    let shaded = shaded(arithmetic, &own, place % width, place / width);
                    *killed += (own.len() - shaded.len()) as u64;
                    let colour = arithmetic.colour.map(|colour| colour(&shaded, pixel.colour));
                    image.pixels.extend(colour);
                }
                // The sort is stable, so equal depths keep arrival order.
                own.sort_by_key(|layer| Z_FAR - layer.z);
                let colour = |below, layer: &Layer| blend(layer.rgba, below);
                known.image.pixels.push(own.iter().fold(pixel.colour, colour));
                known.blended += own.len() as u64;
                known.layers.push(own.len() as u32);
                count(&mut known.layer_histogram, own.len());
                count(&mut known.stored_histogram, pixel.stored as usize);
            }
        }
        known.transparent = known.fragments - known.opaque;
        known.culled = known.transparent - known.blended;
        known.transparent_pixels = known.layer_histogram[1..].iter().sum();
        known.max_layers = (known.layer_histogram.len() - 1) as u32;
        known.stored_pixels = known.stored_histogram[1..].iter().sum();
        self.known = known;
    }

    /// Fills `layers` with the records that count and the numbers of their pixels, pixel by pixel in arrival order.
    fn layers(&self, group: &[Pixel], layers: &mut Vec<(u32, Layer)>) {
        layers.clear();
        let mut chains: Vec<(u32, u32)> = (0..)
            .zip(group.iter().map(|pixel| pixel.latest))
            .filter(|&(_, index)| index != NONE)
            .collect();
        while !chains.is_empty() {
            chains.retain_mut(|(pixel, index)| {
                let record = self.blocks[*index as usize / BLOCK][*index as usize % BLOCK];
                if record.z < group[*pixel as usize].z {
                    layers.push((*pixel, Layer { z: record.z, rgba: record.rgba }));
                }
                *index = record.previous;
                *index != NONE
            });
        }
        // A chain runs from the latest to the earliest; the sort is stable, so each pixel keeps arrival order.
        layers.reverse();
        layers.sort_by_key(|(pixel, _)| *pixel);
    }
}

/// The layers of the pixel in column `x` and row `y`, as `by` shades them; those that it kills are not among them.
fn shaded<'a>(by: &Arithmetic, layers: &'a [Layer], x: u32, y: u32) -> Cow<'a, [Layer]> {
    let Some(Shading { program, colour }) = by.shading else { return Cow::Borrowed(layers) };
    let unshaded = |&Layer { z, rgba }: &Layer| Unshaded { x, y, z, rgba };
    let Some(last) = layers.last().map(unshaded) else { return Cow::Borrowed(layers) };
    let shade = |layer: &Layer| {
        let rgba = colour(program, unshaded(layer), last)?;
        Some(Layer { rgba, ..*layer })
    };
    layers.iter().filter_map(shade).collect()
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
