//! The controller of a data bus: that of a channel, or of a pseudo-channel. It gives commands as the rules and the command buses
//! let it, and sleeps until the next clock at which one may come.

mod choose;

use crate::channel::Buses;
use crate::command::{Command, Issued};
use crate::config::{Config, Page, Refresh, Scheduler};
use crate::device::Device;
use crate::queue::{Entry, HIGH, LOW, Outcome, Queue};
use crate::refresh::{Due, Timer};
use crate::statistics::Statistics;
use crate::table::Constraint;

/// After how many bursts a closed page is closed.
const PAGE_BURSTS: u32 = 4;

/// A read whose data are complete at `clock`.
pub struct Done {
    /// When, device clocks.
    pub clock: u64,
    /// The read's name.
    pub tag: u32,
}

/// What a controller tells.
pub struct Outputs<'a> {
    /// Reads that will be complete.
    pub done: &'a mut dyn FnMut(Done),
    /// What is counted.
    pub statistics: &'a mut Statistics,
    /// The commands, where they are wanted.
    pub record: Option<&'a mut Vec<Issued>>,
}

/// Constants of the part that the controller needs.
struct Numbers {
    cl: u64,
    burst: u64,
    burst_bytes: u64,
    /// After which time a request is served before all others: an interval between refreshes.
    patience: u64,
    rank_banks: usize,
    per_bank: bool,
}

/// The controller of one data bus.
pub struct Controller {
    channel: usize,
    /// The number of its first bank in the channel.
    first_bank: usize,
    device: Device,
    timer: Timer,
    reads: Queue,
    writes: Queue,
    draining: bool,
    scheduler: Scheduler,
    page: Page,
    numbers: Numbers,
    /// Banks that take no more requests before they are refreshed, a bit each.
    held: u128,
    /// The clock of the next step; nothing happens before.
    wake: u64,
}

impl Controller {
    /// Of that pseudo-channel of that channel, under the rules of `table`.
    pub fn new(config: &Config, channel: usize, pseudo: usize, table: &[Constraint]) -> Controller {
        let (o, t) = (&config.part.organisation, &config.part.timing);
        let banks = config.banks() as usize;
        Controller {
            channel,
            first_bank: pseudo * banks,
            device: Device::new(config, table),
            timer: Timer::new(config),
            reads: Queue::new(banks),
            writes: Queue::new(banks),
            draining: false,
            scheduler: config.scheduler,
            page: config.page,
            numbers: Numbers {
                cl: t.cl,
                burst: t.burst,
                burst_bytes: o.burst_bytes(),
                patience: t.refi,
                rank_banks: o.rank_banks(),
                per_bank: config.refresh == Refresh::PerBank,
            },
            held: 0,
            wake: 0,
        }
    }

    /// Whether either queue is full.
    pub fn is_full(&self) -> bool {
        self.reads.is_full() || self.writes.is_full()
    }

    /// Whether nothing waits.
    pub fn is_idle(&self) -> bool {
        self.reads.is_empty() && self.writes.is_empty()
    }

    /// The clock of the next step.
    pub fn wake(&self) -> u64 {
        self.wake
    }

    /// Takes a request; it must not be full.
    pub fn push(&mut self, write: bool, entry: Entry, out: &mut Outputs) {
        if self.writes.has(entry.burst) {
            if write {
                out.statistics.writes_coalesced += 1;
            } else {
                out.statistics.reads_forwarded += 1;
                self.answer(&entry, entry.arrived + 1, out);
            }
            return;
        }
        let hit = self.device.open(entry.bank).is_some_and(|open| open.row == entry.row);
        let queue = if write { &mut self.writes } else { &mut self.reads };
        queue.push(entry, hit);
        let turn = if write { queue.len() == HIGH } else { queue.len() == 1 };
        // Which queue is served can change only at such a turn. Else nothing can come before the new request's own command.
        let next = if turn { 0 } else { self.earliest(write, &entry) };
        self.wake = self.wake.min(next.max(entry.arrived));
    }

    fn answer(&self, entry: &Entry, clock: u64, out: &mut Outputs) {
        let latency = clock - entry.arrived;
        out.statistics.read_latency_clocks += latency;
        out.statistics.client(entry.client).read_latency_clocks += latency;
        (out.done)(Done { clock, tag: entry.tag });
    }

    /// Does what is to be done at `clock`, as far as the command buses are free.
    pub fn step(&mut self, clock: u64, buses: &mut Buses, out: &mut Outputs) {
        let mut next = u64::MAX;
        self.refresh(clock, &mut next, buses, out);
        let (write, head_only) = self.mode(clock, out);
        let choice = self.choose(clock, write, head_only, &mut next);
        // The row command first where there is a bus for each: it names its request by the index that the burst's going would
        // change. Where there is one for both, a burst goes before.
        if choice.column.is_none() || buses.has_two() {
            if let Some((index, command)) = choice.row {
                if buses.take(command, &mut next) {
                    self.row(write, index, command, clock, out);
                }
            } else if self.page == Page::Closed
                && let Some(bank) = self.unused(clock, &mut next)
                && buses.take(Command::Precharge, &mut next)
            {
                self.issue(Command::Precharge, bank, 0, clock, out);
            }
        }
        if let Some((write, index)) = choice.column
            && buses.take(choose::burst_command(write), &mut next)
        {
            self.column(write, index, clock, out);
        }
        self.wake = next.min(self.timer.next()).max(clock + 1);
    }

