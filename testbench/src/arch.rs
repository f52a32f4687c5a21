//! The architectures that a user can name.

use crate::bench::{Bench, BenchError};
use crate::image::Image;
use crate::progress::Progress;
use crate::recorder::{WaveJob, WaveReport};
use crate::source::{Played, Source, SourceError};
use crate::stimulus::Stimulus;
use crate::view::View;
use pellucid_hw::allocator::Chosen;
use pellucid_hw::composer::Composer;
use pellucid_hw::composer::config::{self as composer, Behind};
use pellucid_hw::composer::scan_lines::ScanLines;
use pellucid_hw::composer::store::{FragmentStore, Store};
use pellucid_hw::machine::{Arithmetic, Census, Check, Machine, Tally};
use pellucid_hw::mbuffer::MBuffer;
use pellucid_hw::mbuffer::config as mbuffer;
use pellucid_hw::params::{Param, ParamError, Parameters, Preset, Value, did_you_mean, nearest};
use pellucid_hw::pixel::{Marked, Screen};
use pellucid_hw::rbuffer::RBuffer;
use pellucid_hw::rbuffer::config as rbuffer;
use pellucid_hw::tbuffer::TBuffer;
use pellucid_hw::tbuffer::config as tbuffer;
use pellucid_sim::netlist::{Module, elaborate_alone};
use pellucid_sim::{Registers, Signals};
use std::path::Path;

/// An architecture.
pub struct Architecture {
    /// Its name.
    pub name: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// Its presets with a sentence each; the first is the default.
    pub presets: fn() -> Vec<(&'static str, &'static str)>,
    /// Its parameters.
    pub parameters: fn() -> Vec<Param>,
    /// Builds a machine from a preset and settings, later ones before earlier ones.
    build: fn(Screen, &str, &[Setting]) -> Built,
}

/// All architectures; the first is the default.
pub const ARCHITECTURES: &[Architecture] = &[
    Architecture {
        name: "tbuffer",
        about: "T-buffer: fragments grouped by pixel in sections that any pixel can have",
        presets: || about(tbuffer::PRESETS),
        parameters: tbuffer::Params::list,
        build: build_tbuffer,
    },
    Architecture {
        name: "rbuffer",
        about: "R-buffer: fragments in a queue, sent round until all are blended",
        presets: || about(rbuffer::PRESETS),
        parameters: rbuffer::Params::list,
        build: build_rbuffer,
    },
    Architecture {
        name: "mbuffer",
        about: "M-buffer: a section for each pixel, fragments summed by weight without sorting",
        presets: || about(mbuffer::PRESETS),
        parameters: mbuffer::Params::list,
        build: build_mbuffer,
    },
    Architecture {
        name: "composer",
        about: "Image composition: engines draw opaque primitives, their images are merged, scan-line engines or a fragment store add the rest",
        presets: || about(composer::PRESETS),
        parameters: composer::Params::list,
        build: build_composer,
    },
];

fn about<P>(presets: &[Preset<P>]) -> Vec<(&'static str, &'static str)> {
    presets.iter().map(|p| (p.name, p.about)).collect()
}

/// A machine, or why it cannot be built.
pub type Built = Result<Box<dyn Runnable>, SettingError>;

/// A parameter's value as a user gave it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The parameter's name.
    pub name: String,
    /// Its value.
    pub value: String,
    /// Where it was given, as a user knows the place.
    pub origin: String,
}

