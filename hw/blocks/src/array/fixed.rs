//! The fixed arrays: transparent fragments grouped by pixel, each pixel's in an array of its own; all arrays are of one length
//! and lie one behind the other.
//!
//! ```text
//!             +-------+     +----------+     +------+ extent +--------+
//! fragment -->| Index |<--->| Counters |<--->| Walk |------->| Reader |--> arrived (Stream)
//!             +-------+     | WordList |     +------+        +--------+
//!                 |         +----------+                      ^   |
//!                 |         | Rebuild  |--> replay      depth |   |
//!                 v         +----------+                          v read
//!             +-----------------------------------------------------------+
//!             | Sections, each of one fragment; Answers                    |
//!             +-----------------------------------------------------------+
//! ```
//! Fragment `n` of a pixel has slot `pixel * length + n`. A frame is stored, then read back pixel by pixel. If a pixel has more
//! than the length the frame is not read back but comes again, with arrays of twice the length, as far as slots go; see
//! [`mod@rebuild`]. Reading it back leaves every counter at 0, so that the next frame begins without clearing.

pub mod monitor;
mod wires;

pub use wires::{Events, Wires};

use super::config::{self, MAX_LANES};
use super::counters::{self, Counters};
use super::index::{self, Index};
use super::list::{self, WordList};
use super::prefix_sum::Sums;
use super::reader::{self, Reader};
use super::walk::{self, Walk, visited};
use super::{CounterTable, Turns, cached};
use crate::arbiter;
use crate::cached_table;
use crate::chains::answers::{self, Answers, Words};
use crate::chains::sections::{self, Sections};
use crate::pixels::Resolve;
use crate::rebuild::{self, Growth, Rebuild, Step};
use crate::table_cache;
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked, PixelFragment, Screen, Z_BITS};
use pellucid_sim::ram::port;
use pellucid_sim::{Block, Memory, Optional, Read, ReadPort, Signals, Stream, bits_for, rtl};

/// See the module's description.
pub struct FixedArrays;

/// What they are made of.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Slots of an array to begin with, at least 1.
    pub begin: u32,
    /// The most slots of one, at least as many. An array becomes longer where these are more.
    pub most: u32,
    /// The most slots that are on chip; all others lie outside.
    pub on_chip: u32,
    /// From a read request to outside memory to its data, in cycles, at least 1.
    pub outside_latency: u32,
    /// Fragment reads under way at once, at least 2.
    pub reads_in_flight: u32,
    /// Fragments of a pixel that the receiver takes in one pass, at least 1.
    pub depth: u32,
    /// Counters lie outside, with so much of them on chip; else they lie there as a whole.
    pub cached: Option<cached_table::Cached>,
    /// Pixels lie outside, too: they are asked for as their fragments are about to be.
    pub pixels_ahead: bool,
}

/// Everything that the blocks need to know.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Of arrays that are [fixed](config::Shape::fixed).
    pub arrays: config::Config,
    /// How long they are.
    pub rebuild: rebuild::Config,
}

