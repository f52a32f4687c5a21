//! The array reader: reads a pixel's fragments, slot by slot, and hands them on.
//!
//! ```text
//!                +--------+
//!  extent ------>|        |---> arrived (Stream), then the end of the band
//!  ready <-------| Reader |<--- arrived_ready
//!  word, depth ->|        |---> read, depth_read
//!                +--------+
//! ```
//! One fragment a cycle, across pixels and passes. At most `reads_in_flight` fragments are under way or waiting for the
//! receiver, on chip and outside; [`answers`](crate::chains::answers) keeps their order.
//!
//! Where a count has made room for arrays all of them are visible, and it is known from the start how many there are: a pixel
//! with `n` is read in `ceil(n / K)` passes if the receiver takes K in a pass, and the next pass begins in the cycle after the
//! last read of the one before.
//!
//! Where arrays are of one length fragments are compared with the pixel's opaque depth as they come back, and those behind it
//! are marked invisible. A pixel with more than K waits after its first pass until all of it is there, and is read in
//! `ceil(visible / K)` passes, one at least.

use super::config::Config;
use super::walk::Extent;
use crate::chains::tables::{Place, Word};
use pellucid_machine::pixel::{Arrived, Marked, Z_BITS};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Reader;

/// What is remembered of a read that is under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Pending {
    /// The pixel.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// Last of its pass.
    pub last: bool,
    /// Its pass is the pixel's last. Of a first pass with more than the receiver takes that is not known yet, if some may be
    /// invisible.
    pub last_pass: bool,
    /// Its pass is the second or a later one.
    #[exists(cfg.is_fixed())]
    pub again: bool,
    /// The pixel's opaque depth.
    #[width(Z_BITS)]
    #[exists(cfg.is_fixed())]
    pub depth: u32,
    /// Its slot lies outside.
    #[exists(cfg.fragments.mixes())]
    pub outside: bool,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Pixels that arrived.
    #[with(cfg.extents_ahead())]
    pub extents: fifo::State,
    /// The pixel at hand.
    #[with(*cfg)]
    pub extent: Stream<Extent>,
    /// Its opaque depth.
    #[width(Z_BITS)]
    #[exists(cfg.depths_ahead())]
    pub depth: u32,
    /// How many of its fragments were asked for in this pass.
    #[width(cfg.layer_bits())]
    pub at: u32,
    /// How many are left for this pass and those after it.
    #[width(cfg.layer_bits())]
    pub left: u32,
    /// The first pass of a deep pixel is asked for: waiting until all of it is there.
    #[exists(cfg.settles())]
    pub settles: bool,
    /// Visible fragments in that pass so far.
    #[width(cfg.layer_bits())]
    #[exists(cfg.settles())]
    pub visible: u32,
    /// Reads under way.
    #[with(cfg.shape.reads_in_flight)]
    pub pending: fifo::State,
    /// Fragments that wait for the receiver.
    #[with(cfg.shape.reads_in_flight)]
    pub arrived: fifo::State,
}

impl Config {
    /// Pixels that wait: as many as depths may have been asked for.
    fn extents_ahead(&self) -> u32 {
        if self.depths_ahead() { self.shape.reads_in_flight + 2 } else { 2 }
    }
    /// Whether opaque depths lie outside: a pixel waits until its own is there.
    #[inline]
    pub fn depths_ahead(&self) -> bool {
        self.is_fixed() && self.shape.pixels_ahead
    }
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Pixels to read, then the end of the band.
    #[with(*cfg)]
    pub extent: Stream<Marked<Extent>>,
    /// The oldest fragment that was asked for and is not there yet, if it comes.
    #[with(cfg.fragments)]
    pub word: Read<Word>,
    /// The depth that was asked for. Where depths lie outside, once it is there and until it is taken.
    #[with(Z_BITS)]
    #[exists(cfg.is_fixed())]
    pub depth: Read<u32>,
    /// The receiver takes a fragment.
    pub arrived_ready: bool,
    /// Slots outside may be asked for.
    pub outside_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A pixel is taken.
    pub ready: bool,
    /// Fragments of one pixel after the other, then the end of the band.
    #[with(cfg.screen.pixel_bits(), 0)]
    pub arrived: Stream<Marked<Arrived>>,
    /// A read is under way; whether the oldest one went outside.
    pub oldest: Stream<bool>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a fragment.
    #[with(cfg.fragments)]
    pub read: Stream<Place>,
    /// The read is of a second pass or later.
    pub read_again: bool,
    /// Reads a pixel's opaque depth.
    #[with(cfg.screen.pixel_bits())]
    #[exists(cfg.is_fixed())]
    pub depth_read: ReadPort,
    /// The depth at hand is done with.
    #[exists(cfg.depths_ahead())]
    pub depth_taken: bool,
    /// A fragment came back that the opaque depth hides (told in the first pass).
    #[exists(cfg.is_fixed())]
    pub culled: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Pixels that arrived.
    pub extents: <Extents as Block>::Mem,
    /// Reads under way.
    pub pending: <Pendings as Block>::Mem,
    /// Fragments that wait for the receiver.
    pub arrived: <Arrivals as Block>::Mem,
}

type Extents = Fifo<Marked<Extent>>;
type Pendings = Fifo<Pending>;
type Arrivals = Fifo<Marked<Arrived>>;

