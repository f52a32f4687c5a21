//! What the tests of several blocks share.

use crate::allocator::AllocatorKind;
use crate::array::{config as array, fixed};
use crate::buffer::Buffer;
use crate::cached_table::Cached;
use crate::chains::config::{Config, Link, Passes, Shape};
use crate::weights::WEIGHT_BITS;
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::stream::valid_ignores_ready;
use pellucid_sim::{Block, Sim, Stream, StreamMonitor};
pub use pellucid_test_util::behind::{Behind, at_first, read, word, write};
pub use pellucid_test_util::*;
use proptest::prelude::*;
use std::fmt::Debug;
use std::ops::Range;
use std::panic::{RefUnwindSafe, catch_unwind};

/// Chains that keep tails, with a bitmap, as large as an architecture has them.
pub fn shape() -> Shape {
    Shape {
        owned: false,
        on_chip: 262_144,
        outside: 1_048_576,
        outside_latency: 64,
        capacity: 3,
        link: Link::Tail,
        bitmap: true,
        reads_in_flight: 64,
        passes: Passes::Each(16),
        weight_bits: 0,
        allocator: AllocatorKind::Fifo,
        ssa: None,
        depth_ahead: false,
    }
}

/// Chains for few pixels, whose memories are smaller than random numbers: kept tail and bitmap, or neither.
pub fn small(fast: bool) -> Config {
    let shape = Shape {
        on_chip: 13,
        outside: 6,
        outside_latency: 3,
        link: if fast { Link::Tail } else { Link::Walk },
        bitmap: fast,
        reads_in_flight: 5,
        passes: Passes::Each(4),
        ..shape()
    };
    Config::new(screen(16, 9), shape)
}

/// The faster ones with so many sections on chip and outside.
pub fn small_of(on_chip: u32, outside: u32) -> Config {
    let small = small(true);
    Config::new(small.screen, Shape { on_chip, outside, ..small.shape })
}

/// The faster ones, of which new sections go before the first one.
pub fn small_newest_first() -> Config {
    let small = small(true);
    Config::new(small.screen, Shape { link: Link::Head, ..small.shape })
}

/// The slower ones, with an NSA table that lends entries.
pub fn small_lending() -> Config {
    let mut cfg = small(false);
    cfg.shape.allocator = AllocatorKind::Threaded;
    cfg
}

/// The faster or the slower ones, with an SSA table that lies outside, and sections beside it or not.
pub fn small_caching(fast: bool, sections: bool) -> Config {
    let small = small(fast);
    let outside = if sections { small.shape.outside } else { 0 };
    Config::new(small.screen, Shape { ssa: CACHED, outside, ..small.shape })
}

/// The faster ones, with opaque depths outside.
pub fn small_depth_ahead() -> Config {
    let small = small(true);
    Config::new(small.screen, Shape { depth_ahead: true, ..small.shape })
}

/// Chains of which each pixel owns the first section: weights in memory, or none.
pub fn small_owned(in_memory: bool) -> Config {
    let shape = Shape {
        owned: true,
        on_chip: 5,
        outside: 6,
        outside_latency: 3,
        capacity: 2,
        reads_in_flight: 5,
        passes: if in_memory { Passes::One } else { Passes::Twice(3) },
        weight_bits: if in_memory { WEIGHT_BITS } else { 0 },
        ..shape()
    };
    Config::new(screen(5, 3), shape)
}

/// Requests of words among `addresses`; each write writes its own number.
pub fn requests(addresses: Range<u32>, most: usize) -> impl Strategy<Value = Vec<Request>> {
    proptest::collection::vec((any::<bool>(), addresses), 0..most).prop_map(|asks| {
        let asks = asks.into_iter().zip(1..);
        asks.map(|((writes, at), k)| if writes { write(at, k) } else { read(at) }).collect()
    })
}

/// A buffer that tells what it does.
pub trait Counted: Buffer {
    /// How often its outputs tell what.
    type Events: Copy + Debug + Default + PartialEq;
    /// All that was read is answered while it is idle.
    const ANSWERED: bool;

    /// Counts what a cycle tells.
    fn count(out: &Self::Out, events: &mut Self::Events);
}

