//! An arbiter: several clients that speak the port to outside memory, each with a part of one memory.
//!
//! ```text
//!                      +---------+
//!  request, for each ->|         |---> request (Stream)
//!    ready, for each <-| Arbiter |<--- memory (ready, response)
//!          answered  <-|         |---> idle
//!                      +---------+
//! ```
//! Both sides are the port of [`outside`]: what a client sees of it, which [`client`] gives, is a memory of its own. Their
//! words lie one behind the other in the memory, those of client 0 first.
//!
//! No latency: a request goes to the memory in the cycle in which it comes if nothing stands before it, and an answer to whom it
//! belongs in the cycle in which the memory gives it. Throughput 1: a request goes in each cycle in which the memory takes one
//! and one is there that may go. Each client has a [`Skid`]; a client that always offers does so in each cycle in which it can
//! be its turn.
//!
//! *Round robin*: of clients that always offer each has the same share. Whoever waits is behind each other client once at most.
//! *Priority*: the client with the lowest number goes first. What was offered to the memory stays, whoever comes then.
//!
//! *Reads*: the memory answers in order, so that a queue of whom it will answer is all that is needed. While it has
//! [`Config::reads_in_flight`] clients in it, reads wait and writes go before them, by turns of their own. For a read in each
//! cycle it needs one more than the cycles from a request to its answer.
//!
//! The clients take their answers at once. A reset forgets who is to be answered, so that the memory is reset with it.

use crate::round_robin::{self, behind, first};
use crate::skid::{self, Skid, offered};
use pellucid_machine::choice;
use pellucid_machine::outside::{self, Request};
use pellucid_sim::{
    Block, Fifo, Memory, Ram1R1W, Signals, Stream, bits_for, check_range, fifo, rtl,
};

/// See the module's description.
pub struct Arbiter;

/// The most clients that there can be.
pub const MAX_CLIENTS: usize = 4;

choice! {
    /// Whose request goes first.
    pub enum Policy {
        /// Each client's in turn.
        RoundRobin = "round_robin",
        /// That of the client with the lowest number.
        Priority = "priority",
    }
}

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Words of each client, at least 1; 0 behind the last of them.
    pub words: [u32; MAX_CLIENTS],
    /// Bits of a word, 1 to 128.
    pub bits: u32,
    /// Who goes first.
    pub policy: Policy,
    /// Reads that are asked for and not answered, at least 1.
    pub reads_in_flight: u32,
}

