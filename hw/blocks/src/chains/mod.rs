//! The chains: transparent fragments grouped by pixel, in chains of sections that any pixel can have.
//!
//! ```text
//!             +-------+    +-----------+    +----------+
//! fragment -->| Store |--->| Ssa       |--->| ReadBack |--> arrived (Stream)
//!             +-------+    | Nsa       |    +----------+
//!                 ^        | Sections  |         |
//!           grant |        | Occupancy |         |
//!             +------+     +-----------+         |
//!             | Pool |<--------------------------+
//!             +------+           release
//! ```
//! A frame is stored, then read back pixel by pixel. Reading it back gives every section back and sets every
//! SSA entry that was used to NULL, so that the next frame begins without clearing.
//!
//! Where new sections go to the head of a chain ([`Link::Head`](config::Link::Head)) there is no pool: [`count`](mod@count) gives
//! sections out, and all of them are back once the frame is read back, or what it has stored is cleared.

pub mod answers;
pub mod config;
pub mod count;
pub mod lookup;
pub mod monitor;
pub mod nsa;
pub mod occupancy;
pub mod pool;
pub mod read_back;
pub mod reader;
pub mod release;
pub mod scan;
pub mod sections;
pub mod ssa;
pub mod store;
pub mod tables;
#[cfg(test)]
pub(crate) mod test_util;
pub mod under_way;
pub mod walk;
pub mod weigh;
pub mod wires;

use crate::allocator::{self, Allocator, Lent};
use crate::arbiter::{self, Arbiter};
use crate::cached_table::{self, CachedTable};
use crate::pixels::Resolve;
use crate::table_cache;
use answers::{Answers, Words};
use config::Config;
use count::Count;
use nsa::Nsa;
use occupancy::Occupancy;
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked, PixelFragment, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::ram::port;
use pellucid_sim::{Memory, Optional, Read, ReadPort, Signals, Stream, rtl};
use pool::Pool;
use read_back::ReadBack;
use sections::Sections;
use ssa::Ssa;
use std::marker::PhantomData;
use store::Store;
use tables::SsaEntry;
use under_way::UnderWay;
pub use wires::{Events, Wires};

