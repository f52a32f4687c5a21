//! Room for a machine's memories in the computer's.

use pellucid_sim::{Memory, StorageInfo};

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
