//! glTF 2.0, as text or binary: node transforms, materials with their textures, vertex colours.
//!
//! A part is one primitive at one node, named after the mesh, the node and the material. Alpha counts as the material's
//! alpha mode says; a primitive without a material says nothing of it. Nodes, skins and morph targets are as the first
//! animation has them at the time. Factors and colours of vertices are light in the file, those of images levels (glTF 2.0,
//! 3.9.2).

mod buffers;
mod document;
mod extensions;
mod images;
mod materials;
mod nodes;
mod pose;
mod skin;
mod vertices;

use super::{Found, Reading, bad};
use crate::scene::SceneError;
use crate::scene::geometry::{Part, TRIANGLE_BYTES, VERTEX_BYTES};
use ::gltf::{Node, Primitive, Semantic};
use buffers::Buffers;
use document::parse;
use glam::{Mat3, Mat4, Vec3};
use images::Images;
use nodes::Instances;
use pose::Pose;
use std::io::BufRead;
use vertices::Vertices;

/// Most vertices and indices beyond the bytes of all buffers. Nodes can share a mesh and primitives an accessor, so that a
/// small file could ask for any number.
const MOST_SHARED: usize = 1 << 25;

/// Loads the content of a glTF or GLB file.
pub(super) fn load(file: &mut Reading, bytes: &mut dyn BufRead) -> Result<Vec<Part>, SceneError> {
    let path = file.path;
    let bytes = file.whole(path, bytes)?;
    let (document, blob) = parse(file, &bytes)?;
    let buffers = Buffers::load(file, &document, blob)?;
    let bad = |what: String| bad(path, None, what);
    let pose = Pose::read(file, &document, &buffers)?;
    file.moves = pose.changes;
    let placed = nodes::placed(&document, |node| pose.local(node)).map_err(bad)?;
    let mut to_scene = vec![None; document.nodes().len()];
    placed.iter().for_each(|(node, transform)| to_scene[node.index()] = Some(*transform));

    let mut images = Images::default();
    let mut flat = Found::default();
    let mut parts = Vec::new();
    let mut room = buffers.bytes().saturating_add(MOST_SHARED);
    for (node, transform) in &placed {
        let Some(mesh) = node.mesh() else { continue };
        let in_node = |what: String| bad(format!("node {}: {what}", node.index()));
        let instances = Instances::of(&document, node).map_err(in_node)?;
        let weights = pose.weights(node);
        for (i, primitive) in mesh.primitives().enumerate() {
            let error = |what: String| bad(format!("node {}, primitive {i}: {what}", node.index()));
            take(&mut room, &primitive, instances.count).map_err(error)?;
            let bytes = bytes_of(&primitive).saturating_add(nodes::INSTANCE_BYTES);
            file.take(bytes.saturating_mul(instances.count))?;
            let count = primitive.get(&Semantic::Positions).map_or(0, |accessor| accessor.count());
            let vertices =
                Vertices { primitive: &primitive, buffers: &buffers, count, error: &error };
            let Some(triangles) = vertices.triangles()? else {
                flat.add(format_args!("node {}, primitive {i}", node.index()));
                continue;
            };
            let is_bound = primitive.get(&Semantic::Joints(0)).is_some();
            let transforms = match node.skin().filter(|_| is_bound) {
                Some(skin) => {
                    file.take(count.saturating_mul(skin::BOUND_BYTES))?;
                    let joints = skin::joints(&skin, &buffers, &to_scene).map_err(error)?;
                    Transforms::Each(skin::bound(&vertices, &joints)?)
                }
                None => {
                    let each = instances.transforms(&buffers).map_err(in_node)?;
                    Transforms::Instances(each.iter().map(|each| *transform * *each).collect())
                }
            };
            let mut part =
                part(&vertices, names(node, &primitive), triangles, &weights, &transforms)?;
            materials::dress(file, &mut images, &vertices, &mut part)?;
            parts.push(part);
        }
    }
    file.not_seen(flat.named("primitive of points or lines", "primitives of points or lines"));
    images.tell(file);
    Ok(parts)
}

/// Takes the room of a primitive's instances, their vertices and their indices from what is left.
fn take(room: &mut usize, primitive: &Primitive, instances: usize) -> Result<(), String> {
    let accessors = primitive.get(&Semantic::Positions).into_iter().chain(primitive.indices());
    let wanted = accessors.fold(1, |sum: usize, accessor| sum.saturating_add(accessor.count()));
    *room = room.checked_sub(wanted.saturating_mul(instances)).ok_or_else(|| {
        format!(
            "is one too many, expected at most {MOST_SHARED} vertices and indices that are shared"
        )
    })?;
    Ok(())
}

