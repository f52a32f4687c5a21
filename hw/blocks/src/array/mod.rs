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

use crate::chains::answers::{self, Answers, Words};
use crate::chains::sections::{self, Sections};

use config::Config;
use counters::Counters;
use index::Index;
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked, PixelFragment};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Read, Signals, Stream, rtl};
use prefix_sum::PrefixSum;
use reader::Reader;
use walk::{Extent, Walk};

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
    /// The band's last pixel is written.
    pub written: bool,
    /// A number: the word of counters of that number is cleared.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// What the memory of the slots outside shows.
    #[with(cfg.fragments.port())]
    #[exists(cfg.fragments.port().exists())]
    pub outside: outside::In,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
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
    /// The port to the slots outside.
    #[with(cfg.fragments.port())]
    #[exists(cfg.fragments.port().exists())]
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
}

#[rtl(
    check(Arrays, crate::test_util::arrays(4, true)),
    check(Arrays, crate::test_util::arrays(1, false))
)]
impl Block for Arrays {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let band = PrefixSum::moore(cfg, &q.prefix_sum, &m.prefix_sum).band;
        Moore {
            ready: Index::moore(cfg, &q.index, &m.index).ready,
            arrived: Reader::moore(cfg, &q.reader, &m.reader).arrived,
            whole: cfg.is_last(band),
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        // What every block shows before its inputs are known.
        let counts = Counters::moore(cfg, &(), &m.counters);
        let prefix_sum = PrefixSum::moore(cfg, &q.prefix_sum, &m.prefix_sum);
        let slots = Sections::moore(&cfg.fragments, &q.fragments, &m.fragments);
        let reader = Reader::moore(cfg, &q.reader, &m.reader);
        let words = Words::of(slots.on_chip, i.outside.response);
        let to_answers = answers::In { oldest: reader.oldest, words };
        let word =
            Answers::next(&cfg.fragments, &q.answers, &mut d.answers, &mut m.answers, to_answers);

        let index = if i.comes {
            let to_index = index::In {
                counting: i.counting,
                fragment: i.fragment,
                counts,
                bases: prefix_sum.sums,
                band: prefix_sum.band,
                length: 0,
                outside_ready: slots.ready,
            };
            Index::next(cfg, &q.index, &mut d.index, &mut m.index, to_index)
        } else {
            index::Out::default()
        };

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
                sums: prefix_sum.sums,
                extent_ready: reader.ready,
            };
            let walk = Walk::next(cfg, &q.walk, &mut d.walk, &mut (), to_walk);
            let to_reader = reader::In {
                extent: walk.extent,
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
        Counters::next(cfg, &(), &mut (), &mut m.counters, to_counters);
        let to_fragments = sections::In {
            write: index.place,
            word: index.word,
            read: back.read,
            taken: i.outside.ready,
        };
        let request = Sections::next(
            &cfg.fragments,
            &q.fragments,
            &mut d.fragments,
            &mut m.fragments,
            to_fragments,
        )
        .request;

        Out {
            ended: index.ended,
            summed: sum.done,
            wires: Wires {
                slots: sum.slots,
                extent: walk.extent.with(reader.ready),
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
                },
            },
        }
    }
}
