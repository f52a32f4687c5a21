//! Which cycles a waveform shows.

use pellucid_hw::machine::Phase;
use std::ops::Range;
use std::str::FromStr;

/// Cycles of a phase that `store` and `resolve` show, from its start.
pub const PHASE_CYCLES: u64 = 1000;

/// A window of cycles. Cycle 0 is the first in which the machine is ready for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// From a cycle up to, not including, another.
    Cycles {
        /// The first cycle.
        from: u64,
        /// The cycle after the last.
        to: u64,
    },
    /// The first cycles of a phase, in each frame.
    Start {
        /// The phase.
        phase: Phase,
        /// How many cycles.
        cycles: u64,
    },
}

/// What the first cycles of a run and of its resolve show.
pub const DEFAULT_WINDOWS: [Window; 2] = [
    Window::Start { phase: Phase::Store, cycles: PHASE_CYCLES },
    Window::Start { phase: Phase::Resolve, cycles: PHASE_CYCLES },
];

/// A window that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no window of cycles: expected `FROM..TO` with FROM below TO, `store`, `resolve` or `all`"
)]
pub struct WindowError(String);

impl FromStr for Window {
    type Err = WindowError;
    fn from_str(text: &str) -> Result<Window, WindowError> {
        let start = |phase| Ok(Window::Start { phase, cycles: PHASE_CYCLES });
        match text {
            "store" => return start(Phase::Store),
            "resolve" => return start(Phase::Resolve),
            "all" => return Ok(Window::Cycles { from: 0, to: u64::MAX }),
            _ => {}
        }
        let error = || WindowError(text.to_string());
        let (from, to) = text.split_once("..").ok_or_else(error)?;
        let Range { start: from, end: to } = match (from.trim().parse(), to.trim().parse()) {
            (Ok(from), Ok(to)) if from < to => from..to,
            _ => return Err(error()),
        };
        Ok(Window::Cycles { from, to })
    }
}

/// A window that is followed through a run.
#[derive(Clone, Copy, Debug)]
pub struct Follow {
    window: Window,
    before: Phase,
    until: u64,
}

impl Follow {
    /// At the start of a run.
    pub fn new(window: Window) -> Follow {
        Follow { window, before: Phase::Clear, until: 0 }
    }

    /// Whether the window shows cycle `time`, in which the machine is at `phase`. Asked once a cycle.
    pub fn covers(&mut self, time: u64, phase: Phase) -> bool {
        match self.window {
            Window::Cycles { from, to } => (from..to).contains(&time),
            Window::Start { phase: wanted, cycles } => {
                if phase == wanted && self.before != wanted {
                    self.until = time + cycles;
                }
                self.before = phase;
                time < self.until
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read() {
        assert_eq!("5..17".parse(), Ok(Window::Cycles { from: 5, to: 17 }));
        assert_eq!("store".parse(), Ok(Window::Start { phase: Phase::Store, cycles: 1000 }));
        for bad in ["", "5", "7..7", "9..2", "a..b", "-1..4", "stor"] {
            let error = bad.parse::<Window>().unwrap_err().to_string();
            let expected = format!(
                "`{bad}` is no window of cycles: expected `FROM..TO` with FROM below TO, `store`, \
                 `resolve` or `all`"
            );
            assert_eq!(error, expected);
        }
    }

    #[test]
    fn a_phase_is_shown_from_its_start_in_each_frame() {
        let mut follow = Follow::new(Window::Start { phase: Phase::Resolve, cycles: 2 });
        use Phase::{Idle, Resolve, Store};
        let phases = [Idle, Store, Resolve, Resolve, Resolve, Idle, Store, Resolve, Idle, Idle];
        let shown: Vec<bool> = (0..).zip(phases).map(|(t, p)| follow.covers(t, p)).collect();
        let expected = [0, 0, 1, 1, 0, 0, 0, 1, 1, 0].map(|b| b == 1);
        assert_eq!(shown, expected);
    }
}
