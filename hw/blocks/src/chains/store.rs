//! The store unit: puts each transparent fragment at the end of its pixel's chain where new ones go.
//!
//! ```text
//!                  +-------+
//!  fragment ------>|       |---> SSA read, write    <--- entry
//!  ready <---------| Store |---> NSA access         <--- entry
//!  grant --------->|       |---> section write
//!  take <----------|       |---> occupancy ask, set
//!                  +-------+
//! ```
//! Where tails are kept one fragment a cycle, same pixel or not: the SSA entry names the last section
//! and how full it is. Else (seed 000, Figure 4) the entry names the first section, and
//! the unit reads the NSA table section by section: a fragment whose chain has `c` sections takes
//! `c + 1` cycles, `c + 2` if it needs a new one behind them.
//!
//! Where new sections go before the first one the entry names that and how full it is, and again it is one fragment a cycle: a
//! new section's NSA entry gets the number of the one that was first, NULL if there was none.
//!
//! Where each pixel owns a section, its first fragments go there. Where weights are kept in memory, a
//! fragment is compared with all that its pixel has before it goes to its place, while the next ones come to hand: see [`weigh`].
//!
//! If no section is free anywhere the fragment is dropped, and `dropped` says so.

use super::config::Config;
use super::sections::ReadsReady;
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use super::under_way::{self, Mark};
use super::weigh::{self, Weigh};
use pellucid_machine::pixel::{Marked, PixelFragment};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Port, Read, ReadPort, Signals, Stream, WritePort, fifo, rtl};

/// See the module's description.
pub struct Store;

/// What the unit is at with the fragment in its stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// The pixel's SSA entry is at hand.
    Start,
    /// The NSA entry of section `at` is at hand.
    Walk,
    /// Section `at` is new: its NSA entry is yet to be written.
    Link,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Fragments that arrived.
    #[with(cfg.pixels_ahead())]
    pub queue: fifo::State,
    /// The fragment at hand.
    #[with(cfg.screen)]
    pub stage: Stream<Marked<PixelFragment>>,
    /// What is done with it.
    pub fsm: Fsm,
    /// The section that the walk has come to.
    #[width(cfg.id_bits())]
    pub at: u32,
    /// See [`weigh`].
    #[with(*cfg)]
    #[exists(cfg.weighs())]
    pub weigh: weigh::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Transparent fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The SSA entry that was asked for. Where the table is cached, once it is there.
    #[with(*cfg)]
    pub ssa: Read<SsaEntry>,
    /// The NSA entry that was asked for.
    #[with(*cfg)]
    pub nsa: Read<NsaEntry>,
    /// The oldest stored fragment that was asked for and is not there yet, if it comes in its turn: one outside only while such
    /// may be asked for.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// Whether a fragment is being weighed of the pixel that was asked for.
    #[with(*cfg)]
    #[exists(cfg.weighs())]
    pub under_way: under_way::Moore,
    /// A free section.
    #[with(cfg.id_bits())]
    pub grant: Stream<u32>,
    /// No section is free.
    pub exhausted: bool,
    /// Fragments may be written outside.
    pub outside_ready: bool,
    /// Where fragments may be read.
    #[exists(cfg.weighs())]
    pub reads: ReadsReady,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// The turn of a stored fragment has come, to be compared; whether it lies outside.
    #[exists(cfg.weighs())]
    pub oldest: Stream<bool>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads an SSA entry.
    #[with(cfg.screen.pixel_bits())]
    pub ssa_read: ReadPort,
    /// Writes an SSA entry.
    #[with(cfg.screen.pixel_bits(), *cfg)]
    pub ssa_write: WritePort<SsaEntry>,
    /// The SSA entry at hand is done with. It is written in that cycle or not at all.
    pub ssa_taken: bool,
    /// Reads or writes an NSA entry.
    #[with(cfg.id_bits(), *cfg)]
    pub nsa: Port<NsaEntry>,
    /// A pixel whose occupancy bit may be set.
    #[with(cfg.screen.pixel_bits())]
    pub occupancy_ask: Stream<u32>,
    /// The pixel that was asked for last is set.
    #[with(cfg.screen.pixel_bits())]
    pub occupancy_set: Stream<u32>,
    /// Where a fragment is written.
    #[with(*cfg)]
    pub place: Stream<Place>,
    /// Reads a stored fragment, to compare it with one that came.
    #[with(*cfg)]
    pub stored_read: Stream<Place>,
    /// Writes it back with a new weight. Never while a fragment is written to its place.
    #[with(*cfg)]
    pub stored_write: Stream<Place>,
    /// What is written.
    #[with(*cfg)]
    pub word: Word,
    /// A pixel of which a fragment may be being weighed.
    #[with(cfg.screen.pixel_bits())]
    pub weighed_ask: Stream<u32>,
    /// A fragment is being weighed from now on.
    #[with(*cfg)]
    pub weighed_begins: Stream<Mark>,
    /// One is no more.
    #[with(*cfg)]
    pub weighed_ends: Stream<Mark>,
    /// The granted section is taken.
    pub take: bool,
    /// The fragment is its pixel's first.
    pub first: bool,
    /// The fragment finds no section and is dropped.
    pub dropped: bool,
    /// The fragment waits for a section.
    pub waits: bool,
    /// All fragments of the frame are stored.
    pub frame_stored: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Fragments that arrived.
    pub queue: <Queue as Block>::Mem,
    /// See [`weigh`].
    pub weigh: weigh::Mem,
}

