//! A part: how a device is organised, and its timing, as a table in a TOML file.
//!
//! The parts that are shipped are such files (`src/parts/`), which can be copied and changed. All keys must be there, but those
//! for the refresh of single banks. What contradicts itself is refused.

mod check;
mod keys;

use crate::names::{self, NameError, names};
use keys::{Keys, Section};
use std::path::Path;

/// What is wrong with a part's file.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// No part of that name is shipped.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The file could not be read.
    #[error("{file}: {error}")]
    Read {
        /// Its path.
        file: String,
        /// Why.
        error: std::io::Error,
    },
    /// It is no TOML.
    #[error("{file}: {error}")]
    Syntax {
        /// Its path.
        file: String,
        /// Where and why.
        error: toml::de::Error,
    },
    /// A key that no part has.
    #[error("{file}: unknown key `{key}`{}; known are {known}", names::did_you_mean(*.nearest))]
    Unknown {
        /// The file's path.
        file: String,
        /// The key, with its section.
        key: String,
        /// The known key of that section that is most like it.
        nearest: Option<&'static str>,
        /// All of that section.
        known: String,
    },
    /// A key that is not there, or whose value cannot be.
    #[error("{file}: `{key}` is {found}: expected {expected}")]
    Value {
        /// The file's path.
        file: String,
        /// The key, with its section.
        key: String,
        /// What was found.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// Values that contradict each other.
    #[error("{file}: {text}")]
    Together {
        /// The file's path.
        file: String,
        /// Which, and what was expected.
        text: String,
    },
}

names! {
    /// How commands reach a channel.
    pub enum CommandBuses: "command buses" {
        /// One command in a clock.
        One = "one",
        /// One row command and one column command in a clock, as HBM has it.
        RowAndColumn = "row-and-column",
    }
}

/// How a channel is organised. All sizes are powers of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Organisation {
    /// Width of the data bus of a pseudo-channel, bits.
    pub bus_bits: u32,
    /// Words of a burst.
    pub burst_length: u32,
    /// Pseudo-channels of a channel: data buses of their own behind the same command buses.
    pub pseudo_channels: u32,
    /// Bank groups of a rank.
    pub bank_groups: u32,
    /// Banks of a bank group.
    pub banks: u32,
    /// Rows of a bank.
    pub rows: u32,
    /// Words of a row.
    pub columns: u32,
    /// How commands come.
    pub command_buses: CommandBuses,
}

impl Organisation {
    /// Bytes that one burst moves.
    pub fn burst_bytes(&self) -> u64 {
        u64::from(self.bus_bits) * u64::from(self.burst_length) / 8
    }

    /// Bursts of a row.
    pub fn bursts(&self) -> u64 {
        u64::from(self.columns / self.burst_length)
    }

    /// Banks of a rank.
    pub fn rank_banks(&self) -> usize {
        (self.bank_groups * self.banks) as usize
    }
}

/// Timing of the refresh of single banks, in clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BankRefresh {
    /// How long the bank is busy.
    pub rfc: u64,
    /// From one bank's refresh to the next one's of the same rank.
    pub to_refresh: u64,
    /// From one bank's refresh to an activate of another bank of the rank.
    pub to_activate: u64,
}

/// Timing of a device, in clocks of `tck_ps`; names as in JEDEC's standards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Period of the device's clock, ps.
    pub tck_ps: u64,
    /// Clocks for which a burst has the data bus.
    pub burst: u64,
    /// From a read to the begin of its data.
    pub cl: u64,
    /// From a write to the begin of its data.
    pub cwl: u64,
    /// From an activate to a read of the bank.
    pub rcd_read: u64,
    /// From an activate to a write of the bank.
    pub rcd_write: u64,
    /// From a precharge to an activate of the bank.
    pub rp: u64,
    /// From an activate to a precharge of the bank.
    pub ras: u64,
    /// From an activate to the next one of the bank.
    pub rc: u64,
    /// From a read to a precharge of the bank.
    pub rtp: u64,
    /// From the end of a write's data to a precharge of the bank.
    pub wr: u64,
    /// From a read to a read, or a write to a write, of another bank group.
    pub ccd_s: u64,
    /// The same within a bank group.
    pub ccd_l: u64,
    /// From an activate to one in another bank group.
    pub rrd_s: u64,
    /// The same within a bank group.
    pub rrd_l: u64,
    /// In which at most four activates of a rank begin.
    pub faw: u64,
    /// From the end of a write's data to a read of another bank group.
    pub wtr_s: u64,
    /// The same within a bank group.
    pub wtr_l: u64,
    /// From a read to a write of the same rank.
    pub rtw: u64,
    /// For which the data bus rests between bursts of two ranks.
    pub rank_switch: u64,
    /// From a precharge to the next one of the rank.
    pub ppd: u64,
    /// Between refreshes of a rank; refreshes of single banks share it evenly.
    pub refi: u64,
    /// How long a refresh of all banks takes.
    pub rfc: u64,
    /// Refresh of single banks, where the device has it.
    pub bank_refresh: Option<BankRefresh>,
}

/// A DRAM device. One that is changed by a program must be one that a file could say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// How it is organised.
    pub organisation: Organisation,
    /// Its timing.
    pub timing: Timing,
}

