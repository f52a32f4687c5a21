//! The tables of the chains: what a word of each holds.

use super::config::Config;
use pellucid_machine::pixel::Z_BITS;
use pellucid_sim::{Label, Signals, rtl};

/// A word of the SSA (start-section address) table: a pixel's chain of sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct SsaEntry {
    /// The first section, or NULL (the number of sections) if the pixel has no fragment. Where pixels own
    /// a section, the table does not have it.
    #[width(if cfg.shape.owned { 0 } else { cfg.id_bits() })]
    pub head: u32,
    /// The last section; where pixels own a section, NULL if the pixel has no fragment. The table has it
    /// only if tails are kept.
    #[width(if cfg.shape.tail { cfg.id_bits() } else { 0 })]
    pub tail: u32,
    /// Fragments in the last section, likewise.
    #[width(if cfg.shape.tail { cfg.fill_bits() } else { 0 })]
    pub fill: u32,
}

#[rtl]
impl Config {
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
}

/// A word of the NSA (next-section address) table: what follows a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct NsaEntry {
    /// The next section of the chain, or NULL. If tails are kept the last section of a chain has no entry:
    /// the SSA table knows it.
    #[width(cfg.id_bits())]
    pub next: u32,
    /// Fragments in this section. If tails are kept the table does not have it.
    #[width(if cfg.shape.tail { 0 } else { cfg.fill_bits() })]
    pub fill: u32,
}

/// A fragment as a section holds it; its pixel is known from the chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Word {
    /// Depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// Its weight among the fragments of its pixel so far, where weights are kept in memory.
    #[width(cfg.shape.weight_bits)]
    pub weight: u32,
    /// Which fragment it is, in waveforms.
    pub label: Label,
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
