//! Section allocators: any free section to any pixel.
//!
//! All stand behind one port contract, so that an architecture takes whichever its parameter names:
//! - `grant` is a stream of free section numbers: while `valid` is high, the payload is free and
//!   held; with `take` it is given away on the coming edge.
//! - `exhausted` is high while no section is free and none is on its way: a taker need not wait.
//! - `release` gives a section back; when it can be granted again is for [`Reuse`] to say. Releasing
//!   what is not out is a bug of the user; an allocator that looks for it says so with [`InvalidRelease`].
//! - Each section has a word that is lent to the allocator while the section is free, and that belongs
//!   to whoever has it while it is out. `lent` in [`Lent`] asks for such words; most allocators do not.
//!
//! | allocator | grants | memory |
//! | --- | --- | --- |
//! | [`FreeList`] | one a cycle, oldest release first | one section number per section |
//! | [`Stack`] | one a cycle, latest release first | one section number per section |
//! | [`Bump`] | one a cycle, in order; from the first again once all are back | none: two counters |
//! | [`Threaded`] | one a cycle, latest release first | none: the lent words |
//! | [`Bitmap`] | one a cycle, lowest number first | none: a register bit per section |
//! | [`Hierarchical`] | lowest number first, up to 64 in a row one a cycle | a bit per section and its summaries |
//! | [`Cached`] | latest release first, as far as its cache reaches | a few registers, and those of [`Hierarchical`] |
//!
//! [`Lanes`] is for several takers and givers in a cycle, and has ports of its own.

mod bitmap;
mod bump;
mod cached;
pub mod chosen;
mod free_list;
mod hierarchical;
pub mod lanes;
mod stack;
mod threaded;

pub use bitmap::Bitmap;
pub use bump::Bump;
pub use cached::Cached;
pub use chosen::Chosen;
pub use free_list::FreeList;
pub use hierarchical::Hierarchical;
pub use lanes::Lanes;
pub use stack::Stack;
pub use threaded::Threaded;

use pellucid_machine::choice;
use pellucid_machine::params::ParamError;
use pellucid_sim::{Block, Netlist, Registers, Signals, Stream, bits_for};

choice! {
    /// Which allocator hands out sections.
    pub enum AllocatorKind {
        /// A pointer to the next one: all are granted again once all are back.
        Bump = "bump",
        /// A free list as a queue: what came back first is granted first.
        Fifo = "fifo",
        /// A free list as a stack: what came back last is granted first.
        Lifo = "lifo",
        /// A free list as a stack that goes through the NSA table's entries of the free sections.
        Threaded = "threaded",
        /// A bit for each section in registers: the lowest free one is granted first.
        Bitmap = "bitmap",
        /// A bit for each section in memory, and words of bits that say where to look.
        Hierarchical = "hierarchical",
        /// A small cache of sections in registers over a hierarchical bitmap: what came back last is granted
        /// first.
        Cached = "cached",
    }
}

impl AllocatorKind {
    /// Checks the parameter `name`, which says how many sections an allocator of this kind has.
    ///
    /// # Errors
    /// They are too many for it.
    pub fn check(self, name: &str, sections: u32) -> Result<(), ParamError> {
        if self != AllocatorKind::Bitmap || sections <= Bitmap::MOST {
            return Ok(());
        }
        Err(ParamError::Together(format!(
            "parameter `{name}` is {sections}: expected at most {} with `allocator=bitmap`",
            Bitmap::MOST
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
    #[inline]
    pub fn id_bits(&self) -> u32 {
        bits_for(u64::from(self.sections.max(1) - 1))
    }
    /// Bits of a number of sections, and of a lent word: none up to all of them.
    pub fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.sections))
    }
}

/// Inputs of every allocator.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// The granted section is taken. Without effect while no grant is offered.
    pub take: bool,
    /// A section is given back.
    #[with(cfg.id_bits())]
    pub release: Stream<u32>,
    /// The lent word that was asked for in the cycle before.
    #[width(cfg.count_bits())]
    pub word: u32,
}

/// Outputs of every allocator that are of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The section that a take would get.
    #[with(cfg.id_bits())]
    pub grant: Stream<u32>,
    /// No section is to be had, and none is on its way.
    pub exhausted: bool,
}

/// What is asked of the lent words: one read and one write a cycle, each of a section that is free or that is
/// given back in this cycle, and not of one that is taken in it. The default is nothing.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Lent {
    /// The section whose word is read.
    #[with(cfg.id_bits())]
    pub read: Stream<u32>,
    /// The section whose word is written.
    #[with(cfg.id_bits())]
    pub write: Stream<u32>,
    /// What is written.
    #[width(cfg.count_bits())]
    pub word: u32,
}

/// When a section that was given back can be granted again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// Each within the latency.
    Each,
    /// Once all are back; then the offer may be replaced by another one.
    Together,
}

/// What comes of a release of a section that is not out: one that is free, on offer or taken in the same cycle, or of
/// a number beyond the last section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InvalidRelease {
    /// Anything: it must not be.
    Undefined,
    /// Nothing: it has no effect.
    Refused,
    /// It has no effect, and [`Contract::flagged`] says so.
    Flagged,
}

/// A block that keeps the contract above. Whether it does is a matter of tests: see `pellucid-properties`.
pub trait Contract:
    Block<Config = Config, In = In, Moore = Moore, Out = Lent, State: Registers<Config = Config>>
{
    /// When what was given back can be granted again.
    const REUSE: Reuse = Reuse::Each;
    /// What comes of a release of a section that is not out.
    const INVALID_RELEASE: InvalidRelease = InvalidRelease::Undefined;
    /// The most sections that it can have.
    const MOST: u32 = u32::MAX;

    /// While a section is to be had, cycles until one is granted at the latest: after a reset, after the take
    /// of another one, and after its own release. At least 1.
    fn latency(_: &Config) -> u32 {
        1
    }

    /// With [`InvalidRelease::Flagged`], an output of the allocator's own: high in the cycle after an invalid
    /// release, and only then.
    fn flagged(_: &Config, _: &Self::State) -> bool {
        false
    }
}

/// What an allocator is built from in a machine, which knows the parameter's value.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Which allocator its parameter names.
    pub kind: AllocatorKind,
    /// How many sections.
    pub numbers: Config,
}

/// As every allocator but [`Chosen`] sees it.
impl From<Choice> for Config {
    fn from(choice: Choice) -> Config {
        choice.numbers
    }
}

/// An allocator that an architecture can have: one that keeps the contract and is hardware, or [`Chosen`].
pub trait Allocator:
    Netlist<
        Config: From<Choice>,
        State: Signals<Config = Self::Config>,
        In = In,
        Moore = Moore,
        Out = Lent,
    > + Copy
    + 'static
{
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;

    /// A cycle in which the offer is taken or not, and a section given back or none.
    pub(super) fn clock<A: Contract>(sim: &mut Sim<A>, take: bool, release: Option<u32>) {
        let release = release.map_or(Stream::idle(), Stream::offer);
        sim.clock(In { take, release, ..In::default() }).unwrap();
    }

    #[test]
    fn without_sections_each_is_exhausted_at_once() {
        for kind in AllocatorKind::ALL {
            let choice = Choice { kind: *kind, numbers: Config { sections: 0 } };
            let seen = Sim::<Chosen>::new(choice).moore();
            assert!(seen.exhausted && !seen.grant.valid, "{kind:?}");
        }
    }
}
