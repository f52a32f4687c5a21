//! OBJ with and without its material library.

use super::ply::SQUARE;
use super::*;
use glam::vec4;

pub(super) const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no door\nusemtl tinted\nf 1 2 3 4\ng knob\nf -1 -2 -3\n";

#[test]
fn an_obj_has_a_part_for_each_object_and_material() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, OBJ).unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl tinted\nKd 1 0.5 0\nd 0.25\n").unwrap();
    let parts = load(path.to_str().unwrap()).unwrap();
    assert_eq!(
        parts.iter().map(|part| &part.names[..]).collect::<Vec<_>>(),
        [["door", "tinted"], ["knob", "tinted"]]
    );
    assert_eq!(parts[0].positions, SQUARE);
    assert_eq!(parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(parts[1].colours, [vec4(1.0, 0.5, 0.0, 0.25); 3]);

    fs::write(folder.path().join("a.mtl"), "newmtl tinted\nKd 1 0.5\n").unwrap();
    let error = load(path.to_str().unwrap()).unwrap_err().to_string();
    assert!(error.ends_with("a.mtl, line 2: expected three numbers after Kd"), "{error}");
}

#[test]
fn libraries_are_several_or_one_with_blanks_and_one_that_is_missing_is_noted_once() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.obj");
    let loaded = |text: String| {
        fs::write(&path, text).unwrap();
        super::super::load(path.to_str().unwrap(), Room::new(None), 0.0).unwrap()
    };
    let alphas = |loaded: &Loaded| loaded.parts.iter().map(|part| part.alpha).collect::<Vec<_>>();
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::write(folder.path().join("one.mtl"), "newmtl one\nd 0.25\n").unwrap();
    fs::write(folder.path().join("sub/two.mtl"), "newmtl two\nd 0.75\n").unwrap();
    fs::write(folder.path().join("a b.mtl"), "newmtl three\nd 0.125\n").unwrap();
    let faces = "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl one\nf 1 2 3\nusemtl two\nf 1 2 3\nusemtl three\nf 1 2 3\n";
    let all = loaded(format!("mtllib one.mtl  sub\\two.mtl\nmtllib a b.mtl\n{faces}"));
    assert_eq!(alphas(&all), [0.25, 0.75, 0.125]);
    assert_eq!((all.notes, all.has_no_opacity), (vec![], false));

    let some =
        loaded(format!("mtllib one.mtl no.mtl\nmtllib ./no.mtl one.mtl\nmtllib no.mtl\n{faces}"));
    assert_eq!(alphas(&some), [0.25, 0.5, 0.5]);
    assert!(some.has_no_opacity);
    let (shown, missing) = (path.display(), folder.path().join("no.mtl"));
    let first = format!("{shown}: the material library `{}` does not exist", missing.display());
    assert_eq!(some.notes[0], first);
    assert_eq!(
        some.notes.last().unwrap(),
        &format!("{shown}: the material `two`, and others, is in no library")
    );
}

#[test]
fn a_line_is_read_as_those_who_write_it_mean_it() {
    // An obj as such, and the corners of its faces.
    let corners = |text: &str| {
        let parts = loaded("a.obj", text).unwrap();
        let of = |part: &Part| {
            part.triangles.iter().flatten().map(|&i| part.positions[i as usize]).collect::<Vec<_>>()
        };
        parts.iter().flat_map(of).collect::<Vec<_>>()
    };
    let [a, b, c, d] = SQUARE;
    let plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for faces in [
        "f 1 2 \\\n3 4\n",
        "f 1 2 3 4 # the door\n",
        "fo 1/ 2/7 3// 4/-9/\n",
        "f -4//1 -3//9 -2//-7 -1\n",
        "usemtl\ng\no\ns off\nvt 0.5\nvn 1. .5 -1e-3\nf 1 2 3 4\n",
        "\tf\t1 2 3 4\r\n",
    ] {
        assert_eq!(corners(&format!("{plain}{faces}")), [a, b, c, a, c, d], "{faces:?}");
    }
    assert_eq!(
        corners(&format!("f 1 2 3 4\n{plain}")),
        [a, b, c, a, c, d],
        "vertices may come below"
    );
    let numbers = "v +0 -.0 0e9\rv 1. 0 0.\rv 3 +3 0 3\rf 1 2 3\r";
    assert_eq!(corners(numbers), [a, b, c]);
    assert_eq!(corners(&format!("{plain}f 1 2 3\n").replace("1 1 0", "1 1 0 1 0 0")), [a, b, c]);
    let mut bytes = format!("# \0 \ng ?\n{plain}f 1 2 3 4\n").into_bytes();
    bytes.iter_mut().filter(|byte| matches!(byte, 0 | b'?')).for_each(|byte| *byte = 0xe9);
    assert_eq!(loaded("a.obj", bytes).unwrap()[0].names, ["\u{fffd}"]);
}

