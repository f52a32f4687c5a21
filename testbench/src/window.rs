//! Which cycles a waveform shows.

use pellucid_machine::PhaseInfo;
use std::fmt;
use std::str::FromStr;

/// Cycles of a phase that `store` and `resolve` show, from its start.
pub const PHASE_CYCLES: u64 = 1000;
/// The longest stall that can be waited for: as many cycles are remembered.
pub const LONGEST_STALL: u64 = 10_000;

/// Every event that a machine may have: a wire in a scope `events`.
pub const EVENTS: [&str; 42] = [
    "counted",
    "stored",
    "spilled",
    "ssa_hit",
    "ssa_miss",
    "ssa_write_back",
    "framebuffer_hit",
    "framebuffer_miss",
    "framebuffer_write_back",
    "first",
    "section_taken",
    "lacking",
    "dropped",
    "waits",
    "compared",
    "weight_changed",
    "chain_begun",
    "read",
    "read_again",
    "drawn",
    "hidden",
    "culled_early",
    "culled_late",
    "blended",
    "again",
    "round_ends",
    "round_failed",
    "band_done",
    "pass_begins",
    "submitted",
    "shaded",
    "discarded",
    "culled",
    "killed",
    "play_done",
    "wasted",
    "sort_pass",
    "frame_in",
    "node_done",
    "image_done",
    "scanout",
    "frame_done",
];

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
        /// The phase, by its name.
        phase: String,
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

/// Where no window is asked for: the first cycles of each phase in which a frame is worked on.
pub fn default_windows(phases: &[PhaseInfo]) -> Vec<Window> {
    let works = phases.iter().filter(|phase| phase.works);
    let start =
        |phase: &PhaseInfo| Window::Start { phase: phase.name.to_string(), cycles: PHASE_CYCLES };
    works.map(start).collect()
}

/// A window that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no window of cycles: expected `FROM..TO` with FROM below TO, a phase as `store` or `resolve`, \
     `all`, `stall:N` with N from 1 to {LONGEST_STALL}, or `event:NAME`"
)]
pub struct WindowError(String);

impl FromStr for Window {
    type Err = WindowError;
    fn from_str(text: &str) -> Result<Window, WindowError> {
        if text == "all" {
            return Ok(Window::Cycles { from: 0, to: u64::MAX });
        }
        if !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_') {
            return Ok(Window::Start { phase: text.to_string(), cycles: PHASE_CYCLES });
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
            Window::Start { phase, .. } => write!(f, "{phase}"),
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
            ("store", Window::Start { phase: "store".into(), cycles: 1000 }),
            ("stall:7", Window::Stall { longer_than: 7 }),
            ("event:dropped", Window::Event { name: "dropped".into() }),
        ];
        for (text, window) in cases {
            assert_eq!(text.parse().as_ref(), Ok(&window));
            assert_eq!(window.to_string(), text);
        }
        for bad in
            ["", "5", "7..7", "9..2", "a..b", "-1..4", "Store", "stall:0", "stall:", "event:"]
        {
            let error = bad.parse::<Window>().unwrap_err().to_string();
            let expected = format!(
                "`{bad}` is no window of cycles: expected `FROM..TO` with FROM below TO, a phase \
                 as `store` or `resolve`, `all`, `stall:N` with N from 1 to 10000, or `event:NAME`"
            );
            assert_eq!(error, expected);
        }
    }
}
