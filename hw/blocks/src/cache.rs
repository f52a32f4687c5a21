//! A cache between one client that speaks the port to outside memory and that memory.
//!
//! ```text
//!                +-------+
//!  request ----->|       |---> request (Stream)
//!  client <------| Cache |<--- memory (ready, response)
//!  flush ------->|       |---> idle
//!                +-------+
//! ```
//! It keeps the contract of a [`buffer`](crate::buffer). It is set-associative; of a set, the line that was used least
//! recently makes room (true LRU). After a reset nothing is in it: it first takes [`Config::sets`] cycles to say so.
//! Memories keep their contents through a reset, but what was not written back is lost with it.
//!
//! *Hits*: a read is answered two cycles after its request, and a word a cycle is read or written.
//!
//! *Misses*: one at a time, and what comes after it waits. With `L` cycles from a request to its answer in a memory that
//! takes a request a cycle, a read that misses is answered `3 + line + L` cycles after its request, and `line` cycles
//! later where the line that makes room is dirty. A request that comes in the cycle in which a miss is seen is kept in a
//! [`Skid`].
//!
//! *Writes*: with `write_back` they stay in the cache until their line makes room or is flushed; one that misses fetches its
//! line first. Else each goes to memory, too, in the cycle after its request at the earliest; one that misses goes there
//! alone.
//!
//! A line is fetched whole, so that words may be read that the client has never written. Lines are asked for word by word,
//! from their first on.
//!
//! *Flush*: asked for in any cycle; from the next cycle on the cache takes nothing, until all that it took is done and every
//! dirty line is in memory. Lines stay in it. `idle` is high while nothing is under way or asked for; after a flush in such a
//! cycle it is high again `2 + sets` cycles later, and `1 + line` more for each dirty line, in a memory as above. A cache that
//! writes through has no dirty lines, and is done 2 cycles later.
//!
//! Where a queue is all that is needed to wait for the memory, use [`Skid`].

pub(crate) mod config;
pub(crate) mod tags;

pub use config::{Config, MAX_LINE};
pub use tags::{Line, MAX_WAYS, Set};

use crate::buffer::Buffer;
use crate::skid::{self, Skid};
use pellucid_machine::outside::{self, Request, Word};
use pellucid_sim::{
    Block, Memory, Ram1R1W, Ram1RW, ReadDuringWrite, Signals, Stream, bits_for, rtl,
};

/// See the module's description.
pub struct Cache;

/// What the cache is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Phase {
    /// Forgets what is in it, a set a cycle.
    #[default]
    Clear,
    /// Looks requests up.
    Run,
    /// Writes a dirty line to memory.
    WriteBack,
    /// Fetches a line.
    Fetch,
    /// Looks for dirty lines, a set a cycle.
    Walk,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub phase: Phase,
    /// A request that came in the cycle in which a miss was seen.
    #[with(cfg.port)]
    #[block(Requests)]
    pub requests: skid::State<Request>,
    /// The request whose set is shown by the tags.
    #[with(cfg.port)]
    pub asked: Stream<Request>,
    /// It has missed, and its line was fetched.
    pub again: bool,
    /// The word of a read is shown by the data.
    pub answers: bool,
    /// A flush was asked for and is not done.
    pub flush: bool,
    /// The set that is cleared or looked through.
    #[width(cfg.set_bits())]
    pub set: u32,
    /// The word of a line that memory is asked for, or to write.
    #[width(bits_for(u64::from(cfg.line)))]
    pub word: u32,
    /// The word of a line that comes next.
    #[width(cfg.line_bits())]
    pub comes: u32,
}

