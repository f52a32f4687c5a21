//! The selector: finds each pixel's farthest fragment, pass after pass.
//!
//! ```text
//!                  +----------+---> pushed (back into the queue)
//!  fragment ------>|          |<--- pushed_ready, full
//!  ready <---------| Selector |---> picked (to be blended)
//!  depth --------->|          |---> depth read / write
//!                  +----------+---> ended
//! ```
//! One fragment a cycle; three cycles from input to output. Per pixel it has the depth of the farthest
//! fragment that went into the queue, and three state bits; the depth buffer holds the opaque depth until
//! the pixel's first pass begins, then the depth that is being blended.
//!
//! The rules are those of the R-buffer, with Z1 the depth that is being blended and Z2 the farthest one
//! pushed. A pass begins for a pixel when its first fragment of the pass comes, which the parity of the
//! pass tells: no sweep over all pixels. Then Z1 = Z2, and Z2 = 0, the nearest, than which nothing is
//! nearer.
//!
//! | a fragment comes | condition | what happens |
//! |---|---|---|
//! | at any time | the round has failed | it is thrown away; Z2 = 0 |
//! | on arrival | its pixel is not in the band | it is passed over |
//! | | there is no room | it is dropped, or the round fails: see [`rounds`] |
//! | | otherwise | push; Z2 = max(Z2, z) |
//! | in a pass | the pixel has a target, none was blended in this pass, z = Z1 | blend |
//! | | the pixel has none, z is not in front of the opaque depth | it is culled |
//! | | otherwise | push; Z2 = max(Z2, z) |
//!
//! Where the frame buffer lies in outside memory a fragment of a pass waits until its pixel's depth and colour are there, and says
//! when it is done with them (`taken`) and what they are from then on: a fragment that is picked is blended in that cycle.
//!
//! A pixel has a target but in a first pass in which Z2 is not in front of the opaque depth: an opaque
//! fragment that came later hides its farthest ones. That pass only culls.

use super::config::Config;
use super::rounds;
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::pixels::Pixel;
use pellucid_machine::pixel::{COLOUR_BITS, Marked, PixelFragment, Screen, Z_BITS, blend};
use pellucid_sim::Block;
use pellucid_sim::{
    Fifo, Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, WritePort, fifo, rtl,
};

/// See the module's description.
pub struct Selector;

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct PixelState {
    /// Parity of the pass in which its last fragment came.
    pub parity: bool,
    /// The depth buffer holds the depth that is being blended.
    pub target: bool,
    /// A fragment was blended in that pass.
    pub blended: bool,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Fragments that came.
    #[with(QUEUE_DEPTH)]
    pub queue: fifo::State,
    /// The fragment whose pixel was asked for.
    #[with(cfg.screen)]
    pub stage: Stream<Marked<PixelFragment>>,
}

const QUEUE_DEPTH: u32 = 2;

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct In {
    /// Fragments, then the end of the arrivals or of the pass.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// They come for the first time.
    pub arrival: bool,
    /// They come in the first pass.
    pub first_pass: bool,
    /// Parity of the pass; arrivals have that of the last one.
    pub parity: bool,
    /// The depth that was asked for. Where the frame buffer lies outside, once it is there.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The colour that comes with it there, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    #[exists(cfg.front.outside())]
    pub colour: u32,
    /// The queue takes a fragment.
    pub pushed_ready: bool,
    /// The queue has no room and will have none while fragments arrive.
    pub full: bool,
    /// The band of pixels whose fragments are taken.
    #[with(*cfg)]
    pub round: rounds::Moore,
    /// The pixel that is cleared, after reset.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a pixel's depth.
    #[with(cfg.screen.pixel_bits())]
    pub depth_read: ReadPort,
    /// Writes a pixel's depth.
    #[with(cfg.screen.pixel_bits(), Z_BITS)]
    pub depth_write: WritePort<u32>,
    /// The pixel at hand is done with.
    #[exists(cfg.front.outside())]
    pub taken: bool,
    /// What it holds from now on.
    #[with(cfg.screen)]
    #[exists(cfg.front.outside())]
    pub pixel: Stream<Pixel>,
    /// What goes into the queue.
    #[with(cfg.screen)]
    pub pushed: Stream<PixelFragment>,
    /// What is blended next at its pixel.
    #[with(cfg.screen.pixel_bits())]
    pub picked: Stream<Marked<Sorted>>,
    /// The end has come through, and everything before it is in the queue.
    pub ended: bool,
    /// A fragment is hidden by the final opaque depth.
    pub culled: bool,
    /// A fragment found no room.
    pub dropped: bool,
    /// A fragment finds no room in this round.
    pub overflowed: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Fragments that came.
    pub queue: <Queue as Block>::Mem,
    /// What is known of each pixel.
    pub pixels: Ram1R1W<PixelState>,
    /// Z2: depth of the farthest fragment that was pushed, 0 if none.
    pub farthest: Ram1R1W<u32>,
}

