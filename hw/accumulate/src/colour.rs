//! Colours and pixels on their way through the accumulation.

use pellucid_sim::{Signals, rtl};

/// A colour of three channels of so many bits each: the upper 8 are a level from 0 to 255, those below them its fraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(u32)]
pub struct Colour {
    /// Red.
    #[width(*cfg)]
    pub r: u32,
    /// Green.
    #[width(*cfg)]
    pub g: u32,
    /// Blue.
    #[width(*cfg)]
    pub b: u32,
}

/// A colour `0xRRGGBB`, with so many bits of a fraction.
#[inline(always)]
#[rtl]
pub fn unpacked(fraction_bits: &u32, rgb: u32) -> Colour {
    Colour {
        r: (rgb >> 16) << *fraction_bits,
        g: (rgb >> 8 & 0xff) << *fraction_bits,
        b: (rgb & 0xff) << *fraction_bits,
    }
}

/// The colour `0xRRGGBB` of channels of 8 bits.
#[inline(always)]
#[rtl]
pub fn packed(colour: Colour) -> u32 {
    colour.r << 16 | colour.g << 8 | colour.b
}

/// Bits of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Of its number.
    pub pixel_bits: u32,
    /// Of a channel.
    pub channel_bits: u32,
    /// It is said whether an image ends.
    pub closes: bool,
}

/// A pixel of a frame, or of the mean of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Format)]
pub struct Pixel {
    /// Its number, row by row.
    #[width(cfg.pixel_bits)]
    pub pixel: u32,
    /// Its frame is the last of its image.
    #[exists(cfg.closes)]
    pub closes: bool,
    /// Its colour.
    #[with(cfg.channel_bits)]
    pub colour: Colour,
}
