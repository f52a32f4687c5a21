//! The weigher: compares each fragment that arrives with all that its pixel has, brings their weights up to date, and
//! puts it to its place.
//!
//! ```text
//!                           +-------+
//!  fragment, entry, place ->|       |---> section and NSA read
//!  ready <------------------| Weigh |---> begins, ends
//!  under_way, nsa, word --->|       |---> section write, or place
//!                           +-------+
//! ```
//! Of each two, the weight of the farther one is multiplied by what the nearer one lets through; of equal
//! depths the later one is nearer.
//!
//! It works in two steps, with queues between them. The first asks for the stored fragments of the pixel, one a cycle, and takes
//! the fragment with the last of them. The second compares it with them as they come, one a cycle, writes those back whose
//! weight changes, each in its cycle, and with the last comparison the fragment to its place, a cycle later if something is
//! written back in that one. One that has nothing to be compared with goes to its place at once if the queues are empty.
//!
//! The memory of sections takes an access a cycle on chip and one outside, writes first, and reads wait there for them: so
//! fragments come as fast as the slower side has accesses, or as they are compared.
//!
//! So fragments of several pixels are under way, `reads_in_flight` at most, and as many reads of stored ones, while memory outside
//! takes its time: see [`under_way`] for what keeps those of one pixel in turn. All go to their places in order.

use super::config::Config;
use super::sections::ReadsReady;
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use super::under_way::{self, Mark};
use crate::weights::{WEIGHT_BITS, behind, own_weight};
use pellucid_machine::pixel::{PixelFragment, RGBA_BITS, Z_BITS};
use pellucid_sim::{Block, Fifo, Label, Memory, Port, Read, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Weigh;

/// How far the second step is with the oldest fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// It is compared with none yet.
    First,
    /// It is compared with some.
    Next,
    /// It is compared with all.
    Place,
}

/// A read that is under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Pending {
    /// The stored fragment's place.
    #[with(*cfg)]
    pub place: Place,
    /// It is the pixel's last.
    pub last: bool,
}

/// A fragment that is under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Weighed {
    /// Its depth.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(RGBA_BITS)]
    pub rgba: u32,
    /// Its pixel has others.
    pub compares: bool,
    /// How it is known as under way.
    #[with(*cfg)]
    pub mark: Mark,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Some of the fragments that the one at hand is compared with are asked for.
    pub asks: bool,
    /// The place that was asked for last.
    #[with(*cfg)]
    pub place: Place,
    /// Reads under way.
    #[with(cfg.shape.reads_in_flight)]
    pub pending: fifo::State,
    /// Fragments under way.
    #[with(cfg.shape.reads_in_flight)]
    pub fragments: fifo::State,
    /// Where they go.
    #[with(cfg.shape.reads_in_flight)]
    pub places: fifo::State,
    /// How far the oldest one is.
    pub fsm: Fsm,
    /// Its weight so far.
    #[width(WEIGHT_BITS)]
    pub weight: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A fragment to be weighed. It and what is said of it stay until it is taken; its place may come later.
    #[with(cfg.screen)]
    pub fragment: Stream<PixelFragment>,
    /// Its pixel's entry.
    #[with(*cfg)]
    pub entry: SsaEntry,
    /// Where it goes, once that is known.
    #[with(*cfg)]
    pub place: Stream<Place>,
    /// Whether one of its pixel is under way, and how this one is known.
    #[with(*cfg)]
    pub under_way: under_way::Moore,
    /// The NSA entry that was asked for.
    #[with(*cfg)]
    pub nsa: Read<NsaEntry>,
    /// The oldest stored fragment that was asked for and is not there yet, if it comes in its turn: one outside only while such
    /// may be asked for.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// Fragments may be written outside.
    pub outside_ready: bool,
    /// Where fragments may be read.
    pub reads: ReadsReady,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Reads under way.
    pub pending: <Pendings as Block>::Mem,
    /// Fragments under way.
    pub fragments: <Fragments as Block>::Mem,
    /// Where they go.
    pub places: <Places as Block>::Mem,
}

type Pendings = Fifo<Pending>;
type Fragments = Fifo<Weighed>;
type Places = Fifo<Place>;

#[inline(always)]
fn queue(cfg: &Config) -> fifo::Config<Config> {
    // Where no weights are kept it does not exist.
    fifo::Config { depth: if cfg.weighs() { cfg.shape.reads_in_flight } else { 0 }, item: *cfg }
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A stored fragment's turn has come; whether it lies outside.
    pub oldest: Stream<bool>,
    /// No fragment is under way.
    pub idle: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// The fragment is taken, if its place is known.
    pub ready: bool,
    /// It is under way from now on.
    #[with(*cfg)]
    pub begins: Stream<Mark>,
    /// One is no more.
    #[with(*cfg)]
    pub ends: Stream<Mark>,
    /// Reads a stored fragment.
    #[with(*cfg)]
    pub read: Stream<Place>,
    /// Writes one back.
    #[with(*cfg)]
    pub write: Stream<Place>,
    /// Writes a fragment to its place. Never with another write.
    #[with(*cfg)]
    pub place: Stream<Place>,
    /// What is written.
    #[with(*cfg)]
    pub word: Word,
    /// Reads an NSA entry.
    #[with(cfg.id_bits(), *cfg)]
    pub nsa: Port<NsaEntry>,
}