type Requests = Skid<Request>;

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// What the client asks for.
    #[with(cfg.port)]
    pub request: Stream<Request>,
    /// What the memory drives. It answers what it was asked for and nothing else.
    #[with(cfg.port)]
    pub memory: outside::In,
    /// All that was written is to be in memory.
    pub flush: bool,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What the client sees of it, as of a memory.
    #[with(cfg.port)]
    pub client: outside::In,
    /// Nothing is under way.
    pub idle: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// What is asked of the memory.
    #[with(cfg.port)]
    pub request: Stream<Request>,
    /// A request is found in the cache. Each request is a hit or a miss, once.
    pub hit: bool,
    /// A request is not.
    pub miss: bool,
    /// The memory takes a word of a dirty line.
    pub write_back: bool,
    /// A word of a line has come.
    pub fill: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// What is in each set.
    pub tags: Ram1R1W<Set>,
    /// The words of all lines.
    pub data: Ram1RW<Word>,
}

impl Buffer for Cache {
    fn port(cfg: &Config) -> outside::Config {
        cfg.port
    }
    fn inputs(request: Stream<Request>, memory: outside::In, flush: bool) -> In {
        In { request, memory, flush }
    }
    fn client(seen: &Moore, _: outside::In) -> outside::In {
        seen.client
    }
    fn idle(seen: &Moore) -> bool {
        seen.idle
    }
    fn asks(out: &Out) -> Stream<Request> {
        out.request
    }
}

