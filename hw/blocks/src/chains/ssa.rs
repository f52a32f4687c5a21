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
use pellucid_sim::{
    Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort, rtl,
};

/// See the module's description.
pub struct Ssa;

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// The store unit's read.
    #[with(cfg.screen.pixel_bits())]
    pub store_read: ReadPort,
    /// The store unit's write.
    #[with(cfg.screen.pixel_bits(), *cfg)]
    pub store_write: WritePort<SsaEntry>,
    /// Resolve's read.
    #[with(cfg.screen.pixel_bits())]
    pub lookup_read: ReadPort,
    /// Resolve's write: NULL.
    #[with(cfg.screen.pixel_bits(), *cfg)]
    pub lookup_write: WritePort<SsaEntry>,
    /// A pixel whose entry is set to NULL.
    #[with(cfg.screen.pixel_bits())]
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
        let (head, tail) = if cfg.shape.owned { (0, cfg.null) } else { (cfg.null, 0) };
        SsaEntry { head, tail, fill: 0 }
    }
}

#[rtl(check(Ssa, crate::test_util::small(true)), check(Ssa, crate::test_util::small(false)))]
impl Block for Ssa {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<SsaEntry>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        // Where it is cached, the table lies in outside memory.
        let pixels = if cfg.caches_ssa() { 0 } else { cfg.screen.pixels() };
        Mem { table: Ram1R1W::new(pixels, *cfg, 1, ReadDuringWrite::New) }
    }

    fn moore(_: &Config, (): &(), m: &Self::Mem) -> Read<SsaEntry> {
        m.table.q()
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allocator::FreeList;
    use crate::chains::Chains;
    use crate::chains::config::Shape;
    use crate::test_util::{Clocked, screen, shape, small, small_caching};

    fn nothing() -> In {
        In {
            store_read: ReadPort::default(),
            store_write: WritePort::default(),
            lookup_read: ReadPort::default(),
            lookup_write: WritePort::default(),
            clear: Stream::idle(),
        }
    }

    /// A table of 6 pixels, all NULL; 7 and 2 sections make 9 the number of NULL.
    fn cleared() -> Clocked<Ssa> {
        let shape = Shape { on_chip: 7, outside: 2, ..shape() };
        let mut table = Clocked::<Ssa>::new(Config::new(screen(3, 2), shape));
        for pixel in 0..6 {
            table.clock(In { clear: Stream::offer(pixel), ..nothing() }).unwrap();
        }
        table
    }

    fn read(pixel: u32) -> ReadPort {
        let mut port = ReadPort::default();
        port.read(pixel);
        port
    }

    fn write(pixel: u32, entry: SsaEntry) -> WritePort<SsaEntry> {
        let mut port = WritePort::default();
        port.write(pixel, entry);
        port
    }

    const NULL: SsaEntry = SsaEntry { head: 9, tail: 0, fill: 0 };
    const USED: SsaEntry = SsaEntry { head: 4, tail: 8, fill: 3 };

    #[test]
    fn a_read_that_meets_a_write_shows_what_is_written() {
        let mut table = cleared();
        let both = In { store_read: read(5), store_write: write(5, USED), ..nothing() };
        table.clock(both).unwrap();
        assert_eq!(table.moore(), Read { valid: true, data: USED });
    }

    /// The table is on chip, or behind a cache and, with sections there, an arbiter.
    #[test]
    fn what_is_not_needed_has_no_words() {
        for (cfg, expected) in [
            (small(true), [true, false, false]),
            (small_caching(true, false), [false, true, false]),
            (small_caching(true, true), [false, true, true]),
        ] {
            let mut memories = Chains::<FreeList>::memories(&cfg);
            let mut words = [0; 3];
            memories.visit("", &mut |path, storage| {
                let of = ["ssa.", "ssa_cache.", "turns."].map(|part| path.starts_with(part));
                if let Some(k) = of.iter().position(|is| *is) {
                    words[k] += storage.info().words;
                }
            });
            assert_eq!(words.map(|words| words > 0), expected, "{words:?}");
        }
    }

    #[test]
    fn both_users_reach_the_table() {
        let mut table = cleared();
        table.clock(In { lookup_read: read(2), ..nothing() }).unwrap();
        assert_eq!(table.moore(), Read { valid: true, data: NULL });
        table.clock(In { store_write: write(2, USED), ..nothing() }).unwrap();
        table.clock(In { lookup_read: read(2), ..nothing() }).unwrap();
        assert_eq!(table.moore(), Read { valid: true, data: USED });
        table.clock(In { lookup_write: write(2, NULL), ..nothing() }).unwrap();
        table.clock(In { store_read: read(2), ..nothing() }).unwrap();
        assert_eq!(table.moore(), Read { valid: true, data: NULL });
    }
}
