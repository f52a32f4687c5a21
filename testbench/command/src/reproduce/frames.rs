//! What is played: frames of a scene on a screen.

use crate::quoted;
use pellucid_testbench::scene::{Camera, Options, Sequence, Walk};
use pellucid_testbench::source::Source;

/// A frame, or a walk of several.
#[derive(Clone, Debug)]
pub struct Frames {
    /// A built-in scene, or a mesh.
    pub scene: String,
    /// Width and height of the screen in pixels.
    pub screen: (u32, u32),
    /// How often the scene is there, side by side; nothing for a scene of pixels.
    pub instances: Option<u32>,
    /// Where it is seen from; nothing for the scene's own view.
    pub camera: Option<Camera>,
    /// The way of the camera.
    pub walk: Option<Walk>,
}

impl Frames {
    /// A scene on a square screen, as it is.
    pub fn square(scene: &str, side: u32) -> Frames {
        Frames {
            scene: scene.to_string(),
            screen: (side, side),
            instances: None,
            camera: None,
            walk: None,
        }
    }

    /// How they are asked for, as a shell takes it.
    pub fn arguments(&self) -> String {
        let (width, height) = self.screen;
        let scene = quoted(&self.scene);
        let mut words = format!("--scene {scene} --width {width} --height {height}");
        if let Some(instances) = self.instances {
            words += &format!(" --instances {instances}");
        }
        if let Some(camera) = self.camera {
            words += &format!(" --camera {}", quoted(&camera.to_string()));
        }
        if let Some(Walk { path, frames }) = self.walk {
            words += &format!(" --path {path} --frames {frames}");
        }
        words
    }

    /// Width and height, as a table shows them.
    pub fn size(&self) -> String {
        format!("{}x{}", self.screen.0, self.screen.1)
    }

    /// Its pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.screen.0) * u64::from(self.screen.1)
    }

    /// How many frames there are.
    pub fn count(&self) -> u32 {
        self.walk.map_or(1, |walk| walk.frames)
    }

    /// Opens the scene.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn open(&self) -> anyhow::Result<Source> {
        let (width, height) = self.screen;
        let Frames { instances, camera, walk, .. } = *self;
        let (width, height) = (Some(width), Some(height));
        let sequence = walk.map(Sequence::Walk);
        let options = Options { width, height, instances, camera, sequence, ..Options::default() };
        Ok(Source::open(&self.scene, &options)?)
    }
}
