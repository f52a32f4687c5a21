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
    /// Its bank behind the data bus.
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

/// A queue. Besides the requests it keeps of each bank which of them are for it, and for its open row, as bits by age.
pub struct Queue {
    entries: Vec<Entry>,
    waiting: Vec<u32>,
    hits: Vec<u32>,
    occupied: u128,
}

impl Queue {
    /// For so many banks, at most 128.
    pub fn new(banks: usize) -> Queue {
        Queue { entries: vec![], waiting: vec![0; banks], hits: vec![0; banks], occupied: 0 }
    }

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

    /// Banks that requests are for, a bit each.
    pub fn occupied(&self) -> u128 {
        self.occupied
    }

    /// Requests for a bank, a bit each: bit 0 is the oldest of the queue.
    pub fn waiting(&self, bank: usize) -> u32 {
        self.waiting[bank]
    }

    /// Those of them that need the row that is open.
    pub fn hits(&self, bank: usize) -> u32 {
        self.hits[bank]
    }

    /// A request for which the row of the bank was opened, and that still needs it.
    pub fn opened_for(&self, bank: usize) -> Option<usize> {
        let mut hits = self.hits[bank];
        while hits != 0 {
            let index = hits.trailing_zeros() as usize;
            if self.entries[index].outcome != Outcome::Hit {
                return Some(index);
            }
            hits &= hits - 1;
        }
        None
    }

    /// Adds the youngest; `hit` says whether its row is open. There must be room.
    pub fn push(&mut self, entry: Entry, hit: bool) {
        let bit = 1 << self.entries.len();
        self.waiting[entry.bank] |= bit;
        self.occupied |= 1 << entry.bank;
        if hit {
            self.hits[entry.bank] |= bit;
        }
        self.entries.push(entry);
    }

    /// Takes one out.
    pub fn remove(&mut self, index: usize) -> Entry {
        let older = (1 << index) - 1;
        for bits in self.waiting.iter_mut().chain(&mut self.hits) {
            *bits = *bits & older | *bits >> 1 & !older;
        }
        let entry = self.entries.remove(index);
        if self.waiting[entry.bank] == 0 {
            self.occupied &= !(1 << entry.bank);
        }
        entry
    }

    /// Another row of the bank is open now, or none.
    pub fn opened(&mut self, bank: usize, row: Option<u64>) {
        self.hits[bank] = 0;
        let mut waiting = if row.is_some() { self.waiting[bank] } else { 0 };
        while waiting != 0 {
            let index = waiting.trailing_zeros();
            waiting &= waiting - 1;
            if Some(self.entries[index as usize].row) == row {
                self.hits[bank] |= 1 << index;
            }
        }
    }

    /// Notes that another row was closed for one.
    pub fn note_closed(&mut self, index: usize) {
        self.entries[index].closed = true;
    }

    /// Notes that a row was opened for one.
    pub fn note_opened(&mut self, index: usize) {
        let entry = &mut self.entries[index];
        entry.outcome = if entry.closed { Outcome::Conflict } else { Outcome::Miss };
    }

    /// Whether one is for this burst.
    pub fn has(&self, burst: u64) -> bool {
        self.entries.iter().any(|entry| entry.burst == burst)
    }
}
