//! Triangles as a loader or a builder hands them over: parts with names, before any lighting.

use super::paint::Paint;
use glam::{DVec3, Mat3, Vec3, Vec4};
use std::fmt;
use std::sync::Arc;

/// Opacity of a mesh that states none.
pub(super) const DEFAULT_ALPHA: f32 = 0.5;

/// Bytes that a vertex takes: itself, and what lighting makes of it.
pub(super) const VERTEX_BYTES: usize = 136;
/// Bytes that a triangle takes: itself, and as it is drawn.
pub(super) const TRIANGLE_BYTES: usize = 24;

/// What a material says of alpha (glTF 2.0, 3.9.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is passed over.
    Opaque,
    /// What has less alpha than this is not there, all else is opaque.
    Mask(f32),
    /// Alpha counts.
    Blend,
}

impl fmt::Display for AlphaMode {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            AlphaMode::Opaque => f.write_str("OPAQUE"),
            AlphaMode::Mask(cutoff) => write!(f, "MASK {cutoff}"),
            AlphaMode::Blend => f.write_str("BLEND"),
        }
    }
}

/// Triangles that share their names and look.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Names of the mesh, group and material, by which an alpha rule finds the part.
    pub names: Vec<String>,
    /// What its material is called, if it has one that is known.
    pub material: Option<String>,
    /// The alpha mode of its material, in a format that has such.
    pub alpha_mode: Option<AlphaMode>,
    /// Vertex positions, all finite.
    pub positions: Vec<Vec3>,
    /// One normal for each vertex, of any length, or empty to have them made.
    pub normals: Vec<Vec3>,
    /// One colour with alpha for each vertex, 0..=1, or empty for a colour by the normal.
    pub colours: Vec<Vec4>,
    /// Opacity, 0..=1, where there are no colours.
    pub alpha: f32,
    /// Strength of the highlight, 0 none.
    pub gloss: f32,
    /// How much more opaque the part is where it is seen edge-on, 0 not at all.
    pub rim: f32,
    /// Whether the colours are drawn as they are, without light.
    pub unlit: bool,
    /// Whether machines that take primitives are sent all triangles, those without a pixel too.
    pub sent_whole: bool,
    /// What gives the fragments their colours instead of `colours`, where there are textures or a cutoff of alpha.
    pub paint: Option<Arc<Paint>>,
    /// Vertices of each triangle, all in range.
    pub triangles: Vec<[u32; 3]>,
    /// The covariance of the splat at each vertex, all finite, or empty if the vertices are those of triangles. Splats
    /// have colours and are not lit.
    pub splats: Vec<Mat3>,
}

impl Part {
    /// An empty part without colour, of the default opacity.
    pub fn new(names: Vec<String>) -> Part {
        Part { names, alpha: DEFAULT_ALPHA, ..Part::default() }
    }

    /// Gives every vertex one colour.
    pub fn painted(mut self, colour: Vec4) -> Part {
        self.colours = vec![colour; self.positions.len()];
        self
    }

    /// Makes the part equally opaque all over, but where a cutoff leaves nothing of it.
    pub fn set_alpha(&mut self, alpha: f32) {
        if let Some(paint) = &mut self.paint {
            Arc::make_mut(paint).alpha = Some(alpha);
            return;
        }
        self.alpha = alpha;
        self.rim = 0.0;
        self.colours.iter_mut().for_each(|colour| colour.w = alpha);
    }

    /// The stated normals, or the mean of the adjoining triangles' normals weighted by area, all of length 1.
    pub fn unit_normals(&self) -> Vec<Vec3> {
        let unit = |normal: DVec3| normal.try_normalize().unwrap_or(DVec3::Y).as_vec3();
        if !self.normals.is_empty() {
            return self.normals.iter().map(|normal| unit(normal.as_dvec3())).collect();
        }
        // In f64 the product of two edges neither overflows nor vanishes, whatever the mesh's unit.
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|i| self.positions[i as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            corners.iter().for_each(|&i| sums[i as usize] += normal);
        }
        sums.into_iter().map(unit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_normals_are_those_of_the_triangles() {
        let mut part = Part::new(vec![]);
        part.positions = vec![Vec3::ZERO, Vec3::X * 1e-20, Vec3::Y * 1e-20, Vec3::ZERO];
        part.triangles = vec![[0, 1, 2], [0, 3, 0]];
        assert_eq!(part.unit_normals(), [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y]);
    }
}