/// A buffer between a client that takes every answer and a memory.
pub struct Bench<B: Counted> {
    pub sim: Sim<B>,
    pub memory: Behind,
    from_client: StreamMonitor<Request>,
    to_memory: StreamMonitor<Request>,
    /// What the memory took, and when.
    pub asked: Vec<(u64, Request)>,
    /// What was answered, and when.
    pub answers: Vec<(u64, Word)>,
    pub events: B::Events,
}

impl<B: Counted> Bench<B> {
    pub fn new(cfg: B::Config, memory: Behind) -> Bench<B> {
        Bench {
            sim: Sim::new(cfg),
            memory,
            from_client: StreamMonitor::new("request", "client", "buffer"),
            to_memory: StreamMonitor::new("request", "buffer", "memory"),
            asked: vec![],
            answers: vec![],
            events: B::Events::default(),
        }
    }
    fn client(&self) -> outside::In {
        B::client(&self.sim.moore(), self.memory.shows(self.sim.cycle()))
    }
    fn idle(&self) -> bool {
        B::idle(&self.sim.moore())
    }
    /// A cycle; whether the request was taken.
    pub fn cycle(&mut self, request: Stream<Request>, flush: bool) -> bool {
        let cycle = self.sim.cycle();
        let (client, memory) = (self.client(), self.memory.shows(cycle));
        self.answers.extend(client.response.valid.then_some((cycle, client.response.payload)));
        self.from_client.observe(request.with(client.ready)).unwrap();
        let inputs = |ready| B::inputs(request, outside::In { ready, ..memory }, flush);
        let cfg = self.sim.config();
        let memories = || B::memories(cfg);
        assert!(valid_ignores_ready::<B, _>(cfg, self.sim.state(), memories, inputs, B::asks));
        let out = self.sim.clock(inputs(memory.ready)).unwrap().out;
        let asks = B::asks(&out);
        self.to_memory.observe(asks.with(memory.ready)).unwrap();
        self.asked.extend((asks.valid && memory.ready).then_some((cycle, asks.payload)));
        self.memory.edge(cycle, asks);
        B::count(&out, &mut self.events);
        request.valid && client.ready
    }
    /// Cycles until the request is taken; gives the cycle in which it was.
    pub fn ask(&mut self, request: Request) -> u64 {
        for _ in 0..1000 {
            if self.cycle(Stream::offer(request), false) {
                return self.sim.cycle() - 1;
            }
        }
        panic!("{request:?} is not taken");
    }
    /// Cycles until it is idle, at least one.
    pub fn rest(&mut self) {
        for _ in 0..5000 {
            self.cycle(Stream::idle(), false);
            if self.idle() {
                return;
            }
        }
        panic!("it does not come to rest");
    }
    /// Cycles from the request of a word to its answer, if nothing else is under way.
    pub fn latency(&mut self, address: u32) -> u64 {
        let before = self.answers.len();
        let asked = self.ask(read(address));
        for _ in 0..1000 {
            if let Some((cycle, _)) = self.answers.get(before) {
                return cycle - asked;
            }
            self.cycle(Stream::idle(), false);
        }
        panic!("it is not answered");
    }
    /// Cycles from a flush to the end of it.
    pub fn flush(&mut self) -> u64 {
        let asked = self.sim.cycle();
        self.cycle(Stream::idle(), true);
        assert!(!self.idle() && !self.client().ready);
        self.rest();
        self.sim.cycle() - asked
    }

