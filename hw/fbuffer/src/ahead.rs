//! The F-buffer in outside memory: a queue of what a pass has left, which is read ahead of the walk (`buffer=outside`).
//!
//! ```text
//!               +-------+
//!  write ------>|       |---> room
//!  taken ------>| Ahead |---> next (Stream), there, values
//!  reads, over->|       |---> request (Stream)
//!               +-------+<--- memory (ready, response)
//! ```
//! What a pass leaves lies one behind the other from address 0 on, in the order in which it comes, and the next pass finds it in
//! this order: no place is named. So all reads of a pass are known when it begins. They are asked for as long as there is
//! room on chip for what comes, [`Config::reads_in_flight`] words of the F-buffer; the next one is shown once it is `there`.
//!
//! A word of the F-buffer takes [`Config::parts`] words of the port, one after the other. A write goes before a read: it waits for the
//! port alone, while whoever writes waits for `room`. In a pass nothing is written before what lay there was read and taken, and no read
//! is asked for while a part of a write is left; as the port keeps the order of requests, a read finds what was written.
//!
//! The port takes a request a cycle: with `p` parts a pass that reads and writes takes `2 p` cycles for a fragment, one that
//! does one of these `p`, whatever the latency, if as many reads are in flight as answers take cycles to come.

use crate::program::MOST_VALUES;
use crate::shader::{self, Values};
use crate::window::COUNT_BITS;
use pellucid_blocks::skid::{self, Skid};
use pellucid_machine::outside::{self, Outside, Request, Table, Word};
use pellucid_sim::fifo::after;
use pellucid_sim::{
    Block, Fifo, Label, Memory, Read, Signals, Stream, bits_for, check_range, fifo, rtl,
};

/// See the module's description.
pub struct Ahead;

/// Bits of a word of the port, at most.
const PORT_BITS: u32 = 128;
/// The most words of the port that a word of the F-buffer takes: 16 values of 32 bits, and what is kept beside them.
const MOST_PARTS: usize = 5;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// What a pass leaves.
    pub shader: shader::Config,
    /// Words of the F-buffer that are asked for and not taken, at least 1.
    pub reads_in_flight: u32,
    /// Cycles from a read request to its data, at least 1.
    pub latency: u32,
}

impl Config {
    /// Bits beside the values: the number of a fragment, or that it was killed.
    fn beside_bits(&self) -> u32 {
        if self.shader.window.compacts { COUNT_BITS } else { self.shader.tells().into() }
    }
    fn word_bits(&self) -> u32 {
        self.shader.values() * self.shader.bits + self.beside_bits()
    }
    /// Words of the port that a word of the F-buffer takes, 1 to 5.
    #[inline]
    pub fn parts(&self) -> u32 {
        self.word_bits().div_ceil(PORT_BITS)
    }
    /// The port.
    #[inline]
    pub fn port(&self) -> outside::Config {
        if !self.shader.window.outside {
            return outside::Config::NONE;
        }
        let words = self.shader.words() * self.parts();
        outside::Config { words, bits: self.word_bits().min(PORT_BITS) }
    }
    /// The memory behind it.
    pub fn outside_memory(&self) -> Option<Outside> {
        let outside::Config { words, bits } = self.port();
        let table = || Table { path: "buffer.outside".to_string(), words, bits };
        (words > 0).then(|| Outside { tables: vec![table()], latency: self.latency })
    }
    /// Bits of how many words of the port there are.
    fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.port().words))
    }
    fn part_bits(&self) -> u32 {
        bits_for(u64::from(self.parts() - 1))
    }
    fn words(&self) -> fifo::Config<shader::Config> {
        fifo::Config { depth: self.reads_in_flight, item: self.shader }
    }
}

/// What a pass leaves of a fragment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(shader::Config)]
pub struct Left {
    /// Its values.
    #[with(*cfg)]
    pub values: Values,
    /// Its number in the play.
    #[width(COUNT_BITS)]
    #[exists(cfg.window.compacts)]
    pub number: u32,
}

/// The lower or the upper half of a word of the port with bits that begin at bit `at` of the word of the F-buffer.
#[inline(always)]
#[rtl]
fn with(word: Word, at: &u32, bits: u64) -> Word {
    let mut with = word;
    let shifted = bits << (*at % 64);
    if *at % PORT_BITS < 64 {
        with.low |= shifted;
    } else {
        with.high |= shifted;
    }
    with
}

