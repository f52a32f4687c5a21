//! A prefetching cache between a machine and a table in outside memory, a word for each entry.
//!
//! ```text
//!                +------------+
//!  ask --------->|            |---> entry (Stream)
//!  ready <-------|            |<--- taken, write
//!                | TableCache |
//!  clear ------->|            |---> request (Stream)
//!  clear_ready <-|            |<--- memory (ready, response)
//!  flush ------->|            |---> idle
//!                +------------+
//! ```
//! A table that has a word for each pixel, such as the [`Ssa`](crate::chains::ssa) table, is too large for the chip; what
//! is used of it soon is known before it is used. `ask` names entries that will be used. They are shown as `entry` in the order of
//! the asks, each until it is `taken`; with it a user may give what the entry holds from then on (`write`), and every
//! later ask shows that, one that is next, too. After H. Igehy, M. Eldridge, K. Proudfoot, *Prefetching in a Texture Cache
//! Architecture*, 1998, with a write-back. A word is that of the port: its user packs entries as
//! [`tables`](crate::chains::tables) does.
//!
//! An ask is looked up at once; if its line is not there, memory is asked for it, from the word that was asked for on to the one
//! before it. It then waits in a queue for its turn, be it a hit or a miss, while later ones are looked up, those for the same line
//! among them. In a miss's turn the line that was asked for least recently (true LRU) makes room, and the words that came take
//! its place; so all that was asked before finds the line as it was.
//!
//! The first words of all lines are one memory, the second words another, and so on. So a dirty line is read in one cycle, in which
//! no entry is read. Its words leave one a cycle, in the order in which others come; each stays in its memory's read register until
//! it has left, and an entry of that memory waits for it.
//!
//! *Latency*: a hit is shown 4 cycles after its ask. With `L` cycles from a request to its answer in a memory that takes a request
//! a cycle, an entry that misses is shown `4 + L` cycles after its ask, if nothing else is under way.
//!
//! *Throughput*: hits come an entry a cycle, whichever they are. With [`Config::in_flight`] of at least `L + 2 * line`,
//! [`Config::misses`] of at least `1 + (L + 2) / line`, rounded up, twice as many lines, and a user that takes at once, these
//! cycles are taken, whatever `L`:
//!
//! | | not written | written |
//! | --- | --- | --- |
//! | an entry of those in a row | 1 | 2; `1 + 1 / line` while the line that makes room is clean |
//! | an entry whose line no other one uses | `line` | `2 * line`; `line`, but at least 2, while the line that makes room is clean |
//!
//! The last column is what the port takes for a line that comes and one that leaves; where none leaves, the first word of a line
//! does not come while an entry is written, nor any other one with an entry of its memory. On the port memory is asked for words
//! first, unless a miss or an entry waits for those that leave.
//!
//! *What waits*: a miss, until the queue and memory have room for it; one that would take the way of another one in its set
//! whose turn has not come, until then, so that a set has no more misses under way than ways; and an ask for a line that is to
//! make room itself, until it has left, so that memory is asked for it after it was written. All later asks wait behind it.
//!
//! *Clear*: what memory holds at power-up is not known. Until the first ask after a reset, `clear` writes entries to memory, one a
//! cycle; later `clear_ready` is low. Nothing is in the cache after a reset: it takes [`Config::sets`] cycles until asks are
//! taken. What was not written back is lost, so that the table is to be cleared again. A cache that is idle and is offered
//! something to clear does the same as after a reset, from the next cycle on: so a table is cleared between two uses of it.
//!
//! *Flush*: where [`Config::flushes`] says so, what was written is in memory after a `flush`: asked for in any cycle, it ends in
//! the first cycle behind it in which the cache is `idle`; until then no ask is taken. The lines stay. It begins once nothing is
//! under way and takes 2 cycles for each line, one more for each in use, and `line` more for each dirty one. Elsewhere a frame
//! needs none, as all that use the table go through the cache.
//!
//! `idle` is high while nothing is under way. It takes the memory's answers at once. Up to `in_flight + 4` asks are on their way
//! from `ask` to `entry`: what their user is to do with the entries waits in a queue of its own. Where requests and answers are to
//! be those of the port itself, and one miss at a time is enough, use [`Cache`](crate::cache::Cache).

