//! Mesh files: what kind of file it is, and one loader for each.
//!
//! A loader checks everything that the pipeline relies on, so that nothing behind it can fail: finite positions,
//! indices in range, at least one triangle.

mod gltf;
mod obj;
mod ply;

use super::SceneError;
use super::built_in;
use super::geometry::Part;
use pellucid_machine::params::nearest;
use std::fs;
use std::io::{self, Read};

type Loader = fn(&str, Vec<u8>) -> Result<Vec<Part>, SceneError>;

/// What a path may end in, in any case, and who reads it.
const LOADERS: [(&str, Loader); 5] = [
    (".obj", obj::load),
    (".ply", ply::load),
    (".ply.gz", ply_gz),
    (".gltf", gltf::load),
    (".glb", gltf::load),
];

/// Loads the mesh file at a path.
pub(super) fn load(path: &str) -> Result<Vec<Part>, SceneError> {
    let found = match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(not_there(path)),
        Err(source) => {
            return Err(SceneError::Unreadable { path: path.into(), source });
        }
        Ok(data) if data.is_dir() => return Err(SceneError::Directory { path: path.into() }),
        Ok(found) => found,
    };
    let name = path.to_ascii_lowercase();
    let Some((_, loader)) = LOADERS.iter().find(|(extension, _)| name.ends_with(extension)) else {
        return Err(SceneError::Extension { path: path.into() });
    };
    if !found.is_file() {
        return Err(SceneError::Device { path: path.into() });
    }
    let bytes =
        fs::read(path).map_err(|source| SceneError::Unreadable { path: path.into(), source })?;
    let parts = loader(path, bytes)?;
    match parts.iter().all(|part| part.triangles.is_empty()) {
        true => Err(bad(path, None, "has no triangles, expected at least one")),
        false => Ok(parts),
    }
}

/// The content of a file that a mesh names. A device may have no end, and a pipe may never have a beginning.
fn content(path: &str) -> io::Result<Vec<u8>> {
    let found = fs::metadata(path)?;
    match found.is_file() || found.is_dir() {
        true => fs::read(path),
        false => Err(io::Error::other("it is a device or a pipe, expected a regular file")),
    }
}

/// The error for a name that is no file: a misspelt scene unless it looks like a path.
fn not_there(name: &str) -> SceneError {
    if name.contains(['.', '/', '\\']) {
        return SceneError::Missing { path: name.into() };
    }
    let known = || built_in().iter().map(|scene| scene.name);
    SceneError::Unknown {
        name: name.into(),
        nearest: nearest(name, known()),
        known: known().collect::<Vec<_>>().join(", "),
    }
}

fn ply_gz(path: &str, bytes: Vec<u8>) -> Result<Vec<Part>, SceneError> {
    let mut text = Vec::new();
    match flate2::read::MultiGzDecoder::new(&bytes[..]).read_to_end(&mut text) {
        Ok(_) => ply::load(path, text),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            Err(bad(path, None, "the gzip data is truncated"))
        }
        Err(error) => Err(bad(path, None, format!("expected gzip data: {error}"))),
    }
}

/// An error in a mesh file's content.
fn bad(path: &str, line: Option<usize>, what: impl Into<String>) -> SceneError {
    SceneError::Mesh { path: path.into(), line, what: what.into() }
}

#[cfg(test)]
mod tests;
