//! Vertices that follow more than their node: skins and morph targets.

use super::buffers::Buffers;
use super::vertices::Vertices;
use crate::scene::SceneError;
use ::gltf::{Node, Semantic, Skin};
use glam::{Mat4, Vec3};

/// Bytes that the joints and weights of a vertex take, and where these take it.
pub(super) const BOUND_BYTES: usize = size_of::<[[f32; 4]; 2]>() + size_of::<Mat4>();

/// What takes a vertex that is bound to a joint into the scene, for each joint.
pub(super) fn joints(
    skin: &Skin,
    buffers: &Buffers,
    to_scene: &[Option<Mat4>],
) -> Result<Vec<Mat4>, String> {
    let count = skin.joints().count();
    let inverse = match skin.inverse_bind_matrices() {
        Some(accessor) => {
            let matrices = buffers.vectors::<16>(&accessor, count)?;
            matrices.iter().map(Mat4::from_cols_array).collect()
        }
        None => vec![Mat4::IDENTITY; count],
    };
    let joint = |(node, inverse): (Node, Mat4)| match to_scene[node.index()] {
        Some(to_scene) => Ok(to_scene * inverse),
        None => Err(format!("its joint, node {}, is not in the scene", node.index())),
    };
    skin.joints().zip(inverse).map(joint).collect()
}

/// What takes each vertex into the scene: the mean of its joints by their weights, or the first joint where it has none.
pub(super) fn bound(vertices: &Vertices, joints: &[Mat4]) -> Result<Vec<Mat4>, SceneError> {
    let mut sums = vec![(Mat4::ZERO, 0.0); vertices.count];
    for set in 0.. {
        let numbers = vertices.attribute::<4>(Semantic::Joints(set))?;
        let Some(numbers) = numbers else { break };
        let weights = vertices.attribute::<4>(Semantic::Weights(set))?;
        let missing = || (vertices.error)(format!("has no attribute WEIGHTS_{set}"));
        let weights = weights.ok_or_else(missing)?;
        for ((sum, numbers), weights) in sums.iter_mut().zip(&numbers).zip(&weights) {
            for (number, weight) in
                numbers.iter().zip(weights).filter(|(_, weight)| **weight != 0.0)
            {
                let Some(joint) = joints.get(*number as usize) else {
                    let (found, count) = (*number, joints.len());
                    return Err((vertices.error)(format!(
                        "has the joint {found}, expected one below {count}"
                    )));
                };
                *sum = (sum.0 + *joint * *weight, sum.1 + weight);
            }
        }
    }
    let first = joints.first().copied().unwrap_or(Mat4::IDENTITY);
    let mean = |(sum, total): (Mat4, f32)| if total == 0.0 { first } else { sum * (1.0 / total) };
    Ok(sums.into_iter().map(mean).collect())
}

/// Adds the morph targets by their weights to positions and normals.
pub(super) fn morph(
    vertices: &Vertices,
    weights: &[f32],
    positions: &mut [Vec3],
    normals: &mut [Vec3],
) -> Result<(), SceneError> {
    let targets = vertices.primitive.morph_targets().zip(weights);
    for (target, weight) in targets.filter(|(_, weight)| **weight != 0.0) {
        let moved = [
            (target.positions(), "POSITION", &mut *positions),
            (target.normals(), "NORMAL", &mut *normals),
        ];
        for (accessor, name, values) in moved {
            let Some(accessor) = accessor.filter(|_| !values.is_empty()) else { continue };
            let ways = vertices.values::<3>(&format!("{name} of a morph target"), &accessor)?;
            values
                .iter_mut()
                .zip(ways)
                .for_each(|(value, way)| *value += *weight * Vec3::from(way));
        }
    }
    Ok(())
}