mod config;
mod ports;
mod sets;

pub use config::{Config, Old, Order, Place};
pub use ports::{Entry, In, Moore, Out};
pub use sets::{Before, Misses, Set};

use crate::cache::tags;
use crate::skid::{self, Skid};
use pellucid_machine::outside::{Request, Word};
use pellucid_sim::{Block, Fifo, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct TableCache;

/// What the cache is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Phase {
    /// Forgets what is in it, a set a cycle.
    #[default]
    Forget,
    /// Nothing is in it.
    Empty,
    /// Entries are asked for.
    Run,
    /// Writes dirty lines to memory, one after the other.
    Flush,
}

/// What is known of a line that may have to be flushed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Known {
    /// Nothing.
    #[default]
    Nothing,
    /// Its set is shown by the tags.
    Tags,
    /// Whether it is dirty is shown, too.
    Dirty,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub phase: Phase,
    /// The set that it forgets, or of which it flushes a line.
    #[width(cfg.cache().set_bits())]
    pub set: u32,
    /// That line.
    #[width(cfg.cache().way_bits())]
    #[exists(cfg.flushes)]
    pub way: u32,
    /// What is known of it.
    #[exists(cfg.flushes)]
    pub known: Known,
    /// A flush is asked for.
    #[exists(cfg.flushes)]
    pub flush: bool,
    /// An ask that came while the one before could not go on.
    #[with(cfg.port.address_bits())]
    #[block(Asks)]
    pub asks: skid::State<u32>,
    /// The ask whose set is shown by the tags.
    #[with(cfg.port.address_bits())]
    pub asked: Stream<u32>,
    /// See [`Misses`].
    #[with(*cfg)]
    pub misses: Misses,
    /// Lines that memory is to be asked for, each by the entry that missed: its word goes first.
    #[with(cfg.misses)]
    #[block(Fetches, cfg.fetches())]
    pub fetches: fifo::State,
    /// Words of the first one that were asked for.
    #[width(cfg.cache().line_bits())]
    pub fetched: u32,
    /// Asks that were looked up.
    #[with(cfg.in_flight)]
    #[block(Queue, cfg.queue())]
    pub queue: fifo::State,
    /// The one whose turn it is.
    #[with(*cfg)]
    pub head: Stream<Order>,
    /// The miss whose turn came last, while its line is not all there.
    #[with(*cfg)]
    pub fill: Stream<Place>,
    /// Words of that line that are there.
    #[width(cfg.cache().line_bits())]
    pub filled: u32,
    /// The line that leaves, by the word of it that goes first: the data shows those that have not left.
    #[with(cfg.port.address_bits())]
    pub leaves: Stream<u32>,
    /// Words of it that have left.
    #[width(cfg.cache().line_bits())]
    pub left: u32,
    /// The entry that is shown by the data.
    #[with(*cfg)]
    pub shown: Stream<Place>,
    /// A request that memory has not taken yet.
    #[with(cfg.port)]
    #[block(Requests)]
    pub requests: skid::State<Request>,
    /// Words that came from memory.
    #[with(cfg.answers().depth)]
    #[block(Answers, cfg.answers())]
    pub answers: fifo::State,
}

/// No ask is under way, where none or some are queued.
#[inline(always)]
#[rtl]
fn rests(q: State, queued: bool) -> bool {
    let inside = q.head.valid || q.fill.valid || q.shown.valid;
    !q.asked.valid && !queued && !inside && !q.leaves.valid
}

/// No ask is taken: what is in the cache is forgotten or flushed.
#[inline(always)]
#[rtl]
fn shut(cfg: &Config, q: State) -> bool {
    matches!(q.phase, Phase::Forget) || (cfg.flushes && q.flush)
}

