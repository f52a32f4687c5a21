//! What is played: frames of a scene on a screen, and what of memory they need.

use super::contender::{self, Contender};
use crate::quoted;
use pellucid_hw::architecture;
use pellucid_machine::Census;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::scene::{Options, Walk};
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::Case;
use serde_json::{Value as Json, json};

/// A frame, or a walk of several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames {
    /// A built-in scene, or a mesh.
    pub scene: String,
    /// Width and height of the screen in pixels.
    pub screen: (u32, u32),
    /// How often the scene is there, side by side; nothing for a scene of pixels.
    pub instances: Option<u32>,
    /// The way of the camera.
    pub walk: Option<Walk>,
    /// The machines that play it.
    pub contenders: Vec<Contender>,
}

/// What the frames need: for each figure the most that one of them does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Pixels of the screen.
    pub pixels: u64,
    /// N: fragments that are stored.
    pub fragments: u64,
    /// L: those of the deepest pixel.
    pub layers: u64,
    /// Pages of one fragment and of four.
    pub pages: [u64; 2],
}

/// Fragments of a page, in the order of [`Need::pages`].
pub const PAGES: [u32; 2] = [1, 4];

impl Need {
    fn of(pixels: u64, frames: &[Census]) -> Need {
        let most = |of: &dyn Fn(&Census) -> u64| frames.iter().map(of).max().unwrap_or(0);
        let pages = |page: u32| {
            most(&|frame| frame.layers().map(|(n, i)| n * i.div_ceil(page.into())).sum())
        };
        Need {
            pixels,
            fragments: most(&|frame| frame.stored),
            layers: most(&|frame| {
                frame.layers().filter(|(n, _)| *n > 0).map(|(_, i)| i).max().unwrap_or(0)
            }),
            pages: PAGES.map(pages),
        }
    }

    /// As an object.
    pub fn json(self) -> Json {
        let Need { pixels, fragments, layers, pages: [one, four] } = self;
        json!({ "pixels": pixels, "fragments": fragments, "layers": layers, "pages": [one, four] })
    }

    /// What [`Need::json`] has made.
    pub fn read(json: &Json) -> Option<Need> {
        let number = |name: &str| json[name].as_u64();
        let page = |k: usize| json["pages"][k].as_u64();
        Some(Need {
            pixels: number("pixels")?,
            fragments: number("fragments")?,
            layers: number("layers")?,
            pages: [page(0)?, page(1)?],
        })
    }
}

impl Frames {
    /// How they are asked for, as a shell takes it.
    pub fn arguments(&self) -> String {
        let (width, height) = self.screen;
        let scene = quoted(&self.scene);
        let mut words = format!("--scene {scene} --width {width} --height {height}");
        if let Some(instances) = self.instances {
            words += &format!(" --instances {instances}");
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

    fn open(&self) -> anyhow::Result<Source> {
        let (width, height) = self.screen;
        let Frames { instances, walk, .. } = *self;
        let (width, height) = (Some(width), Some(height));
        let options = Options { width, height, instances, walk, ..Options::default() };
        Ok(Source::open(&self.scene, &options)?)
    }

    /// Plays them to the golden model: a case for each of the contenders.
    ///
    /// # Errors
    /// They cannot be read, or the golden model cannot hold them.
    pub fn case(&self, progress: &mut Progress) -> anyhow::Result<Case> {
        let source = self.open()?;
        // All contenders see fragments, and blend alike.
        let machine = architecture(contender::DFB.arch)?.build(source.screen(), None, &[])?;
        let case = Case::new(&self.scene, source, &*machine, progress)?;
        Ok(case.with_frames(self.count(), &*machine, progress)?)
    }
}

/// What the frames of a case need.
pub fn need(case: &Case, pixels: u64) -> Need {
    let later = case.later.iter().map(|reference| reference.census());
    let frames: Vec<Census> = [case.reference.census()].into_iter().chain(later).collect();
    Need::of(pixels, &frames)
}
