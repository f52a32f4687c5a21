//! What becomes of a scene from frame to frame, if it is told.

use super::vary::Varied;
use super::walk::Walk;

/// How the frames of a scene differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// The camera goes a way.
    Walk(Walk),
    /// The scene is sampled anew from one view.
    Varied(Varied),
}

impl Sequence {
    /// How many frames it is for.
    pub fn frames(self) -> u32 {
        match self {
            Sequence::Walk(Walk { frames, .. }) | Sequence::Varied(Varied { frames, .. }) => frames,
        }
    }
}
