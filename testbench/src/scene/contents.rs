//! What a scene is made of.

use super::camera::Camera;
use super::geometry::Part;
use glam::Vec3;

/// What a scene of meshes is made of, and from where it is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// The camera, given or fitted.
    pub camera: Camera,
    /// Its parts, in the order in which they are drawn.
    pub parts: Vec<PartContents>,
}

/// What a part has.
#[derive(Clone, Debug, PartialEq)]
pub struct PartContents {
    /// Names of the mesh, group and material.
    pub names: Vec<String>,
    /// Vertices, whether a triangle has them or not.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Gaussian splats; they are its vertices.
    pub splats: usize,
    /// The least and the most opacity of a vertex, 0..=1, as rules have it and before light adds to it.
    pub opacity: [f32; 2],
    /// The least and the greatest x, y and z of a vertex; nothing if there is none.
    pub bounds: Option<[[f32; 3]; 2]>,
}

impl Contents {
    pub(super) fn new(camera: Camera, parts: &[Part]) -> Contents {
        Contents { camera, parts: parts.iter().map(PartContents::new).collect() }
    }

    /// The least and the greatest x, y and z of all vertices; nothing if there is none.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let corners = self.parts.iter().filter_map(|part| part.bounds).flatten();
        around(corners.map(Vec3::from))
    }
}

impl PartContents {
    fn new(part: &Part) -> PartContents {
        let alphas = part.colours.iter().map(|colour| colour.w);
        let least_and_most = alphas
            .map(|alpha| [alpha; 2])
            .reduce(|[least, most], [a, b]| [least.min(a), most.max(b)]);
        PartContents {
            names: part.names.clone(),
            vertices: part.positions.len(),
            triangles: part.triangles.len(),
            splats: part.splats.len(),
            opacity: least_and_most.unwrap_or([part.alpha; 2]),
            bounds: around(part.positions.iter().copied()),
        }
    }
}

/// The least and the greatest coordinates of points.
fn around(points: impl Iterator<Item = Vec3>) -> Option<[[f32; 3]; 2]> {
    let ends =
        points.map(|point| [point; 2]).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]);
    ends.map(|ends| ends.map(|end| end.to_array()))
}
