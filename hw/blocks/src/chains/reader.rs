//! The chain reader: reads a pixel's fragments, section by section, and hands them on.
//!
//! ```text
//!               +-------------+
//!  chain ------>|             |---> arrived (Stream), then the end of the frame
//!  ready <------| ChainReader |<--- arrived_ready
//!  nsa, word -->|             |---> NSA read, section read
//!               |             |---> release: push, commit, abort
//!               +-------------+
//! ```
//! One fragment a cycle from sections on chip, across sections and pixels; the NSA entry of a section
//! is read together with its first fragment. At most `reads_in_flight` fragments are under way or
//! waiting for the sorter, on chip and outside; [`super::answers`] keeps their order.
//!
//! Fragments behind the pixel's opaque depth are marked invisible. How often a pixel is read is told by
//! [`Passes`]. With passes of K fragments, one with more than K is read until the receiver has had every
//! visible one: `ceil(visible / K)` passes, one at least; then its sections are released in a walk of their
//! own. Any other pixel's sections are released as they are read. A section that its pixel owns stays, and where they are counted
//! out none is released here.

use super::config::{Config, Passes};
use super::lookup::Chain;
use super::release;
use super::tables::{NsaEntry, Place, Word};
use pellucid_machine::pixel::{Arrived, Marked, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Port, Read, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct ChainReader;

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// No pixel is at hand.
    Idle,
    /// Asking for the pixel's fragments.
    Read,
    /// A pass of a deep pixel is asked for: waiting until all of it is there.
    Settle,
    /// Releasing a deep pixel's sections.
    Release,
}

/// What is remembered of a read that is under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Pending {
    /// The pixel.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// The pixel's opaque depth.
    #[width(Z_BITS)]
    pub depth: u32,
    /// Last of its pass.
    pub last: bool,
    /// Its section lies outside.
    #[exists(cfg.mixes())]
    pub outside: bool,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// Chains that arrived.
    #[with(CHAINS)]
    pub chains: fifo::State,
    /// The pixel at hand.
    #[with(*cfg)]
    pub chain: Chain,
    /// The place that is about to be asked for, or in `Release` the section to be released.
    #[with(*cfg)]
    pub place: Place,
    /// Its position in the chain.
    #[width(cfg.layer_bits())]
    #[exists(!cfg.one_pass())]
    pub position: u32,
    /// The pixel is read again.
    pub again: bool,
    /// Reads under way.
    #[with(cfg.shape.reads_in_flight)]
    pub pending: fifo::State,
    /// Fragments that wait for the receiver.
    #[with(cfg.shape.reads_in_flight)]
    pub arrived: fifo::State,
    /// Visible fragments of the pixel in its first pass so far.
    #[width(cfg.layer_bits())]
    #[exists(!cfg.one_pass())]
    pub visible: u32,
    /// Visible fragments that are left for further passes.
    #[width(cfg.layer_bits())]
    pub left: u32,
    /// The fragments of the pass are loaded: it is read to compare them with all.
    #[exists(cfg.loads())]
    pub loaded: bool,
}

const CHAINS: u32 = 2;

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Chains to read, then the end of the frame.
    #[with(*cfg)]
    pub chain: Stream<Marked<Chain>>,
    /// The NSA entry that was asked for.
    #[with(*cfg)]
    pub nsa: Read<NsaEntry>,
    /// The oldest fragment that was asked for and is not there yet, if it comes.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// The receiver takes a fragment.
    pub arrived_ready: bool,
    /// The release queue has room.
    pub release_ready: bool,
    /// Sections outside may be asked for.
    pub outside_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A chain is taken.
    pub ready: bool,
    /// Fragments of one pixel after the other, then the end of the frame.
    #[with(cfg.screen.pixel_bits(), cfg.shape.weight_bits)]
    pub arrived: Stream<Marked<Arrived>>,
    /// A read is under way; whether the oldest one went outside.
    pub oldest: Stream<bool>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Reads an NSA entry.
    #[with(cfg.id_bits(), *cfg)]
    pub nsa: Port<NsaEntry>,
    /// Reads a fragment.
    #[with(*cfg)]
    pub read: Stream<Place>,
    /// The read is of a second pass or later.
    pub read_again: bool,
    /// A section that is done with.
    #[with(cfg.release)]
    #[exists(!cfg.counts_out())]
    pub release: release::In,
    /// The chain at hand is a new one.
    pub begins: bool,
    /// A fragment came back that the opaque depth hides (counted in the first pass).
    pub culled: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Chains that arrived.
    pub chains: <Chains as Block>::Mem,
    /// Reads under way.
    pub pending: <Pendings as Block>::Mem,
    /// Fragments that wait for the sorter.
    pub arrived: <Arrivals as Block>::Mem,
}

