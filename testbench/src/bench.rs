//! The bench: a machine under the clock, fed with frames, watched, and its images caught.

use crate::image::Image;
use crate::output::OutputError;
use crate::ports::PortRecorder;
use crate::recorder::{Recorder, WaveError, WaveJob, WaveReport};
use crate::room::{NoRoom, reserve};
use crate::source::SourceError;
use pellucid_machine::board::Timing;
use pellucid_machine::dut::Observer;
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Cycles, Dut, Failure, Item, Model, Offer, Tally};
use pellucid_sim::netlist::Module;
use pellucid_sim::panic_text;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Cycles between two looks at the progress of what is only waited for.
const WAIT: u64 = 1 << 12;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The model is at fault, or nothing moves.
    #[error(transparent)]
    Failure(#[from] Box<Failure>),
    /// An assertion in a block did not hold, or its arithmetic overflowed.
    #[error("fault in the model: an assertion failed: {0}")]
    Assertion(String),
    /// The run takes more cycles than it may.
    #[error("stopped after {0} cycles")]
    TooLong(u64),
    /// The frame could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The waveform could not be begun.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The model is at fault, and its waveform could not be written.
    #[error("{fault}; it is not shown: {lost}")]
    Unseen {
        /// What is wrong with the model.
        fault: Box<BenchError>,
        /// Why it is not shown.
        lost: OutputError,
    },
    /// The machine is too large for this computer.
    #[error(transparent)]
    Room(#[from] NoRoom),
}

impl BenchError {
    /// In a word or two what is wrong with the model; nothing if it is not the model.
    pub fn fault(&self) -> Option<String> {
        match self {
            BenchError::Failure(failure) => Some(match &**failure {
                Failure::Fault(fault) => format!("fault in {}", fault.path),
                Failure::Violation(violation) => format!("{} breaks a rule", violation.stream),
                Failure::Deadlock(_) => "stands still".to_string(),
            }),
            BenchError::Assertion(_) => Some("assertion fails".to_string()),
            BenchError::Unseen { fault, .. } => fault.fault(),
            BenchError::TooLong(_)
            | BenchError::Source(_)
            | BenchError::Output(_)
            | BenchError::Wave(_)
            | BenchError::Room(_) => None,
        }
    }
}

/// See the module's description.
///
/// ```
/// use pellucid_machine::pixel::{Fragment, Screen};
/// use pellucid_sim::Label;
/// use pellucid_tbuffer::architecture::ARCHITECTURE;
/// use pellucid_testbench::bench::Bench;
///
/// let screen = Screen { width: 2, height: 1, background: 0 };
/// let mut bench = Bench::new(&*ARCHITECTURE.build(screen, Some("fast"), &[])?);
/// // White over all of the left pixel, and red of half its strength in front of it; the right one is left empty.
/// for (z, rgba) in [(7, 0xffff_ffff), (3, 0xff00_0080)] {
///     bench.send(&Fragment { x: 0, y: 0, z, rgba, label: Label::NONE }.into())?;
/// }
/// bench.end_frame()?;
/// assert_eq!(bench.take_images()[0].pixels, [0xff_7f7f, 0]);
/// assert_eq!(bench.tally().fragments.blended, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Bench {
    dut: Box<dyn Dut>,
    screen: Screen,
    replays: bool,
    /// Nothing of the frame that is being sent has been taken.
    opens: bool,
    sent: Vec<Sent>,
}

/// A frame that is sent or was.
struct Sent {
    /// What had been counted when its first item was taken.
    begins: Cycles,
    /// How often all of it was sent.
    plays: u64,
}

/// What a frame took.
pub struct Played {
    /// Cycles from its first item to that of the next frame.
    pub cycles: Cycles,
    /// How often it was sent.
    pub plays: u64,
}

impl Bench {
    /// A machine at power-up.
    pub fn new(model: &dyn Model) -> Bench {
        Bench {
            dut: model.power_up(),
            screen: model.screen(),
            replays: model.replays(),
            opens: false,
            sent: vec![],
        }
    }

