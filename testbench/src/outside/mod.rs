//! Outside memories with a timing of their own.

pub mod board;
mod timing;

use crate::stimulus::chosen;
use pellucid_machine::board::{Asked, Fixed, Timing};

/// A memory that pauses: it takes no request in some cycles and answers some reads later.
pub struct Pausing {
    /// Whose answers come later.
    fixed: Fixed,
    busy: u64,
    now: u64,
    offers: bool,
}

impl Pausing {
    /// No read is answered before `latency` cycles; in so many `of_eight` cycles no request is taken, and in as many no
    /// answer begins to be offered.
    pub fn new(latency: u32, of_eight: u64) -> Pausing {
        Pausing { fixed: Fixed::new(latency), busy: of_eight, now: 0, offers: false }
    }
}

impl Timing for Pausing {
    fn ready(&self) -> bool {
        !chosen(self.now, self.busy)
    }
    fn answers(&self) -> bool {
        self.offers
    }
    fn idle(&self) -> bool {
        false
    }
    fn longest(&self) -> u64 {
        // Its pauses are short beside what a simulation may stand still anyway.
        self.fixed.longest()
    }
    fn cycle(&mut self, asked: Option<Asked>, answered: bool) {
        self.fixed.cycle(asked, answered);
        self.now += 1;
        let held = self.offers && !answered;
        self.offers = held || (self.fixed.answers() && !chosen(!self.now, self.busy));
    }
    fn reset(&mut self) {
        self.fixed.reset();
        self.offers = false;
    }
}

#[cfg(test)]
mod tests;
