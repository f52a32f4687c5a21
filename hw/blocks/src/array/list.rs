//! The list of words: the words of counters that have a fragment, in the order in which they got their first one.
//!
//! ```text
//!  push ----->+----------+
//!  read ----->| WordList |---> count, word
//!  clear ---->+----------+
//! ```
//! One push and one read a cycle; a read shows its place in the next cycle. `clear` leaves the list empty. It holds every word
//! once; that none comes twice is up to whoever pushes.

use super::config::Config;
use pellucid_sim::Block;
use pellucid_sim::{Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, rtl};

/// See the module's description.
pub struct WordList;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct State {
    /// Words in the list.
    #[width(cfg.word_bits())]
    pub count: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Config)]
pub struct In {
    /// A word that gets its first fragment.
    #[with(cfg.word_bits())]
    pub push: Stream<u32>,
    /// Reads a place of the list.
    #[with(cfg.word_bits())]
    pub read: ReadPort,
    /// No word has a fragment any more. Not beside a push.
    pub clear: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Config)]
pub struct Moore {
    /// Words in the list.
    #[width(cfg.word_bits())]
    pub count: u32,
    /// The word that was asked for.
    #[with(cfg.word_bits())]
    pub word: Read<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The words.
    pub words: Ram1R1W<u32>,
}

#[rtl(check(WordList, crate::test_util::fixed().arrays))]
impl Block for WordList {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) -> State {
        State { count: 0 }
    }

    fn memories(cfg: &Config) -> Mem {
        let words = Ram1R1W::new(cfg.words(), cfg.word_bits(), 1, ReadDuringWrite::Forbidden);
        Mem { words }
    }

    fn moore(_: &Config, q: &State, m: &Mem) -> Moore {
        Moore { count: q.count, word: m.words.q() }
    }

    fn next(_: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) {
        m.words.pass_read(i.read);
        if i.push.valid {
            m.words.write(q.count, i.push.payload);
            d.count = q.count + 1;
        }
        if i.clear {
            d.count = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::Sim;
    use proptest::prelude::*;

    proptest! {
        /// Frame after frame: what was pushed since it was cleared, in that order.
        #[test]
        fn behaves_as_a_plain_list(
            frames in prop::collection::vec(prop::collection::vec(any::<bool>(), 0..30), 1..4),
        ) {
            let cfg = crate::test_util::fixed().arrays;
            let mut sim = Sim::<WordList>::new(cfg);
            for frame in frames {
                let mut expected = vec![];
                for (cycle, pushes) in (0..).zip(frame) {
                    let word = (7 * cycle + 3) % cfg.words();
                    let pushes = pushes && !expected.contains(&word);
                    let push = Stream { valid: pushes, payload: word };
                    sim.clock(In { push, ..In::default() }).unwrap();
                    expected.extend(pushes.then_some(word));
                }
                prop_assert_eq!(sim.moore().count, expected.len() as u32);
                for (place, word) in (0..).zip(expected) {
                    let mut i = In::default();
                    i.read.read(place);
                    sim.clock(i).unwrap();
                    prop_assert_eq!(sim.moore().word, Read { valid: true, data: word });
                }
                sim.clock(In { clear: true, ..In::default() }).unwrap();
                prop_assert_eq!(sim.moore().count, 0);
            }
        }
    }
}
