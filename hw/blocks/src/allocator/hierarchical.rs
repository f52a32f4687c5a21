//! A bit for each section in memory, and above it words of bits that say where to look: the lowest free
//! section of millions is found in a fixed number of cycles.
//!
//! ```text
//!             +--------------+
//!   take ---->|              |---> grant
//!  release -->| Hierarchical |---> exhausted
//!             +--------------+
//!  root (a register)     bit k: word k of `upper` has a bit
//!  upper, middle         bit k: word k of the level below has a bit
//!  leaves                bit k: section k of these 64 is free
//! ```
//! A word holds 64 bits, so that three levels below the root are enough for 2^24 sections.
//!
//! A search goes from the root down, a level a cycle, and takes a whole word of leaves out of the tree: its
//! sections are at hand, and are granted one a cycle, lowest first. So up to 64 grants in a row come one a
//! cycle; between two words, and where each word has one free section, it takes up to [`LATENCY`] cycles.
//! Sections that were never used come last; a counter grants them, one a cycle. Where it comes to a new word
//! it clears it, so that a reset has nothing to clear.
//!
//! One release a cycle. It reads the words above its section in one cycle and writes them in the next. A search
//! that meets one begins anew; what comes back while nothing is offered is offered at once, so that releases
//! cannot keep a taker waiting.

use super::{Allocator, Config, Contract, In, Lent, Moore};
use crate::bits::{WORD_BITS, WORD_SHIFT, bit, lowest, rest};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Hierarchical;

/// Cycles to an offer at the most: the search asks the root and three levels, one a cycle, and what it finds is
/// offered in the next. Before that a release may be on its way into the tree, in the cycle of the take.
pub const LATENCY: u32 = 5;

impl Contract for Hierarchical {
    fn latency(_: &Config) -> u32 {
        LATENCY
    }
}

impl Allocator for Hierarchical {}

impl Config {
    /// Words of leaves, at least 1.
    fn leaves(&self) -> u32 {
        self.sections.div_ceil(WORD_BITS)
    }
    /// Words of the level above.
    fn middles(&self) -> u32 {
        self.leaves().div_ceil(WORD_BITS)
    }
    /// Words of the level above that, each a bit of the root.
    fn uppers(&self) -> u32 {
        self.middles().div_ceil(WORD_BITS)
    }
    /// Bits of the number of a word of leaves.
    fn leaf_bits(&self) -> u32 {
        bits_for(u64::from(self.leaves().saturating_sub(1)))
    }
}

/// What a search waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Search {
    /// Nothing: there is none.
    Idle,
    /// The word of `upper`.
    Upper,
    /// The word of `middle`.
    Middle,
    /// The word of leaves.
    Leaf,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What is offered; it is neither at hand nor in the tree.
    #[with(cfg.id_bits())]
    pub offer: Stream<u32>,
    /// Free sections at hand: those of word `word` of the leaves that were in the tree.
    #[width(WORD_BITS)]
    pub hand: u64,
    /// Which word that is; while a search is under way, the number of the word that was asked for.
    #[width(cfg.leaf_bits())]
    pub word: u32,
    /// Which words of `upper` have a bit.
    #[width(cfg.uppers())]
    pub root: u64,
    /// The search.
    pub search: Search,
    /// The word of `upper` on the search's way.
    #[width(WORD_BITS)]
    pub upper: u64,
    /// The word of `middle` on its way.
    #[width(WORD_BITS)]
    pub middle: u64,
    /// A section that came back, whose words the memories show.
    #[with(cfg.id_bits())]
    pub back: Stream<u32>,
    /// The lowest section that was never offered; the number of sections once all were.
    #[width(cfg.count_bits())]
    pub fresh: u32,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Which words of `middle` have a bit.
    pub upper: Ram1R1W<u64>,
    /// Which words of `leaf` have a bit.
    pub middle: Ram1R1W<u64>,
    /// Which sections are free.
    pub leaf: Ram1R1W<u64>,
}

#[rtl(
    check(Hierarchical, Config { sections: 1 }),
    check(Hierarchical, Config { sections: 6 }),
    check(Hierarchical, Config { sections: 300 })
)]
impl Block for Hierarchical {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = Mem;

    fn reset(_: &Config) -> State {
        State {
            offer: Stream::idle(),
            hand: 0,
            word: 0,
            root: 0,
            search: Search::Idle,
            upper: 0,
            middle: 0,
            back: Stream::idle(),
            fresh: 0,
        }
    }

    fn memories(cfg: &Config) -> Mem {
        // A release may read what the one before it, or the end of a search, writes.
        let level = |words| Ram1R1W::new(words, WORD_BITS, 1, ReadDuringWrite::New);
        Mem { upper: level(cfg.uppers()), middle: level(cfg.middles()), leaf: level(cfg.leaves()) }
    }

