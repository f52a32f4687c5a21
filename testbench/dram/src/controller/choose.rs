//! Which request gets the next command.

use super::{Controller, PAGE_BURSTS};
use crate::command::Command;
use crate::config::Page;
use crate::device::OpenRow;
use crate::queue::{Entry, Queue};

/// The command that moves a burst.
pub(super) fn burst_command(write: bool) -> Command {
    if write { Command::Write } else { Command::Read }
}

/// What may be given in this clock.
pub struct Choice {
    /// The oldest request whose burst can move: whether it is a write, and its index in its queue.
    pub column: Option<(bool, usize)>,
    /// By its index in the queue that is served, the oldest request that needs a row opened or closed, and can have it.
    pub row: Option<(usize, Command)>,
}

impl Controller {
    /// Whether the row is to be closed, whoever needs it.
    fn is_spent(&self, open: OpenRow) -> bool {
        self.page == Page::Closed && open.bursts >= PAGE_BURSTS
    }

    /// The queue of writes, or of reads, and the other one.
    fn queues(&self, write: bool) -> (&Queue, &Queue) {
        if write { (&self.writes, &self.reads) } else { (&self.reads, &self.writes) }
    }

    /// The first clock at which the next command for the request may come.
    pub(super) fn earliest(&self, write: bool, entry: &Entry) -> u64 {
        let (_, other) = self.queues(write);
        let command = match self.device.open(entry.bank) {
            None => Command::Activate,
            Some(open) if open.row == entry.row => burst_command(write),
            Some(_) if other.opened_for(entry.bank).is_some() => burst_command(!write),
            Some(_) => Command::Precharge,
        };
        self.device.earliest(command, entry.bank)
    }

    /// Looks through the queue that is served, or at its head. `next` is lowered to the clock at which what cannot be given
    /// now can be at the earliest.
    ///
    /// All requests of a bank to its open row may have their burst at the same clock, so that the oldest speaks for the others;
    /// while there is one the row stays open. Neither is a row closed that was opened for a request of the other queue, before the
    /// queues changed: that one's burst goes before.
    pub(super) fn choose(
        &self,
        clock: u64,
        write: bool,
        head_only: bool,
        next: &mut u64,
    ) -> Choice {
        let (queue, other) = self.queues(write);
        let (mut banks, among) = match (head_only, queue.entries().first()) {
            (true, Some(head)) => (1 << head.bank, 1),
            _ => (queue.occupied(), u32::MAX),
        };
        banks &= !self.held;
        let burst = burst_command(write);
        // By index, that is by age.
        let (mut column, mut row) = (u32::MAX, (u32::MAX, Command::Activate));
        let mut left = None;
        while banks != 0 {
            let bank = banks.trailing_zeros() as usize;
            banks &= banks - 1;
            let open = self.device.open(bank);
            let spent = open.is_some_and(|open| self.is_spent(open));
            let hits = queue.hits(bank) & among;
            let (command, requests) = match open {
                _ if spent => continue,
                Some(_) if hits != 0 => (burst, hits),
                Some(_) => match other.opened_for(bank) {
                    Some(index) => (burst_command(!write), 1 << index),
                    None => (Command::Precharge, queue.waiting(bank) & among),
                },
                None => (Command::Activate, queue.waiting(bank) & among),
            };
            let oldest = requests.trailing_zeros();
            let earliest = self.device.earliest(command, bank);
            if earliest > clock {
                *next = (*next).min(earliest);
            } else if command == burst {
                column = column.min(oldest);
            } else if command.is_column() {
                left = Some((!write, oldest as usize));
            } else if oldest < row.0 {
                row = (oldest, command);
            }
        }
        Choice {
            column: (column != u32::MAX).then_some((write, column as usize)).or(left),
            row: (row.0 != u32::MAX).then_some((row.0 as usize, row.1)),
        }
    }

    /// With closed pages: a bank whose row is spent, or that no request needs, and that can be closed.
    pub(super) fn unused(&self, clock: u64, next: &mut u64) -> Option<usize> {
        for bank in (0..self.device.banks()).filter(|bank| self.held >> bank & 1 == 0) {
            let Some(open) = self.device.open(bank) else { continue };
            if self.reads.hits(bank) | self.writes.hits(bank) != 0 && !self.is_spent(open) {
                continue;
            }
            let earliest = self.device.earliest(Command::Precharge, bank);
            if earliest <= clock {
                return Some(bank);
            }
            *next = (*next).min(earliest);
        }
        None
    }
}
