//! The vertices and faces of an OBJ, and the parts that they make.

use super::material::{Library, Material};
use super::painter::Painter;
use crate::scene::SceneError;
use crate::scene::geometry::{Part, TRIANGLE_BYTES, VERTEX_BYTES};
use crate::scene::mesh::polygon::MOST_CORNERS;
use crate::scene::mesh::{Found, Polygons, Reading};
use crate::scene::paint::PAINT_BYTES;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

/// The index of a normal or of texture coordinates where there is no index.
const NONE: u32 = u32::MAX;
/// The index of what there cannot be.
const ASTRAY: u32 = u32::MAX - 1;

/// A corner of a face: indices from 0.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    /// [`NONE`] if the corner has no place on a texture.
    place: u32,
    /// [`NONE`] if the corner has no normal.
    normal: u32,
}

/// A face: its line, and the end of its corners.
struct Face {
    line: usize,
    end: usize,
}

/// Faces of one object or group and one material, up to an end.
struct Run {
    name: String,
    material: String,
    end: usize,
}

/// What the lines of an OBJ have said of its faces.
#[derive(Default)]
pub(super) struct Faces {
    positions: Vec<Vec3>,
    /// Of the first vertices, up to the last that has one.
    colours: Vec<Option<Vec3>>,
    normals: Vec<Vec3>,
    places: Vec<Vec2>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    runs: Vec<Run>,
    name: String,
    material: String,
    points: Found,
    lines: Found,
}

impl Faces {
    /// Takes a vertex.
    pub fn vertex(
        &mut self,
        file: &mut Reading,
        position: Vec3,
        colour: Option<Vec3>,
    ) -> Result<(), SceneError> {
        file.take(size_of_val(&position) + size_of_val(&colour))?;
        if colour.is_some() {
            self.colours.resize(self.positions.len(), None);
            self.colours.push(colour);
        }
        self.positions.push(position);
        Ok(())
    }

    /// Takes a normal.
    pub fn normal(&mut self, file: &mut Reading, normal: Vec3) -> Result<(), SceneError> {
        file.take(size_of_val(&normal))?;
        self.normals.push(normal);
        Ok(())
    }

    /// Takes texture coordinates.
    pub fn place(&mut self, file: &mut Reading, place: Vec2) -> Result<(), SceneError> {
        file.take(size_of_val(&place))?;
        self.places.push(place);
        Ok(())
    }

    /// Faces from here on have that name.
    pub fn name(&mut self, name: &str) {
        self.name = name.to_owned();
    }

    /// Faces from here on have that material.
    pub fn material(&mut self, name: &str) {
        self.material = name.to_owned();
    }

    /// Passes over points or lines.
    pub fn pass_over(&mut self, line: usize, points: bool) {
        if points { &mut self.points } else { &mut self.lines }.add(format_args!("line {line}"));
    }