/// The chains, with allocator `A`.
pub struct Chains<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// See [`store`].
    #[with(*cfg)]
    #[block(Store)]
    pub store: store::State,
    /// See [`sections`].
    #[with(*cfg)]
    #[block(Sections)]
    pub sections: sections::State,
    /// See [`answers`].
    #[with(*cfg)]
    #[block(Answers)]
    pub answers: answers::State,
    /// See [`pool`].
    #[with(*cfg)]
    #[exists(!cfg.counts_out())]
    #[block(Pool<A>)]
    pub pool: pool::State<A>,
    /// See [`count`].
    #[with(*cfg)]
    #[exists(cfg.counts_out())]
    #[block(Count)]
    pub count: count::State,
    /// See [`read_back`].
    #[with(*cfg)]
    #[block(ReadBack)]
    pub read_back: read_back::State,
    /// The SSA table, where it lies outside.
    #[with(cfg.ssa_shape())]
    #[exists(cfg.caches_ssa())]
    #[block(SsaOutside, cfg.ssa_table())]
    pub ssa: cached_table::State,
    /// Sections and SSA table take turns at the port.
    #[with(cfg.arbiter())]
    #[exists(cfg.shares())]
    #[block(Turns, cfg.arbiter())]
    pub turns: arbiter::State,
    /// All pixels are written; the last sections may still be on their way back.
    pub written: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<A: Allocator> {
    /// See [`ssa`].
    #[block(Ssa, *cfg)]
    pub ssa: ssa::Mem,
    /// The SSA table, where it lies outside.
    #[block(SsaOutside, cfg.ssa_table())]
    #[exists(cfg.caches_ssa())]
    pub ssa_cache: Optional<cached_table::Mem>,
    /// Whose answers come.
    #[block(Turns, cfg.arbiter())]
    #[exists(cfg.shares())]
    pub turns: Optional<arbiter::Mem>,
    /// See [`nsa`].
    #[block(Nsa, *cfg)]
    pub nsa: nsa::Mem,
    /// See [`sections`].
    #[block(Sections, *cfg)]
    pub sections: sections::Mem,
    /// See [`answers`].
    #[block(Answers, *cfg)]
    pub answers: answers::Mem,
    /// See [`pool`].
    #[block(Pool<A>, *cfg)]
    #[exists(!cfg.counts_out())]
    pub pool: Optional<pool::Mem<A>>,
    /// See [`occupancy`].
    #[block(Occupancy, *cfg)]
    pub occupancy: occupancy::Mem,
    /// See [`under_way`].
    #[block(UnderWay, *cfg)]
    #[exists(cfg.weighs())]
    pub under_way: Optional<under_way::Mem>,
    /// See [`store`].
    #[block(Store, *cfg)]
    pub store: store::Mem,
    /// See [`read_back`].
    #[block(ReadBack, *cfg)]
    pub read_back: read_back::Mem,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame's fragments come.
    pub storing: bool,
    /// They are read back.
    pub resolving: bool,
    /// They begin to be read back. Else that begins as the last one is stored.
    #[exists(cfg.counts_out())]
    pub start: bool,
    /// So many sections may be taken.
    #[width(cfg.id_bits())]
    #[exists(cfg.counts_out())]
    pub limit: u32,
    /// Transparent fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The depth that was asked for. Where depths lie outside, once it is there and until it is taken.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// Depths may be asked for, where they lie outside.
    #[exists(cfg.shape.depth_ahead)]
    pub depth_ready: bool,
    /// The receiver takes what is read back.
    pub arrived_ready: bool,
    /// The frame's last pixel is written.
    pub written: bool,
    /// A number: what every pixel, or word of the bitmap, of that number has is cleared. Where sections are counted out all are
    /// given back.
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
    /// What is cleared is taken.
    pub clear_ready: bool,
    /// Sections that were asked for, all there are at most.
    #[width(cfg.id_bits())]
    #[exists(cfg.counts_out())]
    pub asked: u32,
    /// Fragments of one pixel after the other, then the end of the frame.
    #[with(cfg.screen.pixel_bits(), cfg.shape.weight_bits)]
    pub arrived: Stream<Marked<Arrived>>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Reads a pixel's opaque depth.
    #[with(cfg.screen.pixel_bits())]
    pub depth_read: ReadPort,
    /// What is asked and told of pixels whose depth lies outside.
    #[with(cfg.screen)]
    #[exists(cfg.shape.depth_ahead)]
    pub resolve: Resolve,
    /// All fragments of the frame are stored.
    pub stored: bool,
    /// Every pixel is written and every section given back.
    pub done: bool,
    /// What can be seen.
    #[with(*cfg)]
    pub wires: Wires,
}

type SsaOutside = CachedTable<SsaEntry>;
type Turns = Arbiter;

/// A cycle in which tables are [cleared](In::clear) and all else rests, with their memories; whether one of these is at fault.
/// Nothing where the SSA table is cached, which takes longer.
#[inline(always)]
pub fn clear_alone<A: Allocator>(cfg: &Config, m: &mut Mem<A>, clear: Stream<u32>) -> Option<bool> {
    if cfg.caches_ssa() {
        return None;
    }
    Ssa::next(cfg, &(), &mut (), &mut m.ssa, ssa::In { clear, ..ssa::In::default() });
    let mut fault = m.ssa.clock();
    if cfg.shape.bitmap {
        let to_occupancy = occupancy::In { clear, ..occupancy::In::default() };
        Occupancy::next(cfg, &(), &mut (), &mut m.occupancy, to_occupancy);
        fault |= m.occupancy.clock();
    }
    if cfg.weighs() {
        let to_under_way = under_way::In { clear, ..under_way::In::default() };
        UnderWay::next(cfg, &(), &mut (), &mut m.under_way, to_under_way);
        fault |= m.under_way.clock();
    }
    Some(fault)
}

#[rtl(
    check(Chains<allocator::FreeList>, crate::test_util::small(true)),
    check(Chains<allocator::FreeList>, crate::test_util::small(false)),
    check(Chains<allocator::FreeList>, crate::test_util::small_owned(true)),
    check(Chains<allocator::Chosen>, crate::test_util::small_lending()),
    check(Chains<allocator::Bump>, crate::test_util::small_newest_first()),
    check(Chains<allocator::FreeList>, crate::test_util::small_caching(true, true)),
    check(Chains<allocator::FreeList>, crate::test_util::small_caching(false, false)),
    check(Chains<allocator::FreeList>, crate::test_util::small_depth_ahead())
)]
impl<A: Allocator> Block for Chains<A> {
    type Config = Config;
    type State = State<A>;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem<A>;

