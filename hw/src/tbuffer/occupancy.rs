//! The occupancy bitmap: one bit per pixel, set while the pixel has fragments.
//!
//! ```text
//!  store read, write --->+-----------+
//!  scan read, write ---->| Occupancy |---> word
//!  clear --------------->+-----------+
//! ```
//! A word holds the bits of [`OCCUPANCY_BITS`] pixels. One read and one write a cycle; a read that
//! meets a write of the same word shows what is written. With `scan=linear` it does not exist.

use super::config::{Config, OCCUPANCY_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Stream, WritePort};

/// See the module's description.
pub struct Occupancy;

/// Inputs.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// The store unit's read.
    pub store_read: ReadPort,
    /// The store unit's write.
    pub store_write: WritePort<u64>,
    /// The scanner's read.
    pub scan_read: ReadPort,
    /// The scanner's write: 0.
    pub scan_write: WritePort<u64>,
    /// A word that is set to 0, if there is one of that number.
    pub clear: Stream<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// One bit per pixel.
    pub bitmap: Ram1R1W<u64>,
}

impl Block for Occupancy {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = Read<u64>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}

    fn memories(cfg: &Config) -> Mem {
        let words = if cfg.bitmap { cfg.occupancy_words() } else { 0 };
        Mem { bitmap: Ram1R1W::new(words, OCCUPANCY_BITS, 1, ReadDuringWrite::New) }
    }

    #[inline(always)]
    fn moore(_: &Config, (): &(), m: &Self::Mem) -> Read<u64> {
        m.bitmap.q()
    }

    #[inline(always)]
    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Self::Mem, i: In) {
        m.bitmap.pass_read(i.store_read);
        m.bitmap.pass_read(i.scan_read);
        m.bitmap.pass_write(i.store_write);
        m.bitmap.pass_write(i.scan_write);
        if cfg.bitmap && i.clear.valid && i.clear.payload < cfg.occupancy_words() {
            m.bitmap.write(i.clear.payload, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tbuffer::config::{Params, Scan};
    use crate::test_util::{Table, screen, traffic};

    /// 130 pixels: two words and a part of a third.
    fn bitmap(scan: Scan) -> Table<Occupancy> {
        let params = Params { scan, ..Params::default() };
        Table::new(Config::new(screen(13, 10), params).unwrap())
    }

    fn clear(word: u32) -> In {
        let (read, write) = (ReadPort::default(), WritePort::default());
        let clear = Stream::offer(word);
        In { store_read: read, store_write: write, scan_read: read, scan_write: write, clear }
    }

    #[test]
    fn a_clear_beyond_the_last_word_is_ignored() {
        let mut table = bitmap(Scan::Bitmap);
        for word in 0..130 {
            table.clock(clear(word)).unwrap();
        }
        assert_eq!(traffic(table.memories()), (0, 3));
    }

    #[test]
    fn with_a_linear_scan_it_does_not_exist() {
        let mut table = bitmap(Scan::Linear);
        table.clock(clear(0)).unwrap();
        table.memories().visit("", &mut |_, bitmap| assert_eq!(bitmap.info().words, 0));
    }

    #[test]
    fn both_users_reach_it_and_a_read_meets_the_write_of_its_cycle() {
        let mut table = bitmap(Scan::Bitmap);
        let (mut read, mut write) = (ReadPort::default(), WritePort::default());
        read.read(2);
        write.write(2, 0b11);
        let nothing = In { clear: Stream::idle(), ..clear(0) };
        table.clock(In { store_read: read, store_write: write, ..nothing }).unwrap();
        assert_eq!(table.moore(), Read { valid: true, data: 0b11 });
        write = WritePort::default();
        write.write(2, 0);
        table.clock(In { scan_write: write, ..nothing }).unwrap();
        table.clock(In { scan_read: read, ..nothing }).unwrap();
        assert_eq!(table.moore(), Read { valid: true, data: 0 });
    }
}
