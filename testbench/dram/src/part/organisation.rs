//! How a channel is organised.

use super::PartError;
use super::keys::Section;
use crate::names::names;

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

    /// From a file's section.
    pub(super) fn read(section: &Section) -> Result<Organisation, PartError> {
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
