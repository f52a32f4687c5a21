//! What the parser fills in for each element of a PLY file.

use crate::scene::geometry::DEFAULT_ALPHA;
use glam::{Vec3, Vec4};
use ply_rs_bw::ply::{BeginList, Property, PropertyAccess, PropertyAccessResult};

/// Names of the list with a face's vertices.
pub(super) const FACE_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// A vertex while it is read.
pub(super) struct Vertex {
    /// `x`, `y` and `z`.
    pub position: Vec3,
    /// `red`, `green`, `blue` and `alpha`, 0..=1; the default alpha if the file has none.
    pub colour: Vec4,
}

impl PropertyAccess for Vertex {
    fn new() -> Vertex {
        Vertex { position: Vec3::ZERO, colour: Vec4::new(0.0, 0.0, 0.0, DEFAULT_ALPHA) }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = property.to_f32_lossy() else {
            return PropertyAccessResult::Ignored;
        };
        let channel = || (value / full_scale(&property)).clamp(0.0, 1.0);
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "red" => self.colour.x = channel(),
            "green" => self.colour.y = channel(),
            "blue" => self.colour.z = channel(),
            "alpha" => self.colour.w = channel(),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// What stands for 1.0 in a colour of this type.
fn full_scale(property: &Property) -> f32 {
    match property {
        Property::Char(_) => 127.0,
        Property::UChar(_) => 255.0,
        Property::Short(_) => 32767.0,
        Property::UShort(_) => 65535.0,
        Property::Int(_) => i32::MAX as f32,
        Property::UInt(_) => u32::MAX as f32,
        _ => 1.0,
    }
}

/// A face's vertices while they are read.
pub(super) struct Face(pub Vec<i32>);

impl PropertyAccess for Face {
    fn new() -> Face {
        Face(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !FACE_LISTS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        let Some(list) = property.to_u32_list() else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0 = list.into_iter().map(|index| i32::try_from(index).unwrap_or(i32::MAX)).collect();
        PropertyAccessResult::Set
    }

    fn begin_list_int(&mut self, name: &str, _len: usize) -> BeginList<'_, i32> {
        match FACE_LISTS.contains(&name) {
            true => BeginList::Fill(&mut self.0),
            false => BeginList::UseSetter,
        }
    }
}

/// An element of no interest.
pub(super) struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Ignored {
        Ignored
    }
}
