//! The nodes that are seen: where each is, and how often.

use super::buffers::Buffers;
use ::gltf::{Accessor, Document, Node};
use glam::{Mat4, Quat, Vec3};

/// All nodes of the scene that is shown, each with what takes it into the scene, parents first.
///
/// It is the scene that the file names, or the first one; a file without scenes shows all its nodes.
pub(super) fn placed<'a>(
    document: &'a Document,
    local: impl Fn(&Node) -> Mat4,
) -> Result<Vec<(Node<'a>, Mat4)>, String> {
    let mut to_visit: Vec<(Node, Mat4)> =
        roots(document).into_iter().map(|node| (node, Mat4::IDENTITY)).collect();
    to_visit.reverse();
    let mut visited = vec![false; document.nodes().len()];
    let mut placed = vec![];
    while let Some((node, above)) = to_visit.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(format!("node {} has two parents, expected a tree", node.index()));
        }
        let to_scene = above * local(&node);
        let first_child = to_visit.len();
        to_visit.extend(node.children().map(|child| (child, to_scene)));
        to_visit[first_child..].reverse();
        placed.push((node, to_scene));
    }
    Ok(placed)
}

fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let mut has_parent = vec![false; document.nodes().len()];
    document.nodes().flat_map(|node| node.children()).for_each(|c| has_parent[c.index()] = true);
    document.nodes().filter(|node| !has_parent[node.index()]).collect()
}

/// Bytes that an instance takes while it is read.
pub(super) const INSTANCE_BYTES: usize = 4 * size_of::<Mat4>();

/// The instances of a node's mesh (EXT_mesh_gpu_instancing).
pub(super) struct Instances<'a> {
    /// Translation, rotation and scale, where they are stated.
    attributes: [Option<Accessor<'a>>; 3],
    /// How many there are.
    pub count: usize,
}

impl<'a> Instances<'a> {
    /// Those of a node, or a single one where it states none.
    pub fn of(document: &'a Document, node: &Node) -> Result<Instances<'a>, String> {
        let stated =
            node.extension_value("EXT_mesh_gpu_instancing").map(|value| &value["attributes"]);
        let mut count = None;
        let mut attributes = [const { None }; 3];
        for (name, attribute) in
            ["TRANSLATION", "ROTATION", "SCALE"].into_iter().zip(&mut attributes)
        {
            let Some(index) = stated.and_then(|attributes| attributes.get(name)) else { continue };
            let index = index.as_u64().and_then(|index| usize::try_from(index).ok());
            let accessor = index.and_then(|index| document.accessors().nth(index));
            let accessor =
                accessor.ok_or_else(|| format!("has no accessor for the instances' {name}"))?;
            let (found, expected) = (accessor.count(), *count.get_or_insert(accessor.count()));
            if found != expected {
                return Err(format!("has {found} instances by their {name}, expected {expected}"));
            }
            *attribute = Some(accessor);
        }
        Ok(Instances { attributes, count: count.unwrap_or(1) })
    }

    /// Where each is from the node.
    pub fn transforms(&self, buffers: &Buffers) -> Result<Vec<Mat4>, String> {
        let [translation, rotation, scale] = &self.attributes;
        let count = self.count;
        let vectors = |accessor: &Option<Accessor>, default: Vec3| match accessor {
            Some(accessor) => Ok::<_, String>(
                buffers.vectors::<3>(accessor, count)?.into_iter().map(Vec3::from).collect(),
            ),
            None => Ok(vec![default; count]),
        };
        let translations = vectors(translation, Vec3::ZERO)?;
        let scales = vectors(scale, Vec3::ONE)?;
        let turn = |turn| Quat::from_array(turn).normalize();
        let rotations = match rotation {
            Some(accessor) => {
                buffers.vectors::<4>(accessor, count)?.into_iter().map(turn).collect()
            }
            None => vec![Quat::IDENTITY; count],
        };
        let parts = translations.into_iter().zip(rotations).zip(scales);
        Ok(parts
            .map(|((translation, rotation), scale)| {
                Mat4::from_scale_rotation_translation(scale, rotation, translation)
            })
            .collect())
    }
}
