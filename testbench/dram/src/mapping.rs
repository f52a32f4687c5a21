//! Which address is in which channel, bank and row.

use crate::config::Config;
use crate::names::names;

names! {
    /// The order of the parts of an address, from the most significant one. The channel, with the pseudo-channel, always
    /// comes last, so that neighbouring bursts are in different channels. Ranks stand with the banks.
    pub enum Mapping: "mapping" {
        /// Row, bank, group, column: neighbouring bursts are in one row, and bound by `ccd_l`.
        RowBankColumn = "row-bank-column",
        /// Row, column, bank, group: neighbouring bursts are in different banks.
        RowColumnBank = "row-column-bank",
        /// Bank, group, row, column: neighbouring rows are in one bank.
        BankRowColumn = "bank-row-column",
        /// Row, bank, column, group: neighbouring bursts are in one row of each group, bound by `ccd_s`.
        RowBankColumnGroup = "row-bank-column-group",
    }
}

/// Where a burst is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The channel.
    pub channel: usize,
    /// The bank of the channel: pseudo-channels, their ranks, bank groups and banks counted through.
    pub bank: usize,
    /// The row.
    pub row: u64,
    /// The burst of the row.
    pub column: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Field {
    shift: u32,
    mask: u64,
}

impl Field {
    fn of(self, burst: u64) -> u64 {
        burst >> self.shift & self.mask
    }
}

/// Cuts addresses into parts.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    burst_shift: u32,
    bits: u32,
    channel: Field,
    pseudo: Field,
    group: Field,
    bank: Field,
    rank: Field,
    row: Field,
    column: Field,
}

impl Layout {
    pub(crate) fn new(config: &Config) -> Layout {
        let o = &config.part.organisation;
        let mut next = 0;
        let mut field = |size: u64| {
            let shift = next;
            next += size.ilog2();
            Field { shift, mask: size - 1 }
        };
        let channel = field(u64::from(config.channels));
        let pseudo = field(u64::from(o.pseudo_channels));
        let (groups, banks) = (u64::from(o.bank_groups), u64::from(o.banks));
        let (ranks, rows, columns) = (u64::from(config.ranks), u64::from(o.rows), o.bursts());
        let (group, bank, rank, row, column);
        match config.mapping {
            Mapping::RowBankColumn => {
                (column, group, bank) = (field(columns), field(groups), field(banks));
                (rank, row) = (field(ranks), field(rows));
            }
            Mapping::RowColumnBank => {
                (group, bank, rank) = (field(groups), field(banks), field(ranks));
                (column, row) = (field(columns), field(rows));
            }
            Mapping::BankRowColumn => {
                (column, row) = (field(columns), field(rows));
                (group, bank, rank) = (field(groups), field(banks), field(ranks));
            }
            Mapping::RowBankColumnGroup => {
                (group, column, bank) = (field(groups), field(columns), field(banks));
                (rank, row) = (field(ranks), field(rows));
            }
        }
        let burst_shift = o.burst_bytes().ilog2();
        Layout { burst_shift, bits: next, channel, pseudo, group, bank, rank, row, column }
    }

    /// The burst that a byte is in; addresses past the capacity begin again at 0.
    pub fn burst(&self, address: u64) -> u64 {
        (address >> self.burst_shift) & ((1 << self.bits) - 1)
    }

    /// Bytes of all channels together.
    pub fn capacity(&self) -> u128 {
        1 << (self.bits + self.burst_shift)
    }

    /// Where a burst is.
    pub fn place(&self, burst: u64) -> Place {
        let mut bank = self.pseudo.of(burst);
        for field in [self.rank, self.group, self.bank] {
            bank = bank * (field.mask + 1) + field.of(burst);
        }
        Place {
            channel: self.channel.of(burst) as usize,
            bank: bank as usize,
            row: self.row.of(burst),
            column: self.column.of(burst),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Part;

    fn layout(part: &str, mapping: Mapping) -> Layout {
        let config =
            Config { mapping, channels: 2, ranks: 2, ..Config::new(Part::named(part).unwrap()) };
        Layout::new(&config)
    }

    /// Addresses of DDR4 by hand: 64 bytes a burst, 2 channels, 128 bursts a row, 4 groups of 4 banks, 2 ranks.
    #[test]
    fn by_hand() {
        let place = |mapping, burst: u64| {
            let layout = layout("ddr4-3200", mapping);
            let place = layout.place(layout.burst(burst * 64 + 63));
            (place.channel, place.bank, place.row, place.column)
        };
        for &mapping in Mapping::ALL {
            assert_eq!(place(mapping, 0), (0, 0, 0, 0));
            assert_eq!(place(mapping, 1), (1, 0, 0, 0));
        }
        assert_eq!(place(Mapping::RowBankColumn, 2), (0, 0, 0, 1));
        assert_eq!(place(Mapping::RowBankColumn, 256), (0, 4, 0, 0));
        assert_eq!(place(Mapping::RowBankColumn, 256 * 4), (0, 1, 0, 0));
        assert_eq!(place(Mapping::RowBankColumn, 256 * 32 + 256 * 16), (0, 16, 1, 0));
        assert_eq!(place(Mapping::RowColumnBank, 2), (0, 4, 0, 0));
        assert_eq!(place(Mapping::RowColumnBank, 8), (0, 1, 0, 0));
        assert_eq!(place(Mapping::RowColumnBank, 64), (0, 0, 0, 1));
        assert_eq!(place(Mapping::BankRowColumn, 256), (0, 0, 1, 0));
        assert_eq!(place(Mapping::BankRowColumn, 256 << 16), (0, 4, 0, 0));
        assert_eq!(place(Mapping::RowBankColumnGroup, 2), (0, 4, 0, 0));
        assert_eq!(place(Mapping::RowBankColumnGroup, 8), (0, 0, 0, 1));
        assert_eq!(place(Mapping::RowBankColumnGroup, 8 * 128), (0, 1, 0, 0));
    }

    /// Every place has one address, and addresses past the capacity are those at the start.
    #[test]
    fn one_address_each() {
        let text = Part::file("hbm3-6400").unwrap().replace("rows = 16384", "rows = 4");
        let part = Part::parse("small", &text).unwrap();
        for &mapping in Mapping::ALL {
            let layout = Layout::new(&Config {
                mapping,
                channels: 4,
                ranks: 2,
                ..Config::new(part.clone())
            });
            let bursts = 4 * 2 * 2 * 16 * 4 * 32;
            assert_eq!(layout.capacity(), bursts * 32);
            let mut seen = vec![false; bursts as usize];
            for burst in 0..bursts as u64 {
                let Place { channel, bank, row, column } = layout.place(burst);
                assert!(bank < 64 && row < 4 && column < 32);
                let index = ((channel * 64 + bank) * 4 + row as usize) * 32 + column as usize;
                assert!(!std::mem::replace(&mut seen[index], true), "{mapping}: twice {burst}");
                assert_eq!(layout.burst((burst + bursts as u64) * 32), burst);
            }
        }
    }
}
