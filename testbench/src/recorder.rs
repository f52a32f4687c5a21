//! A waveform being written, with what viewers need beside it.

use crate::output::partial::{self, PartialName};
use crate::output::{OutputError, create_dir, put};
use crate::watch::Watch;
use crate::window::Window;
use pellucid_hw::machine::Phase;
use pellucid_hw::params::{did_you_mean, nearest};
use pellucid_sim::{Declare, Memory, Sink};
use pellucid_waveforms::{FileFormat, Layout, Marker, NoSignal, Sampler, StreamOf, View, Wave};
use std::io;
use std::path::{Path, PathBuf};
use wildmatch::WildMatch;

/// Words of a memory that are shown where it is not said which.
pub const DEFAULT_WORDS: u32 = 256;
/// The most words that are shown of all memories together.
pub const MOST_WORDS: u64 = 4096;

/// What is to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveJob {
    /// Where; the set-ups for viewers go beside it.
    pub path: PathBuf,
    /// How.
    pub format: FileFormat,
    /// Which cycles.
    pub windows: Vec<Window>,
    /// Which signals, by patterns of their paths; all if there is none.
    pub scopes: Vec<String>,
    /// Which words of which memories.
    pub memories: Vec<Words>,
}

impl WaveJob {
    /// A VCD file of all signals.
    pub fn new(path: &Path, windows: &[Window]) -> WaveJob {
        WaveJob {
            path: path.to_owned(),
            format: FileFormat::Vcd,
            windows: windows.to_vec(),
            scopes: vec![],
            memories: vec![],
        }
    }
}

/// Words of a memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Words {
    /// The memory's path, or a pattern of several.
    pub memory: String,
    /// The first word and the one after the last.
    pub range: Option<(u32, u32)>,
}

/// A waveform that cannot be begun.
#[derive(Debug, thiserror::Error)]
pub enum WaveError {
    /// It cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A pattern fits no signal.
    #[error("--wave-scope: {0}")]
    Scope(#[from] NoSignal),
    /// There is no such memory.
    #[error(
        "--wave-memory: there is no memory `{name}`{}; there are {known}",
        did_you_mean(nearest)
    )]
    Memory {
        /// What was asked for.
        name: String,
        /// The known name most like it.
        nearest: Option<String>,
        /// All names.
        known: String,
    },
    /// A memory has not so many words.
    #[error("--wave-memory: `{name}` has {words} words, numbered from 0")]
    Range {
        /// The memory.
        name: String,
        /// How many it has.
        words: u64,
    },
    /// Too many words.
    #[error(
        "--wave-memory: {words} words are asked for; {MOST_WORDS} can be shown: give ranges, as in \
         `{example}:0..64`"
    )]
    Words {
        /// How many.
        words: u64,
        /// One of the memories.
        example: String,
    },
    /// There is no such event.
    #[error("--wave: there is no event `{name}`{}; there are {known}", did_you_mean(nearest))]
    Event {
        /// What was asked for.
        name: String,
        /// The known name most like it.
        nearest: Option<String>,
        /// All names.
        known: String,
    },
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WaveReport {
    /// The points that have names.
    pub markers: Vec<Marker>,
    /// What was waited for and did not come, a sentence each.
    pub notes: Vec<String>,
}

/// Words of a memory that are shown.
struct Shown {
    memory: String,
    words: std::ops::Range<u32>,
    /// Writes to the memory that the values know of.
    writes: u64,
    values: Vec<u64>,
}

/// See the module's description.
pub(crate) struct Recorder {
    wave: Wave,
    name: PartialName,
    job: WaveJob,
    watches: Vec<Watch>,
    /// Cycles are remembered before it is known whether they are shown.
    remembers: bool,
    /// As long as the phase is this one, nothing is shown before this cycle.
    quiet: (Phase, u64),
    markers: Vec<Marker>,
    memories: Vec<Shown>,
}

