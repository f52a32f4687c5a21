//! The weighted sum: adds up a pixel's terms and gives the rest of the weight to the opaque colour.
//!
//! ```text
//!              +-----+
//!  term ------>|     |---> colour read (a pixel's last term)
//!  colour ---->| Sum |---> colour write
//!              |     |---> frame_done
//!              +-----+
//! ```
//! One term a cycle, always ready. A colour is written in the cycle after its pixel's last term came in:
//! `(sum of weight * colour + (1 - sum of weights) * opaque colour)`, rounded to nearest.

use crate::pixel::{COLOUR_BITS, Marked, Screen};
use crate::weights::{ONE, WEIGHT_BITS};
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Sum;

/// Bits of a sum of weight times colour: the weights add up to at most one.
const SUM_BITS: u32 = WEIGHT_BITS + 8;

/// What some fragments of a pixel add up to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Term {
    /// The pixel.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// Sum of weight times red.
    #[width(SUM_BITS)]
    pub r: u32,
    /// Sum of weight times green.
    #[width(SUM_BITS)]
    pub g: u32,
    /// Sum of weight times blue.
    #[width(SUM_BITS)]
    pub b: u32,
    /// Sum of the weights, at most one.
    #[width(WEIGHT_BITS + 1)]
    pub weight: u32,
    /// The pixel's last term.
    pub last: bool,
}

/// A term with a further fragment of colour `0xRRGGBBAA`.
#[inline(always)]
#[rtl]
pub fn plus(term: Term, rgba: u32, weight: u32) -> Term {
    Term {
        r: term.r + weight * (rgba >> 24),
        g: term.g + weight * (rgba >> 16 & 0xff),
        b: term.b + weight * (rgba >> 8 & 0xff),
        weight: term.weight + weight,
        ..term
    }
}

/// A channel of a colour: what the fragments add up to, and the rest of the weight for what is below.
#[inline(always)]
#[rtl]
fn channel(sum: u32, weight: u32, below: u32) -> u32 {
    (sum + (ONE - weight) * below + (ONE >> 1)) >> WEIGHT_BITS
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// What the pixel's terms add up to so far.
    #[with(*cfg)]
    pub so_far: Term,
    /// The pixel that is to be written.
    #[with(*cfg)]
    pub stage: Stream<Marked<Term>>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Terms of one pixel after the other, then the end of the frame.
    #[with(*cfg)]
    pub term: Stream<Marked<Term>>,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Out {
    /// Reads a pixel's opaque colour.
    #[with(cfg.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes a pixel's final colour.
    #[with(cfg.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// The end of the frame has come through.
    pub frame_done: bool,
}

#[rtl(check(Sum, crate::test_util::screen(5, 3)))]
impl Block for Sum {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = ();

    fn reset(_: &Screen) -> State {
        State { so_far: Term::default(), stage: Stream::idle() }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, _: &State, _: &()) {}

    #[inline(always)]
    fn next(_: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let (mut colour_read, mut colour_write) = (ReadPort::default(), WritePort::default());

        // Second stage: the colour below is at hand.
        let Marked { end, item: all } = q.stage.payload;
        if q.stage.valid && !end {
            let below = i.colour.data;
            let r = channel(all.r, all.weight, below >> 16);
            let g = channel(all.g, all.weight, below >> 8 & 0xff);
            let b = channel(all.b, all.weight, below & 0xff);
            colour_write.write(all.pixel, r << 16 | g << 8 | b);
        }

        // First stage: a pixel's last term asks for it.
        d.stage = Stream::idle();
        let term = i.term.payload.item;
        if i.term.valid && i.term.payload.end {
            d.stage = i.term;
        } else if i.term.valid {
            let all = Term {
                pixel: term.pixel,
                r: q.so_far.r + term.r,
                g: q.so_far.g + term.g,
                b: q.so_far.b + term.b,
                weight: q.so_far.weight + term.weight,
                last: term.last,
            };
            d.so_far = all;
            if term.last {
                d.so_far = Term::default();
                d.stage = Stream::offer(Marked::item(all));
                colour_read.read(term.pixel);
            }
        }
        let frame_done = q.stage.valid && end;
        Out { colour_read, colour_write, frame_done }
    }
}