type Chains = Fifo<Marked<Chain>>;
type Pendings = Fifo<Pending>;
type Arrivals = Fifo<Marked<Arrived>>;

#[inline(always)]
fn chains(cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: CHAINS, item: *cfg }
}
#[inline(always)]
fn pendings(cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: cfg.shape.reads_in_flight, item: *cfg }
}
#[inline(always)]
fn arrivals(cfg: &Config) -> fifo::Config<(u32, u32)> {
    let item = (cfg.screen.pixel_bits(), cfg.shape.weight_bits);
    fifo::Config { depth: cfg.shape.reads_in_flight, item }
}

impl Config {
    /// Whether every pixel is read just once.
    pub fn one_pass(&self) -> bool {
        self.shape.passes == Passes::One
    }
    /// Visible fragments that one pass takes, 0 if there is but one pass.
    pub fn pass_depth(&self) -> u32 {
        match self.shape.passes {
            Passes::One => 0,
            Passes::Each(depth) | Passes::Twice(depth) => depth,
        }
    }
    /// Whether a pass from the second on reads twice.
    pub fn loads(&self) -> bool {
        matches!(self.shape.passes, Passes::Twice(_))
    }
}

#[rtl]
impl Config {
    /// Where the fragment is that is read first of a chain.
    #[inline(always)]
    fn first_place(&self, chain: Chain) -> Place {
        Place {
            section: self.first_section(chain.pixel, chain.entry),
            slot: self.first_slot(chain.entry),
        }
    }
}

