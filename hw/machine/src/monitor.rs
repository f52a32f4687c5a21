//! Watches a machine cycle by cycle.

use crate::machine::Machine;
use crate::tally::{MemoryTally, StreamTally, Tally};
use pellucid_sim::{Deadlock, StorageInfo, StreamMonitor, Violation, Wait};

/// Watches a machine cycle by cycle: counts, and holds its streams to their rules.
pub trait Monitor<M: Machine + ?Sized>: Sized {
    /// A monitor that has seen nothing.
    fn new(cfg: &M::Config) -> Self;
    /// One cycle: the registers at its start and the wires during it.
    ///
    /// # Errors
    /// A stream broke its rules: a bug in a block.
    fn observe(&mut self, cfg: &M::Config, q: &M::State, out: &M::Out) -> Result<(), Violation>;
    /// A number that grows whenever something moves between blocks.
    fn transfers(&self) -> u64;
    /// Who waits for whom in the last cycle.
    fn deadlock(&self, cycle: u64, idle: u64, q: &M::State) -> Deadlock;
    /// What was counted, once the memories' traffic is known.
    fn tally(&self, cfg: &M::Config, memories: &[(String, StorageInfo)]) -> Tally;
}

/// What a stream's monitor has seen.
pub struct Seen {
    /// Its traffic.
    pub tally: StreamTally,
    /// Something was offered in the last cycle.
    pub valid: bool,
    /// The receiver was ready in the last cycle.
    pub ready: bool,
}

/// What a stream's monitor has seen.
pub fn seen<T>(monitor: &StreamMonitor<T>) -> Seen
where
    T: Copy + Default + PartialEq + std::fmt::Debug,
{
    let (valid, ready) = monitor.last();
    let StreamMonitor { name, from, to, transfers, stalls, .. } = *monitor;
    Seen { tally: StreamTally { name, from, to, transfers, stalls }, valid, ready }
}

/// Who waits for whom; `state` names the state of a block.
pub fn waits(streams: &[Seen], state: impl Fn(&str) -> &'static str) -> Vec<Wait> {
    let (mut senders, mut receivers) = (vec![], vec![]);
    for Seen { tally, valid, ready } in streams {
        let StreamTally { name: stream, from, to, .. } = *tally;
        if *valid && !ready {
            let state = state(from);
            senders.push(Wait { block: from, state, stream, other: to, sends: true });
        } else if *ready && !valid {
            let state = state(to);
            receivers.push(Wait { block: to, state, stream, other: from, sends: false });
        }
    }
    // Who cannot send is the cause; who has nothing to receive matters only without one.
    if senders.is_empty() { receivers } else { senders }
}

/// The memories that a machine has, with their traffic; those without a word are left out. Of one whose block says
/// nothing of the words in use, all are.
pub struct Memories {
    all: Vec<MemoryTally>,
}

impl Memories {
    /// As they are.
    pub fn new(memories: &[(String, StorageInfo)]) -> Memories {
        let tally = |(name, info): &(String, StorageInfo)| MemoryTally {
            name: name.clone(),
            info: *info,
            peak_words: info.peak_words.unwrap_or(info.words),
        };
        Memories { all: memories.iter().map(tally).collect() }
    }

    /// Sets the most words that were in use at once of the memory at `path`.
    ///
    /// # Panics
    /// There is no such memory.
    #[track_caller]
    pub fn set_peak(&mut self, path: &str, words: u64) {
        let memory = self.all.iter_mut().find(|memory| memory.name == path);
        let memory = memory.unwrap_or_else(|| panic!("there is no memory `{path}`"));
        memory.peak_words = words.min(memory.info.words);
    }

    /// The same for all whose path begins with `path`.
    ///
    /// # Panics
    /// There is none.
    #[track_caller]
    pub fn set_peaks(&mut self, path: &str, words: u64) {
        let below: Vec<String> = self.all.iter().map(|memory| memory.name.clone()).collect();
        let below: Vec<_> = below.iter().filter(|name| name.starts_with(path)).collect();
        assert!(!below.is_empty(), "there is no memory below `{path}`");
        below.into_iter().for_each(|name| self.set_peak(name, words));
    }

    /// Those that have words.
    pub fn tallies(self) -> Vec<MemoryTally> {
        self.all.into_iter().filter(|memory| memory.info.words > 0).collect()
    }
}

/// The memories whose path begins with `place`, with the rest of it, and the others.
pub fn below(place: &str, memories: &[(String, StorageInfo)]) -> [Vec<(String, StorageInfo)>; 2] {
    let (mut inside, mut around) = (vec![], vec![]);
    for (name, info) in memories {
        match name.strip_prefix(place) {
            Some(name) => inside.push((name.to_string(), *info)),
            None => around.push((name.clone(), *info)),
        }
    }
    [inside, around]
}

/// A tally as the part that is at `place` sees it: with its own memories.
pub fn seen_from(place: &str, tally: &Tally) -> Tally {
    let memories = tally.memories.iter().filter_map(|m| {
        m.name.strip_prefix(place).map(|name| MemoryTally { name: name.to_string(), ..*m })
    });
    Tally { memories: memories.collect(), ..tally.clone() }
}

/// Memories of the part that is at `place`.
pub fn above(place: &str, memories: Vec<MemoryTally>) -> impl Iterator<Item = MemoryTally> {
    memories.into_iter().map(move |m| MemoryTally { name: format!("{place}{}", m.name), ..m })
}
