//! What stands behind the image merger: takes the transparent primitives of a frame while the one before is
//! composed, and adds them to the merged opaque image.

use super::merging_unit::Opaque;
use crate::machine::Fragments;
use crate::pixel::{COLOUR_BITS, Marked, Screen};
use crate::primitive::Primitive;
use pellucid_sim::{Figure, Netlist, Registers, Signals, Stream, Violation};

/// See the module's description.
pub trait Transparency:
    Netlist<
        Config: Copy,
        State: Registers<Config = Self::Config>,
        In = In,
        Moore = Moore,
        Out: Signals<Config = Self::Config>,
    > + Copy
    + 'static
{
    /// Watches it.
    type Monitor: Watch<Self>;
}

/// Watches what stands behind the merger: counts, and holds its streams to their rules.
pub trait Watch<T: Transparency>: Sized {
    /// A monitor that has seen nothing.
    fn new(cfg: &T::Config) -> Self;
    /// One cycle: the registers at its start and the wires during it.
    ///
    /// # Errors
    /// A stream broke its rules: a bug in a block.
    fn observe(&mut self, cfg: &T::Config, q: &T::State, out: &T::Out) -> Result<(), Violation>;
    /// The state of one of its blocks, if it is one.
    fn state(block: &str, q: &T::State) -> Option<&'static str>;
    /// Transparent fragments by what became of them; those that came in are counted as `arrived`.
    fn fragments(&self) -> Fragments;
    /// Why fragments are dropped, with the parameters that could help.
    fn dropped_since(&self) -> &'static str;
    /// Its own figures.
    fn own(&self) -> Vec<Figure>;
    /// Of a memory, by its path, the most words in use; nothing if it is none of those that fill.
    fn peak_words(&self, name: &str) -> Option<u64>;
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