type Queue = Fifo<Marked<PixelFragment>>;

#[inline(always)]
fn queue(cfg: &Config) -> fifo::Config<pellucid_machine::pixel::Screen> {
    fifo::Config { depth: cfg.pixels_ahead(), item: cfg.screen }
}

#[rtl(
    check(Store, crate::test_util::small(true)),
    check(Store, crate::test_util::small(false)),
    check(Store, crate::test_util::small_newest_first()),
    check(Store, crate::test_util::small_owned(false)),
    check(Store, crate::test_util::small_owned(true)),
    check(Store, crate::test_util::small_caching(true, true))
)]
impl Block for Store {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        let queue = Queue::reset(&queue(cfg));
        let weigh = Weigh::reset(cfg);
        State { queue, stage: Stream::idle(), fsm: Fsm::Start, at: 0, weigh }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { queue: Queue::memories(&queue(cfg)), weigh: Weigh::memories(cfg) }
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let mut oldest = Stream::idle();
        if cfg.weighs() {
            oldest = Weigh::moore(cfg, &q.weigh, &m.weigh).oldest;
        }
        Moore { ready: Queue::moore(&queue(cfg), &q.queue, &m.queue).ready, oldest }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let fragment = q.stage.payload.item;
        let PixelFragment { pixel, z, rgba, label } = fragment;
        let mut o = Out { frame_stored: q.stage.valid && q.stage.payload.end, ..Out::default() };
        if cfg.weighs() {
            o.frame_stored &= Weigh::moore(cfg, &q.weigh, &m.weigh).idle;
        }
        let pixel_at_hand = q.stage.valid && !q.stage.payload.end;
        let at_hand = pixel_at_hand && cfg.is_there(i.ssa);

        // Where does the fragment go? To a slot that the pixel has, or into a new section: its first,
        // or one beside its newest.
        let mut slot: Stream<Place> = Stream::idle();
        let mut owns = false;
        let mut needs_first = false;
        let mut beside: Stream<u32> = Stream::idle();
        let mut linked = false;
        let empty = cfg.is_null(i.ssa.data);
        if at_hand {
            match q.fsm {
                Fsm::Start => {
                    let SsaEntry { head, tail, fill } = i.ssa.data;
                    if empty {
                        owns = cfg.shape.owned;
                        needs_first = !cfg.shape.owned;
                    } else if !cfg.keeps_fill() {
                        o.nsa.read(head);
                        d.at = head;
                        d.fsm = Fsm::Walk;
                    } else {
                        let newest = if cfg.keeps_tail() { tail } else { head };
                        if fill < cfg.shape.capacity {
                            slot = Stream::offer(Place { section: newest, slot: fill });
                        } else {
                            beside = Stream::offer(newest);
                        }
                    }
                }
                Fsm::Walk => {
                    let NsaEntry { next, fill } = i.nsa.data;
                    if next != cfg.null {
                        o.nsa.read(next);
                        d.at = next;
                    } else if fill < cfg.shape.capacity {
                        slot = Stream::offer(Place { section: q.at, slot: fill });
                    } else {
                        beside = Stream::offer(q.at);
                    }
                }
                Fsm::Link => {
                    o.nsa.write(q.at, NsaEntry { next: cfg.null, fill: 1 });
                    linked = true;
                }
            }
        }

