//! What is played: frames of a scene on a screen.

use crate::quoted;
use pellucid_testbench::scene::{Camera, Options, Sequence, Varied, Walk};
use pellucid_testbench::source::Source;

/// A frame, or a sequence of several.
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
    /// How several frames differ.
    pub sequence: Option<Sequence>,
}

impl Frames {
    /// A scene on a square screen, as it is.
    pub fn square(scene: &str, side: u32) -> Frames {
        Frames {
            scene: scene.to_string(),
            screen: (side, side),
            instances: None,
            camera: None,
            sequence: None,
        }
    }

    /// The way of the camera, if it goes one.
    pub fn walk(&self) -> Option<Walk> {
        match self.sequence? {
            Sequence::Walk(walk) => Some(walk),
            Sequence::Varied(_) => None,
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
        match self.sequence {
            Some(Sequence::Walk(Walk { path, frames })) => {
                words += &format!(" --path {path} --frames {frames}");
            }
            Some(Sequence::Varied(Varied { vary, frames })) => {
                words += &format!(" --vary {vary} --frames {frames}");
            }
            None => {}
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
        self.sequence.map_or(1, Sequence::frames)
    }

    /// Opens the scene.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn open(&self) -> anyhow::Result<Source> {
        let (width, height) = self.screen;
        let Frames { instances, camera, sequence, .. } = *self;
        let (width, height) = (Some(width), Some(height));
        let options = Options { width, height, instances, camera, sequence, ..Options::default() };
        Ok(Source::open(&self.scene, &options)?)
    }
}
