//! The images of a glTF file and the textures that show them.

use super::super::images::Unseen;
use super::super::{Reading, bad};
use super::buffers::{Buffers, at};
use crate::scene::SceneError;
use crate::scene::paint::Texture;
use crate::scene::texture::{Image, Wrap};
use ::gltf::image::Source;
use ::gltf::texture::WrappingMode;
use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

/// The images of a file, read where they are used.
#[derive(Default)]
pub(super) struct Images {
    /// By their index; nothing for one that is not seen.
    read: HashMap<usize, Option<Arc<Image>>>,
    files: HashMap<PathBuf, Rc<Vec<u8>>>,
    unseen: Unseen,
}

impl Images {
    /// A texture; nothing if it has no image that can be read.
    pub fn texture(
        &mut self,
        file: &mut Reading,
        buffers: &Buffers,
        texture: &::gltf::Texture,
    ) -> Result<Option<Texture>, SceneError> {
        let Some(source) = texture.source() else {
            self.unseen.has_other_form(format_args!("that of texture {}", texture.index()));
            return Ok(None);
        };
        let image = match self.read.get(&source.index()) {
            Some(image) => image.clone(),
            None => {
                let image = self.image(file, buffers, &source)?;
                self.read.insert(source.index(), image.clone());
                image
            }
        };
        let sampler = texture.sampler();
        let wraps = [sampler.wrap_s(), sampler.wrap_t()].map(|wrap| match wrap {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        });
        Ok(image.map(|image| Texture { image, wraps }))
    }

    fn image(
        &mut self,
        file: &mut Reading,
        buffers: &Buffers,
        image: &::gltf::Image,
    ) -> Result<Option<Arc<Image>>, SceneError> {
        let path = file.path;
        let error = |what: &str| bad(path, None, format!("image {} {what}", image.index()));
        let name = format_args!("image {}", image.index());
        match image.source() {
            Source::View { view, .. } => {
                let bytes =
                    buffers.view(&view).ok_or_else(|| error("reaches beyond its buffer"))?;
                self.unseen.decoded(file, bytes, name, &error)
            }
            Source::Uri { uri, .. } => match at(file, uri, &mut self.files, &error) {
                Err(SceneError::Unreadable { path, source })
                    if source.kind() == ErrorKind::NotFound =>
                {
                    self.unseen.is_missing(&path);
                    Ok(None)
                }
                bytes => self.unseen.decoded(file, &bytes?, name, &error),
            },
        }
    }

    /// Notes which images are not seen.
    pub fn tell(&self, file: &mut Reading) {
        self.unseen.tell(file);
    }
}