    fn moore(cfg: &Config, q: &State<A>, m: &Self::Mem) -> Moore {
        let mut ready = Store::moore(cfg, &q.store, &m.store).ready;
        let mut clear_ready = true;
        if cfg.caches_ssa() {
            let ssa = SsaOutside::moore(&cfg.ssa_table(), &q.ssa, &m.ssa_cache);
            ready &= ssa.ready;
            clear_ready = ssa.clear_ready;
        }
        let mut asked = 0;
        if cfg.counts_out() {
            asked = Count::moore(cfg, &q.count, &()).count;
        }
        Moore {
            ready,
            clear_ready,
            asked,
            arrived: ReadBack::moore(cfg, &q.read_back, &m.read_back).arrived,
        }
    }

    fn next(cfg: &Config, q: &State<A>, d: &mut State<A>, m: &mut Self::Mem, i: In) -> Out {
        // What every block shows before its inputs are known.
        let mut ssa = Ssa::moore(cfg, &(), &m.ssa);
        let mut ssa_ready = true;
        if cfg.caches_ssa() {
            let seen = SsaOutside::moore(&cfg.ssa_table(), &q.ssa, &m.ssa_cache);
            ssa = seen.entry;
            ssa_ready = seen.ready;
        }
        let nsa = Nsa::moore(cfg, &(), &m.nsa);
        let mut occupancy = occupancy::Moore::default();
        if cfg.shape.bitmap {
            occupancy = Occupancy::moore(cfg, &(), &m.occupancy);
        }
        let mut under_way = under_way::Moore::default();
        if cfg.weighs() {
            under_way = UnderWay::moore(cfg, &(), &m.under_way);
        }
        let sections = Sections::moore(cfg, &q.sections, &m.sections);
        // What sections and SSA table see of the outside memory.
        let mut section_memory = i.outside;
        let mut ssa_memory = i.outside;
        if cfg.shares() {
            let turns = Turns::moore(&cfg.arbiter(), &q.turns, &m.turns);
            section_memory = arbiter::client(&0, turns, i.outside);
            ssa_memory = arbiter::client(&1, turns, i.outside);
        } else if cfg.caches_ssa() {
            section_memory = outside::In::default();
        }
        let words = Words::of(sections.on_chip, section_memory.response);
        let mut oldest = ReadBack::moore(cfg, &q.read_back, &m.read_back).oldest;
        if cfg.weighs() {
            // While fragments come, one outside has its turn when it could be written back.
            let stores = Store::moore(cfg, &q.store, &m.store).oldest;
            if i.storing {
                let turn = stores.valid && (sections.ready || !stores.payload);
                oldest = Stream { valid: turn, payload: stores.payload };
            }
        }
        let to_answers = answers::In { oldest, words };
        let word = Answers::next(cfg, &q.answers, &mut d.answers, &mut m.answers, to_answers);
        let pool = if cfg.counts_out() {
            cfg.counted(Count::moore(cfg, &q.count, &()).count, i.limit)
        } else {
            Pool::<A>::moore(cfg, &q.pool, &m.pool)
        };
        let read = ReadBack::moore(cfg, &q.read_back, &m.read_back);

        let mut fragment = i.fragment;
        fragment.valid &= ssa_ready;
        let store = if i.storing {
            let to_store = store::In {
                fragment,
                ssa,
                nsa,
                word,
                under_way,
                grant: pool.grant,
                exhausted: pool.exhausted,
                outside_ready: sections.ready,
                reads: sections.reads,
            };
            Store::next(cfg, &q.store, &mut d.store, &mut m.store, to_store)
        } else {
            store::Out::default()
        };

        // The read-back is clocked from the end of the store on.
        let start = if cfg.counts_out() { i.start } else { store.frame_stored };
        let back = if start || i.resolving {
            let to_read_back = read_back::In {
                start,
                ssa,
                ssa_ready,
                depth_ready: i.depth_ready,
                nsa,
                occupancy,
                word,
                depth: i.depth,
                arrived_ready: i.arrived_ready,
                outside_ready: sections.ready,
            };
            ReadBack::next(cfg, &q.read_back, &mut d.read_back, &mut m.read_back, to_read_back)
        } else {
            read_back::Out::default()
        };
        let written = q.written || i.written;
        let done = written && read.released;
        d.written = written && !done;

        // The tables serve whoever asks.
        let to_ssa = ssa::In {
            store_read: store.ssa_read,
            store_write: store.ssa_write,
            lookup_read: back.ssa_read,
            lookup_write: back.ssa_write,
            clear: i.clear,
        };
        if !cfg.caches_ssa() {
            Ssa::next(cfg, &(), &mut (), &mut m.ssa, to_ssa);
        }
        if cfg.shape.bitmap {
            let to_occupancy = occupancy::In {
                ask: store.occupancy_ask,
                set: store.occupancy_set,
                summary_read: back.scan.summary_read,
                summary_clear: back.scan.summary_clear,
                word_read: back.scan.word_read,
                word_clear: back.scan.word_clear,
                clear: i.clear,
            };
            Occupancy::next(cfg, &(), &mut (), &mut m.occupancy, to_occupancy);
        }
        if cfg.weighs() {
            let to_under_way = under_way::In {
                ask: store.weighed_ask,
                begins: store.weighed_begins,
                ends: store.weighed_ends,
                clear: i.clear,
            };
            UnderWay::next(cfg, &(), &mut (), &mut m.under_way, to_under_way);
        }
        let to_sections = sections::In {
            write: if store.stored_write.valid { store.stored_write } else { store.place },
            word: store.word,
            read: if store.stored_read.valid { store.stored_read } else { back.read },
            taken: section_memory.ready,
        };
        let mut request =
            Sections::next(cfg, &q.sections, &mut d.sections, &mut m.sections, to_sections).request;
        let visits = back.pixel.valid && back.pixel.ready && !back.pixel.payload.end;
        let visited = Stream { valid: visits, payload: back.pixel.payload.item };
        let mut cached = table_cache::Out::default();
        if cfg.caches_ssa() {
            // What comes to the store or to the lookup is asked for as it is taken.
            let mut ask = visited;
            let mut write = port::written(back.ssa_write);
            if i.storing {
                let taken = fragment.valid && Store::moore(cfg, &q.store, &m.store).ready;
                let Marked { end, item } = fragment.payload;
                ask = Stream { valid: taken && !end, payload: item.pixel };
                write = port::written(store.ssa_write);
            }
            let to_table = cached_table::In {
                ask,
                taken: store.ssa_taken || back.taken,
                write,
                clear: i.clear,
                flush: false,
                memory: ssa_memory,
            };
            cached =
                SsaOutside::next(&cfg.ssa_table(), &q.ssa, &mut d.ssa, &mut m.ssa_cache, to_table);
            if cfg.shares() {
                let to_turns = arbiter::In {
                    request: [request, cached.request, Stream::idle(), Stream::idle()],
                    memory: i.outside,
                };
                request =
                    Turns::next(&cfg.arbiter(), &q.turns, &mut d.turns, &mut m.turns, to_turns)
                        .request;
            } else {
                request = cached.request;
            }
        }
        let mut lent = Lent::default();
        if cfg.counts_out() {
            let asked = store.take || store.dropped;
            let to_count = count::In { asked, restart: done || i.clear.valid };
            Count::next(cfg, &q.count, &mut d.count, &mut (), to_count);
        } else {
            let to_pool =
                allocator::In { take: store.take, release: back.release, word: nsa.data.next };
            lent = Pool::<A>::next(cfg, &q.pool, &mut d.pool, &mut m.pool, to_pool);
        }
        let to_nsa = nsa::In { store: store.nsa, chain: back.nsa, lent };
        Nsa::next(cfg, &(), &mut (), &mut m.nsa, to_nsa);

        Out {
            depth_read: back.depth_read,
            resolve: Resolve {
                ask: visited,
                taken: back.taken,
                kept: back.chain.valid && back.chain.ready,
                comes: false,
                visible: false,
                last: false,
            },
            stored: store.frame_stored,
            done,
            wires: Wires {
                grant: pool.grant.with(store.take),
                release: back.release.with(true),
                pixel: back.pixel,
                chain: back.chain,
                arrived: read.arrived.with(i.arrived_ready),
                // What was asked for always finds room.
                outside: outside::Wires {
                    request: request.with(i.outside.ready),
                    response: i.outside.response.with(true),
                },
                events: Events {
                    stored: store.place.valid,
                    spilled: store.place.valid && cfg.is_outside(store.place.payload.section),
                    first: store.first,
                    section_taken: store.take,
                    dropped: store.dropped,
                    waits: store.waits,
                    compared: store.stored_read.valid,
                    weight_changed: store.stored_write.valid,
                    chain_begun: back.chain_begun,
                    read: back.read.valid,
                    read_again: back.read_again,
                    culled_late: back.culled,
                    ssa_hit: cached.hit,
                    ssa_miss: cached.miss,
                    ssa_write_back: cached.write_back,
                },
            },
        }
    }
}