        // Is a section to be had where one is needed?
        let needs = needs_first || beside.valid;
        o.dropped = needs && !i.grant.valid && i.exhausted;
        let mut place = slot;
        if owns {
            place = Stream::offer(Place { section: pixel, slot: 0 });
        } else if needs {
            let section = i.grant.payload;
            place = Stream { valid: i.grant.valid, payload: Place { section, slot: 0 } };
        }

        // The fragment goes there, if that is not outside or the port is open; or, with its place, to be weighed.
        o.word = Word { z, rgba, weight: 0, label };
        let mut ready = i.outside_ready || !cfg.is_outside(place.payload.section);
        let mut asks = true;
        if cfg.weighs() {
            let to_weigh = weigh::In {
                fragment: Stream { valid: at_hand && !o.dropped, payload: fragment },
                entry: i.ssa.data,
                place,
                under_way: i.under_way,
                nsa: i.nsa,
                word: i.word,
                outside_ready: i.outside_ready,
                reads: i.reads,
            };
            let weigh = Weigh::next(cfg, &q.weigh, &mut d.weigh, &mut m.weigh, to_weigh);
            ready = weigh.ready;
            asks = weigh.ready;
            o.place = weigh.place;
            o.word = weigh.word;
            o.stored_read = weigh.read;
            o.stored_write = weigh.write;
            o.weighed_begins = weigh.begins;
            o.weighed_ends = weigh.ends;
            o.nsa = weigh.nsa;
        }
        let goes = place.valid && ready;
        if !cfg.weighs() {
            o.place = Stream { valid: goes, payload: place.payload };
        }
        o.waits = needs && !i.grant.valid && !i.exhausted && asks;
        o.take = needs && goes;
        o.first = (owns || needs_first) && goes;
        let mut linking = false;

        // The tables learn of it.
        if slot.valid && goes {
            let fill = slot.payload.slot + 1;
            if cfg.keeps_fill() {
                o.ssa_write.write(pixel, SsaEntry { fill, ..i.ssa.data });
            } else {
                o.nsa.write(slot.payload.section, NsaEntry { next: cfg.null, fill });
            }
        } else if goes {
            let new = place.payload.section;
            let head = if cfg.shape.owned { 0 } else { new };
            if cfg.newest_first() {
                // What the first one is linked to is NULL.
                o.ssa_write.write(pixel, SsaEntry { head, tail: 0, fill: 1 });
                o.nsa.write(new, NsaEntry { next: i.ssa.data.head, fill: 0 });
            } else if o.first {
                if cfg.keeps_tail() {
                    o.ssa_write.write(pixel, SsaEntry { head, tail: new, fill: 1 });
                } else {
                    o.ssa_write.write(pixel, SsaEntry { head, tail: 0, fill: 0 });
                    o.nsa.write(new, NsaEntry { next: cfg.null, fill: 1 });
                }
            } else if cfg.keeps_tail() {
                o.ssa_write.write(pixel, SsaEntry { tail: new, fill: 1, ..i.ssa.data });
                o.nsa.write(beside.payload, NsaEntry { next: new, fill: 0 });
            } else {
                o.nsa.write(beside.payload, NsaEntry { next: new, fill: cfg.shape.capacity });
                d.at = new;
                d.fsm = Fsm::Link;
                linking = true;
            }
            if o.first {
                o.occupancy_set = Stream::offer(pixel);
            }
        }

        // The next fragment comes to hand once this one is done.
        let over = !q.stage.valid || o.frame_stored;
        let done = over || linked || o.dropped || (goes && !linking);
        o.ssa_taken = pixel_at_hand && done;
        if done {
            d.fsm = Fsm::Start;
            let front = Queue::moore(&queue(cfg), &q.queue, &m.queue).front;
            d.stage = front;
            if front.valid && !front.payload.end {
                o.ssa_read.read(front.payload.item.pixel);
                o.occupancy_ask = Stream::offer(front.payload.item.pixel);
                o.weighed_ask = o.occupancy_ask;
            }
        } else if i.under_way.busy {
            o.weighed_ask = Stream::offer(pixel);
        }
        let to_queue = fifo::In { push: i.fragment, pop: done };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        o
    }
}

#[cfg(test)]
mod tests;
