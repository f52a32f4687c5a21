//! How the memory behind a machine is put together and driven.

use crate::mapping::Mapping;
use crate::names::names;
use crate::part::Part;
use crate::queue::CAPACITY;

names! {
    /// In which order requests are served.
    pub enum Scheduler: "scheduler" {
        /// Bursts of open rows first, then the oldest request; a row that a queued request needs is not closed.
        FrFcfs = "fr-fcfs",
        /// The oldest request first, and nothing for any other before it is served.
        Fcfs = "fcfs",
    }
}

names! {
    /// When a row is closed.
    pub enum Page: "page policy" {
        /// When a request needs another row of the bank, or a refresh is due.
        Open = "open",
        /// Also when no queued request needs it, and after four bursts.
        Closed = "closed",
    }
}

names! {
    /// What is refreshed at a time.
    pub enum Refresh: "refresh" {
        /// All banks of a rank.
        AllBank = "all-bank",
        /// One bank after the other.
        PerBank = "per-bank",
    }
}

/// The memory of a machine. The fields can be chosen freely; [`Dram::new`](crate::Dram::new) checks them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Config {
    /// The device.
    pub part: Part,
    /// Channels beside each other, a power of two from 1 to 64. Each has its own controller.
    pub channels: u32,
    /// Ranks on the data bus of each pseudo-channel, a power of two. At most 128 banks share a data bus.
    pub ranks: u32,
    /// Which address is where.
    pub mapping: Mapping,
    /// In which order requests are served.
    pub scheduler: Scheduler,
    /// When rows are closed.
    pub page: Page,
    /// What is refreshed at a time.
    pub refresh: Refresh,
    /// Period of the machine's clock, ps, from 1 to 1,000,000. With the part's `tck_ps` it says how many device clocks a
    /// machine cycle has, on average.
    pub machine_period_ps: u64,
}

/// Why there is no such memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigError {
    /// A number that cannot be.
    #[error("`{key}` is {found}: expected {expected}")]
    Value {
        /// Which.
        key: &'static str,
        /// What was given.
        found: u64,
        /// What it may be.
        expected: &'static str,
    },
    /// More banks than a controller keeps.
    #[error("a data bus of `{part}` with {ranks} ranks has {banks} banks: expected at most 128")]
    Banks {
        /// The part.
        part: String,
        /// Ranks asked for.
        ranks: u32,
        /// Banks on a data bus then.
        banks: u64,
    },
    /// The part has no timing for it.
    #[error("`{part}` has no `rfc_bank`, `pbr2pbr` and `pbr2act`: expected `all-bank` refresh")]
    PerBank {
        /// The part.
        part: String,
    },
}

impl Config {
    /// One channel of one rank of `part`, scheduled by FR-FCFS with open pages; the machine has the device's clock.
    pub fn new(part: Part) -> Config {
        Config {
            channels: 1,
            ranks: 1,
            mapping: Mapping::RowBankColumnGroup,
            scheduler: Scheduler::FrFcfs,
            page: Page::Open,
            refresh: Refresh::AllBank,
            machine_period_ps: part.timing.tck_ps,
            part,
        }
    }

    /// Banks on a data bus.
    pub fn banks(&self) -> u64 {
        let o = &self.part.organisation;
        [self.ranks, o.bank_groups, o.banks].iter().map(|&n| u64::from(n)).product()
    }

    /// Device clocks from a request to the end of its data, at most, if nothing is asked after it.
    ///
    /// In each interval between refreshes there is time for a row to be closed and opened and for a burst, whatever was done
    /// before, so that one request goes; others may go before it that are in the two queues of its data bus.
    pub fn longest_wait(&self) -> u64 {
        let t = &self.part.timing;
        (2 * CAPACITY as u64 + 1) * t.refi + t.cl.max(t.cwl) + t.burst
    }

    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let value = |key, found, expected| Err(ConfigError::Value { key, found, expected });
        if !self.channels.is_power_of_two() || self.channels > 64 {
            return value("channels", u64::from(self.channels), "a power of two from 1 to 64");
        }
        if !self.ranks.is_power_of_two() || self.ranks > 128 {
            return value("ranks", u64::from(self.ranks), "a power of two from 1 to 128");
        }
        if !(1..=1_000_000).contains(&self.machine_period_ps) {
            return value(
                "machine_period_ps",
                self.machine_period_ps,
                "a number of ps from 1 to 1000000",
            );
        }
        let part = &self.part;
        if self.banks() > 128 {
            let (part, ranks, banks) = (part.name.clone(), self.ranks, self.banks());
            return Err(ConfigError::Banks { part, ranks, banks });
        }
        if self.refresh == Refresh::PerBank && part.timing.bank_refresh.is_none() {
            return Err(ConfigError::PerBank { part: part.name.clone() });
        }
        Ok(())
    }
}
