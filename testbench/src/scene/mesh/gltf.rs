//! glTF 2.0, as text or binary: node transforms, materials with their textures, vertex colours.
//!
//! A part is one primitive at one node, named after the mesh, the node and the material. Alpha counts as the material's
//! alpha mode says; a primitive without a material says nothing of it. Skins and morph targets are not looked at. Factors
//! and colours of vertices are light in the file, those of images levels (glTF 2.0, 3.9.2).

mod buffers;
mod extensions;
mod images;
mod materials;

use super::{Reading, bad};
use crate::scene::SceneError;
use crate::scene::geometry::{Part, TRIANGLE_BYTES, VERTEX_BYTES};
use ::gltf::json::validation::Checked;
use ::gltf::mesh::Mode;
use ::gltf::{Document, Gltf, Node, Primitive, Semantic};
use buffers::Buffers;
use glam::{Mat3, Mat4, Vec3};
use images::Images;
use materials::Vertices;
use std::io::BufRead;

/// Size of a GLB's header.
const GLB_HEADER_BYTES: u8 = 12;
/// Most vertices and indices beyond the bytes of all buffers. Nodes can share a mesh and primitives an accessor, so that a
/// small file could ask for any number.
const MOST_SHARED: usize = 1 << 25;

/// Loads the content of a glTF or GLB file.
pub(super) fn load(file: &mut Reading, bytes: &mut dyn BufRead) -> Result<Vec<Part>, SceneError> {
    let path = file.path;
    let bytes = file.whole(path, bytes)?;
    let (document, blob) = parse(file, &bytes)?;
    let mut images = Images::default();
    let buffers = Buffers::load(file, &document, blob)?;
    let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
        return Err(bad(path, None, "has no scene"));
    };
    let mut parts = Vec::new();
    let mut to_visit: Vec<(Node, Mat4)> =
        scene.nodes().map(|node| (node, Mat4::IDENTITY)).collect();
    to_visit.reverse();
    let mut visited = vec![false; document.nodes().count()];
    let mut room = buffers.bytes().saturating_add(MOST_SHARED);
    while let Some((node, above)) = to_visit.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(bad(
                path,
                None,
                format!("node {} has two parents, expected a tree", node.index()),
            ));
        }
        let transform = above * Mat4::from_cols_array_2d(&node.transform().matrix());
        for (i, primitive) in node.mesh().iter().flat_map(|mesh| mesh.primitives()).enumerate() {
            let error = |what: String| {
                bad(path, None, format!("node {}, primitive {i}: {what}", node.index()))
            };
            take(&mut room, &primitive).map_err(error)?;
            file.take(bytes_of(&primitive))?;
            let part = part(&node, &primitive, transform, &buffers).map_err(error)?;
            let Some(mut part) = part else { continue };
            let count = part.positions.len();
            let vertices =
                Vertices { primitive: &primitive, buffers: &buffers, count, error: &error };
            materials::dress(file, &mut images, &vertices, &mut part)?;
            parts.push(part);
        }
        let first_child = to_visit.len();
        to_visit.extend(node.children().map(|child| (child, transform)));
        to_visit[first_child..].reverse();
    }
    images.tell(file);
    Ok(parts)
}

/// The document, with every index in it checked, and a GLB's binary part.
fn parse(file: &mut Reading, bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), SceneError> {
    let path = file.path;
    let invalid = |error: ::gltf::Error| {
        if is_version_1(bytes) {
            return bad(path, None, "is glTF 1.0, expected glTF 2.0");
        }
        let what = match &error {
            ::gltf::Error::Validation(faults) if !faults.is_empty() => {
                let (place, fault) = &faults[0];
                let more = match faults.len() - 1 {
                    0 => String::new(),
                    more => format!(", and {more} more like it"),
                };
                format!("{place}: {fault}{more}")
            }
            _ => error.to_string(),
        };
        bad(path, None, format!("expected glTF 2.0: {what}"))
    };
    // Two checks that the library takes for granted: a GLB is as long as its header, and positions exist.
    let length = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..8));
    if length.is_some_and(|bytes| bytes[0] < GLB_HEADER_BYTES && bytes[1..] == [0; 3]) {
        return Err(bad(path, None, "the length in the GLB's header is less than the header's"));
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let mut json = document.into_json();
    extensions::check(file, &mut json)?;
    // An application's own attributes are no concern of the picture.
    for primitive in json.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.attributes.retain(|name, _| matches!(name, Checked::Valid(_)));
    }
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for accessor in primitives.flat_map(|primitive| primitive.attributes.values()) {
        let (index, count) = (accessor.value(), json.accessors.len());
        if index >= count {
            return Err(bad(
                path,
                None,
                format!("has the accessor index {index}, expected one below {count}"),
            ));
        }
    }
    // Bounds of positions are asked for by the library, often left out, and of no use here.
    let positions: Vec<usize> = json
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.primitives)
        .filter_map(|primitive| primitive.attributes.get(&Checked::Valid(Semantic::Positions)))
        .map(|accessor| accessor.value())
        .collect();
    for accessor in positions {
        let accessor = &mut json.accessors[accessor];
        accessor.min = Some(vec![0.0f32; 3].into());
        accessor.max = accessor.min.clone();
    }
    Ok((Document::from_json(json).map_err(invalid)?, blob))
}

