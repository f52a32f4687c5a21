//! A table that lies in outside memory behind a [`TableCache`], with entries as its users know them.
//!
//! ```text
//!             +-------------+
//!  ask ------>|             |---> entry
//!  ready <----| CachedTable |<--- taken, write
//!  clear ---->|             |---> request (Stream)
//!  ready <----|             |<--- memory (ready, response)
//!             +-------------+
//! ```
//! Latency, throughput, order and what waits are those of the [`table_cache`]; [`Entry`] says how an entry is a word. What is
//! shown is as the [`Read`] of a memory on chip, but that it is `valid` once the entry is there, until it is `taken`: a user
//! that waits for it serves both.
//!
//! `clear` names an entry, which then holds [`Entry::first`]; a number behind the last one is passed over. So that the last entry's
//! line is whole the words behind it in that line are cleared too, by themselves, after a reset and before any entry.

mod config;

pub use config::{Cached, Config, Place, Shape};

use crate::table_cache::{self, TableCache};
use pellucid_machine::outside::{self, Word};
use pellucid_sim::netlist::Value;
use pellucid_sim::{Block, Memory, Read, Signals, Stream, rtl};
use std::marker::PhantomData;

/// See the module's description.
pub struct CachedTable<E>(PhantomData<E>);

/// What a table holds for a number, in 64 bits at most.
pub trait Entry: Signals + Default {
    /// What it holds after a reset.
    fn first(cfg: &<Self as Signals>::Config) -> Self;
    /// The word that holds an entry.
    fn packed(cfg: &<Self as Signals>::Config, entry: Self) -> Word;
    /// The entry that a word holds.
    fn unpacked(cfg: &<Self as Signals>::Config, word: Word) -> Self;
    /// [`Entry::packed`] as `#[rtl]` makes it.
    fn packed_netlist(cfg: &<Self as Signals>::Config, entry: Value) -> Value;
    /// [`Entry::unpacked`] as `#[rtl]` makes it.
    fn unpacked_netlist(cfg: &<Self as Signals>::Config, word: Value) -> Value;
}

/// Makes a type an [`Entry`], of a configuration, with what it holds after a reset: its `word` and `of_word`, which are `#[rtl]`.
macro_rules! entry {
    ($entry:ty, $config:ty, $first:expr) => {
        impl $crate::cached_table::Entry for $entry {
            fn first(cfg: &$config) -> $entry {
                $first(cfg)
            }
            #[inline(always)]
            fn packed(cfg: &$config, entry: $entry) -> ::pellucid_machine::outside::Word {
                <$entry>::word(cfg, entry)
            }
            #[inline(always)]
            fn unpacked(cfg: &$config, word: ::pellucid_machine::outside::Word) -> $entry {
                <$entry>::of_word(cfg, word)
            }
            fn packed_netlist(
                cfg: &$config,
                entry: ::pellucid_sim::netlist::Value,
            ) -> ::pellucid_sim::netlist::Value {
                <$entry>::word_netlist(cfg, entry)
            }
            fn unpacked_netlist(
                cfg: &$config,
                word: ::pellucid_sim::netlist::Value,
            ) -> ::pellucid_sim::netlist::Value {
                <$entry>::of_word_netlist(cfg, word)
            }
        }
    };
}
pub(crate) use entry;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Shape)]
pub struct State {
    /// The cache.
    #[with(cfg.cache)]
    #[block(TableCache, cfg.cache)]
    pub cache: table_cache::State,
    /// Words behind the last entry that are cleared.
    #[width(cfg.padding_bits())]
    #[exists(cfg.padding() > 0)]
    pub padded: u32,
}

/// Memories.
#[derive(Memory)]
#[memory(Shape)]
pub struct Mem {
    /// The cache.
    #[block(TableCache, cfg.cache)]
    pub cache: table_cache::Mem,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<E::Config>)]
pub struct In<E: Signals> {
    /// The number of an entry that will be used.
    #[with(cfg.shape.cache.port.address_bits())]
    pub ask: Stream<u32>,
    /// The entry that is shown is done with.
    pub taken: bool,
    /// What it holds from now on. Without effect where none is taken.
    #[with(cfg.entry)]
    pub write: Stream<E>,
    /// The number of an entry that is cleared.
    #[with(u32::BITS)]
    pub clear: Stream<u32>,
    /// All that was written is to be in memory.
    #[exists(cfg.shape.cache.flushes)]
    pub flush: bool,
    /// What the memory drives.
    #[with(cfg.shape.cache.port)]
    pub memory: outside::In,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config<E::Config>)]
pub struct Moore<E: Signals> {
    /// An ask is taken.
    pub ready: bool,
    /// An entry that is cleared is taken.
    pub clear_ready: bool,
    /// The entries that were asked for, in that order.
    #[with(cfg.entry)]
    pub entry: Read<E>,
    /// Nothing is under way, and all is in memory where a flush was asked for.
    #[exists(cfg.shape.cache.flushes)]
    pub idle: bool,
}

#[rtl(
    state = cfg.shape,
    output = cfg.shape.cache,
    check(CachedTable<SsaEntry>, crate::test_util::small_caching(true, true).ssa_table()),
    check(CachedTable<Counts>, crate::test_util::caching_arrays(2, true).counter_table()),
    check(CachedTable<Sums>, crate::test_util::caching_arrays(1, false).sum_table())
)]
impl<E> Block for CachedTable<E>
where
    E: Entry,
    <E as Signals>::Config: Copy,
{
    type Config = Config<<E as Signals>::Config>;
    type State = State;
    type In = In<E>;
    type Moore = Moore<E>;
    type Out = table_cache::Out;
    type Mem = Mem;

    fn reset(cfg: &Self::Config) -> State {
        State::reset(&cfg.shape)
    }

    fn memories(cfg: &Self::Config) -> Mem {
        Mem::new(&cfg.shape)
    }

    fn moore(cfg: &Self::Config, q: &State, m: &Mem) -> Moore<E> {
        let seen = TableCache::moore(&cfg.shape.cache, &q.cache, &m.cache);
        let data = E::unpacked(&cfg.entry, seen.entry.payload.word);
        Moore {
            ready: seen.ready,
            clear_ready: seen.clear_ready && q.padded == cfg.shape.padding(),
            entry: Read { valid: seen.entry.valid, data },
            idle: seen.idle,
        }
    }

    fn next(
        cfg: &Self::Config,
        q: &State,
        d: &mut State,
        m: &mut Mem,
        i: In<E>,
    ) -> table_cache::Out {
        let first = E::packed(&cfg.entry, E::first(&cfg.entry));
        let mut clears = i.clear.valid && i.clear.payload < cfg.shape.entries;
        let mut address = if clears { i.clear.payload } else { 0 };
        if q.padded < cfg.shape.padding() {
            let takes = TableCache::moore(&cfg.shape.cache, &q.cache, &m.cache).clear_ready;
            address = cfg.shape.entries + q.padded;
            clears = true;
            d.padded = q.padded + u32::from(takes);
        }
        let to_cache = table_cache::In {
            ask: i.ask,
            taken: i.taken,
            write: Stream { valid: i.write.valid, payload: E::packed(&cfg.entry, i.write.payload) },
            clear: Stream { valid: clears, payload: table_cache::Entry { address, word: first } },
            flush: i.flush,
            memory: i.memory,
        };
        TableCache::next(&cfg.shape.cache, &q.cache, &mut d.cache, &mut m.cache, to_cache)
    }
}

#[cfg(test)]
use crate::array::{counters::Counts, prefix_sum::Sums};
#[cfg(test)]
use crate::chains::tables::SsaEntry;