fn listed(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn most_like(name: &str, known: &[String]) -> Option<String> {
    nearest(name, known.iter().map(String::as_str)).map(str::to_string)
}

/// The words that are asked for.
fn shown(asked: &[Words], memories: &mut impl Memory) -> Result<Vec<Shown>, WaveError> {
    let mut all = vec![];
    memories.visit("", &mut |path, storage| all.push((path.to_string(), storage.info().words)));
    all.retain(|(_, words)| *words > 0);
    let known: Vec<String> = all.iter().map(|(path, _)| path.clone()).collect();
    let mut shown = vec![];
    for Words { memory: pattern, range } in asked {
        let fits = WildMatch::new(pattern);
        let before = shown.len();
        for (path, words) in all.iter().filter(|(path, _)| fits.matches(path)) {
            let all_words = u32::try_from(*words).unwrap_or(u32::MAX);
            let (from, to) = range.unwrap_or((0, all_words.min(DEFAULT_WORDS)));
            if to > all_words {
                return Err(WaveError::Range { name: path.clone(), words: *words });
            }
            let memory = path.clone();
            shown.push(Shown { memory, words: from..to, writes: u64::MAX, values: vec![] });
        }
        if shown.len() == before {
            let nearest = most_like(pattern, &known);
            return Err(WaveError::Memory {
                name: pattern.clone(),
                nearest,
                known: listed(&known),
            });
        }
    }
    let words = shown.iter().map(|s| s.words.len() as u64).sum();
    match shown.first() {
        Some(first) if words > MOST_WORDS => {
            Err(WaveError::Words { words, example: first.memory.clone() })
        }
        _ => Ok(shown),
    }
}

/// Declares the words, each memory's in the scopes of its path.
fn declare_words(shown: &[Shown], memories: &mut impl Memory, to: &mut dyn Declare) {
    if shown.is_empty() {
        return;
    }
    to.open("memories");
    for Shown { memory, words, .. } in shown {
        let scopes: Vec<&str> = memory.split('.').collect();
        scopes.iter().for_each(|scope| to.open(scope));
        memories.visit("", &mut |path, storage| {
            if path == memory {
                for k in words.clone() {
                    storage.word(&format!("word[{k}]"), to);
                }
            }
        });
        scopes.iter().for_each(|_| to.close());
    }
    to.close();
}

/// Declares what it is told but labels: words hold those of what was there before.
struct Unlabelled<'a>(&'a mut dyn Declare);

impl Declare for Unlabelled<'_> {
    fn open(&mut self, name: &str) {
        self.0.open(name);
    }
    fn close(&mut self) {
        self.0.close();
    }
    fn signal(&mut self, name: &str, width: u32, kind: pellucid_sim::Kind) {
        self.0.signal(name, width, kind);
    }
}

impl Recorder {
    /// Begins a waveform. `declare` declares the machine's registers and wires in the scope of the machine.
    pub(crate) fn new(
        job: &WaveJob,
        scope: &str,
        streams: Vec<StreamOf>,
        declare: impl FnOnce(&mut dyn Declare),
        memories: &mut impl Memory,
    ) -> Result<Recorder, WaveError> {
        let shown = shown(&job.memories, memories)?;
        let mut layout = Layout::new(streams, |to| {
            to.open(scope);
            declare(to);
            declare_words(&shown, memories, &mut Unlabelled(to));
            to.close();
        });
        if !job.scopes.is_empty() {
            layout.select(&job.scopes)?;
        }
        for window in &job.windows {
            let known: Vec<String> = layout.events().map(|(name, _)| name.to_string()).collect();
            if let Window::Event { name } = window
                && !known.contains(name)
            {
                let nearest = most_like(name, &known);
                return Err(WaveError::Event {
                    name: name.clone(),
                    nearest,
                    known: listed(&known),
                });
            }
        }
        let history = job.windows.iter().map(Watch::history).max().unwrap_or(0);
        let (file, name) = partial::create(&job.path)?;
        let wave = Wave::new(job.format, file, layout, history);
        let wave = wave.map_err(|error| name.error(&error))?;
        let watches = job.windows.iter().filter_map(|window| Watch::new(window, &wave)).collect();
        Ok(Recorder {
            wave,
            name,
            job: job.clone(),
            watches,
            remembers: history > 0,
            quiet: (Phase::Clear, 0),
            markers: vec![],
            memories: shown,
        })
    }

