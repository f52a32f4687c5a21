//! A channel: its command buses, and behind them a controller for each data bus.

use crate::command::Command;
use crate::config::Config;
use crate::controller::{Controller, Outputs};
use crate::mapping::Place;
use crate::part::CommandBuses;
use crate::queue::Entry;
use crate::table::Constraint;

/// The command buses of a channel in one clock.
pub struct Buses {
    two: bool,
    row: bool,
    column: bool,
    retry: u64,
}

impl Buses {
    fn new(kind: CommandBuses, clock: u64) -> Buses {
        Buses { two: kind == CommandBuses::RowAndColumn, row: true, column: true, retry: clock + 1 }
    }

    /// Whether row commands have a bus of their own.
    pub fn has_two(&self) -> bool {
        self.two
    }

    /// Whether the command has its bus. It, or others, may come in the next clock: `next` is lowered to that.
    pub fn take(&mut self, command: Command, next: &mut u64) -> bool {
        *next = (*next).min(self.retry);
        let free = if command.is_column() { self.column } else { self.row };
        if free {
            self.row &= self.two && command.is_column();
            self.column &= self.two && !command.is_column();
        }
        free
    }
}

/// A channel.
pub struct Channel {
    kind: CommandBuses,
    /// Banks of each data bus.
    banks: usize,
    controllers: Vec<Controller>,
    /// The clock of the next step; nothing happens before.
    wake: u64,
}

impl Channel {
    /// The channel of that number, under the rules of `table`.
    pub fn new(config: &Config, channel: usize, table: &[Constraint]) -> Channel {
        let o = &config.part.organisation;
        let pseudo = 0..o.pseudo_channels as usize;
        Channel {
            kind: o.command_buses,
            banks: config.banks() as usize,
            controllers: pseudo.map(|p| Controller::new(config, channel, p, table)).collect(),
            wake: 0,
        }
    }

    /// Whether a queue is full.
    pub fn is_full(&self) -> bool {
        self.controllers.iter().any(Controller::is_full)
    }

    /// Whether nothing waits.
    pub fn is_idle(&self) -> bool {
        self.controllers.iter().all(Controller::is_idle)
    }

    /// The clock of the next step.
    pub fn wake(&self) -> u64 {
        self.wake
    }

    /// Takes a request for `place`; it must not be full.
    pub fn push(&mut self, write: bool, place: Place, entry: Entry, out: &mut Outputs) {
        let controller = &mut self.controllers[place.bank / self.banks];
        controller.push(write, Entry { bank: place.bank % self.banks, ..entry }, out);
        self.wake = self.wake.min(controller.wake());
    }

    /// Runs until before `end`.
    pub fn run(&mut self, end: u64, out: &mut Outputs) {
        while self.wake < end {
            let clock = self.wake;
            let mut buses = Buses::new(self.kind, clock);
            let count = self.controllers.len();
            // In turn each is the first to have the buses.
            let (late, early) = self.controllers.split_at_mut(clock as usize % count);
            for controller in early.iter_mut().chain(late) {
                if controller.wake() <= clock {
                    controller.step(clock, &mut buses, out);
                }
            }
            self.wake = self.controllers.iter().map(Controller::wake).min().unwrap_or(u64::MAX);
        }
    }
}
