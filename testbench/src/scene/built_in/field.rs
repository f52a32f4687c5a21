//! Smooth random fields over the screen, in basic arithmetic alone and so the same on every machine.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Blobs on the screen.
const BLOBS: usize = 16;
/// What ranks the pixels.
pub(super) struct Field {
    /// Column, row and radius in pixels.
    blobs: Vec<[f32; 3]>,
    coarse: Noise,
    fine: Noise,
    inner: Noise,
}

impl Field {
    /// For the frame of this number, 0..=480.
    pub fn new(frame: u32, rng: &mut ChaCha8Rng) -> Field {
        let time = frame as f32 / 480.0;
        let blobs = (0..BLOBS)
            .map(|_| {
                let from = [rng.random_range(40.0..600.0), rng.random_range(40.0..440.0)];
                let to = [rng.random_range(40.0..600.0), rng.random_range(40.0..440.0)];
                let [x, y] = [0, 1].map(|i| from[i] + time * (to[i] - from[i]));
                [x, y, rng.random_range(45.0..115.0)]
            })
            .collect();
        let [coarse, fine, inner] = [64.0, 17.0, 40.0].map(|cell| Noise::new(rng, cell));
        Field { blobs, coarse, fine, inner }
    }

    /// High inside the blobs.
    pub fn cover(&self, x: u32, y: u32) -> f32 {
        let (x, y) = (x as f32, y as f32);
        let blobs: f32 = self
            .blobs
            .iter()
            .map(|[bx, by, radius]| {
                let left = 1.0 - ((x - bx) * (x - bx) + (y - by) * (y - by)) / (radius * radius);
                left.max(0.0) * left.max(0.0)
            })
            .sum();
        blobs + 0.45 * self.coarse.at(x, y) + 0.14 * self.fine.at(x, y)
    }

    /// High where the stacks are deep.
    pub fn depth(&self, cover: f32, x: u32, y: u32) -> f32 {
        let (x, y) = (x as f32, y as f32);
        cover + 0.7 * self.inner.at(x, y) + 0.2 * self.fine.at(x + 300.0, y)
    }
}

/// Value noise: random values in 0..1 on a square lattice, smoothly blended.
pub(super) struct Noise {
    lattice: Vec<f32>,
    cell: f32,
}

impl Noise {
    /// Lattice points along each side before it repeats.
    const SIDE: usize = 64;

    /// Random, with lattice points every `cell` pixels.
    pub fn new(rng: &mut ChaCha8Rng, cell: f32) -> Noise {
        Noise { lattice: (0..Noise::SIDE * Noise::SIDE).map(|_| rng.random()).collect(), cell }
    }

    /// The value at a place with coordinates of 0 or more, in pixels.
    pub fn at(&self, x: f32, y: f32) -> f32 {
        let (column, u) = Noise::split(x / self.cell);
        let (row, v) = Noise::split(y / self.cell);
        let value =
            |c: usize, r: usize| self.lattice[r % Noise::SIDE * Noise::SIDE + c % Noise::SIDE];
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        let upper = mix(value(column, row), value(column + 1, row), u);
        let lower = mix(value(column, row + 1), value(column + 1, row + 1), u);
        mix(upper, lower, v)
    }

    /// Lattice index and the eased way to the next.
    fn split(t: f32) -> (usize, f32) {
        let way = t.fract();
        (t as usize, way * way * (3.0 - 2.0 * way))
    }
}