type Asks = Skid<u32>;
type Queue = Fifo<Order>;
type Fetches = Fifo<u32>;
type Requests = Skid<Request>;
type Answers = Fifo<Word>;

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// What is in each set.
    pub tags: Ram1R1W<Set>,
    /// Whether each line holds what memory does not.
    pub dirty: Ram1R1W<bool>,
    /// The first words of all lines, the second ones, and so on.
    pub data: Vec<Ram1R1W<Word>>,
    /// Lines that memory is to be asked for.
    pub fetches: <Fetches as Block>::Mem,
    /// Asks that were looked up.
    pub queue: <Queue as Block>::Mem,
    /// Words that came from memory.
    pub answers: <Answers as Block>::Mem,
}

#[rtl(
    check(TableCache, tests::config(1, 1, 1, 1, 1)),
    check(TableCache, tests::config(4, 1, 4, 6, 2)),
    check(TableCache, tests::config(2, 2, 4, 5, 3)),
    check(TableCache, tests::config(1, 4, 2, 3, 1)),
    check(TableCache, tests::config(8, 2, 1, 9, 4)),
    check(TableCache, Config { flushes: true, ..tests::config(4, 2, 4, 5, 3) }),
    check(TableCache, Config { flushes: true, ..tests::config(1, 1, 1, 1, 1) })
)]
impl Block for TableCache {
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
        let lines = cfg.sets * cfg.ways;
        Mem {
            tags: Ram1R1W::new(cfg.sets, *cfg, 1, ReadDuringWrite::New),
            dirty: Ram1R1W::new(lines, (), 1, ReadDuringWrite::New),
            data: (0..cfg.line)
                .map(|_| Ram1R1W::new(lines, cfg.port, 1, ReadDuringWrite::New))
                .collect(),
            fetches: Fetches::memories(&cfg.fetches()),
            queue: Queue::memories(&cfg.queue()),
            answers: Answers::memories(&cfg.answers()),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let asks = Asks::moore(&cfg.port.address_bits(), &q.asks, &()).ready;
        let requests = Requests::moore(&cfg.port, &q.requests, &()).ready;
        let queued = Queue::moore(&cfg.queue(), &q.queue, &m.queue).count > 0;
        let address = q.shown.payload.address;
        let mut word = m.data[0].q().data;
        for k in 1..cfg.line {
            if cfg.cache().word_of(address) == k {
                word = m.data[k as usize].q().data;
            }
        }
        Moore {
            ready: asks && !shut(cfg, *q),
            clear_ready: requests && matches!(q.phase, Phase::Forget | Phase::Empty),
            entry: Stream { valid: q.shown.valid, payload: Entry { address, word } },
            idle: rests(*q, queued) && asks && requests && !shut(cfg, *q),
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let cache = cfg.cache();
        let queue = Queue::moore(&cfg.queue(), &q.queue, &m.queue);
        let answer = Answers::moore(&cfg.answers(), &q.answers, &m.answers).front;
        let fetch = Fetches::moore(&cfg.fetches(), &q.fetches, &m.fetches).front;
        let room = Requests::moore(&cfg.port, &q.requests, &()).ready;

        // The entry that is shown is taken, and may be written.
        let shown = q.shown.payload;
        let free = !q.shown.valid || i.taken;
        let writes = q.shown.valid && i.taken && i.write.valid;

        // A miss whose turn has come: what was asked before is done with the line that makes room.
        let Order { place, miss, old } = q.head.payload;
        let line = cfg.line_of(place);
        let at = cache.word_of(place.address);
        let turn = q.head.valid && miss && !q.fill.valid && free;
        let dirty = old.valid && (m.dirty.q().data || (writes && cfg.line_of(shown) == line));

        // The line that makes room leaves word by word, each of which stays in its memory's read register until then.
        let held = q.leaves.valid && !cache.after(at, q.leaves.payload, q.left, false);
        let awaited = (turn && dirty) || (q.head.valid && !miss && held);
        let writes_back = q.leaves.valid && room && (!fetch.valid || awaited);
        let left = writes_back && q.left == cfg.line - 1;
        if writes_back {
            d.left = (q.left + 1) & (cfg.line - 1);
        }
        if left {
            d.leaves.valid = false;
        }
        let starts = turn && (!dirty || !q.leaves.valid || left);
        let evicts = starts && dirty;
        if starts {
            d.head.payload.miss = false;
            d.fill = Stream::offer(place);
            d.misses.waits = cfg.next(q.misses.waits);
        }
        if evicts {
            let set = cache.set_of(place.address);
            d.leaves = Stream::offer(cache.address(old.tag, set, at));
        }

        // Its words take the place of those that were read.
        let filling = if starts { place } else { q.fill.payload };
        let fill_at = cache.word_of(cache.on(filling.address, q.filled));
        let shown_at = cache.word_of(shown.address);
        // A write port has one user; the first word says that the line is clean, too.
        let meets = writes && (q.filled == 0 || shown_at == fill_at);
        let fills = (starts || q.fill.valid) && !evicts && answer.valid && !meets;
        let full = fills && q.filled == cfg.line - 1;
        if fills {
            d.filled = (q.filled + 1) & (cfg.line - 1);
        }
        if full {
            d.fill.valid = false;
            d.misses.fills = cfg.next(q.misses.fills);
        }
        for k in 0..cfg.line {
            if writes && shown_at == k {
                m.data[k as usize].write(cfg.line_of(shown), i.write.payload);
            } else if fills && fill_at == k {
                m.data[k as usize].write(cfg.line_of(filling), answer.payload);
            }
        }
        if writes {
            m.dirty.write(cfg.line_of(shown), true);
        } else if fills && q.filled == 0 {
            m.dirty.write(cfg.line_of(filling), false);
        }

        // The head's entry is read as soon as it is there, and the word that its memory shows has left.
        let comes = starts || (q.fill.valid && cfg.line_of(q.fill.payload) == line);
        let came = cache.after(at, filling.address, q.filled, fills);
        let there = (starts || !miss) && (!comes || came);
        let shows = q.leaves.valid && !cache.after(at, q.leaves.payload, q.left, writes_back);
        let reads = q.head.valid && there && free && !shows;
        for k in 0..cfg.line {
            if evicts || (reads && at == k) {
                m.data[k as usize].read(line);
            }
        }
        if free {
            d.shown = Stream { valid: reads, payload: place };
        }
        let takes_head = !q.head.valid || reads;
        if takes_head {
            d.head = queue.front;
        }
        let head = if takes_head { queue.front } else { q.head };
        if head.valid && head.payload.miss && head.payload.old.valid && (takes_head || writes) {
            m.dirty.read(cfg.line_of(head.payload.place));
        }

        // Memory is asked for lines ahead.
        let fetches = fetch.valid && room && !writes_back;
        let fetched = fetches && q.fetched == cfg.line - 1;
        if fetches {
            d.fetched = (q.fetched + 1) & (cfg.line - 1);
        }

        // Asks are looked up.
        let set = m.tags.q().data;
        let asked = q.asked.payload;
        let tag = cache.tag_of(asked);
        let found = tags::hit(&cache, set.now, tag);
        let way = if found.valid { found.payload } else { tags::oldest(&cache, set.now) };
        let was = set.now.lines[way as usize];
        let may_miss = cfg.after(q.misses.next, q.misses.fills) < cfg.misses
            && !sets::waits(cfg, set, q.misses, tag, way)
            && !(q.leaves.valid && cache.line_in(q.leaves.payload) == cache.line_in(asked));
        let goes = q.asked.valid && queue.ready && (found.valid || may_miss);
        let misses = goes && !found.valid;
        if misses {
            d.misses.next = cfg.next(q.misses.next);
        }
        let push = Stream { valid: misses, payload: asked };
        let to_fetches = fifo::In { push, pop: fetched };
        Fetches::next(&cfg.fetches(), &q.fetches, &mut d.fetches, &mut m.fetches, to_fetches);
        let order = Order {
            place: Place { address: asked, way },
            miss: !found.valid,
            old: Old { valid: was.valid, tag: was.tag },
        };
        let to_queue = fifo::In { push: Stream { valid: goes, payload: order }, pop: takes_head };
        Queue::next(&cfg.queue(), &q.queue, &mut d.queue, &mut m.queue, to_queue);

        let asks = Asks::moore(&cfg.port.address_bits(), &q.asks, &()).ready;
        let forgets = matches!(q.phase, Phase::Forget);
        let comes_in = i.ask.valid && asks && !shut(cfg, *q);
        let takes = !forgets && (!q.asked.valid || goes);
        let push = Stream { valid: comes_in, payload: i.ask.payload };
        let to_asks = skid::In { push, taken: takes };
        let ask = Asks::next(&cfg.port.address_bits(), &q.asks, &mut d.asks, &mut (), to_asks);
        if takes {
            d.asked = ask;
        }
        if takes && ask.valid {
            m.tags.read(cache.set_of(ask.payload));
        }
        let idle = rests(*q, queue.count > 0) && asks && room;
        if comes_in {
            d.phase = Phase::Run;
        } else if i.clear.valid && idle && matches!(q.phase, Phase::Run) {
            d.phase = Phase::Forget;
        }
        if forgets {
            m.tags.write(q.set, sets::empty(cfg));
            d.set = (q.set + 1) & (cfg.sets - 1);
            if q.set == cfg.sets - 1 {
                d.phase = Phase::Empty;
            }
        } else if goes {
            let mut next = set;
            if misses {
                next = sets::taken(cfg, set, way, tag, q.misses.next);
            }
            m.tags.write(cache.set_of(asked), sets::used(cfg, next, way));
        }

        // Line after line is flushed, in the same way as one that makes room.
        if cfg.flushes {
            let flushes = matches!(q.phase, Phase::Flush);
            d.flush = q.flush || i.flush;
            let begins = q.flush && rests(*q, queue.count > 0) && asks && room;
            let (at, tags) = (cache.line_at(q.set, q.way), set.now.lines[q.way as usize]);
            let there = matches!(q.known, Known::Tags) && tags.valid;
            let looks = matches!(q.known, Known::Dirty) && !q.leaves.valid;
            let clean = looks && !m.dirty.q().data;
            let done = (matches!(q.known, Known::Tags) && !tags.valid) || clean || left;
            if matches!(q.phase, Phase::Empty) && begins {
                d.flush = false;
            } else if matches!(q.phase, Phase::Run) && begins {
                d.phase = Phase::Flush;
            } else if flushes && matches!(q.known, Known::Nothing) {
                m.tags.read(q.set);
                d.known = Known::Tags;
            } else if flushes && there {
                m.dirty.read(at);
                d.known = Known::Dirty;
            } else if flushes && looks && !clean {
                for k in 0..cfg.line {
                    m.data[k as usize].read(at);
                }
                d.leaves = Stream::offer(cache.address(tags.tag, q.set, 0));
            }
            if flushes && left {
                m.dirty.write(at, false);
            }
            if flushes && done {
                d.known = Known::Nothing;
                d.way = (q.way + 1) & (cfg.ways - 1);
                if d.way == 0 {
                    d.set = (q.set + 1) & (cfg.sets - 1);
                    if d.set == 0 {
                        d.phase = Phase::Run;
                        d.flush = false;
                    }
                }
            }
        }

        // What goes to memory, and what comes from there.
        let mut push = Stream::idle();
        if writes_back {
            let address = cache.on(q.leaves.payload, q.left);
            let mut word = m.data[0].q().data;
            for k in 1..cfg.line {
                if cache.word_of(address) == k {
                    word = m.data[k as usize].q().data;
                }
            }
            let request = Request { write: true, address, word };
            push = Stream { valid: room, payload: request };
        } else if fetch.valid {
            let address = cache.on(fetch.payload, q.fetched);
            let request = Request { write: false, address, word: Word::default() };
            push = Stream { valid: room, payload: request };
        } else if matches!(q.phase, Phase::Forget | Phase::Empty) {
            let Entry { address, word } = i.clear.payload;
            let request = Request { write: true, address, word };
            push = Stream { valid: room && i.clear.valid, payload: request };
        }
        let to_requests = skid::In { push, taken: i.memory.ready };
        let request = Requests::next(&cfg.port, &q.requests, &mut d.requests, &mut (), to_requests);
        let to_answers = fifo::In { push: i.memory.response, pop: fills };
        Answers::next(&cfg.answers(), &q.answers, &mut d.answers, &mut m.answers, to_answers);

        Out { request, hit: goes && found.valid, miss: misses, write_back: writes_back }
    }
}

#[cfg(test)]
mod tests;
