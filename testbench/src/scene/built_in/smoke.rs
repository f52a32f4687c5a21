//! A column of soft discs that face the camera: many layers, each fragment with an alpha of its own.

use crate::scene::Screen;
use crate::scene::camera::Camera;
use crate::scene::order::Order;
use crate::scene::raster::{depth, packed};
use crate::scene::vary::{Sample, aspect};
use glam::{DVec3, Vec3, Vec4, vec3};
use pellucid_machine::pixel::Fragment;
use pellucid_sim::Label;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f32::consts::TAU;

/// Background, `0xRRGGBB`.
pub(in crate::scene) const BACKGROUND: u32 = 0x10141c;
/// How many discs there are.
const PARTICLES: usize = 3600;
/// Seed of the particles' places.
const SEED: u64 = 7;

/// Discs in order of emission, projected.
#[derive(Debug)]
pub(in crate::scene) struct Smoke {
    discs: Vec<Disc>,
    camera: Camera,
    info: Screen,
    order: Order,
}

/// A particle on the screen, at one depth all over.
#[derive(Debug)]
struct Disc {
    /// Centre in pixels from the upper left corner.
    x: f32,
    y: f32,
    /// Radius in pixels.
    radius: f32,
    z: u32,
    /// Colour, 0..=255, with the alpha of the centre.
    colour: Vec4,
}

struct Particle {
    centre: Vec3,
    radius: f32,
    colour: Vec4,
}

impl Smoke {
    /// The column as seen by the camera, or as a whole if `None`; the fragments of each disc come in this order.
    pub fn new(camera: Option<Camera>, info: Screen, order: Order) -> Smoke {
        let camera =
            camera.unwrap_or_else(|| Camera::new(vec3(0.0, 1.6, 6.2), vec3(0.0, 1.75, 0.0), 40.0));
        Smoke::seen(camera, info, order, &Sample::default())
    }

    /// The same where what varies is at `sample`.
    pub fn sampled(&self, sample: &Sample) -> Smoke {
        Smoke::seen(self.camera, self.info, self.order, sample)
    }

    fn seen(camera: Camera, info: Screen, order: Order, sample: &Sample) -> Smoke {
        let particles = particles();
        let points: Vec<Vec3> = particles.iter().map(|particle| particle.centre).collect();
        let (width, height) = (f64::from(info.width), f64::from(info.height));
        let view = sample.seen(&camera, camera.view(&points, aspect(info)), info);
        let disc = |particle: &Particle| {
            let clip = view.clip * particle.centre.as_dvec3().extend(1.0);
            let ndc: DVec3 = clip.truncate() / clip.w;
            (0.0..=clip.w).contains(&clip.z).then(|| Disc {
                x: ((ndc.x + 1.0) / 2.0 * width) as f32,
                y: ((1.0 - ndc.y) / 2.0 * height) as f32,
                radius: (f64::from(particle.radius) * view.focal / clip.w * height) as f32,
                z: depth(ndc.z),
                colour: particle.colour,
            })
        };
        Smoke { discs: particles.iter().filter_map(disc).collect(), camera, info, order }
    }

    /// How many particles a play goes through.
    pub fn particles(&self) -> usize {
        self.discs.len()
    }

    /// Sends each disc's fragments, without those whose alpha rounds to 0.
    pub fn play<E>(&self, sink: &mut dyn FnMut(Fragment) -> Result<(), E>) -> Result<(), E> {
        for disc in &self.discs {
            let span = |centre: f32, pixels: u32| {
                let [first, last] =
                    [centre - disc.radius, centre + disc.radius].map(|edge| edge as u32);
                first..last.saturating_add(1).min(pixels)
            };
            let columns = span(disc.x, self.info.width);
            self.order.runs(
                span(disc.y, self.info.height),
                |_| columns.clone(),
                &mut |y, run| {
                    for x in run {
                        let away = (
                            (x as f32 + 0.5 - disc.x) / disc.radius,
                            (y as f32 + 0.5 - disc.y) / disc.radius,
                        );
                        let left = 1.0 - away.0 * away.0 - away.1 * away.1;
                        let rgba =
                            packed(disc.colour * Vec4::new(1.0, 1.0, 1.0, left.max(0.0).powi(2)));
                        if rgba & 0xff != 0 {
                            sink(Fragment { x, y, z: disc.z, rgba, label: Label::NONE })?;
                        }
                    }
                    Ok(())
                },
            )?;
        }
        Ok(())
    }
}

/// Puffs that rise, swirl and spread, warm at the foot and blue-grey at the top, in random order.
fn particles() -> Vec<Particle> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut unit = || rng.random::<f32>();
    (0..PARTICLES)
        .map(|_| {
            let rise = unit().powf(0.8);
            let height = 3.6 * rise;
            let spread = 0.2 + 0.9 * rise * (1.0 + 0.3 * (9.0 * rise).sin());
            let (angle, out) = (TAU * unit(), spread * unit().sqrt());
            let sway = vec3((3.1 * rise).sin() * 0.45, 0.0, (4.3 * rise).cos() * 0.25);
            let centre = sway + vec3(out * angle.cos(), height, out * angle.sin());
            let swirl = 0.5 + 0.5 * (2.0 * angle + 9.0 * rise).sin();
            let warm = vec3(1.0, 0.55, 0.22).lerp(vec3(0.95, 0.35, 0.42), swirl);
            let cool = vec3(0.34, 0.42, 0.62).lerp(vec3(0.78, 0.80, 0.88), swirl);
            let colour = warm.lerp(cool, (1.6 * rise).min(1.0)) * (0.75 + 0.25 * unit());
            let alpha = (0.34 - 0.24 * rise) * (0.6 + 0.8 * unit());
            Particle {
                centre,
                radius: 0.06 + 0.1 * rise + 0.05 * unit(),
                colour: 255.0 * colour.extend(alpha),
            }
        })
        .collect()
}
