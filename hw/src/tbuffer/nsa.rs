//! The NSA table: for each section the one that follows it in its pixel's chain.
//!
//! ```text
//!  store (read or write) --->+-----+
//!  chain (read) ------------>| Nsa |---> entry
//!                            +-----+
//! ```
//! One access a cycle; a read shows its entry in the next cycle and keeps it until the next read.

use super::config::Config;
use super::tables::NsaEntry;
use pellucid_sim::Block;
use pellucid_sim::{Memory, Port, Ram1RW, Read, width_of};

/// See the module's description.
pub struct Nsa;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// The store unit's access.
    pub store: Port<NsaEntry>,
    /// The chain reader's access.
    pub chain: Port<NsaEntry>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// One entry per section.
    pub table: Ram1RW<NsaEntry>,
}

impl Block for Nsa {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<NsaEntry>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        Mem { table: Ram1RW::new(cfg.null, width_of::<NsaEntry>(cfg), 1) }
    }

    #[inline(always)]
    fn moore(_: &Config, (): &(), m: &Self::Mem) -> Read<NsaEntry> {
        m.table.q()
    }

    #[inline(always)]
    fn next(_: &Config, (): &(), (): &mut (), m: &mut Self::Mem, i: In) {
        m.table.pass(i.store);
        m.table.pass(i.chain);
    }
}