    /// Which queue is served, whether of it the oldest request alone.
    fn mode(&mut self, clock: u64, out: &mut Outputs) -> (bool, bool) {
        if self.writes.len() >= HIGH && !self.draining {
            self.draining = true;
            out.statistics.drains += 1;
        } else if self.writes.len() <= LOW {
            self.draining = false;
        }
        let waited =
            |queue: &Queue| queue.entries().first().map_or(0, |entry| clock - entry.arrived);
        let (read, write) = (waited(&self.reads), waited(&self.writes));
        if read.max(write) > self.numbers.patience {
            return (write > read, true);
        }
        (self.draining || self.reads.is_empty(), self.scheduler == Scheduler::Fcfs)
    }

    /// Brings banks that are due nearer to their refresh.
    fn refresh(&mut self, clock: u64, next: &mut u64, buses: &mut Buses, out: &mut Outputs) {
        self.held = 0;
        if self.timer.next() > clock {
            return;
        }
        let mut ready: Option<(Command, Due)> = None;
        for due in self.timer.due(clock) {
            let mut banks = due.bank..due.bank + due.banks;
            banks.clone().for_each(|bank| self.held |= 1 << bank);
            let open = banks.any(|bank| self.device.open(bank).is_some());
            let command = match (open, self.numbers.per_bank) {
                (true, true) => Command::Precharge,
                (true, false) => Command::PrechargeAll,
                (false, true) => Command::RefreshBank,
                (false, false) => Command::Refresh,
            };
            let earliest = self.device.earliest(command, due.bank);
            if earliest > clock {
                *next = (*next).min(earliest);
            } else if ready.is_none() {
                ready = Some((command, due));
            }
        }
        if let Some((command, due)) = ready
            && buses.take(command, next)
        {
            self.issue(command, due.bank, 0, clock, out);
            if matches!(command, Command::Refresh | Command::RefreshBank) {
                self.timer.done(due);
            }
        }
    }

    fn column(&mut self, write: bool, index: usize, clock: u64, out: &mut Outputs) {
        let entry = if write { self.writes.remove(index) } else { self.reads.remove(index) };
        self.issue(choose::burst_command(write), entry.bank, entry.row, clock, out);
        let statistics = &mut *out.statistics;
        match entry.outcome {
            Outcome::Hit => statistics.row_hits += 1,
            Outcome::Miss => statistics.row_misses += 1,
            Outcome::Conflict => statistics.row_conflicts += 1,
        }
        statistics.busy_bus_clocks += self.numbers.burst;
        let waited = clock - entry.arrived;
        if write {
            statistics.bytes_written += self.numbers.burst_bytes;
            statistics.write_queue_clocks += waited;
        } else {
            statistics.bytes_read += self.numbers.burst_bytes;
            statistics.read_queue_clocks += waited;
            self.answer(&entry, clock + self.numbers.cl + self.numbers.burst, out);
        }
    }

    fn row(&mut self, write: bool, index: usize, command: Command, clock: u64, out: &mut Outputs) {
        let queue = if write { &mut self.writes } else { &mut self.reads };
        let Entry { bank, row, .. } = queue.entries()[index];
        match command {
            Command::Precharge => queue.note_closed(index),
            _ => queue.note_opened(index),
        }
        self.issue(command, bank, row, clock, out);
    }

    fn issue(&mut self, command: Command, bank: usize, row: u64, clock: u64, out: &mut Outputs) {
        self.device.issue(command, bank, row, clock);
        match command {
            Command::Activate => {
                out.statistics.activates += 1;
                self.opened(bank, Some(row));
            }
            Command::Precharge => {
                out.statistics.precharges += 1;
                self.opened(bank, None);
            }
            Command::PrechargeAll => {
                out.statistics.precharges += 1;
                (bank..bank + self.numbers.rank_banks).for_each(|bank| self.opened(bank, None));
            }
            Command::Refresh | Command::RefreshBank => out.statistics.refreshes += 1,
            Command::Read | Command::Write => {}
        }
        if let Some(record) = &mut out.record {
            let bank = self.first_bank + bank;
            record.push(Issued { clock, command, channel: self.channel, bank, row });
        }
    }

    fn opened(&mut self, bank: usize, row: Option<u64>) {
        self.reads.opened(bank, row);
        self.writes.opened(bank, row);
    }
}
