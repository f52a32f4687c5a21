//! What is held to the contract: a unit that counts fragments, beside the memory of its counters.

use pellucid_blocks::array::config::{Band, Config};
use pellucid_blocks::array::counters::{self, Counters, Counts};
use pellucid_blocks::array::index::{self, Index};
use pellucid_machine::pixel::{Marked, PixelFragment};
use pellucid_sim::{Block, Memory, Read, Registers, Signals, Stream};
use std::marker::PhantomData;

/// A unit that counts: a block with the ports of [`Index`].
pub trait Counting:
    Block<
        Config = Config,
        State: Registers<Config = Config>,
        In = index::In,
        Moore = index::Moore,
        Out = index::Out,
    > + 'static
{
    /// Cycles from the one in which the end of a frame is taken to that in which all of it is counted.
    fn latency(cfg: &Config) -> u32;
}

impl Counting for Index {
    fn latency(_: &Config) -> u32 {
        2
    }
}

/// A memory of counters: a block with the ports of [`Counters`].
pub trait Words:
    Block<Config = Config, State = (), In = counters::In, Moore = Read<Counts>, Out = ()> + 'static
{
}

impl<B> Words for B where
    B: Block<Config = Config, State = (), In = counters::In, Moore = Read<Counts>, Out = ()>
        + 'static
{
}

/// A unit that counts beside its counters.
pub struct Counted<I = Index, C = Counters>(PhantomData<(I, C)>);

/// Memories.
#[derive(Memory)]
pub struct Mem<I: Memory, C: Memory> {
    /// Those of the unit.
    pub index: I,
    /// The counters.
    pub counters: C,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct In {
    /// A fragment, or the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// What is asked of the counters beside that.
    #[with(*cfg)]
    pub others: counters::In,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// The word that was read.
    #[with(*cfg)]
    pub counts: Read<Counts>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Config)]
pub struct Out {
    /// A fragment is counted.
    pub counted: bool,
    /// All of the frame are.
    pub ended: bool,
}

/// What a waveform shows.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Outputs {
    /// Before the inputs come.
    #[with(*cfg)]
    pub seen: Moore,
    /// After that.
    #[with(*cfg)]
    pub out: Out,
}

impl<I: Counting, C: Words> Block for Counted<I, C> {
    type Config = Config;
    type State = I::State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem<I::Mem, C::Mem>;

    fn reset(cfg: &Config) -> I::State {
        I::reset(cfg)
    }
    fn memories(cfg: &Config) -> Self::Mem {
        Mem { index: I::memories(cfg), counters: C::memories(cfg) }
    }
    fn moore(cfg: &Config, q: &I::State, m: &Self::Mem) -> Moore {
        let counts = C::moore(cfg, &(), &m.counters);
        Moore { ready: I::moore(cfg, q, &m.index).ready, counts }
    }
    fn next(cfg: &Config, q: &I::State, d: &mut I::State, m: &mut Self::Mem, i: In) -> Out {
        let to_index = index::In {
            counting: true,
            fragment: i.fragment,
            counts: C::moore(cfg, &(), &m.counters),
            bases: Read::default(),
            band: Band { from: 0, to: cfg.screen.pixels() },
            length: 0,
            outside_ready: true,
        };
        let index = I::next(cfg, q, d, &mut m.index, to_index);
        let (index_read, index_write) = (index.count_read, index.count_write);
        let to_counters = counters::In { index_read, index_write, ..i.others };
        C::next(cfg, &(), &mut (), &mut m.counters, to_counters);
        Out { counted: index.counted, ended: index.ended }
    }
}