/// Bytes that a primitive's part takes.
fn bytes_of(primitive: &Primitive) -> usize {
    let vertices = primitive.get(&Semantic::Positions).map_or(0, |accessor| accessor.count());
    let indices = primitive.indices().map_or(vertices, |accessor| accessor.count());
    vertices.saturating_mul(VERTEX_BYTES).saturating_add(indices.saturating_mul(TRIANGLE_BYTES))
}

/// What takes the vertices of a primitive into the scene.
enum Transforms {
    /// All of them together, once by each.
    Instances(Vec<Mat4>),
    /// Each by its own.
    Each(Vec<Mat4>),
}

/// The names of a primitive's part.
fn names(node: &Node, primitive: &Primitive) -> Vec<String> {
    let material = primitive.material();
    let names = [node.mesh().and_then(|mesh| mesh.name()), node.name(), material.name()];
    names.into_iter().flatten().map(str::to_owned).collect()
}

/// A primitive's triangles in scene coordinates.
fn part(
    vertices: &Vertices,
    names: Vec<String>,
    triangles: Vec<[u32; 3]>,
    weights: &[f32],
    transforms: &Transforms,
) -> Result<Part, SceneError> {
    let missing = || (vertices.error)("has no attribute POSITION".into());
    let vectors = |vectors: Vec<[f32; 3]>| vectors.into_iter().map(Vec3::from).collect::<Vec<_>>();
    let positions = vertices.attribute::<3>(Semantic::Positions)?.ok_or_else(missing)?;
    let mut positions = vectors(positions);
    let mut normals = vectors(vertices.attribute::<3>(Semantic::Normals)?.unwrap_or_default());
    skin::morph(vertices, weights, &mut positions, &mut normals)?;

    let mut part = Part::new(names);
    let to_normals = |transform: &Mat4| Mat3::from_mat4(*transform).inverse().transpose();
    match transforms {
        Transforms::Instances(transforms) => {
            for (i, transform) in transforms.iter().enumerate() {
                let first = (i * vertices.count) as u32;
                part.triangles.extend(triangles.iter().map(|corners| corners.map(|c| first + c)));
                part.positions.extend(positions.iter().map(|p| transform.transform_point3(*p)));
                let to_normals = to_normals(transform);
                part.normals.extend(normals.iter().map(|normal| to_normals * *normal));
            }
        }
        Transforms::Each(transforms) => {
            part.triangles = triangles;
            let moved = positions.iter().zip(transforms);
            part.positions = moved.map(|(p, transform)| transform.transform_point3(*p)).collect();
            let turned = normals.iter().zip(transforms);
            part.normals = turned.map(|(n, transform)| to_normals(transform) * *n).collect();
        }
    }
    match part.positions.iter().position(|position| !position.is_finite()) {
        Some(i) => Err((vertices.error)(format!("vertex {} is not finite", i % vertices.count))),
        None => Ok(part),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::room::Room;

    #[test]
    fn room_is_taken_until_there_is_none() {
        let json = br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                          "min":[0,0,0],"max":[0,0,0]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":0}]}]}"#;
        let (document, _) = parse(&mut Reading::new("a.gltf", Room::new(None)), json).unwrap();
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        let mut room = 13;
        take(&mut room, &primitive, 1).unwrap();
        assert_eq!(room, 6, "itself, three vertices and three indices are taken");
        assert_eq!(
            take(&mut room, &primitive, 1).unwrap_err(),
            "is one too many, expected at most 33554432 vertices and indices that are shared"
        );
    }

    #[test]
    fn buffers_in_the_same_file_share_its_content() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        let json = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.gltf","byteLength":9},
            {"uri":"./a.gltf","byteLength":42},{"uri":"data:;base64,AAAA","byteLength":3}]}"#;
        std::fs::write(&path, json).unwrap();
        let (document, _) =
            parse(&mut Reading::new("a.gltf", Room::new(None)), json.as_bytes()).unwrap();
        let mut file = Reading::new(path.to_str().unwrap(), Room::new(None));
        let buffers = Buffers::load(&mut file, &document, None).unwrap();
        assert_eq!(buffers.bytes(), json.len() + 3);
    }
}
