//! What commands take.

use super::keys::{Keys, Section};
use super::{PartError, read, table};
use std::path::Path;

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
    /// That of a user's file, from its section `[energy]`: the file of a part, or one with nothing else.
    ///
    /// # Errors
    /// The file cannot be read or is no TOML, or a key of the section is unknown, missing or out of its range.
    pub fn open(path: &Path) -> Result<Energy, PartError> {
        let (file, text) = read(path)?;
        Energy::read(&Section::new(Keys { file: &file }, "energy", &table(&file, &text)?)?)
    }

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
