//! The SSA table: for each pixel the start of its chain of sections.
//!
//! ```text
//!  store read, write ---->+-----+
//!  lookup read, write --->| Ssa |---> entry
//!  clear ---------------->+-----+
//! ```
//! One read and one write a cycle; a read shows its entry in the next cycle, a read that meets a
//! write of the same pixel shows what is written: two fragments of one pixel may come in a row.
//! Resolve sets each entry that it visits back to NULL; `clear` does so after reset.

use super::config::Config;
use super::tables::SsaEntry;
use pellucid_sim::Block;
use pellucid_sim::{Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Stream, WritePort, width_of};

/// See the module's description.
pub struct Ssa;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// The store unit's read.
    pub store_read: ReadPort,
    /// The store unit's write.
    pub store_write: WritePort<SsaEntry>,
    /// Resolve's read.
    pub lookup_read: ReadPort,
    /// Resolve's write: NULL.
    pub lookup_write: WritePort<SsaEntry>,
    /// A pixel whose entry is set to NULL.
    pub clear: Stream<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// One entry per pixel.
    pub table: Ram1R1W<SsaEntry>,
}

impl SsaEntry {
    /// A pixel without fragments.
    pub fn null(cfg: &Config) -> SsaEntry {
        SsaEntry { head: cfg.null, tail: 0, fill: 0 }
    }
}

impl Block for Ssa {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<SsaEntry>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let bits = width_of::<SsaEntry>(cfg);
        Mem { table: Ram1R1W::new(cfg.screen.pixels(), bits, 1, ReadDuringWrite::New) }
    }

    #[inline(always)]
    fn moore(_: &Config, (): &(), m: &Self::Mem) -> Read<SsaEntry> {
        m.table.q()
    }

    #[inline(always)]
    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Self::Mem, i: In) {
        m.table.pass_read(i.store_read);
        m.table.pass_read(i.lookup_read);
        m.table.pass_write(i.store_write);
        m.table.pass_write(i.lookup_write);
        if i.clear.valid {
            m.table.write(i.clear.payload, SsaEntry::null(cfg));
        }
    }
}