impl Config {
    /// What is named where nothing takes turns.
    pub const NONE: Config =
        Config { words: [1, 0, 0, 0], bits: 1, policy: Policy::RoundRobin, reads_in_flight: 1 };
    /// How many clients there are.
    pub fn clients(&self) -> u32 {
        self.words.iter().take_while(|words| **words > 0).count() as u32
    }
    /// The port of client `k`; none beyond the last.
    pub fn client(&self, k: u32) -> outside::Config {
        outside::Config { words: self.words[k as usize], bits: self.bits }
    }
    /// Where its words begin in the memory.
    pub fn base(&self, k: u32) -> u32 {
        self.words[..k as usize].iter().sum()
    }
    /// The port of the memory.
    pub fn memory(&self) -> outside::Config {
        outside::Config { words: self.base(self.clients()), bits: self.bits }
    }
    fn client_bits(&self) -> u32 {
        bits_for(u64::from(self.clients() - 1))
    }
    fn readers(&self) -> fifo::Config<u32> {
        fifo::Config { depth: self.reads_in_flight, item: self.client_bits() }
    }
    fn in_turn(&self) -> bool {
        self.policy == Policy::RoundRobin
    }
    fn check(&self) {
        check_range("the number of words of an arbiter's client", self.words[0], 1..);
        for words in &self.words[self.clients() as usize..] {
            check_range("the number of words behind the last client of an arbiter", *words, ..=0);
        }
        let all: u64 = self.words.iter().map(|words| u64::from(*words)).sum();
        assert!(
            u32::try_from(all).is_ok(),
            "the number of words behind an arbiter is {all}: expected at most {}",
            u32::MAX
        );
        check_range("the number of bits of an arbiter's word", self.bits, 1..=128);
        check_range("the number of an arbiter's reads in flight", self.reads_in_flight, 1..);
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What each client asked for and the memory did not take yet.
    #[with(cfg.client(k as u32))]
    #[len(cfg.clients())]
    pub requests: [skid::State<Request>; MAX_CLIENTS],
    /// Whose request was offered to the memory and not taken.
    #[with(cfg.client_bits())]
    pub offers: Stream<u32>,
    /// The client whose turn it is.
    #[width(cfg.client_bits())]
    #[exists(cfg.in_turn())]
    pub turn: u32,
    /// The client whose turn it is while writes alone may go.
    #[width(cfg.client_bits())]
    #[exists(cfg.in_turn())]
    pub write_turn: u32,
    /// Whom the memory will answer.
    #[with(cfg.reads_in_flight)]
    pub readers: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// What each client asks for.
    #[with(cfg.client(k as u32))]
    #[len(cfg.clients())]
    pub request: [Stream<Request>; MAX_CLIENTS],
    /// What the memory drives. It answers what it was asked for and nothing else.
    #[with(cfg.memory())]
    pub memory: outside::In,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Moore {
    /// A request of the client is taken.
    #[len(cfg.clients())]
    pub ready: [bool; MAX_CLIENTS],
    /// The client that the memory's next answer is for.
    #[width(cfg.client_bits())]
    pub answered: u32,
    /// Nothing is under way.
    pub idle: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What is asked of the memory.
    #[with(cfg.memory())]
    pub request: Stream<Request>,
    /// The client that asks.
    #[width(cfg.client_bits())]
    pub client: u32,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Whom the memory will answer.
    pub readers: Ram1R1W<u32>,
}

type Requests = Skid<Request>;
type Readers = Fifo<u32>;

/// What client `k` sees of it, as of a memory.
#[inline(always)]
#[rtl]
pub fn client(k: &u32, seen: Moore, memory: outside::In) -> outside::In {
    let answered = memory.response.valid && seen.answered == *k;
    let response = Stream { valid: answered, payload: memory.response.payload };
    outside::In { ready: seen.ready[*k as usize], response }
}

#[rtl(
    check(Arbiter, tests::config(&[9], Policy::RoundRobin, 2)),
    check(Arbiter, tests::config(&[8, 5], Policy::Priority, 1)),
    check(Arbiter, tests::config(&[3, 1, 20], Policy::RoundRobin, 3)),
    check(Arbiter, tests::config(&[16, 16, 16, 16], Policy::RoundRobin, 8)),
    check(Arbiter, tests::config(&[2, 30, 7, 9], Policy::Priority, 4))
)]
impl Block for Arbiter {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        cfg.check();
        State {
            requests: std::array::from_fn(|k| Requests::reset(&cfg.client(k as u32))),
            offers: Stream::idle(),
            turn: 0,
            write_turn: 0,
            readers: Readers::reset(&cfg.readers()),
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { readers: Readers::memories(&cfg.readers()) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let readers = Readers::moore(&cfg.readers(), &q.readers, &m.readers);
        let mut ready = [false; MAX_CLIENTS];
        let mut idle = !readers.front.valid;
        for k in 0..cfg.clients() {
            let room = Requests::moore(&cfg.client(k), &q.requests[k as usize], &()).ready;
            ready[k as usize] = room;
            idle &= room;
        }
        Moore { ready, answered: readers.front.payload, idle }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let room = Readers::moore(&cfg.readers(), &q.readers, &m.readers).ready;
        let mut requests = [Stream::idle(); MAX_CLIENTS];
        let mut asks = [false; round_robin::MOST];
        for k in 0..cfg.clients() {
            let kept = Requests::moore(&cfg.client(k), &q.requests[k as usize], &()).held;
            let request = offered(kept, i.request[k as usize]);
            requests[k as usize] = request;
            asks[k as usize] = request.valid && (request.payload.write || room);
        }
        let mut turn = 0;
        if cfg.in_turn() {
            turn = if room { q.turn } else { q.write_turn };
        }
        let next = first(&cfg.clients(), asks, turn);
        let goes = if q.offers.valid { q.offers } else { next };
        let who = goes.payload;
        // Once it is on offer it will go, so that it has had its turn.
        if cfg.in_turn() && next.valid && !q.offers.valid {
            let then = behind(&cfg.clients(), who);
            if room {
                d.turn = then;
            } else {
                d.write_turn = then;
            }
        }
        d.offers = Stream { valid: goes.valid && !i.memory.ready, payload: who };

        let mut ask = Request::default();
        for k in 0..cfg.clients() {
            let its = goes.valid && who == k;
            if its {
                ask = requests[k as usize].payload;
                ask.address += cfg.base(k);
            }
            let to_requests =
                skid::In { push: i.request[k as usize], taken: its && i.memory.ready };
            Requests::next(
                &cfg.client(k),
                &q.requests[k as usize],
                &mut d.requests[k as usize],
                &mut (),
                to_requests,
            );
        }
        let reads = goes.valid && i.memory.ready && !ask.write;
        let push = Stream { valid: reads, payload: who };
        let to_readers = fifo::In { push, pop: i.memory.response.valid };
        Readers::next(&cfg.readers(), &q.readers, &mut d.readers, &mut m.readers, to_readers);
        Out { request: Stream { valid: goes.valid, payload: ask }, client: who }
    }
}

#[cfg(test)]
mod tests;
