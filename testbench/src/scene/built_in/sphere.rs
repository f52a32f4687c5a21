//! The object that the F-buffer paper measures with (seed 003, its figures 3 and 4): a sphere, of few vertices or of many.
//!
//! It has `n` steps around it and `n / 2` from pole to pole, `n^2` triangles. Its poles lie on the line of sight and its rings come from
//! back to front: seen so, each is all front or all back, so that its fragments come from back to front at every pixel.

use super::shapes::sphere_along_z;
use crate::scene::camera::Camera;
use crate::scene::geometry::Part;
use glam::{Vec3, vec4};

/// How far the eye is, in radii: at 1024x1024 the sphere then has as many fragments as the paper's.
const DISTANCE: f32 = 4.435;
/// Vertical field of view in degrees.
const FOV: f64 = 40.0;

/// The view that the scene is made for, along its axis.
pub(in crate::scene) fn camera() -> Camera {
    Camera::new(DISTANCE * Vec3::Z, Vec3::ZERO, FOV)
}

/// The sphere with so many steps around it. Each triangle has its own vertices and its own normal, so that it is of one colour, and one
/// primitive comes of it.
pub(in crate::scene) fn parts(steps: u32) -> Vec<Part> {
    let mut smooth = Part::new(vec![]);
    sphere_along_z(&mut smooth, steps);
    let corners = smooth.triangles.iter().flatten();
    let positions: Vec<Vec3> = corners.map(|corner| smooth.positions[*corner as usize]).collect();
    let of_one = |corners: &[Vec3]| [corners.iter().sum::<Vec3>(); 3];
    let facets = Part {
        normals: positions.chunks_exact(3).flat_map(of_one).collect(),
        triangles: (0..positions.len() as u32 / 3).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect(),
        positions,
        sent_whole: true,
        ..Part::new(vec!["sphere".into()])
    };
    vec![facets.painted(vec4(0.42, 0.74, 0.94, 0.5))]
}

#[cfg(test)]
mod tests {
    use crate::scene::{Options, Scene};
    use std::convert::Infallible;

    const NAMES: [(&str, usize); 2] = [("sphere-12288", 12_288), ("sphere-196608", 196_608)];

    fn scene(name: &str, side: u32, camera: Option<&str>) -> Scene {
        let camera = camera.map(|camera| camera.parse().unwrap());
        let size = Options { width: Some(side), height: Some(side), ..Options::default() };
        Scene::open(name, &Options { camera, ..size }).unwrap()
    }

    fn fragments(scene: &Scene) -> u64 {
        let mut count = 0;
        let Ok(()) = scene.play(&mut |_| {
            count += 1;
            Ok::<(), Infallible>(())
        });
        count
    }

    /// Three for each triangle, as the paper counts them, also where triangles are smaller than pixels.
    #[test]
    fn vertices_are_those_of_its_name() {
        for (name, vertices) in NAMES {
            for (side, camera) in [(1024, None), (512, Some("0,0,3.0625:0,0,0")), (64, None)] {
                let mut sent = 0;
                let Ok(()) = scene(name, side, camera).play_primitives(&mut |_| {
                    sent += 3;
                    Ok::<(), Infallible>(())
                });
                assert_eq!(sent, vertices, "{name} at {side}x{side}");
            }
        }
    }

    /// 489 submissions of three passes with a buffer of 64x64, and 33 with one of 256x256: so many windows of so many fragments.
    #[test]
    fn at_1024x1024_it_has_as_many_fragments_as_the_papers() {
        for (name, _) in NAMES {
            let fragments = fragments(&scene(name, 1024, None));
            assert!((663_553..=667_648).contains(&fragments), "{name}: {fragments}");
        }
    }

    /// Figure 3 needs 23 windows of 128x128 for a view of 512x512, so that the eye is nearer there.
    #[test]
    fn from_nearer_it_has_those_of_figure_3() {
        for (name, _) in NAMES {
            let fragments = fragments(&scene(name, 512, Some("0,0,3.0625:0,0,0")));
            assert!((360_449..=376_832).contains(&fragments), "{name}: {fragments}");
        }
    }

    #[test]
    fn at_every_pixel_it_comes_from_back_to_front() {
        for (name, _) in NAMES {
            let mut last = vec![u32::MAX; 200 * 200];
            let Ok(()) = scene(name, 200, None).play(&mut |f| {
                let last = &mut last[(f.y * 200 + f.x) as usize];
                assert!(f.z <= *last, "{name}: {f:?}");
                *last = f.z;
                Ok::<(), Infallible>(())
            });
        }
    }
}
