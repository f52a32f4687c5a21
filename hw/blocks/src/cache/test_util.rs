//! What the tests of caches share: what becomes of requests.

use super::Config;
use pellucid_machine::outside::Request;
use std::collections::VecDeque;

/// What the events came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// Requests that were found.
    pub hits: u32,
    /// Those that were not.
    pub misses: u32,
    /// Words of dirty lines.
    pub written_back: u32,
    /// Words of lines that came.
    pub filled: u32,
}

/// The lines of a cache, each set a list with the line that was used last in front, and whether it is dirty.
pub struct Reference {
    cfg: Config,
    sets: Vec<VecDeque<(u32, bool)>>,
    /// What they came to.
    pub events: Events,
}

impl Reference {
    /// A cache with nothing in it.
    pub fn new(cfg: Config) -> Reference {
        Reference { cfg, sets: vec![VecDeque::new(); cfg.sets as usize], events: Events::default() }
    }
    /// A request.
    pub fn request(&mut self, Request { write, address, .. }: Request) {
        let Config { sets, ways, line, write_back, .. } = self.cfg;
        let number = address / line;
        let set = &mut self.sets[(number % sets) as usize];
        let found = set.iter().position(|(known, _)| *known == number);
        let was_dirty = found.and_then(|at| set.remove(at)).is_some_and(|(_, dirty)| dirty);
        self.events.hits += u32::from(found.is_some());
        self.events.misses += u32::from(found.is_none());
        if found.is_none() && write && !write_back {
            return;
        }
        if found.is_none() {
            self.events.filled += line;
            if set.len() == ways as usize && set.pop_back().is_some_and(|(_, dirty)| dirty) {
                self.events.written_back += line;
            }
        }
        set.push_front((number, write_back && (write || was_dirty)));
    }
    /// A flush.
    pub fn flush(&mut self) {
        for (_, dirty) in self.sets.iter_mut().flatten() {
            self.events.written_back += if *dirty { self.cfg.line } else { 0 };
            *dirty = false;
        }
    }
}
