//! What stands behind the image merger: takes the transparent primitives of a frame while the one before is
//! composed, and adds them to the merged opaque image.

use super::merging_unit::Opaque;
use pellucid_machine::pixel::{COLOUR_BITS, Marked, Screen};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_machine::{Arithmetic, Census, Check, InConfig, Outside, Room, Tally, outside};
use pellucid_sim::{Handshake, Netlist, Registers, Signals, StorageInfo, Stream, Violation, Wait};

/// See the module's description.
pub trait Transparency:
    Netlist<
        Config: Copy + Send + Sync,
        State: Registers<Config = Self::Config>,
        In = In,
        Moore = Moore,
        Out: Signals<Config = Self::Config>,
    > + Copy
    + 'static
{
    /// Watches it.
    type Monitor: Watch<Self>;
    /// How it makes colours.
    fn arithmetic(cfg: &Self::Config) -> Arithmetic;
    /// Its port to outside memory.
    fn port(_: &Self::Config) -> outside::Config {
        outside::Config::NONE
    }
    /// The memory behind it, if there is one.
    fn outside(_: &Self::Config) -> Option<Outside> {
        None
    }
    /// That port's wires.
    fn wires(_: &Self::Config, _: &Self::Out) -> outside::Wires {
        outside::Wires::default()
    }
    /// How large it must be for a frame: see [`Machine::room`](pellucid_machine::Machine::room).
    fn room(_: &Self::Config, _: &Census) -> Option<Room> {
        None
    }
    /// What must have been counted behind the merger, for frames of which every fragment found its place.
    fn closed_forms(cfg: &Self::Config, tally: &Tally, frames: &[Census]) -> Vec<Check>;
}

/// Watches what stands behind the merger: counts, and holds its streams to their rules.
pub trait Watch<T: Transparency>: Sized {
    /// A monitor that has seen nothing.
    fn new(cfg: &T::Config) -> Self;
    /// One cycle: the registers at its start and the wires during it, and the image that goes out.
    ///
    /// # Errors
    /// A stream broke its rules: a bug in a block.
    fn observe(
        &mut self,
        cfg: &T::Config,
        q: &T::State,
        out: &T::Out,
        image: Handshake<u32>,
    ) -> Result<(), Violation>;
    /// A number that grows whenever something moves.
    fn transfers(&self) -> u64;
    /// Who waits for whom in the last cycle.
    fn waits(&self, q: &T::State) -> Vec<Wait>;
    /// What was counted, but for the cycles by phase and opaque fragments; `memories` are those behind the merger.
    fn tally(&self, cfg: &T::Config, memories: &[(String, StorageInfo)]) -> Tally;
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(InConfig)]
pub struct In {
    /// Transparent primitives, then the end of the frame.
    #[with(Format::drawn(cfg.screen))]
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
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// What the outside memory shows.
    #[with(cfg.outside)]
    #[exists(cfg.outside.exists())]
    pub outside: outside::In,
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
