//! Room in the computer's memory: for a machine's memories, and for what is read.

use pellucid_sim::{Memory, StorageInfo};
use std::fmt;
use std::str::FromStr;
use sysinfo::System;

/// Bytes that a machine's memories leave for all else.
const SPARE_BYTES: usize = 1 << 26;

/// A memory for which there is no room.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the machine's memories find no room in this computer: `{path}` has {words} words of {bits} bits; expected \
     parameters that make them smaller"
)]
pub struct NoRoom {
    /// The memory's path.
    pub path: String,
    /// Its words.
    pub words: u64,
    /// Bits of a word.
    pub bits: u32,
}

/// Makes room for all memories at power-up, and leaves some.
///
/// # Errors
/// The first memory for which there is none.
pub fn reserve(memories: &mut dyn Memory) -> Result<(), NoRoom> {
    let mut spare = Vec::<u8>::new();
    let mut there_is = spare.try_reserve_exact(SPARE_BYTES).is_ok();
    let mut done = Ok(());
    memories.visit("", &mut |path, storage| {
        there_is = there_is && storage.reserve().is_ok();
        if !there_is && done.is_ok() {
            let StorageInfo { words, bits_per_word: bits, .. } = storage.info();
            done = Err(NoRoom { path: path.to_string(), words, bits });
        }
    });
    // It is kept until all others are there.
    drop(std::hint::black_box(spare));
    done
}

/// The most memory that reading a scene may take: bytes, or as many KiB, MiB or GiB with `K`, `M` or `G` behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub struct Limit(u64);

/// A text that is no limit of memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no size of memory: expected a whole number of bytes, or one with K, M or G behind, as `4G`"
)]
pub struct LimitError(String);

/// Units of a limit.
const UNITS: [(char, u32); 3] = [('G', 30), ('M', 20), ('K', 10)];

impl FromStr for Limit {
    type Err = LimitError;

    fn from_str(text: &str) -> Result<Limit, LimitError> {
        let unit =
            UNITS.into_iter().find(|(unit, _)| text.ends_with([*unit, unit.to_ascii_lowercase()]));
        let (digits, bits) = unit.map_or((text, 0), |(_, bits)| (&text[..text.len() - 1], bits));
        let number = digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok());
        let bytes = number.flatten().and_then(|number: u64| number.checked_mul(1 << bits));
        bytes.map(Limit).ok_or_else(|| LimitError(text.into()))
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let unit =
            UNITS.into_iter().find(|(_, bits)| self.0 > 0 && self.0.is_multiple_of(1 << bits));
        match unit {
            Some((unit, bits)) => write!(f, "{}{unit}", self.0 >> bits),
            None => self.0.fmt(f),
        }
    }
}

impl Limit {
    /// Half of the memory that this computer has left, for this process if it has a limit of its own.
    fn of_this_computer() -> Limit {
        let left = System::new().map(|mut system| {
            system.refresh_memory();
            let own = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
            system.available_memory().min(own)
        });
        // In whole MiB, so that it can be told.
        Limit(left.unwrap_or(UNKNOWN) >> 21 << 20)
    }
}

/// Bytes that are taken to be left where the system does not say.
const UNKNOWN: u64 = 1 << 32;

/// What is read finds no room.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "does not fit into the memory that a scene may take, {0}; `--memory-limit` sets another limit"
)]
pub struct Full(Limit);

/// The room that is left for what is read.
#[derive(Debug)]
pub struct Room {
    limit: Limit,
    taken: u64,
}

impl Room {
    /// All the room up to a limit, or as much as this computer can well give.
    pub fn new(limit: Option<Limit>) -> Room {
        Room { limit: limit.unwrap_or_else(Limit::of_this_computer), taken: 0 }
    }

    /// Takes so many bytes of it.
    ///
    /// # Errors
    /// There is not as much left.
    pub fn take(&mut self, bytes: u64) -> Result<(), Full> {
        self.taken = self.taken.saturating_add(bytes);
        if self.taken > self.limit.0 { Err(Full(self.limit)) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_a_number_of_bytes_with_or_without_a_unit() {
        for (text, bytes, shown) in
            [("0", 0, "0"), ("1000", 1000, "1000"), ("3k", 3 << 10, "3K"), ("1024M", 1 << 30, "1G")]
        {
            let limit: Limit = text.parse().unwrap();
            assert_eq!((limit, limit.to_string()), (Limit(bytes), shown.to_owned()));
        }
        for text in ["", "G", "-1", "+1", "1.5G", "4GB", "18446744073709551616", "17179869184G"] {
            let error = text.parse::<Limit>().unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("`{text}` is no size of memory: expected ")),
                "{error}"
            );
        }
    }

    #[test]
    fn room_is_taken_up_to_the_limit() {
        let mut room = Room::new(Some(Limit(10)));
        assert_eq!(room.take(10), Ok(()));
        assert_eq!(room.take(1), Err(Full(Limit(10))));
        assert!(Room::new(None).limit > Limit(1 << 20), "a computer has some memory");
    }
}
