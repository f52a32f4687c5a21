//! The early depth test of fragments whose pixels lie in outside memory: several wait for their pixel, in order.
//!
//! ```text
//!                    +--------------+---> mark read, mark
//!  fragment -------->|              |---> passed (transparent, in front)
//!  ready <-----------| DepthAhead   |<--- passed_ready
//!  marked ---------->|              |---> ask (a pixel of the table)
//!  pixel ----------->|              |---> taken, write
//!                    +--------------+
//! ```
//! What becomes of a fragment is as in [`DepthTest`](crate::depth_test). A pixel without its [mark](super::marks) is at the far plane:
//! a transparent fragment that comes to one is in front, and the table is not asked. An opaque one sets the mark as it asks, and is
//! the first that its pixel is to hold; so one that comes behind it asks, too, and sees what it has left, as the table shows
//! entries in the order of the asks. One fragment a cycle, as long as pixels come; four cycles from input to output for one
//! whose pixel is not asked for, six for one whose pixel is in the cache.
//!
//! Where fragments are blended [as they come](super::Blends::Coming), a transparent one asks as an opaque one does, and leaves the blend of its own
//! colour and its pixel's there in the cycle in which it is passed on.
//!
//! Where they come [`again`](In::again), to be blended after all of them were tested, each asks for its pixel, and is passed on at once
//! and without a test. The [pixel](revisited) is shown until its receiver is done with it, and says what it holds then.

use super::config::Config;
use super::pixel::Pixel;
use pellucid_machine::pixel::{Marked, PixelFragment, Screen, blend, is_opaque};
use pellucid_sim::{Block, Fifo, Memory, Optional, Read, ReadPort, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct DepthAhead;

/// A fragment that waits for its pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Waiting {
    /// The fragment.
    #[with(*cfg)]
    pub fragment: PixelFragment,
    /// Its pixel holds something already.
    pub marked: bool,
}

const QUEUE_DEPTH: u32 = 2;

type Queue = Fifo<Marked<PixelFragment>>;
type Waits = Fifo<Marked<Waiting>>;
type Firsts = Fifo<bool>;

fn queue(cfg: &Config) -> fifo::Config<Screen> {
    fifo::Config { depth: QUEUE_DEPTH, item: cfg.screen }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Fragments that arrived.
    #[with(QUEUE_DEPTH)]
    #[block(Queue, queue(cfg))]
    pub queue: fifo::State,
    /// The fragment whose pixel's mark is shown.
    #[with(cfg.screen)]
    pub stage: Stream<Marked<PixelFragment>>,
    /// Fragments that wait for their pixel.
    #[with(cfg.waiting().depth)]
    #[block(Waits, cfg.waiting())]
    pub waits: fifo::State,
    /// Fragments come again.
    #[exists(cfg.revisits())]
    pub again: bool,
    /// Of those that came again and are not done with their pixel, whether it holds nothing yet.
    #[with(cfg.firsts().depth)]
    #[exists(cfg.revisits())]
    #[block(Firsts, cfg.firsts())]
    pub firsts: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// They come again, to be blended.
    #[exists(cfg.revisits())]
    pub again: bool,
    /// The pixel of one that came again is done with.
    #[exists(cfg.revisits())]
    pub taken: bool,
    /// What it holds from now on.
    #[with(cfg.screen)]
    #[exists(cfg.revisits())]
    pub write: Stream<Pixel>,
    /// The mark that was asked for.
    pub marked: Read<bool>,
    /// The table takes an ask.
    pub table_ready: bool,
    /// The pixel that was asked for first, once it is there.
    #[with(cfg.screen)]
    pub pixel: Read<Pixel>,
    /// The receiver of `passed` is ready.
    pub passed_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// The fragment that was there first: see [`passed`].
    #[with(cfg.screen)]
    pub oldest: Stream<Marked<Waiting>>,
    /// Fragments come again.
    #[exists(cfg.revisits())]
    pub again: bool,
    /// Whether the pixel of the first of these that is not done with it holds nothing yet.
    #[exists(cfg.revisits())]
    pub first: Stream<bool>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a mark.
    #[with(cfg.screen.pixel_bits())]
    pub mark_read: ReadPort,
    /// Sets one.
    #[with(cfg.screen.pixel_bits())]
    pub mark: Stream<u32>,
    /// Asks for a pixel.
    #[with(cfg.screen.pixel_bits())]
    pub ask: Stream<u32>,
    /// The pixel that is shown is done with.
    pub taken: bool,
    /// What it holds from now on.
    #[with(cfg.screen)]
    pub write: Stream<Pixel>,
    /// An opaque fragment is drawn in this cycle.
    pub drawn: bool,
    /// An opaque fragment is dropped in this cycle: it is hidden.
    pub hidden: bool,
    /// A transparent fragment is dropped in this cycle: it is hidden.
    pub culled: bool,
}