#[rtl(check(Weigh, crate::test_util::small_owned(true)))]
impl Block for Weigh {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(_: &Config) -> State {
        let empty = fifo::State { head: 0, tail: 0, count: 0 };
        State {
            asks: false,
            place: Place::default(),
            pending: empty,
            fragments: empty,
            places: empty,
            fsm: Fsm::First,
            weight: 0,
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem {
            pending: Pendings::memories(&queue(cfg)),
            fragments: Fragments::memories(&queue(cfg)),
            places: Places::memories(&queue(cfg)),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let pending = Pendings::moore(&queue(cfg), &q.pending, &m.pending).front;
        let fragment = Fragments::moore(&queue(cfg), &q.fragments, &m.fragments).front;
        let compares = fragment.payload.compares && q.fsm != Fsm::Place;
        let outside = cfg.is_outside(pending.payload.place.section);
        Moore {
            oldest: Stream { valid: pending.valid && fragment.valid && compares, payload: outside },
            idle: !fragment.valid,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let mut o = Out::default();
        let pending = Pendings::moore(&queue(cfg), &q.pending, &m.pending);
        let fragments = Fragments::moore(&queue(cfg), &q.fragments, &m.fragments);
        let place = Places::moore(&queue(cfg), &q.places, &m.places).front;
        let Stream { valid: under_way, payload: oldest } = fragments.front;

        // The oldest read is answered: its fragment and the one that waits for it are compared.
        let mut weight = if q.fsm == Fsm::First { own_weight(oldest.rgba) } else { q.weight };
        let mut done = under_way && (q.fsm == Fsm::Place || !oldest.compares);
        if i.word.valid {
            let stored = i.word.data;
            let nearer = oldest.z <= stored.z;
            let changes = if nearer { stored.weight } else { weight };
            let changed = behind(changes, if nearer { oldest.rgba } else { stored.rgba });
            d.fsm = if pending.front.payload.last { Fsm::Place } else { Fsm::Next };
            if nearer {
                o.write = Stream::offer(pending.front.payload.place);
                o.word = Word { weight: changed, ..stored };
            } else {
                weight = changed;
                done = pending.front.payload.last;
            }
            d.weight = weight;
        }

        // Once it is compared with all it goes to its place.
        if done && place.valid && may(cfg, i.outside_ready, place.payload) {
            o.place = place;
            o.word = Word { z: oldest.z, rgba: oldest.rgba, weight, label: oldest.label };
            o.ends = Stream::offer(oldest.mark);
            d.fsm = Fsm::First;
        }

        // The fragment at hand: which of its pixel's is asked for next, behind that which was last?
        let compares = !cfg.is_null(i.entry);
        let in_tail = q.place.section == i.entry.tail;
        let fill = if in_tail { i.entry.fill } else { cfg.shape.capacity };
        let mut asked =
            Place { section: cfg.first_section(i.fragment.payload.pixel, i.entry), slot: 0 };
        if q.asks && q.place.slot + 1 < fill {
            asked = Place { section: q.place.section, slot: q.place.slot + 1 };
        } else if q.asks {
            asked = Place { section: i.nsa.data.next, slot: 0 };
        }
        let is_tail = asked.section == i.entry.tail;
        let last = is_tail && asked.slot + 1 == i.entry.fill;

        // It is under way from the first of them on, or from when it goes there without.
        let PixelFragment { pixel, z, rgba, label } = i.fragment.payload;
        let turn = i.fragment.valid && !i.under_way.busy && (q.asks || fragments.ready);
        let mark = Mark { number: cfg.mark_number(pixel), turn: i.under_way.turn };
        let fragment = Weighed { z, rgba, compares, mark, label };
        let mut joins = Stream::idle();
        let mut reads = Stream::idle();
        if turn && compares {
            let outside = cfg.is_outside(asked.section);
            let free = pending.ready && if outside { i.reads.outside } else { i.reads.on_chip };
            o.ready = free && last;
            if free && (!last || i.place.valid) {
                o.read = Stream::offer(asked);
                reads = Stream::offer(Pending { place: asked, last });
                joins = Stream { valid: !q.asks, payload: fragment };
                d.asks = !last;
                d.place = asked;
                // What follows its section is looked up with a section's first fragment.
                if asked.slot == 0 && !is_tail {
                    o.nsa.read(asked.section);
                }
            }
        } else if turn {
            o.ready = true;
        }
        let taken = o.ready && i.place.valid;
        let at_once = !compares && !under_way && may(cfg, i.outside_ready, i.place.payload);
        if taken && at_once {
            o.place = i.place;
            o.word = Word { z, rgba, weight: own_weight(rgba), label };
        } else if taken {
            o.begins = Stream::offer(mark);
            if !compares {
                joins = Stream::offer(fragment);
            }
        }

        let to_pending = fifo::In { push: reads, pop: i.word.valid };
        Pendings::next(&queue(cfg), &q.pending, &mut d.pending, &mut m.pending, to_pending);
        let to_fragments = fifo::In { push: joins, pop: o.ends.valid };
        Fragments::next(
            &queue(cfg),
            &q.fragments,
            &mut d.fragments,
            &mut m.fragments,
            to_fragments,
        );
        let push = Stream { valid: o.begins.valid, payload: i.place.payload };
        let to_places = fifo::In { push, pop: o.ends.valid };
        Places::next(&queue(cfg), &q.places, &mut d.places, &mut m.places, to_places);
        o
    }
}

/// Whether a place may be accessed while sections outside may be asked for, or not.
#[inline(always)]
#[rtl]
fn may(cfg: &Config, outside_ready: bool, place: Place) -> bool {
    outside_ready || !cfg.is_outside(place.section)
}

#[cfg(test)]
mod tests;
