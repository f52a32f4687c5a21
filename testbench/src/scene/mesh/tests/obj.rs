//! OBJ with and without its material library.

use super::ply::SQUARE;
use super::*;
use crate::scene::mesh::obj::Libraries;
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
fn a_library_that_is_named_again_is_not_read_again() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl tinted\nKd 1 0.5 0\n").unwrap();
    let path = folder.path().join("a.obj");
    let libraries = Libraries::of(path.to_str().unwrap());
    let found =
        ["a.mtl", "a.mtl", "./a.mtl"].map(|name| libraries.load(name.as_ref()).unwrap().0.len());
    assert_eq!(found, [1, 0, 0]);
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
    let cases = [
        (OBJ.replace("v 1 1 0", "v 1 1"), "a.obj, line 4: expected a vertex as v X Y Z"),
        (OBJ.replace("v 1 1 0", "v inf 1 0"), "a.obj, line 4: the vertex is not finite"),
        (OBJ.replace("v 1 1 0", "v 1 1 0 1e-45"), "a.obj, line 4: the vertex is not finite"),
        (
            OBJ.replace("v 1 1 0", "v 1 1 0 0"),
            "a.obj, line 4: expected a vertex as v X Y Z W with W other than 0",
        ),
        (
            OBJ.replace("1 2 3 4", "1 2 3 5"),
            "a.obj, line 8: vertex index 5 is out of range, expected 1..=4",
        ),
        (
            OBJ.replace("1 2 3 4", "1 2 3 0"),
            "a.obj, line 8: vertex index 0 is out of range, expected 1..=4",
        ),
        (
            OBJ.replace("-1 -2 -3", "-1 -2 -5"),
            "a.obj, line 10: vertex index -5 is out of range, expected 1..=4",
        ),
        (
            OBJ.replace("1 2 3 4", "1//1 2 3"),
            "a.obj, line 8: normal index 1 is out of range, expected 1..=0",
        ),
        (
            OBJ.replace("1 2 3 4", "1 2 x"),
            "a.obj, line 8: expected a face as f V V V, with indices as V, V/T, V//N or V/T/N",
        ),
        ("v 0 0 0\n".to_owned(), "a.obj: has no triangles, expected at least one"),
    ];
    for (file, expected) in cases {
        assert_eq!(message("a.obj", file), expected);
    }
    assert_eq!(message("a.obj", b"o \xff\n"), "a.obj, line 1: expected text in UTF-8");
}
