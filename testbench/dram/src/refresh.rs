//! When which rank or bank is to be refreshed.

use crate::config::{Config, Refresh};

/// A refresh that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Due {
    /// Whose.
    rank: usize,
    /// Its first bank.
    pub bank: usize,
    /// How many banks from there on.
    pub banks: usize,
}

struct Rank {
    /// Where in the interval its refreshes are.
    offset: u64,
    /// Refreshes that it has had.
    done: u64,
    /// When the next one is due.
    at: u64,
}

/// The refreshes of the ranks on a data bus.
pub struct Timer {
    ranks: Vec<Rank>,
    rank_banks: usize,
    /// Refreshes of a rank in an interval.
    parts: u64,
    refi: u64,
    next: u64,
}

impl Timer {
    /// The ranks' refreshes are spread over the interval. All data buses have the same times, as a request to one that rests would
    /// keep the others waiting.
    pub fn new(config: &Config) -> Timer {
        let rank_banks = config.part.organisation.rank_banks();
        let ranks = u64::from(config.ranks);
        let parts = if config.refresh == Refresh::PerBank { rank_banks as u64 } else { 1 };
        let refi = config.part.timing.refi;
        let rank = |rank| {
            let offset = refi * rank / (ranks * parts);
            Rank { offset, done: 0, at: offset + refi / parts }
        };
        Timer { ranks: (0..ranks).map(rank).collect(), rank_banks, parts, refi, next: refi / parts }
    }

    /// When the next one is due, or was.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// What is due at `clock`.
    pub fn due(&self, clock: u64) -> impl Iterator<Item = Due> + '_ {
        let due = self.ranks.iter().enumerate().filter(move |(_, rank)| rank.at <= clock);
        due.map(|(index, rank)| {
            let first = index * self.rank_banks;
            match self.parts {
                1 => Due { rank: index, bank: first, banks: self.rank_banks },
                _ => Due { rank: index, bank: first + (rank.done % self.parts) as usize, banks: 1 },
            }
        })
    }

    /// One that was due has been given.
    pub fn done(&mut self, due: Due) {
        let rank = &mut self.ranks[due.rank];
        rank.done += 1;
        rank.at = rank.offset + self.refi * (rank.done + 1) / self.parts;
        self.next = self.ranks.iter().map(|rank| rank.at).min().unwrap_or(u64::MAX);
    }
}
