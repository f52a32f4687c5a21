//! A pipe rack as in a refinery, for frames with hundreds of layers: the role that the Power Plant model has in the dynamic fragment
//! buffer paper (seed 002).
//!
//! The rack runs away from the viewer in bays that are alike but for what a seeded generator places in them: transparent pipes along
//! it and across it, and valves, between opaque columns, beams and platforms. Along the rack all pipes across it lie behind each
//! other; from the side there are a few. All of it takes 32 MiB as it is drawn.

use super::shapes::{box_of, sphere_of, tube};
use crate::scene::camera::Camera;
use crate::scene::geometry::Part;
use glam::{Vec3, Vec4, vec3, vec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Bays of the rack.
const BAYS: u32 = 92;
/// Length of a bay.
const BAY: f32 = 2.0;
/// Half the width of the rack.
const HALF: f32 = 3.0;
/// Heights of its beams.
const LEVELS: [f32; 3] = [1.0, 3.0, 5.0];
/// Pipes along the rack on each level but the highest.
const ALONG: u32 = 8;
/// Pipes across the rack in each bay, between the first two levels.
const ACROSS: u32 = 8;
/// A bay in so many has a platform.
const PLATFORM_EVERY: u32 = 4;
/// Slats of a platform.
const SLATS: u32 = 14;
/// Seed of places and colours.
const SEED: u64 = 3;

const STEEL: Vec4 = vec4(0.42, 0.45, 0.5, 1.0);
const GRATING: Vec4 = vec4(0.86, 0.66, 0.24, 1.0);
/// Red, green and blue of what flows.
const MEDIA: [Vec3; 5] = [
    vec3(0.92, 0.36, 0.28),
    vec3(0.24, 0.62, 0.9),
    vec3(0.3, 0.74, 0.46),
    vec3(0.95, 0.76, 0.3),
    vec3(0.68, 0.48, 0.86),
];

/// The view along the rack, from before its first bay, between the pipes across it.
pub(in crate::scene) fn camera() -> Camera {
    Camera::new(vec3(0.125, 2.0, 5.0), vec3(0.125, 2.0, -(BAYS as f32) * BAY / 2.0), 40.0)
}

/// The parts, bay by bay: transparent ones before the opaque ones that hide some of them.
pub(in crate::scene) fn parts() -> Vec<Part> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut parts = vec![along(&mut rng)];
    for bay in 0..BAYS {
        let z = -(bay as f32) * BAY;
        parts.push(across(&mut rng, z));
        parts.push(valve(&mut rng, z));
        parts.push(structure(z));
        if bay % PLATFORM_EVERY == 0 {
            parts.push(platform(z));
        }
    }
    parts
}

/// A colour of something that flows, with a transparent wall around it.
fn medium(rng: &mut ChaCha8Rng) -> Vec4 {
    let colour = MEDIA[rng.random_range(0..MEDIA.len())];
    (colour * rng.random_range(0.8..1.0)).extend(rng.random_range(0.06..0.3))
}

/// Pipes from end to end.
fn along(rng: &mut ChaCha8Rng) -> Part {
    let mut part = Part::new(vec!["pipes".into()]);
    for level in &LEVELS[..2] {
        for pipe in 0..ALONG {
            let radius = rng.random_range(0.1..0.26);
            let place = (pipe as f32 + 0.5) / ALONG as f32 * 2.0 - 1.0;
            let start = vec3(place * (HALF - 0.2), level + 0.1 + radius, 0.0);
            tube(&mut part, start, Vec3::NEG_Z * BAYS as f32 * BAY, radius, (12, 2 * BAYS));
            part.colours.resize(part.positions.len(), medium(rng));
        }
    }
    part
}

/// Pipes from side to side.
fn across(rng: &mut ChaCha8Rng, z: f32) -> Part {
    let mut part = Part::new(vec!["pipes".into()]);
    for _ in 0..ACROSS {
        let radius = rng.random_range(0.14..0.3);
        let start = vec3(-HALF, rng.random_range(1.55..2.75), z - rng.random_range(0.2..BAY - 0.2));
        tube(&mut part, start, Vec3::X * 2.0 * HALF, radius, (12, 10));
        part.colours.resize(part.positions.len(), medium(rng));
    }
    part
}

