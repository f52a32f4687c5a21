//! Meshes: the bytes are a scene in one of the formats, or refused with the file and, where there are lines, the line.
//!
//! A comment more moves every line by one and changes nothing else; compressed they are the same mesh.

use crate::{lines, write};
use flate2::Compression;
use flate2::write::GzEncoder;
use pellucid_machine::pixel::{Fragment, Z_FAR};
use pellucid_testbench::scene::{Options, Scene, SceneError};
use std::fs;
use std::io::Write;
use std::path::Path;

/// A small screen: what the checks compare takes little time and memory.
const WIDTH: u32 = 16;
const HEIGHT: u32 = 12;
/// An opacity, and the alpha that every fragment has by it.
const ALPHA: (&str, u32) = ("0.4", 102);

/// Marks of UTF-8 and UTF-16.
const MARKS: [&[u8]; 3] = [b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"];
/// The most memory that a mesh may take.
const MEMORY: &str = "64M";

/// What a mesh gives: how many triangles, and the fragments. Or the line and what is wrong with it.
type Outcome = Result<(usize, Vec<Fragment>), (Option<usize>, String)>;

/// Reads the bytes as every format.
///
/// # Panics
/// They are not read or refused as they must be.
pub fn check(bytes: &[u8]) {
    let obj = outcome("mesh.obj", bytes, 0);
    // A comment cannot come before the mark of an encoding.
    if !MARKS.iter().any(|mark| bytes.starts_with(mark)) {
        assert_eq!(outcome("mesh.obj", &[b"# first\n", bytes].concat(), 1), obj, "a comment more");
    }

    let ply = outcome("mesh.ply", bytes, 0);
    if let Some(rest) = bytes.strip_prefix(b"ply\n") {
        let longer = [b"ply\nobj_info first\n", rest].concat();
        assert_eq!(outcome("mesh.ply", &longer, 1), ply, "a comment more");
        let mut encoder = GzEncoder::new(vec![], Compression::fast());
        let done = encoder.write_all(bytes).and_then(|()| encoder.finish());
        assert_eq!(outcome("mesh.ply.gz", &done.expect("it goes to memory"), 0), ply, "compressed");
    }
    let _ = outcome("mesh.ply.gz", bytes, 0);
    // The same loader reads the text and the binary form.
    let _ = outcome("mesh.gltf", bytes, 0);
}

/// What the file gives, its lines counted without the first `more`.
fn outcome(name: &str, bytes: &[u8], more: usize) -> Outcome {
    let path = write(name, bytes);
    let shown = path.to_str().expect("a temporary folder has a plain name");
    let memory_limit = Some(MEMORY.parse().expect("a limit"));
    let (width, height) = (Some(WIDTH), Some(HEIGHT));
    let options = Options { width, height, memory_limit, ..Options::default() };
    let scene = match Scene::open(shown, &options) {
        Ok(scene) => scene,
        Err(error) => {
            // The lines of what is compressed are not seen here.
            let lines = if name.ends_with(".gz") { usize::MAX } else { lines(bytes) };
            return Err(refusal(&error, &path, lines, more));
        }
    };
    let fragments = played(&scene);
    assert!(scene.primitives() > 0, "an empty scene is opened");
    for f in &fragments {
        assert!(f.x < WIDTH && f.y < HEIGHT && f.z < Z_FAR, "{f:?} outside the screen");
    }
    assert_eq!(played(&scene), fragments, "a second play");

    let (text, alpha) = ALPHA;
    let options = Options { alphas: vec![text.parse().expect("an alpha")], ..options };
    let even = played(&Scene::open(shown, &options).expect("an alpha for all changes no more"));
    let place = |f: &Fragment| (f.x, f.y, f.z);
    assert!(even.iter().map(place).eq(fragments.iter().map(place)), "an alpha moves a fragment");
    assert!(even.iter().all(|f| f.rgba & 0xff == alpha), "an alpha for all is that of each");
    Ok((scene.primitives(), fragments))
}

fn played(scene: &Scene) -> Vec<Fragment> {
    let mut fragments = vec![];
    let Ok(()) = scene.play::<std::convert::Infallible>(&mut |fragment| {
        fragments.push(fragment);
        Ok(())
    });
    fragments
}

/// The line and what is wrong, checked against a file of so many lines.
fn refusal(error: &SceneError, mesh: &Path, lines: usize, more: usize) -> (Option<usize>, String) {
    let text = error.to_string();
    match error {
        SceneError::Mesh { path, line: Some(line), what } if is(path, mesh) => {
            // The line that is missing at the end is one more.
            assert!((1..=lines.saturating_add(1)).contains(line), "line {line} of {lines}: {text}");
            (Some(line.checked_sub(more).unwrap_or_default()), what.clone())
        }
        SceneError::Mesh { path, line, what } => {
            assert!(text.starts_with(path), "no file is named: {text}");
            let lined = !path.ends_with(".obj") || what.starts_with("has no triangles");
            assert!(lined, "no line is named: {text}");
            (*line, what.clone())
        }
        // A material library or a buffer that the mesh names.
        SceneError::Unreadable { path, .. } => {
            assert!(text.starts_with(path), "no file is named: {text}");
            assert!(!is(path, mesh), "the mesh itself can be read: {text}");
            (None, text)
        }
        SceneError::Memory { path, source } => {
            assert!(text.starts_with(path), "no file is named: {text}");
            (None, source.to_string())
        }
        _ => panic!("refused by {error:?}"),
    }
}

/// Whether the path leads to that file.
fn is(path: &str, file: &Path) -> bool {
    fs::canonicalize(path).ok() == fs::canonicalize(file).ok()
}
