//! A write combiner: gathers words that are written to one burst of memory, and sends them together.
//!
//! ```text
//!                +----------+
//!  request ----->|          |---> request (Stream)
//!  ready <-------| Combiner |<--- memory_ready
//!  flush ------->|          |---> idle
//!                +----------+
//! ```
//! It keeps the contract of a [`buffer`](crate::buffer). A memory that moves whole bursts moves one for each word that is
//! written alone: here words of a line, which should be a burst, wait for each other. The answers of the memory are the
//! client's as they come.
//!
//! A word that is written is put into its line, which is opened if it is not yet open. A line leaves, its words one after
//! the other from the lowest on and nothing between them,
//! - as soon as all its words were written,
//! - where another line is to be opened and all that there may be are open: the line that was written least recently (LRU),
//! - when a word of it that was written is read,
//! - on a flush.
//!
//! *Writes*: one a cycle, while lines are open or leave as fast. A line makes room at once when it begins to leave, but for the
//! words of it that the memory did not take yet. The first word of a line is offered in the cycle after it begins to leave, which
//! is the one after its last write at the earliest; in a memory that takes a request a cycle lines leave without a gap.
//!
//! *Reads*: one passes in the cycle in which it comes, if no line leaves. Else it waits until that one has left; of a word that
//! was written, until the word's own line has, too. So a read gives what was written before it.
//!
//! *Flush*: asked for in any cycle; from the next cycle on the combiner takes nothing, until all that it took is in memory.
//! `idle` is high while nothing is on its way to memory or asked for, though lines are open; after a flush in such a cycle it is
//! high again 2 cycles later, and one more for each word that was written, in a memory as above. A reset loses what was not
//! sent.
//!
//! Where words are read again, or many lines are written in turn, use [`Cache`](crate::cache::Cache).

use crate::bits::{bit, lowest, rest};
use crate::buffer::Buffer;
use crate::cache::config::{check_lines, check_power_of_two};
use crate::cache::{self, Line, MAX_WAYS, Set, tags};
use crate::skid::{self, Skid, offered};
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::{Block, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, check_range, rtl};

/// See the module's description.
pub struct Combiner;

/// The most lines that can be open.
pub const MAX_LINES: usize = MAX_WAYS;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The port of the client and of the memory; a whole number of lines.
    pub port: outside::Config,
    /// Lines that can be open, 1..=[`MAX_LINES`]; a power of two.
    pub lines: u32,
    /// Words of a line, 1..=[`MAX_LINE`](cache::MAX_LINE); a power of two.
    pub line: u32,
}

impl Config {
    /// Holds every number to its range.
    fn check(&self) {
        let Config { port, lines, line } = *self;
        check_lines("combiner", port, line);
        let most = (MAX_LINES as u32).min(port.words / line);
        check_range("the number of lines of a combiner", lines, 1..=most);
        check_power_of_two("lines of a combiner", lines);
    }
    /// Its lines are those of the only set of a cache.
    fn cache(&self) -> cache::Config {
        let Config { port, lines, line } = *self;
        cache::Config { port, sets: 1, ways: lines, line, write_back: false }
    }
    fn way_bits(&self) -> u32 {
        self.cache().way_bits()
    }
    fn tag_bits(&self) -> u32 {
        self.cache().tag_bits()
    }
    fn line_bits(&self) -> u32 {
        self.cache().line_bits()
    }
}

/// A line on its way to memory.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Leaving {
    /// A word of it is shown by the data, and offered.
    pub valid: bool,
    /// Which line it is.
    #[width(cfg.tag_bits())]
    pub tag: u32,
    /// Where it is.
    #[width(cfg.way_bits())]
    pub way: u32,
    /// The word that is offered.
    #[width(cfg.line_bits())]
    pub word: u32,
    /// Those that come behind it.
    #[width(cfg.line)]
    pub left: u64,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// A request that waits.
    #[with(cfg.port)]
    #[block(Requests)]
    pub requests: skid::State<Request>,
    /// The lines that are open.
    #[with(cfg.cache())]
    #[reset(tags::empty(&cfg.cache()))]
    pub open: Set,
    /// The words of each that were written.
    #[width(cfg.line)]
    #[len(cfg.lines)]
    pub written: [u64; MAX_LINES],
    /// The line that leaves.
    #[with(*cfg)]
    pub leaving: Leaving,
    /// A flush was asked for and is not done.
    pub flush: bool,
}

type Requests = Skid<Request>;

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// What the client asks for.
    #[with(cfg.port)]
    pub request: Stream<Request>,
    /// The memory takes what is asked of it.
    pub memory_ready: bool,
    /// All that was written is to be in memory.
    pub flush: bool,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A request of the client is taken.
    pub ready: bool,
    /// Nothing is on its way to memory.
    pub idle: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// What is asked of the memory.
    #[with(cfg.port)]
    pub request: Stream<Request>,
    /// A write opens a line. Each write opens or joins one, once.
    pub opens: bool,
    /// A write joins a line that is open.
    pub joins: bool,
    /// A line begins to leave.
    pub leaves: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The words of all lines.
    pub data: Ram1R1W<Word>,
}

impl Buffer for Combiner {
    fn port(cfg: &Config) -> outside::Config {
        cfg.port
    }
    fn inputs(request: Stream<Request>, memory: outside::In, flush: bool) -> In {
        In { request, memory_ready: memory.ready, flush }
    }
    fn client(seen: &Moore, memory: outside::In) -> outside::In {
        outside::In { ready: seen.ready, ..memory }
    }
    fn idle(seen: &Moore) -> bool {
        seen.idle
    }
    fn asks(out: &Out) -> Stream<Request> {
        out.request
    }
}

