//! The pose of the nodes at one time of a file's first animation.

mod curve;

use super::buffers::Buffers;
use ::gltf::animation::Property;
use ::gltf::{Document, Node};
use curve::Curve;
use glam::{Mat4, Quat, Vec3};
use std::collections::HashMap;

/// What an animation says of a node.
#[derive(Default)]
struct Moved {
    translation: Option<Vec3>,
    rotation: Option<Quat>,
    scale: Option<Vec3>,
    weights: Option<Vec<f32>>,
}

/// See the module's description.
#[derive(Default)]
pub(super) struct Pose(HashMap<usize, Moved>);

impl Pose {
    /// The pose at a time in seconds of the first animation; as the nodes themselves say where there is none.
    pub fn at(document: &Document, buffers: &Buffers, seconds: f32) -> Result<Pose, String> {
        let mut pose = Pose::default();
        for channel in document.animations().next().iter().flat_map(|first| first.channels()) {
            let node = channel.target().node().index();
            let curve = Curve::read(&channel, buffers);
            let curve = curve.map_err(|what| format!("animation 0, node {node}: {what}"))?;
            let moved = pose.0.entry(node).or_default();
            match channel.target().property() {
                Property::Translation => {
                    moved.translation = Some(Vec3::from_slice(&curve.at(seconds)))
                }
                Property::Scale => moved.scale = Some(Vec3::from_slice(&curve.at(seconds))),
                Property::Rotation => moved.rotation = Some(curve.rotation(seconds)),
                Property::MorphTargetWeights => moved.weights = Some(curve.at(seconds)),
            }
        }
        Ok(pose)
    }

    /// What takes a node into that above it.
    pub fn local(&self, node: &Node) -> Mat4 {
        let Some(moved) = self.0.get(&node.index()) else {
            return Mat4::from_cols_array_2d(&node.transform().matrix());
        };
        let (translation, rotation, scale) = node.transform().decomposed();
        Mat4::from_scale_rotation_translation(
            moved.scale.unwrap_or(scale.into()),
            moved.rotation.unwrap_or(Quat::from_array(rotation)),
            moved.translation.unwrap_or(translation.into()),
        )
    }

    /// Weights of the morph targets of a node's mesh.
    pub fn weights(&self, node: &Node) -> Vec<f32> {
        let moved = self.0.get(&node.index()).and_then(|moved| moved.weights.clone());
        let own = || node.weights().map(<[f32]>::to_vec);
        let of_mesh = || node.mesh().and_then(|mesh| mesh.weights().map(<[f32]>::to_vec));
        moved.or_else(own).or_else(of_mesh).unwrap_or_default()
    }
}
