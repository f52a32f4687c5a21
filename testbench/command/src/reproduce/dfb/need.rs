//! What of memory frames need.

use super::contender;
use crate::reproduce::frames::Frames;
use pellucid_hw::architecture;
use pellucid_machine::Census;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::trial::Case;
use serde_json::{Value as Json, json};

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

/// Plays them to the golden model: a case for each of the contenders.
///
/// # Errors
/// They cannot be read, or the golden model cannot hold them.
pub fn case(frames: &Frames, progress: &mut Progress) -> anyhow::Result<Case> {
    let source = frames.open()?;
    // All contenders see fragments, and blend alike.
    let machine = architecture(contender::DFB.arch)?.build(source.screen(), None, &[])?;
    let case = Case::new(&frames.scene, source, &*machine, progress)?;
    Ok(case.with_frames(frames.count(), &*machine, progress)?)
}

/// What the frames of a case need.
pub fn need(case: &Case, pixels: u64) -> Need {
    let later = case.later.iter().map(|reference| reference.census());
    let frames: Vec<Census> = [case.reference.census()].into_iter().chain(later).collect();
    Need::of(pixels, &frames)
}
