//! Follows a window through a run: whether a cycle is shown, from where on, and which points get a name.

use crate::window::Window;
use pellucid_machine::PhaseInfo;
use pellucid_sim::Label;
use pellucid_waveforms::{Found, Marker, Wave};

/// Cycles that are shown before and after those in which a followed fragment is seen.
const AROUND: u64 = 10;
/// Cycles that are shown before a stall or an event, and after it.
const BEFORE: u64 = 20;
const AFTER: u64 = 100;
/// Cycles that are remembered for the case that the model is found at fault.
const BEFORE_FAILURE: usize = 1000;

/// A window that is followed through a run.
pub(crate) struct Watch {
    window: Window,
    /// The machine's phases.
    phases: &'static [PhaseInfo],
    /// The phase of the cycle before.
    phase: u8,
    /// The cycle after the last that is shown, as far as is known.
    until: u64,
    /// What it waits for has come.
    came: bool,
    /// For each stream its name, where its stall is among the values, how long the stall at hand is and how
    /// long the longest was.
    stalls: Vec<Stall>,
    /// Where the event is among the values.
    event: usize,
}

struct Stall {
    stream: String,
    at: usize,
    cycles: u64,
    longest: u64,
}

impl Watch {
    /// At the start of a run. Nothing if it waits for an event that there is not.
    pub(crate) fn new(window: &Window, wave: &Wave, phases: &'static [PhaseInfo]) -> Option<Watch> {
        let (mut stalls, mut event) = (vec![], 0);
        match window {
            Window::Stall { .. } => {
                stalls.extend(wave.layout().stalls().map(|(stream, at)| Stall {
                    stream: stream.to_string(),
                    at,
                    cycles: 0,
                    longest: 0,
                }));
            }
            Window::Event { name } => {
                event = wave.layout().events().find(|(event, _)| event == name)?.1;
            }
            _ => {}
        }
        let window = window.clone();
        Some(Watch { window, phases, phase: 0, until: 0, came: false, stalls, event })
    }

    /// Cycles that must be remembered, 0 if it is known of a cycle whether it is shown when it comes.
    pub(crate) fn history(window: &Window) -> usize {
        match window {
            Window::Cycles { .. } | Window::Start { .. } => 0,
            Window::Stall { longer_than } => (longer_than + BEFORE) as usize + 1,
            Window::Event { .. } => BEFORE as usize + 1,
            Window::Fragment { .. } | Window::Pixel { .. } => AROUND as usize + 1,
            Window::Failure => BEFORE_FAILURE,
        }
    }

    /// The first cycle after `time`, which is not shown, that may be: as long as the phase stays the same.
    pub(crate) fn quiet_until(&self, time: u64) -> u64 {
        match self.window {
            Window::Cycles { from, .. } if time < from => from,
            Window::Cycles { .. } | Window::Start { .. } => u64::MAX,
            _ => time,
        }
    }

    /// From which cycle on the waveform is shown, if cycle `time` is, in which the machine is at `phase`.
    /// Asked once a cycle. Names of points go to `markers`, and where they were seen to `found`.
    pub(crate) fn look(
        &mut self,
        time: u64,
        phase: u8,
        wave: &Wave,
        markers: &mut Vec<Marker>,
        found: &mut Found,
    ) -> Option<u64> {
        let begins = phase != self.phase;
        self.phase = phase;
        let name = self.phases[usize::from(phase)].name;
        let mut from = time;
        let mut mark = |cycle, name: String| markers.push(Marker { cycle, name });
        match &self.window {
            Window::Cycles { from, to } => {
                self.came |= time >= *from;
                return (*from..*to).contains(&time).then_some(time);
            }
            Window::Start { phase: wanted, cycles } => {
                if begins && name == *wanted {
                    self.came = true;
                    self.until = time.saturating_add(*cycles);
                    mark(time, self.window.to_string());
                }
            }
            Window::Stall { longer_than } => {
                for stall in &mut self.stalls {
                    stall.cycles = if wave.value(stall.at) == 1 { stall.cycles + 1 } else { 0 };
                    stall.longest = stall.longest.max(stall.cycles);
                    if !self.came && stall.cycles > *longer_than {
                        self.came = true;
                        self.until = time + AFTER;
                        found.values.push(stall.at);
                        from = (time + 1 - stall.cycles).saturating_sub(BEFORE);
                        mark(time + 1 - stall.cycles, format!("{} stalls", stall.stream));
                    }
                }
            }
            Window::Event { name } => {
                if !self.came && wave.value(self.event) == 1 {
                    self.came = true;
                    self.until = time + AFTER;
                    found.values.push(self.event);
                    from = time.saturating_sub(BEFORE);
                    mark(time, name.clone());
                }
            }
            Window::Fragment { .. } | Window::Pixel { .. } => {
                let places = wave.labels().iter().enumerate();
                let mut seen = places.filter(|(_, label)| self.follows(**label)).peekable();
                if let Some((_, label)) = seen.peek().copied() {
                    for (place, _) in seen {
                        if !found.labels.contains(&place) {
                            found.labels.push(place);
                        }
                    }
                    if time >= self.until {
                        mark(time, format!("{label} {name}"));
                        from = time.saturating_sub(AROUND);
                    }
                    self.came = true;
                    self.until = time + 1 + AROUND;
                }
            }
            Window::Failure => {}
        }
        (time < self.until).then_some(from)
    }

    fn follows(&self, label: Label) -> bool {
        match &self.window {
            Window::Fragment { number } => label.number() == Some(*number),
            Window::Pixel { x, y } => label.number().is_some() && label.place() == (*x, *y),
            _ => false,
        }
    }

    /// What is to be said of it after a run of so many cycles, if what it waits for has not come.
    pub(crate) fn note(&self, cycles: u64) -> Option<String> {
        if self.came {
            return None;
        }
        let window = &self.window;
        Some(match window {
            Window::Cycles { .. } => format!("window {window}: the run has {cycles} cycles"),
            Window::Stall { longer_than } => {
                let longest = self.stalls.iter().max_by_key(|stall| stall.longest)?;
                let Stall { stream, longest, .. } = longest;
                format!(
                    "window {window}: no stream stalled for more than {longer_than} cycles; the longest \
                     stall is that of `{stream}`, {longest} cycles"
                )
            }
            Window::Event { name } => format!("window {window}: `{name}` did not happen"),
            Window::Fragment { .. } => format!("{window} did not come"),
            Window::Pixel { .. } => format!("no fragment came to {window}"),
            Window::Start { .. } | Window::Failure => return None,
        })
    }
}
