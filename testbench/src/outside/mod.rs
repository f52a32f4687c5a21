//! Outside memories with a timing of their own.

pub mod board;
mod timing;

use crate::stimulus::chosen;
use pellucid_machine::board::{Asked, Fixed, Timing};

/// A memory that pauses: it takes no request in some cycles and answers some reads later.
pub(crate) struct Pausing {
    /// Whose answers come later.
    fixed: Fixed,
    now: u64,
    offers: bool,
}

/// Of eight cycles, in how many no request is taken.
const BUSY: u64 = 2;
/// Of eight cycles, in how many no answer begins to be offered.
const LATE: u64 = 2;

impl Pausing {
    /// No read is answered before `latency` cycles.
    pub(crate) fn new(latency: u32) -> Pausing {
        Pausing { fixed: Fixed::new(latency), now: 0, offers: false }
    }
}

impl Timing for Pausing {
    fn ready(&self) -> bool {
        !chosen(self.now, BUSY)
    }
    fn answers(&self) -> bool {
        self.offers
    }
    fn idle(&self) -> bool {
        false
    }
    fn cycle(&mut self, asked: Option<Asked>, answered: bool) {
        self.fixed.cycle(asked, answered);
        self.now += 1;
        let held = self.offers && !answered;
        self.offers = held || (self.fixed.answers() && !chosen(!self.now, LATE));
    }
    fn reset(&mut self) {
        self.fixed.reset();
        self.offers = false;
    }
}
