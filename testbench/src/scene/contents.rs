//! What a scene is made of.

use super::camera::Camera;
use super::geometry::{AlphaMode, Part};
use super::paint::{Paint, Texture};
use glam::Vec3;
use std::fmt;

/// What a scene of meshes is made of, and from where it is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// The camera, given or fitted.
    pub camera: Camera,
    /// Its parts, in the order in which they are drawn.
    pub parts: Vec<PartContents>,
    /// Extensions of the file's format that it uses, by name.
    pub extensions: Vec<Extension>,
}

/// An extension that a file uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extension {
    /// Its name.
    pub name: String,
    /// What becomes of it.
    pub handling: Handling,
}

/// What becomes of something in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handling {
    /// It is read.
    Read,
    /// It is passed over, as it says nothing of what is drawn here.
    WithoutEffect,
    /// It is passed over, though it may say something of the picture.
    PassedOver,
}

/// What a part has.
#[derive(Clone, Debug, PartialEq)]
pub struct PartContents {
    /// Names of the mesh, group and material.
    pub names: Vec<String>,
    /// What its material is called, if it has one that is known.
    pub material: Option<String>,
    /// The alpha mode of its material, in a format that has such.
    pub alpha_mode: Option<AlphaMode>,
    /// The textures that it is drawn with.
    pub textures: Vec<TextureContents>,
    /// Vertices, whether a triangle has them or not.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Gaussian splats; they are its vertices.
    pub splats: usize,
    /// The least and the most opacity, 0..=1, that vertices and textures give it, as rules have it and before light adds to
    /// it.
    pub opacity: [f32; 2],
    /// The least and the greatest x, y and z of a vertex; nothing if there is none.
    pub bounds: Option<[[f32; 3]; 2]>,
}

/// A texture that a part is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureContents {
    /// What it gives: `colour`, with alpha where that counts, or `alpha`.
    pub gives: &'static str,
    /// Its width and height in texels.
    pub size: [u32; 2],
}

impl Handling {
    /// In words: `read`, `without effect` or `passed over`.
    pub fn as_str(self) -> &'static str {
        match self {
            Handling::Read => "read",
            Handling::WithoutEffect => "without effect",
            Handling::PassedOver => "passed over",
        }
    }
}

impl fmt::Display for TextureContents {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let TextureContents { gives, size: [width, height] } = self;
        write!(f, "{gives} {width}x{height}")
    }
}

impl Contents {
    pub(super) fn new(camera: Camera, parts: &[Part], extensions: &[Extension]) -> Contents {
        let parts = parts.iter().map(PartContents::new).collect();
        Contents { camera, parts, extensions: extensions.to_vec() }
    }

    /// The least and the greatest x, y and z of all vertices; nothing if there is none.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let corners = self.parts.iter().filter_map(|part| part.bounds).flatten();
        around(corners.map(Vec3::from))
    }
}

impl PartContents {
    fn new(part: &Part) -> PartContents {
        let opacity = match &part.paint {
            Some(paint) => Some(paint.opacity()),
            None => least_and_most(part.colours.iter().map(|colour| colour.w)),
        };
        PartContents {
            names: part.names.clone(),
            material: part.material.clone(),
            alpha_mode: part.alpha_mode,
            textures: part.paint.iter().flat_map(|paint| textures(paint)).collect(),
            vertices: part.positions.len(),
            triangles: part.triangles.len(),
            splats: part.splats.len(),
            opacity: opacity.unwrap_or([part.alpha; 2]),
            bounds: around(part.positions.iter().copied()),
        }
    }
}

/// The least and the greatest coordinates of points.
pub(super) fn around(points: impl Iterator<Item = Vec3>) -> Option<[[f32; 3]; 2]> {
    let ends =
        points.map(|point| [point; 2]).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]);
    ends.map(|ends| ends.map(|end| end.to_array()))
}

/// The least and the most of some numbers; nothing if there are none.
pub(super) fn least_and_most(numbers: impl Iterator<Item = f32>) -> Option<[f32; 2]> {
    let ends = numbers.map(|number| [number; 2]);
    ends.reduce(|[least, most], [a, b]| [least.min(a), most.max(b)])
}

/// The textures of a paint.
fn textures(paint: &Paint) -> impl Iterator<Item = TextureContents> {
    let texture = |gives, texture: &Texture| TextureContents { gives, size: texture.image.size() };
    let veil = paint.veil.as_ref().and_then(|veil| veil.image.as_ref());
    let colour = paint.colour.as_ref().map(|colour| texture("colour", colour));
    colour.into_iter().chain(veil.map(|(veil, _)| texture("alpha", veil)))
}
