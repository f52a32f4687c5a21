//! glTF 2.0, as text or binary: node transforms, base colour factors, vertex colours.
//!
//! A part is one primitive at one node, named after the mesh, the node and the material. The base colour's alpha counts
//! whatever the material's alpha mode says, since what is transparent is the point here. Textures, skins and morph
//! targets are not looked at. Colours are linear in the file and come out gamma-encoded.

mod buffers;

use super::{Reading, bad};
use crate::scene::SceneError;
use crate::scene::geometry::{DEFAULT_ALPHA, Part, TRIANGLE_BYTES, VERTEX_BYTES};
use ::gltf::mesh::Mode;
use ::gltf::{Document, Gltf, Node, Primitive, Semantic};
use buffers::Buffers;
use glam::{Mat3, Mat4, Vec3, Vec4};
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
    let (document, blob) = parse(path, &bytes)?;
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
            let bad =
                |what| bad(path, None, format!("node {}, primitive {i}: {what}", node.index()));
            take(&mut room, &primitive).map_err(bad)?;
            file.take(bytes_of(&primitive))?;
            if primitive.material().index().is_none() {
                file.has_no_opacity();
            }
            parts.extend(part(&node, &primitive, transform, &buffers).map_err(bad)?);
        }
        let first_child = to_visit.len();
        to_visit.extend(node.children().map(|child| (child, transform)));
        to_visit[first_child..].reverse();
    }
    Ok(parts)
}

/// The document, with every index in it checked, and a GLB's binary part.
fn parse(path: &str, bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), SceneError> {
    let invalid = |error: ::gltf::Error| bad(path, None, format!("expected glTF 2.0: {error}"));
    // Two checks that the library takes for granted: a GLB is as long as its header, and positions exist.
    let length = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..8));
    if length.is_some_and(|bytes| bytes[0] < GLB_HEADER_BYTES && bytes[1..] == [0; 3]) {
        return Err(bad(path, None, "the length in the GLB's header is less than the header's"));
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let json = document.into_json();
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
    Ok((Document::from_json(json).map_err(invalid)?, blob))
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

    let material = primitive.material();
    let names = [
        node.mesh().and_then(|mesh| mesh.name().map(str::to_owned)),
        node.name().map(str::to_owned),
    ];
    let mut part =
        Part::new(names.into_iter().flatten().chain(material.name().map(str::to_owned)).collect());
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

    let has_material = material.index().is_some();
    let factor =
        if has_material { material.pbr_metallic_roughness().base_color_factor() } else { [1.0; 4] };
    if let Some(accessor) = primitive.get(&Semantic::Colors(0)) {
        part.colours = match accessor.dimensions() {
            ::gltf::accessor::Dimensions::Vec3 => {
                let alpha = if has_material { 1.0 } else { DEFAULT_ALPHA };
                buffers
                    .vectors::<3>(&accessor)?
                    .into_iter()
                    .map(|c| Vec3::from(c).extend(alpha))
                    .collect()
            }
            _ => buffers.vectors::<4>(&accessor)?.into_iter().map(Vec4::from).collect(),
        };
        same_count("COLOR_0", part.colours.len())?;
    } else if has_material {
        part.colours = vec![Vec4::ONE; count];
    }
    part.colours.iter_mut().for_each(|colour| *colour = encoded(*colour * Vec4::from(factor)));
    Ok(Some(part))
}

/// A linear colour gamma-encoded, alpha as it is.
fn encoded(linear: Vec4) -> Vec4 {
    let linear = linear.clamp(Vec4::ZERO, Vec4::ONE);
    linear.truncate().powf(1.0 / 2.2).extend(linear.w)
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
        let (document, _) = parse("a.gltf", json).unwrap();
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
        let (document, _) = parse("a.gltf", json.as_bytes()).unwrap();
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
