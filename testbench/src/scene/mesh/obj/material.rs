//! Material libraries: what a surface looks like, by its name.
//!
//! Read are `Kd`, `d`, `Tr`, `map_Kd` and `map_d`; everything else is passed over. A library that does
//! not exist is as good as none and noted; one that cannot be read is an error.

use crate::scene::SceneError;
use crate::scene::mesh::images::Unseen;
use crate::scene::mesh::lines::Lines;
use crate::scene::mesh::{Reading, bad, beside, line_error, open, unmarked};
use crate::scene::paint::Texture;
use crate::scene::texture::{Image, Wrap};
use glam::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a surface looks like.
#[derive(Default)]
pub(super) struct Material {
    /// `Kd`, 0..=1.
    pub diffuse: Option<Vec3>,
    /// `d`, 0..=1, 1 opaque.
    dissolve: Option<f32>,
    /// `Tr`, 0..=1, 0 opaque.
    transparency: Option<f32>,
    /// `map_Kd` and `map_d`, the ones that are used.
    maps: Vec<Map>,
    /// The library that it is in.
    library: String,
}

/// A texture of a material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// `map_Kd` or `map_d`.
    pub keyword: &'static str,
    /// The file as it is named.
    pub file: String,
    /// `-o`: added to the coordinates after they are scaled.
    pub offset: Vec3,
    /// `-s`: how often the texture goes into the coordinates' unit.
    pub scale: Vec3,
    /// `-clamp on`: the texture is not repeated.
    pub clamp: bool,
}

impl Map {
    /// Where a vertex with these coordinates, the second upwards, lies on the image, whose first row is at 0.
    pub fn place(&self, coordinates: Vec2) -> Vec2 {
        let at = coordinates * self.scale.truncate() + self.offset.truncate();
        Vec2::new(at.x, 1.0 - at.y)
    }
}

impl Material {
    /// The opacity, 0..=1: `d`, or what `Tr` leaves, or opaque. Programs that write both do not agree on `Tr`.
    pub fn alpha(&self) -> f32 {
        self.dissolve.or(self.transparency.map(|part| 1.0 - part)).unwrap_or(1.0)
    }
}

/// The materials of all libraries.
#[derive(Default)]
pub(super) struct Library {
    materials: HashMap<String, Material>,
    /// The files that have been read. One that is named again would define the same once more.
    read: HashSet<PathBuf>,
    /// By their path; nothing for one that is not seen.
    images: HashMap<PathBuf, Option<Arc<Image>>>,
    unseen: Unseen,
    /// Names of materials that were asked for in vain, without repetition.
    missing: Vec<String>,
}

/// A finite number as C reads it.
pub(super) fn number(word: &str) -> Option<f32> {
    word.parse().ok().filter(|number: &f32| number.is_finite())
}

impl Library {
    /// The material of that name. There need not be one of the empty name.
    pub fn get(&mut self, name: &str) -> Option<&Material> {
        let found = self.materials.get(name);
        if found.is_none() && !name.is_empty() && !self.missing.iter().any(|known| known == name) {
            self.missing.push(name.to_owned());
        }
        found
    }

    /// Reads the libraries that a statement names: one whose name may have blanks, or several.
    pub fn load(&mut self, file: &mut Reading, names: &str) -> Result<(), SceneError> {
        let names = match beside(file.path, names).exists() {
            true => vec![names],
            false => names.split_whitespace().collect(),
        };
        names.into_iter().try_for_each(|name| self.read(file, &beside(file.path, name)))
    }

    fn read(&mut self, file: &mut Reading, path: &Path) -> Result<(), SceneError> {
        let shown = path.to_string_lossy().into_owned();
        if !self.read.insert(fs::canonicalize(path).unwrap_or(path.to_owned())) {
            return Ok(());
        }
        let mut text = match open(path) {
            Ok(text) => unmarked(text),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                file.note(format!("the material library `{shown}` does not exist"));
                return Ok(());
            }
            Err(source) => return Err(SceneError::Unreadable { path: shown, source }),
        };
        let mut lines = Lines::new(&mut text);
        let mut current: Option<String> = None;
        while lines.read_joined().map_err(|error| line_error(&shown, lines.number(), error))? {
            let text = String::from_utf8_lossy(lines.text());
            let Some((keyword, rest)) = statement(&text) else { continue };
            if keyword == "newmtl" {
                file.take(size_of::<Material>() + shown.len() + rest.len())?;
                let material = Material { library: shown.clone(), ..Material::default() };
                self.materials.insert(rest.to_owned(), material);
                current = Some(rest.to_owned());
            } else if let Some(material) =
                current.as_ref().and_then(|name| self.materials.get_mut(name))
            {
                let taken = material.take(keyword, rest);
                taken.map_err(|what| bad(&shown, Some(lines.number()), what))?;
            }
        }
        Ok(())
    }

    /// The textures of the material of that name that can be read, with how they lie.
    pub fn textures(
        &mut self,
        file: &mut Reading,
        name: &str,
    ) -> Result<Vec<(Map, Texture)>, SceneError> {
        let Some(Material { maps, library, .. }) = self.materials.get(name) else {
            return Ok(vec![]);
        };
        let mut textures = vec![];
        for map in maps {
            let path = beside(library, &map.file);
            let image = match self.images.get(&path) {
                Some(image) => image.clone(),
                None => {
                    let image = read(file, &path, &mut self.unseen)?;
                    self.images.insert(path, image.clone());
                    image
                }
            };
            let wraps = [if map.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
            textures.extend(image.map(|image| (map.clone(), Texture { image, wraps })));
        }
        Ok(textures)
    }

    /// Notes what is not drawn of the materials.
    pub fn tell(&self, file: &mut Reading) {
        self.unseen.tell(file);
        if let [first, rest @ ..] = &self.missing[..] {
            let more = if rest.is_empty() { "" } else { ", and others," };
            file.note(format!("the material `{first}`{more} is in no library"));
        }
    }
}

