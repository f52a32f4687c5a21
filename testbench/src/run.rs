//! A run: frames through a machine.

use crate::bench::{Bench, BenchError, Played};
use crate::image::Image;
use crate::progress::Progress;
use crate::recorder::{WaveJob, WaveReport};
use crate::source::Source;
use pellucid_machine::{Model, Tally};

/// What is asked of a run.
pub struct Job<'a> {
    /// The first frame.
    pub source: &'a Source,
    /// How many there are, played in a row: the next one may come while the one before is still being shown. Each is
    /// as [`Source::later`] has it, or the first one again where that gives none. A machine that makes one image of several
    /// has as many as make whole images.
    pub frames: u32,
    /// How often they are played before the time that counts, so that memories and free sections are as a running
    /// machine has them.
    pub warm_up: u32,
    /// The most cycles that it may take, if there is a limit.
    pub most_cycles: Option<u64>,
    /// The waveform.
    pub wave: Option<&'a WaveJob>,
    /// Told of every item.
    pub progress: &'a mut Progress,
}

/// What a run gives.
pub struct Outcome {
    /// The images: one for each frame, or for as many as the machine accumulates.
    pub images: Vec<Image>,
    /// What was counted.
    pub tally: Tally,
    /// Of it what each frame took.
    pub frames: Vec<Played>,
    /// What the waveform has.
    pub wave: WaveReport,
}

/// Runs the frames.
///
/// # Errors
/// See [`BenchError`].
pub fn run(model: &dyn Model, job: Job) -> Result<Outcome, BenchError> {
    let Job { source, frames, warm_up, most_cycles, wave, progress } = job;
    let within = |bench: &Bench| match most_cycles {
        Some(most) if bench.cycles() > most => Err(BenchError::TooLong(most)),
        _ => Ok(()),
    };
    let mut bench = Bench::new(model);
    bench.reserve()?;
    if let Some(wave) = wave {
        bench.record(wave, "machine")?;
    }
    let ((), wave) = bench.traced(|bench| {
        for left in (0..=warm_up).rev() {
            if left < warm_up {
                // What came before has left its traces in the memories alone.
                bench.take_images();
                bench.count_anew();
                progress.turn_to("simulating");
            }
            let mut plays = 0;
            source.each_frame::<BenchError>(frames, &mut |_, source| {
                // The items of all frames are as many as was said; those that are asked for again come on top.
                if plays > 1 {
                    progress.turn_to("simulating");
                }
                plays = 0;
                bench.frame(|bench| {
                    plays += 1;
                    if plays > 1 {
                        progress.turn_to("simulating, the frame again");
                    }
                    source.play(model.kind(), &mut |item| {
                        progress.step();
                        bench.send(item)?;
                        within(bench)
                    })
                })
            })?;
            progress.turn_to("resolving");
            bench.wait_for((frames / model.frames_of_image()) as usize, |bench, cycles| {
                progress.steps(cycles);
                within(bench)
            })?;
        }
        Ok(())
    })?;
    let images = bench.take_images();
    Ok(Outcome { images, tally: bench.tally(), frames: bench.frames(), wave })
}
