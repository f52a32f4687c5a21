//! Mesh files: what kind of file it is, and one loader for each.
//!
//! A loader checks everything that the pipeline relies on, so that nothing behind it can fail: finite positions,
//! indices in range, at least one triangle.

mod gltf;
mod images;
mod lines;
mod obj;
mod ply;
mod polygon;
mod reading;

use super::SceneError;
use super::built_in;
use super::contents::Extension;
use super::geometry::Part;
use crate::room::Room;
use encoding_rs_io::DecodeReaderBytesBuilder;
use flate2::bufread::MultiGzDecoder;
use pellucid_machine::params::nearest;
use polygon::has_area;
use reading::{Found, Polygons, Reading, bad, line_error, read_error};
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

type Loader = fn(&mut Reading, &mut dyn BufRead) -> Result<Vec<Part>, SceneError>;

/// What a path may end in, in any case, and who reads it.
const LOADERS: [(&str, Loader); 5] = [
    (".obj", obj::load),
    (".ply", ply::load),
    (".ply.gz", ply_gz),
    (".gltf", gltf::load),
    (".glb", gltf::load),
];

/// Bytes of a compressed file in which damage is looked for once something is wrong with what it holds.
const MOST_DAMAGED: u64 = 1 << 26;

/// What a mesh file gives.
pub(super) struct Loaded {
    /// Parts; they have at least one triangle with an area, or splats.
    pub parts: Vec<Part>,
    /// What is to be said of the file, each as one sentence.
    pub notes: Vec<String>,
    /// Extensions that the file uses, by name.
    pub extensions: Vec<Extension>,
    /// Whether there are parts of which the file says nothing of the opacity.
    pub has_no_opacity: bool,
    /// Whether the parts are others at another time.
    pub moves: bool,
}

/// Loads the mesh file at a path into the room that there is, at a time of what moves in it.
pub(super) fn load(path: &str, room: Room, seconds: f32) -> Result<Loaded, SceneError> {
    let unreadable = |source| SceneError::Unreadable { path: path.into(), source };
    let found = match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(not_there(path)),
        Err(source) => return Err(unreadable(source)),
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
    let mut file = Reading::new(path, room);
    file.seconds = seconds;
    let parts = loader(&mut file, &mut unmarked(File::open(path).map_err(unreadable)?))?;
    let is_seen = |part: &Part| {
        let corners = |triangle: &[u32; 3]| triangle.map(|i| part.positions[i as usize]);
        !part.splats.is_empty() || part.triangles.iter().any(|triangle| has_area(corners(triangle)))
    };
    if !parts.iter().any(is_seen) {
        return Err(file.has_nothing());
    }
    Ok(file.loaded(parts))
}

/// The bytes without a mark of their encoding; those of a text that is marked as UTF-16 as UTF-8.
fn unmarked<'a>(bytes: impl Read + 'a) -> impl BufRead + 'a {
    let mut decoder = DecodeReaderBytesBuilder::new();
    BufReader::new(decoder.utf8_passthru(true).strip_bom(true).build(bytes))
}

/// The path of a file that a mesh names. A backslash parts folders where no file has it in its name.
fn beside(mesh: &str, name: &str) -> PathBuf {
    let folder = Path::new(mesh).with_file_name("");
    let path = folder.join(name);
    if path.exists() { path } else { folder.join(name.replace('\\', "/")) }
}

/// Opens a file that a mesh names. A device may have no end, and a pipe may never have a beginning.
fn open(path: &Path) -> io::Result<File> {
    let found = fs::metadata(path)?;
    match found.is_file() {
        true => File::open(path),
        false if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
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

fn ply_gz(file: &mut Reading, bytes: &mut dyn BufRead) -> Result<Vec<Part>, SceneError> {
    let mut bytes = unmarked(MultiGzDecoder::new(bytes));
    let parts = ply::load(file, &mut bytes);
    // Whether the data is whole shows at its end. What is wrong may be so because it is not.
    let rest = if parts.is_ok() { u64::MAX } else { MOST_DAMAGED };
    let checked = io::copy(&mut bytes.take(rest), &mut io::sink());
    checked.map_err(|error| read_error(file.path, error))?;
    parts
}

#[cfg(test)]
mod tests;