#[rtl(
    check(Cache, tests::config(1, 1, 1, true)),
    check(Cache, tests::config(16, 1, 4, true)),
    check(Cache, tests::config(4, 2, 4, true)),
    check(Cache, tests::config(1, 4, 4, true)),
    check(Cache, tests::config(8, 8, 1, true)),
    check(Cache, tests::config(4, 1, 4, false)),
    check(Cache, tests::config(2, 4, 2, false)),
    check(Cache, tests::config(2, 2, 1, false))
)]
impl Block for Cache {
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
        Mem {
            tags: Ram1R1W::new(cfg.sets, *cfg, 1, ReadDuringWrite::New),
            data: Ram1RW::new(cfg.sets * cfg.ways * cfg.line, cfg.port, 1),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let room = Requests::moore(&cfg.port, &q.requests, &()).ready;
        let response = Stream { valid: q.answers, payload: m.data.q().data };
        // Nothing is kept while nothing is looked up.
        let rests = !q.asked.valid && !q.answers && !q.flush;
        Moore {
            client: outside::In { ready: opens(room, q.flush, q.phase), response },
            idle: rests && matches!(q.phase, Phase::Run),
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // While the cache takes nothing from the client, the tags show the set of the request that was taken last, or the one
        // that a flush has come to.
        let asked = q.asked.payload;
        let set = m.tags.q().data;
        let index = if q.asked.valid { cfg.set_of(asked.address) } else { q.set };
        let hit = tags::hit(cfg, set, cfg.tag_of(asked.address));
        let dirty = tags::dirty(cfg, set);
        let way = if q.asked.valid { tags::oldest(cfg, set) } else { dirty.payload };
        let line = set.lines[way as usize];

        let looks = matches!(q.phase, Phase::Run) && q.asked.valid;
        let through = !cfg.write_back && asked.write;
        let done = looks && (if through { i.memory.ready } else { hit.valid });
        let misses = looks && !through && !hit.valid;

        let room = Requests::moore(&cfg.port, &q.requests, &()).ready;
        let push = Stream {
            valid: i.request.valid && opens(room, q.flush, q.phase),
            payload: i.request.payload,
        };
        let takes = matches!(q.phase, Phase::Run) && (!q.asked.valid || done);
        let to_requests = skid::In { push, taken: takes };
        let request = Requests::next(&cfg.port, &q.requests, &mut d.requests, &mut (), to_requests);
        if takes {
            d.asked = request;
            d.again = false;
        }
        if takes && request.valid {
            m.tags.read(cfg.set_of(request.payload.address));
        }
        d.answers = done && !asked.write;
        d.flush = q.flush || i.flush;

        let mut ask = Stream::idle();
        match q.phase {
            Phase::Clear => {
                m.tags.write(q.set, tags::empty(cfg));
                d.set = (q.set + 1) & (cfg.sets - 1);
                if q.set == cfg.sets - 1 {
                    d.phase = Phase::Run;
                }
            }
            Phase::Run => {
                if looks && through {
                    ask = Stream::offer(asked);
                }
                if done && hit.valid {
                    let place = cfg.place(index, hit.payload, cfg.word_of(asked.address));
                    m.tags.write(index, tags::used(cfg, set, hit.payload, asked.write));
                    if asked.write {
                        m.data.write(place, asked.word);
                    } else {
                        m.data.read(place);
                    }
                }
                if misses {
                    d.phase = Phase::Fetch;
                    if cfg.write_back && line.dirty {
                        m.data.read(cfg.place(index, way, 0));
                        d.phase = Phase::WriteBack;
                    }
                }
                if q.flush && !q.asked.valid {
                    if cfg.write_back {
                        m.tags.read(q.set);
                        d.phase = Phase::Walk;
                    } else {
                        d.flush = false;
                    }
                }
            }
            Phase::WriteBack => {
                if cfg.write_back {
                    // The word stays in the read register of the data until it is taken.
                    let address = cfg.address(line.tag, index, q.word);
                    ask = Stream::offer(Request { write: true, address, word: m.data.q().data });
                    if i.memory.ready && q.word < cfg.line - 1 {
                        d.word = q.word + 1;
                        m.data.read(cfg.place(index, way, d.word));
                    } else if i.memory.ready {
                        d.word = 0;
                        if q.asked.valid {
                            d.phase = Phase::Fetch;
                        } else {
                            m.tags.write(index, tags::clean(cfg, set, way));
                            m.tags.read(index);
                            d.phase = Phase::Walk;
                        }
                    }
                }
            }
            Phase::Fetch => {
                let first = asked.address - cfg.word_of(asked.address);
                if q.word < cfg.line {
                    let address = first | q.word;
                    ask = Stream::offer(Request { write: false, address, word: Word::default() });
                    if i.memory.ready {
                        d.word = q.word + 1;
                    }
                }
                if i.memory.response.valid {
                    m.data.write(cfg.place(index, way, q.comes), i.memory.response.payload);
                    d.comes = (q.comes + 1) & (cfg.line - 1);
                    if q.comes == cfg.line - 1 {
                        // The request is looked up again, and is a hit.
                        let tag = cfg.tag_of(asked.address);
                        m.tags.write(index, tags::fetched(cfg, set, way, tag));
                        m.tags.read(index);
                        d.word = 0;
                        d.again = true;
                        d.phase = Phase::Run;
                    }
                }
            }
            Phase::Walk => {
                if cfg.write_back {
                    if dirty.valid {
                        m.data.read(cfg.place(index, way, 0));
                        d.phase = Phase::WriteBack;
                    } else {
                        d.set = (q.set + 1) & (cfg.sets - 1);
                        if q.set == cfg.sets - 1 {
                            d.flush = false;
                            d.phase = Phase::Run;
                        } else {
                            m.tags.read(d.set);
                        }
                    }
                }
            }
        }

        let writes_back = matches!(q.phase, Phase::WriteBack) && i.memory.ready;
        Out {
            request: ask,
            hit: done && hit.valid && !q.again,
            miss: misses || (done && !hit.valid),
            write_back: cfg.write_back && writes_back,
            fill: matches!(q.phase, Phase::Fetch) && i.memory.response.valid,
        }
    }
}

/// Whether requests are taken, where a request finds `room`.
#[inline(always)]
#[rtl]
fn opens(room: bool, flush: bool, phase: Phase) -> bool {
    room && !flush && !matches!(phase, Phase::Clear)
}

#[cfg(test)]
pub(crate) mod test_util;
#[cfg(test)]
mod tests;