    fn moore(cfg: &Config, q: &State, _: &Mem) -> Moore {
        let new = q.fresh < cfg.sections;
        let none = !q.offer.valid && q.hand == 0 && q.root == 0 && !q.back.valid && !new;
        Moore { grant: q.offer, exhausted: none }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Lent {
        let upper_data = m.upper.q().data;
        let middle_data = m.middle.q().data;
        let leaf_data = m.leaf.q().data;
        d.search = Search::Idle;
        d.back.valid = false;

        // What came back is added to the words above it.
        if q.back.valid {
            let id = q.back.payload;
            let (leaf, middle, upper) =
                (id >> WORD_SHIFT, id >> (2 * WORD_SHIFT), id >> (3 * WORD_SHIFT));
            d.root = q.root | bit(upper);
            m.upper.write(upper, upper_data | bit(middle));
            m.middle.write(middle, middle_data | bit(leaf));
            m.leaf.write(leaf, leaf_data | bit(id));
        }

        // The end of a search: the word leaves the tree.
        let found = q.search == Search::Leaf;
        let hand = if found { leaf_data } else { q.hand };
        if found {
            let (middle, upper) = (q.word >> WORD_SHIFT, q.word >> (2 * WORD_SHIFT));
            let between = rest(q.middle);
            let above = if between == 0 { rest(q.upper) } else { q.upper };
            m.leaf.write(q.word, 0);
            m.middle.write(middle, between);
            m.upper.write(upper, above);
            if above == 0 {
                d.root = rest(q.root);
            }
        }

        // The next offer: the lowest at hand, else what comes back, else a new one once the tree is empty.
        let wanted = i.take || !q.offer.valid;
        let direct = wanted && hand == 0 && i.release.valid;
        let new = !q.back.valid && q.root == 0 && q.fresh < cfg.sections;
        d.hand = hand;
        if wanted {
            if hand != 0 {
                d.offer = Stream { valid: true, payload: (q.word << WORD_SHIFT) + lowest(hand) };
                d.hand = rest(hand);
            } else if direct {
                d.offer = i.release;
            } else if new {
                d.offer = Stream { valid: true, payload: q.fresh };
                d.fresh = q.fresh + 1;
                if bit(q.fresh) == 1 {
                    let leaf = q.fresh >> WORD_SHIFT;
                    m.leaf.write(leaf, 0);
                    m.leaf.holds(leaf + 1);
                    if bit(leaf) == 1 {
                        let middle = leaf >> WORD_SHIFT;
                        m.middle.write(middle, 0);
                        m.middle.holds(middle + 1);
                        if bit(middle) == 1 {
                            m.upper.write(middle >> WORD_SHIFT, 0);
                            m.upper.holds((middle >> WORD_SHIFT) + 1);
                        }
                    }
                }
            } else {
                d.offer.valid = false;
            }
        }

        if i.release.valid && !direct {
            // What comes back asks for the words above it.
            let id = i.release.payload;
            m.leaf.read(id >> WORD_SHIFT);
            m.middle.read(id >> (2 * WORD_SHIFT));
            m.upper.read(id >> (3 * WORD_SHIFT));
            d.back = i.release;
        } else if !q.back.valid {
            // Else the ports are free for the search.
            if q.search == Search::Upper {
                let middle = (q.word << WORD_SHIFT) + lowest(upper_data);
                m.middle.read(middle);
                d.upper = upper_data;
                d.word = middle;
                d.search = Search::Middle;
            } else if q.search == Search::Middle {
                let leaf = (q.word << WORD_SHIFT) + lowest(middle_data);
                m.leaf.read(leaf);
                d.middle = middle_data;
                d.word = leaf;
                d.search = Search::Leaf;
            } else if !found && hand == 0 && q.root != 0 {
                let upper = lowest(q.root);
                m.upper.read(upper);
                d.word = upper;
                d.search = Search::Upper;
            }
        }
        Lent::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::clock;
    use super::*;
    use pellucid_sim::Sim;
    use std::collections::BTreeSet;

    /// Takes so many, one after the other.
    fn take(sim: &mut Sim<Hierarchical>, count: usize) -> Vec<u32> {
        let (mut taken, mut since) = (vec![], 0);
        while taken.len() < count {
            let Moore { grant, exhausted } = sim.moore();
            since = if grant.valid { 0 } else { since + 1 };
            assert!(!exhausted && since < LATENCY, "after {} of {count}", taken.len());
            taken.extend(grant.valid.then_some(grant.payload));
            clock(sim, true, None);
        }
        taken
    }

    /// Across words of every level: the first and last of leaves, of `middle` words and of `upper` words.
    #[test]
    fn the_lowest_of_a_million_goes_first() {
        let sections = 1 << 20;
        let mut sim = Sim::<Hierarchical>::new(Config { sections });
        assert!(take(&mut sim, sections as usize).into_iter().eq(0..sections));
        assert!(sim.moore().exhausted);
        let mut back = BTreeSet::new();
        for edge in [0, 64, 4096, 1 << 18, 1 << 19, sections] {
            back.extend((edge.max(2) - 2..edge + 3).filter(|id| *id < sections));
        }
        let mut order: Vec<u32> = back.iter().copied().collect();
        order.sort_by_key(|id| id.wrapping_mul(2_654_435_761));
        // The first is offered at once; the others are in the tree.
        for id in &order {
            clock(&mut sim, false, Some(*id));
        }
        back.remove(&order[0]);
        let mut expected = vec![order[0]];
        expected.extend(back);
        assert_eq!(take(&mut sim, order.len()), expected);
        assert!(sim.moore().exhausted);
    }

    /// Sections of one word come one a cycle; between two words the search takes its time.
    #[test]
    fn a_word_is_granted_one_a_cycle_and_the_next_is_searched() {
        let mut sim = Sim::<Hierarchical>::new(Config { sections: 256 });
        take(&mut sim, 256);
        (0..128).for_each(|id| clock(&mut sim, false, Some(id)));
        // The first word comes to hand; its section 0 was offered as it came back.
        (0..LATENCY).for_each(|_| clock(&mut sim, false, None));
        let mut gaps = vec![];
        for cycle in 0..128 + 3 {
            gaps.extend((!sim.moore().grant.valid).then_some(cycle));
            clock(&mut sim, true, None);
        }
        assert!(sim.moore().exhausted);
        // The search begins in the cycle in which the last one of the word is offered, asks three levels, and
        // offers what it finds in the cycle after it came.
        assert_eq!(gaps, [64, 65, 66]);
    }
}
