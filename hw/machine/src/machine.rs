//! What every architecture is to those who clock it, watch it and judge it.

use crate::accumulation::Accumulation;
use crate::arithmetic::Arithmetic;
use crate::census::{Census, Check};
use crate::item::{Item, ItemType};
use crate::monitor::Monitor;
use crate::outside::{self, Outside, Wires};
use crate::phase::PhaseInfo;
use crate::pixel::Screen;
use crate::room::Room;
use crate::tally::Tally;
use pellucid_sim::{Block, Handshake, Netlist, Registers, Signals};

/// What the outside sees of a machine in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Ports {
    /// What it is at: a number into [`Machine::PHASES`].
    pub phase: u8,
    /// Whether the item that was offered is taken.
    pub item_ready: bool,
    /// The image goes out, pixel by pixel, `0xRRGGBB`.
    pub image: Handshake<u32>,
    /// What is to come next is the same frame again, from its first fragment. High from the end of a round
    /// of the frame until its first item comes again.
    pub replay: bool,
    /// The port to outside memory.
    pub outside: Wires,
}

/// Says to which engine each item of a frame goes; asked once of each, in arrival order.
pub type Dealer = Box<dyn FnMut(&Item) -> u32>;

/// An architecture: a block that takes frames, with the monitor that watches it.
pub trait Machine:
    Netlist
    + Block<
        Config: Copy + Send + Sync,
        State: Registers<Config = Self::Config>,
        In = <<Self as Machine>::Item as ItemType>::In,
        Out: Signals<Config = Self::Config>,
    > + 'static
{
    /// What its frames are made of.
    type Item: ItemType;
    /// Watches it.
    type Monitor: Monitor<Self>;
    /// Its phases, [`MAX_PHASES`](crate::phase::MAX_PHASES) at most.
    const PHASES: &'static [PhaseInfo];
    /// How it makes colours.
    fn arithmetic(cfg: &Self::Config) -> Arithmetic;
    /// How it makes one image of several frames; nothing if each frame is an image.
    fn accumulation(_: &Self::Config) -> Option<Accumulation> {
        None
    }
    /// Whether it may ask for a frame again: see [`Ports::replay`].
    fn replays(_: &Self::Config) -> bool {
        false
    }
    /// Where the machine has several engines for what is opaque, a new dealer for each call: of opaque fragments
    /// that are equally deep the one of the engine with the lower number is seen, of one engine's the one that
    /// arrived first. What it says of transparent items is without meaning.
    fn dealer(_: &Self::Config) -> Option<Dealer> {
        None
    }
    /// Its port to outside memory.
    fn port(_: &Self::Config) -> outside::Config {
        outside::Config::NONE
    }
    /// The memory behind it, if there is one.
    fn outside(_: &Self::Config) -> Option<Outside> {
        None
    }
    /// What the outside sees.
    fn ports(cfg: &Self::Config, out: &Self::Out) -> Ports;
    /// How large it must be so that nothing is dropped of a frame; nothing if what it holds is no question of the frame, or of a
    /// parameter.
    fn room(_: &Self::Config, _: &Census) -> Option<Room> {
        None
    }
    /// The screen.
    fn screen(cfg: &Self::Config) -> Screen;
    /// Where its front is among registers and memories, if that can be clocked [alone](Machine::alone).
    const FRONT: Option<&'static str> = None;
    /// Its front has work in the coming cycle that it may do alone: it clears memories, or shows an image between frames.
    fn may_be_alone(_: &Self::Config, _: &Self::State) -> bool {
        false
    }
    /// A cycle in which nothing works but the front, and what it clears: clocks just these, memories included, as
    /// [`Block::next`] with all else at rest; whether a memory is at fault. `out` comes in as the cycle before left it and is set where
    /// it differs. Nothing, and nothing is done, where the inputs give others work. Asked only while the machine
    /// [may be alone](Machine::may_be_alone), and a cycle before has changed no register but the front's.
    fn alone(
        _cfg: &Self::Config,
        _q: &mut Self::State,
        _d: &mut Self::State,
        _m: &mut Self::Mem,
        _i: &Self::In,
        _out: &mut Self::Out,
    ) -> Option<bool> {
        None
    }
    /// What a run must have counted, by the closed forms of the architecture's seed document, for
    /// frames of which every fragment found its place.
    fn closed_forms(cfg: &Self::Config, tally: &Tally, frames: &[Census]) -> Vec<Check>;
}
