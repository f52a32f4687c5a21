//! A queue of requests that wait for their burst, oldest first.

/// What it took to serve a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing: its row was open.
    Hit,
    /// An activate.
    Miss,
    /// A precharge of another row, and an activate.
    Conflict,
}

/// A request that waits.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Its burst, as a number.
    pub burst: u64,
    /// Who asked.
    pub client: u8,
    /// The name of a read.
    pub tag: u32,
    /// Its bank of the channel.
    pub bank: usize,
    /// Its row.
    pub row: u64,
    /// The device clock at which it came.
    pub arrived: u64,
    /// Whether another row was closed for it.
    pub closed: bool,
    /// What it has taken so far.
    pub outcome: Outcome,
}

/// Requests that a queue holds.
pub const CAPACITY: usize = 32;
/// At this many writes they are drained: 0.8 of the queue.
pub const HIGH: usize = 26;
/// At this few writes draining ends: 0.2 of the queue.
pub const LOW: usize = 6;

/// A queue.
#[derive(Default)]
pub struct Queue {
    entries: Vec<Entry>,
}

impl Queue {
    /// The requests, oldest first.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Whether no more fit.
    pub fn is_full(&self) -> bool {
        self.entries.len() >= CAPACITY
    }

    /// Adds the youngest.
    pub fn push(&mut self, entry: Entry) {
        self.entries.push(entry);
    }

    /// Takes one out.
    pub fn remove(&mut self, index: usize) -> Entry {
        self.entries.remove(index)
    }

    /// Another row was closed for one.
    pub fn closed(&mut self, index: usize) {
        self.entries[index].closed = true;
    }

    /// A row was opened for one.
    pub fn opened(&mut self, index: usize) {
        let entry = &mut self.entries[index];
        entry.outcome = if entry.closed { Outcome::Conflict } else { Outcome::Miss };
    }

    /// Whether one is for this burst.
    pub fn has(&self, burst: u64) -> bool {
        self.entries.iter().any(|entry| entry.burst == burst)
    }
}