    /// Makes room for the machine's memories, before it runs; else they grow as they are written, and end the
    /// program where they cannot.
    ///
    /// # Errors
    /// There is none: [`BenchError::Room`].
    pub fn reserve(&mut self) -> Result<(), BenchError> {
        Ok(reserve(self.dut.memories())?)
    }

    /// Makes the display take a pixel only in cycles for which `ready` says so.
    pub fn set_display(&mut self, ready: impl FnMut(u64) -> bool + 'static) {
        self.dut.set_display(Box::new(ready));
    }

    /// Gives the outside memory another timing, before anything is sent.
    pub fn set_timing(&mut self, timing: Box<dyn Timing>) {
        self.dut.set_timing(timing);
    }

    /// Writes a waveform from now on, and at its end beside it what viewers need to show it. `scope` names
    /// the machine in it.
    ///
    /// # Errors
    /// The file cannot be written, or something is asked for that the machine does not have.
    pub fn record(&mut self, job: &WaveJob, scope: &str) -> Result<(), WaveError> {
        let recorder = Recorder::new(job, scope, &mut *self.dut)?;
        self.dut.watch(Box::new(recorder));
        Ok(())
    }

    /// Writes the inputs and outputs of every cycle from now on to the file `path`, for the machine's
    /// netlist.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn record_ports(&mut self, path: &Path, netlist: &Module) -> Result<(), OutputError> {
        self.dut.watch(Box::new(PortRecorder::new(path, netlist)?));
        Ok(())
    }

    /// Ends what [`Bench::record_ports`] began.
    ///
    /// # Errors
    /// The file could not be written.
    pub fn finish_ports(&mut self) -> Result<(), OutputError> {
        self.observer::<PortRecorder>().map_or(Ok(()), |ports| ports.finish())
    }

    /// Shows every cycle from now on to `observer`.
    pub fn watch(&mut self, observer: impl Observer) {
        self.dut.watch(Box::new(observer));
    }

    /// Whoever watches, if it is of that kind.
    pub fn observer<T: Observer>(&mut self) -> Option<Box<T>> {
        let observer: Box<dyn Any> = self.dut.unwatch()?;
        observer.downcast().ok()
    }

    /// Plays what `play` plays and ends the waveform that is recorded, if any, whatever comes of it: one is
    /// wanted most of all when the model goes wrong. A panic is an assertion that failed. A frame that cannot
    /// be read leaves none, and a waveform that cannot be written is left as far as it goes, which its report says.
    ///
    /// # Errors
    /// Those of `play`.
    pub fn traced<T>(
        &mut self,
        play: impl FnOnce(&mut Self) -> Result<T, BenchError>,
    ) -> Result<(T, WaveReport), BenchError> {
        // What is left of the simulation is only looked at.
        let played = catch_unwind(AssertUnwindSafe(|| play(self)));
        let played = played
            .unwrap_or_else(|panic| Err(BenchError::Assertion(panic_text(&*panic).to_string())));
        let fault = match played {
            Ok(done) => return Ok((done, self.finish_wave())),
            Err(error) => error,
        };
        if let Some(what) = fault.fault() {
            let time = self.dut.show_fault();
            if let Some(mut wave) = self.observer::<Recorder>() {
                wave.failure(time, &what);
                self.dut.watch(wave);
            }
        } else if let (BenchError::Source(_) | BenchError::TooLong(_), Some(wave)) =
            (&fault, self.observer::<Recorder>())
        {
            wave.discard();
        }
        match self.finish_wave().lost {
            None => Err(fault),
            Some(lost) => Err(BenchError::Unseen { fault: Box::new(fault), lost }),
        }
    }

    /// Sends one item, for as many cycles as that takes.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn send(&mut self, item: &Item) -> Result<(), BenchError> {
        self.take(Offer::Item(item))
    }

    /// Sends what is offered; it may be the first of a frame.
    fn take(&mut self, offer: Offer) -> Result<(), BenchError> {
        self.dut.send(offer)?;
        if std::mem::take(&mut self.opens) {
            let phase = &self.dut.phases()[usize::from(self.dut.phase())];
            let begins = self.dut.tally().cycles.before_one_of(phase);
            self.sent.push(Sent { begins, plays: 0 });
        }
        Ok(())
    }

    /// One cycle; whether what is offered is taken in it, or would be.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn step(&mut self, offer: Offer) -> Result<bool, BenchError> {
        Ok(self.dut.step(offer)?)
    }

    /// One cycle in which nothing is offered; whether something would have been taken.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn pause(&mut self) -> Result<bool, BenchError> {
        self.step(Offer::Nothing)
    }

    /// Sends a frame as often as the machine asks for it: `play` sends its items, the same each time.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn frame(
        &mut self,
        mut play: impl FnMut(&mut Self) -> Result<(), BenchError>,
    ) -> Result<(), BenchError> {
        self.opens = true;
        loop {
            play(self)?;
            self.take(Offer::End)?;
            if let Some(frame) = self.sent.last_mut() {
                frame.plays += 1;
            }
            if !self.replays {
                return Ok(());
            }
            // It opens for the same frame again, or for the next one.
            while !self.pause()? {}
            if !self.dut.replay() {
                return Ok(());
            }
        }
    }

    /// Waits until `images` images have been shown and not been taken, and tells `each` how many cycles have gone by
    /// now and then.
    ///
    /// # Errors
    /// See [`BenchError`]; the first one of `each`.
    pub fn wait_for(
        &mut self,
        images: usize,
        mut each: impl FnMut(&Self, u64) -> Result<(), BenchError>,
    ) -> Result<(), BenchError> {
        while self.dut.images() < images {
            let cycles = self.dut.run(WAIT, images)?;
            each(self, cycles)?;
        }
        Ok(())
    }

    /// Sends the end of a frame to a machine that does not ask for it again, and waits until its image has
    /// been shown.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn end_frame(&mut self) -> Result<(), BenchError> {
        let images = self.dut.images();
        self.dut.send(Offer::End)?;
        self.wait_for(images + 1, |_, _| Ok(()))
    }

    /// Reset in mid-flight: whatever frame is under way is lost, and the machine clears its memories
    /// before it is ready again. Counts begin anew.
    pub fn reset(&mut self) {
        self.dut.reset();
    }

    /// The images that have been shown, in order; they are taken out.
    pub fn take_images(&mut self) -> Vec<Image> {
        let Screen { width, height, .. } = self.screen;
        let images = self.dut.take_images().into_iter();
        images.map(|pixels| Image { width, height, pixels }).collect()
    }

    /// Ends the waveform, if one is recorded, and tells what it has, or why it could not be written.
    pub fn finish_wave(&mut self) -> WaveReport {
        let time = self.dut.time();
        self.observer::<Recorder>().map_or(WaveReport::default(), |wave| wave.finish(time))
    }

    /// What was counted so far.
    pub fn tally(&mut self) -> Tally {
        self.dut.tally()
    }

    /// What each [`Bench::frame`] since counting began took: the first one from the beginning and the last one until now. A machine
    /// may have the frame before still under way in its cycles.
    pub fn frames(&mut self) -> Vec<Played> {
        let now = self.dut.tally().cycles;
        let ends = self.sent.iter().skip(1).map(|frame| &frame.begins).chain([&now]);
        let mut begin = &Cycles::default();
        let frames = ends.zip(&self.sent).map(|(end, frame)| {
            let cycles = end.since(std::mem::replace(&mut begin, end));
            Played { cycles, plays: frame.plays }
        });
        frames.collect()
    }

    /// Counts from here on. Between two frames, when the image of the one before is complete, nothing is left
    /// of that one but what the memories hold.
    pub fn count_anew(&mut self) {
        self.dut.count_anew();
        self.sent.clear();
    }

    /// Edges since power-up.
    pub fn cycles(&self) -> u64 {
        self.dut.cycles()
    }

    /// The machine itself.
    pub fn dut(&mut self) -> &mut dyn Dut {
        &mut *self.dut
    }
}
