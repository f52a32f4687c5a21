//! Chains as the store unit leaves them, for the tests of blocks that read them: what is in which table, and
//! what must come of it.

use super::config::{Config, Link};
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use crate::test_util::edge;
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_sim::{Label, Ram1RW, Read};
use std::collections::{BTreeMap, VecDeque};

/// A pixel: the depths of its fragments in the order of their arrival, and its opaque depth.
#[derive(Clone, Debug)]
pub struct Pixel {
    pub layers: Vec<u32>,
    pub depth: u32,
}

impl Pixel {
    pub fn visible(&self) -> u32 {
        self.layers.iter().filter(|z| **z < self.depth).count() as u32
    }
    pub fn passes(&self, k: u32) -> u32 {
        self.visible().div_ceil(k).max(1)
    }
}

fn colour(pixel: usize, layer: usize) -> u32 {
    (pixel as u32) << 16 | layer as u32
}

/// A fragment as it must arrive. `last_pass` has a meaning on the last of a pass alone: elsewhere it
/// is taken as false.
pub fn meaning(arrived: Marked<Arrived>) -> Marked<Arrived> {
    let Marked { end, item } = arrived;
    if end {
        return Marked::end();
    }
    Marked::item(Arrived { last_pass: item.last && item.last_pass, ..item })
}

/// What must arrive: each pixel's chain in order, pass after pass, then the end.
pub fn reference(pixels: &[Pixel], k: u32, link: Link) -> Vec<Marked<Arrived>> {
    let mut arrived = vec![];
    for (number, pixel) in pixels.iter().enumerate() {
        let passes = if pixel.layers.is_empty() { 0 } else { pixel.passes(k) };
        for pass in 1..=passes {
            let mut layers: Vec<(usize, u32)> = pixel.layers.iter().copied().enumerate().collect();
            if link == Link::Head {
                layers.reverse();
            }
            for (at, &(layer, z)) in layers.iter().enumerate() {
                let last = at + 1 == layers.len();
                arrived.push(Marked::item(Arrived {
                    pixel: number as u32,
                    z,
                    rgba: colour(number, layer),
                    weight: 0,
                    visible: z < pixel.depth,
                    last,
                    last_pass: last && pass == passes,
                    label: Label::new(layer as u32, number as u16, 0),
                }));
            }
        }
    }
    arrived.push(Marked::end());
    arrived
}

/// The stored fragments of a frame.
pub struct Stored {
    pub nsa: Ram1RW<NsaEntry>,
    pub words: Words,
    /// Each pixel's SSA entry; that of a pixel without fragments is NULL.
    pub entries: Vec<SsaEntry>,
    /// Sections of the chains.
    pub used: Vec<u32>,
}

impl Stored {
    /// The pixels' fragments are laid into `sections`, in that order.
    pub fn new(cfg: &Config, pixels: &[Pixel], sections: &[u32]) -> Stored {
        let mut sections = sections.iter().copied();
        let mut stored = Stored {
            nsa: Ram1RW::new(cfg.null, *cfg, 1),
            words: Words::new(*cfg),
            entries: vec![],
            used: vec![],
        };
        for (number, pixel) in pixels.iter().enumerate() {
            let groups = pixel.layers.chunks(cfg.shape.capacity as usize);
            let own: Vec<u32> = sections.by_ref().take(groups.len()).collect();
            let mut layer = 0;
            for (at, group) in groups.enumerate() {
                for (slot, &z) in group.iter().enumerate() {
                    let label = Label::new(layer as u32, number as u16, 0);
                    let word = Word { z, rgba: colour(number, layer), weight: 0, label };
                    stored.words.put(Place { section: own[at], slot: slot as u32 }, word);
                    layer += 1;
                }
                let before = at.checked_sub(1).map_or(cfg.null, |at| own[at]);
                let next = own.get(at + 1).copied().unwrap_or(cfg.null);
                let fill = group.len() as u32;
                // The last section of a chain has an entry only where the SSA table knows no tail.
                match cfg.shape.link {
                    Link::Walk => stored.nsa.write(own[at], NsaEntry { next, fill }),
                    Link::Tail if next == cfg.null => {}
                    Link::Tail => stored.nsa.write(own[at], NsaEntry { next, fill: 0 }),
                    Link::Head => stored.nsa.write(own[at], NsaEntry { next: before, fill: 0 }),
                }
                edge(&mut stored.nsa);
            }
            let (head, last) = match own[..] {
                [] => (cfg.null, None),
                [head, ..] => (head, own.last()),
            };
            let fill = (pixel.layers.len() as u32).wrapping_sub(1) % cfg.shape.capacity + 1;
            stored.entries.push(match (last, cfg.shape.link) {
                (Some(&tail), Link::Tail) => SsaEntry { head, tail, fill },
                (Some(&newest), Link::Head) => SsaEntry { head: newest, tail: 0, fill },
                _ => SsaEntry { head, tail: 0, fill: 0 },
            });
            stored.used.extend(own);
        }
        stored
    }
}

/// The memory of sections: answers come in the order of the questions, one a cycle, outside ones later.
pub struct Words {
    cfg: Config,
    words: BTreeMap<(u32, u32), Word>,
    /// Answers on their way, with the cycle from which on they may be shown.
    answers: VecDeque<(u64, Word)>,
}

impl Words {
    pub fn new(cfg: Config) -> Words {
        Words { cfg, words: BTreeMap::new(), answers: VecDeque::new() }
    }
    pub fn put(&mut self, Place { section, slot }: Place, word: Word) {
        self.words.insert((section, slot), word);
    }
    pub fn at(&self, Place { section, slot }: Place) -> Word {
        self.words[&(section, slot)]
    }
    /// Cycles from a question to its answer.
    pub fn latency(&self, section: u32) -> u32 {
        if self.cfg.is_outside(section) { self.cfg.shape.outside_latency } else { 1 }
    }
    /// What is shown in a cycle.
    pub fn answer(&mut self, cycle: u64) -> Read<Word> {
        let due = self.answers.pop_front_if(|(due, _)| *due <= cycle);
        due.map_or(Read::default(), |(_, data)| Read { valid: true, data })
    }
    /// A place is asked for.
    pub fn ask(&mut self, cycle: u64, place: Place) {
        let due = cycle + u64::from(self.latency(place.section));
        self.answers.push_back((due, self.at(place)));
    }
}