/// So many bits from bit `at` of the word of the F-buffer on, of the word of the port that has them.
#[inline(always)]
#[rtl]
fn bits_at(word: Word, at: &u32, bits: &u32) -> u64 {
    let half = if *at % PORT_BITS < 64 { word.low } else { word.high };
    half >> (*at % 64) & (u64::MAX >> (u64::BITS - *bits))
}

#[rtl]
impl Config {
    /// A word of the F-buffer as words of the port: values from the lowest bit on, then what is kept beside them.
    #[inline(always)]
    fn packed(&self, left: Left, label: Label) -> [Word; MOST_PARTS] {
        let mut parts = [Word { low: 0, high: 0, label }; MOST_PARTS];
        for k in 0..self.shader.values() {
            let at = k * self.shader.bits;
            let part = (at / PORT_BITS) as usize;
            parts[part] = with(parts[part], &at, u64::from(left.values.of[k as usize]));
        }
        let at = self.shader.values() * self.shader.bits;
        let part = (at / PORT_BITS) as usize;
        if self.shader.window.compacts {
            parts[part] = with(parts[part], &at, u64::from(left.number));
        } else if self.shader.tells() {
            parts[part] = with(parts[part], &at, u64::from(left.values.killed));
        }
        parts
    }
    /// The word of the F-buffer that words of the port are.
    #[inline(always)]
    fn unpacked(&self, parts: [Word; MOST_PARTS]) -> Left {
        let (mut of, mut killed, mut number) = ([0; MOST_VALUES], false, 0);
        for k in 0..self.shader.values() {
            let at = k * self.shader.bits;
            let word = parts[(at / PORT_BITS) as usize];
            of[k as usize] = bits_at(word, &at, &self.shader.bits) as u32;
        }
        let at = self.shader.values() * self.shader.bits;
        let part = (at / PORT_BITS) as usize;
        if self.shader.window.compacts {
            number = bits_at(parts[part], &at, &COUNT_BITS) as u32;
        } else if self.shader.tells() {
            killed = bits_at(parts[part], &at, &1) == 1;
        }
        Left { values: Values { of, killed }, number }
    }
}

/// Registers. What is counted in addresses is counted in words of the port.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Addresses that the pass before has written.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// Of these, how many were asked for.
    #[width(cfg.count_bits())]
    pub asked: u32,
    /// Addresses that this pass has written, or is about to.
    #[width(cfg.count_bits())]
    pub written: u32,
    /// Words of the F-buffer that were asked for and not taken.
    #[width(bits_for(u64::from(cfg.reads_in_flight)))]
    pub reserved: u32,
    /// The part that is asked for next.
    #[width(cfg.part_bits())]
    pub asks: u32,
    /// The part that comes next.
    #[width(cfg.part_bits())]
    pub comes: u32,
    /// Parts that came of a word of which more are to come.
    #[with(cfg.port())]
    #[len(cfg.parts() - 1)]
    pub came: [Word; MOST_PARTS - 1],
    /// Parts that are left to be written.
    #[width(cfg.part_bits())]
    pub left: u32,
    /// These, the next one first.
    #[with(cfg.port())]
    #[len(cfg.parts() - 1)]
    pub rest: [Word; MOST_PARTS - 1],
    /// The address of the next one.
    #[width(cfg.count_bits())]
    #[exists(cfg.parts() > 1)]
    pub address: u32,
    /// Words that came.
    #[with(cfg.reads_in_flight)]
    pub words: fifo::State,
    /// The one that was taken last.
    #[with(cfg.shader)]
    pub values: Values,
    /// A request that the memory did not take yet.
    #[with(cfg.port())]
    pub requests: skid::State<Request>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// What a pass leaves, in order; there is `room`.
    #[with(cfg.shader)]
    pub write: Stream<Left>,
    /// The fragment that it is of, in waveforms.
    pub label: Label,
    /// The next word is taken: its values are seen from the next cycle on.
    pub taken: bool,
    /// The pass reads what the one before has left.
    pub reads: bool,
    /// The play is over.
    pub over: bool,
    /// What the memory drives.
    #[with(cfg.port())]
    pub memory: outside::In,
}

