//! The contract of a buffer between a client and outside memory, see [`pellucid_blocks::buffer`], as properties: the client sees
//! a plain memory.
//!
//! A sequence says for every cycle what the client begins to ask for, whether the memory takes and whether it answers, and
//! whether the buffer is flushed or reset. A request stays until it is taken. A word that is written counts how often it was.
//! Behind the last cycle all is answered and the buffer is flushed, so that nothing can have been lost.

use crate::reference::{Judged, Long, Reference};
use pellucid_blocks::buffer::Buffer;
use pellucid_blocks::{cache, combiner};
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::{Fault, Signals, Stream};
use proptest::prelude::*;
use std::collections::VecDeque;
use std::fmt::{self, Debug};

/// A buffer that can be tested.
pub trait Tried:
    Buffer<
        Config: Clone + Debug,
        In: Signals<Config = Self::Config>,
        Out: Signals<Config = Self::Config> + Default,
    > + 'static
{
    /// Configurations to be tried, of words of up to 64 bits. Of the first two every state is looked at.
    fn configs() -> Vec<Self::Config>;
    /// The most cycles in a row in which nothing moves on either side, while something is asked for, is due or is being flushed,
    /// and the memory takes and answers at once.
    fn latency(cfg: &Self::Config) -> u32;
}

impl Tried for cache::Cache {
    fn configs() -> Vec<cache::Config> {
        let shapes = [
            (2, 1, 1, 1, true),
            (2, 1, 1, 1, false),
            (4, 1, 1, 2, true),
            (64, 2, 2, 4, true),
            (64, 2, 2, 2, false),
            (64, 1, 16, 2, true),
            (64, 8, 1, 4, true),
        ];
        let config = |(words, sets, ways, line, write_back)| cache::Config {
            port: port(words),
            sets,
            ways,
            line,
            write_back,
        };
        shapes.map(config).to_vec()
    }
    fn latency(cfg: &cache::Config) -> u32 {
        // A flush that comes after a reset waits until all sets are cleared and looks through all of them; one that comes later
        // waits for two requests.
        2 * cfg.sets + 2
    }
}

impl Tried for combiner::Combiner {
    fn configs() -> Vec<combiner::Config> {
        let shapes =
            [(2, 1, 1), (2, 1, 2), (4, 1, 2), (16, 2, 2), (64, 4, 4), (64, 16, 2), (64, 2, 16)];
        let config = |(words, lines, line)| combiner::Config { port: port(words), lines, line };
        shapes.map(config).to_vec()
    }
    fn latency(_: &combiner::Config) -> u32 {
        2
    }
}

/// A port of so many words: small ones where there are few.
fn port(words: u32) -> outside::Config {
    outside::Config { words, bits: if words > 4 { 8 } else { 1 } }
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The client asks for a word from now on, to be written or read, unless it does already.
    pub ask: Option<(bool, u32)>,
    /// The memory takes what is asked of it.
    pub ready: bool,
    /// It answers the oldest read.
    pub answer: bool,
    /// A flush is asked for.
    pub flush: bool,
    /// The buffer is reset instead.
    pub reset: bool,
}

impl Step {
    /// A step in which all moves that can.
    const MOVES: Step = Step { ask: None, ready: true, answer: true, flush: false, reset: false };
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A read gives what was written before it.
    Read,
    /// Nothing is answered but what was read.
    Early,
    /// What is asked of the memory is held until it is taken.
    Held,
    /// The memory is asked for words that there are.
    Range,
    /// Where it is idle after a flush all is in memory, and nothing is taken before.
    Flush,
    /// While the memory takes and answers, all goes on within the latency.
    Stuck,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Read => "a read gives what was written before it",
            Property::Early => "nothing is answered but what was read",
            Property::Held => "what is asked of the memory is held until it is taken",
            Property::Range => "the memory is asked for words that there are",
            Property::Flush => {
                "where it is idle after a flush all is in memory, and nothing is taken before"
            }
            Property::Stuck => "while the memory takes and answers, all goes on within the latency",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// The plain memory that a client sees, beside the one that is behind the buffer.
pub struct Model<B: Tried> {
    cfg: B::Config,
    /// What the client must see of each word.
    client: Vec<u64>,
    /// What the memory has.
    memory: Vec<u64>,
    /// What the client asks for, until it is taken.
    offered: Option<Request>,
    /// What the client must be answered.
    due: VecDeque<u64>,
    /// What the memory has to answer.
    answers: VecDeque<u64>,
    /// What was asked of the memory in the cycle before and not taken.
    held: Option<Request>,
    /// It was flushed and was not idle since.
    flushes: bool,
    /// Cycles in a row in which nothing moved, though it could.
    still: u32,
    /// The memory takes a request in this cycle.
    ready: bool,
    /// Something could move in this cycle, and does.
    moves: (bool, bool),
    /// What the client asked for in the cycle that was played last, what the memory answered, and what was done.
    last: (Option<Request>, Option<u64>, Step),
    /// What is broken by what the client sees in this cycle.
    seen: Judged<Property>,
}

/// A word that holds a number.
fn word(number: u64) -> Word {
    Word { low: number, ..Word::default() }
}

impl<B: Tried> Model<B> {
    fn port(&self) -> outside::Config {
        B::port(&self.cfg)
    }

