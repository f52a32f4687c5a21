//! The bench: a machine under the clock, fed with frames, watched, and its images caught.

use crate::image::Image;
use crate::output::{AtomicFile, OutputError};
use crate::recorder::{Recorder, WaveError, WaveJob, WaveReport};
use crate::source::SourceError;
use pellucid_hw::machine::{Item, Machine, Monitor, Phase, Tally};
use pellucid_hw::pixel::{Marked, Screen};
use pellucid_sim::block::Cycle;
use pellucid_sim::netlist::Module;
use pellucid_sim::{
    Deadlock, Declare, Fault, Memory, Registers, Signals, Sim, StorageInfo, Stream, Violation,
    Watchdog,
};
use pellucid_verilog::lockstep::Vectors;
use pellucid_waveforms::StreamOf;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Cycles without progress after which a simulation is given up.
pub const WATCHDOG_CYCLES: u64 = 100_000;
/// How often the watchdog looks.
const LOOK_EVERY: u64 = 1 << 14;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A block misused its hardware.
    #[error("fault in the model: {0}")]
    Fault(#[from] Fault),
    /// A stream broke its rules.
    #[error("fault in the model: {0}")]
    Violation(#[from] Violation),
    /// An assertion in a block did not hold, or its arithmetic overflowed.
    #[error("fault in the model: an assertion failed: {0}")]
    Assertion(String),
    /// Nothing moved.
    #[error("the simulation stands still, {0}")]
    Deadlock(Deadlock),
    /// The frame could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The waveform could not be begun.
    #[error(transparent)]
    Wave(#[from] WaveError),
}

impl BenchError {
    /// In a word or two what is wrong with the model; nothing if it is not the model.
    pub fn fault(&self) -> Option<String> {
        match self {
            BenchError::Fault(fault) => Some(format!("fault in {}", fault.path)),
            BenchError::Violation(violation) => Some(format!("{} breaks a rule", violation.stream)),
            BenchError::Assertion(_) => Some("assertion fails".to_string()),
            BenchError::Deadlock(_) => Some("stands still".to_string()),
            BenchError::Source(_) | BenchError::Output(_) | BenchError::Wave(_) => None,
        }
    }
}

/// The ports of every cycle, being written.
struct Recording {
    vectors: Vectors<AtomicFile>,
    path: PathBuf,
    inputs: Vec<u64>,
    outputs: Vec<u64>,
}

impl Recording {
    #[inline(never)]
    fn show<M: Machine>(&mut self, i: &M::In, cycle: &Cycle<M>) -> Result<(), OutputError> {
        let numbers = M::numbers();
        self.inputs.clear();
        self.outputs.clear();
        (numbers.input)(cycle.cfg, i, &mut self.inputs);
        (numbers.out)(cycle.cfg, &cycle.out, &mut self.outputs);
        let shown = self.vectors.cycle(&self.inputs, &self.outputs);
        shown.map_err(|e| OutputError::write(&self.path, &e))
    }
}

/// What a panic said.
fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("without a message").to_string()
}

/// The cycle comes by value: where nothing is recorded, it need not be in memory at all.
#[inline(never)]
fn show<M: Machine>(
    wave: &mut Recorder,
    time: u64,
    phase: Phase,
    cycle: Cycle<M>,
) -> Result<(), OutputError>
where
    M::State: Registers<Config = M::Config>,
    M::Out: Signals<Config = M::Config>,
{
    wave.cycle(time, phase, |to| {
        Registers::sample(cycle.q, cycle.cfg, to);
        Signals::sample(&cycle.out, cycle.cfg, to);
    })
}

/// See the module's description.
pub struct Bench<M: Machine>
where
    M::State: Registers<Config = M::Config>,
    M::Out: Signals<Config = M::Config>,
{
    sim: Sim<M>,
    monitor: M::Monitor,
    /// Words of each memory that were read and written before counting began.
    before: Vec<[u64; 2]>,
    watchdog: Watchdog,
    pixels: Vec<u32>,
    images: Vec<Image>,
    screen: Screen,
    /// The cycle in which the machine was first ready: 0 on every time axis that users see.
    ready_at: Option<u64>,
    phase: Phase,
    replay: bool,
    /// The frame's items that were taken so far.
    taken: u32,
    wave: Option<Recorder>,
    recording: Option<Recording>,
    display: Option<Box<dyn FnMut(u64) -> bool>>,
}

impl<M: Machine> Bench<M>
where
    M::State: Registers<Config = M::Config>,
    M::Out: Signals<Config = M::Config>,
{
    /// A machine at power-up.
    pub fn new(cfg: M::Config) -> Bench<M> {
        let (screen, monitor) = (M::screen(&cfg), M::Monitor::new(&cfg));
        Bench {
            sim: Sim::new(cfg),
            monitor,
            before: vec![],
            watchdog: Watchdog::new(WATCHDOG_CYCLES),
            pixels: Vec::with_capacity(screen.pixels() as usize),
            images: vec![],
            screen,
            ready_at: None,
            phase: Phase::Clear,
            replay: false,
            taken: 0,
            wave: None,
            recording: None,
            display: None,
        }
    }

    /// Makes the display take a pixel only in cycles for which `ready` says so.
    pub fn set_display(&mut self, ready: impl FnMut(u64) -> bool + 'static) {
        self.display = Some(Box::new(ready));
    }

    /// Writes a waveform from now on, and at its end beside it what viewers need to show it. `scope` names
    /// the machine in it.
    ///
    /// # Errors
    /// The file cannot be written, or something is asked for that the machine does not have.
    pub fn record(&mut self, job: &WaveJob, scope: &str) -> Result<(), WaveError> {
        let streams = self.tally().streams.into_iter();
        let streams = streams.map(|s| StreamOf { name: s.name.into(), to: s.to.into() }).collect();
        let (cfg, memories) = self.sim.parts();
        let declare = |to: &mut dyn Declare| {
            <M::State as Registers>::declare(cfg, "registers", to);
            <M::Out as Signals>::declare(cfg, "wires", to);
        };
        self.wave = Some(Recorder::new(job, scope, streams, declare, memories)?);
        Ok(())
    }

    /// Writes the inputs and outputs of every cycle from now on to the file `path`, for the machine's
    /// netlist.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn record_ports(&mut self, path: &Path, netlist: &Module) -> Result<(), OutputError> {
        let vectors = Vectors::new(netlist, AtomicFile::create(path)?);
        let (inputs, outputs) = (vec![], vec![]);
        self.recording = Some(Recording { vectors, path: path.to_owned(), inputs, outputs });
        Ok(())
    }

    /// Ends what [`Bench::record_ports`] began.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish_ports(&mut self) -> Result<(), OutputError> {
        match self.recording.take() {
            None => Ok(()),
            Some(Recording { vectors, path, .. }) => match vectors.finish() {
                Ok(file) => file.finish(),
                Err(error) => Err(OutputError::write(&path, &error)),
            },
        }
    }

    /// One cycle in which `item` is offered; whether it was taken.
    ///
    /// # Errors
    /// See [`BenchError`].
    #[inline(always)]
    pub fn step(&mut self, mut item: Stream<Marked<M::Item>>) -> Result<bool, BenchError> {
        let at = self.sim.cycle();
        if !item.payload.end {
            item.payload.item.label(self.taken);
        }
        let image_ready = match &mut self.display {
            None => true,
            Some(ready) => ready(at),
        };
        let frame = M::Item::frame(item, image_ready);
        if let Some(wave) = &mut self.wave
            && wave.peeks()
        {
            wave.peek(self.sim.memories());
        }
        let cycle = self.sim.clock(frame)?;
        // A cycle with a fault is shown before it is told of.
        let observed = self.monitor.observe(cycle.cfg, cycle.q, &cycle.out);
        let fits =
            if cfg!(debug_assertions) { Signals::check(&cycle.out, cycle.cfg) } else { Ok(()) };
        let ports = M::ports(&cycle.out);
        self.replay = ports.replay;
        if ports.phase != self.phase {
            self.phase = ports.phase;
            self.ready_at.get_or_insert(at);
        }
        if let Some(recording) = &mut self.recording {
            recording.show(&frame, &cycle)?;
        }
        if let Some(wave) = &mut self.wave
            && let Some(zero) = self.ready_at
        {
            // A frame's first item comes in while the machine still is idle.
            let first = ports.phase == Phase::Idle && item.valid && ports.item_ready;
            let phase = if first { Phase::Store } else { ports.phase };
            if !wave.is_quiet(at - zero, phase) {
                show(wave, at - zero, phase, cycle)?;
            }
        }
        observed?;
        fits.map_err(|overflow| Fault::overflow(at, overflow))?;
        if item.valid && ports.item_ready {
            self.taken = if item.payload.end { 0 } else { self.taken.saturating_add(1) };
        }
        if ports.image.fires() {
            self.pixel(ports.image.payload);
        }
        if at.is_multiple_of(LOOK_EVERY) {
            self.look()?;
        }
        Ok(ports.item_ready)
    }

    /// Plays what `play` plays and ends the waveform that is recorded, if any, whatever comes of it: one is
    /// wanted most of all when the model goes wrong. A panic is an assertion that failed. A frame that cannot
    /// be read leaves none, and a waveform that cannot be written is left as far as it goes.
    ///
    /// # Errors
    /// Those of `play`, or the waveform cannot be written.
    pub fn traced<T>(
        &mut self,
        play: impl FnOnce(&mut Self) -> Result<T, BenchError>,
    ) -> Result<(T, WaveReport), BenchError> {
        // What is left of the simulation is only looked at.
        let played = catch_unwind(AssertUnwindSafe(|| play(self)));
        let played = played.unwrap_or_else(|panic| Err(BenchError::Assertion(message(&*panic))));
        match &played {
            Err(BenchError::Source(_)) => self.discard_wave(),
            Err(BenchError::Output(_) | BenchError::Wave(_)) => {}
            Err(error) => {
                self.show_failure(error)?;
                self.finish_wave()?;
            }
            Ok(_) => return Ok((played?, self.finish_wave()?)),
        }
        Ok((played?, WaveReport::default()))
    }

    /// Shows the cycles before that in which the model was found at fault, where the waveform waits for that.
    fn show_failure(&mut self, error: &BenchError) -> Result<(), OutputError> {
        let Some(what) = error.fault() else { return Ok(()) };
        let zero = self.ready_at.unwrap_or(0);
        // Unless the cycle came to its end, it has not been counted.
        let mut time = self.sim.cycle().saturating_sub(zero);
        let Some(wave) = &mut self.wave else { return Ok(()) };
        match self.sim.at_fault() {
            Some(cycle) => show(wave, time, self.phase, cycle)?,
            None => time = time.saturating_sub(1),
        }
        wave.failure(time, &what)
    }

    /// Sends one item, for as many cycles as that takes. A cycle is a whole machine: one copy of its code serves all
    /// who send.
    ///
    /// # Errors
    /// See [`BenchError`].
    #[inline(never)]
    pub fn send(&mut self, item: Marked<M::Item>) -> Result<(), BenchError> {
        while !self.step(Stream::offer(item))? {}
        Ok(())
    }

    /// One cycle in which nothing is offered; whether something would have been taken.
    ///
    /// # Errors
    /// See [`BenchError`].
    #[inline(never)]
    pub fn pause(&mut self) -> Result<bool, BenchError> {
        self.step(Stream::idle())
    }

    /// Sends a frame as often as the machine asks for it: `play` sends its items, the same each time.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn frame(
        &mut self,
        mut play: impl FnMut(&mut Self) -> Result<(), BenchError>,
    ) -> Result<(), BenchError> {
        loop {
            play(self)?;
            self.send(Marked::end())?;
            if !M::replays(self.sim.config()) {
                return Ok(());
            }
            // It opens for the same frame again, or for the next one.
            while !self.pause()? {}
            if !self.replay {
                return Ok(());
            }
        }
    }

    /// Waits until `images` images have been shown and not been taken, and calls `each` after every cycle.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn wait_for(&mut self, images: usize, mut each: impl FnMut()) -> Result<(), BenchError> {
        while self.images.len() < images {
            self.step(Stream::idle())?;
            each();
        }
        Ok(())
    }

    /// Sends the end of a frame to a machine that does not ask for it again, and waits until its image has
    /// been shown.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn end_frame(&mut self) -> Result<(), BenchError> {
        let images = self.images.len();
        self.send(Marked::end())?;
        self.wait_for(images + 1, || {})
    }

    /// Reset in mid-flight: whatever frame is under way is lost, and the machine clears its memories
    /// before it is ready again. Counts begin anew.
    ///
    /// # Errors
    /// The recording of the ports cannot be written.
    pub fn reset(&mut self) -> Result<(), OutputError> {
        self.sim.reset();
        self.count_anew();
        self.pixels.clear();
        self.taken = 0;
        self.phase = Phase::Clear;
        match &mut self.recording {
            None => Ok(()),
            Some(Recording { vectors, path, .. }) => {
                vectors.reset().map_err(|e| OutputError::write(path, &e))
            }
        }
    }

    /// The images that have been shown, in order; they are taken out.
    pub fn take_images(&mut self) -> Vec<Image> {
        std::mem::take(&mut self.images)
    }

    /// Ends the waveform, if one is recorded, and tells what it has.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish_wave(&mut self) -> Result<WaveReport, OutputError> {
        let Some(wave) = self.wave.take() else { return Ok(WaveReport::default()) };
        let time = self.sim.cycle() - self.ready_at.unwrap_or(self.sim.cycle());
        wave.finish(time)
    }

    fn discard_wave(&mut self) {
        if let Some(wave) = self.wave.take() {
            wave.discard();
        }
    }

    /// What was counted so far.
    pub fn tally(&mut self) -> Tally {
        let mut memories = self.memories();
        for ((_, info), [reads, writes]) in memories.iter_mut().zip(&self.before) {
            info.reads -= reads;
            info.writes -= writes;
        }
        self.monitor.tally(self.sim.config(), &memories)
    }

    /// Counts from here on. Between two frames, when the image of the one before is complete, nothing is left
    /// of that one but what the memories hold.
    pub fn count_anew(&mut self) {
        self.before = self.memories().iter().map(|(_, info)| [info.reads, info.writes]).collect();
        self.monitor = M::Monitor::new(self.sim.config());
    }

    fn memories(&mut self) -> Vec<(String, StorageInfo)> {
        let mut memories = vec![];
        self.sim.memories().visit("", &mut |path, storage| {
            memories.push((path.to_string(), storage.info()));
        });
        memories
    }

    /// Edges since power-up.
    pub fn cycles(&self) -> u64 {
        self.sim.cycle()
    }

    fn pixel(&mut self, colour: u32) {
        self.pixels.push(colour);
        if self.pixels.len() == self.screen.pixels() as usize {
            let Screen { width, height, .. } = self.screen;
            let pixels = std::mem::take(&mut self.pixels);
            self.images.push(Image { width, height, pixels });
        }
    }

    #[cold]
    fn look(&mut self) -> Result<(), BenchError> {
        let mut progress = self.monitor.transfers();
        self.sim.memories().visit("", &mut |_, storage| {
            let info = storage.info();
            progress += info.reads + info.writes;
        });
        let cycle = self.sim.cycle();
        match self.watchdog.look(cycle, progress) {
            None => Ok(()),
            Some(idle) => {
                Err(BenchError::Deadlock(self.monitor.deadlock(cycle, idle, self.sim.state())))
            }
        }
    }
}