    /// Takes a face, its corners as words.
    pub fn face<'a>(
        &mut self,
        file: &mut Reading,
        line: usize,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), SceneError> {
        let first = self.corners.len();
        for word in words {
            let corner = self.corner(word).map_err(|what| file.bad(Some(line), what))?;
            file.take(size_of::<Corner>())?;
            self.corners.push(corner);
        }
        let end = self.corners.len();
        if end - first > MOST_CORNERS {
            let what =
                format!("a face has {} corners, expected at most {MOST_CORNERS}", end - first);
            return Err(file.bad(Some(line), what));
        }
        file.take(size_of::<Face>())?;
        self.faces.push(Face { line, end });
        let end = self.faces.len();
        match self.runs.last_mut() {
            Some(run) if run.name == self.name && run.material == self.material => run.end = end,
            _ => {
                let (name, material) = (self.name.clone(), self.material.clone());
                file.take(size_of::<Run>() + name.len() + material.len())?;
                self.runs.push(Run { name, material, end });
            }
        }
        Ok(())
    }

    /// The corner that a word stands for: `V`, `V/T`, `V//N` or `V/T/N`, each from 1, or from -1 backwards.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let form = || {
            let what = "expected a face as f V V V, with indices as V, V/T, V//N or V/T/N";
            format!("found `{word}`, {what}")
        };
        let mut indices = word.split('/');
        let mut next = |is_needed: bool| match indices.next() {
            None | Some("") if !is_needed => Ok(None),
            text => text.and_then(|text| text.parse::<i64>().ok()).map(Some).ok_or_else(form),
        };
        let (vertex, place, normal) = (next(true)?.unwrap_or_default(), next(false)?, next(false)?);
        if indices.next().is_some() {
            return Err(form());
        }
        let found = self.positions.len();
        let position = absolute(vertex, found).ok_or_else(|| match vertex {
            0 => "vertex index 0 is out of range, expected one from 1, or from -1 backwards"
                .to_owned(),
            _ => format!("vertex index {vertex} is out of range, {found} vertices come before"),
        })?;
        // One that there is not may come to be used by nobody.
        let other = |index: Option<i64>, count: usize| {
            index.map_or(NONE, |index| absolute(index, count).unwrap_or(ASTRAY))
        };
        let place = other(place, self.places.len());
        Ok(Corner { position, place, normal: other(normal, self.normals.len()) })
    }

    /// A part for each run of faces.
    ///
    /// # Errors
    /// A face has a vertex that there is not, or the parts do not fit into memory.
    pub fn parts(self, file: &mut Reading, library: &mut Library) -> Result<Vec<Part>, SceneError> {
        let mut polygons = Polygons::default();
        let (mut astray, mut placeless) = (Found::default(), Found::default());
        let mut parts = vec![];
        let (mut first_face, mut first) = (0, 0);
        for run in &self.runs {
            let faces = &self.faces[first_face..run.end];
            let material = library.get(&run.material);
            if material.is_none() {
                file.has_no_opacity();
            }
            let mut builder = Builder::new(&self, run, material);
            builder.paint = Painter::new(library.textures(file, &run.material)?);
            let last = faces.last().map_or(first, |face| face.end);
            builder.has_normals = self.have_normals(&self.corners[first..last]);
            for face in faces {
                let corners = &self.corners[first..face.end];
                first = face.end;
                let place = format_args!("line {}", face.line);
                if let Some(index) =
                    corners.iter().find(|c| c.position as usize >= self.positions.len())
                {
                    let (index, total) = (u64::from(index.position) + 1, self.positions.len());
                    let what =
                        format!("vertex index {index} is out of range, expected 1..={total}");
                    return Err(file.bad(Some(face.line), what));
                }
                if corners
                    .iter()
                    .any(|c| c.normal != NONE && c.normal as usize >= self.normals.len())
                {
                    astray.add(place);
                }
                if builder.paint.is_some() && corners.iter().any(|c| self.placed(c).is_none()) {
                    placeless.add(place);
                }
                builder.add(file, corners, &mut polygons, place)?;
            }
            first_face = run.end;
            parts.push(builder.part());
        }
        polygons.tell(file);
        file.not_seen(self.points.named("statement of points", "statements of points"));
        file.not_seen(self.lines.named("line", "lines"));
        if self.faces.is_empty() && !self.positions.is_empty() {
            let count = self.positions.len();
            let vertices = format!("{count} {}", if count == 1 { "vertex" } else { "vertices" });
            file.not_seen(Some((vertices, "no face".into())));
        }
        if let Some((found, place)) = astray.named("face has", "faces have") {
            file.note(format!(
                "{found} a normal that there is not ({place}): normals are made there"
            ));
        }
        if let Some((found, place)) = placeless.named("face has", "faces have") {
            file.note(format!(
                "{found} no texture coordinates ({place}): the texture is read at 0, 0 there"
            ));
        }
        Ok(parts)
    }

    /// The texture coordinates of a corner.
    fn placed(&self, corner: &Corner) -> Option<Vec2> {
        self.places.get(corner.place as usize).copied()
    }

    /// Whether all corners have a normal.
    fn have_normals(&self, corners: &[Corner]) -> bool {
        corners.iter().all(|corner| (corner.normal as usize) < self.normals.len())
    }
}