/// Whether a fragment may write its pixel.
#[inline(always)]
#[rtl]
fn writes(cfg: &Config, rgba: u32) -> bool {
    cfg.composes() || is_opaque(rgba)
}

/// Whether a fragment's pixel was asked for.
#[inline(always)]
#[rtl]
fn asked(cfg: &Config, waiting: Waiting) -> bool {
    waiting.marked || writes(cfg, waiting.fragment.rgba)
}

/// What a fragment's pixel holds before it.
#[inline(always)]
#[rtl]
fn below(cfg: &Config, waiting: Waiting, pixel: Read<Pixel>) -> Pixel {
    if waiting.marked { pixel.data } else { Pixel::clear(&cfg.screen) }
}

/// Whether what is to be known of the oldest fragment is there.
#[inline(always)]
#[rtl]
fn there(cfg: &Config, oldest: Stream<Marked<Waiting>>, pixel: Read<Pixel>) -> bool {
    oldest.valid && (oldest.payload.end || !asked(cfg, oldest.payload.item) || pixel.valid)
}

/// Whether it is in front of what its pixel holds, which is nothing where it is the first.
#[inline(always)]
#[rtl]
fn nearer(cfg: &Config, waiting: Waiting, pixel: Read<Pixel>) -> bool {
    waiting.fragment.z < below(cfg, waiting, pixel).depth
}

/// What is passed on, before inputs are known: transparent fragments in front, in order, then the end of the frame.
#[inline(always)]
#[rtl]
pub fn passed(cfg: &Config, seen: Moore, pixel: Read<Pixel>) -> Stream<Marked<PixelFragment>> {
    let oldest = seen.oldest;
    let Marked { end, item } = oldest.payload;
    let in_front = !is_opaque(item.fragment.rgba) && nearer(cfg, item, pixel);
    let mut valid = there(cfg, oldest, pixel) && (end || in_front);
    if cfg.revisits() && seen.again {
        valid = oldest.valid;
    }
    Stream { valid, payload: Marked { end, item: item.fragment } }
}

/// What the pixel holds of the first fragment that came again and is not done with it.
#[inline(always)]
#[rtl]
pub fn revisited(cfg: &Config, seen: Moore, pixel: Read<Pixel>) -> Read<Pixel> {
    let data = if seen.first.payload { Pixel::clear(&cfg.screen) } else { pixel.data };
    Read { valid: seen.again && pixel.valid, data }
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Fragments that arrived.
    #[block(Queue, queue(cfg))]
    pub queue: <Queue as Block>::Mem,
    /// Fragments that wait for their pixel.
    #[block(Waits, cfg.waiting())]
    pub waits: <Waits as Block>::Mem,
    /// Whether pixels hold nothing yet.
    #[block(Firsts, cfg.firsts())]
    #[exists(cfg.revisits())]
    pub firsts: Optional<<Firsts as Block>::Mem>,
}

