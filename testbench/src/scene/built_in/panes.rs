//! The example of the image composition paper (seed 001, its figure 7): seven panes one behind the other, of which the
//! first, the third and the last are transparent.
//!
//! A is yellow and transparent, B blue, C red and transparent, D blue, E yellow, F black, G green and transparent; A is
//! nearest. B hides all that lies behind it, C and G too. So where all seven meet, in the middle, yellow is blended over
//! blue: green. The panes are shifted against each other, so that each can be seen somewhere, and they come in the order
//! in which the paper says that a machine without order independence goes wrong: C, A, B, and then the others.

use crate::scene::clip::Vertex;
use glam::{DVec4, Vec4};

/// Background, `0xRRGGBB`.
pub(in crate::scene) const BACKGROUND: u32 = 0xd8d8d8;

/// Alpha of the transparent ones, of 255.
const TRANSPARENT: f32 = 128.0;
const OPAQUE: f32 = 255.0;
/// Half the side of a pane, in half sides of the screen.
const HALF: f64 = 0.58;
/// How far a pane is shifted against the one before it.
const SHIFT: f64 = 0.12;

/// Red, green, blue and alpha of panes A to G.
const PANES: [[f32; 4]; 7] = [
    [255.0, 255.0, 0.0, TRANSPARENT],
    [0.0, 0.0, 255.0, OPAQUE],
    [255.0, 0.0, 0.0, TRANSPARENT],
    [0.0, 0.0, 255.0, OPAQUE],
    [255.0, 255.0, 0.0, OPAQUE],
    [0.0, 0.0, 0.0, OPAQUE],
    [0.0, 255.0, 0.0, TRANSPARENT],
];

/// In which order they come.
const ORDER: [usize; 7] = [2, 0, 1, 3, 4, 5, 6];

/// Corners and triangles, two for each pane.
pub(in crate::scene) fn triangles() -> (Vec<Vertex>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (vec![], vec![]);
    for (n, pane) in ORDER.into_iter().enumerate() {
        let shift = (pane as f64 - 3.0) * SHIFT;
        let depth = (pane as f64 + 1.0) / 8.0;
        let colour = Vec4::from(PANES[pane]);
        vertices.extend(
            [(-HALF, -HALF), (HALF, -HALF), (-HALF, HALF), (HALF, HALF)].map(|(x, y)| Vertex {
                clip: DVec4::new(x + shift, y + shift, depth, 1.0),
                colour,
            }),
        );
        let first = 4 * n as u32;
        triangles.extend([[0, 1, 2], [1, 3, 2]].map(|corners| corners.map(|k| first + k)));
    }
    (vertices, triangles)
}
