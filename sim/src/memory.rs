//! What a memory is to the clock: requests are gathered on its ports, and carried out on the edge.
//!
//! During a cycle a block sees the read data of its memories, which are registers, and asks their
//! ports for accesses; [`Memory::clock`] carries them out. `#[derive(Memory)]` makes a struct of
//! memories one memory, so that a parent nests its children's.

use crate::signals::Declare;
use std::collections::TryReserveError;
use std::fmt;
use std::ops::{Deref, DerefMut};

/// A memory, or a struct of them.
pub trait Memory {
    /// The clock edge. True if a port was misused: the fault stays with the memory until
    /// [`Storage::take_fault`].
    fn clock(&mut self) -> bool;
    /// Reset: the words stay, what is asked for or under way is forgotten.
    fn reset(&mut self);
    /// Calls `to` for each memory with its path below `path`.
    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage));
    /// Calls `to` for each memory, in the order of [`Memory::visit`].
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage));
}

impl Memory for () {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        false
    }
    fn reset(&mut self) {}
    fn visit(&mut self, _: &str, _: &mut dyn FnMut(&str, &mut dyn Storage)) {}
    fn each(&mut self, _: &mut dyn FnMut(&mut dyn Storage)) {}
}

/// The memories of several blocks of one kind, each under its number.
impl<M: Memory> Memory for Vec<M> {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        self.iter_mut().fold(false, |fault, memory| fault | memory.clock())
    }
    fn reset(&mut self) {
        self.iter_mut().for_each(Memory::reset);
    }
    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        for (k, memory) in self.iter_mut().enumerate() {
            memory.visit(&format!("{path}[{k}]"), to);
        }
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        self.iter_mut().for_each(|memory| memory.each(to));
    }
}

/// The memories of a child that does not exist in every configuration: where it does not they have no words, and are not
/// clocked.
pub struct Optional<M> {
    exists: bool,
    memories: M,
}

impl<M: Memory> Optional<M> {
    /// These memories, of a child that exists or does not.
    pub fn new(mut memories: M, exists: bool) -> Optional<M> {
        if !exists {
            memories.each(&mut |memory| memory.leave_out());
        }
        Optional { exists, memories }
    }
}

impl<M> Deref for Optional<M> {
    type Target = M;
    #[inline(always)]
    fn deref(&self) -> &M {
        &self.memories
    }
}

impl<M> DerefMut for Optional<M> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut M {
        &mut self.memories
    }
}

impl<M: Memory> Memory for Optional<M> {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        self.exists && self.memories.clock()
    }
    fn reset(&mut self) {
        self.memories.reset();
    }
    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        self.memories.visit(path, to);
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        self.memories.each(to);
    }
}

/// One physical memory.
pub trait Storage {
    /// Size and traffic.
    fn info(&self) -> StorageInfo;
    /// Declares the signals of a word, under a name.
    fn word(&self, name: &str, to: &mut dyn Declare);
    /// Tells the values of the word at `addr`, in the order of [`Storage::word`]; 0 if there is none.
    fn peek(&self, addr: u32, to: &mut Vec<u64>);
    /// Something is asked, shown as valid or under way: else the edge changes nothing.
    fn busy(&self) -> bool;
    /// Tells what it shows and what is on its way, as far as no word holds it.
    fn under_way(&self, to: &mut Vec<u64>);
    /// The first misuse since the last call, if any.
    fn take_fault(&mut self) -> Option<FaultKind>;
    /// Counts traffic and words in use from here on.
    fn count_anew(&mut self);
    /// Takes away all of its words, at power-up: there is no such memory.
    fn leave_out(&mut self);
    /// Makes room for all of its words, at power-up; else room is made as they are written.
    ///
    /// # Errors
    /// The computer has none.
    fn reserve(&mut self) -> Result<(), TryReserveError>;
}

/// What ports a memory has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ports {
    /// One read port and one write port.
    OneReadOneWrite,
    /// One port that reads or writes.
    One,
}

/// What a read gives that meets a write of the same word in the same cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadDuringWrite {
    /// The word as it was.
    Old,
    /// The word as it is written.
    New,
    /// The design promises that it does not happen; in debug builds it is reported as a fault.
    Forbidden,
}

/// Size, ports and traffic of one memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StorageInfo {
    /// Its ports.
    pub ports: Ports,
    /// What a read gives that meets a write; with one port they do not meet.
    pub read_during_write: ReadDuringWrite,
    /// From a read request to its data, in cycles.
    pub latency: u32,
    /// It is not on the chip.
    pub outside: bool,
    /// How many words it has.
    pub words: u64,
    /// Bits of a word.
    pub bits_per_word: u32,
    /// Words read since counting began.
    pub reads: u64,
    /// Words written since counting began.
    pub writes: u64,
    /// The most words that held something of use at once, where the block that has the memory says so.
    pub peak_words: Option<u64>,
}

impl StorageInfo {
    /// Bits of all words.
    pub fn bits(&self) -> u64 {
        self.words * u64::from(self.bits_per_word)
    }
}

/// A misuse of hardware that a model must not contain: a bug in a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Where: the path of the memory or register.
    pub path: String,
    /// When: the cycle, counted from 0 at the start of the simulation.
    pub cycle: u64,
    /// What.
    pub kind: FaultKind,
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// A port was used twice in one cycle.
    PortUsedTwice(&'static str),
    /// An address beyond the last word.
    Address {
        /// The address that was asked for.
        addr: u32,
        /// How many words there are.
        words: u64,
    },
    /// A word was read before it was ever written (checked in debug builds).
    Unwritten(u32),
    /// Read and write of one word in one cycle, in a memory that does not allow it (checked in debug
    /// builds).
    ReadDuringWrite(u32),
    /// A register or a word that is written holds more than its bits can (checked in debug builds).
    Overflow(crate::Overflow),
}

impl Fault {
    /// A register or wire that held too much in `cycle`.
    pub fn overflow(cycle: u64, overflow: crate::Overflow) -> Fault {
        Fault { path: overflow.path.clone(), cycle, kind: FaultKind::Overflow(overflow) }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "cycle {}: ", self.cycle)?;
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        match &self.kind {
            FaultKind::PortUsedTwice(port) => write!(f, "its {port} port was used twice"),
            FaultKind::Address { addr, words } => {
                write!(f, "address {addr} is beyond its {words} words")
            }
            FaultKind::Unwritten(addr) => write!(f, "word {addr} was read before it was written"),
            FaultKind::ReadDuringWrite(addr) => {
                write!(f, "word {addr} was read and written at once, which it does not allow")
            }
            FaultKind::Overflow(overflow) => overflow.fmt(f),
        }
    }
}

impl std::error::Error for Fault {}

/// `a.b`, or the one that is not empty.
pub fn join(a: &str, b: &str) -> String {
    match (a, b) {
        ("", x) | (x, "") => x.to_string(),
        _ => format!("{a}.{b}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_names_the_memory_if_it_has_a_name() {
        let kind = FaultKind::PortUsedTwice("read");
        let said =
            |path: &str| Fault { path: path.into(), cycle: 7, kind: kind.clone() }.to_string();
        assert_eq!(said("queue.outside"), "cycle 7: queue.outside: its read port was used twice");
        assert_eq!(said(""), "cycle 7: its read port was used twice");
    }
}
