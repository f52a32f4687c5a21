//! The times of a device.

use super::PartError;
use super::keys::Section;

/// Timing of the refresh of single banks, in clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BankRefresh {
    /// How long the bank is busy.
    pub rfc: u64,
    /// From one bank's refresh to the next one's of the same rank.
    pub to_refresh: u64,
    /// From one bank's refresh to an activate of another bank of the rank.
    pub to_activate: u64,
}

/// More than any device has, of clocks and of ps.
const MOST: u64 = 1_000_000;

/// Declares the times that every part has: keys of the file and fields of [`Timing`], in clocks.
macro_rules! timing {
    ($($(#[$about:meta])+ $key:ident,)*) => {
        /// Timing of a device, in clocks of `tck_ps`; names as in JEDEC's standards.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Timing {
            /// Period of the device's clock, ps.
            pub tck_ps: u64,
            $($(#[$about])+ pub $key: u64,)*
            /// Refresh of single banks, where the device has it: `rfc_bank`, `pbr2pbr`, `pbr2act`.
            pub bank_refresh: Option<BankRefresh>,
        }

        impl Timing {
            /// From a file's section.
            pub(super) fn read(section: &Section) -> Result<Timing, PartError> {
                let known = [&["tck_ps", $(stringify!($key)),*][..], &BankRefresh::KEYS].concat();
                section.known(&known)?;
                let time = |key| section.number(key, 1, MOST);
                Ok(Timing {
                    tck_ps: time("tck_ps")?,
                    $($key: time(stringify!($key))?,)*
                    bank_refresh: BankRefresh::read(section)?,
                })
            }
        }
    };
}

impl BankRefresh {
    const KEYS: [&'static str; 3] = ["rfc_bank", "pbr2pbr", "pbr2act"];

    fn read(section: &Section) -> Result<Option<BankRefresh>, PartError> {
        if !Self::KEYS.iter().any(|key| section.has(key)) {
            return Ok(None);
        }
        let [rfc, to_refresh, to_activate] = Self::KEYS.map(|key| section.number(key, 1, MOST));
        Ok(Some(BankRefresh { rfc: rfc?, to_refresh: to_refresh?, to_activate: to_activate? }))
    }
}

timing! {
    /// Clocks for which a burst has the data bus.
    burst,
    /// From a read to the begin of its data.
    cl,
    /// From a write to the begin of its data.
    cwl,
    /// From an activate to a read of the bank.
    rcd_read,
    /// From an activate to a write of the bank.
    rcd_write,
    /// From a precharge to an activate of the bank.
    rp,
    /// From an activate to a precharge of the bank.
    ras,
    /// From an activate to the next one of the bank.
    rc,
    /// From a read to a precharge of the bank.
    rtp,
    /// From the end of a write's data to a precharge of the bank.
    wr,
    /// From a read to a read, or a write to a write, of another bank group.
    ccd_s,
    /// The same within a bank group.
    ccd_l,
    /// From an activate to one in another bank group.
    rrd_s,
    /// The same within a bank group.
    rrd_l,
    /// In which at most four activates of a rank begin.
    faw,
    /// From the end of a write's data to a read of another bank group.
    wtr_s,
    /// The same within a bank group.
    wtr_l,
    /// From a read to a write of the same rank.
    rtw,
    /// For which the data bus rests between bursts of two ranks.
    rank_switch,
    /// From a precharge to the next one of the rank.
    ppd,
    /// Between refreshes of a rank; refreshes of single banks share it evenly.
    refi,
    /// How long a refresh of all banks takes.
    rfc,
}