type Queue = Fifo<Marked<PixelFragment>>;

fn queue(cfg: &Config) -> fifo::Config<Screen> {
    fifo::Config { depth: QUEUE_DEPTH, item: cfg.screen }
}

/// A cycle in which a pixel is [cleared](In::clear) and all else rests, with the memories; whether one of these is at fault.
pub fn clear_alone(
    cfg: &Config,
    q: &State,
    d: &mut State,
    m: &mut Mem,
    clear: Stream<u32>,
) -> Option<bool> {
    Selector::next(cfg, q, d, m, In { clear, ..In::default() });
    Some(m.clock())
}

#[rtl(moore = (), check(Selector, crate::test_util::small_rbuffer(4, Some(7))), check(Selector, crate::test_util::small_rbuffer(9, None)))]
impl Block for Selector {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State { queue: Queue::reset(&queue(cfg)), stage: Stream::idle() }
    }

    fn memories(cfg: &Config) -> Mem {
        let (words, new) = (cfg.screen.pixels(), ReadDuringWrite::New);
        Mem {
            queue: Queue::memories(&queue(cfg)),
            pixels: Ram1R1W::new(words, (), 1, new),
            farthest: Ram1R1W::new(words, Z_BITS, 1, new),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        Moore { ready: Queue::moore(&queue(cfg), &q.queue, &m.queue).ready }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (mut depth_read, mut depth_write) = (ReadPort::default(), WritePort::default());

        // Second stage: what is known of the pixel is at hand.
        let (pixel, farthest, depth) = (m.pixels.q().data, m.farthest.q().data, i.depth.data);
        let end = q.stage.valid && q.stage.payload.end;
        let waits = cfg.front.outside() && !i.arrival && !i.depth.valid;
        let fragment = q.stage.valid && !end && !waits;
        let f = q.stage.payload.item;
        let fresh = pixel.parity != i.parity;
        let has_target = if fresh { !i.first_pass || farthest < depth } else { pixel.target };
        let target = !i.arrival && has_target;
        let z1 = if fresh && target { farthest } else { depth };
        let blended = !i.arrival && !fresh && pixel.blended;
        // Where the frame is sent once, its band is all pixels and never fails.
        let mut round = rounds::once(cfg);
        let mut out_of_band = false;
        if cfg.replay {
            round = i.round;
            out_of_band = f.pixel < round.from || f.pixel >= round.to;
        }
        let passed_over = round.failed || (i.arrival && out_of_band);
        let picked = fragment && !passed_over && target && !blended && f.z == z1;
        let culled = fragment && !passed_over && !i.arrival && !target && f.z >= z1;
        let stays = fragment && !picked && !culled && !passed_over;
        let full = stays && i.arrival && i.full;
        let push = stays && !full;
        let held = push && !i.pushed_ready;
        let stall = held || (q.stage.valid && !end && waits);
        if fragment && !held && !full && !passed_over {
            let before = if fresh && !i.arrival { 0 } else { farthest };
            let now = if push && f.z > before { f.z } else { before };
            let known = PixelState { parity: i.parity, target, blended: blended || picked };
            m.pixels.write(f.pixel, known);
            m.farthest.write(f.pixel, now);
            if fresh && target && !cfg.front.outside() {
                depth_write.write(f.pixel, z1);
            }
        } else if fragment && round.failed && !i.arrival {
            // Thrown away: nothing of the pixel is left.
            m.pixels.write(f.pixel, PixelState { parity: i.parity, target: false, blended: false });
            m.farthest.write(f.pixel, 0);
        }

        // First stage: ask for what is known of the next fragment's pixel.
        let front = Queue::moore(&queue(cfg), &q.queue, &m.queue).front;
        if !stall {
            d.stage = front;
            if front.valid && !front.payload.end {
                m.pixels.read(front.payload.item.pixel);
                m.farthest.read(front.payload.item.pixel);
                if !i.arrival && !cfg.front.outside() {
                    depth_read.read(front.payload.item.pixel);
                }
            }
        }
        let to_queue = fifo::In { push: i.fragment, pop: !stall };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);

        if i.clear.valid {
            m.pixels.write(i.clear.payload, PixelState::default());
            m.farthest.write(i.clear.payload, 0);
        }

        let mut colour = i.colour;
        if picked {
            colour = blend(f.rgba, i.colour);
        }
        let taken = cfg.front.outside() && fragment && !i.arrival && !held;
        let changes = taken && (picked || (fresh && target && !passed_over));
        let sorted = Sorted { pixel: f.pixel, rgba: f.rgba, last: true, label: f.label };
        Out {
            depth_read,
            depth_write,
            taken,
            pixel: Stream { valid: changes, payload: Pixel { depth: z1, colour } },
            pushed: Stream { valid: push, payload: f },
            picked: Stream { valid: picked, payload: Marked::item(sorted) },
            ended: end,
            culled,
            dropped: full && round.smallest,
            overflowed: full && !round.smallest,
        }
    }
}

#[cfg(test)]
mod tests;
