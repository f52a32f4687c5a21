//! Cases of one scene for machines that come one after the other: what does not differ between them is made once.

use super::{Case, CaseError, view};
use crate::progress::Progress;
use crate::source::Source;
use crate::view::View;
use pellucid_machine::pixel::Fragment;
use pellucid_machine::{Arithmetic, Kind, Model};
use std::sync::Arc;

/// Fragments of a frame that are held, at most: of a frame with more each machine has them made anew.
const MOST_HELD: u64 = 1 << 22;

/// See the module's description.
pub struct Cases {
    scene: String,
    source: Arc<Source>,
    frames: u32,
    known: Vec<(View, Arithmetic, Case)>,
    held: Option<Arc<Source>>,
}

impl Cases {
    /// For so many frames of a scene, or more where a machine makes one image of several.
    pub fn new(scene: &str, source: Source, frames: u32) -> Cases {
        let (scene, source) = (scene.to_string(), Arc::new(source));
        Cases { scene, source, frames, known: vec![], held: None }
    }

    /// The frame.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// How many there are, but for a machine that makes one image of more.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The case for a machine. Those of one view and arithmetic share what the golden model says, and machines that take
    /// fragments those of a frame that is alone and not too large.
    ///
    /// # Errors
    /// As [`Case::new`].
    pub fn of(&mut self, machine: &dyn Model, progress: &mut Progress) -> Result<Case, CaseError> {
        let (view, arithmetic) = (view(machine, &self.source)?, machine.arithmetic());
        let frames = self.frames.next_multiple_of(machine.frames_of_image());
        let known = self
            .known
            .iter()
            .find(|(v, a, case)| (v, a, case.frames()) == (&view, &arithmetic, frames));
        // What becomes of several frames is the machine's own.
        let of_all = machine.frames_of_image() == 1;
        if let Some((_, _, case)) = known.filter(|_| of_all) {
            return Ok(case.clone());
        }
        let case = Case::of(&self.scene, self.source.clone(), machine, progress)?;
        let mut case = case.with_frames(frames, machine, progress)?;
        if machine.kind() == Kind::Fragments && frames == 1 && case.items <= MOST_HELD {
            if self.held.is_none() {
                let mut fragments: Vec<Fragment> = vec![];
                self.source.play_fragments::<CaseError>(&mut |fragment| {
                    fragments.push(fragment);
                    Ok(())
                })?;
                self.held = Some(Arc::new(Source::Fragments(self.source.screen(), fragments)));
            }
            case.source = self.held.clone().unwrap_or(case.source);
        }
        if of_all {
            self.known.push((view, arithmetic, case.clone()));
        }
        Ok(case)
    }
}
