//! What every architecture agrees on about pixels: the fragment, depth range, colour packing and the blend.
//!
//! Depth is 24 bits unsigned, 0 nearest. Colour is 8-bit unorm per channel, not premultiplied.

/// Bits of a depth value.
pub const Z_BITS: u32 = 24;
/// The far plane: what a cleared depth buffer holds. A fragment is visible only if its depth is less.
pub const Z_FAR: u32 = (1 << Z_BITS) - 1;

/// One fragment as the rasteriser hands it over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fragment {
    /// Column, 0 at the left, less than the screen's width.
    pub x: u32,
    /// Row, 0 at the top, less than the screen's height.
    pub y: u32,
    /// Depth, 0 nearest, at most [`Z_FAR`].
    pub z: u32,
    /// Colour as `0xRRGGBBAA`; alpha 255 is opaque, anything less is transparent.
    pub rgba: u32,
}

impl Fragment {
    /// Whether the fragment hides what lies behind it (alpha 255).
    pub fn is_opaque(self) -> bool {
        self.rgba & 0xff == 0xff
    }
}

/// Packs four channels, each 0..=255, as `0xRRGGBBAA`.
pub fn rgba(r: u8, g: u8, b: u8, a: u8) -> u32 {
    u32::from_be_bytes([r, g, b, a])
}

/// `t / 255` rounded to nearest, exact for `t` in 0..=65025.
pub fn div255(t: u32) -> u32 {
    (t + 128 + ((t + 128) >> 8)) >> 8
}

/// A fragment's colour `0xRRGGBBAA` over a colour `0xRRGGBB`: `div255(a*s + (255-a)*c)` per channel.
pub fn blend(rgba: u32, below: u32) -> u32 {
    let a = rgba & 0xff;
    let r = div255(a * (rgba >> 24) + (255 - a) * (below >> 16 & 0xff));
    let g = div255(a * (rgba >> 16 & 0xff) + (255 - a) * (below >> 8 & 0xff));
    let b = div255(a * (rgba >> 8 & 0xff) + (255 - a) * (below & 0xff));
    r << 16 | g << 8 | b
}
