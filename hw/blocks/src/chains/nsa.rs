//! The NSA table: for each section the one that follows it in its pixel's chain.
//!
//! ```text
//!  store (read or write) --->+-----+
//!  chain (read) ------------>| Nsa |---> entry
//!  lent (read, write) ------>|     |
//!                            +-----+
//! ```
//! One access a cycle; a read shows its entry in the next cycle and keeps it until the next read. Where the
//! entries of free sections are lent to the allocator, the table has a read and a write port: one read and
//! one write a cycle, never of the same entry.

use super::config::Config;
use super::tables::NsaEntry;
use crate::allocator::Lent;
use pellucid_sim::Block;
use pellucid_sim::{Memory, Port, Ram1R1W, Ram1RW, Read, ReadDuringWrite, Signals, rtl};

/// See the module's description.
pub struct Nsa;

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// The store unit's access.
    #[with(cfg.id_bits(), *cfg)]
    pub store: Port<NsaEntry>,
    /// The chain reader's access.
    #[with(cfg.id_bits(), *cfg)]
    pub chain: Port<NsaEntry>,
    /// The allocator's accesses to entries of free sections.
    #[with(cfg.section_numbers())]
    pub lent: Lent,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// One entry per section.
    pub table: Ram1RW<NsaEntry>,
    /// The same, where entries are lent.
    pub lent: Ram1R1W<NsaEntry>,
}

#[rtl(
    check(Nsa, crate::test_util::small(true)),
    check(Nsa, crate::test_util::small(false)),
    check(Nsa, crate::test_util::small_lending())
)]
impl Block for Nsa {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<NsaEntry>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let (own, lent) = if cfg.lends() { (0, cfg.null) } else { (cfg.null, 0) };
        Mem {
            table: Ram1RW::new(own, *cfg, 1),
            lent: Ram1R1W::new(lent, *cfg, 1, ReadDuringWrite::Forbidden),
        }
    }

    fn moore(cfg: &Config, (): &(), m: &Self::Mem) -> Read<NsaEntry> {
        if cfg.lends() { m.lent.q() } else { m.table.q() }
    }

    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Self::Mem, i: In) {
        if cfg.lends() {
            m.lent.pass(i.store);
            m.lent.pass(i.chain);
            if i.lent.read.valid {
                m.lent.read(i.lent.read.payload);
            }
            if i.lent.write.valid {
                m.lent.write(i.lent.write.payload, NsaEntry { next: i.lent.word, fill: 0 });
            }
        } else {
            m.table.pass(i.store);
            m.table.pass(i.chain);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chains::config::Shape;
    use crate::test_util::{Clocked, screen, shape};
    use pellucid_sim::FaultKind;

    fn table() -> Clocked<Nsa> {
        let shape = Shape { on_chip: 7, outside: 2, ..shape() };
        Clocked::new(Config::new(screen(3, 2), shape))
    }

    #[test]
    fn every_section_has_an_entry() {
        let mut table = table();
        for section in 0..9 {
            let mut store = Port::default();
            store.write(section, NsaEntry { next: 9 - section, fill: 0 });
            table.clock(In { store, chain: Port::default(), lent: Lent::default() }).unwrap();
        }
        for section in 0..9 {
            let mut chain = Port::default();
            chain.read(section);
            table.clock(In { store: Port::default(), chain, lent: Lent::default() }).unwrap();
            let data = NsaEntry { next: 9 - section, fill: 0 };
            assert_eq!(table.moore(), Read { valid: true, data });
        }
    }

    #[test]
    fn two_users_at_once_are_a_fault() {
        let mut port = Port::default();
        port.write(3, NsaEntry::default());
        let fault =
            table().clock(In { store: port, chain: port, lent: Lent::default() }).unwrap_err();
        assert_eq!(fault, FaultKind::PortUsedTwice("only"));
    }
}
