//! Synchronous memories.
//!
//! ```text
//!            Ram1R1W                        Ram1RW
//!          +---------+                    +---------+
//!  read -->| en addr |                    |         |
//!          |         |--> Read    port -->| en addr |--> Read
//!  write ->| en addr |    valid           | write   |    valid
//!          | data    |    data            | data    |    data
//!          +---------+                    +---------+
//! ```
//! A read asked for in cycle `t` shows its data, with `valid` high, in cycle `t + latency`. Reads
//! are pipelined: one a cycle. With latency 1 the data stays (with `valid` low) until the next
//! read; a block that stalls finds it again. A write asked for in `t` is in the memory from `t + 1`
//! on. What a read of the same word in the same cycle as its write gives is stated by
//! [`ReadDuringWrite`].

mod cells;
pub mod port;

pub use port::{Port, ReadPort, WritePort};

use crate::memory::{FaultKind, Memory, Ports, ReadDuringWrite, Storage, StorageInfo};
use crate::signals::{Declare, Signals, width_of};
use cells::Cells;
use pellucid_sim_derive::Signals;
use std::collections::TryReserveError;

/// What a memory shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(T::Config)]
pub struct Read<T> {
    /// High for the cycle in which a read's data arrives.
    pub valid: bool,
    /// The data.
    #[with(*cfg)]
    pub data: T,
}

/// The words, their traffic and their faults: what both kinds of memory share.
struct Words<T: Signals> {
    /// The words up to the highest that was written; those beyond hold what they held at power-up.
    words: Cells<T>,
    size: u32,
    /// What a word's widths depend on.
    item: T::Config,
    latency: u32,
    outside: bool,
    reads: u64,
    writes: u64,
    /// The most words of use that it was told of, if it was told of any.
    peak: Option<u32>,
    /// Which words were ever written; kept in debug builds only.
    written: Vec<bool>,
    fault: Option<FaultKind>,
    /// Data on its way: entry `k` of a ring of `latency - 1`.
    line: Vec<Read<T>>,
    line_at: usize,
    /// What the last read gave, with a line.
    held: T,
    q: Read<T>,
    /// Something is asked, shown as valid or under way: else the edge changes nothing.
    busy: bool,
}

impl<T: Signals + Default> Words<T> {
    fn new(words: u32, item: T::Config, latency: u32) -> Words<T> {
        assert!(latency >= 1, "a synchronous memory answers after one cycle at the earliest");
        let known = if cfg!(debug_assertions) { words as usize } else { 0 };
        Words {
            words: Cells::new(&item),
            size: words,
            item,
            latency,
            outside: false,
            reads: 0,
            writes: 0,
            peak: None,
            written: vec![false; known],
            fault: None,
            line: vec![Read::default(); latency as usize - 1],
            line_at: 0,
            held: T::default(),
            q: Read::default(),
            busy: false,
        }
    }

    fn leave_out(&mut self) {
        self.size = 0;
        self.written.clear();
    }

    fn count_anew(&mut self) {
        (self.reads, self.writes) = (0, 0);
        self.peak = self.peak.map(|_| 0);
    }

    #[inline(always)]
    fn holds(&mut self, words: u32) {
        self.peak = self.peak.max(Some(words));
    }

    #[cold]
    fn fail(&mut self, kind: FaultKind) {
        self.fault.get_or_insert(kind);
    }

    /// Whether there is a word of that address.
    fn check(&mut self, addr: u32) -> bool {
        let inside = addr < self.size;
        if !inside {
            self.fail(FaultKind::Address { addr, words: u64::from(self.size) });
        }
        inside
    }

    /// Writes a word beyond those written so far. Memory is taken a page or so at a time: a model's
    /// memories may be far larger than what a frame uses of them.
    #[cold]
    fn grow(&mut self, addr: u32, data: T) {
        const STEP: u32 = 1024;
        if self.check(addr) {
            let len = addr.saturating_add(STEP).min(self.size);
            self.words.resize(len as usize);
            self.words.set(&self.item, addr, data);
        }
    }

