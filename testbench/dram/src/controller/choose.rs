//! Which request gets the next command.

use super::{Controller, PAGE_BURSTS};
use crate::command::Command;
use crate::config::Page;
use crate::device::OpenRow;
use crate::queue::Entry;

fn burst_command(write: bool) -> Command {
    if write { Command::Write } else { Command::Read }
}

/// What may be given in this clock, by the index of the request in the queue that is served.
pub struct Choice {
    /// The oldest request whose burst can move.
    pub column: Option<usize>,
    /// The oldest request that needs a row opened or closed, and can have it.
    pub row: Option<(usize, Command)>,
}

impl Controller {
    /// Whether the row is to be closed, whoever needs it.
    fn is_spent(&self, open: OpenRow) -> bool {
        self.page == Page::Closed && open.bursts >= PAGE_BURSTS
    }

    /// The first clock at which the request's own next command may come.
    pub(super) fn earliest(&self, write: bool, entry: &Entry) -> u64 {
        let command = match self.device.open(entry.bank) {
            None => Command::Activate,
            Some(open) if open.row == entry.row => burst_command(write),
            Some(_) => Command::Precharge,
        };
        self.device.earliest(command, entry.bank)
    }

    /// Looks through the queue that is served, or at its head. `next` is lowered to the clock at which what cannot be given
    /// now can be at the earliest.
    pub(super) fn choose(
        &self,
        clock: u64,
        write: bool,
        head_only: bool,
        next: &mut u64,
    ) -> Choice {
        let queue = if write { &self.writes } else { &self.reads };
        let count = if head_only { queue.len().min(1) } else { queue.len() };
        let entries = &queue.entries()[..count];
        let burst = burst_command(write);
        let mut choice = Choice { column: None, row: None };

        // Banks whose open row is needed, and banks that are closed or have another row open, a bit each. All requests of a
        // bank to one row may have their burst at the same clock, so that the oldest of each bank speaks for the others.
        let (mut needed, mut seen) = (self.held, self.held);
        for (index, entry) in entries.iter().enumerate() {
            let bit = 1 << entry.bank;
            if needed & bit != 0 {
                continue;
            }
            let open = self.device.open(entry.bank);
            if open.is_some_and(|open| open.row == entry.row && !self.is_spent(open)) {
                needed |= bit;
                let earliest = self.device.earliest(burst, entry.bank);
                if earliest <= clock {
                    choice.column = choice.column.or(Some(index));
                } else {
                    *next = (*next).min(earliest);
                }
            }
        }
        if choice.column.is_some() && !self.numbers.two_buses {
            return choice;
        }
        seen |= needed;
        for (index, entry) in entries.iter().enumerate() {
            let bit = 1 << entry.bank;
            if seen & bit != 0 {
                continue;
            }
            seen |= bit;
            let command = match self.device.open(entry.bank) {
                None => Command::Activate,
                Some(open) if self.is_spent(open) => continue,
                Some(_) => Command::Precharge,
            };
            let earliest = self.device.earliest(command, entry.bank);
            if earliest <= clock {
                choice.row = Some((index, command));
                break;
            }
            *next = (*next).min(earliest);
        }
        choice
    }

    /// With closed pages: a bank whose row is spent, or that no request needs, and that can be closed.
    pub(super) fn unused(&self, clock: u64, next: &mut u64) -> Option<usize> {
        let mut needed = self.held;
        for entry in self.reads.entries().iter().chain(self.writes.entries()) {
            let open = self.device.open(entry.bank);
            if open.is_some_and(|open| open.row == entry.row && !self.is_spent(open)) {
                needed |= 1 << entry.bank;
            }
        }
        for bank in 0..self.device.banks() {
            if needed & 1 << bank == 0 && self.device.open(bank).is_some() {
                let earliest = self.device.earliest(Command::Precharge, bank);
                if earliest <= clock {
                    return Some(bank);
                }
                *next = (*next).min(earliest);
            }
        }
        None
    }
}
