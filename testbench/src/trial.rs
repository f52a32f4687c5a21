//! A trial: one scene through one machine, held to the golden model.

mod cases;

pub use cases::Cases;

use crate::bench::BenchError;
use crate::costs::{Costs, Logic, Technology};
use crate::golden::{Golden, GoldenError, Reference};
use crate::image::Image;
use crate::progress::Progress;
use crate::recorder::{WaveJob, WaveReport};
use crate::report::{Frame, Report};
use crate::run::{Job, Outcome, run};
use crate::scoreboard::Verdict;
use crate::source::{Source, SourceError};
use crate::view::View;
use crate::window::Window;
use pellucid_machine::pixel::Fragment;
use pellucid_machine::{Census, Model};
use std::sync::Arc;

/// A scene, and what the golden model says of it for machines of one view.
#[derive(Clone)]
pub struct Case {
    /// The scene's name or file.
    pub scene: String,
    /// Its frame.
    pub source: Arc<Source>,
    /// The same in memory, where it is not too large: so it is made once for the golden model and all machines.
    pub held: Option<Arc<Source>>,
    /// What machines must give.
    pub reference: Arc<Reference>,
    /// How many items they are sent: fragments or primitives.
    pub items: u64,
    /// What machines must give of the frames that come after it in the same run, each as [`Source::later`] has it.
    pub later: Arc<[Arc<Reference>]>,
    /// How often a machine plays them before the time that counts.
    pub warm_up: u32,
    /// The most cycles that a machine may take, if there is a limit.
    pub most_cycles: Option<u64>,
    /// Where the energy and area of memories on the chip come from.
    pub technology: Arc<Technology>,
    /// What the logic of the one machine that it is for takes, where that is known.
    pub logic: Option<Logic>,
}

