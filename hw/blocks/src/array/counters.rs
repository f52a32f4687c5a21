//! The counters: for each pixel how many fragments it has, several of them in a word.
//!
//! ```text
//!  index read, write ---->+----------+
//!  sum read, write ------>| Counters |---> counts
//!  walk read, write ----->|          |
//!  clear ---------------->+----------+
//! ```
//! One read and one write a cycle; a read shows its word in the next cycle, a read that meets a write of the same word shows
//! what is written: two fragments of one pixel may come in a row. `clear` sets words to 0 after reset. Where they lie
//! outside there are none of them here: a word of [`Counts`] is an [`Entry`](cached_table::Entry) of a table there.

use super::config::{Config, MAX_LANES};
use crate::cached_table;
use pellucid_machine::outside;
use pellucid_sim::Block;
use pellucid_sim::{
    Label, Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort, rtl,
};

/// See the module's description.
pub struct Counters;

/// A word: the counters of pixels that follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Counts {
    /// Each one's.
    #[width(cfg.shape.count_bits)]
    #[len(cfg.shape.lanes)]
    pub of: [u32; MAX_LANES],
}

#[rtl]
impl Counts {
    /// The first one lowest.
    #[inline(always)]
    fn word(cfg: &Config, counts: Counts) -> outside::Word {
        let mut low: u64 = 0;
        for lane in 0..cfg.shape.lanes {
            low |= u64::from(counts.of[lane as usize]) << (lane * cfg.shape.count_bits);
        }
        outside::Word { low, high: 0, label: Label::NONE }
    }
    #[inline(always)]
    fn of_word(cfg: &Config, word: outside::Word) -> Counts {
        let mut of = [0; MAX_LANES];
        for lane in 0..cfg.shape.lanes {
            of[lane as usize] =
                (word.low >> (lane * cfg.shape.count_bits) & cfg.count_mask()) as u32;
        }
        Counts { of }
    }
}

cached_table::entry!(Counts, Config, |_| Counts::default());

/// Inputs; nothing is asked by default.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// Reads the word of a fragment's pixel.
    #[with(cfg.word_bits())]
    pub index_read: ReadPort,
    /// Writes it.
    #[with(cfg.word_bits(), *cfg)]
    pub index_write: WritePort<Counts>,
    /// Reads what is summed up.
    #[with(cfg.word_bits())]
    pub sum_read: ReadPort,
    /// Clears it.
    #[with(cfg.word_bits(), *cfg)]
    pub sum_write: WritePort<Counts>,
    /// Reads what is read back.
    #[with(cfg.word_bits())]
    pub walk_read: ReadPort,
    /// Clears it.
    #[with(cfg.word_bits(), *cfg)]
    pub walk_write: WritePort<Counts>,
    /// A number: the word that has it, if there is one, is set to 0.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// All words.
    pub words: Ram1R1W<Counts>,
}

/// A cycle in which a word is [cleared](In::clear) and all else rests, with the memory; whether that is at fault. Nothing where the
/// words are cached, which takes longer.
pub fn clear_alone(cfg: &Config, m: &mut Mem, clear: Stream<u32>) -> Option<bool> {
    if cfg.caches() {
        return None;
    }
    Counters::next(cfg, &(), &mut (), m, In { clear, ..In::default() });
    Some(m.clock())
}

#[rtl(
    check(Counters, crate::test_util::arrays(4, true)),
    check(Counters, crate::test_util::arrays(1, false))
)]
impl Block for Counters {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<Counts>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let words = if cfg.caches() { 0 } else { cfg.words() };
        Mem { words: Ram1R1W::new(words, *cfg, 1, ReadDuringWrite::New) }
    }

    fn moore(_: &Config, (): &(), m: &Mem) -> Read<Counts> {
        m.words.q()
    }

    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Mem, i: In) {
        m.words.pass_read(i.index_read);
        m.words.pass_read(i.sum_read);
        m.words.pass_read(i.walk_read);
        m.words.pass_write(i.index_write);
        m.words.pass_write(i.sum_write);
        m.words.pass_write(i.walk_write);
        if i.clear.valid && i.clear.payload < cfg.words() {
            m.words.write(i.clear.payload, Counts::default());
        }
    }
}
