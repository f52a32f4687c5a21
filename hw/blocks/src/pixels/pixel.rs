//! What a word of the frame buffer in outside memory holds.

use pellucid_machine::outside::{self, Word};
use pellucid_machine::pixel::{COLOUR_BITS, Screen, Z_BITS, Z_FAR};
use pellucid_sim::{Label, Signals, rtl};

/// Depth and colour of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Pixel {
    /// Depth.
    #[width(Z_BITS)]
    pub depth: u32,
    /// Colour, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

#[rtl]
impl Pixel {
    /// The word that holds a pixel.
    #[inline(always)]
    pub fn word(_: &Screen, pixel: Pixel) -> Word {
        outside::packed(pixel.depth, pixel.colour, 0, Label::NONE)
    }
    /// The pixel that a word holds.
    #[inline(always)]
    pub fn of_word(_: &Screen, word: Word) -> Pixel {
        Pixel { depth: outside::depth(word), colour: outside::colour(word) & 0xff_ffff }
    }
    /// A pixel that nothing was drawn into.
    #[inline(always)]
    pub fn clear(cfg: &Screen) -> Pixel {
        Pixel { depth: Z_FAR, colour: cfg.background }
    }
}

crate::cached_table::entry!(Pixel, Screen, Pixel::clear);