    /// Whether a cycle need not even be looked at. Most of a long run is like that.
    #[inline(always)]
    pub(crate) fn is_quiet(&self, time: u64, phase: Phase) -> bool {
        time < self.quiet.1 && phase == self.quiet.0
    }

    /// Whether words of memories are shown: then [`Recorder::peek`] is to be called before each cycle.
    pub(crate) fn peeks(&self) -> bool {
        !self.memories.is_empty()
    }

    /// Looks at the words of the memories.
    pub(crate) fn peek(&mut self, memories: &mut impl Memory) {
        memories.visit("", &mut |path, storage| {
            for shown in self.memories.iter_mut().filter(|shown| shown.memory == path) {
                let writes = storage.info().writes;
                if shown.writes != writes {
                    shown.writes = writes;
                    shown.values.clear();
                    shown.words.clone().for_each(|k| storage.peek(k, &mut shown.values));
                }
            }
        });
    }

    /// One cycle, in which the machine is at `phase`.
    ///
    /// # Errors
    /// The file cannot be written.
    #[inline]
    pub(crate) fn cycle(
        &mut self,
        time: u64,
        phase: Phase,
        sample: impl FnOnce(&mut Sampler),
    ) -> Result<(), OutputError> {
        self.show(time, phase, sample).map_err(|error| self.name.error(&error))
    }

    #[inline]
    fn show(
        &mut self,
        time: u64,
        phase: Phase,
        sample: impl FnOnce(&mut Sampler),
    ) -> io::Result<()> {
        let Recorder { wave, watches, markers, memories, remembers, .. } = self;
        // The earliest of what they ask for: all are asked.
        let mut look = |wave: &Wave| {
            watches.iter_mut().filter_map(|watch| watch.look(time, phase, wave, markers)).min()
        };
        let shown = !*remembers && look(wave).is_some();
        if !*remembers && !shown {
            let quiet = self.watches.iter().map(|watch| watch.quiet_until(time)).min();
            self.quiet = (phase, quiet.unwrap_or(u64::MAX));
            return wave.gap(time);
        }
        wave.sample(|to| {
            sample(to);
            memories.iter().flat_map(|shown| &shown.values).for_each(|value| to.push(*value));
        });
        if shown {
            return wave.show(time);
        }
        wave.remember(time)?;
        look(wave).map_or(Ok(()), |from| wave.recall(from, time))
    }

    /// The model is found at fault in cycle `time`, `what` in a word or two. If that is waited for, the cycles
    /// before are shown; where nothing moves, those before it stood still.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn failure(&mut self, time: u64, what: &str) -> Result<(), OutputError> {
        if !self.job.windows.contains(&Window::Failure) {
            return Ok(());
        }
        let last = self.wave.last_change().unwrap_or(time);
        self.markers.insert(0, Marker { cycle: last, name: what.to_string() });
        self.wave.recall(0, time).map_err(|error| self.name.error(&error))
    }

    /// Ends the file with the cycle after the last, and writes how viewers show it.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn finish(self, time: u64) -> Result<WaveReport, OutputError> {
        let Recorder { wave, name, job, watches, mut markers, .. } = self;
        let notes = watches.iter().filter_map(|watch| watch.note(time)).collect();
        markers.dedup();
        let view = View {
            stem: job.path.file_stem().unwrap_or_default().to_string_lossy().into(),
            format: job.format,
            markers,
            first: wave.first().unwrap_or(0),
        };
        let layout = wave.layout().clone();
        wave.finish(time).map_err(|error| name.error(&error))?;
        name.finish()?;
        let folder = job.path.parent().unwrap_or(Path::new(""));
        view.write(&layout, folder, create_dir, put)?;
        Ok(WaveReport { markers: view.markers, notes })
    }

    /// Removes the file: there is nothing to be seen.
    pub(crate) fn discard(self) {
        let Recorder { wave, name, .. } = self;
        drop(wave);
        name.discard();
    }
}
