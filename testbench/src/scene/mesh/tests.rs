//! Small files of every format, good ones for what is read, bad ones for the exact message.

mod gltf;
mod obj;
mod ply;

use super::*;
use tempfile::TempDir;

/// Loads a file of this name and content.
fn loaded(name: &str, content: impl AsRef<[u8]>) -> Result<Vec<Part>, SceneError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    load(path.to_str().unwrap())
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
    ];
    for (name, file) in files {
        let loader = LOADERS.iter().find(|(extension, _)| name.ends_with(extension)).unwrap().1;
        for at in 0..file.len() {
            for byte in [b'0', b'9', b'-', b'/', b'"', 0, 0xff] {
                let mut file = file.clone();
                file[at] = byte;
                let _ = loader(name, file);
            }
            let _ = loader(name, file[..at].to_vec());
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
