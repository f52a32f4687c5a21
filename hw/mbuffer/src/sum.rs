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

use pellucid_blocks::weights::{ONE, WEIGHT_BITS};
use pellucid_machine::pixel::{COLOUR_BITS, Marked, Screen};
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Sum;

/// Bits of a sum of weight times colour: the weights add up to at most one.
const SUM_BITS: u32 = WEIGHT_BITS + 8;

/// What some fragments of a pixel add up to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Weighted {
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
}

/// A part of a pixel's weighted sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Term {
    /// The pixel.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// What it adds.
    pub sum: Weighted,
    /// The pixel's last term.
    pub last: bool,
}

/// A pixel's weighted sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Total {
    /// The pixel.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// What its fragments add up to.
    pub sum: Weighted,
}

/// A term with a further fragment of colour `0xRRGGBBAA`.
#[inline(always)]
#[rtl]
pub fn plus(term: Term, rgba: u32, weight: u32) -> Term {
    let more = Weighted {
        r: weight * (rgba >> 24),
        g: weight * (rgba >> 16 & 0xff),
        b: weight * (rgba >> 8 & 0xff),
        weight,
    };
    Term { sum: both(term.sum, more), ..term }
}

/// What two parts of a pixel's fragments add up to.
#[inline(always)]
#[rtl]
fn both(a: Weighted, b: Weighted) -> Weighted {
    Weighted { r: a.r + b.r, g: a.g + b.g, b: a.b + b.b, weight: a.weight + b.weight }
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
    pub so_far: Weighted,
    /// The pixel that is to be written.
    #[with(*cfg)]
    pub stage: Stream<Marked<Total>>,
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
        State { so_far: Weighted::default(), stage: Stream::idle() }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, _: &State, _: &()) {}

    fn next(_: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let (mut colour_read, mut colour_write) = (ReadPort::default(), WritePort::default());

        // Second stage: the colour below is at hand.
        let Marked { end, item: Total { pixel, sum: all } } = q.stage.payload;
        if q.stage.valid && !end {
            let below = i.colour.data;
            let r = channel(all.r, all.weight, below >> 16);
            let g = channel(all.g, all.weight, below >> 8 & 0xff);
            let b = channel(all.b, all.weight, below & 0xff);
            colour_write.write(pixel, r << 16 | g << 8 | b);
        }

        // First stage: a pixel's last term asks for it.
        d.stage = Stream::idle();
        let Marked { end: ends, item: Term { pixel, sum, last } } = i.term.payload;
        if i.term.valid && ends {
            d.stage = Stream::offer(Marked::end());
        } else if i.term.valid {
            let all = both(q.so_far, sum);
            d.so_far = all;
            if last {
                d.so_far = Weighted::default();
                d.stage = Stream::offer(Marked::item(Total { pixel, sum: all }));
                colour_read.read(pixel);
            }
        }
        let frame_done = q.stage.valid && end;
        Out { colour_read, colour_write, frame_done }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{Source, contents, edge, holding, pattern, screen};
    use pellucid_sim::{ReadDuringWrite, Sim};
    use proptest::prelude::*;

    const PIXELS: u32 = 5;

    /// `(sum of weight * colour + rest * below) / ONE`, rounded to nearest, channel by channel.
    fn reference(below: u32, layers: &[(u32, u32)]) -> u32 {
        let channel = |shift: u32| {
            let parts =
                layers.iter().map(|(rgb, w)| u64::from(*w) * u64::from(rgb >> shift & 0xff));
            let rest = ONE - layers.iter().map(|(_, w)| w).sum::<u32>();
            let all = parts.sum::<u64>() + u64::from(rest) * u64::from(below >> shift & 0xff);
            ((2 * all + u64::from(ONE)) / (2 * u64::from(ONE))) as u32
        };
        channel(16) << 16 | channel(8) << 8 | channel(0)
    }

    proptest! {
        /// One term for each layer, whose weights add up to one at most.
        #[test]
        fn adds_up_as_a_plain_loop(
            below in proptest::collection::vec(0..1u32 << 24, PIXELS as usize),
            pixels in proptest::collection::vec(
                proptest::collection::vec((0..1u32 << 24, 0..=ONE / 6), 1..=6), PIXELS as usize),
            starts in pattern(),
        ) {
            let mut colours = holding(&below, COLOUR_BITS, ReadDuringWrite::Forbidden);
            let mut terms = vec![];
            for (pixel, layers) in (0..).zip(&pixels) {
                for (k, (rgb, weight)) in layers.iter().enumerate() {
                    let last = k + 1 == layers.len();
                    let none = Term { pixel, last, ..Term::default() };
                    terms.push(Marked::item(plus(none, rgb << 8, *weight)));
                }
            }
            terms.push(Marked::end());
            let mut source = Source::new(terms, starts);
            let mut sim = Sim::<Sum>::new(screen(PIXELS, 1));
            for cycle in 0.. {
                prop_assert!(cycle < 10_000, "the end of the frame does not come");
                let term = source.offer(cycle);
                source.edge(true);
                let out = sim.clock(In { term, colour: colours.q() }).unwrap().out;
                colours.pass_read(out.colour_read);
                colours.pass_write(out.colour_write);
                edge(&mut colours);
                if out.frame_done {
                    break;
                }
            }
            let expected: Vec<u32> =
                below.iter().zip(&pixels).map(|(below, layers)| reference(*below, layers)).collect();
            prop_assert_eq!(contents(&mut colours, PIXELS), expected);
        }
    }
}
