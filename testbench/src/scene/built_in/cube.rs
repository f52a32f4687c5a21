//! The RGB colour cube, of which the accumulation paper (seed 004, its figure 3) takes the mean of equal images.

use crate::scene::geometry::Part;
use glam::{Vec3, vec3};

/// The cube from black at the origin to white, each corner in the colour that its coordinates are, without light.
pub(in crate::scene) fn parts() -> Vec<Part> {
    let corner = |k: u8| vec3(f32::from(k & 1), f32::from(k >> 1 & 1), f32::from(k >> 2));
    let positions: Vec<Vec3> = (0..8).map(corner).collect();
    let colours = positions.iter().map(|corner| corner.extend(1.0)).collect();
    // Faces across an axis: two corners along another, two along the third.
    let faces = [0, 1, 2].into_iter().flat_map(|axis| {
        let [across, right, up] = [1 << axis, 1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
        [0, across].map(|first| [first, first + right, first + right + up, first + up])
    });
    let triangles = faces.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    vec![Part { positions, colours, triangles, unlit: true, ..Part::new(vec!["cube".into()]) }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::Golden;
    use crate::scene::{Options, Scene};
    use std::convert::Infallible;

    #[test]
    fn it_is_closed_and_has_the_area_of_six_squares() {
        let [part] = &parts()[..] else { panic!("one part") };
        let mut edges = std::collections::BTreeMap::new();
        let mut area = 0.0;
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|k| part.positions[k as usize]);
            area += (b - a).cross(c - a).length() / 2.0;
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (from, to) = (triangle[from], triangle[to]);
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += 1;
            }
        }
        assert_eq!(area, 6.0);
        assert!(edges.values().all(|count| *count == 2) && edges.len() == 18, "{edges:?}");
    }

    /// From the front, from the right and above, the white corner is nearest.
    #[test]
    fn its_colours_are_those_of_its_places() {
        let (width, height) = (Some(480), Some(480));
        let scene = Scene::open("cube", &Options { width, height, ..Options::default() }).unwrap();
        let mut fragments = vec![];
        let Ok(()) = scene.play(&mut |fragment| {
            fragments.push(fragment);
            Ok::<(), Infallible>(())
        });
        let nearest = fragments.iter().min_by_key(|f| f.z).unwrap().rgba;
        assert!(nearest.to_be_bytes().iter().all(|channel| *channel >= 253), "{nearest:08x}");
        let image = Golden::new(scene.info()).of(&fragments).unwrap().image;
        for (corner, close) in [(0xff_0000, "red"), (0x00_ff00, "green"), (0x00_00ff, "blue")] {
            let off = |pixel: &u32| {
                let channel =
                    |rgb: u32, k: u32| (rgb >> (8 * k) & 0xff).abs_diff(corner >> (8 * k) & 0xff);
                (0..3).map(|k| channel(*pixel, k)).max().unwrap()
            };
            assert!(image.pixels.iter().map(off).min().unwrap() <= 6, "{close}");
        }
    }
}
