//! Small files of every format, good ones for what is read, bad ones for the exact message.

mod gltf;
mod gltf_data;
mod materials;
mod obj;
mod obj_textures;
mod ply;

use super::*;
use crate::room::Limit;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use tempfile::TempDir;

/// Loads the file at a path into what room there is.
fn load(path: &str) -> Result<Vec<Part>, SceneError> {
    super::load(path, Room::new(None), 0.0).map(|loaded| loaded.parts)
}

/// Loads a file of this name and content.
fn loaded(name: &str, content: impl AsRef<[u8]>) -> Result<Vec<Part>, SceneError> {
    with_notes(name, content).map(|loaded| loaded.parts)
}

/// Loads such a file, with what is to be said of it.
fn with_notes(name: &str, content: impl AsRef<[u8]>) -> Result<Loaded, SceneError> {
    within(None, name, content)
}

/// Loads such a file within a limit of memory.
fn within(
    limit: Option<Limit>,
    name: &str,
    content: impl AsRef<[u8]>,
) -> Result<Loaded, SceneError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    super::load(path.to_str().unwrap(), Room::new(limit), 0.0)
}

/// What is to be said of such a file, without its folder.
fn notes(name: &str, content: impl AsRef<[u8]>) -> Vec<String> {
    let notes = with_notes(name, content).unwrap().notes;
    notes.iter().map(|text| text[text.find(name).expect("its name")..].to_owned()).collect()
}

/// The message for such a file, without its folder.
fn message(name: &str, content: impl AsRef<[u8]>) -> String {
    let text = loaded(name, content).expect_err("the file is bad").to_string();
    text[text.find(name).expect("the message names the file")..].to_owned()
}

#[test]
fn no_cut_or_changed_byte_makes_a_loader_panic() {
    let files = [
        ("a.ply", ply::PLY.as_bytes().to_vec()),
        ("a.obj", obj::OBJ.into()),
        ("a.gltf", gltf::embedded(&gltf::gltf_data()).into()),
        ("a.glb", gltf::glb()),
        ("b.gltf", materials::blended().into()),
        ("c.gltf", gltf_data::moving().into()),
        ("d.gltf", gltf_data::skinned().into()),
    ];
    for (name, file) in files {
        let loader = LOADERS.iter().find(|(extension, _)| name.ends_with(extension)).unwrap().1;
        let loader = |bytes: Vec<u8>| {
            loader(&mut Reading::new(name, Room::new(None)), &mut unmarked(&bytes[..])).is_ok()
        };
        assert!(loader(file.clone()), "{name} as it is");
        for at in 0..file.len() {
            for byte in [b'0', b'9', b'-', b'/', b'"', 0, 0xff] {
                let mut file = file.clone();
                file[at] = byte;
                loader(file);
            }
            loader(file[..at].to_vec());
        }
    }
}

#[cfg(unix)]
#[test]
fn a_device_that_a_mesh_names_is_refused() {
    let refused = "/dev/zero: cannot be read: it is a device or a pipe, expected a regular file";
    let library = format!("mtllib /dev/zero\n{}", obj::OBJ);
    let buffer = gltf::gltf(r#""uri":"/dev/zero","#);
    for (name, content) in [("a.obj", library), ("a.gltf", buffer)] {
        assert_eq!(loaded(name, content).unwrap_err().to_string(), refused);
    }
}

#[test]
fn what_is_no_mesh_file_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let error = |path: &str| load(path).unwrap_err().to_string();
    fs::create_dir(path("d.obj")).unwrap();
    fs::write(path("a.stl"), "").unwrap();
    assert_eq!(
        error(&path("d.obj")),
        format!(
            "{}: is a directory, expected a file: a mesh (.obj, .ply, .ply.gz, .gltf or .glb) or a trace (.csv or .ptrace)",
            path("d.obj")
        )
    );
    assert_eq!(
        error(&path("a.stl")),
        format!(
            "{}: unknown kind of file, expected a mesh (.obj, .ply, .ply.gz, .gltf or .glb) or a trace (.csv or .ptrace)",
            path("a.stl")
        )
    );
    assert_eq!(error(&path("no.obj")), format!("{}: no such file", path("no.obj")));
}

#[test]
fn a_mark_of_the_encoding_is_no_part_of_a_text() {
    let wide = |text: &str, big: bool| -> Vec<u8> {
        let units = format!("\u{feff}{text}");
        let order = |unit: u16| if big { unit.to_be_bytes() } else { unit.to_le_bytes() };
        units.encode_utf16().flat_map(order).collect()
    };
    let plain = loaded("a.obj", obj::OBJ).unwrap();
    let marked =
        [format!("\u{feff}{}", obj::OBJ).into_bytes(), wide(obj::OBJ, false), wide(obj::OBJ, true)];
    for text in marked {
        let parts = loaded("a.obj", text).unwrap();
        assert_eq!(parts.len(), plain.len());
        assert_eq!(parts[0].positions, plain[0].positions);
    }
    let marked = format!("\u{feff}{}", ply::PLY);
    assert_eq!(loaded("a.ply", marked).unwrap()[0].positions, ply::SQUARE);
    let marked = format!("\u{feff}{}", gltf::embedded(&gltf::gltf_data()));
    assert_eq!(loaded("a.gltf", marked).unwrap().len(), 1);
}

fn gzip(content: impl Read) -> Vec<u8> {
    let mut content = content;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    io::copy(&mut content, &mut encoder).unwrap();
    encoder.flush().unwrap();
    encoder.finish().unwrap()
}

#[test]
fn what_does_not_fit_into_memory_is_refused_before_it_is_taken() {
    let limit = || Some("1M".parse().unwrap());
    let refused = |name: &str, content: &[u8]| {
        let text = within(limit(), name, content).err().expect("it is refused").to_string();
        text[text.find(name).unwrap()..].to_owned()
    };
    let full = "does not fit into the memory that a scene may take, 1M; `--memory-limit` sets another limit";
    let many = ply::PLY.replace("vertex 4", "vertex 3000000000");
    assert_eq!(refused("a.ply", many.as_bytes()), format!("a.ply: {full}"));
    // However long a line goes on, no more of it is held than a line may have.
    let long = gzip(io::repeat(b'a').take(1 << 26));
    assert_eq!(refused("a.ply.gz", &long), "a.ply.gz, line 1: is longer than 2097151 bytes");
    let comments = format!("ply\n{}", "comment a\n".repeat(200_000));
    assert_eq!(
        refused("a.ply.gz", &gzip(comments.as_bytes())),
        "a.ply.gz, line 116510: the header goes on, expected at most 1048576 bytes of it"
    );
    assert_eq!(refused("a.obj", "v 1 2 3\n".repeat(100_000).as_bytes()), format!("a.obj: {full}"));
    let data = " ".repeat(1 << 20);
    assert_eq!(refused("a.gltf", data.as_bytes()), format!("a.gltf: {full}"));
    assert!(within(limit(), "a.obj", obj::OBJ).is_ok());
    assert!(within(limit(), "a.ply", ply::PLY).is_ok());
}
