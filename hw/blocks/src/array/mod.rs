//! The arrays: transparent fragments grouped by pixel, each pixel's side by side in one shared buffer, as large as a count
//! of them found it to be.
//!
//! ```text
//!             +-------+     +-----------+     +------+ extent +--------+
//! fragment -->| Index |<--->| Counters  |<--->| Walk |------->| Reader |--> arrived (Stream)
//!             +-------+     | PrefixSum |     +------+        +--------+
//!                 |         +-----------+                         |
//!                 v place, word                                   v read
//!             +-----------------------------------------------------------+
//!             | Sections, each of one fragment; Answers                    |
//!             +-----------------------------------------------------------+
//! ```
//! A frame is counted, its counters are summed up, it comes again and is stored, then it is read back pixel by pixel. What
//! is stored at once is a band of pixels, as many as the buffer has slots for. Reading it back leaves every counter at 0,
//! so that the next frame begins without clearing. Use [`fixed`] where no count is to come first.

pub mod config;
pub mod counters;
pub mod fixed;
pub mod index;
pub mod list;
pub mod monitor;
pub mod prefix_sum;
pub mod reader;
pub mod walk;

use crate::arbiter::{self, Arbiter};
use crate::cached_table::{self, CachedTable};
use crate::chains::answers::{self, Answers, Words};
use crate::chains::sections::{self, Sections};
use crate::pixels::Resolve;
use crate::table_cache;
use config::Config;
use counters::{Counters, Counts};
use index::Index;
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked, PixelFragment};
use pellucid_sim::Block;
use pellucid_sim::ram::port;
use pellucid_sim::{Handshake, Memory, Optional, Read, Signals, Stream, rtl};
use prefix_sum::{PrefixSum, Sums};
use reader::Reader;
use walk::{Extent, Walk, visited};

/// See the module's description.
pub struct Arrays;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`index`].
    #[with(*cfg)]
    #[block(Index)]
    pub index: index::State,
    /// See [`prefix_sum`].
    #[with(*cfg)]
    #[block(PrefixSum)]
    pub prefix_sum: prefix_sum::State,
    /// See [`walk`].
    #[with(*cfg)]
    #[block(Walk)]
    pub walk: walk::State,
    /// See [`reader`].
    #[with(*cfg)]
    #[block(Reader)]
    pub reader: reader::State,
    /// See [`sections`].
    #[with(cfg.fragments)]
    #[block(Sections)]
    pub fragments: sections::State,
    /// See [`answers`].
    #[with(cfg.fragments)]
    #[block(Answers)]
    pub answers: answers::State,
    /// The counters, where they lie outside.
    #[with(cfg.counter_shape())]
    #[exists(cfg.caches())]
    #[block(CounterTable, cfg.counter_table())]
    pub counter_table: cached_table::State,
    /// The sums, where they lie outside.
    #[with(cfg.sum_shape())]
    #[exists(cfg.caches_sums())]
    #[block(SumTable, cfg.sum_table())]
    pub sum_table: cached_table::State,
    /// Counters, sums and slots take turns at the port.
    #[with(cfg.arbiter())]
    #[exists(cfg.shares())]
    #[block(Turns, cfg.arbiter())]
    pub turns: arbiter::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`index`].
    #[block(Index, *cfg)]
    pub index: index::Mem,
    /// See [`counters`].
    #[block(Counters, *cfg)]
    pub counters: counters::Mem,
    /// See [`prefix_sum`].
    #[block(PrefixSum, *cfg)]
    pub prefix_sum: prefix_sum::Mem,
    /// See [`reader`].
    #[block(Reader, *cfg)]
    pub reader: reader::Mem,
    /// See [`sections`].
    #[block(Sections, cfg.fragments)]
    pub fragments: sections::Mem,
    /// See [`answers`].
    #[block(Answers, cfg.fragments)]
    pub answers: answers::Mem,
    /// The counters, where they lie outside.
    #[block(CounterTable, cfg.counter_table())]
    #[exists(cfg.caches())]
    pub counter_table: Optional<cached_table::Mem>,
    /// The sums, where they lie outside.
    #[block(SumTable, cfg.sum_table())]
    #[exists(cfg.caches_sums())]
    pub sum_table: Optional<cached_table::Mem>,
    /// Counters, sums and slots take turns at the port.
    #[block(Turns, cfg.arbiter())]
    #[exists(cfg.shares())]
    pub turns: Optional<arbiter::Mem>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame's fragments come.
    pub comes: bool,
    /// They are counted; else stored.
    pub counting: bool,
    /// They are read back.
    pub resolving: bool,
    /// Transparent fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The receiver takes what is read back.
    pub arrived_ready: bool,
    /// Pixels may be asked for, where they lie outside.
    #[exists(cfg.shape.pixels_ahead)]
    pub pixel_ready: bool,
    /// The band's last pixel is written.
    pub written: bool,
    /// A number: the word of counters of that number is cleared.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// What the outside memory shows.
    #[with(cfg.port())]
    #[exists(cfg.port().exists())]
    pub outside: outside::In,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// A word that is cleared is taken.
    pub clear_ready: bool,
    /// Fragments of one pixel after the other, then the end of the band.
    #[with(cfg.screen.pixel_bits(), 0)]
    pub arrived: Stream<Marked<Arrived>>,
    /// The band is the frame's last.
    pub whole: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// All fragments of the frame have come.
    pub ended: bool,
    /// A band's counters are summed up.
    pub summed: bool,
    /// What is asked and told of pixels that lie outside: of each whose fragments will arrive.
    #[with(cfg.screen)]
    #[exists(cfg.shape.pixels_ahead)]
    pub resolve: Resolve,
    /// What can be seen.
    #[with(*cfg)]
    pub wires: Wires,
}

