//! A trial: one scene through one machine, held to the golden model.

use crate::arch::{Job, Outcome, Runnable};
use crate::bench::BenchError;
use crate::golden::{Golden, GoldenError, Reference};
use crate::image::Image;
use crate::progress::Progress;
use crate::recorder::{WaveJob, WaveReport};
use crate::report::Report;
use crate::scoreboard::Verdict;
use crate::source::{Source, SourceError};
use crate::view::View;
use crate::window::Window;
use pellucid_hw::machine::Census;
use std::sync::Arc;

/// A scene, and what the golden model says of it for machines of one view.
#[derive(Clone)]
pub struct Case {
    /// The scene's name or file.
    pub scene: String,
    /// Its frame.
    pub source: Arc<Source>,
    /// What machines must give.
    pub reference: Arc<Reference>,
    /// How many items they are sent: fragments or primitives.
    pub items: u64,
    /// How often a machine plays them before the time that counts.
    pub warm_up: u32,
}

/// What a machine gave, and how it was judged.
pub struct Trial {
    /// Its image.
    pub image: Image,
    /// Whether it is right.
    pub verdict: Verdict,
    /// Its figures.
    pub report: Report,
    /// What its waveform has.
    pub wave: WaveReport,
}

/// A scene of which the golden model can say nothing.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// The frame could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The frame does not fit the golden model.
    #[error(transparent)]
    Golden(#[from] GoldenError),
}

impl Case {
    /// Plays the scene to the golden model, for one machine.
    ///
    /// # Errors
    /// The frame cannot be read, or has more fragments than the golden model holds.
    pub fn new(
        scene: &str,
        source: Source,
        machine: &dyn Runnable,
        progress: &mut Progress,
    ) -> Result<Case, CaseError> {
        let mut cases = Case::all(scene, source, &[machine], progress)?;
        Ok(cases.remove(0))
    }

    /// Plays the scene to the golden model, for several machines: a case for each. Those of machines that see the
    /// frame alike share what the golden model says.
    ///
    /// # Errors
    /// As [`Case::new`].
    pub fn all(
        scene: &str,
        source: Source,
        machines: &[&dyn Runnable],
        progress: &mut Progress,
    ) -> Result<Vec<Case>, CaseError> {
        let views: Vec<View> =
            machines.iter().map(|machine| machine.view(&source)).collect::<Result<_, _>>()?;
        let source = Arc::new(source);
        let mut cases: Vec<Case> = vec![];
        for (k, view) in views.iter().enumerate() {
            let same = views[..k].iter().position(|other| other == view);
            let case = match same {
                Some(same) => cases[same].clone(),
                None => {
                    let alike = machines.iter().zip(&views).filter(|(_, other)| *other == view);
                    let arithmetics = alike.map(|(machine, _)| machine.arithmetic());
                    let golden = arithmetics.fold(Golden::new(source.screen()), Golden::with);
                    Case::seen(scene, &source, view, golden, progress)?
                }
            };
            cases.push(case);
        }
        Ok(cases)
    }

    fn seen(
        scene: &str,
        source: &Arc<Source>,
        view: &View,
        mut golden: Golden,
        progress: &mut Progress,
    ) -> Result<Case, CaseError> {
        let items = view.play::<CaseError>(source, &mut |fragment| {
            progress.step();
            Ok(golden.push(fragment)?)
        })?;
        let (scene, source) = (scene.to_string(), source.clone());
        Ok(Case { scene, source, reference: Arc::new(golden.finish()), items, warm_up: 0 })
    }

    /// Sends the scene through a machine of the architecture `arch` and judges what it gives. Where the model
    /// turns out to be at fault and a waveform is asked for, the frame is played again: then the waveform has
    /// the cycles before, too.
    ///
    /// # Errors
    /// See [`BenchError`].
    ///
    /// # Panics
    /// The case is for machines of other arithmetics alone.
    pub fn run(
        &self,
        arch: &'static str,
        machine: &dyn Runnable,
        wave: Option<&WaveJob>,
        progress: &mut Progress,
    ) -> Result<Trial, BenchError> {
        match (machine.run(self.job(wave, progress)), wave) {
            // A model is the same every time: it fails again.
            (Err(error), Some(wave)) if error.fault().is_some() => {
                self.run_again(arch, machine, wave, Window::Failure, progress)
            }
            (outcome, _) => self.judge(arch, machine, outcome?),
        }
    }

    /// The same once more, for a waveform with a further window.
    ///
    /// # Errors
    /// See [`BenchError`].
    ///
    /// # Panics
    /// As [`Case::run`] does.
    pub fn run_again(
        &self,
        arch: &'static str,
        machine: &dyn Runnable,
        wave: &WaveJob,
        window: Window,
        progress: &mut Progress,
    ) -> Result<Trial, BenchError> {
        let windows = wave.windows.iter().cloned().chain([window]).collect();
        let wave = WaveJob { windows, ..wave.clone() };
        progress.turn_to("again, for the waveform");
        let outcome = machine.run(self.job(Some(&wave), progress))?;
        self.judge(arch, machine, outcome)
    }

    fn job<'a>(&'a self, wave: Option<&'a WaveJob>, progress: &'a mut Progress) -> Job<'a> {
        Job { source: &self.source, warm_up: self.warm_up, wave, progress }
    }

    /// Judges what a machine gave.
    fn judge(
        &self,
        arch: &'static str,
        machine: &dyn Runnable,
        outcome: Outcome,
    ) -> Result<Trial, BenchError> {
        let (screen, reference) = (self.source.screen(), &*self.reference);
        let histogram = reference.stored_histogram.clone();
        let census = Census { stored: reference.stored, histogram };
        let closed_forms = machine.closed_forms(&outcome.tally, &census);
        let Outcome { image, tally, wave } = outcome;
        let arithmetic = machine.arithmetic();
        let verdict = Verdict::new(reference, arithmetic, &image, &tally, closed_forms);
        let values = machine.values();
        let report = Report::new(arch, &self.scene, values, screen, reference, tally, &verdict);
        Ok(Trial { image, verdict, report, wave })
    }
}

#[cfg(test)]
mod tests;
