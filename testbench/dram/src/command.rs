//! The commands that a controller gives to a device.

/// A command. `Read` and `Write` are column commands, and all others row commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Opens a row of a bank.
    Activate,
    /// Closes the row of a bank.
    Precharge,
    /// Closes the rows of all banks of a rank.
    PrechargeAll,
    /// Reads a burst of the open row.
    Read,
    /// Writes a burst of the open row.
    Write,
    /// Refreshes rows of all banks of a rank, which must be closed.
    Refresh,
    /// Refreshes rows of one bank, which must be closed.
    RefreshBank,
}

impl Command {
    /// How many there are.
    pub const COUNT: usize = 7;

    /// Whether it moves a burst.
    pub fn is_column(self) -> bool {
        matches!(self, Command::Read | Command::Write)
    }
}

/// A command as it was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Issued {
    /// When, in device clocks.
    pub clock: u64,
    /// What.
    pub command: Command,
    /// To which channel.
    pub channel: usize,
    /// To which bank of the channel: pseudo-channels, their ranks, their bank groups and their banks counted through. The
    /// first bank of the rank for a command to all of them.
    pub bank: usize,
    /// The row that is opened, or that is open where a burst is moved; else 0.
    pub row: u64,
}
