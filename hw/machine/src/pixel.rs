//! What every architecture agrees on about pixels: the fragment, depth range, colour packing and the blend.
//!
//! Depth is 24 bits unsigned, 0 nearest. Colour is 8-bit unorm per channel, not premultiplied.

use pellucid_sim::{Label, Signals, bits_for, check_range, rtl};

/// Bits of a depth value.
pub const Z_BITS: u32 = 24;
/// The far plane: what a cleared depth buffer holds. A fragment is visible only if its depth is less.
pub const Z_FAR: u32 = (1 << Z_BITS) - 1;

/// Bits of a colour without alpha, `0xRRGGBB`.
pub const COLOUR_BITS: u32 = 24;
/// Bits of a fragment's colour, `0xRRGGBBAA`.
pub const RGBA_BITS: u32 = 32;

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
    /// Which fragment it is, in waveforms. Whoever plays a frame to a machine sets it.
    pub label: Label,
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
    /// Checks its sides where a block is built for it.
    ///
    /// # Panics
    /// If a side is outside of its range.
    pub fn check(&self) {
        check_range("the width of a screen", self.width, 1..=MAX_SIDE);
        check_range("the height of a screen", self.height, 1..=MAX_SIDE);
    }
    /// How many pixels; they are numbered row by row from the top left.
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }
    /// Bits of a pixel's number.
    #[inline]
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
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// Most bits of a pixel's number.
pub const MOST_PIXEL_BITS: u32 = 2 * MAX_SIDE.ilog2();

/// A fragment as it is read back from storage. Its widths depend on the bits of a pixel's number and of its weight, which
/// are 0 where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals((u32, u32))]
pub struct Arrived {
    /// Its pixel.
    #[width(cfg.0)]
    pub pixel: u32,
    /// Its depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// Its weight, where weights are kept in memory.
    #[width(cfg.1)]
    pub weight: u32,
    /// It is in front of the pixel's opaque depth. Hidden ones only carry the two marks below.
    pub visible: bool,
    /// The last of the pass.
    pub last: bool,
    /// This is the pixel's last pass.
    pub last_pass: bool,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// What a stream of a frame carries: items, then a mark that ends the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(T::Config)]
pub struct Marked<T> {
    /// The frame ends here; `item` is without meaning.
    pub end: bool,
    /// The item.
    #[with(*cfg)]
    pub item: T,
}

#[rtl]
impl<T> Marked<T> {
    /// An item.
    pub fn item(item: T) -> Marked<T> {
        Marked { end: false, item }
    }
}

#[rtl]
impl<T: Default> Marked<T> {
    /// The end of the frame.
    pub fn end() -> Marked<T> {
        Marked { end: true, item: T::default() }
    }
}

impl Fragment {
    /// Whether the fragment hides what lies behind it (alpha 255).
    pub fn is_opaque(self) -> bool {
        is_opaque(self.rgba)
    }
}

/// Whether a colour `0xRRGGBBAA` hides what lies behind it (alpha 255).
#[inline(always)]
#[rtl]
pub fn is_opaque(rgba: u32) -> bool {
    rgba & 0xff == 0xff
}

/// Packs four channels, each 0..=255, as `0xRRGGBBAA`.
pub fn rgba(r: u8, g: u8, b: u8, a: u8) -> u32 {
    u32::from_be_bytes([r, g, b, a])
}

/// `t / 255` rounded to nearest, exact for `t` in 0..=65025.
#[rtl]
pub fn div255(t: u32) -> u32 {
    (t + 128 + ((t + 128) >> 8)) >> 8
}

/// A fragment's colour `0xRRGGBBAA` over a colour `0xRRGGBB`: `div255(a*s + (255-a)*c)` per channel.
#[rtl]
pub fn blend(rgba: u32, below: u32) -> u32 {
    let a = rgba & 0xff;
    let r = div255(a * (rgba >> 24) + (255 - a) * (below >> 16 & 0xff));
    let g = div255(a * (rgba >> 16 & 0xff) + (255 - a) * (below >> 8 & 0xff));
    let b = div255(a * (rgba >> 8 & 0xff) + (255 - a) * (below & 0xff));
    r << 16 | g << 8 | b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn div255_rounds_to_nearest_for_every_product() {
        // 255 is odd, so no quotient lies half way: the nearest is floor(t / 255 + 1 / 2).
        for t in 0..=255 * 255 {
            assert_eq!(div255(t), (2 * t + 255) / 510, "t = {t}");
        }
    }

    #[test]
    fn blend_by_hand() {
        // 128 * 200 + 127 * 100 = 38300 = 150.2 * 255; 128 * 10 + 127 * 20 = 3820 = 14.98 * 255;
        // 128 * 255 + 127 * 255 = 255 * 255.
        assert_eq!(blend(rgba(200, 10, 255, 128), 0x64_14_ff), 0x96_0f_ff);
        // Each channel takes its own: 128 * 255 = 128 * 255, 127 * 255 = 127 * 255.
        assert_eq!(blend(rgba(255, 0, 0, 128), 0x00_ff_00), 0x80_7f_00);
        assert_eq!(blend(rgba(0, 0, 255, 128), 0xff_00_00), 0x7f_00_80);
    }

    #[test]
    fn blend_at_the_ends_of_alpha() {
        assert_eq!(blend(rgba(1, 2, 3, 255), 0xab_cd_ef), 0x01_02_03);
        assert_eq!(blend(rgba(1, 2, 3, 0), 0xab_cd_ef), 0xab_cd_ef);
    }

    #[test]
    fn alpha_255_alone_is_opaque() {
        let opaque =
            |a| Fragment { rgba: rgba(255, 255, 255, a), ..Fragment::default() }.is_opaque();
        assert!(opaque(255));
        assert!(!opaque(254) && !opaque(0));
    }

    #[test]
    fn colours_are_packed_from_red_down_to_alpha() {
        assert_eq!(rgba(0x12, 0x34, 0x56, 0x78), 0x1234_5678);
    }

    #[test]
    #[should_panic(expected = "the width of a screen is 0: expected 1 to 8192")]
    fn a_screen_has_columns() {
        Screen { width: 0, height: 9, background: 0 }.check();
    }

    #[test]
    #[should_panic(expected = "the height of a screen is 8193: expected 1 to 8192")]
    fn a_screen_has_not_too_many_rows() {
        Screen { width: MAX_SIDE, height: MAX_SIDE + 1, background: 0 }.check();
    }

    #[test]
    fn bits_of_a_screen() {
        let bits = |width, height| {
            let screen = Screen { width, height, background: 0 };
            (screen.pixels(), screen.pixel_bits(), screen.x_bits(), screen.y_bits())
        };
        assert_eq!(bits(1, 1), (1, 1, 1, 1));
        assert_eq!(bits(640, 480), (307_200, 19, 10, 9));
        assert_eq!(bits(256, 257), (65_792, 17, 8, 9));
        assert_eq!(bits(MAX_SIDE, MAX_SIDE), (1 << 26, 26, 13, 13));
    }
}