impl Config {
    /// All of that shape.
    ///
    /// # Panics
    /// If a number is outside of its range, or if arrays of the most slots have more than 2^32 together.
    pub fn new(screen: Screen, shape: Shape) -> Config {
        let slots = screen.pixels() * shape.most;
        let on_chip = shape.on_chip.min(slots);
        let arrays = config::Shape {
            lanes: MAX_LANES as u32,
            count_bits: bits_for(u64::from(shape.most)),
            down: false,
            sweeps: false,
            bands: false,
            on_chip,
            outside: slots - on_chip,
            outside_latency: shape.outside_latency,
            reads_in_flight: shape.reads_in_flight,
            depth: shape.depth,
            fixed: shape.most,
            cached: shape.cached,
            pixels_ahead: shape.pixels_ahead,
        };
        let arrays = config::Config::new(screen, arrays);
        let rebuild = rebuild::Config {
            begin: shape.begin,
            most: shape.most,
            growth: Growth::Double,
            entries: arrays.words(),
        };
        Config { arrays, rebuild }
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`mod@rebuild`].
    #[with(cfg.rebuild)]
    #[block(Rebuild)]
    pub rebuild: rebuild::State,
    /// See [`index`].
    #[with(cfg.arrays)]
    #[block(Index)]
    pub index: index::State,
    /// See [`list`].
    #[with(cfg.arrays)]
    #[exists(cfg.arrays.lists())]
    #[block(WordList)]
    pub list: list::State,
    /// See [`walk`].
    #[with(cfg.arrays)]
    #[block(Walk)]
    pub walk: walk::State,
    /// See [`reader`].
    #[with(cfg.arrays)]
    #[block(Reader)]
    pub reader: reader::State,
    /// See [`sections`].
    #[with(cfg.arrays.fragments)]
    #[block(Sections)]
    pub fragments: sections::State,
    /// See [`answers`].
    #[with(cfg.arrays.fragments)]
    #[block(Answers)]
    pub answers: answers::State,
    /// The counters, where they lie outside.
    #[with(cfg.arrays.counter_shape())]
    #[exists(cfg.arrays.caches())]
    #[block(CounterTable, cfg.arrays.counter_table())]
    pub counter_table: cached_table::State,
    /// Counters and slots take turns at the port.
    #[with(cfg.arrays.arbiter())]
    #[exists(cfg.arrays.shares())]
    #[block(Turns, cfg.arrays.arbiter())]
    pub turns: arbiter::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`index`].
    #[block(Index, cfg.arrays)]
    pub index: index::Mem,
    /// See [`counters`].
    #[block(Counters, cfg.arrays)]
    pub counters: counters::Mem,
    /// See [`list`].
    #[block(WordList, cfg.arrays)]
    #[exists(cfg.arrays.lists())]
    pub list: Optional<list::Mem>,
    /// See [`reader`].
    #[block(Reader, cfg.arrays)]
    pub reader: reader::Mem,
    /// See [`sections`].
    #[block(Sections, cfg.arrays.fragments)]
    pub fragments: sections::Mem,
    /// See [`answers`].
    #[block(Answers, cfg.arrays.fragments)]
    pub answers: answers::Mem,
    /// The counters, where they lie outside.
    #[block(CounterTable, cfg.arrays.counter_table())]
    #[exists(cfg.arrays.caches())]
    pub counter_table: Optional<cached_table::Mem>,
    /// Counters and slots take turns at the port.
    #[block(Turns, cfg.arrays.arbiter())]
    #[exists(cfg.arrays.shares())]
    pub turns: Optional<arbiter::Mem>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame's fragments come.
    pub comes: bool,
    /// An item of a frame is taken by whoever tests its depth.
    pub taken: bool,
    /// Transparent fragments in arrival order, then the end of the frame.
    #[with(cfg.arrays.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The depth that was asked for. Where pixels lie outside, once it is there and until it is taken.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// Pixels may be asked for, where they lie outside.
    #[exists(cfg.arrays.shape.pixels_ahead)]
    pub pixel_ready: bool,
    /// The receiver takes what is read back.
    pub arrived_ready: bool,
    /// The frame's last pixel is written.
    pub written: bool,
    /// A number: the word of counters of that number is cleared.
    #[with(cfg.arrays.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// What the outside memory shows.
    #[with(cfg.arrays.port())]
    #[exists(cfg.arrays.port().exists())]
    pub outside: outside::In,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What is done with the frame.
    pub step: Step,
    /// What comes next is the same frame again, from its first item.
    pub replay: bool,
    /// A fragment is taken.
    pub ready: bool,
    /// A word that is cleared is taken.
    pub clear_ready: bool,
    /// Fragments of one pixel after the other, then the end of the frame.
    #[with(cfg.arrays.screen.pixel_bits(), 0)]
    pub arrived: Stream<Marked<Arrived>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// All fragments of the frame have come.
    pub ended: bool,
    /// Reads a pixel's opaque depth.
    #[with(cfg.arrays.screen.pixel_bits())]
    pub depth_read: ReadPort,
    /// What is asked and told of pixels that lie outside.
    #[with(cfg.arrays.screen)]
    #[exists(cfg.arrays.shape.pixels_ahead)]
    pub resolve: Resolve,
    /// What can be seen.
    #[with(*cfg)]
    pub wires: Wires,
}