#[rtl(
    check(ChainReader, crate::test_util::small(true)),
    check(ChainReader, crate::test_util::small(false)),
    check(ChainReader, crate::test_util::small_newest_first()),
    check(ChainReader, crate::test_util::small_owned(false)),
    check(ChainReader, crate::test_util::small_owned(true))
)]
impl Block for ChainReader {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            fsm: Fsm::Idle,
            chains: Chains::reset(&chains(cfg)),
            chain: Chain::default(),
            place: Place::default(),
            position: 0,
            again: false,
            pending: Pendings::reset(&pendings(cfg)),
            arrived: Arrivals::reset(&arrivals(cfg)),
            visible: 0,
            left: 0,
            loaded: false,
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem {
            chains: Chains::memories(&chains(cfg)),
            pending: Pendings::memories(&pendings(cfg)),
            arrived: Arrivals::memories(&arrivals(cfg)),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let Stream { valid, payload } =
            Pendings::moore(&pendings(cfg), &q.pending, &m.pending).front;
        Moore {
            ready: Chains::moore(&chains(cfg), &q.chains, &m.chains).ready,
            arrived: Arrivals::moore(&arrivals(cfg), &q.arrived, &m.arrived).front,
            oldest: Stream { valid, payload: payload.outside },
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let mut o = Out {
            nsa: Port::default(),
            read: Stream::idle(),
            read_again: false,
            release: release::In { push: Stream::idle(), commit: false, abort: false, pop: true },
            begins: false,
            culled: false,
        };
        let depth = cfg.pass_depth();
        let once = cfg.one_pass();

        // An answer comes back: the oldest read under way learns its fragment.
        let pending = Pendings::moore(&pendings(cfg), &q.pending, &m.pending);
        let waiting = Arrivals::moore(&arrivals(cfg), &q.arrived, &m.arrived).count;
        let oldest = pending.front.payload;
        let mut arrived: Stream<Marked<Arrived>> = Stream::idle();
        if i.word.valid {
            let visible = i.word.data.z < oldest.depth;
            o.culled = !visible && !q.again;
            let seen = if q.again { 0 } else { q.visible + u32::from(visible) };
            let before = if q.again { q.left } else { seen };
            let only_loads = cfg.loads() && q.again && !q.loaded;
            let taken = if only_loads { 0 } else { depth };
            let left = if once { 0 } else { before.saturating_sub(taken) };
            d.visible = seen;
            if oldest.last {
                d.left = left;
                d.loaded = only_loads;
                d.visible = 0;
            }
            arrived = Stream::offer(Marked::item(Arrived {
                pixel: oldest.pixel,
                z: i.word.data.z,
                rgba: i.word.data.rgba,
                weight: i.word.data.weight,
                visible,
                last: oldest.last,
                last_pass: left == 0,
                label: i.word.data.label,
            }));
        }

        // What follows the section at hand? Where tails are kept the SSA entry knows the last one.
        let entry = q.chain.entry;
        let is_tail = cfg.keeps_tail() && q.place.section == entry.tail;
        let (next, fill) = if is_tail {
            (cfg.null, entry.fill)
        } else if cfg.keeps_fill() {
            (i.nsa.data.next, cfg.shape.capacity)
        } else {
            (i.nsa.data.next, i.nsa.data.fill)
        };

        let mut fetch = Stream::idle();
        let mut begin = false;
        let nothing_under_way = pending.count == 0;
        match q.fsm {
            Fsm::Idle => begin = true,
            Fsm::Read => {
                // The place at hand is asked for if its answer will find room.
                let room = pending.count + waiting < cfg.shape.reads_in_flight;
                let outside = cfg.is_outside(q.place.section);
                if room && i.release_ready && (i.outside_ready || !outside) {
                    let more_here =
                        if cfg.newest_first() { q.place.slot > 0 } else { q.place.slot + 1 < fill };
                    let last = !more_here && next == cfg.null;
                    let shallow = once || q.position < depth;
                    o.read = Stream::offer(q.place);
                    o.read_again = q.again;
                    fetch = Stream::offer(Pending {
                        pixel: q.chain.pixel,
                        depth: q.chain.depth,
                        last,
                        outside,
                    });
                    d.position = q.position + 1;
                    let done = !more_here && !q.again && shallow && !cfg.counts_out();
                    if done && q.place.section >= cfg.owned {
                        o.release.push = Stream::offer(q.place.section);
                        o.release.commit = once;
                    }
                    if more_here {
                        d.place.slot = if cfg.newest_first() {
                            q.place.slot.saturating_sub(1)
                        } else {
                            q.place.slot + 1
                        };
                    } else if !last {
                        d.place = Place { section: next, slot: cfg.next_first_slot() };
                    } else if q.again || !shallow {
                        o.release.abort = !q.again;
                        d.fsm = Fsm::Settle;
                    } else {
                        o.release.commit = true;
                        begin = true;
                    }
                }
            }
            Fsm::Settle => {
                if nothing_under_way {
                    d.again = q.left > 0;
                    d.fsm = if q.left > 0 { Fsm::Read } else { Fsm::Release };
                    begin = cfg.counts_out() && q.left == 0;
                    d.place = cfg.first_place(q.chain);
                    d.position = 0;
                }
            }
            Fsm::Release => {
                if i.release_ready {
                    if q.place.section >= cfg.owned {
                        o.release.push = Stream::offer(q.place.section);
                        o.release.commit = true;
                    }
                    d.place = Place { section: next, slot: 0 };
                    if next == cfg.null {
                        begin = true;
                    }
                }
            }
        }

        // The next pixel, or the end of the frame once everything before it is on its way.
        let front = Chains::moore(&chains(cfg), &q.chains, &m.chains).front;
        let Marked { end, item: chain } = front.payload;
        let mut pop = false;
        if begin {
            d.fsm = Fsm::Idle;
            if front.valid && !end {
                pop = true;
                o.begins = true;
                d.fsm = Fsm::Read;
                d.chain = chain;
                d.place = cfg.first_place(chain);
                d.position = 0;
                d.again = false;
            } else if front.valid && q.fsm == Fsm::Idle && nothing_under_way {
                pop = waiting < cfg.shape.reads_in_flight;
                arrived = Stream { valid: pop, payload: Marked::end() };
            }
        }

        // A section that comes to hand is looked up in the NSA table, unless it is known as the last.
        let enters = d.fsm == Fsm::Read || d.fsm == Fsm::Release;
        let moved = d.place.section != q.place.section || begin || q.fsm == Fsm::Settle;
        if enters && moved && !(cfg.keeps_tail() && d.place.section == d.chain.entry.tail) {
            o.nsa.read(d.place.section);
        }

        let to_chains = fifo::In { push: i.chain, pop };
        Chains::next(&chains(cfg), &q.chains, &mut d.chains, &mut m.chains, to_chains);
        let to_pending = fifo::In { push: fetch, pop: i.word.valid };
        Pendings::next(&pendings(cfg), &q.pending, &mut d.pending, &mut m.pending, to_pending);
        let to_arrived = fifo::In { push: arrived, pop: i.arrived_ready };
        Arrivals::next(&arrivals(cfg), &q.arrived, &mut d.arrived, &mut m.arrived, to_arrived);
        o
    }
}

#[cfg(test)]
mod tests;
