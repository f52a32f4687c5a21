//! The pose of the nodes at one time of a file's first animation.

mod curve;

use super::super::Reading;
use super::buffers::Buffers;
use crate::scene::SceneError;
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
pub(super) struct Pose {
    /// By the number of the node.
    moved: HashMap<usize, Moved>,
    /// Whether there is another at another time.
    pub changes: bool,
}

impl Pose {
    /// The pose of the first animation at the time of the file, which starts again at its end; as the nodes themselves say
    /// where there is none.
    pub fn read(
        file: &mut Reading,
        document: &Document,
        buffers: &Buffers,
    ) -> Result<Pose, SceneError> {
        let mut animations = document.animations();
        let animation = animations.next();
        if let more @ 1.. = animations.len() {
            file.note(format!("has {} animations, of which the first is seen", more + 1));
        }
        let channels = animation.iter().flat_map(|animation| animation.channels());
        let curves = channels.map(|channel| {
            file.take(Curve::bytes(&channel))?;
            let node = channel.target().node().index();
            let curve = Curve::read(&channel, buffers);
            let bad = |what| file.bad(None, format!("animation 0, node {node}: {what}"));
            Ok((node, channel.target().property(), curve.map_err(bad)?))
        });
        let curves = curves.collect::<Result<Vec<_>, SceneError>>()?;
        let end = curves.iter().map(|(_, _, curve)| curve.end()).fold(0.0, f32::max);
        let seconds = if end > 0.0 { file.seconds % end } else { 0.0 };
        let mut pose = Pose { moved: HashMap::new(), changes: end > 0.0 };
        for (node, property, curve) in curves {
            let moved = pose.moved.entry(node).or_default();
            match property {
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
        let Some(moved) = self.moved.get(&node.index()) else {
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
        let moved = self.moved.get(&node.index()).and_then(|moved| moved.weights.clone());
        let own = || node.weights().map(<[f32]>::to_vec);
        let of_mesh = || node.mesh().and_then(|mesh| mesh.weights().map(<[f32]>::to_vec));
        moved.or_else(own).or_else(of_mesh).unwrap_or_default()
    }
}
