//! A glTF file's document, checked.

use super::extensions;
use crate::scene::SceneError;
use crate::scene::mesh::{Reading, bad};
use ::gltf::json::image::MimeType;
use ::gltf::json::validation::Checked;
use ::gltf::{Document, Gltf, Semantic};
use serde_json::Value;

/// Size of a GLB's header.
const GLB_HEADER_BYTES: u8 = 12;
/// Bytes that a value of a document takes in memory, about: an object of several fields.
const VALUE_BYTES: usize = 256;

/// The document, with every index in it checked, and a GLB's binary part.
pub(super) fn parse(
    file: &mut Reading,
    bytes: &[u8],
) -> Result<(Document, Option<Vec<u8>>), SceneError> {
    let path = file.path;
    let other = |version: &str| bad(path, None, format!("is glTF {version}, expected glTF 2.0"));
    let invalid = |error: ::gltf::Error| {
        if let Some(version) = other_version(bytes) {
            return other(&version);
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
    file.take(values(bytes).saturating_mul(VALUE_BYTES))?;
    // Two checks that the library takes for granted: a GLB is as long as its header, and positions exist.
    let length = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..8));
    if length.is_some_and(|bytes| bytes[0] < GLB_HEADER_BYTES && bytes[1..] == [0; 3]) {
        return Err(bad(path, None, "the length in the GLB's header is less than the header's"));
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let mut json = document.into_json();
    if !is_read(&json.asset.version) {
        return Err(other(&json.asset.version));
    }
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
    // What the library takes for granted of images: those in a buffer say their form, which their bytes say anyway.
    for (i, image) in json.images.iter_mut().enumerate() {
        match image.buffer_view {
            Some(_) => image.mime_type = Some(MimeType(String::new())),
            None if image.uri.is_none() => {
                return Err(bad(path, None, format!("image {i} has neither a view nor a URI")));
            }
            None => {}
        }
    }
    // And of the targets of animations: they exist, and are of a kind that it knows.
    let nodes = json.nodes.len();
    for (i, animation) in json.animations.iter_mut().enumerate() {
        animation.channels.retain(|channel| matches!(channel.target.path, Checked::Valid(_)));
        if let Some(node) =
            animation.channels.iter().map(|c| c.target.node.value()).find(|node| *node >= nodes)
        {
            let what = format!("animation {i} moves node {node}, expected one below {nodes}");
            return Err(bad(path, None, what));
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

/// How many values a document has, at most: each but the first stands behind a comma or begins a list or an object.
fn values(bytes: &[u8]) -> usize {
    // In a GLB it is the first chunk, behind the header and the chunk's length and kind.
    let chunk = bytes.strip_prefix(b"glTF").and_then(|_| {
        let length = u32::from_le_bytes(*bytes.get(12..)?.first_chunk()?);
        bytes.get(20..)?.get(..length as usize)
    });
    chunk.unwrap_or(bytes).iter().filter(|byte| matches!(byte, b',' | b'[' | b'{')).count()
}

/// Whether a version is 2, or 2 and a minor one.
fn is_read(version: &str) -> bool {
    version.split('.').next() == Some("2")
}

/// The version of a file of another one than 2. Before 2 it need not be stated, and may be a number; what has a number now
/// had a name then.
fn other_version(bytes: &[u8]) -> Option<String> {
    let version = match bytes.strip_prefix(b"glTF") {
        Some(rest) => format!("{}.0", u32::from_le_bytes(*rest.first_chunk()?)),
        None => {
            let json: Value = serde_json::from_slice(bytes).ok()?;
            match &json["asset"]["version"] {
                Value::String(version) => version.clone(),
                Value::Number(version) if version.is_u64() => format!("{version}.0"),
                Value::Number(version) => version.to_string(),
                _ if json["meshes"].is_object() => "1.0".into(),
                _ => return None,
            }
        }
    };
    (!is_read(&version)).then_some(version)
}
