//! What stands behind the image merger: takes the transparent primitives of a frame while the one before is
//! composed, and adds them to the merged opaque image.

use super::merging_unit::Opaque;
use crate::pixel::{COLOUR_BITS, Marked, Screen};
use crate::primitive::Primitive;
use pellucid_sim::{Netlist, Signals, Stream};

/// See the module's description.
pub trait Transparency:
    Netlist<
        Config: Copy,
        State: Signals<Config = Self::Config>,
        In = In,
        Moore = Moore,
        Out: Signals<Config = Self::Config>,
    > + Copy
    + 'static
{
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Transparent primitives, then the end of the frame.
    #[with(*cfg)]
    pub primitive: Stream<Marked<Primitive>>,
    /// The frame whose primitives came is composed from now on, and the next one may come. Only while
    /// `sorted` and not `busy`.
    pub swap: bool,
    /// The merged image in raster order.
    pub merged: Stream<Opaque>,
    /// A line of it is complete.
    pub line_merged: bool,
    /// The receiver takes a colour.
    pub image_ready: bool,
    /// A pixel's number, for what is to be emptied after reset.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// A primitive is taken.
    pub ready: bool,
    /// The frame's primitives have come, its end included.
    pub sorted: bool,
    /// A merged pixel is taken.
    pub merged_ready: bool,
    /// A frame is being composed, or waits to be shown.
    pub busy: bool,
    /// It waits to be shown.
    pub waits: bool,
    /// The image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// An image is being shown.
    pub shows: bool,
}
