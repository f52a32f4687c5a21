//! What a frame is before its first fragment arrives: its size and its background.

/// The longest side of a frame, in pixels.
pub const MAX_SIDE: u32 = 8192;

/// Size and background of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameInfo {
    /// Width in pixels, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Height in pixels, 1 to [`MAX_SIDE`].
    pub height: u32,
    /// Colour of a pixel that no fragment covers, `0xRRGGBB`.
    pub background: u32,
}
