//! Textures of OBJ materials.

use super::materials::{drawn, png};
use super::*;

const SQUARE: &str = "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n";

/// A folder with such a square, its material of these statements, and these images.
fn folder(statements: &str, images: &[(&str, Vec<u8>)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.obj"), SQUARE).unwrap();
    fs::write(folder.path().join("a.mtl"), format!("newmtl m\n{statements}\n")).unwrap();
    for (name, bytes) in images {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

/// The colours of the square's 4 x 4 pixels, row by row from the top.
fn colours(folder: &TempDir, alphas: &[&str]) -> Vec<[u8; 4]> {
    let mut fragments = drawn(&folder.path().join("a.obj"), alphas);
    fragments.sort_by_key(|fragment| (fragment.y, fragment.x));
    assert_eq!(fragments.len(), 16);
    fragments.iter().map(|fragment| fragment.rgba.to_be_bytes()).collect()
}

fn one(statements: &str, images: &[(&str, Vec<u8>)]) -> [u8; 4] {
    colours(&folder(statements, images), &[])[0]
}

const WHITE: [u8; 4] = [255; 4];

#[test]
fn the_first_row_of_a_texture_is_at_the_top() {
    let [red, green, blue] = [[200, 0, 0, 255], [0, 200, 0, 255], [0, 0, 200, 255]];
    let image = png(2, &[red, green, blue, WHITE]);
    // The texel that only one channel has: which channel is there shows which texel.
    let folder = folder("map_Kd -clamp on a.png", &[("a.png", image)]);
    let colours = colours(&folder, &[]);
    let there = |i: usize| colours[i].map(|channel| channel > 100);
    let expected = |texel: [u8; 4]| texel.map(|channel| channel > 100);
    assert_eq!([0, 3, 12, 15].map(there), [red, green, blue, WHITE].map(expected));
}

#[test]
fn a_texture_is_multiplied_by_the_diffuse_colour() {
    let white = || [("a.png", png(1, &[WHITE]))];
    let near = |found: [u8; 4], expected: [u8; 4]| {
        assert!((0..4).all(|i| found[i].abs_diff(expected[i]) <= 1), "{found:?}, {expected:?}");
    };
    near(one("Kd 0.5 0.2 0\nmap_Kd a.png", &white()), one("Kd 0.5 0.2 0", &[]));
    near(one("map_Kd a.png", &white()), one("Kd 1 1 1", &[]));
    let texel = [51, 102, 153, 255];
    near(one("Kd 1 1 1\nmap_Kd a.png", &[("a.png", png(1, &[texel]))]), one("Kd 0.2 0.4 0.6", &[]));
}

#[test]
fn opacity_is_d_times_the_map_of_it() {
    let images = || {
        [("clear.png", png(1, &[[255, 255, 255, 64]])), ("grey.png", png(1, &[[30, 60, 90, 255]]))]
    };
    let alpha = |statements: &str| one(statements, &images())[3];
    assert_eq!(alpha("map_Kd clear.png"), 255, "alpha of the colours says nothing");
    assert_eq!(alpha("d 0.5\nmap_Kd clear.png"), 128);
    assert_eq!(alpha("map_d clear.png"), 64);
    assert_eq!(alpha("map_d grey.png"), 60, "the mean of the channels");
    assert_eq!(alpha("Tr 0.5\nmap_d grey.png\nmap_Kd grey.png"), 30);
    let folder = folder("map_d grey.png", &images());
    assert_eq!(colours(&folder, &["m=0.4"])[0][3], 102, "a rule wins");
}

#[test]
fn what_of_textures_is_not_seen_is_noted() {
    let notes = |folder: &TempDir| {
        let path = folder.path().join("a.obj");
        let loaded = super::super::load(path.to_str().unwrap(), Room::new(None), 0.0).unwrap();
        let shown = format!("{}/", folder.path().display());
        loaded.notes.iter().map(|note| note.replace(&shown, "")).collect::<Vec<_>>()
    };
    let missing = folder("map_Kd none.png\nmap_d a.tga", &[("a.tga", vec![0; 50])]);
    assert_eq!(
        notes(&missing),
        ["a.obj: not seen: 1 image that does not exist (`none.png`), \
          1 image that is no PNG or JPEG (`a.tga`)"]
    );
    let placeless = folder("map_Kd a.png", &[("a.png", png(1, &[WHITE]))]);
    let text = SQUARE.replace("1/1 2/2 3/3 4/4", "1/1 2 3/3 4/9");
    fs::write(placeless.path().join("a.obj"), text).unwrap();
    assert_eq!(
        notes(&placeless),
        ["a.obj: 1 face has no texture coordinates (line 11): the texture is read at 0, 0 there"]
    );
    let bad = folder("map_Kd a.png", &[("a.png", png(1, &[WHITE])[..40].to_vec())]);
    let path = bad.path().join("a.obj");
    let error = load(path.to_str().unwrap()).unwrap_err().to_string();
    assert!(error.contains("a.png: is no valid PNG: "), "{error}");
}
