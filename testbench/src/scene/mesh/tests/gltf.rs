//! glTF with embedded, external and binary buffers.

use super::*;
use glam::{Vec3, Vec4, vec3, vec4};

/// One triangle at a node that is moved by (10, 0, 0) and mirrored, below one that is moved by (0, 5, 0).
pub(super) fn gltf(buffer: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"name":"hall","translation":[0,5,0],"children":[1]}},
                 {{"name":"lamp","mesh":0,"translation":[10,0,0],"scale":[-1,1,1]}}],
        "materials":[{{"name":"shade","alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorFactor":[1,0,1,0.25]}}}}],
        "meshes":[{{"name":"cone","primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
                     {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],
        "buffers":[{{{buffer}"byteLength":42}}]}}"#
    )
}

pub(super) fn gltf_data() -> Vec<u8> {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y].into_iter().flat_map(|p| p.to_array());
    positions
        .flat_map(f32::to_le_bytes)
        .chain([0u16, 1, 2].into_iter().flat_map(u16::to_le_bytes))
        .collect()
}

pub(super) fn embedded(data: &[u8]) -> String {
    use base64::Engine;
    let text = base64::engine::general_purpose::STANDARD.encode(data);
    gltf(&format!(r#""uri":"data:application/octet-stream;base64,{text}","#))
}

pub(super) fn glb() -> Vec<u8> {
    let mut json = gltf("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data = gltf_data();
    data.resize(data.len().next_multiple_of(4), 0);
    let length = (12 + 8 + json.len() + 8 + data.len()) as u32;
    let word = |value: u32| value.to_le_bytes().to_vec();
    let chunks = [(json, *b"JSON"), (data, *b"BIN\0")];
    let chunks =
        chunks.into_iter().flat_map(|(data, kind)| [word(data.len() as u32), kind.to_vec(), data]);
    [b"glTF".to_vec(), word(2), word(length)].into_iter().chain(chunks).flatten().collect()
}

#[test]
fn gltf_is_read_with_any_kind_of_buffer() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, gltf(r#""uri":"the%20data.bin","#)).unwrap();
    fs::write(folder.path().join("the data.bin"), gltf_data()).unwrap();
    let external = load(path.to_str().unwrap());
    for parts in [external, loaded("b.gltf", embedded(&gltf_data())), loaded("c.GLB", glb())] {
        let [part] = &parts.unwrap()[..] else { panic!("one part") };
        assert_eq!(part.names, ["cone", "lamp", "shade"]);
        assert_eq!(
            part.positions,
            [vec3(10.0, 5.0, 0.0), vec3(9.0, 5.0, 0.0), vec3(10.0, 6.0, 0.0)]
        );
        assert_eq!(part.triangles, [[0, 1, 2]]);
        assert_eq!(part.colours, [Vec4::new(1.0, 0.0, 1.0, 0.25); 3]);
    }
}

#[test]
fn a_bad_gltf_is_refused() {
    let good = embedded(&gltf_data());
    let mut nan = gltf_data();
    nan[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut far = gltf_data();
    far[40] = 3;
    let cases = [
        (embedded(&nan), "a.gltf: node 1, primitive 0: vertex 0 is not finite"),
        (
            embedded(&far),
            "a.gltf: node 1, primitive 0: has the vertex index 3, expected one below 3",
        ),
        (embedded(&gltf_data()[..40]), "a.gltf: buffer 0 has 40 bytes, expected 42"),
        (gltf(r#""uri":"data:;base64,%","#), "a.gltf: buffer 0 is no valid base64 data"),
        (gltf(""), "a.gltf: buffer 0 is the binary part of a GLB, which is missing"),
        (
            good.replace(r#""count":3,"type":"VEC3""#, r#""count":4,"type":"VEC3""#),
            "a.gltf: node 1, primitive 0: accessor 0 reaches beyond its buffer",
        ),
        (
            good.replace(r#""children":[1]"#, r#""children":[1,1]"#),
            "a.gltf: node 1 has two parents, expected a tree",
        ),
        (
            good.replace(r#""POSITION":0"#, r#""POSITION":9"#),
            "a.gltf: has the accessor index 9, expected one below 2",
        ),
        (
            good.replace(r#""mesh":0,"#, ""),
            "a.gltf: has no triangles with an area, expected at least one",
        ),
    ];
    for (file, expected) in cases {
        assert_eq!(message("a.gltf", file), expected);
    }
    assert!(message("a.gltf", &good[..99]).starts_with("a.gltf: expected glTF 2.0: "));
    let glb = glb();
    for length in 0..glb.len() - 4 {
        assert!(message("a.glb", &glb[..length]).starts_with("a.glb: "), "{length} bytes");
    }
}

#[test]
fn gltf_vertex_colours_are_used_with_or_without_alpha() {
    let coloured = |kind: &str| {
        let accessors = format!(
            r#","type":"SCALAR"}},
            {{"bufferView":0,"byteOffset":12,"componentType":5121,"normalized":true,"count":3,"type":"{kind}"}}]"#
        );
        embedded(&gltf_data())
            .replace(r#","type":"SCALAR"}]"#, &accessors)
            .replace(r#""POSITION":0}"#, r#""POSITION":0,"COLOR_0":2}"#)
            .replace(r#","material":0"#, "")
    };
    // The colours lie over the second position, whose x is 1.0: the bytes 0, 0, 0x80, 0x3f.
    let blue = 1.055 * (128.0f32 / 255.0).powf(1.0 / 2.4) - 0.055;
    for (kind, alpha) in [("VEC3", 0.5), ("VEC4", 63.0 / 255.0)] {
        let colour = loaded("a.gltf", coloured(kind)).unwrap()[0].colours[0];
        assert!(colour.abs_diff_eq(vec4(0.0, 0.0, blue, alpha), 1e-6), "{colour}");
    }
}