/// What a machine gave, and how it was judged.
pub struct Trial {
    /// Its images: one for each frame, or for as many as the machine accumulates.
    pub images: Vec<Image>,
    /// Whether they are right.
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
        machine: &dyn Model,
        progress: &mut Progress,
    ) -> Result<Case, CaseError> {
        Case::of(scene, Arc::new(source), machine, progress)
    }

    fn of(
        scene: &str,
        source: Arc<Source>,
        machine: &dyn Model,
        progress: &mut Progress,
    ) -> Result<Case, CaseError> {
        let mut cases = Case::of_all(scene, source, &[machine], progress)?;
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
        machines: &[&dyn Model],
        progress: &mut Progress,
    ) -> Result<Vec<Case>, CaseError> {
        Case::of_all(scene, Arc::new(source), machines, progress)
    }

    fn of_all(
        scene: &str,
        source: Arc<Source>,
        machines: &[&dyn Model],
        progress: &mut Progress,
    ) -> Result<Vec<Case>, CaseError> {
        let views: Vec<View> =
            machines.iter().map(|machine| view(*machine, &source)).collect::<Result<_, _>>()?;
        let technology = Arc::new(Technology::default());
        let mut cases: Vec<Case> = vec![];
        for (k, view) in views.iter().enumerate() {
            let same = views[..k].iter().position(|other| other == view);
            let case = match same {
                Some(same) => cases[same].clone(),
                None => {
                    let alike = machines.iter().zip(&views).filter(|(_, other)| *other == view);
                    let arithmetics = alike.map(|(machine, _)| machine.arithmetic());
                    let golden = arithmetics.fold(Golden::new(source.screen()), Golden::with);
                    let holds = view.is_of_fragments();
                    let (reference, (items, held)) =
                        judged(&source, view, golden, holds, progress)?;
                    let held = held.map(|held| Source::Fragments(source.screen(), held));
                    Case {
                        scene: scene.to_string(),
                        source: source.clone(),
                        held: held.map(Arc::new),
                        reference: Arc::new(reference),
                        items,
                        later: Arc::new([]),
                        warm_up: 0,
                        most_cycles: None,
                        technology: technology.clone(),
                        logic: None,
                    }
                }
            };
            let of_image = machines[k].frames_of_image();
            cases.push(case.with_frames(of_image, machines[k], progress)?);
        }
        Ok(cases)
    }

    /// The case with so many frames in all, for the one machine that it is for. Of a source that is one frame alone each is
    /// that one.
    ///
    /// # Errors
    /// As [`Case::new`].
    pub fn with_frames(
        self,
        frames: u32,
        machine: &dyn Model,
        progress: &mut Progress,
    ) -> Result<Case, CaseError> {
        if frames == self.frames() {
            return Ok(self);
        }
        let later = (1..frames).map(|number| {
            let Some(source) = self.source.later(number)? else {
                return Ok(self.reference.clone());
            };
            let golden = Golden::new(source.screen()).with(machine.arithmetic());
            let view = view(machine, &source)?;
            let (reference, _) = judged(&source, &view, golden, false, progress)?;
            Ok(Arc::new(reference))
        });
        let later = later.collect::<Result<_, CaseError>>()?;
        Ok(Case { later, ..self })
    }

    /// What is known of each frame.
    pub fn censuses(&self) -> Vec<Census> {
        self.references().map(Reference::census).collect()
    }

    fn references(&self) -> impl Iterator<Item = &Reference> + Clone {
        [&self.reference].into_iter().chain(&*self.later).map(|reference| &**reference)
    }

    /// How many frames a run has.
    pub fn frames(&self) -> u32 {
        1 + self.later.len() as u32
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
        machine: &dyn Model,
        wave: Option<&WaveJob>,
        progress: &mut Progress,
    ) -> Result<Trial, BenchError> {
        match (run(machine, self.job(wave, progress)), wave) {
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
        machine: &dyn Model,
        wave: &WaveJob,
        window: Window,
        progress: &mut Progress,
    ) -> Result<Trial, BenchError> {
        let windows = wave.windows.iter().cloned().chain([window]).collect();
        let wave = WaveJob { windows, ..wave.clone() };
        progress.turn_to("again, for the waveform");
        let outcome = run(machine, self.job(Some(&wave), progress))?;
        self.judge(arch, machine, outcome)
    }

    fn job<'a>(&'a self, wave: Option<&'a WaveJob>, progress: &'a mut Progress) -> Job<'a> {
        // What comes after it is known of the source alone.
        let held = self.held.as_ref().filter(|_| self.frames() == 1);
        Job {
            source: held.unwrap_or(&self.source),
            frames: self.frames(),
            warm_up: self.warm_up,
            most_cycles: self.most_cycles,
            wave,
            progress,
        }
    }

    /// Judges what a machine gave.
    fn judge(
        &self,
        arch: &'static str,
        machine: &dyn Model,
        outcome: Outcome,
    ) -> Result<Trial, BenchError> {
        let references = self.references();
        let closed_forms = machine.closed_forms(&outcome.tally, &self.censuses());
        let Outcome { images, tally, frames: played, wave } = outcome;
        let frames = references.clone().zip(&played);
        let frames = frames.map(|(frame, played)| Frame::new(frame, played)).collect();
        let plays = played.iter().map(|frame| frame.plays).sum();
        let (arithmetic, accumulation) = (machine.arithmetic(), machine.accumulation());
        let several;
        let (reference, verdict) = match (&images[..], accumulation) {
            ([image], None) => {
                let reference = &*self.reference;
                (reference, Verdict::new(reference, arithmetic, image, &tally, closed_forms))
            }
            (images, accumulation) => {
                several = match accumulation {
                    Some(by) => Reference::accumulated(references, &by),
                    None => Reference::stacked(references),
                };
                let image = Image::stacked(images);
                let verdict = Verdict::new(&several, arithmetic, &image, &tally, closed_forms);
                (&several, verdict.of_frames(self.frames()))
            }
        };
        let verdict = Verdict { plays, ..verdict };
        let (screen, values) = (self.source.screen(), machine.values());
        let logic = self.logic.as_ref();
        let costs = Costs::new(&self.technology, &values, &tally, self.frames(), logic);
        let report = Report::new(arch, &self.scene, values, screen, reference, tally, &verdict);
        let report = report.with_frames(frames).with_costs(costs);
        Ok(Trial { images, verdict, report, wave })
    }
}

/// What a machine sees of a frame.
fn view(machine: &dyn Model, source: &Source) -> Result<View, SourceError> {
    View::new(machine.kind(), machine.dealer(), source)
}

/// Fragments of a frame that are held, at most: a frame with more is made anew each time.
const MOST_HELD: usize = 1 << 22;

/// How many items a frame has, and its fragments if they are held.
type Played = (u64, Option<Vec<Fragment>>);

/// What the golden model says of a frame that is seen so, how many items it has, and its fragments if it `holds` them and they are
/// not too many.
fn judged(
    source: &Source,
    view: &View,
    golden: Golden,
    mut holds: bool,
    progress: &mut Progress,
) -> Result<(Reference, Played), CaseError> {
    golden.judge(|sink| {
        // Where the frame is played again they are there, or were too many.
        let mut held = std::mem::take(&mut holds).then(Vec::new);
        let items = view.play::<CaseError>(source, &mut |fragment| {
            progress.step();
            if held.as_ref().is_some_and(|held: &Vec<Fragment>| held.len() == MOST_HELD) {
                held = None;
            }
            if let Some(held) = &mut held {
                held.push(fragment);
            }
            sink(fragment)
        })?;
        Ok((items, held))
    })
}

#[cfg(test)]
mod tests;
