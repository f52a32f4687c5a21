//! The memory behind a machine.

use crate::channel::Channel;
use crate::command::Issued;
use crate::config::{Config, ConfigError};
use crate::controller::{Done, Outputs};
use crate::mapping::Layout;
use crate::queue::{Entry, Outcome};
use crate::statistics::Statistics;
use crate::table::{Constraint, constraints};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// One burst that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Whether it is written.
    pub write: bool,
    /// A byte of the burst; addresses past the capacity begin again at 0.
    pub address: u64,
    /// What [`Dram::pop`] calls a read; of no use for a write.
    pub tag: u32,
    /// Who asks, for the statistics.
    pub client: u8,
}

/// The memory behind a machine: when which data are there, not what they are.
pub struct Dram {
    config: Config,
    layout: Layout,
    channels: Vec<Channel>,
    /// Reads that are on their way: the clock at which they are complete, their number in order of completion, their tag.
    done: BinaryHeap<Reverse<(u64, u64, u32)>>,
    /// How many have been put there.
    answers: u64,
    statistics: Statistics,
    record: Option<Vec<Issued>>,
    /// Device clocks that have gone by.
    now: u64,
    /// Time of the machine that is no whole device clock yet, ps.
    phase_ps: u64,
    /// The first clock at which a channel has something to do.
    wake: u64,
}

impl Dram {
    /// With empty queues and closed rows.
    ///
    /// # Errors
    /// A number of `config` is out of its range, or the part cannot do what it asks for.
    pub fn new(config: Config) -> Result<Dram, ConfigError> {
        config.check()?;
        let table = constraints(&config);
        Ok(Dram::build(config, &table))
    }

    /// The same under rules of one's own instead of [`constraints`].
    ///
    /// # Errors
    /// As [`Dram::new`].
    pub fn with_constraints(config: Config, table: &[Constraint]) -> Result<Dram, ConfigError> {
        config.check()?;
        Ok(Dram::build(config, table))
    }

    fn build(config: Config, table: &[Constraint]) -> Dram {
        let channels = 0..config.channels as usize;
        Dram {
            layout: Layout::new(&config),
            channels: channels.map(|channel| Channel::new(&config, channel, table)).collect(),
            config,
            done: BinaryHeap::new(),
            answers: 0,
            statistics: Statistics::default(),
            record: None,
            now: 0,
            phase_ps: 0,
            wake: 0,
        }
    }

    /// What it was made of.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Which address is where.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Whether a request will be taken in this machine cycle, whatever it asks for: no queue of any channel is full.
    pub fn ready(&self) -> bool {
        !self.channels.iter().any(Channel::is_full)
    }

    /// Asks for one burst; whether it was taken, as it is if the memory is [`ready`](Dram::ready).
    ///
    /// A write is done with here. A read comes back from [`pop`](Dram::pop), once.
    pub fn push(&mut self, request: Request) -> bool {
        if !self.ready() {
            return false;
        }
        let Request { write, address, tag, client } = request;
        let burst = self.layout.burst(address);
        let place = self.layout.place(burst);
        let (bank, row, arrived) = (place.bank, place.row, self.now);
        let entry =
            Entry { burst, client, tag, bank, row, arrived, closed: false, outcome: Outcome::Hit };
        self.statistics.ask(write, client);
        let mut done = |done| answer(&mut self.done, &mut self.answers, done);
        let mut out = Outputs { done: &mut done, statistics: &mut self.statistics, record: None };
        let channel = &mut self.channels[place.channel];
        channel.push(write, place, entry, &mut out);
        self.wake = self.wake.min(channel.wake());
        true
    }

    /// One machine cycle: as many device clocks as have become whole.
    pub fn cycle(&mut self) {
        self.phase_ps += self.config.machine_period_ps;
        let tck_ps = self.config.part.timing.tck_ps;
        let end = self.now + self.phase_ps / tck_ps;
        self.phase_ps %= tck_ps;
        if self.wake < end {
            self.run(end);
        }
        self.now = end;
    }

    fn run(&mut self, end: u64) {
        let mut done = |done| answer(&mut self.done, &mut self.answers, done);
        let statistics = &mut self.statistics;
        let mut out = Outputs { done: &mut done, statistics, record: self.record.as_mut() };
        self.wake = u64::MAX;
        for channel in &mut self.channels {
            channel.run(end, &mut out);
            self.wake = self.wake.min(channel.wake());
        }
    }

    /// The tag of a read whose data are complete, if there is one: of several the one whose data were complete first. Reads
    /// come back in another order than they were asked for. They wait here, any number of them, until they are taken.
    pub fn pop(&mut self) -> Option<u32> {
        let Reverse((clock, _, tag)) = *self.done.peek()?;
        (clock <= self.now).then(|| {
            self.done.pop();
            tag
        })
    }

    /// Whether no request is queued and all reads have been taken.
    pub fn idle(&self) -> bool {
        self.done.is_empty() && self.channels.iter().all(Channel::is_idle)
    }

    /// What was done up to now.
    pub fn statistics(&self) -> Statistics {
        Statistics { clocks: self.now, ..self.statistics.clone() }
    }

    /// Keeps the commands from here on, for [`commands`](Dram::commands).
    pub fn record(&mut self) {
        self.record = Some(vec![]);
    }

    /// The commands that were given since [`record`](Dram::record) or the last call of this; in order within each channel.
    pub fn commands(&mut self) -> Vec<Issued> {
        self.record.as_mut().map(std::mem::take).unwrap_or_default()
    }
}

fn answer(heap: &mut BinaryHeap<Reverse<(u64, u64, u32)>>, answers: &mut u64, done: Done) {
    heap.push(Reverse((done.clock, *answers, done.tag)));
    *answers += 1;
}
