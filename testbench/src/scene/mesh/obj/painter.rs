//! What the textures of a material make of the faces that have it.

use super::material::Map;
use crate::scene::paint::{Paint, Texture, Veil};
use crate::scene::srgb::decoded;
use glam::{Vec2, Vec3, Vec4};

/// The paint of a part while its vertices are put together.
pub(super) struct Painter {
    textures: Vec<(Map, Texture)>,
    colours: Vec<Vec4>,
    places: Vec<Vec4>,
}

impl Painter {
    /// With these textures, if there are any.
    pub fn new(textures: Vec<(Map, Texture)>) -> Option<Painter> {
        (!textures.is_empty()).then(|| Painter { textures, colours: vec![], places: vec![] })
    }

    fn texture(&self, keyword: &str) -> Option<&(Map, Texture)> {
        self.textures.iter().find(|(map, _)| map.keyword == keyword)
    }

    /// Takes a vertex: its colour in sRGB, 0..=1, and its texture coordinates.
    pub fn vertex(&mut self, colour: Vec3, coordinates: Vec2) {
        let place =
            |keyword| self.texture(keyword).map_or(Vec2::ZERO, |(map, _)| map.place(coordinates));
        let (colour_place, veil_place) = (place("map_Kd"), place("map_d"));
        self.places.push(Vec4::from((colour_place, veil_place)));
        self.colours.push(Vec3::from(colour.to_array().map(decoded)).extend(1.0));
    }

    /// The paint of a material of that opacity. `map_d` is the alpha of its image, or the mean of the colours of one that has
    /// none; that of `map_Kd` says nothing.
    pub fn finish(self, alpha: f32) -> Paint {
        let colour = self.texture("map_Kd").map(|(_, texture)| texture.clone());
        let veil = match self.texture("map_d") {
            Some((_, texture)) => {
                let third = Vec3::splat(alpha / 3.0).extend(0.0);
                let weights = if texture.image.has_alpha() { alpha * Vec4::W } else { third };
                Veil { plain: 0.0, image: Some((texture.clone(), weights)) }
            }
            None => Veil { plain: alpha, image: None },
        };
        let Painter { colours, places, .. } = self;
        Paint {
            colours,
            places,
            colour,
            is_solid: true,
            veil: Some(veil),
            cutoff: None,
            alpha: None,
        }
    }
}
