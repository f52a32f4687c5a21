//! The index unit: counts each transparent fragment or, once its pixel has a place in the buffer, stores it there.
//!
//! ```text
//!                  +-------+
//!  fragment ------>|       |---> counters: read, write    <--- counts
//!  ready <---------| Index |---> sums: read               <--- bases
//!  counting ------>|       |---> place, word
//!  band, length -->|       |---> ended, first_of_word
//!                  +-------+
//! ```
//! One fragment a cycle, same pixel or not. A counter that has come to its limit stays there.
//!
//! Where slots are found by counting up, counters begin at 0 and a fragment's slot is its pixel's base plus its counter; where by
//! counting down, they begin at what was counted, and it is the end of its pixel's array minus its counter. Either way the
//! fragments of a pixel lie side by side in arrival order. Those of pixels that are not of the band are passed over, or
//! dropped if there is one band; and so is what its pixel's counter did not count.
//!
//! Where arrays are of one length nothing is counted before: the base is the pixel's number times the length, and a
//! fragment that finds its pixel's array full is dropped. `first_of_word` names the word of counters of which the first one
//! leaves 0.
//!
//! Where counters and sums lie outside a fragment waits until they are there; who hands it over asks for them as it is taken,
//! if [`Config::is_asked`] says so, and with `taken` they are done with.

use super::config::{Band, Config};
use super::counters::Counts;
use super::prefix_sum::Sums;
use crate::chains::tables::{Place, Word};
use pellucid_machine::pixel::{Marked, PixelFragment, Screen};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, WritePort, fifo, rtl};

/// See the module's description.
pub struct Index;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Fragments that arrived.
    #[with(cfg.fragments_ahead())]
    pub queue: fifo::State,
    /// The fragment at hand.
    #[with(cfg.screen)]
    pub stage: Stream<Marked<PixelFragment>>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments are counted; else they are stored.
    pub counting: bool,
    /// Transparent fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The counters that were asked for.
    #[with(*cfg)]
    pub counts: Read<Counts>,
    /// The sums that were asked for.
    #[with(*cfg)]
    #[exists(!cfg.is_fixed())]
    pub bases: Read<Sums>,
    /// The pixels whose fragments are stored.
    #[with(*cfg)]
    #[exists(!cfg.is_fixed())]
    pub band: Band,
    /// Slots of every array.
    #[width(cfg.layer_bits())]
    #[exists(cfg.is_fixed())]
    pub length: u32,
    /// Slots outside may be asked for.
    pub outside_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads counters.
    #[with(cfg.word_bits())]
    pub count_read: ReadPort,
    /// Writes counters.
    #[with(cfg.word_bits(), *cfg)]
    pub count_write: WritePort<Counts>,
    /// Reads sums.
    #[with(cfg.word_bits())]
    #[exists(!cfg.is_fixed())]
    pub base_read: ReadPort,
    /// Counters, and sums if fragments are stored, are done with.
    #[exists(cfg.caches())]
    pub taken: bool,
    /// Where the fragment is written.
    #[with(cfg.fragments)]
    pub place: Stream<Place>,
    /// What is written there.
    #[with(cfg.fragments)]
    pub word: Word,
    /// A fragment is counted.
    pub counted: bool,
    /// A fragment is dropped.
    pub dropped: bool,
    /// All fragments of the frame have come.
    pub ended: bool,
    /// A word of counters that are all 0 gets its first fragment.
    #[with(cfg.word_bits())]
    #[exists(cfg.is_fixed())]
    pub first_of_word: Stream<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Fragments that arrived.
    pub queue: <Queue as Block>::Mem,
}

type Queue = Fifo<Marked<PixelFragment>>;

#[inline(always)]
fn queue(cfg: &Config) -> fifo::Config<Screen> {
    fifo::Config { depth: cfg.fragments_ahead(), item: cfg.screen }
}

#[rtl(
    check(Index, crate::test_util::arrays(4, true)),
    check(Index, crate::test_util::arrays(1, false)),
    check(Index, crate::test_util::fixed().arrays),
    check(Index, crate::test_util::caching_arrays(2, true))
)]
impl Block for Index {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State { queue: Queue::reset(&queue(cfg)), stage: Stream::idle() }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { queue: Queue::memories(&queue(cfg)) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        Moore { ready: Queue::moore(&queue(cfg), &q.queue, &m.queue).ready }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let Marked { end, item } = q.stage.payload;
        let PixelFragment { pixel, z, rgba, label } = item;
        let mut o = Out { ended: q.stage.valid && end, ..Out::default() };
        o.word = Word { z, rgba, weight: 0, label };

        // Second stage: the pixel's counter and base are at hand.
        let asked = q.stage.valid && !end && cfg.is_asked(i.counting, i.band, pixel);
        let sums_there = i.counting || cfg.is_fixed() || i.bases.valid;
        let waits = asked && !cfg.is_there(i.counts.valid && sums_there);
        let at_hand = q.stage.valid && !end && !waits;
        let lane = cfg.lane_of(pixel);
        let count = i.counts.data.of[lane as usize];
        let base = i.bases.data.of[lane as usize];
        let mut counted = count;
        let mut stall = waits;
        if at_hand && i.counting {
            o.counted = count < cfg.limit();
            counted = if o.counted { count + 1 } else { count };
        }
        if at_hand && !i.counting {
            let limit = if cfg.is_fixed() { i.length } else { cfg.limit() };
            let left = if cfg.shape.down { count > 0 } else { count < limit };
            if cfg.has(i.band, pixel) && left {
                let base = if cfg.is_fixed() { pixel * i.length } else { base };
                let section = if cfg.shape.down { base - count } else { base + count };
                stall = cfg.fragments.is_outside(section) && !i.outside_ready;
                o.place = Stream { valid: !stall, payload: Place { section, slot: 0 } };
                counted = if cfg.shape.down { count - 1 } else { count + 1 };
            } else {
                o.dropped = !cfg.shape.bands || cfg.has(i.band, pixel);
            }
        }
        if o.counted || o.place.valid {
            let mut counts = i.counts.data;
            counts.of[lane as usize] = counted;
            o.count_write.write(cfg.word_of(pixel), counts);
        }
        if cfg.is_fixed() {
            let mut used = false;
            for lane in 0..cfg.shape.lanes {
                used |= i.counts.data.of[lane as usize] > 0;
            }
            let first = o.place.valid && !used;
            o.first_of_word = Stream { valid: first, payload: cfg.word_of(pixel) };
        }
        o.taken = asked && !stall;

        // First stage: ask for those of the next fragment's pixel, if it counts or has a place.
        let front = Queue::moore(&queue(cfg), &q.queue, &m.queue).front;
        if !stall {
            d.stage = front;
            let next = front.payload.item.pixel;
            if front.valid && !front.payload.end && cfg.is_asked(i.counting, i.band, next) {
                o.count_read.read(cfg.word_of(next));
                if !i.counting && !cfg.is_fixed() {
                    o.base_read.read(cfg.word_of(next));
                }
            }
        }
        let to_queue = fifo::In { push: i.fragment, pop: !stall };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        o
    }
}

#[cfg(test)]
mod tests;
