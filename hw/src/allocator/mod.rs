//! Section allocators: any free section to any pixel.
//!
//! All stand behind one port contract, so that an architecture takes whichever its parameter names:
//! - `grant` is a stream of free section numbers: while `valid` is high, the payload is free and
//!   held; with `take` it is given away on the coming edge.
//! - `exhausted` is high while no section is free and none is on its way: a taker need not wait.
//! - `release` gives a section back; it can be granted again from the next cycle on. Releasing what
//!   was not granted is a bug of the user.
//!
//! | allocator | grants | memory |
//! | --- | --- | --- |
//! | [`FreeList`] | one a cycle, oldest release first | one section number per section |
//! | [`Stack`] | one a cycle, latest release first | one section number per section |
//! | [`Bitmap`] | one a cycle, lowest number first | none: a register bit per section |

pub mod bitmap;
mod free_list;
mod stack;

pub use bitmap::Bitmap;
pub use free_list::FreeList;
pub use stack::Stack;

use crate::choice;
use crate::params::ParamError;
use bitmap::MAX_SECTIONS;
use pellucid_sim::{Block, Netlist, Signals, Stream, bits_for};

choice! {
    /// Which allocator hands out sections.
    pub enum AllocatorKind {
        /// A free list as a queue: what came back first is granted first.
        Fifo = "fifo",
        /// A free list as a stack: what came back last is granted first.
        Lifo = "lifo",
        /// A bit for each section in registers: the lowest free one is granted first.
        Bitmap = "bitmap",
    }
}

impl AllocatorKind {
    /// Checks the parameter `name`, which says how many sections an allocator of this kind has.
    ///
    /// # Errors
    /// They are too many for it.
    pub fn check(self, name: &str, sections: u32) -> Result<(), ParamError> {
        if self != AllocatorKind::Bitmap || sections <= MAX_SECTIONS {
            return Ok(());
        }
        Err(ParamError::Together(format!(
            "parameter `{name}` is {sections}: expected at most {MAX_SECTIONS} with `allocator=bitmap`"
        )))
    }
}

/// What every allocator is built from.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// How many sections it manages, 0 for none at all; they are numbered from 0.
    pub sections: u32,
}

impl Config {
    /// Bits of a section number.
    pub fn id_bits(&self) -> u32 {
        bits_for(u64::from(self.sections.max(1) - 1))
    }
}

/// Inputs of every allocator.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// The granted section is taken. Without effect while no grant is offered.
    pub take: bool,
    /// A section is given back.
    #[with(cfg.id_bits())]
    pub release: Stream<u32>,
}

/// Outputs of every allocator, all of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The section that a take would get.
    #[with(cfg.id_bits())]
    pub grant: Stream<u32>,
    /// No section is free, and none is on its way.
    pub exhausted: bool,
}

/// A block that keeps the contract above. Whether it does is a matter of tests: see `pellucid-properties`.
pub trait Contract:
    Block<Config = Config, In = In, Moore = Moore, Out = (), State: Signals<Config = Config>>
{
    /// While a section is free, cycles until one is granted at the latest: after a reset, after the take of
    /// another one, and after its own release. At least 1.
    fn latency(_: &Config) -> u32 {
        1
    }
}

/// An allocator that an architecture can have: it keeps the contract, and it is hardware.
pub trait Allocator: Contract + Netlist + Copy + 'static {
    /// Words of its memory that hold something of use.
    fn words_in_use(q: &Self::State) -> u32;
}