#[rtl(
    check(DepthAhead, super::tests::config(1, 2)),
    check(DepthAhead, super::tests::config(4, 7)),
    check(DepthAhead, super::tests::config(4, 7).blending(super::Blends::Coming)),
    check(DepthAhead, super::tests::config(4, 7).blending(super::Blends::Revisiting))
)]
impl Block for DepthAhead {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let mut first = Stream::idle();
        if cfg.revisits() {
            first = Firsts::moore(&cfg.firsts(), &q.firsts, &m.firsts).front;
        }
        Moore {
            ready: Queue::moore(&queue(cfg), &q.queue, &m.queue).ready,
            oldest: Waits::moore(&cfg.waiting(), &q.waits, &m.waits).front,
            again: q.again,
            first,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // Third stage: the fragment that came first, once its pixel is there.
        let seen = Self::moore(cfg, q, m);
        let waits = Waits::moore(&cfg.waiting(), &q.waits, &m.waits);
        let again = cfg.revisits() && q.again;
        let Marked { end, item } = waits.front.payload;
        let f = item.fragment;
        let passed = passed(cfg, seen, i.pixel);
        let stalls = passed.valid && !i.passed_ready;
        let leaves = (there(cfg, waits.front, i.pixel) || passed.valid) && !stalls;
        let fragment = leaves && !end && !again;
        let (opaque, nearer) = (is_opaque(f.rgba), nearer(cfg, item, i.pixel));
        let mut taken = fragment && asked(cfg, item);
        let drawn = fragment && opaque && nearer;
        let blended = cfg.composes() && fragment && !opaque && nearer;
        // The first one is written even if it is at the far plane: its mark is set.
        let mut pixel = below(cfg, item, i.pixel);
        if drawn {
            pixel = Pixel { depth: f.z, colour: f.rgba >> 8 };
        } else if blended {
            pixel.colour = blend(f.rgba, pixel.colour);
        }
        let changes = drawn || blended || (taken && !item.marked);
        let mut write = Stream { valid: changes, payload: pixel };
        if again {
            // Its receiver is done with its pixel; one that held nothing is written in any case, as its mark is set.
            taken = i.taken;
            write.valid = i.write.valid || seen.first.payload;
            write.payload = Pixel::clear(&cfg.screen);
            if i.write.valid {
                write.payload = i.write.payload;
            }
        }

        // Second stage: the mark says whether the pixel is asked for.
        let Marked { end: last, item: next } = q.stage.payload;
        let waiting = Waiting { fragment: next, marked: i.marked.data };
        let mut kept = true;
        if cfg.revisits() {
            kept = Firsts::moore(&cfg.firsts(), &q.firsts, &m.firsts).ready;
        }
        let goes = q.stage.valid && waits.ready && i.table_ready && kept;
        let comes = goes && !last;
        let ask = Stream { valid: comes && (again || asked(cfg, waiting)), payload: next.pixel };
        let first = comes && (again || writes(cfg, next.rgba)) && !i.marked.data;
        if cfg.revisits() {
            let push = Stream { valid: comes && again, payload: first };
            let to_firsts = fifo::In { push, pop: again && taken };
            Firsts::next(&cfg.firsts(), &q.firsts, &mut d.firsts, &mut m.firsts, to_firsts);
            d.again = i.again;
        }
        let push = Stream { valid: goes, payload: Marked { end: last, item: waiting } };
        let to_waits = fifo::In { push, pop: leaves };
        Waits::next(&cfg.waiting(), &q.waits, &mut d.waits, &mut m.waits, to_waits);

        // First stage: asks for the mark of the next fragment's pixel.
        let front = Queue::moore(&queue(cfg), &q.queue, &m.queue).front;
        let mut mark_read = ReadPort::default();
        let takes = !q.stage.valid || goes;
        if takes {
            d.stage = front;
            if front.valid && !front.payload.end {
                mark_read.read(front.payload.item.pixel);
            }
        }
        let to_queue = fifo::In { push: i.fragment, pop: takes };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);

        Out {
            mark_read,
            mark: Stream { valid: first, payload: next.pixel },
            ask,
            taken,
            write,
            drawn,
            hidden: fragment && opaque && !nearer,
            culled: fragment && !opaque && !nearer,
        }
    }
}
