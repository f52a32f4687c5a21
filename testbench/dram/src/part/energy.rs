//! What commands take.

use super::PartError;
use super::keys::Section;

/// Energy by commands, of all devices of a rank together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Energy {
    /// An activate and the precharge that follows it, pJ.
    pub activate_pj: u64,
    /// A burst that is read, pJ.
    pub read_pj: u64,
    /// A burst that is written, pJ.
    pub write_pj: u64,
    /// A refresh of all banks, pJ; that of a bank takes its share.
    pub refresh_pj: u64,
    /// What a rank takes all the time, mW.
    pub background_mw: u64,
}

/// The most pJ of a command, and the most mW.
const MOST: u64 = 1_000_000_000;

impl Energy {
    /// From a file's section.
    pub(super) fn read(section: &Section) -> Result<Energy, PartError> {
        section.known(&["activate_pj", "read_pj", "write_pj", "refresh_pj", "background_mw"])?;
        let number = |key| section.number(key, 0, MOST);
        Ok(Energy {
            activate_pj: number("activate_pj")?,
            read_pj: number("read_pj")?,
            write_pj: number("write_pj")?,
            refresh_pj: number("refresh_pj")?,
            background_mw: number("background_mw")?,
        })
    }
}