    /// The request that a client begins with; a write counts how often its word was written.
    fn request(&self, (write, address): (bool, u32)) -> Request {
        let now = self.client[address as usize];
        let next = now.wrapping_add(1) & (u64::MAX >> (u64::BITS - self.port().bits));
        Request { write, address, word: word(if write { next } else { 0 }) }
    }

    /// What the client sees of a buffer that is idle or not.
    fn client_sees(&mut self, idle: bool, client: outside::In) -> Judged<Property> {
        let outside::In { ready, response } = client;
        if response.valid {
            let is = response.payload.low;
            match self.due.pop_front() {
                None => return Err((Property::Early, format!("{is} comes where nothing is due"))),
                Some(due) if due != is => {
                    return Err((Property::Read, format!("{is} comes where {due} is due")));
                }
                _ => self.moves.1 = true,
            }
        }
        if self.flushes && ready && !idle {
            let seen = "it is ready for the client before it is idle".to_string();
            return Err((Property::Flush, seen));
        }
        if let Some(Request { write, address, word }) = self.offered.take_if(|_| ready) {
            self.moves.1 = true;
            if write {
                self.client[address as usize] = word.low;
            } else {
                self.due.push_back(self.client[address as usize]);
            }
        }
        Ok(())
    }
}

/// Any step, where a request is begun, the memory takes and answers so often.
fn step(port: outside::Config, often: f64, reset: f64) -> BoxedStrategy<Step> {
    let ask = proptest::option::weighted(often, (any::<bool>(), 0..port.words));
    let often = || prop::bool::weighted(often);
    (ask, often(), often(), prop::bool::weighted(0.02), prop::bool::weighted(reset))
        .prop_map(|(ask, ready, answer, flush, reset)| Step { ask, ready, answer, flush, reset })
        .boxed()
}

impl<B: Tried> Reference for Model<B> {
    type Block = B;
    type Config = B::Config;
    type Setup = B::Config;
    type Step = Step;
    type Property = Property;
    type Outputs = B::Out;
    const NAME: &'static str = "buffer";

    fn setups() -> BoxedStrategy<B::Config> {
        prop::sample::select(B::configs()).boxed()
    }
    fn steps(cfg: &B::Config) -> BoxedStrategy<Step> {
        step(B::port(cfg), 0.5, 0.01)
    }
    fn long() -> Vec<Long<Self>> {
        let long = |cfg: B::Config| {
            let step = step(B::port(&cfg), 0.9, 0.0);
            Long { setup: Just(cfg).boxed(), step, steps: 20_000 }
        };
        B::configs().into_iter().map(long).collect()
    }
    fn small() -> Vec<B::Config> {
        B::configs().into_iter().take(2).collect()
    }
    fn told(cfg: &B::Config) -> String {
        format!("{cfg:?}")
    }
    fn config(cfg: &B::Config) -> B::Config {
        cfg.clone()
    }
    fn new(cfg: &B::Config) -> Model<B> {
        let outside::Config { words, bits } = B::port(cfg);
        let at_first = (0..u64::from(words)).map(|at| (5 * at) & ((1 << bits) - 1));
        let memory: Vec<u64> = at_first.collect();
        Model {
            cfg: cfg.clone(),
            client: memory.clone(),
            memory,
            offered: None,
            due: VecDeque::new(),
            answers: VecDeque::new(),
            held: None,
            flushes: false,
            still: 0,
            ready: false,
            moves: (false, false),
            last: (None, None, Step::default()),
            seen: Ok(()),
        }
    }

