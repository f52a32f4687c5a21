//! `run --check`: what a scene holds, without a run.

use super::*;

/// A triangle in front of another one, and a point, which is not seen.
const TWO: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 -2\ng pane\nf 1 2 3\ng wall\nf 2 3 4\np 1\n";
const VIEW: [&str; 12] = [
    "--scene",
    "two.obj",
    "--alpha",
    "pane=0.25",
    "--alpha",
    "wall=1",
    "--camera",
    "0.5,0.25,3:0.5,0.5,0",
    "--width",
    "40",
    "--height",
    "30",
];
const NOTE: &str = "two.obj: not seen: 1 statement of points (line 9)";

#[test]
fn a_mesh_is_told_part_by_part_and_nothing_is_written() {
    let folder = folder();
    fs::write(folder.path().join("two.obj"), TWO).unwrap();
    let output = pellucid(folder.path(), &[&["run", "--check"], &VIEW[..]].concat());
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(stderr(&output), format!("note: {NOTE}\n"));
    assert_eq!(names(folder.path()), ["two.obj"]);

    // As many as a trace of it has.
    let trace = ["trace", "--quiet", "--out", "two.csv"];
    assert!(pellucid(folder.path(), &[&trace, &VIEW[..]].concat()).status.success());
    let trace = fs::read_to_string(folder.path().join("two.csv")).unwrap();
    let fragments: Vec<&str> = trace.lines().skip(2).collect();
    let transparent = fragments.iter().filter(|line| line.ends_with(",64")).count();
    let opaque = fragments.iter().filter(|line| line.ends_with(",255")).count();
    assert_eq!(transparent + opaque, fragments.len());
    let expected = format!(
        "two.obj: 40 x 30 pixels, {} fragments, {transparent} of them transparent.\n\
         Seen from 0.5,0.25,3:0.5,0.5,0:40 (eye, point looked at, field of view).\n\
         \n\
         PARTS   vertices  triangles  splats  material  alpha mode  textures  opacity  from x,y,z  to x,y,z\n\
         \x20 pane         3          1       0                                  0.25     0,0,0       1,1,0\n\
         \x20 wall         3          1       0                                  1        0,0,-2      1,1,0\n\
         \n\
         ALL            6          2       0                                           0,0,-2      1,1,0\n",
        fragments.len()
    );
    assert_eq!(stdout(&output), expected);

    let output = pellucid(folder.path(), &[&["run", "--check", "--json"], &VIEW[..]].concat());
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    let expected = serde_json::json!({
        "scene": "two.obj",
        "frame": {
            "width": 40, "height": 30, "frames": 1, "fragments": fragments.len(), "transparent": transparent,
        },
        "notes": [NOTE],
        "camera": "0.5,0.25,3:0.5,0.5,0:40",
        "bounds": { "from": [0.0, 0.0, -2.0], "to": [1.0, 1.0, 0.0] },
        "extensions": [],
        "parts": [
            {
                "names": ["pane"], "material": null, "alpha_mode": null, "textures": [],
                "vertices": 3, "triangles": 1, "splats": 0,
                "opacity": { "least": 0.25, "most": 0.25 },
                "bounds": { "from": [0.0, 0.0, 0.0], "to": [1.0, 1.0, 0.0] },
            },
            {
                "names": ["wall"], "material": null, "alpha_mode": null, "textures": [],
                "vertices": 3, "triangles": 1, "splats": 0,
                "opacity": { "least": 1.0, "most": 1.0 },
                "bounds": { "from": [0.0, 0.0, -2.0], "to": [1.0, 1.0, 0.0] },
            },
        ],
    });
    assert_eq!(json, expected);
}

/// A trace is read to its end, and what is wrong with it is found.
#[test]
fn a_list_of_fragments_is_read_whole() {
    let folder = folder();
    let trace = "# pellucid-trace width=3 height=1 background=0,0,0\nx,y,z,r,g,b,a\n\
                 1,0,5,200,0,0,255\n2,0,5,0,200,0,128\n2,0,6,0,0,200,0\n";
    fs::write(folder.path().join("three.csv"), trace).unwrap();
    let args = ["run", "--check", "--scene", "three.csv"];
    let output = exact(pellucid(folder.path(), &args));
    assert_eq!(stdout(&output), "three.csv: 3 x 1 pixels, 3 fragments, 2 of them transparent.\n");
    assert_eq!(stdout(&pellucid(folder.path(), &[&args[..], &["--quiet"]].concat())), "");

    fs::write(folder.path().join("three.csv"), trace.to_owned() + "3,0,0,0,0,0,0\n").unwrap();
    refused(folder.path(), &args, "`three.csv`, line 6: x is `3`, expected an integer from 0 to 2");
}

/// A triangle with a material that uses what a glTF may state of one.
#[test]
fn materials_textures_and_extensions_are_told() {
    let folder = folder();
    // A PNG of one white texel, and the corners 0,0,0, 1,0,0 and 0,1,0.
    let png = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII=";
    let corners = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "extensionsUsed":["KHR_materials_unlit","KHR_materials_clearcoat","KHR_lights_punctual"],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "materials":[{{"name":"leaf","alphaMode":"MASK","alphaCutoff":0.25,"extensions":{{"KHR_materials_unlit":{{}}}},
                       "pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"data:image/png;base64,{png}"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"uri":"data:;base64,{corners}","byteLength":36}}]}}"#
    );
    fs::write(folder.path().join("leaf.gltf"), json).unwrap();
    let args = ["run", "--check", "--scene", "leaf.gltf", "--camera", "0,0,3:0,0,0"];
    let output = pellucid(folder.path(), &args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let (_, told) = stdout(&output).split_once("field of view).\n").unwrap();
    assert_eq!(
        told,
        "Extensions: KHR_lights_punctual (without effect), KHR_materials_clearcoat (passed over), \
         KHR_materials_unlit (read).\n\
         \n\
         PARTS   vertices  triangles  splats  material  alpha mode  textures    opacity  from x,y,z  to x,y,z\n\
         \x20 leaf         3          1       0  leaf      MASK 0.25   colour 1x1  1        0,0,0       1,1,0\n"
    );
    let output = pellucid(folder.path(), &[&args[..], &["--json"]].concat());
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    assert_eq!(
        json["extensions"],
        serde_json::json!([
            { "name": "KHR_lights_punctual", "handling": "without effect" },
            { "name": "KHR_materials_clearcoat", "handling": "passed over" },
            { "name": "KHR_materials_unlit", "handling": "read" },
        ])
    );
    let part = &json["parts"][0];
    assert_eq!((&part["material"], &part["alpha_mode"]), (&"leaf".into(), &"MASK 0.25".into()));
    let texture = serde_json::json!([{ "gives": "colour", "width": 1, "height": 1 }]);
    assert_eq!(part["textures"], texture);
}
