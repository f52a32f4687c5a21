//! The occupancy bitmap: one bit per pixel, set while the pixel has fragments, and a summary with one
//! bit per word of the bitmap, set while the word has a bit.
//!
//! ```text
//!  ask, set (pixel) -------------->+-----------+
//!  word and summary: read, clear ->| Occupancy |---> word, summary
//!  clear ------------------------->+-----------+
//! ```
//! A word holds [`WORD_BITS`] bits. The store unit asks for a pixel, and may set it in any later
//! cycle until it asks again; a pixel may be set and the next one asked for in one cycle. With
//! `scan=linear` it does not exist.

use super::config::Config;
use crate::bits::{WORD_BITS, WORD_SHIFT, bit};
use pellucid_sim::{
    Block, Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort, rtl,
};

/// See the module's description.
pub struct Occupancy;

/// Inputs; nothing is asked by default.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// A pixel that may be set.
    #[with(cfg.screen.pixel_bits())]
    pub ask: Stream<u32>,
    /// The pixel that was asked for last is set.
    #[with(cfg.screen.pixel_bits())]
    pub set: Stream<u32>,
    /// The scanner reads a summary word.
    #[with(cfg.word_bits())]
    pub summary_read: ReadPort,
    /// The scanner clears a summary word.
    #[with(cfg.word_bits(), WORD_BITS)]
    pub summary_clear: WritePort<u64>,
    /// The scanner reads a word.
    #[with(cfg.word_bits())]
    pub word_read: ReadPort,
    /// The scanner clears a word.
    #[with(cfg.word_bits(), WORD_BITS)]
    pub word_clear: WritePort<u64>,
    /// A number: the words of the bitmap and of the summary that have it are set to 0.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Moore {
    /// A word of the summary.
    #[with(WORD_BITS)]
    pub summary: Read<u64>,
    /// A word of the bitmap.
    #[with(WORD_BITS)]
    pub word: Read<u64>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// One bit per pixel.
    pub bitmap: Ram1R1W<u64>,
    /// One bit per word of the bitmap.
    pub summary: Ram1R1W<u64>,
}

impl Config {
    /// Words of the bitmap.
    pub fn occupancy_words(&self) -> u32 {
        self.screen.pixels().div_ceil(WORD_BITS)
    }
    /// Words of the summary.
    pub fn summary_words(&self) -> u32 {
        self.occupancy_words().div_ceil(WORD_BITS)
    }
}

#[rtl(check(Occupancy, crate::test_util::small(true)))]
impl Block for Occupancy {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let ram = |words| {
            let words = if cfg.shape.bitmap { words } else { 0 };
            Ram1R1W::new(words, WORD_BITS, 1, ReadDuringWrite::New)
        };
        Mem { bitmap: ram(cfg.occupancy_words()), summary: ram(cfg.summary_words()) }
    }

    fn moore(_: &Config, (): &(), m: &Mem) -> Moore {
        Moore { summary: m.summary.q(), word: m.bitmap.q() }
    }

    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Mem, i: In) {
        if i.set.valid {
            let word = i.set.payload >> WORD_SHIFT;
            m.bitmap.write(word, m.bitmap.q().data | bit(i.set.payload));
            if m.summary.q().data & bit(word) == 0 {
                m.summary.write(word >> WORD_SHIFT, m.summary.q().data | bit(word));
            }
        }
        if i.ask.valid {
            let word = i.ask.payload >> WORD_SHIFT;
            m.bitmap.read(word);
            m.summary.read(word >> WORD_SHIFT);
        }
        m.bitmap.pass_read(i.word_read);
        m.bitmap.pass_write(i.word_clear);
        m.summary.pass_read(i.summary_read);
        m.summary.pass_write(i.summary_clear);
        if i.clear.valid && i.clear.payload < cfg.occupancy_words() {
            m.bitmap.write(i.clear.payload, 0);
        }
        if i.clear.valid && i.clear.payload < cfg.summary_words() {
            m.summary.write(i.clear.payload, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chains::config::Shape;
    use crate::test_util::{Clocked, screen, shape, traffic};

    /// 5000 pixels: 79 words, of which the last is not full, and two words of summary.
    fn bitmap(bitmap: bool) -> Clocked<Occupancy> {
        let shape = Shape { bitmap, ..shape() };
        Clocked::new(Config::new(screen(100, 50), shape))
    }

    /// After reset.
    fn cleared() -> Clocked<Occupancy> {
        let mut table = bitmap(true);
        for word in 0..5000 {
            table.clock(In { clear: Stream::offer(word), ..In::default() }).unwrap();
        }
        table
    }

    fn read(table: &mut Clocked<Occupancy>, summary: u32, word: u32) -> (u64, u64) {
        let mut i = In::default();
        i.summary_read.read(summary);
        i.word_read.read(word);
        table.clock(i).unwrap();
        let Moore { summary, word } = table.moore();
        (summary.data, word.data)
    }

    #[test]
    fn a_clear_beyond_the_last_word_is_ignored() {
        assert_eq!(traffic(cleared().memories()), (0, 79 + 2));
    }

    #[test]
    fn with_a_linear_scan_it_does_not_exist() {
        let mut table = bitmap(false);
        table.memories().visit("", &mut |_, bitmap| assert_eq!(bitmap.info().words, 0));
    }

    #[test]
    fn pixels_are_set_in_bitmap_and_summary_one_a_cycle() {
        let mut table = cleared();
        // Two in one word, two in another that is in the second word of the summary.
        let pixels = [3, 9, 4996, 4999];
        let asks = pixels.map(Stream::offer).into_iter().chain([Stream::idle()]);
        let sets = [Stream::idle()].into_iter().chain(pixels.map(Stream::offer));
        for (ask, set) in asks.zip(sets) {
            table.clock(In { ask, set, ..In::default() }).unwrap();
        }
        assert_eq!(read(&mut table, 0, 0), (1, 1 << 3 | 1 << 9));
        assert_eq!(read(&mut table, 1, 78), (1 << (78 - 64), 1 << 4 | 1 << 7));
        assert_eq!(read(&mut table, 0, 77), (1, 0));
    }

    #[test]
    fn the_scanner_clears_words() {
        let mut table = cleared();
        table.clock(In { ask: Stream::offer(70), ..In::default() }).unwrap();
        table.clock(In { set: Stream::offer(70), ..In::default() }).unwrap();
        assert_eq!(read(&mut table, 0, 1), (0b10, 1 << 6));
        let mut i = In::default();
        i.summary_clear.write(0, 0);
        i.word_clear.write(1, 0);
        table.clock(i).unwrap();
        assert_eq!(read(&mut table, 0, 1), (0, 0));
    }
}