    fn look(&mut self, _: u64, seen: &B::Moore) -> Judged<Property> {
        if self.flushes && B::idle(seen) {
            self.flushes = false;
            let differs = |at: &usize| self.memory[*at] != self.client[*at];
            if let Some(at) = (0..self.client.len()).find(differs) {
                let (is, due) = (self.memory[at], self.client[at]);
                let seen = format!("the memory has {is} at {at} where {due} was written");
                return Err((Property::Flush, seen));
            }
        }
        if self.still > B::latency(&self.cfg) {
            return Err((Property::Stuck, format!("nothing moves for {} cycles", self.still)));
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, seen: &B::Moore) -> Option<B::In> {
        if step.reset {
            // What was not in memory is lost, and so are answers.
            let memory = std::mem::take(&mut self.memory);
            *self = Model { client: memory.clone(), memory, ..Model::new(&self.cfg) };
            return None;
        }
        self.offered = self.offered.or(step.ask.map(|ask| self.request(ask)));
        let offer = self.offered.map_or(Stream::idle(), Stream::offer);
        let answer = if step.answer { self.answers.pop_front() } else { None };
        self.last = (self.offered, answer, *step);
        let response = answer.map_or(Stream::idle(), |number| Stream::offer(word(number)));
        let memory = outside::In { ready: step.ready, response };
        let busy = self.offered.is_some() || !self.due.is_empty() || self.flushes;
        // A flush that is asked for again begins anew.
        self.moves = (busy && step.ready && step.answer && !step.flush, answer.is_some());
        self.ready = step.ready;
        self.seen = self.client_sees(B::idle(seen), B::client(seen, memory));
        self.flushes |= step.flush;
        Some(B::inputs(offer, memory, step.flush))
    }

    fn judge(&mut self, out: &B::Out) -> Judged<Property> {
        std::mem::replace(&mut self.seen, Ok(()))?;
        let asks = B::asks(out);
        if let Some(before) = self.held.filter(|before| asks != Stream::offer(*before)) {
            let now = if asks.valid { told(asks.payload) } else { "nothing".to_string() };
            return Err((Property::Held, format!("{}, then {now}", told(before))));
        }
        self.held = (asks.valid && !self.ready).then_some(asks.payload);
        if asks.valid && asks.payload.address >= self.port().words {
            let seen = format!("{}, of {} words", told(asks.payload), self.port().words);
            return Err((Property::Range, seen));
        }
        if asks.valid && self.ready {
            let Request { write, address, word } = asks.payload;
            if write {
                self.memory[address as usize] = word.low;
            } else {
                self.answers.push_back(self.memory[address as usize]);
            }
        }
        let (could, moved) = self.moves;
        let moved = moved || asks.valid && self.ready;
        self.still = if could && !moved { self.still + 1 } else { 0 };
        Ok(())
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        let busy = self.offered.is_some() || !self.due.is_empty() || self.flushes;
        let flush = !busy && self.memory != self.client;
        (busy || flush).then_some(Step { flush, ..Step::MOVES })
    }
    fn choices(&self) -> Vec<Step> {
        let moves = [(true, true), (true, false), (false, false)];
        let moves = moves.map(|(ready, answer)| Step { ready, answer, ..Step::default() });
        let words = if self.offered.is_some() { 0 } else { self.port().words };
        // A client that waits for so many answers does not ask for more.
        let reads = if self.due.len() < 2 { words } else { 0 };
        let asks = (0..words).map(|at| Some((true, at)));
        let asks = asks.chain((0..reads).map(|at| Some((false, at)))).chain([None]);
        let ends = [Step { flush: true, ..Step::MOVES }, Step { reset: true, ..Step::default() }];
        asks.flat_map(|ask| moves.map(|step| Step { ask, ..step })).chain(ends).collect()
    }
    fn known(&self, to: &mut Vec<u64>) {
        let request = |request: Option<Request>| {
            let number = |Request { write, address, word }| {
                1 | u64::from(write) << 1 | u64::from(address) << 2 | word.low << 32
            };
            request.map_or(0, number)
        };
        to.extend(self.client.iter().chain(&self.memory));
        to.extend([request(self.offered), request(self.held), u64::from(self.flushes)]);
        to.extend([u64::from(self.still), self.due.len() as u64, self.answers.len() as u64]);
        to.extend(self.due.iter().chain(&self.answers));
    }
    fn outputs(_: &B::Moore, out: Option<&B::Out>) -> B::Out {
        out.copied().unwrap_or_default()
    }
    fn tell(&self, _: &B::In) -> Vec<String> {
        let (asks, answer, step) = self.last;
        let mut what = vec![];
        what.extend(asks.map(told));
        what.extend(step.ready.then(|| "the memory takes".to_string()));
        what.extend(answer.map(|number| format!("the memory answers {number}")));
        what.extend(step.flush.then(|| "flush".to_string()));
        what
    }
}

/// A request in words.
fn told(Request { write, address, word }: Request) -> String {
    if write {
        format!("{} is written to {address}", word.low)
    } else {
        format!("{address} is read")
    }
}

/// Tests of everything that the contract of a buffer asks for: `buffer_properties!(MyBuffer)`, or with a name for the module
/// that they stand in, `buffer_properties!(MyBuffer, mine)`.
#[macro_export]
macro_rules! buffer_properties {
    ($buffer:ty) => {
        $crate::buffer_properties!($buffer, buffer_properties);
    };
    ($buffer:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::buffer::Model<$buffer>, $name $(, $states)?);
    };
}
