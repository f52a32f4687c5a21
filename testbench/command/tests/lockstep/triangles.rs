//! A frame that exercises what a frame of fine meshes hardly does: walks along long edges of every slope, also through the
//! middles of pixels, colours, alphas and depths that change across a triangle, depths that are equal, pixels many layers
//! deep, and none without a layer.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;
use tempfile::NamedTempFile;

/// Straight at the triangles, so that what is level in them is level on the screen.
pub const CAMERA: &str = "0,0,3:0,0,0:40";

/// A pixel's side at the distance of what it looks at, on a screen of 18 rows: 2 * 3 * tan(40 degrees / 2) / 18.
const PIXEL: f64 = 0.121_323_4;

/// Triangles of a frame that is played in an event-driven simulator.
pub const FEW: u32 = 48;
/// Of a frame by which every operator is judged.
pub const MANY: u32 = 112;

/// A file with so many triangles.
pub fn scene(count: u32) -> NamedTempFile {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut random = |most: f64| rng.random_range(-most..most);
    let mut corners = [[0.0; 3]; 3];
    let mut vertices = String::new();
    for k in 0..count {
        let mut anywhere = |size: f64| [random(1.4 * size), random(1.1 * size), random(0.5 * size)];
        let middle = anywhere(0.8);
        let near = |offset: [f64; 3]| std::array::from_fn(|axis| middle[axis] + offset[axis]);
        match k % 16 {
            // All of the screen.
            0 => corners = [[-9.0, -9.0, -0.6], [9.0, -9.0, -0.6], [0.0, 9.0, -0.6]],
            1 | 3 | 4 => corners = [(); 3].map(|()| anywhere(1.0)),
            // Two edges along rows and columns.
            6 | 7 => {
                let [x, y, _] = anywhere(0.6);
                corners = [[0.0; 3], [x, 0.0, 0.0], [0.0, y, 0.0]].map(near);
            }
            8 => corners = [(); 3].map(|()| near(anywhere(0.2))),
            // Edges that go through the middles of pixels, and what is as deep.
            9 | 10 | 11 | 14 | 15 => {
                corners = [(); 3].map(|()| {
                    let [x, y] = [11.0, 8.0].map(|most| random(most).round() + 0.5);
                    [x * PIXEL, y * PIXEL, 0.0]
                });
            }
            // As deep as the one before it in every pixel.
            _ => {}
        }
        // Of the opaque ones some lie behind all, and the others hide a part of what came before them.
        let back = if [1, 2].contains(&(k % 16)) { 0.7 } else { 0.0 };
        let opaque = [1, 2, 5, 12].contains(&(k % 16)) || k % 32 == 0;
        let mut colour = [0; 4];
        for (corner, [x, y, z]) in corners.into_iter().enumerate() {
            // Of one colour it is one primitive, however deep it goes.
            if corner == 0 || !matches!(k % 16, 3 | 6 | 8) {
                colour = [(); 4].map(|()| (128.0 + random(127.9)) as u8);
            }
            let [red, green, blue, alpha] = colour;
            let (z, alpha) = (z - back, if opaque { 255 } else { alpha });
            writeln!(vertices, "{x:.4} {y:.4} {z:.4} {red} {green} {blue} {alpha}").unwrap();
        }
    }
    let mut text = String::from("ply\nformat ascii 1.0\n");
    writeln!(text, "element vertex {}", 3 * count).unwrap();
    for property in ["float x", "float y", "float z"] {
        writeln!(text, "property {property}").unwrap();
    }
    for colour in ["red", "green", "blue", "alpha"] {
        writeln!(text, "property uchar {colour}").unwrap();
    }
    writeln!(text, "element face {count}").unwrap();
    text += "property list uchar int vertex_indices\nend_header\n";
    text += &vertices;
    for k in 0..count {
        writeln!(text, "3 {} {} {}", 3 * k, 3 * k + 1, 3 * k + 2).unwrap();
    }
    let file = tempfile::Builder::new().suffix(".ply").tempfile().unwrap();
    std::fs::write(file.path(), text).unwrap();
    file
}
