//! The tables of the chains: what a word of each holds.

use super::config::Config;
use crate::cached_table;
use pellucid_machine::outside;
use pellucid_machine::pixel::{RGBA_BITS, Z_BITS};
use pellucid_sim::{Label, Read, Signals, rtl};

/// A word of the SSA (start-section address) table: a pixel's chain of sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct SsaEntry {
    /// The first section, or NULL (the number of sections) if the pixel has no fragment. Where pixels own
    /// a section, the table does not have it.
    #[width(cfg.head_bits())]
    pub head: u32,
    /// The last section; where pixels own a section, NULL if the pixel has no fragment. The table has it
    /// only if tails are kept.
    #[width(cfg.tail_bits())]
    pub tail: u32,
    /// Fragments in the last section, or in the first where new ones go before it. The table has it only if one of the two is
    /// so.
    #[width(if cfg.keeps_fill() { cfg.fill_bits() } else { 0 })]
    pub fill: u32,
}

#[rtl]
impl Config {
    /// Whether the entry that was asked for is shown. On chip it is in the next cycle.
    #[inline(always)]
    pub fn is_there(&self, ssa: Read<SsaEntry>) -> bool {
        !self.caches_ssa() || ssa.valid
    }
    /// Whether an entry is that of a pixel without fragments.
    #[inline(always)]
    pub fn is_null(&self, entry: SsaEntry) -> bool {
        if self.shape.owned { entry.tail == self.null } else { entry.head == self.null }
    }
    /// The first section of a pixel with fragments.
    #[inline(always)]
    pub fn first_section(&self, pixel: u32, entry: SsaEntry) -> u32 {
        if self.shape.owned { pixel } else { entry.head }
    }
    /// The slot of the fragment that is read first of a pixel with fragments.
    #[inline(always)]
    pub fn first_slot(&self, entry: SsaEntry) -> u32 {
        if self.newest_first() { entry.fill.saturating_sub(1) } else { 0 }
    }
    /// The same of every section but the pixel's first.
    #[inline(always)]
    pub fn next_first_slot(&self) -> u32 {
        if self.newest_first() { self.shape.capacity - 1 } else { 0 }
    }
}

#[rtl]
impl SsaEntry {
    /// Its first section lowest, then its last, then how full that is.
    #[inline(always)]
    fn word(cfg: &Config, entry: SsaEntry) -> outside::Word {
        let (head, tail, fill) =
            (u64::from(entry.head), u64::from(entry.tail), u64::from(entry.fill));
        let low = (fill << cfg.tail_bits() | tail) << cfg.head_bits() | head;
        outside::Word { low, high: 0, label: Label::NONE }
    }
    #[inline(always)]
    fn of_word(cfg: &Config, word: outside::Word) -> SsaEntry {
        let (above, beyond) =
            (word.low >> cfg.head_bits(), word.low >> cfg.head_bits() >> cfg.tail_bits());
        SsaEntry {
            head: (word.low & cfg.head_mask()) as u32,
            tail: (above & cfg.tail_mask()) as u32,
            fill: (beyond & cfg.fill_mask()) as u32,
        }
    }
}

cached_table::entry!(SsaEntry, Config, SsaEntry::null);

/// A word of the NSA (next-section address) table: what follows a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct NsaEntry {
    /// The next section of the chain, or NULL. If tails are kept the last section of a chain has no entry:
    /// the SSA table knows it.
    #[width(cfg.id_bits())]
    pub next: u32,
    /// Fragments in this section. If SSA entries tell how full a section is the table does not have it.
    #[width(if cfg.keeps_fill() { 0 } else { cfg.fill_bits() })]
    pub fill: u32,
}

/// A fragment as a section holds it; its pixel is known from the chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Word {
    /// Depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Colour, `0xRRGGBBAA`.
    #[width(RGBA_BITS)]
    pub rgba: u32,
    /// Its weight among the fragments of its pixel so far, where weights are kept in memory.
    #[width(cfg.shape.weight_bits)]
    pub weight: u32,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// A fragment as a word of outside memory.
#[inline(always)]
#[rtl]
pub fn packed(word: Word) -> outside::Word {
    outside::packed(word.z, word.rgba, word.weight, word.label)
}

/// The fragment that a word of outside memory holds.
#[inline(always)]
#[rtl]
pub fn unpacked(word: outside::Word) -> Word {
    let (z, rgba) = (outside::depth(word), outside::colour(word));
    Word { z, rgba, weight: outside::beside(word), label: word.label }
}

impl Word {
    /// All bits of it.
    #[inline]
    pub fn bits(cfg: &Config) -> u32 {
        Z_BITS + RGBA_BITS + cfg.shape.weight_bits
    }
}

/// A place in a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Place {
    /// The section.
    #[width(cfg.id_bits())]
    pub section: u32,
    /// The slot in it.
    #[width(cfg.slot_bits())]
    pub slot: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{small, small_owned};
    use pellucid_sim::width_of;
    use proptest::prelude::*;

    #[test]
    fn a_fragment_has_as_many_bits_in_outside_memory() {
        for cfg in [small(true), small_owned(true)] {
            assert_eq!(Word::bits(&cfg), width_of::<Word>(&cfg));
        }
    }

    proptest! {
        #[test]
        fn a_fragment_comes_back_from_outside_as_it_was(
            z in 0u32..1 << Z_BITS,
            rgba: u32,
            weight in 0u32..1 << 24,
            in_memory: bool,
        ) {
            let label = Label::new(3, 4, 5);
            let word = Word { z, rgba, weight: if in_memory { weight } else { 0 }, label };
            let outside = packed(word);
            prop_assert_eq!(unpacked(outside), word);
            prop_assert!(outside.check(&small_owned(in_memory).port()).is_ok(), "{:?}", outside);
        }
    }
}