/// What can be seen of the arrays in a cycle: the streams between their blocks, and what these did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Wires {
    /// Slots that the band takes so far, while it is summed up.
    #[with(cfg.sum_bits())]
    pub slots: Stream<u32>,
    /// Pixels with their fragments.
    #[with(*cfg)]
    pub extent: Handshake<Marked<Extent>>,
    /// Fragments that were read back.
    #[with(cfg.screen.pixel_bits(), 0)]
    pub arrived: Handshake<Marked<Arrived>>,
    /// The port to what lies outside.
    #[with(cfg.port())]
    #[exists(cfg.port().exists())]
    pub outside: outside::Wires,
    /// What happened.
    pub events: Events,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// A fragment was counted.
    pub counted: bool,
    /// A fragment was stored.
    pub stored: bool,
    /// It was stored in outside memory.
    pub spilled: bool,
    /// A fragment found no slot.
    pub dropped: bool,
    /// A fragment was read back.
    pub read: bool,
    /// It was read in a second pass or later.
    pub read_again: bool,
    /// What the cache of counters did.
    pub counters: Cached,
    /// What that of sums did.
    pub sums: Cached,
}

/// What the cache of a table did in a cycle.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Cached {
    /// A word was there, or on its way.
    pub hit: bool,
    /// It was not.
    pub miss: bool,
    /// One was written back.
    pub write_back: bool,
}

type CounterTable = CachedTable<Counts>;
type SumTable = CachedTable<Sums>;
type Turns = Arbiter;

/// What is seen of a cache.
#[inline(always)]
#[rtl]
pub(super) fn cached(out: table_cache::Out) -> Cached {
    Cached { hit: out.hit, miss: out.miss, write_back: out.write_back }
}

