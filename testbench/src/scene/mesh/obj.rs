//! Wavefront OBJ with its material library.
//!
//! Each object, group and material is a part. The material's `Kd` is the colour unless the vertices have their own, its
//! `d` the opacity. A material library that does not exist is as good as none; one that cannot be read is an error.

use super::bad;
use crate::scene::SceneError;
use crate::scene::geometry::{DEFAULT_ALPHA, Part};
use glam::Vec3;
use std::fs;
use std::io::{self, BufRead, Read};
use std::path::Path;
use tobj::{LoadError, LoadOptions, MTLLoadResult, Material, Mesh, Model};

/// Loads the content of an OBJ file.
pub(super) fn load(path: &str, bytes: Vec<u8>) -> Result<Vec<Part>, SceneError> {
    let options = LoadOptions {
        triangulate: true,
        single_index: true,
        ..LoadOptions::default()
    };
    let mut text = Tracked {
        bytes: &bytes,
        at: 0,
    };
    let library = |name: &Path| read_library(&Path::new(path).with_file_name("").join(name));
    let (models, materials) = tobj::load_obj_buf(&mut text, &options, library)
        .map_err(|error| explain(path, &text, error))?;
    let materials = materials.map_err(|_| {
        bad(
            path,
            None,
            "its material library (mtllib) cannot be read as one",
        )
    })?;
    let parts: Vec<Part> = models
        .into_iter()
        .filter(|model| !model.mesh.indices.is_empty())
        .map(|model| {
            part(
                &model,
                model.mesh.material_id.and_then(|id| materials.get(id)),
            )
        })
        .collect();
    if parts
        .iter()
        .flat_map(|part| &part.positions)
        .any(|position| !position.is_finite())
    {
        let infinite = |words: &[&str]| {
            words[0] == "v"
                && words[1..]
                    .iter()
                    .take(3)
                    .any(|w| !w.parse().is_ok_and(f32::is_finite))
        };
        return Err(bad(
            path,
            find_line(&bytes, infinite),
            "the vertex is not finite",
        ));
    }
    Ok(parts)
}

fn read_library(path: &Path) -> MTLLoadResult {
    match fs::read(path) {
        Ok(bytes) => tobj::load_mtl_buf(&mut &bytes[..]),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Default::default()),
        Err(_) => Err(LoadError::ReadError),
    }
}

fn part(model: &Model, material: Option<&Material>) -> Part {
    let Mesh {
        positions,
        normals,
        vertex_color,
        indices,
        ..
    } = &model.mesh;
    let vectors = |numbers: &[f32]| {
        numbers
            .as_chunks()
            .0
            .iter()
            .map(|&v| Vec3::from_array(v))
            .collect::<Vec<_>>()
    };
    let mut part = Part::new(vec![model.name.clone()]);
    part.names
        .extend(material.map(|material| material.name.clone()));
    part.alpha = material
        .and_then(|material| material.dissolve)
        .unwrap_or(DEFAULT_ALPHA)
        .clamp(0.0, 1.0);
    part.positions = vectors(positions);
    if normals.len() == positions.len() {
        part.normals = vectors(normals);
    }
    if vertex_color.len() == positions.len() {
        let alpha = part.alpha;
        let colour = |c: Vec3| c.clamp(Vec3::ZERO, Vec3::ONE).extend(alpha);
        part.colours = vectors(vertex_color).into_iter().map(colour).collect();
    } else if let Some(diffuse) = material.and_then(|material| material.diffuse) {
        let colour = Vec3::from(diffuse)
            .clamp(Vec3::ZERO, Vec3::ONE)
            .extend(part.alpha);
        part = part.painted(colour);
    }
    part.triangles = indices.as_chunks().0.to_vec();
    part
}

/// The loader's reason with the line: the last one read, except for indices, which are looked at after their object.
fn explain(path: &str, text: &Tracked, error: LoadError) -> SceneError {
    let what = match error {
        LoadError::PositionParseError => "expected a vertex as v X Y Z",
        LoadError::ColorParseError => "expected a vertex with a colour as v X Y Z R G B",
        LoadError::NormalParseError => "expected a normal as vn X Y Z",
        LoadError::TexcoordParseError => "expected a texture coordinate as vt U V",
        LoadError::FaceParseError => {
            "expected a face as f V V V, with indices as V, V/T, V//N or V/T/N"
        }
        LoadError::ReadError => "expected text in UTF-8",
        LoadError::FaceVertexOutOfBounds => {
            return out_of_range(path, text.bytes, "v", 0, "vertex");
        }
        LoadError::FaceTexCoordOutOfBounds => {
            return out_of_range(path, text.bytes, "vt", 1, "texture coordinate");
        }
        LoadError::FaceNormalOutOfBounds => {
            return out_of_range(path, text.bytes, "vn", 2, "normal");
        }
        LoadError::FaceColorOutOfBounds => {
            return bad(
                path,
                None,
                "only some of the vertices have a colour, expected all or none",
            );
        }
        _ => "expected a line of a Wavefront OBJ",
    };
    bad(path, Some(text.line()), what)
}

/// The error for the first face whose `field`-th index is above the number of `keyword` lines.
fn out_of_range(path: &str, bytes: &[u8], keyword: &str, field: usize, kind: &str) -> SceneError {
    let known = words(bytes)
        .filter(|words| words.first() == Some(&keyword))
        .count();
    let beyond = |word: &&str| {
        let index = word
            .split('/')
            .nth(field)
            .and_then(|index| index.parse::<i64>().ok());
        index.is_some_and(|index| index.unsigned_abs() > known as u64)
    };
    let line = find_line(bytes, |words| {
        words[0] == "f" && words[1..].iter().any(|word| beyond(word))
    });
    bad(
        path,
        line,
        format!("the face has a {kind} index out of range, expected 1..={known}"),
    )
}

/// The first line, from 1, whose words are as asked for.
fn find_line(bytes: &[u8], asked: impl Fn(&[&str]) -> bool) -> Option<usize> {
    words(bytes)
        .position(|words| !words.is_empty() && asked(&words))
        .map(|line| line + 1)
}

/// The words of each line.
fn words(bytes: &[u8]) -> impl Iterator<Item = Vec<&str>> {
    bytes.split(|&byte| byte == b'\n').map(|line| {
        str::from_utf8(line)
            .unwrap_or("")
            .split_whitespace()
            .collect()
    })
}

/// A text that knows how far it has been read.
struct Tracked<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Tracked<'_> {
    /// The line, from 1, that was read last.
    fn line(&self) -> usize {
        let read = &self.bytes[..self.at];
        read.split_inclusive(|&byte| byte == b'\n').count()
    }
}

impl Read for Tracked<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = (&self.bytes[self.at..]).read(buffer)?;
        self.at += read;
        Ok(read)
    }
}

impl BufRead for Tracked<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(&self.bytes[self.at..])
    }

    fn consume(&mut self, amount: usize) {
        self.at += amount;
    }
}