    /// Plays requests that are offered from the cycles of `starts` on, flushes it in the cycles of `flushes`, and at the end.
    /// Tells of each request that is taken, and of each flush. What is read is what was written last, answered in order and
    /// once, and after a flush all is in memory.
    pub fn play(
        &mut self,
        requests: &[Request],
        starts: Pattern,
        flushes: &[u64],
        mut tell: impl FnMut(Option<Request>),
    ) -> Result<(), TestCaseError> {
        let mut array = self.memory.words.clone();
        let mut expected = vec![];
        let mut source = Source::new(requests.iter().copied(), starts);
        let last = flushes.iter().max().map_or(0, |last| last + 1);
        let (mut taken, mut flushing) = (0, false);
        for cycle in 0.. {
            prop_assert!(cycle < 30_000, "not all is done");
            let (client, idle) = (self.client(), self.idle());
            if flushing && (client.ready || idle) {
                prop_assert!(idle);
                prop_assert_eq!(&self.memory.words, &array, "after a flush, in cycle {}", cycle);
                flushing = false;
            }
            let answered = self.answers.len() == expected.len();
            prop_assert!(answered || !idle || !B::ANSWERED, "idle before all is answered");
            if idle && answered && taken == requests.len() && cycle >= last {
                break;
            }
            let flush = flushes.contains(&cycle);
            let offer = source.offer(cycle);
            let fires = self.cycle(offer, flush);
            source.edge(client.ready);
            if fires {
                let Request { write, address, word } = offer.payload;
                if write {
                    array[address as usize] = word;
                } else {
                    expected.push(array[address as usize]);
                }
                tell(Some(offer.payload));
                taken += 1;
            }
            if flush {
                tell(None);
                flushing = true;
            }
        }
        let answers: Vec<Word> = self.answers.iter().map(|(_, word)| *word).collect();
        prop_assert_eq!(answers, expected);
        self.flush();
        tell(None);
        prop_assert_eq!(&self.memory.words, &array);
        Ok(())
    }
}

/// Arrays for few pixels, whose memories are smaller than random numbers: with bands where counted down, with drops where
/// counted up.
pub fn arrays(lanes: u32, down: bool) -> array::Config {
    let shape = array::Shape {
        lanes,
        count_bits: 3,
        down,
        sweeps: false,
        bands: down,
        on_chip: 13,
        outside: 6,
        outside_latency: 3,
        reads_in_flight: 5,
        depth: 4,
        fixed: 0,
        cached: None,
        pixels_ahead: false,
    };
    array::Config::new(screen(16, 9), shape)
}

/// The same with counters and sums outside, and slots beside them where counted down.
pub fn caching_arrays(lanes: u32, down: bool) -> array::Config {
    let cfg = arrays(lanes, down);
    let outside = if down { cfg.shape.outside } else { 0 };
    array::Config::new(cfg.screen, array::Shape { cached: CACHED, outside, ..cfg.shape })
}

const CACHED: Option<Cached> = Some(Cached { sets: 2, ways: 2, line: 4 });

/// The same of which the counters are summed up in sweeps.
pub fn sweeping(lanes: u32, down: bool, bands: bool) -> array::Config {
    let cfg = arrays(lanes, down);
    array::Config::new(cfg.screen, array::Shape { sweeps: true, bands, ..cfg.shape })
}

/// Fixed arrays for few pixels that may become longer, on chip and outside.
pub fn fixed() -> fixed::Config {
    fixed_at(1)
}

/// The same with so many slots each to begin with, of 3 at most.
pub fn fixed_at(begin: u32) -> fixed::Config {
    fixed::Config::new(screen(9, 5), fixed::Shape { begin, ..FIXED })
}

/// The same with pixels outside.
pub fn fixed_ahead() -> fixed::Config {
    fixed::Config::new(screen(9, 5), fixed::Shape { pixels_ahead: true, ..FIXED })
}

/// The same with counters outside, and slots beside them or not.
pub fn caching_fixed(slots: bool) -> fixed::Config {
    let on_chip = if slots { FIXED.on_chip } else { 9 * 5 * FIXED.most };
    fixed::Config::new(screen(9, 5), fixed::Shape { cached: CACHED, on_chip, ..FIXED })
}

const FIXED: fixed::Shape = fixed::Shape {
    begin: 1,
    most: 3,
    on_chip: 70,
    outside_latency: 3,
    reads_in_flight: 5,
    depth: 2,
    cached: None,
    pixels_ahead: false,
};

/// What a block says of a configuration that it refuses.
pub fn refusal<B: Block<Config: RefUnwindSafe>>(cfg: &B::Config) -> String {
    let made = catch_unwind(|| drop(B::reset(cfg)));
    *made.expect_err("it is made").downcast::<String>().unwrap()
}
