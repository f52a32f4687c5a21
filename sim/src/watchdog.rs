//! Stops a simulation in which nothing moves, and says who waits for whom.

use std::fmt;

/// Trips when nothing moved for a number of cycles.
///
/// It is asked now and then, not every cycle, so that it costs nothing: `progress` is any number
/// that grows whenever something moves (transfers plus memory accesses).
#[derive(Clone, Debug)]
pub struct Watchdog {
    limit: u64,
    progress: u64,
    since: u64,
}

/// One handshake that did not complete.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wait {
    /// The block that waits.
    pub block: &'static str,
    /// Its state.
    pub state: &'static str,
    /// The stream.
    pub stream: &'static str,
    /// The block that it waits for.
    pub other: &'static str,
    /// Whether it waits to send (else to receive).
    pub sends: bool,
}

/// A simulation that stands still.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deadlock {
    /// The cycle in which it was found.
    pub cycle: u64,
    /// How long nothing had moved, in cycles, at least.
    pub idle: u64,
    /// Who waits for whom.
    pub waits: Vec<Wait>,
}

impl Watchdog {
    /// Trips after `limit` cycles without progress.
    pub fn new(limit: u64) -> Watchdog {
        Watchdog { limit, progress: 0, since: 0 }
    }

    /// Looks at cycle `cycle`; gives for how many cycles nothing has moved, once that is too long.
    pub fn look(&mut self, cycle: u64, progress: u64) -> Option<u64> {
        if progress != self.progress {
            self.progress = progress;
            self.since = cycle;
        }
        let idle = cycle - self.since;
        (idle >= self.limit).then_some(idle)
    }
}

impl fmt::Display for Deadlock {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "cycle {}: nothing moved for {} cycles", self.cycle, self.idle)?;
        for w in &self.waits {
            let what = if w.sends { "to take from" } else { "to offer on" };
            write!(
                f,
                "\n  {} (state {}) waits for {} {what} `{}`",
                w.block, w.state, w.other, w.stream
            )?;
        }
        Ok(())
    }
}

impl std::error::Error for Deadlock {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trips_at_the_limit_and_not_before() {
        let mut dog = Watchdog::new(10);
        assert_eq!(dog.look(5, 1), None);
        assert_eq!(dog.look(14, 1), None);
        assert_eq!(dog.look(15, 1), Some(10));
        assert_eq!(dog.look(16, 2), None);
        assert_eq!(dog.look(26, 2), Some(10));
    }

    #[test]
    fn names_the_handshake() {
        let waits = vec![
            Wait { block: "scanout", state: "Run", stream: "image", other: "display", sends: true },
            Wait {
                block: "store",
                state: "Start",
                stream: "stored",
                other: "depth_test",
                sends: false,
            },
        ];
        assert_eq!(
            Deadlock { cycle: 900, idle: 100, waits }.to_string(),
            "cycle 900: nothing moved for 100 cycles\n  scanout (state Run) waits for display to \
             take from `image`\n  store (state Start) waits for depth_test to offer on `stored`"
        );
    }
}
