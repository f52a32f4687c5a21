//! How far work has come that takes a while: a bar on the terminal, or a line now and then where standard error is
//! none.

use crate::report::grouped;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use serde_json::json;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// How often the clock is looked at, in steps.
const LOOK_EVERY: u64 = 1 << 12;
/// Work that is done sooner shows nothing.
const PATIENCE: Duration = Duration::from_secs(1);
/// From line to line where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Counts steps; shows nothing when told to be quiet.
pub struct Progress {
    bars: MultiProgress,
    subject: String,
    what: &'static str,
    total: Option<u64>,
    done: u64,
    start: Instant,
    quiet: bool,
    bar: Option<ProgressBar>,
    /// When the next line is due.
    line_at: Duration,
}

impl Progress {
    /// Work of `total` steps, if that is known.
    pub fn new(what: &'static str, total: Option<u64>, quiet: bool) -> Progress {
        Progress::among(&MultiProgress::new(), String::new(), what, total, quiet)
    }

    /// The same for one of several works that go on at once, each with a bar among `bars` that says
    /// whose it is.
    pub fn among(
        bars: &MultiProgress,
        mut subject: String,
        what: &'static str,
        total: Option<u64>,
        quiet: bool,
    ) -> Progress {
        if !subject.is_empty() {
            subject += ": ";
        }
        let (bars, start) = (bars.clone(), Instant::now());
        Progress {
            bars,
            subject,
            what,
            total,
            done: 0,
            start,
            quiet,
            bar: None,
            line_at: LINE_EVERY,
        }
    }

    /// Other work follows, of which it is not known how long it takes.
    pub fn turn_to(&mut self, what: &'static str) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
        (self.what, self.total, self.done) = (what, None, 0);
    }

    /// One step is done.
    #[inline]
    pub fn step(&mut self) {
        self.done += 1;
        if self.done.is_multiple_of(LOOK_EVERY) && !self.quiet {
            self.show();
        }
    }

    /// Many steps are done.
    pub fn steps(&mut self, steps: u64) {
        self.done += steps;
        if !self.quiet {
            self.show();
        }
    }

    #[cold]
    fn show(&mut self) {
        let elapsed = self.start.elapsed();
        if elapsed < PATIENCE {
            return;
        }
        if !std::io::stderr().is_terminal() {
            if let Some(line) = self.line(elapsed) {
                let _ = writeln!(std::io::stderr().lock(), "{line}");
            }
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let (bar, template) = match self.total {
                Some(total) => {
                    (ProgressBar::new(total), "{msg} {wide_bar} {human_pos}/{human_len} {eta}")
                }
                None => (ProgressBar::new_spinner(), "{msg} {spinner} {human_pos}"),
            };
            let style = ProgressStyle::with_template(template);
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            let message = format!("{}{}", self.subject, self.what);
            self.bars.add(bar.with_style(style).with_message(message))
        });
        bar.set_position(self.done);
    }

    /// The line that is due so long after the start, if one is.
    fn line(&mut self, elapsed: Duration) -> Option<String> {
        if elapsed < self.line_at {
            return None;
        }
        self.line_at = elapsed + LINE_EVERY;
        let count = |steps: u64| grouped(&json!(steps));
        let of = self.total.map(|total| format!(" of {}", count(total))).unwrap_or_default();
        let (subject, what, done) = (&self.subject, self.what, count(self.done));
        Some(format!("progress: {subject}{what}, {done}{of}"))
    }
}

/// A spinner that turns by itself, for work that cannot be counted.
pub fn waiting(what: String, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {spinner} {elapsed}");
    let bar = ProgressBar::new_spinner()
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
        .with_message(what);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_every_ten_seconds_and_says_how_far_it_is() {
        let bars = MultiProgress::new();
        let mut progress =
            Progress::among(&bars, "glass".into(), "simulating", Some(1_234_567), false);
        progress.done = 5000;
        let seconds = Duration::from_secs;
        assert_eq!(progress.line(seconds(9)), None);
        let line = "progress: glass: simulating, 5,000 of 1,234,567".to_string();
        assert_eq!(progress.line(seconds(11)), Some(line));
        assert_eq!(progress.line(seconds(20)), None);
        progress.turn_to("resolving");
        progress.done = 8192;
        let line = "progress: glass: resolving, 8,192".to_string();
        assert_eq!(progress.line(seconds(21)), Some(line));
        assert_eq!(Progress::new("", None, true).line(seconds(9)), None);
    }
}