/// An architecture that cannot be built as asked.
#[derive(Debug, thiserror::Error)]
pub enum SettingError {
    /// No such architecture.
    #[error("unknown architecture `{name}`{}; known are {known}", did_you_mean(nearest))]
    Architecture {
        /// What was asked for.
        name: String,
        /// The known name most like it.
        nearest: Option<&'static str>,
        /// All known names.
        known: String,
    },
    /// No such preset.
    #[error("unknown preset `{name}` of `{arch}`{}; known are {known}", did_you_mean(nearest))]
    Preset {
        /// What was asked for.
        name: String,
        /// The architecture.
        arch: &'static str,
        /// The known name most like it.
        nearest: Option<&'static str>,
        /// All known names.
        known: String,
    },
    /// A setting that was not understood.
    #[error("{origin}: {error}")]
    Setting {
        /// Where it was given.
        origin: String,
        /// What is wrong.
        error: ParamError,
    },
    /// Settings that do not go together.
    #[error(transparent)]
    Together(#[from] ParamError),
}

fn quoted(names: &[&'static str]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

impl Architecture {
    /// The architecture of that name.
    ///
    /// # Errors
    /// There is none; the nearest name is suggested.
    pub fn named(name: &str) -> Result<&'static Architecture, SettingError> {
        let names: Vec<&str> = ARCHITECTURES.iter().map(|a| a.name).collect();
        ARCHITECTURES.iter().find(|a| a.name == name).ok_or_else(|| SettingError::Architecture {
            name: name.to_string(),
            nearest: nearest(name, names.iter().copied()),
            known: quoted(&names),
        })
    }

    /// A machine of this architecture.
    ///
    /// # Errors
    /// An unknown preset or parameter, or a value out of range.
    pub fn build(&self, screen: Screen, preset: Option<&str>, settings: &[Setting]) -> Built {
        let names: Vec<&str> = (self.presets)().iter().map(|p| p.0).collect();
        let name = preset.unwrap_or(names[0]);
        if !names.contains(&name) {
            return Err(SettingError::Preset {
                name: name.to_string(),
                arch: self.name,
                nearest: nearest(name, names.iter().copied()),
                known: quoted(&names),
            });
        }
        (self.build)(screen, name, settings)
    }
}

/// The parameters of the preset of that name, with the settings over them.
fn chosen<P: Parameters + Default>(
    presets: &[Preset<P>],
    name: &str,
    settings: &[Setting],
) -> Result<P, SettingError> {
    let preset = presets.iter().find(|p| p.name == name);
    let mut params = preset.map_or_else(P::default, |p| (p.params)());
    for Setting { name, value, origin } in settings {
        let set = params.set(name, value);
        set.map_err(|error| SettingError::Setting { origin: origin.clone(), error })?;
    }
    Ok(params)
}

fn build_rbuffer(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(rbuffer::PRESETS, preset, settings)?;
    let cfg = rbuffer::Config::new(screen, params)?;
    Ok(Box::new(Prepared::<RBuffer> { cfg, values: params.values() }))
}

fn build_tbuffer(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(tbuffer::PRESETS, preset, settings)?;
    let cfg = tbuffer::Config::new(screen, params)?;
    Ok(Box::new(Prepared::<TBuffer<Chosen>> { cfg, values: params.values() }))
}

fn build_mbuffer(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(mbuffer::PRESETS, preset, settings)?;
    let cfg = mbuffer::Config::new(screen, params)?;
    Ok(Box::new(Prepared::<MBuffer<Chosen>> { cfg, values: params.values() }))
}

fn build_composer(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(composer::PRESETS, preset, settings)?;
    match params.transparency {
        Behind::ScanLine => {
            let cfg = composer::scan_lines(screen, &params)?;
            Ok(Box::new(Prepared::<Composer<ScanLines>> { cfg, values: params.values() }))
        }
        Behind::TBuffer => {
            let store = tbuffer::Config::new(screen, params.tbuffer);
            with_store::<TBuffer<Chosen>, tbuffer::Params>(screen, &params, store, "tbuffer")
        }
        Behind::RBuffer => {
            let store = rbuffer::Config::new(screen, params.rbuffer);
            with_store::<RBuffer, rbuffer::Params>(screen, &params, store, "rbuffer")
        }
        Behind::MBuffer => {
            let store = mbuffer::Config::new(screen, params.mbuffer);
            with_store::<MBuffer<Chosen>, mbuffer::Params>(screen, &params, store, "mbuffer")
        }
    }
}

/// The image composition machine with a fragment store, whose parameters `P` are those of `part`.
fn with_store<M, P>(
    screen: Screen,
    params: &composer::Params,
    store: Result<M::Config, ParamError>,
    part: &str,
) -> Built
where
    M: FragmentStore,
    M::Config: Send + Sync,
    P: Parameters,
{
    let store = store.map_err(|error| error.of_part::<P>(part))?;
    let cfg = composer::store(screen, params, store)?;
    Ok(Box::new(Prepared::<Composer<Store<M>>> { cfg, values: params.values() }))
}

/// What is asked of a run.
pub struct Job<'a> {
    /// The first frame.
    pub source: &'a Source,
    /// How many there are, played in a row: the next one may come while the one before is still being shown. Each is
    /// as [`Source::later`] has it, so that there is more than one only where that gives any.
    pub frames: u32,
    /// How often they are played before the time that counts, so that memories and free sections are as a running
    /// machine has them.
    pub warm_up: u32,
    /// The waveform.
    pub wave: Option<&'a WaveJob>,
    /// Told of every item.
    pub progress: &'a mut Progress,
}

/// What a run gives.
pub struct Outcome {
    /// The images, one for each frame.
    pub images: Vec<Image>,
    /// What was counted.
    pub tally: Tally,
    /// What the waveform has.
    pub wave: WaveReport,
}

/// A machine that is ready to run.
pub trait Runnable: Send + Sync {
    /// Its parameters' final values.
    fn values(&self) -> Vec<(String, Value)>;
    /// How it makes colours.
    fn arithmetic(&self) -> Arithmetic;
    /// What it sees of a frame.
    ///
    /// # Errors
    /// The frame cannot be read.
    fn view(&self, source: &Source) -> Result<View, SourceError>;
    /// Runs the frames.
    ///
    /// # Errors
    /// See [`BenchError`].
    fn run(&self, job: Job) -> Result<Outcome, BenchError>;
    /// The machine as a netlist.
    fn netlist(&self) -> Module;
    /// Plays a frame as `stimulus` says and writes the ports of every cycle to the file `path`; how many
    /// cycles that took.
    ///
    /// # Errors
    /// See [`BenchError`].
    fn record(
        &self,
        netlist: &Module,
        source: &Source,
        stimulus: Stimulus,
        path: &Path,
    ) -> Result<u64, BenchError>;
    /// What a run must have counted: see [`Machine::closed_forms`].
    fn closed_forms(&self, tally: &Tally, frames: &[Census]) -> Vec<Check>;
}

struct Prepared<M: Machine> {
    cfg: M::Config,
    values: Vec<(String, Value)>,
}

impl<M> Runnable for Prepared<M>
where
    M: Machine<Item: Played>,
    M::Config: Copy + Send + Sync,
    M::State: Registers<Config = M::Config>,
    M::Out: Signals<Config = M::Config>,
{
    fn values(&self) -> Vec<(String, Value)> {
        self.values.clone()
    }

    fn arithmetic(&self) -> Arithmetic {
        M::ARITHMETIC
    }

    fn view(&self, source: &Source) -> Result<View, SourceError> {
        View::new(M::dealer(&self.cfg), source)
    }

    fn run(&self, job: Job) -> Result<Outcome, BenchError> {
        let Job { source, frames, warm_up, wave, progress } = job;
        let mut bench = Bench::<M>::new(self.cfg);
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
                for number in 0..frames {
                    let later = if number > 0 { source.later(number) } else { None };
                    let source = later.as_ref().unwrap_or(source);
                    bench.frame(|bench| {
                        M::Item::play(source, &mut |item| {
                            progress.step();
                            bench.send(Marked::item(item))
                        })
                    })?;
                }
                progress.turn_to("resolving");
                bench.wait_for(frames as usize, || progress.step())?;
            }
            Ok(())
        })?;
        let images = bench.take_images();
        Ok(Outcome { images, tally: bench.tally(), wave })
    }

    fn netlist(&self) -> Module {
        elaborate_alone::<M>(&self.cfg)
    }

    fn record(
        &self,
        netlist: &Module,
        source: &Source,
        stimulus: Stimulus,
        path: &Path,
    ) -> Result<u64, BenchError> {
        let mut bench = Bench::<M>::new(self.cfg);
        bench.record_ports(path, netlist)?;
        stimulus.play(&mut bench, source)?;
        bench.finish_ports()?;
        Ok(bench.cycles())
    }

    fn closed_forms(&self, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        M::closed_forms(&self.cfg, tally, frames)
    }
}