const SHIPPED: [(&str, &str); 4] = [
    ("ddr4-3200", include_str!("parts/ddr4-3200.toml")),
    ("lpddr5-6400", include_str!("parts/lpddr5-6400.toml")),
    ("gddr6-14000", include_str!("parts/gddr6-14000.toml")),
    ("hbm3-6400", include_str!("parts/hbm3-6400.toml")),
];

impl Part {
    /// Names of the parts that are shipped.
    pub const NAMES: [&str; 4] = [SHIPPED[0].0, SHIPPED[1].0, SHIPPED[2].0, SHIPPED[3].0];

    /// The file of a part that is shipped, to copy and change.
    ///
    /// # Errors
    /// No part has that name.
    pub fn file(name: &str) -> Result<&'static str, PartError> {
        match SHIPPED.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Ok(text),
            None => Err(NameError::new("part", name, &Part::NAMES).into()),
        }
    }

    /// A part that is shipped.
    ///
    /// # Errors
    /// No part has that name.
    pub fn named(name: &str) -> Result<Part, PartError> {
        Part::parse(name, Part::file(name)?)
    }

    /// A part from a user's file.
    ///
    /// # Errors
    /// The file cannot be read, or [`Part::parse`] refuses it.
    pub fn open(path: &Path) -> Result<Part, PartError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Part::parse(&file, &text),
            Err(error) => Err(PartError::Read { file, error }),
        }
    }

    /// A part from the text of a file; `file` is what errors call it.
    ///
    /// # Errors
    /// The text is no TOML, a key is unknown or missing, a value is out of its range, or values contradict each other.
    pub fn parse(file: &str, text: &str) -> Result<Part, PartError> {
        let table: toml::Table =
            text.parse().map_err(|error| PartError::Syntax { file: file.to_string(), error })?;
        let keys = Keys { file };
        keys.known("", &table, &["name", "organisation", "timing"])?;
        let name = keys.text("name", table.get("name"))?.to_string();
        let section = |name| Section::new(keys, name, &table);
        let part = Part {
            name,
            organisation: Organisation::read(&section("organisation")?)?,
            timing: Timing::read(&section("timing")?)?,
        };
        match check::contradiction(&part) {
            None => Ok(part),
            Some(text) => Err(PartError::Together { file: file.to_string(), text }),
        }
    }
}

impl Organisation {
    fn read(section: &Section) -> Result<Organisation, PartError> {
        section.known(&[
            "bus_bits",
            "burst_length",
            "pseudo_channels",
            "bank_groups",
            "banks",
            "rows",
            "columns",
            "command_buses",
        ])?;
        Ok(Organisation {
            bus_bits: section.size("bus_bits", 8, 4096)?,
            burst_length: section.size("burst_length", 1, 256)?,
            pseudo_channels: section.size("pseudo_channels", 1, 16)?,
            bank_groups: section.size("bank_groups", 1, 64)?,
            banks: section.size("banks", 1, 64)?,
            rows: section.size("rows", 1, 1 << 24)?,
            columns: section.size("columns", 1, 1 << 20)?,
            command_buses: section.choice("command_buses", CommandBuses::NAMES)?,
        })
    }
}

impl Timing {
    fn read(section: &Section) -> Result<Timing, PartError> {
        section.known(&[
            "tck_ps",
            "burst",
            "cl",
            "cwl",
            "rcd_read",
            "rcd_write",
            "rp",
            "ras",
            "rc",
            "rtp",
            "wr",
            "ccd_s",
            "ccd_l",
            "rrd_s",
            "rrd_l",
            "faw",
            "wtr_s",
            "wtr_l",
            "rtw",
            "rank_switch",
            "ppd",
            "refi",
            "rfc",
            "rfc_bank",
            "pbr2pbr",
            "pbr2act",
        ])?;
        let clocks = |key| section.number(key, 1, 1_000_000);
        let bank_refresh =
            match ["rfc_bank", "pbr2pbr", "pbr2act"].iter().any(|key| section.has(key)) {
                false => None,
                true => Some(BankRefresh {
                    rfc: clocks("rfc_bank")?,
                    to_refresh: clocks("pbr2pbr")?,
                    to_activate: clocks("pbr2act")?,
                }),
            };
        Ok(Timing {
            tck_ps: section.number("tck_ps", 1, 1_000_000)?,
            burst: clocks("burst")?,
            cl: clocks("cl")?,
            cwl: clocks("cwl")?,
            rcd_read: clocks("rcd_read")?,
            rcd_write: clocks("rcd_write")?,
            rp: clocks("rp")?,
            ras: clocks("ras")?,
            rc: clocks("rc")?,
            rtp: clocks("rtp")?,
            wr: clocks("wr")?,
            ccd_s: clocks("ccd_s")?,
            ccd_l: clocks("ccd_l")?,
            rrd_s: clocks("rrd_s")?,
            rrd_l: clocks("rrd_l")?,
            faw: clocks("faw")?,
            wtr_s: clocks("wtr_s")?,
            wtr_l: clocks("wtr_l")?,
            rtw: clocks("rtw")?,
            rank_switch: clocks("rank_switch")?,
            ppd: clocks("ppd")?,
            refi: clocks("refi")?,
            rfc: clocks("rfc")?,
            bank_refresh,
        })
    }
}

#[cfg(test)]
mod tests;
