//! Materials of glTF: textures, alpha modes, extensions; what each fragment of a square gets.

use super::*;
use crate::scene::{AlphaMode, Options, PartContents, Scene, TextureContents};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Vec2, vec2};
use pellucid_machine::pixel::Fragment;
use std::convert::Infallible;

const UNLIT: &str = r#""extensions":{"KHR_materials_unlit":{}}"#;
const TEXTURED: &str = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0}}"#;

/// A PNG of these texels, rows from the top.
pub(super) fn png(width: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width, texels.len() as u32 / width);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(texels.as_flattened()).unwrap();
    bytes
}

fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// A square with the colour at each vertex, one material, and one texture with the image and sampler.
fn square(colour: [f32; 4], material: &str, image: &str, sampler: &str) -> String {
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let data = [
        floats(&[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0]),
        floats(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        floats(&[colour; 4].concat()),
        [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect(),
    ];
    let buffer = data_uri("application/octet-stream", &data.concat());
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2}},
                                   "indices":3,"material":0}}]}}],
        "materials":[{{{material}}}],"textures":[{{"source":0,"sampler":0}}],
        "images":[{{{image}}}],"samplers":[{{{sampler}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
                     {{"bufferView":2,"componentType":5126,"count":4,"type":"VEC4"}},
                     {{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
                       {{"buffer":0,"byteOffset":80,"byteLength":64}},
                       {{"buffer":0,"byteOffset":144,"byteLength":12}}],
        "buffers":[{{"uri":"{buffer}","byteLength":156}}]}}"#
    )
}

/// Such a square with a texture of one texel, not lit.
fn texel(texel: [u8; 4], colour: [f32; 4], material: &str) -> String {
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(1, &[texel])));
    square(colour, &format!("{UNLIT},{material}"), &image, "")
}