#[rtl(
    check(FixedArrays, crate::test_util::fixed()),
    check(FixedArrays, crate::test_util::fixed_at(3)),
    check(FixedArrays, crate::test_util::caching_fixed(true)),
    check(FixedArrays, crate::test_util::caching_fixed(false))
)]
impl Block for FixedArrays {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let rebuild = Rebuild::moore(&cfg.rebuild, &q.rebuild, &());
        let mut ready = Index::moore(&cfg.arrays, &q.index, &m.index).ready;
        let mut clear_ready = true;
        if cfg.arrays.caches() {
            let table = cfg.arrays.counter_table();
            let counters = CounterTable::moore(&table, &q.counter_table, &m.counter_table);
            ready &= counters.ready;
            clear_ready = counters.clear_ready;
        }
        Moore {
            step: rebuild.step,
            replay: rebuild.replay,
            ready,
            clear_ready,
            arrived: Reader::moore(&cfg.arrays, &q.reader, &m.reader).arrived,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let arrays = &cfg.arrays;
        let slots = &arrays.fragments;

        // What every block shows before its inputs are known.
        let at = Rebuild::moore(&cfg.rebuild, &q.rebuild, &());
        let mut counts = Counters::moore(arrays, &(), &m.counters);
        let (mut table_ready, mut clear_ready) = (true, true);
        if arrays.caches() {
            let table = arrays.counter_table();
            let counters = CounterTable::moore(&table, &q.counter_table, &m.counter_table);
            counts = counters.entry;
            table_ready = counters.ready;
            clear_ready = counters.clear_ready;
        }
        let mut list = list::Moore::default();
        if arrays.lists() {
            list = WordList::moore(arrays, &q.list, &m.list);
        }
        // What counters and slots see of the outside memory.
        let (mut of_counters, mut of_slots) = (i.outside, i.outside);
        if arrays.shares() {
            let turns = Turns::moore(&arrays.arbiter(), &q.turns, &m.turns);
            of_counters = arbiter::client(&0, turns, i.outside);
            of_slots = arbiter::client(&1, turns, i.outside);
        } else if arrays.caches() {
            of_slots = outside::In::default();
        }
        let memory = Sections::moore(slots, &q.fragments, &m.fragments);
        let reader = Reader::moore(arrays, &q.reader, &m.reader);
        let words = Words::of(memory.on_chip, of_slots.response);
        let to_answers = answers::In { oldest: reader.oldest, words };
        let word = Answers::next(slots, &q.answers, &mut d.answers, &mut m.answers, to_answers);

        let mut fragment = i.fragment;
        fragment.valid &= table_ready;
        let index = if i.comes {
            let to_index = index::In {
                counting: false,
                fragment,
                counts,
                bases: Read::<Sums>::default(),
                band: config::Band::default(),
                length: at.limit,
                outside_ready: memory.ready,
            };
            Index::next(arrays, &q.index, &mut d.index, &mut m.index, to_index)
        } else {
            index::Out::default()
        };

        let to_rebuild = rebuild::In {
            lacking: index.dropped,
            asked: 0,
            ended: index.ended,
            resolved: i.written,
            comes: i.taken,
            clear_ready,
        };
        let rebuild = Rebuild::next(&cfg.rebuild, &q.rebuild, &mut d.rebuild, &mut (), to_rebuild);

        let mut extent_ready = reader.ready;
        if arrays.shape.pixels_ahead {
            extent_ready &= i.pixel_ready;
        }
        // What is complete is read back.
        let (walk, back) = if rebuild.begins || at.step == Step::Resolve {
            let to_walk = walk::In {
                start: rebuild.begins,
                band: config::Band::default(),
                length: at.limit,
                occupied: list.count,
                word: list.word,
                counts,
                sums: Read::<Sums>::default(),
                ready: table_ready,
                extent_ready,
            };
            let walk = Walk::next(arrays, &q.walk, &mut d.walk, &mut (), to_walk);
            let mut extent = walk.extent;
            extent.valid &= extent_ready;
            let to_reader = reader::In {
                extent,
                word,
                depth: i.depth,
                arrived_ready: i.arrived_ready,
                outside_ready: memory.ready,
            };
            let back = Reader::next(arrays, &q.reader, &mut d.reader, &mut m.reader, to_reader);
            (walk, back)
        } else {
            (walk::Out::default(), reader::Out::default())
        };

        // The memories serve whoever asks.
        let to_list = list::In {
            push: index.first_of_word,
            read: walk.occupied_read,
            clear: i.written || rebuild.again,
        };
        if arrays.lists() {
            WordList::next(arrays, &q.list, &mut d.list, &mut m.list, to_list);
        }
        let mut clear = i.clear;
        if at.clear.valid {
            clear = at.clear;
        }
        let to_counters = counters::In {
            index_read: index.count_read,
            index_write: index.count_write,
            walk_read: walk.read,
            walk_write: walk.write,
            clear,
            ..counters::In::default()
        };
        if !arrays.caches() {
            Counters::next(arrays, &(), &mut (), &mut m.counters, to_counters);
        }
        let to_fragments = sections::In {
            write: index.place,
            word: index.word,
            read: back.read,
            taken: of_slots.ready,
        };
        let mut request =
            Sections::next(slots, &q.fragments, &mut d.fragments, &mut m.fragments, to_fragments)
                .request;
        let mut counters = table_cache::Out::default();
        if arrays.caches() {
            // A fragment's word is asked for as it is taken.
            let taken = fragment.valid && Index::moore(arrays, &q.index, &m.index).ready;
            let Marked { end, item } = fragment.payload;
            let mut ask = walk.ahead;
            if i.comes && taken && !end {
                ask = Stream::offer(arrays.word_of(item.pixel));
            }
            let of_index = port::written(index.count_write);
            let write = if of_index.valid { of_index } else { port::written(walk.write) };
            let to_table = cached_table::In {
                ask,
                taken: index.taken || walk.taken,
                write,
                clear,
                flush: false,
                memory: of_counters,
            };
            counters = CounterTable::next(
                &arrays.counter_table(),
                &q.counter_table,
                &mut d.counter_table,
                &mut m.counter_table,
                to_table,
            );
            if arrays.shares() {
                let to_turns = arbiter::In {
                    request: [counters.request, request, Stream::idle(), Stream::idle()],
                    memory: i.outside,
                };
                let turns = &arrays.arbiter();
                request =
                    Turns::next(turns, &q.turns, &mut d.turns, &mut m.turns, to_turns).request;
            } else {
                request = counters.request;
            }
        }

        let longest = at.limit == cfg.rebuild.most;
        Out {
            ended: index.ended,
            depth_read: back.depth_read,
            resolve: visited(walk.extent, extent_ready, back.depth_taken),
            wires: Wires {
                length: at.limit,
                extent: walk.extent.with(extent_ready),
                arrived: reader.arrived.with(i.arrived_ready),
                // What was asked for always finds room.
                outside: outside::Wires {
                    request: request.with(i.outside.ready),
                    response: i.outside.response.with(true),
                },
                events: Events {
                    stored: index.place.valid,
                    spilled: index.place.valid && slots.is_outside(index.place.payload.section),
                    lacking: index.dropped && !longest,
                    dropped: index.dropped && longest,
                    again: rebuild.again,
                    read: back.read.valid,
                    read_again: back.read_again,
                    culled_late: back.culled,
                    counters: cached(counters),
                },
            },
        }
    }
}
