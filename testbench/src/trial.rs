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
use crate::window::Window;
use pellucid_hw::machine::{Arithmetic, Census};

/// A scene, and what the golden model says of it.
pub struct Case {
    /// The scene's name or file.
    pub scene: String,
    /// Its fragments.
    pub source: Source,
    /// What machines must give.
    pub reference: Reference,
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
    /// Plays the scene to the golden model, for machines of the given arithmetics.
    ///
    /// # Errors
    /// The frame cannot be read, or has more fragments than the golden model holds.
    pub fn new(
        scene: &str,
        source: Source,
        arithmetics: impl IntoIterator<Item = Arithmetic>,
        progress: &mut Progress,
    ) -> Result<Case, CaseError> {
        let golden = Golden::new(source.screen());
        let mut golden = arithmetics.into_iter().fold(golden, Golden::with);
        source.play::<CaseError>(&mut |fragment| {
            progress.step();
            Ok(golden.push(fragment)?)
        })?;
        Ok(Case { scene: scene.to_string(), source, reference: golden.finish(), warm_up: 0 })
    }

    /// Sends the scene through a machine of the architecture `arch` and judges what it gives. Where the model
    /// turns out to be at fault and a waveform is asked for, the frame is played again: then the waveform has
    /// the cycles before, too.
    ///
    /// # Errors
    /// See [`BenchError`].
    ///
    /// # Panics
    /// The case is not for machines of that arithmetic.
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
        let (screen, reference) = (self.source.screen(), &self.reference);
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
