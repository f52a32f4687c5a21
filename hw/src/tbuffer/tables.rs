//! The T-buffer's tables: what a word of each holds.

use super::config::Config;
use crate::pixel::Z_BITS;
use pellucid_sim::Signals;

/// A word of the SSA (start-section address) table: a pixel's chain of sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct SsaEntry {
    /// The first section, or NULL (the number of sections) if the pixel has no fragment.
    #[width(cfg.id_bits())]
    pub head: u32,
    /// The last section. With `append=walk` the table does not have it.
    #[width(if cfg.tail { cfg.id_bits() } else { 0 })]
    pub tail: u32,
    /// Fragments in the last section. With `append=walk` the table does not have it.
    #[width(if cfg.tail { cfg.fill_bits() } else { 0 })]
    pub fill: u32,
}

/// A word of the NSA (next-section address) table: what follows a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct NsaEntry {
    /// The next section of the chain, or NULL. With `append=tail` the last section of a chain has no
    /// entry: the SSA table knows it.
    #[width(cfg.id_bits())]
    pub next: u32,
    /// Fragments in this section. With `append=tail` the table does not have it.
    #[width(if cfg.tail { 0 } else { cfg.fill_bits() })]
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
