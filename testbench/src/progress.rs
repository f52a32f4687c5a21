//! A bar on the terminal for work that takes longer than a second.

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// How often the clock is looked at, in steps.
const LOOK_EVERY: u64 = 1 << 12;
/// Work that is done sooner shows nothing.
const PATIENCE: Duration = Duration::from_secs(1);

/// Counts steps; shows nothing where standard error is no terminal, or when told to be quiet.
pub struct Progress {
    bars: MultiProgress,
    subject: String,
    what: &'static str,
    total: Option<u64>,
    done: u64,
    start: Instant,
    quiet: bool,
    bar: Option<ProgressBar>,
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
        Progress { bars, subject, what, total, done: 0, start, quiet, bar: None }
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

    #[cold]
    fn show(&mut self) {
        if self.start.elapsed() < PATIENCE {
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
