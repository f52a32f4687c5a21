//! What a run of a machine came to.

use crate::phase::Cycles;
use pellucid_sim::{Figure, StorageInfo};

/// What a run of a machine came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cycles by phase.
    pub cycles: Cycles,
    /// Cycles that the architecture counts beside those.
    pub further_cycles: Vec<Figure>,
    /// Fragments by what became of them.
    pub fragments: Fragments,
    /// Why fragments are dropped, as a user reads it, with the parameters that could help.
    pub dropped_since: &'static str,
    /// Cycles in which a stream's offer was not taken: stream, sender, receiver, transfers, stalls.
    pub streams: Vec<StreamTally>,
    /// Memories with their traffic.
    pub memories: Vec<MemoryTally>,
    /// Accesses as the seed document counts them.
    pub seed_accesses: u64,
    /// Storage as the seed document counts it for the machine as configured, in bytes.
    pub seed_bytes: u64,
    /// The same for just the storage that was in use at the peak, in bytes.
    pub seed_bytes_used: u64,
    /// The architecture's own figures.
    pub own: Vec<Figure>,
    /// Those of the outside memory, if its timing has any; the energy that it took, in pJ, is among them where that is known.
    pub outside: Vec<Figure>,
}

impl Tally {
    /// One of the figures that only this architecture has.
    ///
    /// # Panics
    /// It has none of that name.
    #[track_caller]
    pub fn figure(&self, name: &str) -> u64 {
        let mut figures = self.further_cycles.iter().chain(&self.own);
        let figure = figures.find(|figure| figure.name == name);
        figure.unwrap_or_else(|| panic!("there is no figure `{name}`")).value
    }

    /// The traffic of the memory at `path`: none if the machine as configured has no word of it.
    pub fn memory(&self, path: &str) -> Option<&MemoryTally> {
        self.memories.iter().find(|memory| memory.name == path)
    }
}

pellucid_sim::counters! {
    /// Fragments by what became of them.
    pub struct Fragments {
        /// Fragments that came in, opaque and transparent.
        arrived: "fragments",
        /// Opaque fragments that were drawn (and perhaps drawn over later).
        drawn: "fragments",
        /// Opaque fragments that were hidden on arrival.
        hidden: "fragments",
        /// Transparent fragments that were stored.
        stored: "fragments",
        /// Transparent fragments that were stored in outside memory.
        spilled: "fragments",
        /// Transparent fragments behind their pixel's opaque depth: never blended.
        culled: "fragments",
        /// Transparent fragments that their program killed: never blended.
        killed: "fragments",
        /// Transparent fragments that were blended.
        blended: "fragments",
        /// Transparent fragments for which there was no place: the image lacks them.
        dropped: "fragments",
    }
}

/// One stream's traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamTally {
    /// Its name.
    pub name: &'static str,
    /// The block that sends.
    pub from: &'static str,
    /// The block that receives.
    pub to: &'static str,
    /// Transfers.
    pub transfers: u64,
    /// Cycles in which something was offered and not taken.
    pub stalls: u64,
}

/// One memory's traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryTally {
    /// Its path.
    pub name: String,
    /// Size and traffic.
    pub info: StorageInfo,
    /// The most words that held something of use at once.
    pub peak_words: u64,
}
