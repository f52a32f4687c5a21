//! Cases of one scene for machines that come one after the other: what does not differ between them is made once.

use super::{Case, CaseError, view};
use crate::progress::Progress;
use crate::source::Source;
use crate::view::View;
use pellucid_machine::{Arithmetic, Model};
use std::sync::Arc;

/// See the module's description.
pub struct Cases {
    scene: String,
    source: Arc<Source>,
    frames: u32,
    known: Vec<(View, Arithmetic, Case)>,
}

impl Cases {
    /// For so many frames of a scene, or more where a machine makes one image of several.
    pub fn new(scene: &str, source: Source, frames: u32) -> Cases {
        let (scene, source) = (scene.to_string(), Arc::new(source));
        Cases { scene, source, frames, known: vec![] }
    }

    /// The frame.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// How many there are, but for a machine that makes one image of more.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The case for a machine. Those of one view and arithmetic share it.
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
        let mut case = Case::of(&self.scene, self.source.clone(), machine, progress)?;
        // Whatever the arithmetic, the frame is held once.
        if let Some(held) = self.known.iter().find_map(|(_, _, case)| case.held.clone()) {
            case.held = case.held.map(|_| held);
        }
        let case = case.with_frames(frames, machine, progress)?;
        if of_all {
            self.known.push((view, arithmetic, case.clone()));
        }
        Ok(case)
    }
}
