//! A bit for each section, in registers, and a priority encoder that finds the lowest free one.
//!
//! ```text
//!             +--------+
//!   take ---->|        |---> grant
//!  release -->| Bitmap |---> exhausted
//!             +--------+
//! ```
//! One grant and one release a cycle, and no memory: for few sections, up to 4096, of which the
//! lowest are used again and again. What is offered is held in a register until it is taken; while another one
//! is taken, the encoder looks at all bits, with that of the section which comes back in the same cycle.

use super::{Allocator, Config, Contract, In, Lent, Moore};
use crate::bits::{WORD_BITS, WORD_SHIFT, bit, lowest, rest};
use pellucid_sim::Block;
use pellucid_sim::{Signals, Stream, check_range, rtl};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Bitmap;

const MAX_WORDS: usize = 64;

impl Contract for Bitmap {
    const MOST: u32 = WORD_BITS * MAX_WORDS as u32;
}

impl Allocator for Bitmap {}

impl Config {
    /// Words of a bitmap.
    fn words(&self) -> u32 {
        self.sections.div_ceil(WORD_BITS)
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Which sections are free, but for the one that is offered.
    #[width(WORD_BITS)]
    #[len(cfg.words())]
    pub free: [u64; MAX_WORDS],
    /// What is offered.
    #[with(cfg.id_bits())]
    pub offer: Stream<u32>,
}

#[rtl(
    check(Bitmap, Config { sections: 1 }),
    check(Bitmap, Config { sections: 6 }),
    check(Bitmap, Config { sections: 150 })
)]
impl Block for Bitmap {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        check_range("the number of sections of a bitmap allocator", cfg.sections, ..=Bitmap::MOST);
        let free = std::array::from_fn(|k| {
            let here = cfg.sections.saturating_sub(k as u32 * WORD_BITS).min(WORD_BITS);
            let all = u64::MAX.checked_shr(WORD_BITS - here).unwrap_or(0);
            // The first one is offered.
            if k == 0 { all & !1 } else { all }
        });
        let offer = if cfg.sections > 0 { Stream::offer(0) } else { Stream::idle() };
        State { free, offer }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { grant: q.offer, exhausted: !q.offer.valid }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Lent {
        let wanted = i.take || !q.offer.valid;
        let back = i.release.payload;
        let mut at = 0;
        let mut found = false;
        for k in 0..cfg.words() {
            let here = i.release.valid && back >> WORD_SHIFT == k;
            let free = if here { q.free[k as usize] | bit(back) } else { q.free[k as usize] };
            let first = wanted && !found && free != 0;
            if first {
                at = k * WORD_BITS + lowest(free);
            }
            found |= first;
            d.free[k as usize] = if first { rest(free) } else { free };
        }
        if wanted {
            d.offer = Stream { valid: found, payload: at };
        }
        Lent::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;

    /// Over the ends of words, up to the last.
    #[test]
    fn the_lowest_goes_first() {
        for sections in [1, 63, 64, 65, 150, Bitmap::MOST] {
            let mut sim = Sim::<Bitmap>::new(Config { sections });
            for id in 0..sections {
                assert_eq!(sim.moore().grant, Stream::offer(id), "of {sections}");
                sim.clock(In { take: true, ..In::default() }).unwrap();
            }
            assert!(sim.moore().exhausted && !sim.moore().grant.valid);
            for id in [sections - 1, 0, sections / 2] {
                sim.clock(In { release: Stream::offer(id), ..In::default() }).unwrap();
            }
            // The first that came back was offered at once.
            let mut expected = vec![sections - 1];
            expected.extend([0, sections / 2].into_iter().filter(|_| sections > 2));
            for id in expected {
                assert_eq!(sim.moore().grant, Stream::offer(id), "of {sections}");
                sim.clock(In { take: true, ..In::default() }).unwrap();
            }
        }
    }

    #[test]
    #[should_panic(
        expected = "the number of sections of a bitmap allocator is 4097: expected at most 4096"
    )]
    fn more_sections_than_bits_are_too_many() {
        Bitmap::reset(&Config { sections: Bitmap::MOST + 1 });
    }
}
