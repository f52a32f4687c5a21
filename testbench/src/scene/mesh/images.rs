//! The images that a file names: those that are seen, and how many are not.

use super::{Found, Reading};
use crate::scene::SceneError;
use crate::scene::texture::{Encoded, Image};
use std::fmt;
use std::sync::Arc;

/// Images of a file that are not seen.
#[derive(Default)]
pub(super) struct Unseen {
    missing: Found,
    other_forms: Found,
}

impl Unseen {
    /// There is no file where the image is to be.
    pub fn is_missing(&mut self, path: &str) {
        self.missing.add(format_args!("`{path}`"));
    }

    /// The image, here with its name, is in a form that is not read.
    pub fn has_other_form(&mut self, name: fmt::Arguments) {
        self.other_forms.add(name);
    }

    /// Decodes an image, once there is room for it; nothing if it is no PNG or JPEG. `error` says what is wrong with it.
    pub fn decoded(
        &mut self,
        file: &mut Reading,
        bytes: &[u8],
        name: fmt::Arguments,
        error: &dyn Fn(&str) -> SceneError,
    ) -> Result<Option<Arc<Image>>, SceneError> {
        let Some(encoded) = Encoded::new(bytes).map_err(|what| error(&what))? else {
            self.has_other_form(name);
            return Ok(None);
        };
        file.take(encoded.bytes())?;
        let image = encoded.decode().map_err(|what| error(&what))?;
        Ok(Some(Arc::new(image)))
    }

    /// Notes them.
    pub fn tell(&self, file: &mut Reading) {
        file.not_seen(self.missing.named("image that does not exist", "images that do not exist"));
        let (one, several) = ("image that is no PNG or JPEG", "images that are no PNG or JPEG");
        file.not_seen(self.other_forms.named(one, several));
    }
}
