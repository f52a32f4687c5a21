//! A mesh file while it is read: what room is left for it, and what there is to say of it.

use super::Loaded;
use super::lines::Lines;
use super::polygon::{Cut, Cutter};
use crate::room::Room;
use crate::scene::geometry::Part;
use crate::scene::{Extension, SceneError};
use glam::Vec3;
use std::fmt;
use std::io::{self, ErrorKind, Read};

/// Bytes that are read at a time.
const BLOCK: usize = 1 << 20;

/// See the module's description.
pub(super) struct Reading<'a> {
    /// The path as given.
    pub path: &'a str,
    /// The time of what moves, in seconds.
    pub seconds: f32,
    /// Whether anything does.
    pub moves: bool,
    /// Extensions that it uses.
    pub extensions: Vec<Extension>,
    room: Room,
    notes: Vec<String>,
    /// What is in the file and not seen.
    passed_over: Vec<(String, String)>,
    has_no_opacity: bool,
}

/// How often something was found, and where first.
#[derive(Default)]
pub(super) struct Found {
    count: u64,
    first: String,
}

impl Found {
    /// One more, at that place.
    pub fn add(&mut self, place: fmt::Arguments) {
        if self.count == 0 {
            self.first = place.to_string();
        }
        self.count += 1;
    }

    /// How many there are of what has that name, and where the first is; nothing if there are none.
    pub fn named(&self, one: &str, several: &str) -> Option<(String, String)> {
        match self.count {
            0 => None,
            1 => Some((format!("1 {one}"), self.first.clone())),
            count => Some((format!("{count} {several}"), format!("the first: {}", self.first))),
        }
    }
}

impl<'a> Reading<'a> {
    /// Nothing read yet.
    pub fn new(path: &'a str, room: Room) -> Reading<'a> {
        let (notes, passed_over, extensions) = (vec![], vec![], vec![]);
        let (seconds, moves, has_no_opacity) = (0.0, false, false);
        Reading { path, seconds, moves, extensions, room, notes, passed_over, has_no_opacity }
    }

    /// Takes room for so many bytes.
    ///
    /// # Errors
    /// There is not as much.
    pub fn take(&mut self, bytes: usize) -> Result<(), SceneError> {
        let taken = self.room.take(bytes as u64);
        taken.map_err(|source| SceneError::Memory { path: self.path.into(), source })
    }

    /// Notes a sentence on the file.
    pub fn note(&mut self, what: String) {
        self.notes.push(format!("{}: {what}", self.path));
    }

    /// Notes a sentence on the file, but not again.
    pub fn note_once(&mut self, what: &str) {
        let note = format!("{}: {what}", self.path);
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Notes that the file has something that is not seen, and where.
    pub fn not_seen(&mut self, what: Option<(String, String)>) {
        self.passed_over.extend(what);
    }

    /// Notes that the file says nothing of the opacity of a part.
    pub fn has_no_opacity(&mut self) {
        self.has_no_opacity = true;
    }

    /// An error in the content.
    pub fn bad(&self, line: Option<usize>, what: impl Into<String>) -> SceneError {
        bad(self.path, line, what)
    }

    /// The error for a file of which nothing is seen.
    pub fn has_nothing(self) -> SceneError {
        let mut what = "has no triangles with an area, expected at least one".to_owned();
        if !self.passed_over.is_empty() {
            let passed_over = self.passed_over.iter().map(|(what, _)| what.as_str());
            what += &format!(": it has {}", passed_over.collect::<Vec<_>>().join(", "));
        }
        bad(self.path, None, what)
    }

    /// These parts, and what has been noted.
    pub fn loaded(mut self, parts: Vec<Part>) -> Loaded {
        if !self.passed_over.is_empty() {
            let passed_over =
                self.passed_over.iter().map(|(what, place)| format!("{what} ({place})"));
            self.note(format!("not seen: {}", passed_over.collect::<Vec<_>>().join(", ")));
        }
        let Reading { notes, extensions, has_no_opacity, moves, .. } = self;
        Loaded { parts, notes, extensions, has_no_opacity, moves }
    }

    /// All bytes of the file, or of one that it names.
    pub fn whole(&mut self, path: &str, bytes: &mut dyn Read) -> Result<Vec<u8>, SceneError> {
        let mut all = vec![];
        loop {
            self.take(BLOCK)?;
            let read = bytes.take(BLOCK as u64).read_to_end(&mut all);
            match read.map_err(|source| SceneError::Unreadable { path: path.into(), source })? {
                BLOCK => {}
                _ => return Ok(all),
            }
        }
    }

    /// Reads a line, and those that are joined to it. Whether there is one.
    pub fn read_joined(&mut self, lines: &mut Lines) -> Result<bool, SceneError> {
        lines.read_joined().map_err(|error| line_error(self.path, lines.number(), error))
    }
}

/// An error in a mesh file's content.
pub(super) fn bad(path: &str, line: Option<usize>, what: impl Into<String>) -> SceneError {
    SceneError::Mesh { path: path.into(), line, what: what.into() }
}

/// An error over reading a line.
pub(super) fn line_error(path: &str, line: usize, error: io::Error) -> SceneError {
    match error.kind() {
        ErrorKind::FileTooLarge => bad(path, Some(line), error.to_string()),
        _ => read_error(path, error),
    }
}

/// An error over reading a mesh file, which may be compressed.
pub(super) fn read_error(path: &str, error: io::Error) -> SceneError {
    match error.kind() {
        ErrorKind::UnexpectedEof => bad(path, None, "the gzip data is truncated"),
        ErrorKind::InvalidInput | ErrorKind::InvalidData => {
            bad(path, None, format!("expected gzip data: {error}"))
        }
        _ => SceneError::Unreadable { path: path.into(), source: error },
    }
}

/// Cuts the polygons of a file, and keeps what there is to say of them.
#[derive(Default)]
pub(super) struct Polygons {
    cutter: Cutter,
    flat: Found,
    crossed: Found,
}

impl Polygons {
    /// The triangles of a polygon at that place of the file, as numbers of its corners.
    pub fn cut(&mut self, corners: &[Vec3], place: fmt::Arguments) -> &[[u32; 3]] {
        let (cut, triangles) = self.cutter.cut(corners);
        match cut {
            Cut::Whole => {}
            Cut::Flat => self.flat.add(place),
            Cut::Crossed => self.crossed.add(place),
        }
        triangles
    }

    /// Notes what has been found.
    pub fn tell(&self, file: &mut Reading) {
        file.not_seen(self.flat.named("face without an area", "faces without an area"));
        let crossed = self.crossed.named("face crosses itself", "faces cross themselves");
        if let Some((found, place)) = crossed {
            file.note(format!(
                "{found} ({place}): pixels may be covered twice there, or not at all"
            ));
        }
    }
}
