//! Wavefront OBJ with its material library.
//!
//! Each object, group and material is a part. The material's `Kd` is the colour unless the vertices have their own, its
//! `d` the opacity. A material library that does not exist is as good as none; one that cannot be read is an error.

mod indices;
mod lines;

use super::{bad, content};
use crate::scene::SceneError;
use crate::scene::geometry::{DEFAULT_ALPHA, Part};
use glam::Vec3;
use indices::check_indices;
use lines::{Tracked, words};
use std::cell::RefCell;
use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use tobj::{LoadError, LoadOptions, MTLLoadResult, Material, Mesh, Model};

/// Loads the content of an OBJ file.
pub(super) fn load(path: &str, bytes: Vec<u8>) -> Result<Vec<Part>, SceneError> {
    check_indices(path, &bytes)?;
    let options = LoadOptions { triangulate: true, single_index: true, ..LoadOptions::default() };
    let mut text = Tracked::new(&bytes);
    let libraries = Libraries::of(path);
    let loaded = tobj::load_obj_buf(&mut text, &options, |name| libraries.load(name));
    if let Some(error) = libraries.error.into_inner() {
        return Err(error);
    }
    let (models, materials) =
        loaded.map_err(|error| bad(path, Some(text.line()), expected(error)))?;
    let materials = materials.unwrap_or_default();
    let parts: Vec<Part> = models
        .into_iter()
        .filter(|model| !model.mesh.indices.is_empty())
        .map(|model| part(&model, model.mesh.material_id.and_then(|id| materials.get(id))))
        .collect();
    if parts.iter().flat_map(|part| &part.positions).any(|position| !position.is_finite()) {
        let infinite = |words: Vec<&str>| {
            // A fourth number of four divides the others.
            let divisor = if words.len() == 5 { words[4].parse().unwrap_or(1.0) } else { 1.0 };
            let finite = |word: &&str| word.parse().is_ok_and(|x: f32| (x / divisor).is_finite());
            words.first() == Some(&"v") && !words[1..].iter().take(3).all(finite)
        };
        let line = words(&bytes).position(infinite).map(|line| line + 1);
        return Err(bad(path, line, "the vertex is not finite"));
    }
    Ok(parts)
}

/// The material libraries that a file names.
pub(super) struct Libraries<'a> {
    mesh: &'a Path,
    /// Those that have been read. One that is named again would define the same once more.
    known: RefCell<HashSet<PathBuf>>,
    /// Why one cannot be read.
    error: RefCell<Option<SceneError>>,
}

impl Libraries<'_> {
    /// Those of the file with that path, none of them read yet.
    pub fn of(path: &str) -> Libraries<'_> {
        let (known, error) = Default::default();
        Libraries { mesh: Path::new(path), known, error }
    }

    /// The materials of a library that is named; none if they are known.
    pub fn load(&self, name: &Path) -> MTLLoadResult {
        let refuse = |error| {
            *self.error.borrow_mut() = Some(error);
            LoadError::ReadError
        };
        let file = self.mesh.with_file_name("").join(name);
        let path = file.to_string_lossy().into_owned();
        if !self.known.borrow_mut().insert(fs::canonicalize(&file).unwrap_or(file)) {
            return Ok(Default::default());
        }
        let bytes = library_content(&path).map_err(refuse)?;
        let mut text = Tracked::new(&bytes);
        let expected = "expected a line of a material library";
        tobj::load_mtl_buf(&mut text).map_err(|_| refuse(bad(&path, Some(text.line()), expected)))
    }
}

/// The content of a material library, nothing if it does not exist.
fn library_content(path: &str) -> Result<Vec<u8>, SceneError> {
    let bytes = match content(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => {
            return Err(SceneError::Unreadable { path: path.into(), source });
        }
    };
    // The loader takes it for granted that a colour has three numbers.
    for (line, words) in words(&bytes).enumerate() {
        let colour = matches!(words.first(), Some(&("Ka" | "Kd" | "Ks" | "Ke")));
        if colour
            && words[1..].iter().take(3).filter(|word| word.parse::<f32>().is_ok()).count() < 3
        {
            return Err(bad(
                path,
                Some(line + 1),
                format!("expected three numbers after {}", words[0]),
            ));
        }
    }
    Ok(bytes)
}

fn part(model: &Model, material: Option<&Material>) -> Part {
    let Mesh { positions, normals, vertex_color, indices, .. } = &model.mesh;
    let vectors = |numbers: &[f32]| {
        numbers.as_chunks().0.iter().map(|&v| Vec3::from_array(v)).collect::<Vec<_>>()
    };
    let mut part = Part::new(vec![model.name.clone()]);
    part.names.extend(material.map(|material| material.name.clone()));
    part.alpha =
        material.and_then(|material| material.dissolve).unwrap_or(DEFAULT_ALPHA).clamp(0.0, 1.0);
    part.positions = vectors(positions);
    if normals.len() == positions.len() {
        part.normals = vectors(normals);
    }
    if vertex_color.len() == positions.len() {
        let alpha = part.alpha;
        let colour = |c: Vec3| c.clamp(Vec3::ZERO, Vec3::ONE).extend(alpha);
        part.colours = vectors(vertex_color).into_iter().map(colour).collect();
    } else if let Some(diffuse) = material.and_then(|material| material.diffuse) {
        let colour = Vec3::from(diffuse).clamp(Vec3::ZERO, Vec3::ONE).extend(part.alpha);
        part = part.painted(colour);
    }
    part.triangles = indices.as_chunks().0.to_vec();
    part
}

/// What a line should have been.
fn expected(error: LoadError) -> &'static str {
    match error {
        LoadError::PositionParseError => "expected a vertex as v X Y Z",
        LoadError::ScalingByZeroError => "expected a vertex as v X Y Z W with W other than 0",
        LoadError::ColorParseError => "expected a vertex with a colour as v X Y Z R G B",
        LoadError::FaceColorOutOfBounds => {
            "some vertices have a colour, expected all or none to have one"
        }
        LoadError::NormalParseError => "expected a normal as vn X Y Z",
        LoadError::TexcoordParseError => "expected a texture coordinate as vt U V",
        LoadError::FaceParseError => {
            "expected a face as f V V V, with indices as V, V/T, V//N or V/T/N"
        }
        LoadError::FaceVertexOutOfBounds
        | LoadError::FaceTexCoordOutOfBounds
        | LoadError::FaceNormalOutOfBounds => "a face above has an index of what comes only below",
        LoadError::ReadError => "expected text in UTF-8",
        _ => "expected a line of a Wavefront OBJ",
    }
}