/// A part while its faces are put together.
struct Builder<'a> {
    faces: &'a Faces,
    part: Part,
    has_normals: bool,
    has_colours: bool,
    /// Colour of the material.
    diffuse: Option<Vec3>,
    paint: Option<Painter>,
    /// The vertices that the part has.
    known: HashMap<Corner, u32>,
    /// Positions of the corners of the face at hand.
    outline: Vec<Vec3>,
}

impl<'a> Builder<'a> {
    fn new(faces: &'a Faces, run: &Run, material: Option<&Material>) -> Builder<'a> {
        let names = [&run.name, &run.material].into_iter().filter(|name| !name.is_empty()).cloned();
        let mut part = Part::new(names.collect());
        if let Some(material) = material {
            part.alpha = material.alpha();
            part.material = Some(run.material.clone());
        }
        Builder {
            faces,
            part,
            has_normals: false,
            has_colours: !faces.colours.is_empty(),
            diffuse: material.and_then(|material| material.diffuse),
            paint: None,
            known: HashMap::new(),
            outline: vec![],
        }
    }

    /// Adds a face.
    fn add(
        &mut self,
        file: &mut Reading,
        corners: &[Corner],
        polygons: &mut Polygons,
        place: fmt::Arguments,
    ) -> Result<(), SceneError> {
        self.outline.clear();
        self.outline.extend(corners.iter().map(|c| self.faces.positions[c.position as usize]));
        for triangle in polygons.cut(&self.outline, place) {
            file.take(TRIANGLE_BYTES)?;
            let mut vertices = [0; 3];
            for (vertex, corner) in vertices.iter_mut().zip(triangle) {
                *vertex = self.vertex(file, corners[*corner as usize])?;
            }
            self.part.triangles.push(vertices);
        }
        Ok(())
    }

    /// The vertex of the part that a corner is.
    fn vertex(&mut self, file: &mut Reading, corner: Corner) -> Result<u32, SceneError> {
        let corner = Corner {
            normal: if self.has_normals { corner.normal } else { NONE },
            place: if self.paint.is_some() { corner.place } else { NONE },
            ..corner
        };
        if let Some(vertex) = self.known.get(&corner) {
            return Ok(*vertex);
        }
        file.take(VERTEX_BYTES + 2 * size_of::<(Corner, u32)>())?;
        let Faces { positions, normals, colours, .. } = self.faces;
        let part = &mut self.part;
        let vertex = part.positions.len() as u32;
        self.known.insert(corner, vertex);
        part.positions.push(positions[corner.position as usize]);
        if self.has_normals {
            part.normals.push(normals[corner.normal as usize]);
        }
        let own = colours.get(corner.position as usize).copied().flatten().or(self.diffuse);
        if let Some(paint) = &mut self.paint {
            file.take(PAINT_BYTES)?;
            let coordinates = self.faces.placed(&corner).unwrap_or_default();
            paint.vertex(own.unwrap_or(Vec3::ONE), coordinates);
            return Ok(vertex);
        }
        let colour = if self.has_colours { own.or(Some(Vec3::ONE)) } else { own };
        part.colours.extend(colour.map(|colour| colour.extend(part.alpha)));
        Ok(vertex)
    }

    /// The part with all its faces.
    fn part(self) -> Part {
        let Builder { mut part, paint, .. } = self;
        part.paint = paint.map(|paint| Arc::new(paint.finish(part.alpha)));
        part
    }
}

/// The index from 0 that one from 1, or from -1 backwards, stands for.
fn absolute(index: i64, count: usize) -> Option<u32> {
    let index = match index {
        0 => return None,
        1.. => index - 1,
        _ => i64::try_from(count).ok()?.checked_add(index)?,
    };
    u32::try_from(index).ok().filter(|index| *index < ASTRAY)
}
