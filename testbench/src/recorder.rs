//! A waveform being written, with what viewers need beside it.

use crate::output::partial::{self, PartialName};
use crate::output::{OutputError, create_dir, put};
use crate::watch::Watch;
use crate::window::Window;
use pellucid_machine::dut::{At, Observed, Observer, Quiet};
use pellucid_machine::params::{did_you_mean, nearest};
use pellucid_machine::{Dut, PhaseInfo};
use pellucid_sim::{Declare, Memory, Sink};
use pellucid_waveforms::{FileFormat, Found, Layout, Marker, NoSignal, StreamOf, View, Wave};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::{fs, io};
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
    /// There is no such phase.
    #[error("--wave: there is no phase `{name}`{}; there are {known}", did_you_mean(nearest))]
    Phase {
        /// What was asked for.
        name: String,
        /// The known name most like it.
        nearest: Option<String>,
        /// All names.
        known: String,
    },
    /// There is no such event.
    #[error("--wave: there is no event `{name}`{}; {known}", did_you_mean(nearest))]
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
    /// Why the file or its set-ups could not be written, if so. The run went on without.
    pub lost: Option<OutputError>,
}

/// Words of a memory that are shown.
struct ShownMemory {
    memory: String,
    /// Which one it is, in the order in which memories are visited.
    number: usize,
    words: std::ops::Range<u32>,
    /// Writes to the memory that the values know of.
    writes: u64,
    values: Vec<u64>,
}

/// See the module's description.
pub(crate) struct Recorder {
    /// The file and its name; nothing once it could not be written.
    file: Option<(Wave, PartialName)>,
    /// Why it could not.
    lost: Option<OutputError>,
    job: WaveJob,
    layout: Arc<Layout>,
    /// How viewers show what there is so far, for whoever ends the process.
    view: Arc<Mutex<View>>,
    watches: Vec<Watch>,
    /// Cycles are remembered before it is known whether they are shown.
    remembers: bool,
    markers: Vec<Marker>,
    found: Found,
    memories: Vec<ShownMemory>,
}