/// Whether the file is of the version before, which is another format.
fn is_version_1(bytes: &[u8]) -> bool {
    let version = |json: serde_json::Value| {
        let version = &json["asset"]["version"];
        version.as_str().is_some_and(|version| version.starts_with("1."))
    };
    match bytes.strip_prefix(b"glTF") {
        Some(rest) => rest.get(..4) == Some(&1u32.to_le_bytes()),
        None => serde_json::from_slice(bytes).is_ok_and(version),
    }
}

/// Takes the room of a primitive, its vertices and its indices from what is left.
fn take(room: &mut usize, primitive: &Primitive) -> Result<(), String> {
    let accessors = primitive.get(&Semantic::Positions).into_iter().chain(primitive.indices());
    let wanted = accessors.fold(1, |sum: usize, accessor| sum.saturating_add(accessor.count()));
    *room = room.checked_sub(wanted).ok_or_else(|| {
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

/// A primitive's triangles in scene coordinates; none if it is made of points or lines.
fn part(
    node: &Node,
    primitive: &Primitive,
    transform: Mat4,
    buffers: &Buffers,
) -> Result<Option<Part>, String> {
    let positions = primitive.get(&Semantic::Positions).ok_or("has no attribute POSITION")?;
    let positions = buffers.vectors::<3>(&positions)?;
    let count = positions.len();
    let indices = match primitive.indices() {
        Some(accessor) => buffers.indices(&accessor)?,
        None => (0..count as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|&&index| index as usize >= count) {
        return Err(format!("has the vertex index {index}, expected one below {count}"));
    }
    let Some(triangles) = triangles(primitive.mode(), &indices) else {
        return Ok(None);
    };

    let names = [
        node.mesh().and_then(|mesh| mesh.name().map(str::to_owned)),
        node.name().map(str::to_owned),
    ];
    let mut part = Part::new(
        names.into_iter().flatten().chain(primitive.material().name().map(str::to_owned)).collect(),
    );
    part.triangles = triangles;
    part.positions = positions.into_iter().map(|p| transform.transform_point3(p.into())).collect();
    if let Some(i) = part.positions.iter().position(|position| !position.is_finite()) {
        return Err(format!("vertex {i} is not finite"));
    }
    let same_count = |kind: &str, found: usize| match found == count {
        true => Ok(()),
        false => Err(format!("has {found} of the attribute {kind}, expected {count}")),
    };
    if let Some(accessor) = primitive.get(&Semantic::Normals) {
        let to_scene = Mat3::from_mat4(transform).inverse().transpose();
        part.normals = buffers
            .vectors::<3>(&accessor)?
            .into_iter()
            .map(|n| to_scene * Vec3::from(n))
            .collect();
        same_count("NORMAL", part.normals.len())?;
    }

    Ok(Some(part))
}

fn triangles(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    match mode {
        Mode::Triangles => Some(indices.as_chunks().0.to_vec()),
        Mode::TriangleStrip => Some(indices.windows(3).map(|w| [w[0], w[1], w[2]]).collect()),
        Mode::TriangleFan => {
            let first = indices.first().copied().unwrap_or_default();
            Some(
                indices
                    .get(1..)
                    .unwrap_or_default()
                    .windows(2)
                    .map(|w| [first, w[0], w[1]])
                    .collect(),
            )
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
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
        take(&mut room, &primitive).unwrap();
        assert_eq!(room, 6, "itself, three vertices and three indices are taken");
        assert_eq!(
            take(&mut room, &primitive).unwrap_err(),
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

    #[test]
    fn strips_and_fans_become_triangles() {
        let indices = [4, 5, 6, 7];
        assert_eq!(triangles(Mode::Triangles, &indices[..3]), Some(vec![[4, 5, 6]]));
        assert_eq!(triangles(Mode::TriangleStrip, &indices), Some(vec![[4, 5, 6], [5, 6, 7]]));
        assert_eq!(triangles(Mode::TriangleFan, &indices), Some(vec![[4, 5, 6], [4, 6, 7]]));
        assert_eq!(triangles(Mode::TriangleFan, &[]), Some(vec![]));
        assert_eq!(triangles(Mode::LineStrip, &indices), None);
    }
}