    /// Shows the word at `addr`.
    #[inline(always)]
    fn load(&mut self, addr: u32) {
        self.reads += 1;
        if cfg!(debug_assertions) && !self.written.get(addr as usize).is_none_or(|written| *written)
        {
            self.fail(FaultKind::Unwritten(addr));
        }
        if !self.words.get(&self.item, addr, &mut self.q.data) {
            self.check(addr);
            self.q.data = T::default();
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store(&mut self, addr: u32, data: T) {
        self.writes += 1;
        if cfg!(debug_assertions)
            && let Err(overflow) = data.check(&self.item)
        {
            self.fail(FaultKind::Overflow(overflow));
        }
        if !self.words.set(&self.item, addr, data) {
            self.grow(addr, data);
        }
        if cfg!(debug_assertions)
            && let Some(written) = self.written.get_mut(addr as usize)
        {
            *written = true;
        }
    }

    /// Nothing is under way any more.
    fn reset(&mut self) {
        self.q.valid = false;
        for read in &mut self.line {
            read.valid = false;
        }
        self.busy = !self.line.is_empty();
    }

    /// The read data moves on by one cycle, in which the word at `read` is asked for, if one is. What is read goes to where it is shown
    /// at once: a copy on the way would be waited for wherever the word is in none of the processor's caches.
    #[inline(always)]
    fn advance(&mut self, read: Option<u32>) {
        if let Some(addr) = read {
            self.load(addr);
        }
        self.q.valid = read.is_some();
        if self.line.is_empty() {
            self.busy = read.is_some();
        } else {
            self.pipeline();
        }
    }

    fn pipeline(&mut self) {
        let mut new = self.q;
        if new.valid {
            self.held = new.data;
        }
        new.data = self.held;
        self.q = std::mem::replace(&mut self.line[self.line_at], new);
        self.line_at = (self.line_at + 1) % self.line.len();
    }

    fn peek(&self, addr: u32, to: &mut Vec<u64>) {
        let mut word = T::default();
        self.words.get(&self.item, addr, &mut word);
        word.sample(&self.item, to);
    }

    fn under_way(&self, to: &mut Vec<u64>) {
        let Words { item, q, line, line_at, .. } = self;
        q.sample(item, to);
        for k in 0..line.len() {
            line[(line_at + k) % line.len()].sample(item, to);
        }
    }

    fn info(&self, ports: Ports, read_during_write: ReadDuringWrite) -> StorageInfo {
        StorageInfo {
            ports,
            read_during_write,
            latency: self.latency,
            outside: self.outside,
            words: u64::from(self.size),
            bits_per_word: width_of::<T>(&self.item),
            reads: self.reads,
            writes: self.writes,
            peak_words: self.peak.map(u64::from),
        }
    }
}

/// A memory with one read port and one write port. Use [`Ram1RW`] where reads and writes never
/// share a cycle: it is cheaper to build.
pub struct Ram1R1W<T: Signals> {
    core: Words<T>,
    policy: ReadDuringWrite,
    read: ReadPort,
    write: WritePort<T>,
}

impl<T: Signals + Default> Ram1R1W<T> {
    /// `words` words whose widths depend on `item`; a read takes `latency` cycles, at least 1.
    pub fn new(words: u32, item: T::Config, latency: u32, policy: ReadDuringWrite) -> Ram1R1W<T> {
        let (read, write) = (ReadPort::default(), WritePort::default());
        Ram1R1W { core: Words::new(words, item, latency), policy, read, write }
    }
    /// What it shows in this cycle.
    #[inline(always)]
    pub fn q(&self) -> Read<T> {
        self.core.q
    }
    /// Asks for the word at `addr`.
    #[inline(always)]
    pub fn read(&mut self, addr: u32) {
        self.read.read(addr);
        self.core.busy = true;
    }
    /// Asks for `data` to be put at `addr`.
    #[inline(always)]
    pub fn write(&mut self, addr: u32, data: T) {
        self.write.write(addr, data);
        self.core.busy = true;
    }
    /// Tells how many of its words hold something of use, for the high-water mark that it keeps. No hardware.
    #[inline(always)]
    pub fn holds(&mut self, words: u32) {
        self.core.holds(words);
    }
    /// Asks its read port for what another block asks, if anything.
    #[inline(always)]
    pub fn pass_read(&mut self, user: ReadPort) {
        if user.en {
            self.read(user.addr);
            self.read.twice |= user.twice;
        }
    }
    /// Asks its write port for what another block asks, if anything.
    #[inline(always)]
    pub fn pass_write(&mut self, user: WritePort<T>) {
        if user.en {
            self.write(user.addr, user.data);
            self.write.twice |= user.twice;
        }
    }
    /// Asks that of its two ports which does it for what another block asks, if anything.
    #[inline(always)]
    pub fn pass(&mut self, user: Port<T>) {
        if !user.en {
            return;
        }
        if user.write {
            self.write(user.addr, user.data);
            self.write.twice |= user.twice;
        } else {
            self.read(user.addr);
            self.read.twice |= user.twice;
        }
    }

    /// The edge of one that is busy. With debug assertions it is long: a function, which is compiled once for each kind of word.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn edge(&mut self) -> bool {
        let Ram1R1W { core, policy, read, write } = self;
        if read.twice || write.twice {
            core.fail(FaultKind::PortUsedTwice(if read.twice { "read" } else { "write" }));
        }
        if cfg!(debug_assertions)
            && *policy == ReadDuringWrite::Forbidden
            && read.en
            && write.en
            && read.addr == write.addr
        {
            core.fail(FaultKind::ReadDuringWrite(read.addr));
        }
        // Whether a read sees the write of its cycle is the order of the two.
        let write_first = *policy != ReadDuringWrite::Old;
        if write_first && write.en {
            core.store(write.addr, write.data);
        }
        core.advance(read.en.then_some(read.addr));
        if !write_first && write.en {
            core.store(write.addr, write.data);
        }
        (read.en, read.twice, write.en, write.twice) = (false, false, false, false);
        core.fault.is_some()
    }
}

impl<T: Signals + Default> Memory for Ram1R1W<T> {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        self.core.busy && self.edge()
    }

