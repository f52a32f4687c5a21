//! The lookup: from a pixel to its chain of sections and its opaque depth.
//!
//! ```text
//!             +--------+
//!  pixel ---->|        |---> chain (Stream), then the end of the frame
//!  ready <----| Lookup |<--- chain_ready
//!  entry ---->|        |---> SSA read, write
//!  depth ---->|        |---> depth read
//!             +--------+
//! ```
//! One pixel a cycle. A pixel without fragments is passed over; the SSA entry of any other is set to
//! NULL as it leaves, so that the next frame finds a clean table.

use super::config::Config;
use super::tables::SsaEntry;
use pellucid_machine::pixel::{Marked, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, WritePort, fifo, rtl};

/// See the module's description.
pub struct Lookup;

/// A pixel's chain of sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Chain {
    /// The pixel.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// Its opaque depth.
    #[width(Z_BITS)]
    pub depth: u32,
    /// Its SSA entry.
    #[with(*cfg)]
    pub entry: SsaEntry,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Pixels that arrived.
    #[with(cfg.pixels_ahead())]
    pub queue: fifo::State,
    /// The pixel whose entry was asked for.
    #[with(cfg.screen.pixel_bits())]
    pub stage: Stream<Marked<u32>>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Pixels to visit, then the end of the frame.
    #[with(cfg.screen.pixel_bits())]
    pub pixel: Stream<Marked<u32>>,
    /// The SSA entry that was asked for. Where the table is cached, once it is there.
    #[with(*cfg)]
    pub ssa: Read<SsaEntry>,
    /// The depth that was asked for. Where depths lie outside, once it is there.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The receiver takes a chain.
    pub chain_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A pixel is taken.
    pub ready: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Reads an SSA entry.
    #[with(cfg.screen.pixel_bits())]
    pub ssa_read: ReadPort,
    /// Sets an SSA entry to NULL.
    #[with(cfg.screen.pixel_bits(), *cfg)]
    pub ssa_write: WritePort<SsaEntry>,
    /// The SSA entry at hand is done with, and the depth.
    pub taken: bool,
    /// Reads a pixel's opaque depth.
    #[with(cfg.screen.pixel_bits())]
    pub depth_read: ReadPort,
    /// Chains, then the end of the frame.
    #[with(*cfg)]
    pub chain: Stream<Marked<Chain>>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Pixels that arrived.
    pub queue: <Queue as Block>::Mem,
}

type Queue = Fifo<Marked<u32>>;

#[inline(always)]
fn queue(cfg: &Config) -> fifo::Config<u32> {
    fifo::Config { depth: cfg.pixels_ahead(), item: cfg.screen.pixel_bits() }
}

#[rtl(
    check(Lookup, crate::test_util::small(true)),
    check(Lookup, crate::test_util::small(false)),
    check(Lookup, crate::test_util::small_caching(true, true)),
    check(Lookup, crate::test_util::small_depth_ahead())
)]
impl Block for Lookup {
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

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        Moore { ready: Queue::moore(&queue(cfg), &q.queue, &m.queue).ready }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (mut ssa_read, mut ssa_write) = (ReadPort::default(), WritePort::default());
        let mut depth_read = ReadPort::default();

        // Second stage: the pixel's entry and depth are at hand.
        let Marked { end, item: pixel } = q.stage.payload;
        let there = cfg.is_there(i.ssa) && (!cfg.shape.depth_ahead || i.depth.valid);
        let found = q.stage.valid && (end || (there && !cfg.is_null(i.ssa.data)));
        let stall = (found && !i.chain_ready) || (q.stage.valid && !end && !there);
        let taken = q.stage.valid && !end && !stall;
        if found && !end && i.chain_ready {
            ssa_write.write(pixel, SsaEntry::null(cfg));
        }
        let chain = Chain { pixel, depth: i.depth.data, entry: i.ssa.data };

        // First stage: ask for those of the next pixel.
        let front = Queue::moore(&queue(cfg), &q.queue, &m.queue).front;
        if !stall {
            d.stage = front;
            if front.valid && !front.payload.end {
                ssa_read.read(front.payload.item);
                if !cfg.shape.depth_ahead {
                    depth_read.read(front.payload.item);
                }
            }
        }
        let to_queue = fifo::In { push: i.pixel, pop: !stall };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        let chain = Stream { valid: found, payload: Marked { end, item: chain } };
        Out { ssa_read, ssa_write, taken, depth_read, chain }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chains::config::Shape;
    use crate::test_util::{
        Pattern, Source, contents, edge, holding, pattern, screen, shape, traffic,
    };
    use pellucid_sim::stream::valid_ignores_ready;
    use pellucid_sim::{ReadDuringWrite, Sim, StreamMonitor};
    use proptest::prelude::*;

