//! Materials: base colour with its texture, alpha mode, transmission.

use super::super::Reading;
use super::images::Images;
use super::vertices::Vertices;
use crate::scene::SceneError;
use crate::scene::geometry::{AlphaMode, DEFAULT_ALPHA, Part};
use crate::scene::paint::{PAINT_BYTES, Paint, Texture, Veil};
use crate::scene::srgb::encoded;
use ::gltf::Semantic;
use ::gltf::accessor::Dimensions;
use ::gltf::material::AlphaMode as Mode;
use ::gltf::texture::Info;
use glam::{Mat2, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Alpha below which a material with a mask is not there, if it states none (glTF 2.0, 3.9.4).
const DEFAULT_CUTOFF: f32 = 0.5;

/// Gives a part its colours and what else its material says. The part has the vertices once or several times.
pub(super) fn dress(
    file: &mut Reading,
    images: &mut Images,
    vertices: &Vertices,
    part: &mut Part,
) -> Result<(), SceneError> {
    let material = vertices.primitive.material();
    let instances = part.positions.len().checked_div(vertices.count).unwrap_or(0);
    let mut colours = colours(vertices)?;
    if material.index().is_none() {
        // What has no material says nothing of its opacity: alpha of its vertices counts.
        file.has_no_opacity();
        part.colours = colours.into_iter().map(level).collect::<Vec<_>>().repeat(instances);
        return Ok(());
    }
    let (factor, info) = match material.pbr_specular_glossiness() {
        Some(other) => (other.diffuse_factor(), other.diffuse_texture()),
        None => {
            let base = material.pbr_metallic_roughness();
            (base.base_color_factor(), base.base_color_texture())
        }
    };
    colours.resize(vertices.count, Vec4::ONE);
    colours.iter_mut().for_each(|colour| *colour = bounded(*colour * Vec4::from(factor)));
    part.unlit = material.unlit();
    part.material = Some(match (material.name(), material.index()) {
        (None, Some(index)) => format!("material {index}"),
        (name, _) => name.unwrap_or_default().to_owned(),
    });
    let cutoff = material.alpha_cutoff().unwrap_or(DEFAULT_CUTOFF);
    let mode = match material.alpha_mode() {
        Mode::Opaque => AlphaMode::Opaque,
        Mode::Mask => AlphaMode::Mask(cutoff),
        Mode::Blend => AlphaMode::Blend,
    };
    part.alpha_mode = Some(mode);

    let mut textures = Textures { file, images, vertices, places: vec![] };
    let colour = match &info {
        Some(info) => textures.get(info, |place, at| (place.x, place.y) = at.into())?,
        None => None,
    };
    let mut veil = None;
    if let Some(stated) = material.transmission().filter(|t| t.transmission_factor() > 0.0) {
        let part = stated.transmission_factor().clamp(0.0, 1.0);
        let texture = match &stated.transmission_texture() {
            Some(info) => textures.get(info, |place, at| (place.z, place.w) = at.into())?,
            None => None,
        };
        veil = Some(match texture {
            Some(texture) => {
                Veil { plain: 1.0, image: Some((texture, Vec4::new(-part, 0.0, 0.0, 0.0))) }
            }
            None => Veil { plain: 1.0 - part, image: None },
        });
    }
    let mut places = textures.places;
    if veil.is_some() {
        file.note_once("transmission is drawn as an alpha of 1 - transmission");
    }
    let is_solid = mode != AlphaMode::Blend;
    let cutoff = if let AlphaMode::Mask(cutoff) = mode { Some(cutoff) } else { None };
    let is_plain = colour.is_none() && veil.as_ref().is_none_or(|veil| veil.image.is_none());
    // A mask that no vertex falls below discards nothing.
    if is_plain && colours.iter().all(|colour| colour.w >= cutoff.unwrap_or(0.0)) {
        let left = veil.map_or(1.0, |veil| veil.plain);
        part.colours = colours.into_iter().map(level).collect();
        for colour in &mut part.colours {
            colour.w = left * if is_solid { 1.0 } else { colour.w };
        }
        part.colours = part.colours.repeat(instances);
        return Ok(());
    }
    places.resize(vertices.count, Vec4::ZERO);
    file.take(part.positions.len() * PAINT_BYTES)?;
    let (colours, places) = (colours.repeat(instances), places.repeat(instances));
    let paint = Paint { colours, places, colour, cutoff, is_solid, veil, alpha: None };
    part.paint = Some(Arc::new(paint));
    Ok(())
}

/// A colour within its range.
fn bounded(colour: Vec4) -> Vec4 {
    colour.clamp(Vec4::ZERO, Vec4::ONE)
}

/// A colour that is light as levels, alpha as it is.
fn level(light: Vec4) -> Vec4 {
    let light = bounded(light);
    Vec3::from(light.truncate().to_array().map(encoded)).extend(light.w)
}

/// Colours of the vertices as light with alpha, or none if they have none.
fn colours(vertices: &Vertices) -> Result<Vec<Vec4>, SceneError> {
    let semantic = Semantic::Colors(0);
    let Some(accessor) = vertices.primitive.get(&semantic) else { return Ok(vec![]) };
    if accessor.dimensions() != Dimensions::Vec3 {
        let colours = vertices.attribute::<4>(semantic)?.unwrap_or_default();
        return Ok(colours.into_iter().map(Vec4::from).collect());
    }
    let has_material = vertices.primitive.material().index().is_some();
    let alpha = if has_material { 1.0 } else { DEFAULT_ALPHA };
    let colours = vertices.attribute::<3>(semantic)?.unwrap_or_default();
    Ok(colours.into_iter().map(|colour| Vec3::from(colour).extend(alpha)).collect())
}

/// Where the vertices lie on a texture; nothing if they do not say.
fn places(vertices: &Vertices, info: &Info) -> Result<Option<Vec<Vec2>>, SceneError> {
    let transform = info.texture_transform();
    let set = transform.as_ref().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord());
    let Some(places) = vertices.attribute::<2>(Semantic::TexCoords(set))? else { return Ok(None) };
    let mut places: Vec<Vec2> = places.into_iter().map(Vec2::from).collect();
    if let Some(transform) = transform {
        // Counter-clockwise as seen with the second axis downwards, as an image lies.
        let (sin, cos) = transform.rotation().sin_cos();
        let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        let [scale, offset] = [transform.scale(), transform.offset()].map(Vec2::from);
        places.iter_mut().for_each(|at| *at = turn * (scale * *at) + offset);
    }
    match places.iter().position(|at| !at.is_finite()) {
        Some(i) => Err((vertices.error)(format!("TEXCOORD_{set} of vertex {i} is not finite"))),
        None => Ok(Some(places)),
    }
}

/// The textures of a material while they are read.
struct Textures<'a, 'b, 'c> {
    file: &'a mut Reading<'b>,
    images: &'a mut Images,
    vertices: &'a Vertices<'c>,
    places: Vec<Vec4>,
}

impl Textures<'_, '_, '_> {
    /// A texture that can be read, and where its vertices lie on it.
    fn get(
        &mut self,
        info: &Info,
        set: impl Fn(&mut Vec4, Vec2),
    ) -> Result<Option<Texture>, SceneError> {
        let Vertices { buffers, count, .. } = *self.vertices;
        let texture = self.images.texture(self.file, buffers, &info.texture())?;
        if texture.is_some() {
            self.places.resize(count, Vec4::ZERO);
            match places(self.vertices, info)? {
                Some(found) => {
                    self.places.iter_mut().zip(found).for_each(|(place, at)| set(place, at));
                }
                None => self.file.note_once(
                    "where a primitive lies on its texture is not said: the texture is read at 0, 0",
                ),
            }
        }
        Ok(texture)
    }
}