#[inline(always)]
fn extents(cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: cfg.extents_ahead(), item: *cfg }
}
#[inline(always)]
fn pendings(cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: cfg.shape.reads_in_flight, item: *cfg }
}
#[inline(always)]
fn arrivals(cfg: &Config) -> fifo::Config<(u32, u32)> {
    fifo::Config { depth: cfg.shape.reads_in_flight, item: (cfg.screen.pixel_bits(), 0) }
}

#[rtl(
    check(Reader, crate::test_util::arrays(4, true)),
    check(Reader, crate::test_util::arrays(1, false)),
    check(Reader, crate::test_util::fixed().arrays),
    check(Reader, crate::test_util::fixed_ahead().arrays)
)]
impl Block for Reader {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            extents: Extents::reset(&extents(cfg)),
            extent: Stream::idle(),
            depth: 0,
            at: 0,
            left: 0,
            settles: false,
            visible: 0,
            pending: Pendings::reset(&pendings(cfg)),
            arrived: Arrivals::reset(&arrivals(cfg)),
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem {
            extents: Extents::memories(&extents(cfg)),
            pending: Pendings::memories(&pendings(cfg)),
            arrived: Arrivals::memories(&arrivals(cfg)),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let Stream { valid, payload } =
            Pendings::moore(&pendings(cfg), &q.pending, &m.pending).front;
        Moore {
            ready: Extents::moore(&extents(cfg), &q.extents, &m.extents).ready,
            arrived: Arrivals::moore(&arrivals(cfg), &q.arrived, &m.arrived).front,
            oldest: Stream { valid, payload: payload.outside },
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let mut o = Out::default();

        // An answer comes back: the oldest read under way learns its fragment.
        let pending = Pendings::moore(&pendings(cfg), &q.pending, &m.pending);
        let waiting = Arrivals::moore(&arrivals(cfg), &q.arrived, &m.arrived).count;
        let oldest = pending.front.payload;
        let Pending { pixel, last, .. } = oldest;
        let Word { z, rgba, label, .. } = i.word.data;
        let (mut visible, mut last_pass) = (true, oldest.last_pass);
        if cfg.is_fixed() {
            visible = z < oldest.depth;
            o.culled = i.word.valid && !visible && !oldest.again;
            if cfg.settles() && i.word.valid && !oldest.again && !oldest.last_pass {
                let seen = q.visible + u32::from(visible);
                d.visible = seen;
                last_pass = seen <= cfg.shape.depth;
            }
        }
        let item = Arrived { pixel, z, rgba, weight: 0, visible, last, last_pass, label };
        let mut arrived = Stream { valid: i.word.valid, payload: Marked::item(item) };

        // The slot at hand is asked for if its answer will find room.
        let mut fetch = Stream::idle();
        let settles = cfg.settles() && q.settles;
        let mut begin = !q.extent.valid;
        let extent = q.extent.payload;
        let section = extent.first + q.at;
        let outside = cfg.fragments.is_outside(section);
        let room = pending.count + waiting < cfg.shape.reads_in_flight;
        if q.extent.valid && room && (i.outside_ready || !outside) && !settles {
            let last = q.at + 1 == extent.count;
            let last_pass = q.left <= cfg.shape.depth;
            let again = q.left != extent.count;
            let depth = if cfg.depths_ahead() { q.depth } else { i.depth.data };
            o.read = Stream::offer(Place { section, slot: 0 });
            o.read_again = again;
            let pixel = extent.pixel;
            fetch = Stream::offer(Pending { pixel, last, last_pass, again, depth, outside });
            if !last {
                d.at = q.at + 1;
            } else if last_pass {
                begin = true;
            } else if cfg.settles() && !again {
                d.settles = true;
            } else {
                d.at = 0;
                d.left = q.left - cfg.shape.depth;
            }
        }

        // All of a deep pixel is there: it is read again if not all that is visible was taken.
        if settles && pending.count == 0 {
            d.settles = false;
            d.visible = 0;
            d.at = 0;
            begin = q.visible <= cfg.shape.depth;
            if !begin {
                d.left = q.visible - cfg.shape.depth;
            }
        }

        // The next pixel, or the end of the band once everything before it is on its way.
        let front = Extents::moore(&extents(cfg), &q.extents, &m.extents).front;
        let Marked { end, item: next } = front.payload;
        let mut pop = false;
        let there = !cfg.depths_ahead() || i.depth.valid;
        if begin {
            d.extent = Stream { valid: front.valid && !end && there, payload: next };
            d.at = 0;
            d.left = next.count;
            pop = front.valid && !end && there;
            if cfg.depths_ahead() {
                d.depth = i.depth.data;
                o.depth_taken = pop;
            } else if cfg.is_fixed() && pop {
                o.depth_read.read(next.pixel);
            }
            if front.valid && end && !q.extent.valid && pending.count == 0 {
                pop = waiting < cfg.shape.reads_in_flight;
                arrived = Stream { valid: pop, payload: Marked::end() };
            }
        }

        let to_extents = fifo::In { push: i.extent, pop };
        Extents::next(&extents(cfg), &q.extents, &mut d.extents, &mut m.extents, to_extents);
        let to_pending = fifo::In { push: fetch, pop: i.word.valid };
        Pendings::next(&pendings(cfg), &q.pending, &mut d.pending, &mut m.pending, to_pending);
        let to_arrived = fifo::In { push: arrived, pop: i.arrived_ready };
        Arrivals::next(&arrivals(cfg), &q.arrived, &mut d.arrived, &mut m.arrived, to_arrived);
        o
    }
}

#[cfg(test)]
mod tests;