/// The image in a file, if it is seen.
fn read(
    file: &mut Reading,
    path: &Path,
    unseen: &mut Unseen,
) -> Result<Option<Arc<Image>>, SceneError> {
    let shown = path.to_string_lossy().into_owned();
    let mut bytes = match open(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            unseen.is_missing(&shown);
            return Ok(None);
        }
        Err(source) => return Err(SceneError::Unreadable { path: shown, source }),
    };
    let bytes = file.whole(&shown, &mut bytes)?;
    unseen.decoded(file, &bytes, format_args!("`{shown}`"), &|what| bad(&shown, None, what))
}

/// The keyword of a line and what follows it.
fn statement(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (!keyword.is_empty() && !keyword.starts_with('#')).then_some((keyword, rest.trim()))
}

impl Material {
    /// Takes a statement, or says what was expected.
    fn take(&mut self, keyword: &str, rest: &str) -> Result<(), String> {
        let mut words = rest.split_whitespace().take_while(|word| !word.starts_with('#'));
        match keyword {
            "Kd" if !rest.starts_with("spectral") && !rest.starts_with("xyz") => {
                let numbers: Option<Vec<f32>> = words.map(number).collect();
                let colour = match numbers.as_deref() {
                    Some(&[grey]) => Vec3::splat(grey),
                    Some(&[r, g, b, ..]) => Vec3::new(r, g, b),
                    _ => return Err("expected three numbers after Kd".into()),
                };
                self.diffuse = Some(colour.clamp(Vec3::ZERO, Vec3::ONE));
            }
            "d" | "Tr" => {
                let value = words.find(|word| *word != "-halo").and_then(number);
                let value = value.ok_or_else(|| format!("expected a number after {keyword}"))?;
                let field =
                    if keyword == "d" { &mut self.dissolve } else { &mut self.transparency };
                *field = Some(value.clamp(0.0, 1.0));
            }
            "map_Kd" => self.map("map_Kd", rest),
            "map_d" => self.map("map_d", rest),
            _ => {}
        }
        Ok(())
    }

    /// Takes a texture; the last of a keyword counts.
    fn map(&mut self, keyword: &'static str, rest: &str) {
        self.maps.retain(|map| map.keyword != keyword);
        self.maps.extend(map(keyword, rest));
    }
}

/// The options of a map statement that are followed by so many words, none of which says where a texture lies.
const OPTIONS: [(&str, usize); 9] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-cc", 1),
    ("-bm", 1),
    ("-boost", 1),
    ("-texres", 1),
    ("-imfchan", 1),
    ("-type", 1),
    ("-mm", 2),
];

/// A map statement without its keyword: options, then the name of a file, which may have blanks. Nothing without a name.
fn map(keyword: &'static str, rest: &str) -> Option<Map> {
    let mut map =
        Map { keyword, file: String::new(), offset: Vec3::ZERO, scale: Vec3::ONE, clamp: false };
    let mut rest = rest;
    while let Some((option, after)) =
        rest.split_once(char::is_whitespace).filter(|_| rest.starts_with('-'))
    {
        rest = after.trim_start();
        match option {
            "-o" => rest = coordinates(rest, &mut map.offset),
            "-s" => rest = coordinates(rest, &mut map.scale),
            "-t" => rest = coordinates(rest, &mut Vec3::ZERO.clone()),
            "-clamp" => {
                let (word, after) = rest.split_once(char::is_whitespace)?;
                (map.clamp, rest) = (word == "on", after.trim_start());
            }
            _ => {
                let (_, words) = OPTIONS.iter().find(|(name, _)| *name == option)?;
                for _ in 0..*words {
                    rest = rest.split_once(char::is_whitespace)?.1.trim_start();
                }
            }
        }
    }
    map.file = rest.to_owned();
    (!rest.is_empty() && !rest.starts_with('-')).then_some(map)
}

/// Takes one to three numbers from the front of a text; what is left of it.
fn coordinates<'a>(mut rest: &'a str, to: &mut Vec3) -> &'a str {
    for i in 0..3 {
        let Some((word, after)) = rest.split_once(char::is_whitespace) else { break };
        let Some(value) = number(word) else { break };
        (to[i], rest) = (value, after.trim_start());
    }
    rest
}

#[cfg(test)]
mod tests;
