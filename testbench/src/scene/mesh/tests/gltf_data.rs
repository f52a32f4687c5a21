//! Where glTF keeps its vertices, and what moves them: accessors of every kind, instances, skins, morph targets, animations.

use super::*;
use crate::scene::{Options, Scene, Sequence, Varied, Vary};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Vec3, vec3};

/// The buffer of a file and the accessors into it.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

const F32: u32 = 5126;

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

impl Data {
    /// A view of these bytes; its number.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
        self.views.len() - 1
    }

    /// An accessor without a view, with more to say of it; its number.
    fn empty(&mut self, kind: &str, component: u32, count: usize, more: &str) -> usize {
        self.accessors.push(format!(
            r#"{{"componentType":{component},"count":{count},"type":"{kind}"{more}}}"#
        ));
        self.accessors.len() - 1
    }

    /// An accessor of these bytes; its number.
    fn add(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.empty(kind, component, count, &format!(r#","bufferView":{view}"#))
    }

    /// An accessor of the positions (0, 0, 0), (1, 0, 0), (0, 1, 0).
    fn triangle(&mut self) -> usize {
        self.add("VEC3", F32, 3, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))
    }

    /// The file, with what else it has at its top.
    fn file(&self, rest: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},{rest},"accessors":[{}],"bufferViews":[{}],
            "buffers":[{{"uri":"data:;base64,{}","byteLength":{}}}]}}"#,
            self.accessors.join(","),
            self.views.join(","),
            STANDARD.encode(&self.bytes),
            self.bytes.len()
        )
    }

    /// The file with one node and one primitive.
    fn primitive(&self, primitive: &str) -> String {
        self.file(&format!(
            r#""nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"meshes":[{{"primitives":[{{{primitive}}}]}}]"#
        ))
    }
}

/// The positions of the only part.
fn positions(json: &str) -> Vec<Vec3> {
    let parts = loaded("a.gltf", json).unwrap();
    assert_eq!(parts.len(), 1);
    parts[0].positions.clone()
}

const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

#[test]
fn attributes_of_an_application_and_positions_without_bounds_are_accepted() {
    let mut data = Data::default();
    let triangle = data.triangle();
    let ids = data.add("SCALAR", 5121, 3, &[0, 1, 2]);
    let json = data.primitive(&format!(
        r#""attributes":{{"POSITION":{triangle},"_FEATURE_ID_0":{ids},"_BATCHID":{ids}}}"#
    ));
    assert_eq!(positions(&json), TRIANGLE);
    assert!(notes("a.gltf", json).is_empty());
}

