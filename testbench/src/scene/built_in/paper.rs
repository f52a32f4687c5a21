//! The T-buffer paper's frames: exactly as many pixels with 1 to 5 transparent fragments as the paper counts.
//!
//! The paper prints counts, not pictures. Here a smooth field over the screen, a few blobs with ragged edges that drift
//! from frame to frame, ranks the pixels: the highest are transparent, and among those the deepest stacks lie innermost.
//! Fragments arrive scrambled over the whole screen. All of it is arithmetic on a seeded generator, and the same on
//! every machine.

use super::field::{Field, Noise};
use pellucid_machine::pixel::{Fragment, Z_FAR, rgba};
use pellucid_sim::Label;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Background, `0xRRGGBB`.
pub(in crate::scene) const BACKGROUND: u32 = 0x1c2333;

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;
/// Seed of everything random.
const SEED: u64 = 1975;
/// One fragment in so many lies on its pixel's own surface, so that equal depths meet in a pixel.
const COINCIDENT: u32 = 5;

/// How many pixels have how many transparent fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) struct Frame {
    /// The frame's number in the paper.
    pub number: u32,
    /// Pixels with exactly 1, 2, 3, 4 and 5 fragments.
    pub pixels: [usize; 5],
}

/// The paper's table.
const FRAMES: [Frame; 8] = [
    counted(0, [5812, 956, 6633, 2279, 189]),
    counted(120, [5723, 956, 6634, 2278, 189]),
    counted(180, [8713, 956, 6634, 2278, 189]),
    counted(240, [32588, 12040, 7235, 2279, 189]),
    counted(300, [26082, 2729, 6636, 2179, 121]),
    counted(360, [27421, 7094, 7006, 1569, 173]),
    counted(420, [15728, 3290, 6770, 1296, 15]),
    counted(480, [95226, 8716, 6711, 671, 0]),
];

const fn counted(number: u32, pixels: [usize; 5]) -> Frame {
    Frame { number, pixels }
}

/// The frame with the name `paper-NUMBER`.
pub(in crate::scene) fn frame(name: &str) -> Option<Frame> {
    FRAMES.into_iter().find(|frame| format!("paper-{}", frame.number) == name)
}

/// The layers of a frame in arrival order.
#[derive(Debug)]
pub(in crate::scene) struct Paper {
    frame: Frame,
    layers: Vec<Layer>,
}

/// One fragment to come: its pixel, row by row from the upper left, and its place among the pixel's fragments, from 0.
#[derive(Clone, Copy, Debug)]
struct Layer {
    pixel: u32,
    index: u8,
}

impl Paper {
    /// Chooses the frame's pixels and the order of arrival.
    pub fn new(frame: Frame) -> Paper {
        let field = Field::new(frame.number, &mut ChaCha8Rng::seed_from_u64(SEED));
        let mut ranked: Vec<(f32, u32)> = (0..WIDTH * HEIGHT)
            .map(|pixel| (field.cover(pixel % WIDTH, pixel / WIDTH), pixel))
            .collect();
        rank(&mut ranked);
        ranked.truncate(frame.pixels.iter().sum());
        for (value, pixel) in &mut ranked {
            *value = field.depth(*value, *pixel % WIDTH, *pixel / WIDTH);
        }
        rank(&mut ranked);

        let deepest_first = (1..=5u8)
            .rev()
            .flat_map(|depth| (0..frame.pixels[usize::from(depth) - 1]).map(move |_| depth));
        let mut layers: Vec<Layer> = ranked
            .into_iter()
            .zip(deepest_first)
            .flat_map(|((_, pixel), depth)| (0..depth).map(move |index| Layer { pixel, index }))
            .collect();
        layers.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
        Paper { frame, layers }
    }

    /// How many fragments a play sends.
    pub fn layers(&self) -> usize {
        self.layers.len()
    }

    /// Sends one fragment for each layer: alpha 1..=254, any depth, a colour that drifts over the screen.
    pub fn play<E>(&self, sink: &mut dyn FnMut(Fragment) -> Result<(), E>) -> Result<(), E> {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED + 1 + u64::from(self.frame.number));
        let hues = [0, 1, 2].map(|_| Noise::new(&mut rng, 90.0));
        for layer in &self.layers {
            let (x, y) = (layer.pixel % WIDTH, layer.pixel / WIDTH);
            let own_surface = Z_FAR / 8 + (x * 7 + y * 11) * (Z_FAR / 16384);
            let z = match rng.random_ratio(1, COINCIDENT) {
                true => own_surface,
                false => rng.random_range(0..Z_FAR),
            };
            let shift = 130.0 * f32::from(layer.index);
            let [r, g, b] = hues.each_ref().map(|hue| {
                let value = 40.0
                    + 215.0 * hue.at(x as f32 + shift, y as f32 + shift)
                    + rng.random_range(-10.0..10.0);
                value as u8
            });
            let rgba = rgba(r, g, b, rng.random_range(1..=254));
            sink(Fragment { x, y, z, rgba, label: Label::NONE })?;
        }
        Ok(())
    }
}

/// Highest value first, equal values by pixel.
fn rank(pixels: &mut [(f32, u32)]) {
    pixels.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn every_frame_has_exactly_the_papers_pixels() {
        let table = [
            ("paper-0", [5812, 956, 6633, 2279, 189]),
            ("paper-120", [5723, 956, 6634, 2278, 189]),
            ("paper-180", [8713, 956, 6634, 2278, 189]),
            ("paper-240", [32588, 12040, 7235, 2279, 189]),
            ("paper-300", [26082, 2729, 6636, 2179, 121]),
            ("paper-360", [27421, 7094, 7006, 1569, 173]),
            ("paper-420", [15728, 3290, 6770, 1296, 15]),
            ("paper-480", [95226, 8716, 6711, 671, 0]),
        ];
        for (name, expected) in table {
            let mut depths = vec![0usize; (WIDTH * HEIGHT) as usize];
            let paper = Paper::new(frame(name).unwrap());
            let Ok(()) = paper.play(&mut |f| -> Result<(), Infallible> {
                assert!(f.x < WIDTH && f.y < HEIGHT && f.z < Z_FAR, "{f:?}");
                assert!((1..=254).contains(&(f.rgba & 0xff)), "{f:?}");
                depths[(f.y * WIDTH + f.x) as usize] += 1;
                Ok(())
            });
            let mut pixels = [0; 6];
            depths.into_iter().for_each(|depth| pixels[depth] += 1);
            assert_eq!(pixels[1..], expected, "{name}");
        }
    }

    #[test]
    fn equal_depths_meet_in_some_pixels() {
        let mut seen = std::collections::HashSet::new();
        let mut met = 0;
        let Ok(()) = Paper::new(FRAMES[0]).play(&mut |f| -> Result<(), Infallible> {
            met += u32::from(!seen.insert((f.x, f.y, f.z)));
            Ok(())
        });
        assert!(met > 100, "{met}");
    }
}