    fn reset(&mut self) {
        self.core.reset();
        (self.read, self.write) = (ReadPort::default(), WritePort::default());
    }

    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        to(path, self);
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        to(self);
    }
}

/// A memory with one port that reads or writes.
pub struct Ram1RW<T: Signals> {
    core: Words<T>,
    port: Port<T>,
}

impl<T: Signals + Default> Ram1RW<T> {
    /// `words` words whose widths depend on `item`; a read takes `latency` cycles, at least 1.
    pub fn new(words: u32, item: T::Config, latency: u32) -> Ram1RW<T> {
        Ram1RW { core: Words::new(words, item, latency), port: Port::default() }
    }
    /// The same memory outside of the chip.
    #[must_use]
    pub fn outside(mut self) -> Ram1RW<T> {
        self.core.outside = true;
        self
    }
    /// What it shows in this cycle.
    #[inline(always)]
    pub fn q(&self) -> Read<T> {
        self.core.q
    }
    /// Asks for the word at `addr`.
    #[inline(always)]
    pub fn read(&mut self, addr: u32) {
        self.port.read(addr);
        self.core.busy = true;
    }
    /// Asks for `data` to be put at `addr`.
    #[inline(always)]
    pub fn write(&mut self, addr: u32, data: T) {
        self.port.write(addr, data);
        self.core.busy = true;
    }
    /// Tells how many of its words hold something of use, for the high-water mark that it keeps. No hardware.
    #[inline(always)]
    pub fn holds(&mut self, words: u32) {
        self.core.holds(words);
    }
    /// Asks for what another block asks, if anything.
    #[inline(always)]
    pub fn pass(&mut self, user: Port<T>) {
        if !user.en {
            return;
        }
        if user.write {
            self.write(user.addr, user.data);
        } else {
            self.read(user.addr);
        }
        self.port.twice |= user.twice;
    }

    /// The edge of one that is busy. With debug assertions it is long: a function, which is compiled once for each kind of word.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn edge(&mut self) -> bool {
        let Ram1RW { core, port } = self;
        if port.twice {
            core.fail(FaultKind::PortUsedTwice("only"));
        }
        if port.en && port.write {
            core.store(port.addr, port.data);
        }
        core.advance((port.en && !port.write).then_some(port.addr));
        (port.en, port.twice, port.write) = (false, false, false);
        core.fault.is_some()
    }
}

impl<T: Signals + Default> Memory for Ram1RW<T> {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        self.core.busy && self.edge()
    }

    fn reset(&mut self) {
        self.core.reset();
        self.port = Port::default();
    }

    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        to(path, self);
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        to(self);
    }
}

impl<T: Signals + Default> Storage for Ram1R1W<T> {
    fn info(&self) -> StorageInfo {
        self.core.info(Ports::OneReadOneWrite, self.policy)
    }
    fn word(&self, name: &str, to: &mut dyn Declare) {
        T::declare(&self.core.item, name, to);
    }
    fn peek(&self, addr: u32, to: &mut Vec<u64>) {
        self.core.peek(addr, to);
    }
    fn busy(&self) -> bool {
        self.core.busy
    }
    fn under_way(&self, to: &mut Vec<u64>) {
        self.core.under_way(to);
    }
    fn take_fault(&mut self) -> Option<FaultKind> {
        self.core.fault.take()
    }
    fn count_anew(&mut self) {
        self.core.count_anew();
    }
    fn leave_out(&mut self) {
        self.core.leave_out();
    }
    fn reserve(&mut self) -> Result<(), TryReserveError> {
        self.core.words.reserve(self.core.size as usize)
    }
}

impl<T: Signals + Default> Storage for Ram1RW<T> {
    fn info(&self) -> StorageInfo {
        self.core.info(Ports::One, ReadDuringWrite::Forbidden)
    }
    fn word(&self, name: &str, to: &mut dyn Declare) {
        T::declare(&self.core.item, name, to);
    }
    fn peek(&self, addr: u32, to: &mut Vec<u64>) {
        self.core.peek(addr, to);
    }
    fn busy(&self) -> bool {
        self.core.busy
    }
    fn under_way(&self, to: &mut Vec<u64>) {
        self.core.under_way(to);
    }
    fn take_fault(&mut self) -> Option<FaultKind> {
        self.core.fault.take()
    }
    fn count_anew(&mut self) {
        self.core.count_anew();
    }
    fn leave_out(&mut self) {
        self.core.leave_out();
    }
    fn reserve(&mut self) -> Result<(), TryReserveError> {
        self.core.words.reserve(self.core.size as usize)
    }
}

#[cfg(test)]
mod tests;