#[rtl(
    check(Arrays, crate::test_util::arrays(4, true)),
    check(Arrays, crate::test_util::arrays(1, false)),
    check(Arrays, crate::test_util::caching_arrays(2, true)),
    check(Arrays, crate::test_util::caching_arrays(1, false))
)]
impl Block for Arrays {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let band = PrefixSum::moore(cfg, &q.prefix_sum, &m.prefix_sum).band;
        let mut ready = Index::moore(cfg, &q.index, &m.index).ready;
        let mut clear_ready = true;
        if cfg.caches() {
            let counters =
                CounterTable::moore(&cfg.counter_table(), &q.counter_table, &m.counter_table);
            let sums = SumTable::moore(&cfg.sum_table(), &q.sum_table, &m.sum_table);
            ready &= counters.ready && sums.ready;
            clear_ready = counters.clear_ready && sums.clear_ready;
        }
        Moore {
            ready,
            clear_ready,
            arrived: Reader::moore(cfg, &q.reader, &m.reader).arrived,
            whole: cfg.is_last(band),
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        // What every block shows before its inputs are known.
        let mut counts = Counters::moore(cfg, &(), &m.counters);
        let prefix_sum = PrefixSum::moore(cfg, &q.prefix_sum, &m.prefix_sum);
        let mut sums = prefix_sum.sums;
        let (mut tables_ready, mut clears) = (true, i.clear.valid);
        if cfg.caches() {
            let counter_table =
                CounterTable::moore(&cfg.counter_table(), &q.counter_table, &m.counter_table);
            let sum_table = SumTable::moore(&cfg.sum_table(), &q.sum_table, &m.sum_table);
            counts = counter_table.entry;
            sums = sum_table.entry;
            tables_ready = counter_table.ready && sum_table.ready;
            clears &= counter_table.clear_ready && sum_table.clear_ready;
        }
        // What each of them sees of the outside memory.
        let (mut of_counters, mut of_sums) = (i.outside, i.outside);
        let mut of_slots = i.outside;
        if cfg.shares() {
            let turns = Turns::moore(&cfg.arbiter(), &q.turns, &m.turns);
            of_counters = arbiter::client(&0, turns, i.outside);
            of_sums = arbiter::client(&1, turns, i.outside);
            of_slots = arbiter::client(&2, turns, i.outside);
        }
        let slots = Sections::moore(&cfg.fragments, &q.fragments, &m.fragments);
        let reader = Reader::moore(cfg, &q.reader, &m.reader);
        let words = Words::of(slots.on_chip, of_slots.response);
        let to_answers = answers::In { oldest: reader.oldest, words };
        let word =
            Answers::next(&cfg.fragments, &q.answers, &mut d.answers, &mut m.answers, to_answers);

        let mut fragment = i.fragment;
        fragment.valid &= tables_ready;
        let index = if i.comes {
            let to_index = index::In {
                counting: i.counting,
                fragment,
                counts,
                bases: sums,
                band: prefix_sum.band,
                length: 0,
                outside_ready: slots.ready,
            };
            Index::next(cfg, &q.index, &mut d.index, &mut m.index, to_index)
        } else {
            index::Out::default()
        };

        // A pixel is asked for as its fragments are about to be.
        let mut extent_ready = reader.ready;
        if cfg.shape.pixels_ahead {
            extent_ready &= i.pixel_ready;
        }
        // What is stored is read back; what is read back makes room for the next band.
        let begins = index.ended && !i.counting;
        let next_band = i.written && !cfg.is_last(prefix_sum.band);
        let (walk, back) = if begins || i.resolving {
            let to_walk = walk::In {
                start: begins,
                band: prefix_sum.band,
                length: 0,
                occupied: prefix_sum.occupied,
                word: prefix_sum.word,
                counts,
                sums,
                ready: tables_ready,
                extent_ready,
            };
            let walk = Walk::next(cfg, &q.walk, &mut d.walk, &mut (), to_walk);
            let mut extent = walk.extent;
            extent.valid &= extent_ready;
            let to_reader = reader::In {
                extent,
                word,
                depth: Read::default(),
                arrived_ready: i.arrived_ready,
                outside_ready: slots.ready,
            };
            let back = Reader::next(cfg, &q.reader, &mut d.reader, &mut m.reader, to_reader);
            (walk, back)
        } else {
            (walk::Out::default(), reader::Out::default())
        };

        let to_prefix_sum = prefix_sum::In {
            start: (index.ended && i.counting) || next_band,
            counts,
            sums,
            ready: tables_ready,
            index_read: index.base_read,
            walk_read: walk.read,
            occupied_read: walk.occupied_read,
        };
        let sum = PrefixSum::next(
            cfg,
            &q.prefix_sum,
            &mut d.prefix_sum,
            &mut m.prefix_sum,
            to_prefix_sum,
        );

        // The memories serve whoever asks.
        let to_counters = counters::In {
            index_read: index.count_read,
            index_write: index.count_write,
            sum_read: sum.read,
            sum_write: sum.write,
            walk_read: walk.read,
            walk_write: walk.write,
            clear: i.clear,
        };
        if !cfg.caches() {
            Counters::next(cfg, &(), &mut (), &mut m.counters, to_counters);
        }
        let to_fragments = sections::In {
            write: index.place,
            word: index.word,
            read: back.read,
            taken: of_slots.ready,
        };
        let mut request = Sections::next(
            &cfg.fragments,
            &q.fragments,
            &mut d.fragments,
            &mut m.fragments,
            to_fragments,
        )
        .request;
        let (mut counter_table, mut sum_table) =
            (table_cache::Out::default(), table_cache::Out::default());
        if cfg.caches() {
            // A fragment's words are asked for as it is taken; one user asks at a time.
            let taken = fragment.valid && Index::moore(cfg, &q.index, &m.index).ready;
            let Marked { end, item } = fragment.payload;
            let asks =
                i.comes && taken && !end && cfg.is_asked(i.counting, prefix_sum.band, item.pixel);
            let of_fragment = Stream { valid: asks, payload: cfg.word_of(item.pixel) };
            let mut counts_ahead = if walk.ahead.valid { walk.ahead } else { sum.counts_ahead };
            let mut sums_ahead = if walk.ahead.valid { walk.ahead } else { sum.sums_ahead };
            if asks {
                counts_ahead = of_fragment;
                sums_ahead = Stream { valid: !i.counting, payload: of_fragment.payload };
            }
            let (of_index, of_walk) = (port::written(index.count_write), port::written(walk.write));
            let mut counts_write = port::written(sum.write);
            counts_write = if of_walk.valid { of_walk } else { counts_write };
            counts_write = if of_index.valid { of_index } else { counts_write };
            let clear = Stream { valid: clears, payload: i.clear.payload };
            let to_counter_table = cached_table::In {
                ask: counts_ahead,
                taken: index.taken || sum.counts_taken || walk.taken,
                write: counts_write,
                clear,
                flush: false,
                memory: of_counters,
            };
            counter_table = CounterTable::next(
                &cfg.counter_table(),
                &q.counter_table,
                &mut d.counter_table,
                &mut m.counter_table,
                to_counter_table,
            );
            let to_sum_table = cached_table::In {
                ask: sums_ahead,
                taken: (index.taken && !i.counting) || sum.sums_taken || walk.taken,
                write: port::written(sum.sums_write),
                clear,
                flush: false,
                memory: of_sums,
            };
            sum_table = SumTable::next(
                &cfg.sum_table(),
                &q.sum_table,
                &mut d.sum_table,
                &mut m.sum_table,
                to_sum_table,
            );
            let to_turns = arbiter::In {
                request: [counter_table.request, sum_table.request, request, Stream::idle()],
                memory: i.outside,
            };
            request =
                Turns::next(&cfg.arbiter(), &q.turns, &mut d.turns, &mut m.turns, to_turns).request;
        }

        Out {
            ended: index.ended,
            summed: sum.done,
            resolve: visited(walk.extent, extent_ready, true),
            wires: Wires {
                slots: sum.slots,
                extent: walk.extent.with(extent_ready),
                arrived: reader.arrived.with(i.arrived_ready),
                // What was asked for always finds room.
                outside: outside::Wires {
                    request: request.with(i.outside.ready),
                    response: i.outside.response.with(true),
                },
                events: Events {
                    counted: index.counted,
                    stored: index.place.valid,
                    spilled: index.place.valid
                        && cfg.fragments.is_outside(index.place.payload.section),
                    dropped: index.dropped,
                    read: back.read.valid,
                    read_again: back.read_again,
                    counters: cached(counter_table),
                    sums: cached(sum_table),
                },
            },
        }
    }
}
