//! Material libraries: what is read, what is passed over and what is refused.

use super::*;
use crate::room::Room;

/// The materials of a library of this content.
fn library(content: &str) -> Result<Library, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.mtl"), content).unwrap();
    let mesh = folder.path().join("a.obj");
    let mut library = Library::default();
    library.load(&mut Reading::new(mesh.to_str().unwrap(), Room::new(None)), "a.mtl")?;
    Ok(library)
}

/// The colour and opacity of the material `m` that these statements make.
fn look(statements: &str) -> (Option<Vec3>, f32) {
    let mut library = library(&format!("newmtl m\n{statements}\n")).unwrap();
    let material = library.get("m").unwrap();
    (material.diffuse, material.alpha())
}

#[test]
fn opacity_is_d_or_what_tr_leaves_or_one() {
    for (statements, alpha) in [
        ("", 1.0),
        ("d 0.25", 0.25),
        ("d -halo .25", 0.25),
        ("Tr 0.25", 0.75),
        ("Tr 0.25\nd 0.5", 0.5),
        ("d 0.5\nTr 0.25", 0.5),
        ("d 7", 1.0),
        ("Tr +1.", 0.0),
        ("d 1 # opaque", 1.0),
    ] {
        assert_eq!(look(statements), (None, alpha), "{statements:?}");
    }
}

#[test]
fn what_does_not_concern_the_picture_is_passed_over() {
    let grey = Some(Vec3::splat(0.5));
    for other in [
        "illum",
        "illum x",
        "Ks",
        "Ks 1",
        "Ka 0 0",
        "Ke",
        "Ns many",
        "Ni",
        "map_Bump",
        "bump -bm 1 a.png",
        "norm n.png",
        "Pr 0.5",
        "unheard of",
        "# Kd 1 1 1",
        "Kd xyz 1 1 1",
        "Kd spectral a.rfl",
    ] {
        assert_eq!(look(&format!("Kd 0.5\n{other}")), (grey, 1.0), "{other:?}");
    }
    assert_eq!(look("Kd 1 0.5 2").0, Some(Vec3::new(1.0, 0.5, 1.0)));
    assert_eq!(library("d 0.5\nKd 1 1 1\nnewmtl\nd 0.5").unwrap().get("").unwrap().alpha(), 0.5);
}

#[test]
fn what_concerns_it_and_cannot_be_read_is_refused_with_its_line() {
    for (statement, expected) in [
        ("Kd", "three numbers after Kd"),
        ("Kd 1 2", "three numbers after Kd"),
        ("Kd 1 nan 0", "three numbers after Kd"),
        ("d", "a number after d"),
        ("d -halo", "a number after d"),
        ("Tr x", "a number after Tr"),
    ] {
        let error =
            library(&format!("\nnewmtl m\n{statement}\n")).err().expect(statement).to_string();
        assert!(error.ends_with(&format!("a.mtl, line 3: expected {expected}")), "{error}");
    }
}

#[test]
fn a_map_has_options_and_then_a_name_that_may_have_blanks() {
    let plain = Map {
        keyword: "map_Kd",
        file: "a.png".into(),
        offset: Vec3::ZERO,
        scale: Vec3::ONE,
        clamp: false,
    };
    let of = |rest: &str| map("map_Kd", rest);
    assert_eq!(of("a.png"), Some(plain.clone()));
    let named = |file: &str| Some(Map { file: file.into(), ..plain.clone() });
    assert_eq!(of("my wood.png"), named("my wood.png"));
    assert_eq!(
        of("-bm 1 -mm 0 1 -blendu off -imfchan r textures\\a.png"),
        named("textures\\a.png")
    );
    let (offset, scale) = (Vec3::new(0.5, 0.25, 0.0), Vec3::new(2.0, 1.0, 1.0));
    let placed = Map { offset, scale, clamp: true, ..plain.clone() };
    assert_eq!(of("-o 0.5 0.25 -s 2 -t 1 1 1 -clamp on a.png"), Some(placed.clone()));
    // Twice over the image, then moved; the image's rows run downwards.
    assert_eq!(placed.place(Vec2::new(0.25, 0.5)), Vec2::new(1.0, 0.25));
    for nothing in ["", "-clamp on", "-clamp", "-unknown 1 a.png"] {
        assert_eq!(of(nothing), None, "{nothing:?}");
    }
}