#[rtl(
    moore = (),
    check(Combiner, tests::config(1, 1)),
    check(Combiner, tests::config(1, 4)),
    check(Combiner, tests::config(2, 8)),
    check(Combiner, tests::config(4, 4)),
    check(Combiner, tests::config(16, 2)),
    check(Combiner, tests::config(4, 16))
)]
impl Block for Combiner {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        cfg.check();
        State::reset(cfg)
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { data: Ram1R1W::new(cfg.lines * cfg.line, cfg.port, 1, ReadDuringWrite::Old) }
    }

    fn moore(cfg: &Config, q: &State, _: &Mem) -> Moore {
        let room = Requests::moore(&cfg.port, &q.requests, &()).ready;
        let rests = room && !q.flush && !q.leaving.valid;
        Moore { ready: room && !q.flush, idle: rests && !full(cfg, q.written).valid }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let kept = Requests::moore(&cfg.port, &q.requests, &()).held;
        let push = Stream { valid: i.request.valid && !q.flush, payload: i.request.payload };
        let request = offered(kept, push);
        let asked = request.payload;
        let reads = request.valid && !asked.write;
        let writes = request.valid && asked.write;
        let word = bit(cfg.cache().word_of(asked.address));
        let tag = cfg.cache().tag_of(asked.address);
        let hit = tags::hit(&cfg.cache(), q.open, tag);
        let free = free(cfg, q.open);
        let any = open(cfg, q.open);

        // Which line is to leave next, and whether it may begin to.
        let awaited = reads && hit.valid && (q.written[hit.payload as usize] & word) != 0;
        let passes = reads && !awaited && !q.leaving.valid;
        let oldest = tags::oldest(&cfg.cache(), q.open);
        let full = full(cfg, q.written);
        let mut next = Stream { valid: q.flush && any.valid, payload: any.payload };
        if awaited {
            next = hit;
        } else if full.valid {
            next = full;
        } else if writes && !hit.valid && !free.valid {
            next = Stream { valid: true, payload: oldest };
        }
        let way = next.payload;
        let ends = q.leaving.valid && q.leaving.left == 0 && i.memory_ready;
        // A read that passes goes before it: what is offered to the memory stays until it is taken.
        let read = passes && i.memory_ready;
        let may = if reads && !awaited { read } else { !q.leaving.valid || ends };
        let leaves = next.valid && may;

        // The word that is offered stays in the read register of the data until it is taken.
        let mut leaving = q.leaving;
        if leaves {
            let words = q.written[way as usize];
            let Line { tag, .. } = q.open.lines[way as usize];
            leaving = Leaving { valid: true, tag, way, word: lowest(words), left: rest(words) };
            m.data.read(cfg.cache().place(0, leaving.way, leaving.word));
        } else if q.leaving.valid && i.memory_ready {
            leaving.valid = !ends;
            leaving.word = lowest(q.leaving.left);
            leaving.left = rest(q.leaving.left);
            if !ends {
                m.data.read(cfg.cache().place(0, leaving.way, leaving.word));
            }
        }
        d.leaving = leaving;

        // The line that begins to leave takes no more words; its place does.
        let joins = hit.valid && !(leaves && hit.payload == way);
        let place = if joins {
            hit.payload
        } else if free.valid {
            free.payload
        } else {
            way
        };
        let room = joins || free.valid || leaves;
        let overwrites = leaving.way == place && (leaving.left & word) != 0;
        let gathers = writes && room && !overwrites;
        let mut lines = q.open;
        for k in 0..cfg.lines {
            let mut words = q.written[k as usize];
            if leaves && way == k {
                lines.lines[k as usize].valid = false;
                words = 0;
            }
            if gathers && place == k {
                words |= word;
            }
            d.written[k as usize] = words;
        }
        d.open = lines;
        if gathers {
            let number = cfg.cache().word_of(asked.address);
            m.data.write(cfg.cache().place(0, place, number), asked.word);
            let opened = tags::fetched(&cfg.cache(), lines, place, tag);
            d.open = tags::used(&cfg.cache(), opened, place, true);
        }

        let done = !request.valid && !any.valid && (!q.leaving.valid || ends);
        d.flush = i.flush || (q.flush && !done);
        let to_requests = skid::In { push, taken: gathers || read };
        Requests::next(&cfg.port, &q.requests, &mut d.requests, &mut (), to_requests);

        let mut ask = Stream { valid: passes, payload: asked };
        if q.leaving.valid {
            let address = cfg.cache().address(q.leaving.tag, 0, q.leaving.word);
            ask = Stream::offer(Request { write: true, address, word: m.data.q().data });
        }
        Out { request: ask, opens: gathers && !joins, joins: gathers && joins, leaves }
    }
}

/// A line of which all words were written, if there is one.
#[inline(always)]
#[rtl]
fn full(cfg: &Config, written: [u64; MAX_LINES]) -> Stream<u32> {
    let mut full = Stream::idle();
    for k in 0..cfg.lines {
        if written[k as usize] == (1 << cfg.line) - 1 {
            full = Stream::offer(k);
        }
    }
    full
}

/// A line that is open, if there is one.
#[inline(always)]
#[rtl]
fn open(cfg: &Config, lines: Set) -> Stream<u32> {
    let mut open = Stream::idle();
    for k in 0..cfg.lines {
        if lines.lines[k as usize].valid {
            open = Stream::offer(k);
        }
    }
    open
}

/// Place for another line, if there is some.
#[inline(always)]
#[rtl]
fn free(cfg: &Config, lines: Set) -> Stream<u32> {
    let mut free = Stream::idle();
    for k in 0..cfg.lines {
        if !lines.lines[k as usize].valid {
            free = Stream::offer(k);
        }
    }
    free
}

#[cfg(test)]
mod tests;