#[test]
fn what_an_obj_has_beside_faces_is_named() {
    let plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 2 0\n";
    assert_eq!(
        message("a.obj", format!("{plain}p 1\np 2\nl 1 2\nf 1 3 4\nf 1\nf\n")),
        "a.obj: has no triangles with an area, expected at least one: it has 3 faces without an area, \
         2 statements of points, 1 line"
    );
    assert_eq!(
        notes("a.obj", format!("{plain}l 1 2\ncurv 1 2\ncurv 1 3\nf 1//1 2//1 3//1\n")),
        [
            "a.obj: 1 face has a normal that there is not (line 8): normals are made there",
            "a.obj: statements that are not known are passed over: curv",
            "a.obj: not seen: 1 line (line 5)",
        ]
    );
    let crossed = "v 0 0 0\nv 4 0 0\nv 0 3 0\nv 5 4 0\nf 1 2 3 4\n";
    assert_eq!(
        notes("a.obj", crossed),
        ["a.obj: 1 face crosses itself (line 5): pixels may be covered twice there, or not at all"]
    );
}

#[test]
fn vertices_without_a_colour_among_others_have_that_of_the_material_or_are_white() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
    let red = vec4(1.0, 0.0, 0.0, 0.5);
    let white = vec4(1.0, 1.0, 1.0, 0.5);
    assert_eq!(loaded("a.obj", text).unwrap()[0].colours, [red, white, white]);
    let first = text.replace(" 1 0 0\nv 1 0 0\n", "\nv 1 0 0 1 0 0\n");
    assert_eq!(loaded("a.obj", first).unwrap()[0].colours, [white, red, white]);
}

#[test]
fn a_concave_face_keeps_to_its_outline() {
    let text = "v 1 1 0\nv 0 -0.5 0\nv -1 1 0\nv -1 -1 0\nv 1 -1 0\nf 1 2 3 4 5\n";
    let parts = loaded("a.obj", text).unwrap();
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|i| parts[0].positions[i as usize]);
        (b - a).cross(c - a).z / 2.0
    };
    let areas: Vec<f32> = parts[0].triangles.iter().map(area).collect();
    // The square of side 2, seen from behind, without the triangle of base 2 and height 1.5.
    assert_eq!(areas.iter().sum::<f32>().abs(), 4.0 - 1.5);
    assert!(
        areas.iter().all(|area| *area > 0.0) || areas.iter().all(|area| *area < 0.0),
        "{areas:?}"
    );
}

#[test]
fn an_obj_without_its_library_is_half_transparent() {
    let parts = loaded("a.obj", OBJ).unwrap();
    assert!(parts.iter().all(|part| part.colours.is_empty() && part.alpha == 0.5));
    let coloured = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n";
    let expected = [vec4(1.0, 0.0, 0.0, 0.5), vec4(0.0, 1.0, 0.0, 0.5), vec4(0.0, 0.0, 1.0, 0.5)];
    assert_eq!(loaded("a.obj", coloured).unwrap()[0].colours, expected);
}

#[test]
fn a_bad_obj_is_refused_with_its_line() {
    let vertex = "expected a vertex as v X Y Z, v X Y Z W or v X Y Z R G B, of finite numbers";
    let face = "expected a face as f V V V, with indices as V, V/T, V//N or V/T/N";
    let cases = [
        (OBJ.replace("v 1 1 0", "v 1 1"), format!("4: {vertex}")),
        (OBJ.replace("v 1 1 0", "v inf 1 0"), format!("4: {vertex}")),
        (OBJ.replace("v 1 1 0", "v nan 1 0"), format!("4: {vertex}")),
        (OBJ.replace("v 1 1 0", "v 1 1 0 1 1"), format!("4: {vertex}")),
        (OBJ.replace("v 1 1 0", "v 1 1 0 1e-45"), "4: the vertex is not finite".into()),
        (
            OBJ.replace("v 1 1 0", "v 1 1 0 0"),
            "4: expected a vertex as v X Y Z W with W other than 0".into(),
        ),
        (OBJ.replace("v 1 1 0", "vn 1 1"), "4: expected a normal as vn X Y Z".into()),
        (OBJ.replace("v 1 1 0", "vt"), "4: expected a texture coordinate as vt U V".into()),
        (
            OBJ.replace("1 2 3 4", "1 2 3 5"),
            "8: vertex index 5 is out of range, expected 1..=4".into(),
        ),
        (
            OBJ.replace("1 2 3 4", "1 2 3 0"),
            "8: vertex index 0 is out of range, expected one from 1, or from -1 backwards".into(),
        ),
        (
            OBJ.replace("-1 -2 -3", "-1 -2 -5"),
            "10: vertex index -5 is out of range, 4 vertices come before".into(),
        ),
        (OBJ.replace("1 2 3 4", "1 2 x"), format!("8: found `x`, {face}")),
        (OBJ.replace("1 2 3 4", "1 2 3/1/1/1"), format!("8: found `3/1/1/1`, {face}")),
        (OBJ.replace("1 2 3 4", "1 \\\n2 x"), format!("8: found `x`, {face}")),
        (
            OBJ.replace("f 1 2 3 4", &format!("f{}", " 1".repeat(65_537))),
            "8: a face has 65537 corners, expected at most 65536".into(),
        ),
        ("# a\r\rv 0 0\r".to_owned(), format!("3: {vertex}")),
    ];
    for (file, expected) in cases {
        assert_eq!(message("a.obj", file), format!("a.obj, line {expected}"));
    }
    let none = "a.obj: has no triangles with an area, expected at least one";
    assert_eq!(message("a.obj", "# none\n"), none);
    assert_eq!(message("a.obj", "v 0 0 0\n"), format!("{none}: it has 1 vertex"));
}
