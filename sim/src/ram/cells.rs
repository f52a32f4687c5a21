//! The words of a memory as they are held: as Rust values, or, where a word has few bits, packed bit by
//! bit, so that a few bits of every pixel of a large screen take just these.

use crate::signals::{Declare, Kind, Signals, Sink, width_of};
use bitvec::field::BitField;
use bitvec::vec::BitVec;
use std::collections::TryReserveError;

/// The widest word that is packed.
const PACKED_BITS: u32 = 4;

/// See the module's description.
pub(super) enum Cells<T> {
    /// As Rust values.
    Values(Vec<T>),
    /// Packed.
    Packed(Packed),
}

/// Words of few bits, one right behind the other.
pub(super) struct Packed {
    bits: BitVec<u64>,
    /// Widths of a word's signals.
    widths: Vec<u32>,
    /// Bits of a word.
    width: usize,
}

impl Declare for Vec<u32> {
    fn open(&mut self, _: &str) {}
    fn close(&mut self) {}
    fn signal(&mut self, _: &str, width: u32, _: Kind) {
        self.push(width);
    }
}

/// A word that is being put together.
struct Word<'a> {
    value: u64,
    at: u32,
    widths: std::slice::Iter<'a, u32>,
}

impl Sink for Word<'_> {
    #[inline(always)]
    fn push(&mut self, value: u64) {
        self.value |= value << self.at;
        self.at += self.widths.next().copied().unwrap_or_default();
    }
}

impl<T: Signals + Default> Cells<T> {
    /// No word yet.
    pub(super) fn new(item: &T::Config) -> Cells<T> {
        let width = width_of::<T>(item);
        if !(1..=PACKED_BITS).contains(&width) {
            return Cells::Values(vec![]);
        }
        let mut widths = vec![];
        T::declare(item, "", &mut widths);
        Cells::Packed(Packed { bits: BitVec::new(), widths, width: width as usize })
    }

    /// Makes room for `words`, before there is one.
    ///
    /// # Errors
    /// There is no room.
    pub(super) fn reserve(&mut self, words: usize) -> Result<(), TryReserveError> {
        match self {
            Cells::Values(values) => values.try_reserve_exact(words),
            Cells::Packed(packed) => {
                let mut room = vec![];
                room.try_reserve_exact((words * packed.width).div_ceil(u64::BITS as usize))?;
                packed.bits = BitVec::from_vec(room);
                Ok(())
            }
        }
    }

    /// Makes it `words` words long; new ones are 0.
    pub(super) fn resize(&mut self, words: usize) {
        match self {
            Cells::Values(values) => values.resize(words, T::default()),
            Cells::Packed(packed) => packed.bits.resize(words * packed.width, false),
        }
    }

    /// Puts the word at `addr` into `to`; whether there is one.
    #[inline(always)]
    pub(super) fn get(&self, item: &T::Config, addr: u32, to: &mut T) -> bool {
        let done = match self {
            Cells::Values(values) => values.get(addr as usize).map(|word| *to = *word),
            Cells::Packed(packed) => packed.get(item, addr).map(|word| *to = word),
        };
        done.is_some()
    }

    /// Puts a word at `addr`; whether there is one.
    #[inline(always)]
    pub(super) fn set(&mut self, item: &T::Config, addr: u32, data: T) -> bool {
        match self {
            Cells::Values(values) => {
                values.get_mut(addr as usize).map(|word| *word = data).is_some()
            }
            Cells::Packed(packed) => packed.set(item, addr, data),
        }
    }
}

impl Packed {
    fn range(&self, addr: u32) -> std::ops::Range<usize> {
        let from = addr as usize * self.width;
        from..from + self.width
    }

    fn get<T: Signals>(&self, item: &T::Config, addr: u32) -> Option<T> {
        let value: u64 = self.bits.get(self.range(addr))?.load_le();
        let mut at = 0;
        let mut values = self.widths.iter().map(|width| {
            let signal = value >> at & ((1 << width) - 1);
            at += width;
            signal
        });
        Some(T::restore(item, &mut values))
    }

    fn set<T: Signals>(&mut self, item: &T::Config, addr: u32, data: T) -> bool {
        let mut word = Word { value: 0, at: 0, widths: self.widths.iter() };
        data.sample(item, &mut word);
        let range = self.range(addr);
        self.bits.get_mut(range).map(|bits| bits.store_le(word.value)).is_some()
    }
}
