//! What becomes of a glTF file's extensions.

use super::super::Reading;
use crate::scene::{Extension, Handling, SceneError};
use ::gltf::json::Root;

/// Extensions that are read.
const READ: [&str; 6] = [
    "EXT_mesh_gpu_instancing",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];
/// Extensions that say nothing of what is drawn here: the light is always the same, and data on data is not seen.
const WITHOUT_EFFECT: [&str; 7] = [
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "KHR_lights_punctual",
    "KHR_materials_variants",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Refuses a file that requires what is not read, and notes what is passed over though it changes the picture. The library
/// is then told of no required extension, as it knows fewer.
pub(super) fn check(file: &mut Reading, json: &mut Root) -> Result<(), SceneError> {
    let handling = |name: &str| match name {
        _ if READ.contains(&name) => Handling::Read,
        _ if WITHOUT_EFFECT.contains(&name) => Handling::WithoutEffect,
        _ => Handling::PassedOver,
    };
    let mut required = json.extensions_required.iter();
    if let Some(name) = required.find(|name| handling(name) == Handling::PassedOver) {
        let unpack = match name.as_str() {
            "KHR_draco_mesh_compression"
            | "EXT_meshopt_compression"
            | "KHR_meshopt_compression" => ": unpack it first, as by `gltf-transform copy IN OUT`",
            _ => "",
        };
        return Err(
            file.bad(None, format!("requires the extension `{name}`, which is not read{unpack}"))
        );
    }
    json.extensions_required.clear();
    let mut used = std::mem::take(&mut json.extensions_used);
    used.sort_unstable();
    used.dedup();
    file.extensions =
        used.into_iter().map(|n| Extension { handling: handling(&n), name: n }).collect();
    let others = file.extensions.iter().filter(|e| e.handling == Handling::PassedOver);
    let others: Vec<&str> = others.map(|extension| extension.name.as_str()).collect();
    if !others.is_empty() {
        file.note(format!("extensions that are passed over: {}", others.join(", ")));
    }
    Ok(())
}
