//! Which cycles a waveform shows.

use pellucid_hw::machine::Phase;
use std::fmt;
use std::str::FromStr;

/// Cycles of a phase that `store` and `resolve` show, from its start.
pub const PHASE_CYCLES: u64 = 1000;
/// The longest stall that can be waited for: as many cycles are remembered.
pub const LONGEST_STALL: u64 = 10_000;

/// A window of cycles. Cycle 0 is the first in which the machine is ready for a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
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
    /// Around the first time that a stream's offer is not taken for more than so many cycles.
    Stall {
        /// How many cycles.
        longer_than: u64,
    },
    /// Around the first cycle in which something happens.
    Event {
        /// Which event, by the name of its wire.
        name: String,
    },
    /// Every cycle in which a fragment is in a register or on a stream, and some around it.
    Fragment {
        /// Its number in its frame.
        number: u32,
    },
    /// The same for all fragments of a pixel.
    Pixel {
        /// Its column.
        x: u16,
        /// Its row.
        y: u16,
    },
    /// Before the cycle in which the model is found at fault: a port misused, a value too wide, a stream that
    /// breaks its rules, or nothing that moves.
    Failure,
}

/// What the first cycles of a run and of its resolve show.
pub const DEFAULT_WINDOWS: [Window; 2] = [
    Window::Start { phase: Phase::Store, cycles: PHASE_CYCLES },
    Window::Start { phase: Phase::Resolve, cycles: PHASE_CYCLES },
];

/// A window that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no window of cycles: expected `FROM..TO` with FROM below TO, `store`, `resolve`, `all`, \
     `stall:N` with N from 1 to {LONGEST_STALL}, or `event:NAME`"
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
        if let Some(cycles) = text.strip_prefix("stall:") {
            let longer_than = cycles.parse().ok().filter(|n| (1..=LONGEST_STALL).contains(n));
            return Ok(Window::Stall { longer_than: longer_than.ok_or_else(error)? });
        }
        if let Some(name) = text.strip_prefix("event:").filter(|name| !name.is_empty()) {
            return Ok(Window::Event { name: name.to_string() });
        }
        let (from, to) = range(text).ok_or_else(error)?;
        Ok(Window::Cycles { from, to })
    }
}

/// `FROM..TO` with FROM below TO.
pub fn range<T: FromStr + PartialOrd>(text: &str) -> Option<(T, T)> {
    let (from, to) = text.split_once("..")?;
    let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
    (from < to).then_some((from, to))
}

/// As users write it, or say it.
impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Window::Cycles { from: 0, to: u64::MAX } => write!(f, "all"),
            Window::Cycles { from, to } => write!(f, "{from}..{to}"),
            Window::Start { phase, .. } => write!(f, "{}", format!("{phase:?}").to_lowercase()),
            Window::Stall { longer_than } => write!(f, "stall:{longer_than}"),
            Window::Event { name } => write!(f, "event:{name}"),
            Window::Fragment { number } => write!(f, "fragment {number}"),
            Window::Pixel { x, y } => write!(f, "pixel {x},{y}"),
            Window::Failure => write!(f, "failure"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read() {
        let cases = [
            ("5..17", Window::Cycles { from: 5, to: 17 }),
            ("all", Window::Cycles { from: 0, to: u64::MAX }),
            ("store", Window::Start { phase: Phase::Store, cycles: 1000 }),
            ("stall:7", Window::Stall { longer_than: 7 }),
            ("event:dropped", Window::Event { name: "dropped".into() }),
        ];
        for (text, window) in cases {
            assert_eq!(text.parse().as_ref(), Ok(&window));
            assert_eq!(window.to_string(), text);
        }
        for bad in ["", "5", "7..7", "9..2", "a..b", "-1..4", "stor", "stall:0", "stall:", "event:"]
        {
            let error = bad.parse::<Window>().unwrap_err().to_string();
            let expected = format!(
                "`{bad}` is no window of cycles: expected `FROM..TO` with FROM below TO, `store`, \
                 `resolve`, `all`, `stall:N` with N from 1 to 10000, or `event:NAME`"
            );
            assert_eq!(error, expected);
        }
    }
}