/// Outputs of registers, and of what was read.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Moore {
    /// There is room for a write.
    pub room: bool,
    /// The number of the next fragment of which something is left.
    #[with(COUNT_BITS)]
    #[exists(cfg.shader.window.compacts)]
    pub next: Stream<u32>,
    /// The next word is here, or there is none.
    pub there: bool,
    /// The values of the one that was taken last.
    #[with(cfg.shader)]
    pub values: Read<Values>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Words that came.
    pub words: <Words as Block>::Mem,
}

type Words = Fifo<Left>;
type Requests = Skid<Request>;

#[rtl(
    output = cfg.port(),
    check(Ahead, crate::test_util::ahead(&[("program", "glass"), ("component_bits", "8")], 3)),
    check(Ahead, crate::test_util::ahead(&[("program", "sieve")], 2)),
    check(Ahead, crate::test_util::ahead(&[("program", "sieve"), ("kill", "compact"), ("targets", "4")], 1))
)]
impl Block for Ahead {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Stream<Request>;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the number of reads in flight", cfg.reads_in_flight, 1..);
        check_range("the latency of outside memory", cfg.latency, 1..);
        State {
            count: 0,
            asked: 0,
            written: 0,
            reserved: 0,
            asks: 0,
            comes: 0,
            came: [Word::default(); MOST_PARTS - 1],
            left: 0,
            rest: [Word::default(); MOST_PARTS - 1],
            address: 0,
            words: Words::reset(&cfg.words()),
            values: Values::default(),
            requests: Requests::reset(&cfg.port()),
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { words: Words::memories(&cfg.words()) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let front = Words::moore(&cfg.words(), &q.words, &m.words).front;
        let ready = Requests::moore(&cfg.port(), &q.requests, &()).ready;
        let none = q.asked == q.count && q.reserved == 0;
        Moore {
            room: ready && q.left == 0,
            next: Stream { valid: front.valid, payload: front.payload.number },
            there: front.valid || none,
            values: Read { valid: true, data: q.values },
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Stream<Request> {
        let ready = Requests::moore(&cfg.port(), &q.requests, &()).ready;

        // A write goes first, then what is left of one, then a read if there is room for what comes.
        let mut request = Stream::idle();
        let mut begins = false;
        let parts = cfg.packed(i.write.payload, i.label);
        let room = q.asks > 0 || q.reserved < cfg.reads_in_flight;
        if i.write.valid {
            request = Stream::offer(Request { write: true, address: q.written, word: parts[0] });
            d.written = q.written + cfg.parts();
            d.left = cfg.parts() - 1;
            d.address = q.written + 1;
            for k in 1..cfg.parts() {
                d.rest[k as usize - 1] = parts[k as usize];
            }
        } else if q.left > 0 {
            if ready {
                let word = q.rest[0];
                request = Stream::offer(Request { write: true, address: q.address, word });
                d.left = q.left - 1;
                d.address = q.address + 1;
                for k in 2..cfg.parts() {
                    d.rest[k as usize - 2] = q.rest[k as usize - 1];
                }
            }
        } else if i.reads && ready && q.asked < q.count && room {
            let word = Word::default();
            request = Stream::offer(Request { write: false, address: q.asked, word });
            d.asked = q.asked + 1;
            d.asks = after(cfg.parts(), q.asks);
            begins = q.asks == 0;
        }

        // What comes is a word of the F-buffer once its last part is there.
        let back = i.memory.response;
        let last = q.comes + 1 == cfg.parts();
        let mut whole = [back.payload; MOST_PARTS];
        for k in 1..cfg.parts() {
            whole[k as usize - 1] = q.came[k as usize - 1];
            if back.valid && q.comes == k - 1 {
                d.came[k as usize - 1] = back.payload;
            }
        }
        if back.valid {
            d.comes = after(cfg.parts(), q.comes);
        }
        let front = Words::moore(&cfg.words(), &q.words, &m.words).front.payload;
        if i.taken {
            d.values = front.values;
        }
        let push = Stream { valid: back.valid && last, payload: cfg.unpacked(whole) };
        let to_words = fifo::In { push, pop: i.taken };
        Words::next(&cfg.words(), &q.words, &mut d.words, &mut m.words, to_words);
        d.reserved = q.reserved + u32::from(begins) - u32::from(i.taken);

        if i.over {
            d.count = q.written;
            d.asked = 0;
            d.written = 0;
        }
        let to_requests = skid::In { push: request, taken: i.memory.ready };
        Requests::next(&cfg.port(), &q.requests, &mut d.requests, &mut (), to_requests)
    }
}

#[cfg(test)]
mod tests;
