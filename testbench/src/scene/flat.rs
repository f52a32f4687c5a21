//! Triangles that lie on the screen, without a camera.

use super::Screen;
use super::clip::Vertex;
use super::order::Order;
use super::shade::Projected;
use super::vary::{Sample, sheared, shift};

/// Triangles as they are given, and as they are drawn.
#[derive(Debug)]
pub(super) struct Flat {
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    info: Screen,
    order: Order,
    /// What is drawn.
    pub projected: Projected,
}

impl Flat {
    /// Triangles by the numbers of their corners, where what varies is at `sample`.
    pub fn new(
        vertices: Vec<Vertex>,
        triangles: Vec<[u32; 3]>,
        info: Screen,
        order: Order,
        sample: &Sample,
    ) -> Flat {
        let moved = sheared(shift(sample.pixel, info));
        let drawn = vertices.iter().map(|vertex| Vertex { clip: moved * vertex.clip, ..*vertex });
        let projected = Projected::new(drawn.collect(), triangles.clone(), info, order);
        Flat { vertices, triangles, info, order, projected }
    }

    /// The same at another sample.
    pub fn sampled(&self, sample: &Sample) -> Flat {
        let (vertices, triangles) = (self.vertices.clone(), self.triangles.clone());
        Flat::new(vertices, triangles, self.info, self.order, sample)
    }
}