fn listed(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn most_like(name: &str, known: &[String]) -> Option<String> {
    nearest(name, known.iter().map(String::as_str)).map(str::to_string)
}

/// The words that are asked for.
fn shown(asked: &[Words], memories: &mut dyn Memory) -> Result<Vec<ShownMemory>, WaveError> {
    let mut all = vec![];
    memories.visit("", &mut |path, storage| {
        all.push((all.len(), path.to_string(), storage.info().words));
    });
    all.retain(|(_, _, words)| *words > 0);
    let known: Vec<String> = all.iter().map(|(_, path, _)| path.clone()).collect();
    let mut shown = vec![];
    for Words { memory: pattern, range } in asked {
        let fits = WildMatch::new(pattern);
        let before = shown.len();
        for (number, path, words) in all.iter().filter(|(_, path, _)| fits.matches(path)) {
            let all_words = u32::try_from(*words).unwrap_or(u32::MAX);
            let (from, to) = range.unwrap_or((0, all_words.min(DEFAULT_WORDS)));
            if to > all_words {
                return Err(WaveError::Range { name: path.clone(), words: *words });
            }
            let memory = path.clone();
            let number = *number;
            shown.push(ShownMemory {
                memory,
                number,
                words: from..to,
                writes: u64::MAX,
                values: vec![],
            });
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
fn declare_words(shown: &[ShownMemory], memories: &mut dyn Memory, to: &mut dyn Declare) {
    if shown.is_empty() {
        return;
    }
    to.open("memories");
    for ShownMemory { memory, words, .. } in shown {
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

fn lock(view: &Mutex<View>) -> MutexGuard<'_, View> {
    view.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes beside a waveform how viewers show it.
fn set_up(view: &View, layout: &Layout, path: &Path) -> Result<(), OutputError> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into();
    let view = View { stem, ..view.clone() };
    view.write(layout, path.parent().unwrap_or(Path::new("")), create_dir, |path, text| {
        put(path, text)
    })
}

/// Removes what an earlier run that was stopped left beside its waveform.
fn remove_set_up(partial: &Path) {
    for extension in ["gtkw", "sucl"] {
        let _ = fs::remove_file(partial.with_extension(extension));
    }
    let _ = fs::remove_dir_all(partial.with_extension("states"));
}

impl Recorder {
    /// Begins a waveform of a machine. `scope` names it.
    pub(crate) fn new(
        job: &WaveJob,
        scope: &str,
        dut: &mut dyn Dut,
    ) -> Result<Recorder, WaveError> {
        let streams = dut.tally().streams.into_iter();
        let streams = streams.map(|s| StreamOf { name: s.name.into(), to: s.to.into() }).collect();
        let shown = shown(&job.memories, dut.memories())?;
        let mut layout = Layout::new(streams, |to| {
            to.open(scope);
            dut.declare(to);
            declare_words(&shown, dut.memories(), &mut Unlabelled(to));
            to.close();
        });
        let phases = dut.phases();
        if !job.scopes.is_empty() {
            layout.select(&job.scopes)?;
        }
        for window in &job.windows {
            known_phase(window, phases)?;
            let known: Vec<String> = layout.events().map(|(name, _)| name.to_string()).collect();
            if let Window::Event { name } = window
                && !known.contains(name)
            {
                let nearest = most_like(name, &known);
                let known = match &known[..] {
                    [] => "the machine has none".to_string(),
                    known => format!("there are {}", listed(known)),
                };
                return Err(WaveError::Event { name: name.clone(), nearest, known });
            }
        }
        let history = job.windows.iter().map(Watch::history).max().unwrap_or(0);
        let (file, name) = partial::create(&job.path)?;
        let wave = match Wave::new(job.format, file, layout, history) {
            Ok(wave) => wave,
            Err(error) => return Err(name.leave(&error).into()),
        };
        let watches =
            job.windows.iter().filter_map(|window| Watch::new(window, &wave, phases)).collect();
        let layout = Arc::new(wave.layout().clone());
        let view = Arc::new(Mutex::new(View { format: job.format, ..View::default() }));
        let (seen, of) = (view.clone(), layout.clone());
        name.partial().into_iter().for_each(remove_set_up);
        name.set_beside(move |partial| {
            // The file is of use without.
            let _ = set_up(&lock(&seen), &of, partial);
        });
        Ok(Recorder {
            file: Some((wave, name)),
            lost: None,
            job: job.clone(),
            layout,
            view,
            watches,
            remembers: history > 0,
            markers: vec![],
            found: Found::default(),
            memories: shown,
        })
    }

    /// One cycle, in which the machine is at phase number `phase`; until when none is shown.
    fn show(&mut self, time: u64, phase: u8, seen: &dyn Observed) -> io::Result<Quiet> {
        let Recorder { file, watches, markers, found, memories, remembers, .. } = self;
        let Some((wave, _)) = file else { return Ok(Quiet { phase, until: u64::MAX }) };
        let before = (wave.first(), wave.longest_label(), markers.len(), found.labels.len());
        // The earliest of what they ask for: all are asked.
        let mut look = |wave: &Wave| {
            watches.iter_mut().filter_map(|w| w.look(time, phase, wave, markers, found)).min()
        };
        let shown = !*remembers && look(wave).is_some();
        if !*remembers && !shown {
            let quiet = self.watches.iter().map(|watch| watch.quiet_until(time)).min();
            wave.gap(time)?;
            return Ok(Quiet { phase, until: quiet.unwrap_or(u64::MAX) });
        }
        wave.sample(|to| {
            seen.sample(to);
            memories.iter().flat_map(|shown| &shown.values).for_each(|value| to.push(*value));
        });
        if shown {
            wave.show(time)?;
        } else {
            wave.remember(time)?;
            look(wave).map_or(Ok(()), |from| wave.recall(from, time))?;
        }
        if before != (wave.first(), wave.longest_label(), markers.len(), found.labels.len()) {
            self.publish();
        }
        Ok(Quiet::default())
    }

    /// Says how viewers show what there is so far.
    #[cold]
    fn publish(&mut self) {
        let mut view = lock(&self.view);
        self.markers.dedup();
        view.markers.clone_from(&self.markers);
        view.found.clone_from(&self.found);
        if let Some((wave, _)) = &self.file {
            view.first = wave.first().unwrap_or(0);
            view.longest_label = wave.longest_label();
        }
    }

    /// The file cannot be written: it ends here, and the run goes on.
    #[cold]
    fn give_up(&mut self, error: &io::Error) {
        self.publish();
        if let Some((wave, name)) = self.file.take() {
            drop(wave);
            self.lost = Some(name.leave(error));
        }
    }

    /// The model is found at fault in cycle `time`, `what` in a word or two. If that is waited for, the cycles
    /// before are shown; where nothing moves, those before it stood still.
    pub(crate) fn failure(&mut self, time: u64, what: &str) {
        let Some((wave, _)) = &mut self.file else { return };
        if !self.job.windows.contains(&Window::Failure) {
            return;
        }
        let last = wave.last_change().unwrap_or(time);
        self.markers.insert(0, Marker { cycle: last, name: what.to_string() });
        if let Err(error) = wave.recall(0, time) {
            self.give_up(&error);
        }
    }

    /// Ends the file with the cycle after the last, and writes how viewers show it.
    pub(crate) fn finish(mut self, time: u64) -> WaveReport {
        let notes = self.watches.iter().filter_map(|watch| watch.note(time)).collect();
        self.publish();
        let mut view = lock(&self.view).clone();
        if let Some((wave, name)) = self.file.take() {
            let written = match wave.finish(time) {
                Ok(longest_label) => {
                    view.longest_label = longest_label;
                    name.finish().and_then(|()| set_up(&view, &self.layout, &self.job.path))
                }
                Err(error) => Err(name.leave(&error)),
            };
            self.lost = written.err();
        }
        WaveReport { markers: view.markers, notes, lost: self.lost }
    }

    /// Removes the file: there is nothing to be seen.
    pub(crate) fn discard(self) {
        if let Some((wave, name)) = self.file {
            drop(wave);
            name.discard();
        }
    }
}

impl Observer for Recorder {
    fn peeks(&self) -> bool {
        !self.memories.is_empty() && self.file.is_some()
    }

    fn peek(&mut self, memories: &mut dyn Memory) {
        let mut number = 0;
        memories.each(&mut |storage| {
            for shown in self.memories.iter_mut().filter(|shown| shown.number == number) {
                let writes = storage.info().writes;
                if shown.writes != writes {
                    shown.writes = writes;
                    shown.values.clear();
                    shown.words.clone().for_each(|k| storage.peek(k, &mut shown.values));
                }
            }
            number += 1;
        });
    }

    /// If the file cannot be written, there is none from here on.
    fn cycle(&mut self, at: At, seen: &dyn Observed) -> Quiet {
        let At { time, phase } = at;
        // There is nothing to be shown before the machine is ready.
        let Some(time) = time else { return Quiet { phase, until: u64::MAX } };
        self.show(time, phase, seen).unwrap_or_else(|error| {
            self.give_up(&error);
            Quiet::default()
        })
    }

    fn reset(&mut self) {
        // Counting begins anew.
        self.memories.iter_mut().for_each(|shown| shown.writes = u64::MAX);
    }
}

/// # Errors
/// The window begins with a phase that the machine does not have.
fn known_phase(window: &Window, phases: &[PhaseInfo]) -> Result<(), WaveError> {
    let known: Vec<String> = phases.iter().map(|phase| phase.name.to_string()).collect();
    match window {
        Window::Start { phase: name, .. } if !known.contains(name) => Err(WaveError::Phase {
            name: name.clone(),
            nearest: most_like(name, &known),
            known: listed(&known),
        }),
        _ => Ok(()),
    }
}
