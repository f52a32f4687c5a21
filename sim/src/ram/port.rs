//! Requests on the ports of memories: what a block asks in a cycle.

use crate::Stream;
use pellucid_sim_derive::{Signals, rtl};

/// A request on a read port. One a cycle. Its width is that of an address.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(u32)]
pub struct ReadPort {
    pub(super) en: bool,
    #[unseen]
    pub(super) twice: bool,
    #[width(*cfg)]
    pub(super) addr: u32,
}

impl ReadPort {
    /// Asks for the word at `addr`.
    #[inline(always)]
    pub fn read(&mut self, addr: u32) {
        self.twice |= self.en;
        self.en = true;
        self.addr = addr;
    }
    /// The word that is asked for, if one is.
    pub fn asked(&self) -> Option<u32> {
        self.en.then_some(self.addr)
    }
}

/// A request on a write port. One a cycle. Its widths depend on that of an address and on the data's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals((u32, T::Config))]
pub struct WritePort<T> {
    pub(super) en: bool,
    #[unseen]
    pub(super) twice: bool,
    #[width(cfg.0)]
    pub(super) addr: u32,
    #[with(cfg.1)]
    pub(super) data: T,
}

impl<T: Copy> WritePort<T> {
    /// Asks for `data` to be put at `addr`.
    #[inline(always)]
    pub fn write(&mut self, addr: u32, data: T) {
        self.twice |= self.en;
        self.en = true;
        self.addr = addr;
        self.data = data;
    }
    /// The word that is written and what is put there, if one is.
    pub fn asked(&self) -> Option<(u32, T)> {
        self.en.then_some((self.addr, self.data))
    }
}

/// What a request on a write port puts somewhere, if it does: for a receiver that has no addresses.
#[inline(always)]
#[rtl]
pub fn written<T: Copy>(port: WritePort<T>) -> Stream<T> {
    Stream { valid: port.en, payload: port.data }
}

/// Which word a request on a read port asks for, if it does: for a receiver that has no memory.
#[inline(always)]
#[rtl]
pub fn read_at(port: ReadPort) -> Stream<u32> {
    Stream { valid: port.en, payload: port.addr }
}

/// Where a request on a write port puts something, if it does.
#[inline(always)]
#[rtl]
pub fn written_at<T: Copy>(port: WritePort<T>) -> Stream<u32> {
    Stream { valid: port.en, payload: port.addr }
}

/// A request on a port that reads or writes. One a cycle. Its widths depend on that of an address and
/// on the data's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals((u32, T::Config))]
pub struct Port<T> {
    pub(super) en: bool,
    #[unseen]
    pub(super) twice: bool,
    pub(super) write: bool,
    #[width(cfg.0)]
    pub(super) addr: u32,
    #[with(cfg.1)]
    pub(super) data: T,
}

impl<T: Copy> Port<T> {
    /// Asks for the word at `addr`.
    #[inline(always)]
    pub fn read(&mut self, addr: u32) {
        self.twice |= self.en;
        self.en = true;
        self.addr = addr;
    }
    /// Asks for `data` to be put at `addr`.
    #[inline(always)]
    pub fn write(&mut self, addr: u32, data: T) {
        self.read(addr);
        self.write = true;
        self.data = data;
    }
}
