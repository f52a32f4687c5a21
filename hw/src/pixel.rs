//! What every architecture agrees on about pixels: the fragment, depth range, colour packing and the blend.
//!
//! Depth is 24 bits unsigned, 0 nearest. Colour is 8-bit unorm per channel, not premultiplied.

use pellucid_sim::{Signals, bits_for};

/// Bits of a depth value.
pub const Z_BITS: u32 = 24;
/// The far plane: what a cleared depth buffer holds. A fragment is visible only if its depth is less.
pub const Z_FAR: u32 = (1 << Z_BITS) - 1;

/// One fragment as the rasteriser hands it over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Fragment {
    /// Column, 0 at the left, less than the screen's width.
    #[width(cfg.x_bits())]
    pub x: u32,
    /// Row, 0 at the top, less than the screen's height.
    #[width(cfg.y_bits())]
    pub y: u32,
    /// Depth, 0 nearest, at most [`Z_FAR`].
    #[width(Z_BITS)]
    pub z: u32,
    /// Colour as `0xRRGGBBAA`; alpha 255 is opaque, anything less is transparent.
    #[width(32)]
    pub rgba: u32,
}

/// The longest side of a screen, in pixels.
pub const MAX_SIDE: u32 = 8192;

/// The screen that a machine is built for: what is known of a frame before its first fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Screen {
    /// Columns, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_SIDE`].
    pub height: u32,
    /// Colour where nothing was drawn, `0xRRGGBB`.
    pub background: u32,
}

impl Screen {
    /// How many pixels; they are numbered row by row from the top left.
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }
    /// Bits of a pixel's number.
    pub fn pixel_bits(&self) -> u32 {
        bits_for(u64::from(self.pixels() - 1))
    }
    /// Bits of a column.
    pub fn x_bits(&self) -> u32 {
        bits_for(u64::from(self.width - 1))
    }
    /// Bits of a row.
    pub fn y_bits(&self) -> u32 {
        bits_for(u64::from(self.height - 1))
    }
}

/// A fragment whose pixel is known by number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct PixelFragment {
    /// The pixel's number, `y * width + x`.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// Depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Colour as `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
}

/// What a stream of a frame carries: items, then a mark that ends the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(T::Config)]
pub struct Marked<T: Signals> {
    /// The frame ends here; `item` is without meaning.
    pub end: bool,
    /// The item.
    #[with(*cfg)]
    pub item: T,
}

impl<T: Signals> Marked<T> {
    /// An item.
    pub fn item(item: T) -> Marked<T> {
        Marked { end: false, item }
    }
    /// The end of the frame.
    pub fn end() -> Marked<T>
    where
        T: Default,
    {
        Marked { end: true, item: T::default() }
    }
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