#[test]
fn quantised_attributes_count_as_they_are_or_as_parts_of_their_range() {
    let mut data = Data::default();
    let shorts = |values: [u16; 12]| values.map(u16::to_le_bytes).concat();
    // Each vector is padded to 8 bytes, which the stride says.
    let view = data.view(&shorts([0, 0, 0, 0, 300, 0, 0, 0, 0, 65535, 0, 0]));
    data.views[view].insert_str(1, r#""byteStride":8,"#);
    let plain = data.empty("VEC3", 5123, 3, &format!(r#","bufferView":{view}"#));
    let parts = data.empty("VEC3", 5123, 3, &format!(r#","normalized":true,"bufferView":{view}"#));
    let view = data.view(&[0, 0, 127, 0, 0, 0, 0x81, 0, 0, 0x80, 0, 0]);
    data.views[view].insert_str(1, r#""byteStride":4,"#);
    let normals =
        data.empty("VEC3", 5120, 3, &format!(r#","normalized":true,"bufferView":{view}"#));
    let json = |positions: usize| {
        let json = data
            .primitive(&format!(r#""attributes":{{"POSITION":{positions},"NORMAL":{normals}}}"#));
        json.replacen('{', r#"{"extensionsRequired":["KHR_mesh_quantization"],"#, 1)
    };
    assert_eq!(
        loaded("a.gltf", json(plain)).unwrap()[0].positions[1..],
        [vec3(300.0, 0.0, 0.0), vec3(0.0, 65535.0, 0.0)]
    );
    let part = &loaded("a.gltf", json(parts)).unwrap()[0];
    assert_eq!(part.positions[2], Vec3::Y);
    // -128 stands for -1 as -127 does.
    assert_eq!(part.normals, [Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y]);
}

#[test]
fn sparse_elements_take_the_place_of_others_or_of_zero() {
    let mut data = Data::default();
    let triangle = data.view(&floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    let numbers = data.view(&[1, 2]);
    let values = data.view(&floats(&[5.0, 0.0, 0.0, 0.0, 7.0, 0.0]));
    let sparse = |count: usize| {
        format!(
            r#","sparse":{{"count":{count},"indices":{{"bufferView":{numbers},"componentType":5121}},
            "values":{{"bufferView":{values}}}}}"#
        )
    };
    let over = data.empty("VEC3", F32, 3, &format!(r#","bufferView":{triangle}{}"#, sparse(1)));
    let alone = data.empty("VEC3", F32, 3, &sparse(2));
    let short = data.empty("VEC3", F32, 2, &sparse(2));
    let long = data.empty("VEC3", F32, 3, &sparse(3));
    let json = |accessor| data.primitive(&format!(r#""attributes":{{"POSITION":{accessor}}}"#));
    assert_eq!(positions(&json(over)), [Vec3::ZERO, 5.0 * Vec3::X, Vec3::Y]);
    assert_eq!(positions(&json(alone)), [Vec3::ZERO, 5.0 * Vec3::X, 7.0 * Vec3::Y]);
    assert_eq!(
        message("a.gltf", json(short)),
        "a.gltf: node 0, primitive 0: accessor 2 has the sparse index 2, expected one below 2"
    );
    assert_eq!(
        message("a.gltf", json(long)),
        "a.gltf: node 0, primitive 0: accessor 3 reaches with its sparse elements beyond its buffer"
    );
}

#[test]
fn all_instances_of_a_mesh_are_drawn() {
    let mut data = Data::default();
    let triangle = data.triangle();
    let moves = data.add("VEC3", F32, 2, &floats(&[10.0, 0.0, 0.0, 0.0, 20.0, 0.0]));
    let scales = data.add("VEC3", F32, 2, &floats(&[1.0, 1.0, 1.0, 2.0, 2.0, -2.0]));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = data.add("VEC4", F32, 2, &floats(&[0.0, 0.0, half, half, 0.0, 0.0, 0.0, 1.0]));
    let colours = data.add("VEC4", F32, 3, &floats(&[1.0; 12]));
    let json = |attributes: &str| {
        data.primitive(&format!(r#""attributes":{{"POSITION":{triangle},"COLOR_0":{colours}}}"#))
            .replace(
                r#"{"mesh":0}"#,
                &format!(
                    r#"{{"mesh":0,"translation":[0,0,1],"extensions":{{
                   "EXT_mesh_gpu_instancing":{{"attributes":{{{attributes}}}}}}}}}"#
                ),
            )
    };
    let all = format!(r#""TRANSLATION":{moves},"ROTATION":{turns},"SCALE":{scales}"#);
    let part = &loaded("a.gltf", json(&all)).unwrap()[0];
    // The first is turned by 90 degrees about z, the second twice as large.
    let expected = [
        vec3(10.0, 0.0, 1.0),
        vec3(10.0, 1.0, 1.0),
        vec3(9.0, 0.0, 1.0),
        vec3(0.0, 20.0, 1.0),
        vec3(2.0, 20.0, 1.0),
        vec3(0.0, 22.0, 1.0),
    ];
    let near = |(found, expected): (&Vec3, Vec3)| found.abs_diff_eq(expected, 1e-5);
    assert!(part.positions.iter().zip(expected).all(near), "{:?}", part.positions);
    assert_eq!((part.triangles.len(), part.colours.len()), (2, 6));
    assert_eq!(part.triangles[1], [3, 4, 5]);
    let uneven = format!(r#""TRANSLATION":{moves},"SCALE":{colours}"#);
    assert_eq!(
        message("a.gltf", json(&uneven)),
        "a.gltf: node 0: has 3 instances by their SCALE, expected 2"
    );
    assert_eq!(
        message("a.gltf", json(r#""SCALE":99"#)),
        "a.gltf: node 0: has no accessor for the instances' SCALE"
    );
}

#[test]
fn a_strip_with_a_restart_is_two_strips() {
    let mut data = Data::default();
    let vertices: Vec<f32> = (0..6).flat_map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
    let positions = data.add("VEC3", F32, 6, &floats(&vertices));
    let bytes = data.add("SCALAR", 5121, 7, &[0, 1, 2, 255, 3, 4, 5]);
    let json = |mode: u32| {
        data.primitive(&format!(
            r#""attributes":{{"POSITION":{positions}}},"indices":{bytes},"mode":{mode}"#
        ))
    };
    for mode in [5, 6] {
        assert_eq!(loaded("a.gltf", json(mode)).unwrap()[0].triangles, [[0, 1, 2], [3, 4, 5]]);
    }
    assert_eq!(
        message("a.gltf", json(4)),
        "a.gltf: node 0, primitive 0: has the vertex index 255, expected one below 6"
    );
    assert_eq!(
        message("a.gltf", json(0)),
        "a.gltf: has no triangles with an area, expected at least one: it has 1 primitive of points \
         or lines"
    );
}

#[test]
fn the_scene_is_the_named_one_or_the_first_or_all_nodes() {
    let mut data = Data::default();
    let triangle = data.triangle();
    let json = |scenes: &str| {
        data.file(&format!(
            r#"{scenes}"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{triangle}}}}}]}}],
            "nodes":[{{"mesh":0,"translation":[1,0,0]}},{{"children":[0],"mesh":0}},{{}}]"#
        ))
    };
    let first = |scenes: &str| {
        let parts = loaded("a.gltf", json(scenes)).unwrap();
        (parts.len(), parts[0].positions[0].x)
    };
    let two = r#""scenes":[{"nodes":[0]},{"nodes":[1,2]}],"#;
    assert_eq!(first(two), (1, 1.0));
    assert_eq!(first(&format!(r#""scene":1,{two}"#)), (2, 0.0));
    assert_eq!(first(""), (2, 0.0), "node 0 has a parent and is drawn once");
}

#[test]
fn another_version_and_a_broken_file_are_one_sentence() {
    let old = r#"{"asset":{"version":"1.0"},"accessors":{"a":{}},"buffers":{}}"#;
    for old in [old.to_owned(), old.replace(r#""1.0""#, "1")] {
        assert_eq!(message("a.gltf", old), "a.gltf: is glTF 1.0, expected glTF 2.0");
    }
    assert_eq!(
        message("a.gltf", r#"{"asset":{"version":"1.1"},"scenes":[{}]}"#),
        "a.gltf: is glTF 1.1, expected glTF 2.0"
    );
    for unstated in [r#"{"asset":{"version":1.0},"meshes":{}}"#, r#"{"meshes":{}}"#] {
        assert_eq!(message("a.gltf", unstated), "a.gltf: is glTF 1.0, expected glTF 2.0");
    }
    let mut binary = b"glTF".to_vec();
    binary.extend([1u32, 24, 4, 0].map(u32::to_le_bytes).concat());
    binary.extend(b"{}  ");
    assert_eq!(message("a.glb", binary), "a.glb: is glTF 1.0, expected glTF 2.0");
    let many = vec![r#"{"nodes":[7]}"#; 40].join(",");
    let json = format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{many}]}}"#);
    assert_eq!(
        message("a.gltf", json),
        "a.gltf: expected glTF 2.0: scenes[0].nodes[0]: Index out of bounds, and 39 more like it"
    );
}

/// A triangle whose vertices follow two joints.
pub(super) fn skinned() -> String {
    let mut weights = [0.0; 12];
    (weights[0], weights[4], weights[8], weights[9]) = (1.0, 1.0, 0.25, 0.75);
    bound(weights)
}

/// The same with these weights.
fn bound(weights: [f32; 12]) -> String {
    let mut data = Data::default();
    let triangle = data.triangle();
    let joints = data.add("VEC4", 5121, 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = data.add("VEC4", F32, 3, &floats(&weights));
    let matrix = |z: f32| {
        let mut matrix = glam::Mat4::IDENTITY;
        matrix.w_axis.z = z;
        matrix.to_cols_array()
    };
    let inverse = data.add("MAT4", F32, 2, &floats(&[matrix(0.0), matrix(-3.0)].concat()));
    data.file(&format!(
        r#""scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0,"skin":0,"translation":[99,0,0]}},
            {{"translation":[0,0,1],"children":[2]}},{{"translation":[8,0,0]}}],
        "skins":[{{"joints":[1,2],"inverseBindMatrices":{inverse}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{triangle},
            "JOINTS_0":{joints},"WEIGHTS_0":{weights}}}}}]}}]"#
    ))
}

#[test]
fn vertices_follow_the_joints_of_their_skin() {
    let json = skinned();
    // The joints move by (0, 0, 1), and by (8, 0, 1) after (0, 0, -3); the node of the mesh does not count.
    assert_eq!(
        positions(&json),
        [vec3(0.0, 0.0, 1.0), vec3(9.0, 0.0, -2.0), vec3(6.0, 1.0, 0.25 - 0.75 * 2.0)]
    );
    assert_eq!(
        positions(&bound([0.0; 12])),
        TRIANGLE.map(|at| at + Vec3::Z),
        "no joint: the first"
    );
    let unbound = json.replace(r#""JOINTS_0":1,"WEIGHTS_0":2"#, r#""_":0"#);
    assert_eq!(positions(&unbound), TRIANGLE.map(|at| at + 99.0 * Vec3::X), "as its node");
    let refused = |from: &str, to: &str| message("a.gltf", json.replace(from, to));
    assert_eq!(
        refused(r#""joints":[1,2]"#, r#""joints":[1]"#),
        "a.gltf: node 0, primitive 0: has the joint 1, expected one below 1"
    );
    assert_eq!(
        refused(r#""nodes":[0,1]"#, r#""nodes":[0]"#),
        "a.gltf: node 0, primitive 0: its joint, node 1, is not in the scene"
    );
    assert_eq!(
        refused(r#""joints":[1,2]"#, r#""joints":[1,2,1]"#),
        "a.gltf: node 0, primitive 0: accessor 3 has 2, expected 3"
    );
}

/// A triangle with a target that an animation gives its weight, at a node that it moves.
fn animated(data: &mut Data, outputs: Option<[usize; 2]>) -> String {
    let triangle = data.triangle();
    let target = data.add("VEC3", F32, 3, &floats(&[0.0, 0.0, 2.0, 0.0, 0.0, 4.0, 0.0, 0.0, 6.0]));
    let times = data.add("SCALAR", F32, 2, &floats(&[0.0, 1.0]));
    let animation = outputs.map(|[moves, weights]| {
        format!(
            r#","animations":[{{"samplers":[{{"input":{times},"output":{moves}}},
                {{"input":{times},"output":{weights}}}],
            "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}},
                {{"sampler":1,"target":{{"node":0,"path":"weights"}}}}]}}]"#
        )
    });
    data.file(&format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":[1,0,0]}}],
        "meshes":[{{"weights":[0.25],"primitives":[{{"attributes":{{"POSITION":{triangle}}},
            "targets":[{{"POSITION":{target}}}]}}]}}]{}"#,
        animation.unwrap_or_default()
    ))
}

/// Values of such an animation at 0 and 1 second.
fn outputs(data: &mut Data) -> [usize; 2] {
    let moves = data.add("VEC3", F32, 2, &floats(&[5.0, 0.0, 0.0, 9.0, 0.0, 0.0]));
    [moves, data.add("SCALAR", F32, 2, &floats(&[0.5, 1.0]))]
}

/// A file with an animation.
pub(super) fn moving() -> String {
    let mut data = Data::default();
    let outputs = outputs(&mut data);
    animated(&mut data, Some(outputs))
}

#[test]
fn the_first_animation_moves_nodes_and_morph_targets() {
    let moved = |x: f32, weight: f32| {
        [vec3(x, 0.0, 2.0 * weight), vec3(x + 1.0, 0.0, 4.0 * weight), vec3(x, 1.0, 6.0 * weight)]
    };
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.gltf");
    let at = |json: &str, seconds: f32| {
        fs::write(&path, json).unwrap();
        let loaded = super::super::load(path.to_str().unwrap(), Room::new(None), seconds).unwrap();
        (loaded.parts[0].positions.clone(), loaded.moves)
    };
    let still = animated(&mut Data::default(), None);
    assert_eq!(at(&still, 0.5), (moved(1.0, 0.25).to_vec(), false), "as nodes and mesh say");
    // After a second it starts again.
    for (seconds, x, weight) in
        [(0.0, 5.0, 0.5), (0.25, 6.0, 0.625), (0.5, 7.0, 0.75), (1.5, 7.0, 0.75)]
    {
        assert_eq!(at(&moving(), seconds), (moved(x, weight).to_vec(), true));
    }
    assert_eq!(
        message("a.gltf", moving().replace(r#""target":{"node":0"#, r#""target":{"node":7"#)),
        "a.gltf: animation 0 moves node 7, expected one below 1"
    );
    let other = moving().replace(r#""path":"translation""#, r#""path":"pointer""#);
    assert_eq!(at(&other, 0.5).0, moved(1.0, 0.75), "what is not known is passed over");
    let mut data = Data::default();
    let [moves, _] = outputs(&mut data);
    let three = data.triangle();
    assert_eq!(
        message("a.gltf", animated(&mut data, Some([moves, three]))),
        "a.gltf: animation 0, node 0: has 3 values of a curve, expected 2"
    );
}

/// It moves by 4 units a second, from 5 on: through the half of a 24th of a second, each frame in the middle of its part.
#[test]
fn while_the_shutter_is_open_an_animation_plays() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, moving()).unwrap();
    let varied = Varied { vary: Vary::Motion, frames: 3 };
    let options = Options { sequence: Some(Sequence::Varied(varied)), ..Options::default() };
    let first = Scene::open(path.to_str().unwrap(), &options).unwrap();
    let later = (1..3).map(|k| first.later(k).unwrap().unwrap());
    let lefts = [first.contents()].into_iter().chain(later.map(|scene| scene.contents()));
    for (k, contents) in (0..).zip(lefts.collect::<Vec<_>>()) {
        let [[left, ..], _] = contents.unwrap().bounds().unwrap();
        let seconds = (k as f32 + 0.5) / 3.0 / 48.0;
        assert!((left - (5.0 + 4.0 * seconds)).abs() < 1e-5, "{k}: {left}");
    }
}