/// A square that is half transparent by its texture.
pub(super) fn blended() -> String {
    texel([255, 0, 0, 128], WHITE, &format!(r#"{TEXTURED},"alphaMode":"BLEND""#))
}

/// The fragments of a file of this content, seen from the front.
fn fragments(name: &str, content: impl AsRef<[u8]>, alphas: &[&str]) -> Vec<Fragment> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    drawn(&path, alphas)
}

/// The fragments of a file, seen from the front: a square from -1, -1 to 1, 1 covers 4 x 4 pixels.
pub(super) fn drawn(path: &Path, alphas: &[&str]) -> Vec<Fragment> {
    let options = Options {
        width: Some(24),
        height: Some(16),
        camera: Some("0,0,9:0,0,0".parse().unwrap()),
        alphas: alphas.iter().map(|alpha| alpha.parse().unwrap()).collect(),
        ..Options::default()
    };
    let scene = Scene::open(path.to_str().unwrap(), &options).unwrap();
    let mut fragments = vec![];
    let Ok(()) = scene.play(&mut |fragment| -> Result<(), Infallible> {
        fragments.push(fragment);
        Ok(())
    });
    fragments
}

/// The one colour of all fragments; nothing if there are none.
fn only_colour(json: &str, alphas: &[&str]) -> Option<[u8; 4]> {
    let fragments = fragments("a.gltf", json, alphas);
    let first = fragments.first()?.rgba;
    assert!(fragments.iter().all(|fragment| fragment.rgba == first));
    assert_eq!(fragments.len(), 16, "the square covers 4 x 4 pixels");
    Some(first.to_be_bytes())
}

const WHITE: [f32; 4] = [1.0; 4];

#[test]
fn a_texture_gives_colour_and_alpha_as_the_mode_says() {
    let mode = |mode: &str| format!(r#"{TEXTURED},"alphaMode":"{mode}""#);
    let red = [255, 0, 0, 128];
    assert_eq!(only_colour(&texel(red, WHITE, &mode("BLEND")), &[]), Some(red));
    assert_eq!(only_colour(&texel(red, WHITE, &mode("OPAQUE")), &[]), Some([255, 0, 0, 255]));
    assert_eq!(only_colour(&texel(red, WHITE, TEXTURED), &[]), Some([255, 0, 0, 255]));
    // 128 / 255 is above the cutoff of 0.5 that a mask has where it states none; 127 / 255 below.
    assert_eq!(only_colour(&texel(red, WHITE, &mode("MASK")), &[]), Some([255, 0, 0, 255]));
    assert_eq!(only_colour(&texel([255, 0, 0, 127], WHITE, &mode("MASK")), &[]), None);
}

#[test]
fn alpha_of_vertices_counts_as_the_mode_says() {
    let plain = |alpha: f32, material: &str| {
        only_colour(&texel([9; 4], [1.0, 1.0, 1.0, alpha], material), &[])
    };
    let white = |alpha| Some([255, 255, 255, alpha]);
    assert_eq!(plain(0.5, r#""alphaMode":"OPAQUE""#), white(255));
    assert_eq!(plain(0.5, r#""alphaMode":"BLEND""#), white(128));
    let mask = r#""alphaMode":"MASK","alphaCutoff":0.5"#;
    assert_eq!(plain(0.48, mask), None);
    assert_eq!(plain(0.5, mask), white(255));
    assert_eq!(plain(0.52, mask), white(255));
    assert_eq!(plain(0.3, r#""alphaMode":"MASK","alphaCutoff":0.3"#), white(255));
}

#[test]
fn texture_factor_and_vertex_colour_are_multiplied_as_light() {
    let factor = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0},
        "baseColorFactor":[1,0.5,0.25,0.5]},"alphaMode":"BLEND""#;
    // 188 is the level of half the light, 137 of a quarter, 99 of an eighth.
    let json = texel([255, 255, 188, 255], [0.5, 0.5, 1.0, 0.5], factor);
    assert_eq!(only_colour(&json, &[]), Some([188, 137, 99, 64]));
    // A colour without a texture is the same as one that a texture has.
    let plain = r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1]}"#;
    assert_eq!(only_colour(&texel([0; 4], WHITE, plain), &[]), Some([188, 137, 99, 255]));
}

#[test]
fn light_on_a_texture_is_as_on_a_colour() {
    let lit = |texel: [u8; 4], material: &str| {
        let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(1, &[texel])));
        let found = only_colour(&square(WHITE, material, &image, ""), &[]);
        found.expect("fragments").map(i32::from)
    };
    let textured = lit([188, 137, 0, 255], TEXTURED);
    let coloured = lit([0; 4], r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0,1]}"#);
    assert!((0..4).all(|i| (textured[i] - coloured[i]).abs() <= 1), "{textured:?} {coloured:?}");
    assert_ne!(textured[0], 188, "it is lit");
}

#[test]
fn a_rule_for_alpha_wins_over_the_texture_but_not_over_a_mask() {
    let blend = format!(r#"{TEXTURED},"alphaMode":"BLEND""#);
    assert_eq!(
        only_colour(&texel([255, 0, 0, 128], WHITE, &blend), &["0.2"]),
        Some([255, 0, 0, 51])
    );
    let mask = format!(r#"{TEXTURED},"alphaMode":"MASK""#);
    assert_eq!(only_colour(&texel([255, 0, 0, 127], WHITE, &mask), &["0.2"]), None);
}

#[test]
fn an_image_is_in_a_file_a_uri_or_a_buffer() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.gltf");
    let open = || {
        let loaded = super::super::load(path.to_str().unwrap(), Room::new(None), 0.0).unwrap();
        let notes = loaded.notes.join(" ");
        (loaded.parts.into_iter().next().unwrap().paint, notes)
    };
    fs::write(&path, square(WHITE, TEXTURED, r#""uri":"a%20b.png""#, "")).unwrap();
    let (paint, notes) = open();
    assert!(paint.is_none(), "no image, no paint");
    assert!(notes.contains("1 image that does not exist (`"), "{notes}");
    assert!(notes.ends_with("a b.png`)"), "{notes}");
    fs::write(folder.path().join("a b.png"), png(1, &[[1, 2, 3, 4]])).unwrap();
    assert!(open().0.unwrap().colour.is_some());

    // A view of the buffer that holds the image behind the vertices.
    let jpeg = include_bytes!("../../texture/halves.jpg");
    let json = square(WHITE, TEXTURED, r#""bufferView":4,"mimeType":"image/jpeg""#, "");
    let (before, after) = json.split_once("base64,").unwrap();
    let (data, after) = after.split_once('"').unwrap();
    let data = [STANDARD.decode(data).unwrap(), jpeg.to_vec()].concat();
    let view = format!(r#"{{"buffer":0,"byteOffset":156,"byteLength":{}}}],"#, jpeg.len());
    let json = format!("{before}base64,{}\"{after}", STANDARD.encode(&data))
        .replace(r#""byteLength":12}],"#, &format!(r#""byteLength":12}},{view}"#))
        .replace(r#""byteLength":156}"#, &format!(r#""byteLength":{}}}"#, data.len()));
    let mut fragments = fragments("a.gltf", &json, &[]);
    fragments.sort_by_key(|fragment| (fragment.y, fragment.x));
    let [left, right] = [0, 3].map(|i| fragments[i].rgba.to_be_bytes());
    assert!(left[0] > left[2] && right[2] > right[0], "red on the left, blue on the right");
}

#[test]
fn wraps_come_from_the_sampler() {
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(1, &[[1; 4]])));
    let wraps = |sampler: &str| {
        let parts = loaded("a.gltf", square(WHITE, TEXTURED, &image, sampler)).unwrap();
        let paint = parts[0].paint.as_ref().unwrap();
        format!("{:?}", paint.colour.as_ref().unwrap().wraps)
    };
    assert_eq!(wraps(""), "[Repeat, Repeat]");
    assert_eq!(wraps(r#""wrapS":33071,"wrapT":33648"#), "[Clamp, Mirror]");
}

/// The places of the vertices on the texture with this transform.
fn places(transform: &str) -> Vec<Vec2> {
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(1, &[[1; 4]])));
    let material = format!(
        r#""pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,
           "extensions":{{"KHR_texture_transform":{{{transform}}}}}}}}}"#
    );
    let json = square(WHITE, &material, &image, "").replace(
        r#""asset":"#,
        r#""extensionsUsed":["KHR_texture_transform"],
           "extensionsRequired":["KHR_texture_transform"],"asset":"#,
    );
    let parts = loaded("a.gltf", json).unwrap();
    let paint = parts[0].paint.as_ref().unwrap();
    paint.places.iter().map(|place| vec2(place.x, place.y)).collect()
}

/// The extension's own example: the lower left quarter of the image, turned clockwise by 90 degrees, which is what turning
/// the coordinates counter-clockwise does. The second coordinate runs downwards.
#[test]
fn a_texture_transform_scales_then_turns_then_moves() {
    let found = places(r#""offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]"#);
    // The square's corners from the lower left counter-clockwise show the image's (0.5, 1), (0.5, 0.5), (0, 0.5), (0, 1).
    let expected = [vec2(0.5, 1.0), vec2(0.5, 0.5), vec2(0.0, 0.5), vec2(0.0, 1.0)];
    assert!(found.iter().zip(expected).all(|(f, e)| f.abs_diff_eq(e, 1e-6)), "{found:?}");
    assert_eq!(
        places(r#""offset":[0,1],"scale":[1,-1]"#),
        [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0)]
    );
}

#[test]
fn specular_glossiness_gives_its_diffuse_colour_and_texture() {
    let other = r#""alphaMode":"BLEND","extensions":{"KHR_materials_unlit":{},
        "KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[1,1,1,0.5],"diffuseTexture":{"index":0}}}"#;
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(1, &[[10, 20, 30, 255]])));
    assert_eq!(only_colour(&square(WHITE, other, &image, ""), &[]), Some([10, 20, 30, 128]));
}

#[test]
fn transmission_is_drawn_as_alpha_and_said_once() {
    let material = |texture: &str| {
        format!(
            r#""extensions":{{"KHR_materials_unlit":{{}},
               "KHR_materials_transmission":{{"transmissionFactor":0.8{texture}}}}}"#
        )
    };
    // The texture's red is 0.5 of 255 as it is: 0.4 pass through.
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(1, &[[128, 0, 0, 9]])));
    let plain = square(WHITE, &material(""), &image, "");
    assert_eq!(only_colour(&plain, &[]), Some([255, 255, 255, 51]));
    let textured = square(WHITE, &material(r#","transmissionTexture":{"index":0}"#), &image, "");
    assert_eq!(only_colour(&textured, &[]), Some([255, 255, 255, 153]));
    let note = "a.gltf: transmission is drawn as an alpha of 1 - transmission";
    assert_eq!(notes("a.gltf", textured), [note]);
}

#[test]
fn extensions_are_read_passed_over_or_refused_by_name() {
    let required = |name: &str| {
        let list =
            format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"],"asset":"#);
        texel([0; 4], WHITE, r#""name":"a""#).replace(r#""asset":"#, &list)
    };
    for met in ["KHR_materials_unlit", "KHR_lights_punctual", "KHR_materials_transmission"] {
        assert!(notes("a.gltf", required(met)).is_empty(), "{met}");
    }
    let refused = |name: &str| message("a.gltf", required(name));
    assert_eq!(
        refused("FB_geometry_metadata"),
        "a.gltf: requires the extension `FB_geometry_metadata`, which is not read"
    );
    assert!(
        refused("KHR_draco_mesh_compression")
            .ends_with("is not read: unpack it first, as by `gltf-transform copy IN OUT`")
    );
    assert!(
        refused("EXT_meshopt_compression")
            .ends_with("is not read: unpack it first, as by `gltf-transform copy IN OUT`")
    );
    let used = required("KHR_materials_clearcoat")
        .replace(r#""extensionsRequired":["KHR_materials_clearcoat"],"#, "");
    assert_eq!(
        notes("a.gltf", used),
        ["a.gltf: extensions that are passed over: KHR_materials_clearcoat"]
    );
}

/// A PNG that says that it has this size.
fn sized(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = png(1, &[[1; 4]]);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let mut check = flate2::Crc::new();
    check.update(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&check.sum().to_be_bytes());
    bytes
}

#[test]
fn bad_textures_are_refused() {
    let image = |bytes: &[u8]| format!(r#""uri":"{}""#, data_uri("image/png", bytes));
    let with = |image: &str| square(WHITE, TEXTURED, image, "");
    let good = with(&image(&png(1, &[[1; 4]])));
    let jpeg = include_bytes!("../../texture/halves.jpg");
    let extended = |extension: &str| {
        let material = format!(r#""extensions":{{{extension}}}"#);
        square(WHITE, &material, &image(&png(1, &[[1; 4]])), "")
    };
    let scaled = |by: &str| {
        format!(r#"{{"index":0,"extensions":{{"KHR_texture_transform":{{"scale":[{by},1]}}}}}}"#)
    };
    let cases = [
        (with(""), "a.gltf: image 0 has neither a view nor a URI"),
        (with(r#""uri":"data:image/png;base64,%""#), "a.gltf: image 0 is no valid base64 data"),
        (
            good.replace(r#"{"index":0}"#, r#"{"index":7}"#),
            "a.gltf: expected glTF 2.0: \
             materials[0].pbrMetallicRoughness.baseColorTexture.index: Index out of bounds",
        ),
        (
            good.replace(r#""source":0"#, r#""source":7"#),
            "a.gltf: expected glTF 2.0: textures[0].source: Index out of bounds",
        ),
        (
            good.replace(r#""sampler":0"#, r#""sampler":7"#),
            "a.gltf: expected glTF 2.0: textures[0].sampler: Index out of bounds",
        ),
        (
            with(&image(&sized(20_000, 20_000))),
            "a.gltf: image 0 is 20000 x 20000, expected 1 to 67108864 texels",
        ),
        (with(&image(&sized(0, 5))), "a.gltf: image 0 is no valid PNG: "),
        (with(&image(&jpeg[..jpeg.len() / 2])), "a.gltf: image 0 is no valid JPEG: "),
        (
            good.replace(r#"{"index":0}"#, &scaled("1e39")),
            "a.gltf: node 0, primitive 0: TEXCOORD_0 of vertex 0 is not finite",
        ),
        (
            extended(r#""KHR_materials_transmission":{"transmissionTexture":{"index":7}}"#),
            "a.gltf: expected glTF 2.0: materials[0].extensions.",
        ),
        (
            extended(r#""KHR_materials_pbrSpecularGlossiness":{"diffuseTexture":{"index":7}}"#),
            "a.gltf: expected glTF 2.0: materials[0].extensions.",
        ),
        (
            good.replace(r#"{"index":0}"#, &scaled("NaN")),
            "a.gltf: expected glTF 2.0: expected value at line ",
        ),
        (
            good.replace(r#""count":4,"type":"VEC2""#, r#""count":3,"type":"VEC2""#),
            "a.gltf: node 0, primitive 0: has 3 of the attribute TEXCOORD_0, expected 4",
        ),
    ];
    for (json, expected) in cases {
        let found = message("a.gltf", json);
        assert!(found.starts_with(expected) && !found.contains('\n'), "{found}, {expected}");
    }
    assert_eq!(
        notes("a.gltf", with(&image(b"GIF89a"))),
        ["a.gltf: not seen: 1 image that is no PNG or JPEG (image 0)"]
    );
    let note =
        "a.gltf: where a primitive lies on its texture is not said: the texture is read at 0, 0";
    assert_eq!(notes("a.gltf", good.replace(r#","TEXCOORD_0":1"#, "")), [note]);
}

/// Two kilobytes that stand for 256 MiB.
#[test]
fn an_image_is_held_against_the_memory_limit_before_it_is_decoded() {
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, 4096, 4096);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.write_header().unwrap().write_image_data(&vec![0; 4096 * 512]).unwrap();
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &bytes));
    let json = square(WHITE, TEXTURED, &image, "");
    let refused = within(Some("200M".parse().unwrap()), "a.gltf", &json).err().unwrap();
    assert!(refused.to_string().contains("does not fit into the memory"), "{refused}");
    within(Some("400M".parse().unwrap()), "a.gltf", &json).unwrap();
}

/// Half a megabyte of text that stands for 64 MiB.
#[test]
fn a_document_is_held_against_the_memory_limit_before_it_is_read() {
    let many = format!(r#"{{"asset":{{"version":"1.0"}},"any":[{}0]}}"#, "0,".repeat(1 << 18));
    let said = |limit: &str| {
        within(Some(limit.parse().unwrap()), "a.gltf", &many).err().unwrap().to_string()
    };
    assert!(said("60M").contains("does not fit into the memory"), "{}", said("60M"));
    assert!(said("70M").contains("is glTF 1.0"), "{}", said("70M"));
}

/// What such a file has of its one part.
fn part(json: &str, alphas: &[&str]) -> PartContents {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, json).unwrap();
    let alphas = alphas.iter().map(|alpha| alpha.parse().unwrap()).collect();
    let options = Options { alphas, ..Options::default() };
    let scene = Scene::open(path.to_str().unwrap(), &options).unwrap();
    scene.contents().unwrap().parts.into_iter().next().unwrap()
}

#[test]
fn contents_have_the_opacity_that_textures_give() {
    let image = format!(r#""uri":"{}""#, data_uri("image/png", &png(2, &[[51; 4], [255; 4]])));
    let square = |alpha: f32, material: &str| {
        square([1.0, 1.0, 1.0, alpha], &format!("{TEXTURED},{material}"), &image, "")
    };
    let [blend, mask] = [r#""alphaMode":"BLEND""#, r#""alphaMode":"MASK","alphaCutoff":0.75"#];
    let texture = TextureContents { gives: "colour", size: [2, 1] };
    for (alpha, material, mode, opacity) in [
        (0.5, blend, AlphaMode::Blend, [0.1, 0.5]),
        (0.5, mask, AlphaMode::Mask(0.75), [1.0, 1.0]),
        (0.5, r#""name":"a""#, AlphaMode::Opaque, [1.0, 1.0]),
    ] {
        let part = part(&square(alpha, material), &[]);
        assert_eq!((part.alpha_mode, &part.textures[..]), (Some(mode), &[texture][..]));
        assert_eq!(part.opacity, opacity);
        let name = if material.contains("name") { "a" } else { "material 0" };
        assert_eq!(part.material.as_deref(), Some(name));
    }
    assert_eq!(part(&square(0.5, blend), &["0.3"]).opacity, [0.3; 2], "a rule wins");
    let transmission = r#""extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5,
        "transmissionTexture":{"index":0}}}"#;
    let part = part(&square(0.5, transmission), &[]);
    // 51 of 255 of the half pass through, or all of the half.
    assert_eq!(part.opacity, [0.5, 0.9]);
    assert_eq!(part.textures, [texture, TextureContents { gives: "alpha", ..texture }]);
}