    fn config() -> Config {
        let shape = Shape { on_chip: 100, outside: 20, ..shape() };
        Config::new(screen(5, 4), shape)
    }

    const EMPTY: SsaEntry = SsaEntry { head: 120, tail: 0, fill: 0 };

    fn depth_of(pixel: u32) -> u32 {
        1000 + pixel
    }

    /// Looks up `visits` in a table of `entries`; gives what came out with its cycles, and the table
    /// afterwards.
    fn play(
        entries: &[SsaEntry],
        visits: &[u32],
        starts: Pattern,
        ready: &Pattern,
    ) -> (Vec<(u64, Marked<Chain>)>, Vec<SsaEntry>) {
        let cfg = config();
        let mut sim = Sim::<Lookup>::new(cfg);
        let mut ssa = holding(entries, cfg, ReadDuringWrite::New);
        let depths: Vec<u32> = (0..20).map(depth_of).collect();
        let mut depth = holding(&depths, Z_BITS, ReadDuringWrite::Forbidden);
        let frame = visits.iter().copied().map(Marked::item).chain([Marked::end()]);
        let mut source = Source::new(frame, starts);
        let mut monitor = StreamMonitor::new("chain", "Lookup", "test");
        let mut found = vec![];
        for cycle in 0.. {
            assert!(cycle < 10_000, "the end of the frame does not come");
            let i = In {
                pixel: source.offer(cycle),
                ssa: ssa.q(),
                depth: depth.q(),
                chain_ready: ready.at(cycle),
            };
            assert!(valid_ignores_ready::<Lookup, _>(
                &cfg,
                sim.state(),
                || Lookup::memories(&cfg),
                |chain_ready| In { chain_ready, ..i },
                |out| out.chain,
            ));
            source.edge(sim.moore().ready);
            let out = sim.clock(i).unwrap().out;
            ssa.pass_read(out.ssa_read);
            ssa.pass_write(out.ssa_write);
            edge(&mut ssa);
            depth.pass_read(out.depth_read);
            edge(&mut depth);
            let chain = out.chain.with(i.chain_ready);
            monitor.observe(chain).unwrap();
            let end = chain.payload.end;
            if chain.fires() {
                found.push((cycle, if end { Marked::end() } else { chain.payload }));
            }
            if chain.fires() && end {
                break;
            }
        }
        // Each visited entry is read once, each chain's is written once, whatever stalled.
        let (visits, chains) = (visits.len() as u64, found.len() as u64 - 1);
        assert_eq!(traffic(&mut ssa), (visits, 20 + chains));
        assert_eq!(traffic(&mut depth).0, visits);
        (found, contents(&mut ssa, 20))
    }

    fn used(pixel: u32) -> SsaEntry {
        SsaEntry { head: pixel * 3, tail: pixel * 3 + 1, fill: 2 }
    }

    #[test]
    fn one_pixel_a_cycle_empty_or_not() {
        let entries: Vec<SsaEntry> =
            (0..20).map(|p| if p % 3 == 1 { EMPTY } else { used(p) }).collect();
        let visits: Vec<u32> = (0..20).collect();
        let (found, _) = play(&entries, &visits, Pattern::always(), &Pattern::always());
        let first = found[0].0;
        let cycles: Vec<u64> = found.iter().map(|(cycle, _)| cycle - first).collect();
        let expected: Vec<u64> = (0..=20).filter(|p| *p == 20 || p % 3 != 1).collect();
        assert_eq!(cycles, expected);
    }

    proptest! {
        /// The chains of the visited pixels that have one, in order; their entries are NULL after.
        #[test]
        fn gives_chains_and_leaves_null(
            has in proptest::collection::vec(any::<bool>(), 20),
            visits in proptest::sample::subsequence((0..20).collect::<Vec<u32>>(), 0..=20),
            starts in pattern(),
            ready in pattern(),
        ) {
            let mut entries: Vec<SsaEntry> =
                (0..20).map(|p| if has[p as usize] { used(p) } else { EMPTY }).collect();
            let (found, after) = play(&entries, &visits, starts, &ready);
            let mut expected = vec![];
            for &pixel in visits.iter().filter(|p| has[**p as usize]) {
                let entry = entries[pixel as usize];
                expected.push(Marked::item(Chain { pixel, depth: depth_of(pixel), entry }));
                entries[pixel as usize] = EMPTY;
            }
            expected.push(Marked::end());
            let found: Vec<_> = found.into_iter().map(|(_, chain)| chain).collect();
            prop_assert_eq!(found, expected);
            prop_assert_eq!(after, entries);
        }
    }
}
