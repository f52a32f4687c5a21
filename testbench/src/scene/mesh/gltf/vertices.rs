//! The vertices of a primitive as its attributes give them.

use super::buffers::Buffers;
use crate::scene::SceneError;
use ::gltf::mesh::Mode;
use ::gltf::{Accessor, Primitive, Semantic};

/// The index that starts a strip or fan anew, here for indices of any size.
const RESTART: u32 = u32::MAX;

/// A primitive's vertices, and how to say what is wrong with them.
pub(super) struct Vertices<'a> {
    pub primitive: &'a Primitive<'a>,
    pub buffers: &'a Buffers,
    /// Vertices of one instance.
    pub count: usize,
    pub error: &'a dyn Fn(String) -> SceneError,
}

impl Vertices<'_> {
    /// An attribute of each vertex, if the primitive has it.
    pub fn attribute<const N: usize>(
        &self,
        semantic: Semantic,
    ) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        let Some(accessor) = self.primitive.get(&semantic) else { return Ok(None) };
        self.values(&semantic.to_string(), &accessor).map(Some)
    }

    /// The values of an accessor, one for each vertex.
    pub fn values<const N: usize>(
        &self,
        kind: &str,
        accessor: &Accessor,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let (found, expected) = (accessor.count(), self.count);
        if found != expected {
            let what = format!("has {found} of the attribute {kind}, expected {expected}");
            return Err((self.error)(what));
        }
        self.buffers.vectors(accessor, found).map_err(self.error)
    }

    /// Corners of the triangles; none if the primitive is made of points or lines.
    pub fn triangles(&self) -> Result<Option<Vec<[u32; 3]>>, SceneError> {
        let mode = self.primitive.mode();
        let indices = match self.primitive.indices() {
            Some(accessor) => {
                let mut indices = self.buffers.indices(&accessor).map_err(self.error)?;
                let last = u32::MAX >> (32 - 8 * accessor.data_type().size());
                if mode != Mode::Triangles {
                    indices.iter_mut().filter(|i| **i == last).for_each(|index| *index = RESTART);
                }
                indices
            }
            None => (0..self.count as u32).collect(),
        };
        let Some(triangles) = triangles(mode, &indices) else { return Ok(None) };
        match triangles.as_flattened().iter().find(|&&index| index as usize >= self.count) {
            None => Ok(Some(triangles)),
            Some(index) => {
                let what =
                    format!("has the vertex index {index}, expected one below {}", self.count);
                Err((self.error)(what))
            }
        }
    }
}

/// The triangles of a list, or of strips or fans between [`RESTART`]s, all wound alike.
fn triangles(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    let runs = || indices.split(|&index| index == RESTART);
    match mode {
        Mode::Triangles => Some(indices.as_chunks().0.to_vec()),
        Mode::TriangleStrip => {
            let wound = |(i, w): (usize, &[u32])| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[0], w[2], w[1]],
            };
            Some(runs().flat_map(|run| run.windows(3).enumerate().map(wound)).collect())
        }
        Mode::TriangleFan => {
            let fan = |run: &[u32]| match run {
                [first, rest @ ..] => rest.windows(2).map(|w| [*first, w[0], w[1]]).collect(),
                [] => vec![],
            };
            Some(runs().flat_map(fan).collect())
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_strips_and_fans_become_triangles() {
        let indices = [4, 5, 6, 7];
        assert_eq!(triangles(Mode::Triangles, &indices[..3]), Some(vec![[4, 5, 6]]));
        // glTF 2.0, 3.7.2.1: every second triangle of a strip has its last two corners exchanged.
        assert_eq!(triangles(Mode::TriangleStrip, &indices), Some(vec![[4, 5, 6], [5, 7, 6]]));
        assert_eq!(triangles(Mode::TriangleFan, &indices), Some(vec![[4, 5, 6], [4, 6, 7]]));
        assert_eq!(triangles(Mode::TriangleFan, &[]), Some(vec![]));
        assert_eq!(triangles(Mode::LineStrip, &indices), None);
    }

    #[test]
    fn a_restart_begins_a_strip_or_fan_anew() {
        let indices = [0, 1, 2, 3, RESTART, 4, RESTART, RESTART, 5, 6, 7, 8];
        assert_eq!(
            triangles(Mode::TriangleStrip, &indices),
            Some(vec![[0, 1, 2], [1, 3, 2], [5, 6, 7], [6, 8, 7]])
        );
        assert_eq!(
            triangles(Mode::TriangleFan, &indices),
            Some(vec![[0, 1, 2], [0, 2, 3], [5, 6, 7], [5, 7, 8]])
        );
    }
}
