//! Reads pixels of a bank ahead of their use, in the order in which they are asked for.
//!
//! ```text
//!               +-------+
//!  ask -------->|       |---> mark read
//!  ready <------| Fetch |---> request (Stream)
//!  marked ----->|       |<--- memory (ready, response)
//!  pixel <------|       |---> looked (the pixel whose mark was used)
//!  taken ------>|       |---> idle
//!               +-------+
//! ```
//! One pixel a cycle. One without its mark is not read: it is as nothing has drawn into it. Up to
//! [`reads_in_flight`](config::Config::reads_in_flight) pixels are under way. One that is read is shown `3 + L` cycles after its ask, where memory answers
//! `L` cycles after a request, and another one 2 cycles after; each until it is `taken`. So pixels come one a cycle with `L + 3`
//! reads in flight. Where the memory does not take a request all wait. No word may be asked for that may be written meanwhile.

use super::config;
use super::pixel::Pixel;
use crate::skid::{self, Skid};
use pellucid_machine::outside::{self, Request, Word};
use pellucid_machine::pixel::{COLOUR_BITS, Z_BITS};
use pellucid_sim::{Block, Fifo, Memory, Read, ReadPort, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Fetch;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The frame buffer.
    pub pixels: config::Config,
    /// Depths are used; else colours alone.
    pub depths: bool,
}

impl Config {
    fn bank(&self) -> outside::Config {
        self.pixels.bank()
    }
    fn reads_in_flight(&self) -> u32 {
        self.pixels.reads_in_flight
    }
    fn pixel_bits(&self) -> u32 {
        self.pixels.screen.pixel_bits()
    }
    /// Reads under way, each with whether it is one.
    #[inline]
    fn pending(&self) -> fifo::Config<()> {
        fifo::Config { depth: self.reads_in_flight(), item: () }
    }
    /// Their answers.
    #[inline]
    fn answers(&self) -> fifo::Config<bool> {
        fifo::Config { depth: self.reads_in_flight(), item: self.depths }
    }
}

/// What is used of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(bool)]
pub struct Fetched {
    /// Its depth.
    #[width(if *cfg { Z_BITS } else { 0 })]
    pub depth: u32,
    /// Its colour, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// What is used of it, where depths are or not.
#[inline(always)]
#[rtl]
fn used(cfg: &Config, pixel: Pixel) -> Fetched {
    Fetched { depth: if cfg.depths { pixel.depth } else { 0 }, colour: pixel.colour }
}

type Requests = Skid<Request>;
type Pending = Fifo<bool>;
type Answers = Fifo<Fetched>;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The pixel whose mark is shown.
    #[with(cfg.pixel_bits())]
    pub stage: Stream<u32>,
    /// A read that memory has not taken yet.
    #[with(cfg.bank())]
    #[block(Requests)]
    pub requests: skid::State<Request>,
    /// Pixels under way; whether each is read.
    #[with(cfg.reads_in_flight())]
    #[block(Pending, cfg.pending())]
    pub pending: fifo::State,
    /// Those that have come.
    #[with(cfg.reads_in_flight())]
    #[block(Answers, cfg.answers())]
    pub answers: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A pixel that will be used.
    #[with(cfg.pixel_bits())]
    pub ask: Stream<u32>,
    /// The mark that was asked for.
    pub marked: Read<bool>,
    /// The pixel at hand is done with.
    pub taken: bool,
    /// What the memory drives.
    #[with(cfg.bank())]
    pub memory: outside::In,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// An ask is taken.
    pub ready: bool,
    /// The pixels that were asked for, in that order.
    #[with(cfg.depths)]
    pub pixel: Stream<Fetched>,
    /// Nothing is under way.
    pub idle: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a mark.
    #[with(cfg.pixel_bits())]
    pub mark_read: ReadPort,
    /// The pixel whose mark was used in this cycle.
    #[with(cfg.pixel_bits())]
    pub looked: Stream<u32>,
    /// Reads a pixel.
    #[with(cfg.bank())]
    pub request: Stream<Request>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Pixels under way.
    #[block(Pending, cfg.pending())]
    pub pending: <Pending as Block>::Mem,
    /// Those that have come.
    #[block(Answers, cfg.answers())]
    pub answers: <Answers as Block>::Mem,
}

#[rtl(check(Fetch, Config { pixels: super::tests::config(1, 2), depths: true }), check(Fetch, Config { pixels: super::tests::config(4, 7), depths: false }))]
impl Block for Fetch {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let pending = Pending::moore(&cfg.pending(), &q.pending, &m.pending);
        let answer = Answers::moore(&cfg.answers(), &q.answers, &m.answers).front;
        let room = Requests::moore(&cfg.bank(), &q.requests, &()).ready;
        let reads = pending.front.payload;
        let clear = used(cfg, Pixel::clear(&cfg.pixels.screen));
        Moore {
            ready: !q.stage.valid || (pending.ready && room),
            pixel: Stream {
                valid: pending.front.valid && (!reads || answer.valid),
                payload: if reads { answer.payload } else { clear },
            },
            idle: !q.stage.valid && pending.count == 0,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let Moore { ready, pixel, .. } = Self::moore(cfg, q, m);

        // Second stage: the mark says whether the pixel is read.
        let goes = q.stage.valid && ready;
        let reads = goes && i.marked.data;
        let read = Request { write: false, address: q.stage.payload, word: Word::default() };
        let push = Stream { valid: reads, payload: read };
        let to_requests = skid::In { push, taken: i.memory.ready };
        let request =
            Requests::next(&cfg.bank(), &q.requests, &mut d.requests, &mut (), to_requests);

        // First stage: asks for the next one's.
        let mut mark_read = ReadPort::default();
        if ready {
            d.stage = i.ask;
            if i.ask.valid {
                mark_read.read(i.ask.payload);
            }
        }

        let leaves = pixel.valid && i.taken;
        let from_memory = Pending::moore(&cfg.pending(), &q.pending, &m.pending).front.payload;
        let push = Stream { valid: goes, payload: i.marked.data };
        let to_pending = fifo::In { push, pop: leaves };
        Pending::next(&cfg.pending(), &q.pending, &mut d.pending, &mut m.pending, to_pending);
        let came = Pixel::of_word(&cfg.pixels.screen, i.memory.response.payload);
        let to_answers = fifo::In {
            push: Stream { valid: i.memory.response.valid, payload: used(cfg, came) },
            pop: leaves && from_memory,
        };
        Answers::next(&cfg.answers(), &q.answers, &mut d.answers, &mut m.answers, to_answers);
        Out { mark_read, looked: Stream { valid: goes, payload: q.stage.payload }, request }
    }
}