/// A valve on one of the pipes: a body, a stem and a wheel.
fn valve(rng: &mut ChaCha8Rng, z: f32) -> Part {
    let mut part = Part::new(vec!["valves".into()]);
    let centre = vec3(
        rng.random_range(-HALF + 0.5..HALF - 0.5),
        rng.random_range(1.6..2.6),
        z - rng.random_range(0.4..BAY - 0.4),
    );
    sphere_of(&mut part, centre, 0.36, 20);
    tube(&mut part, centre, Vec3::Y * 0.7, 0.06, (10, 2));
    tube(&mut part, centre + Vec3::Y * 0.68, Vec3::Y * 0.06, 0.28, (20, 1));
    let colour = medium(rng);
    part.painted(colour)
}

/// The two columns and the beams of a bay.
fn structure(z: f32) -> Part {
    let mut part = Part::new(vec!["structure".into()]);
    let top = LEVELS[2];
    for x in [-HALF, HALF] {
        box_of(&mut part, vec3(x, top / 2.0, z), vec3(0.2, top, 0.2));
    }
    for level in LEVELS {
        box_of(&mut part, vec3(0.0, level, z), vec3(2.0 * HALF, 0.14, 0.14));
    }
    part.painted(STEEL)
}

/// A platform beside a bay, of slats.
fn platform(z: f32) -> Part {
    let mut part = Part::new(vec!["platforms".into()]);
    for slat in 0..SLATS {
        let along = (slat as f32 + 0.5) / SLATS as f32 * BAY;
        box_of(&mut part, vec3(HALF + 0.8, 2.0, z - along), vec3(1.3, 0.04, 0.06));
    }
    part.painted(GRATING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::Golden;
    use crate::scene::geometry::{TRIANGLE_BYTES, VERTEX_BYTES};
    use crate::scene::{Options, Scene};
    use pellucid_machine::pixel::Fragment;
    use std::convert::Infallible;

    /// What the golden model says of it at 800x600.
    fn reference(camera: Option<&str>) -> crate::golden::Reference {
        let camera = camera.map(|text| text.parse().unwrap());
        let (width, height) = (Some(800), Some(600));
        let scene = Scene::open("plant", &Options { camera, width, height, ..Options::default() });
        let scene = scene.unwrap();
        let mut fragments: Vec<Fragment> = vec![];
        let Ok(()) = scene.play(&mut |fragment| {
            fragments.push(fragment);
            Ok::<(), Infallible>(())
        });
        Golden::new(scene.info()).of(&fragments).unwrap()
    }

    #[test]
    fn it_is_hundreds_of_layers_deep_along_the_rack_and_far_fewer_from_elsewhere() {
        let along = reference(None);
        for view in ["60,20,-60:0,2,-100", "0,60,-100:0,2,-101", "30,2,-100:0,2,-100"] {
            let other = reference(Some(view));
            assert!(other.max_layers < 100, "{view}: {}", other.max_layers);
        }
        assert!((560..=600).contains(&along.max_layers), "{}", along.max_layers);
    }

    /// Tubes of 2 * around * along triangles, spheres of as many as a grid of around * around / 2, boxes of 12.
    #[test]
    fn its_triangles_and_their_memory_are_bounded() {
        let parts = parts();
        let count = |name: &str| -> u32 {
            let of_name = parts.iter().filter(|part| part.names[0] == name);
            of_name.map(|part| part.triangles.len() as u32).sum()
        };
        let along = 16 * 2 * 12 * 184;
        let across = 92 * 8 * 2 * 12 * 10;
        assert_eq!(count("pipes"), along + across);
        assert_eq!(count("valves"), 92 * (2 * 20 * 10 + 2 * 10 * 2 + 2 * 20));
        assert_eq!(count("structure"), 92 * 5 * 12);
        assert_eq!(count("platforms"), 23 * 14 * 12);
        let bytes = |part: &Part| {
            part.positions.len() * VERTEX_BYTES + part.triangles.len() * TRIANGLE_BYTES
        };
        let all: usize = parts.iter().map(bytes).sum();
        assert!(all < 40 << 20, "{all}");
        for part in &parts {
            let opaque = matches!(&*part.names[0], "structure" | "platforms");
            assert!(part.colours.len() == part.positions.len(), "{:?}", part.names);
            assert!(part.colours.iter().all(|c| (c.w == 1.0) == opaque), "{:?}", part.names);
        }
    }
}
