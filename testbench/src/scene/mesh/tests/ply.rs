//! PLY, ASCII and binary, plain and compressed.

use super::*;
use glam::{Vec3, vec3, vec4};

pub(super) const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
pub(super) const SQUARE: [Vec3; 4] = [Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), Vec3::Y];

#[test]
fn an_ascii_ply_is_cut_into_fans_whatever_the_case_of_its_name() {
    for part in [loaded("a.PLY", PLY), loaded("a.Ply.gZ", gzip(PLY.as_bytes()))] {
        let [part] = &part.unwrap()[..] else { panic!("one part") };
        assert_eq!(part.names, ["a"]);
        assert_eq!(part.positions, SQUARE);
        assert_eq!(part.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(part.colours.is_empty() && part.alpha == 0.5);
    }
}

#[test]
fn a_binary_ply_gives_the_same_in_both_byte_orders() {
    for big in [false, true] {
        let order = if big { "big" } else { "little" };
        let mut file = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\n\
             property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float alpha\n\
             element face 1\nproperty list uchar uint vertex_index\nend_header\n"
        )
        .into_bytes();
        let ordered = |mut bytes: Vec<u8>| {
            if big {
                bytes.reverse();
            }
            bytes
        };
        for p in SQUARE {
            file.extend(ordered(f64::from(p.x).to_le_bytes().to_vec()));
            file.extend([p.y, p.z].into_iter().flat_map(|v| ordered(v.to_le_bytes().to_vec())));
            file.extend([255, 51, 0]);
            file.extend(ordered(0.25f32.to_le_bytes().to_vec()));
        }
        file.push(4);
        file.extend((0..4u32).flat_map(|i| ordered(i.to_le_bytes().to_vec())));
        let parts = loaded("b.ply", &file).unwrap();
        assert_eq!(parts[0].positions, SQUARE);
        assert_eq!(parts[0].colours, [vec4(1.0, 0.2, 0.0, 0.25); 4]);
        assert_eq!(parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
        file.pop();
        assert_eq!(
            message("b.ply", &file),
            "b.ply: the file ends early: the header declares 1 of the element `face`"
        );
    }
}

#[test]
fn a_bad_ply_is_refused_with_its_line() {
    let cases = [
        (PLY.replace("ply\n", "plx\n"), "a.ply, line 1: expected `ply` as the first line"),
        (
            PLY.replace("float y", "flat y"),
            "a.ply, line 5: `property flat y` is no line of a PLY header",
        ),
        (PLY.replace("end_header\n", ""), "a.ply, line 9: `0 0 0` is no line of a PLY header"),
        (
            PLY.replace("end_header", "comment"),
            "a.ply: the file ends in the header, expected `end_header`",
        ),
        (
            PLY.replace("element face 1", "element vertex 1"),
            "a.ply, line 7: the header has the element `vertex` a second time",
        ),
        (
            PLY.replace("float z", "float w"),
            "a.ply: the header has no number `z` in the element `vertex`",
        ),
        (
            PLY.replace("element face", "element none 4000000000\nelement face"),
            "a.ply: the header declares 4000000000 of the element `none` without a property, expected one or more",
        ),
        (
            PLY.replace("indices", "x"),
            "a.ply: the header has no list `vertex_indices` in the element `face`",
        ),
        (PLY.replace("1 1 0\n", "1 1e39 0\n"), "a.ply, line 12: vertex 2 is not finite"),
        (PLY.replace("1 1 0\n", "1 nan 0\n"), "a.ply, line 12: vertex 2 is not finite"),
        (
            PLY.replace("1 1 0\n", "1 1\n"),
            "a.ply, line 13: `1 0` is left over after an element `vertex`",
        ),
        (
            PLY.replace("1 1 0\n", "1 x 0\n"),
            "a.ply, line 12: found `x`, expected a number for `y` of an element `vertex`",
        ),
        (
            PLY.replace("4 0 1", "-4 0 1"),
            "a.ply, line 14: the list `vertex_indices` of an element `face` has -4 items, expected 0 or more",
        ),
        (
            PLY.replace("2 3\n", "2 2.5\n"),
            "a.ply, line 14: found the vertex index 2.5, expected a whole number",
        ),
        (
            PLY.replace("2 3\n", "2 4\n"),
            "a.ply, line 14: face 0 has the vertex index 4, expected one below 4",
        ),
        (
            PLY.replace("2 3\n", "2 -1\n"),
            "a.ply, line 14: face 0 has the vertex index -1, expected one below 4",
        ),
        (
            PLY.replace("4 0 1 2 3", "2 0 1"),
            "a.ply: has no triangles with an area, expected at least one: it has 1 face without an area",
        ),
        (
            PLY.replace("4 0 1 2 3\n", ""),
            "a.ply, line 14: the file ends early: the header declares 1 of the element `face`",
        ),
        (PLY[..40].to_owned(), "a.ply, line 4: `pr` is no line of a PLY header"),
        (String::new(), "a.ply: the file ends in the header, expected `end_header`"),
        (
            PLY.replace("face 1", "face 0").replace("4 0 1 2 3\n", ""),
            "a.ply: has no triangles with an area, expected at least one: it has 4 points",
        ),
    ];
    for (file, expected) in cases {
        assert_eq!(message("a.ply", file), expected);
    }
}

/// The corners of all triangles.
fn corners(part: &Part) -> Vec<[Vec3; 3]> {
    part.triangles.iter().map(|t| t.map(|i| part.positions[i as usize])).collect()
}

#[test]
fn a_text_is_read_however_its_lines_are_broken() {
    let [a, b, c, d] = SQUARE;
    for text in [
        PLY.replace('\n', "\r"),
        PLY.replace('\n', "\r\n"),
        PLY.replace("1 1 0\n", "1\n1 0\n"),
        PLY.replace("0 0 0\n", "\n 0\t0  0 \n\n"),
        PLY.replace(
            "element vertex",
            "comment made by\nsomething old, on\n\nobj_info x\nelement vertex",
        ),
        PLY.replace("element vertex", "Created by something old\nelement vertex"),
        PLY.replace("face 1", "face 3").replace("4 0 1", "0\n2 1 2\n4 0 1"),
        PLY.replace(
            "element face",
            "element edge 1\nproperty list int double x\nproperty short y\nelement face",
        )
        .replace("4 0 1", "2 1 nan 7\n4 0 1"),
    ] {
        let parts = loaded("a.ply", &text).unwrap();
        assert_eq!(corners(&parts[0]), [[a, b, c], [a, c, d]], "{text}");
    }
}

#[test]
fn strips_turn_alternately_and_begin_anew_where_they_say_so() {
    let text = PLY.replace("face 1", "tristrips 1").replace("4 0 1 2 3", "9 0 1 3 2 -1 3 2 2 1");
    let parts = loaded("a.ply", text).unwrap();
    assert_eq!(parts[0].triangles, [[0, 1, 3], [3, 1, 2]], "of four, two only lead on");
    let bad = PLY.replace("face 1", "tristrips 1").replace("4 0 1 2 3", "4 0 1 3 4");
    assert_eq!(
        message("a.ply", bad),
        "a.ply, line 14: tristrips 0 has the vertex index 4, expected one below 4"
    );
}

#[test]
fn a_face_has_its_colour_where_the_vertices_have_none() {
    let text = PLY
        .replace("element face 1", "element face 2")
        .replace(
            "end_header",
            "property float red\nproperty float green\nproperty uchar blue\nend_header",
        )
        .replace("4 0 1 2 3", "3 0 1 2 1 0.5 0\n3 0 2 3 0 0 255");
    let part = &loaded("a.ply", &text).unwrap()[0];
    let [a, b, c, d] = SQUARE;
    assert_eq!(corners(part), [[a, b, c], [a, c, d]]);
    let (orange, blue) = (vec4(1.0, 0.5, 0.0, 0.5), vec4(0.0, 0.0, 1.0, 0.5));
    assert_eq!(part.colours, [orange, orange, orange, blue, blue, blue]);
}

#[test]
fn opacity_that_a_file_does_not_state_is_told_of() {
    let with = |alpha: &str, value: &str| {
        let channels = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
        let text = PLY.replace("element face", &format!("{channels}{alpha}element face"));
        let text = SQUARE.iter().fold(text, |text, p| {
            let line = format!("\n{} {} 0", p.x, p.y);
            text.replace(&format!("{line}\n"), &format!("{line} 255 0 51{value}\n"))
        });
        with_notes("a.ply", text).unwrap()
    };
    let (without, of) = (with("", ""), with("property uchar alpha\n", " 51"));
    assert_eq!(without.parts[0].colours, [vec4(1.0, 0.0, 0.2, 0.5); 4]);
    assert_eq!(of.parts[0].colours, [vec4(1.0, 0.0, 0.2, 0.2); 4]);
    assert_eq!((without.has_no_opacity, of.has_no_opacity), (true, false));
}

#[test]
fn damaged_gzip_data_is_refused() {
    let file = gzip(PLY.as_bytes());
    assert_eq!(
        message("a.ply.gz", &file[..file.len() - 9]),
        "a.ply.gz: the gzip data is truncated"
    );
    assert_eq!(message("a.ply.gz", PLY), "a.ply.gz: expected gzip data: invalid gzip header");
    let mut damaged = file.clone();
    let middle = damaged.len() / 2;
    damaged[middle..middle + 8].fill(0xff);
    assert!(message("a.ply.gz", &damaged).starts_with("a.ply.gz: expected gzip data: "));
}

#[test]
fn splats_have_the_colour_opacity_and_shape_that_their_numbers_stand_for() {
    let names = "x y z nx f_dc_0 f_dc_1 f_dc_2 f_rest_0 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
    let properties: String =
        names.split(' ').map(|name| format!("property float {name}\n")).collect();
    let header = format!("ply\nformat ascii 1.0\nelement vertex 2\n{properties}end_header\n");
    // A tint of 1 adds 0.5 / sqrt(pi) to a half; an opacity of ln 3 is 3/4; a quarter turn about z.
    let first = "1 2 3 9 1 0 -9 9 1.0986123 0 0.6931472 -0.6931472 2 0 0 2\n";
    let text = format!("{header}{first}{}", "0 0 0 0 0 0 0 0 0 0 0 0 1 0 0 0\n");
    let loaded = with_notes("a.ply", &text).unwrap();
    let part = &loaded.parts[0];
    assert_eq!((part.positions[0], part.triangles.len()), (vec3(1.0, 2.0, 3.0), 0));
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let expected = [0.782_094_8, 0.5, 0.0, 0.75];
    assert!(
        part.colours[0].to_array().iter().zip(expected).all(|(a, b)| near(*a, b)),
        "{:?}",
        part.colours
    );
    // Variances of 1, 4 and 1/4, the first two exchanged by the turn.
    let variances = part.splats[0].to_cols_array();
    let expected = [4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25];
    assert!(variances.iter().zip(expected).all(|(a, b)| near(*a, b)), "{variances:?}");
    assert!(loaded.notes.is_empty() && !loaded.has_no_opacity);

    let bad = text.replace("0.6931472 -", "99 -");
    assert_eq!(message("a.ply", bad), "a.ply, line 21: splat 0 is not finite");
    let bad = text.replace(" 2 0 0 2\n", " 0 0 0 0\n");
    assert_eq!(message("a.ply", bad), "a.ply, line 21: splat 0 is not finite");
    let points = text.replace("rot_3", "rot_4");
    let none = "a.ply: has no triangles with an area, expected at least one: it has 2 points";
    assert_eq!(message("a.ply", points), none);
}
