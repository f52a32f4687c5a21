//! Streams: how blocks hand things to each other.
//!
//! 1. A transfer happens on every edge where `valid` and `ready` are both high.
//! 2. Once `valid` is high, `valid` and the payload hold until the transfer.
//! 3. `valid` never waits for `ready`.
//! 4. `ready` is a function of registers only.
//!
//! The first three are those of AXI-Stream and of Amaranth's streams. The fourth cuts every
//! combinational loop: a block's `ready` is a Moore output, so a composition is evaluated in one
//! pass, upstream to downstream. [`StreamMonitor`] counts transfers and stalls and, in debug
//! builds, holds a stream to rule 2; rule 3 is held by [`valid_ignores_ready`] in the tests of
//! each block that sends, rule 4 by the type of [`crate::Block::moore`], which sees no input.

use crate::block::Block;
use crate::{Signals, rtl};
use std::fmt;

/// What the sender drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(T::Config)]
pub struct Stream<T> {
    /// Something is offered.
    pub valid: bool,
    /// What is offered; without meaning while `valid` is low.
    #[with(*cfg)]
    pub payload: T,
}

/// All wires of a stream in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(T::Config)]
pub struct Handshake<T> {
    /// Something is offered.
    pub valid: bool,
    /// It is taken on the coming edge.
    pub ready: bool,
    /// What is offered.
    #[with(*cfg)]
    pub payload: T,
}

#[rtl]
impl<T: Default> Stream<T> {
    /// Nothing is offered.
    pub fn idle() -> Stream<T> {
        Stream { valid: false, payload: T::default() }
    }
}

#[rtl]
impl<T> Stream<T> {
    /// `payload` is offered.
    pub fn offer(payload: T) -> Stream<T> {
        Stream { valid: true, payload }
    }
}

impl<T> Stream<T> {
    /// With the receiver's side.
    pub fn with(self, ready: bool) -> Handshake<T> {
        Handshake { valid: self.valid, ready, payload: self.payload }
    }
}

impl<T> Handshake<T> {
    /// Whether a transfer happens (rule 1).
    pub fn fires(&self) -> bool {
        self.valid && self.ready
    }
}

/// Watches one stream, cycle by cycle.
#[derive(Clone, Debug)]
pub struct StreamMonitor<T> {
    /// The stream's name.
    pub name: &'static str,
    /// The block that sends.
    pub from: &'static str,
    /// The block that receives.
    pub to: &'static str,
    /// Transfers so far.
    pub transfers: u64,
    /// Cycles in which something was offered and not taken.
    pub stalls: u64,
    last: Handshake<T>,
}

/// A stream that broke rule 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The stream's name.
    pub stream: &'static str,
    /// The block that sends.
    pub from: &'static str,
    /// What the offer was and what became of it.
    pub what: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "stream `{}`: {} {}", self.stream, self.from, self.what)
    }
}

impl std::error::Error for Violation {}

impl<T: Copy + Default + PartialEq + fmt::Debug> StreamMonitor<T> {
    /// A monitor for the stream `name` from block `from` to block `to`.
    pub fn new(name: &'static str, from: &'static str, to: &'static str) -> StreamMonitor<T> {
        StreamMonitor { name, from, to, transfers: 0, stalls: 0, last: Handshake::default() }
    }

    /// One cycle.
    ///
    /// # Errors
    /// In debug builds, a [`Violation`] of rule 2.
    #[inline(always)]
    pub fn observe(&mut self, now: Handshake<T>) -> Result<(), Violation> {
        self.transfers += u64::from(now.valid & now.ready);
        self.stalls += u64::from(now.valid & !now.ready);
        if cfg!(debug_assertions) {
            if self.last.valid && !self.last.ready {
                self.rule_2(now)?;
            }
            self.last.payload = now.payload;
        }
        (self.last.valid, self.last.ready) = (now.valid, now.ready);
        Ok(())
    }

    fn rule_2(&self, now: Handshake<T>) -> Result<(), Violation> {
        let offered = self.last.payload;
        let what = if !now.valid {
            format!("withdrew {offered:?} before it was taken")
        } else if now.payload != offered {
            format!("changed {offered:?} to {:?} before it was taken", now.payload)
        } else {
            return Ok(());
        };
        Err(Violation { stream: self.name, from: self.from, what })
    }

    /// Whether something was offered in the last cycle, and whether the receiver was ready.
    pub fn last(&self) -> (bool, bool) {
        (self.last.valid, self.last.ready)
    }

    /// Forgets an offer that was cut short by a reset.
    pub fn reset(&mut self) {
        self.last = Handshake::default();
    }
}

/// Rule 3 for one cycle of a sender: its offer is the same whether the receiver is ready or not.
/// `with_ready` makes the block's inputs for a given `ready`, `sent` finds the offer in its outputs.
/// The memories are only asked, never clocked.
pub fn valid_ignores_ready<B: Block, T: PartialEq>(
    cfg: &B::Config,
    q: &B::State,
    memories: impl Fn() -> B::Mem,
    with_ready: impl Fn(bool) -> B::In,
    sent: impl Fn(&B::Out) -> Stream<T>,
) -> bool {
    let offer = |ready| sent(&B::next(cfg, q, &mut q.clone(), &mut memories(), with_ready(ready)));
    offer(false) == offer(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(wires: &[(bool, bool, u32)]) -> (StreamMonitor<u32>, Result<(), Violation>) {
        let mut monitor = StreamMonitor::new("s", "sender", "receiver");
        for &(valid, ready, payload) in wires {
            if let Err(v) = monitor.observe(Handshake { valid, ready, payload }) {
                return (monitor, Err(v));
            }
        }
        (monitor, Ok(()))
    }

    #[test]
    fn transfers_and_stalls_are_counted() {
        let (monitor, result) =
            run(&[(false, true, 9), (true, false, 1), (true, true, 1), (true, true, 2)]);
        assert_eq!((monitor.transfers, monitor.stalls, result), (2, 1, Ok(())));
    }

    #[test]
    #[cfg(debug_assertions)]
    fn rule_2_holds_offers() {
        let (_, gone) = run(&[(true, false, 1), (false, true, 1)]);
        assert_eq!(
            gone.unwrap_err().to_string(),
            "stream `s`: sender withdrew 1 before it was taken"
        );
        let (_, changed) = run(&[(true, false, 1), (true, true, 2)]);
        assert_eq!(
            changed.unwrap_err().to_string(),
            "stream `s`: sender changed 1 to 2 before it was taken"
        );
    }
}
