//! Where the frames of a trace begin, as far as it is known.

use std::sync::{Mutex, PoisonError};

/// Where a frame begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Start {
    /// Bytes before it.
    pub offset: u64,
    /// Records before it, end records too, or lines.
    pub before: u64,
}

/// The starts of the frames that have been come to, which are the first ones.
#[derive(Debug)]
pub(super) struct Starts(Mutex<Vec<Start>>);

impl Starts {
    /// That of the first frame alone.
    pub fn new(first: Start) -> Starts {
        Starts(Mutex::new(vec![first]))
    }

    /// The last known frame up to this one, and its start.
    pub fn nearest(&self, number: u32) -> (u32, Start) {
        let starts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let nearest = (number as usize).min(starts.len() - 1);
        (nearest as u32, starts[nearest])
    }

    /// Remembers the start of a frame.
    pub fn found(&self, number: u32, start: Start) {
        let mut starts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if starts.len() == number as usize {
            starts.push(start);
        }
    }
}
