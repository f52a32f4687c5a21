//! Blends fragments over the frame buffer's colours in the order in which they come.
//!
//! ```text
//!               +------------+
//!  fragment --->|            |---> colour read, colour write
//!  colour ----->| Compositor |---> ended
//!               +------------+
//! ```
//! A fragment a cycle, always ready, of the same pixel or not; a colour is written in the cycle after its fragment came.
//! Where the pixels of a frame come one after the other, a [blender](pellucid_blocks::blender) writes each once.

use pellucid_machine::pixel::{COLOUR_BITS, Marked, PixelFragment, Screen, blend};
use pellucid_sim::{Block, Label, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Compositor;

/// A fragment that is to be blended: its depth is done with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Layer {
    /// Its pixel.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// Colour as `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// The fragment at hand.
    #[with(*cfg)]
    pub stage: Stream<Marked<Layer>>,
    /// The one before it was of its pixel.
    pub same: bool,
    /// The colour that was written last, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Fragments, then the end of the play.
    #[with(*cfg)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
pub struct Moore {
    /// All fragments of the play are blended.
    pub ended: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Out {
    /// Reads a pixel's colour.
    #[with(cfg.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes it.
    #[with(cfg.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// A fragment is blended.
    pub blended: bool,
}

#[rtl(moore = (), check(Compositor, crate::test_util::screen(5, 3)))]
impl Block for Compositor {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(_: &Screen) -> State {
        State { stage: Stream::idle(), same: false, colour: 0 }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, q: &State, (): &()) -> Moore {
        Moore { ended: q.stage.valid && q.stage.payload.end }
    }

    fn next(_: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let (mut colour_read, mut colour_write) = (ReadPort::default(), WritePort::default());

        // Second stage: the colour below is at hand.
        let Marked { end, item } = q.stage.payload;
        let blended = q.stage.valid && !end;
        if blended {
            let below = if q.same { q.colour } else { i.colour.data };
            d.colour = blend(item.rgba, below);
            colour_write.write(item.pixel, d.colour);
        }

        // First stage: ask for it, unless it is being written.
        let Marked { end, item: PixelFragment { pixel, rgba, label, .. } } = i.fragment.payload;
        d.stage.valid = i.fragment.valid;
        if i.fragment.valid {
            d.stage.payload = Marked { end, item: Layer { pixel, rgba, label } };
            d.same = blended && item.pixel == pixel;
            if !end && !d.same {
                colour_read.read(pixel);
            }
        }
        Out { colour_read, colour_write, blended }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{contents, edge, holding, screen};
    use pellucid_machine::pixel::rgba;
    use pellucid_sim::{ReadDuringWrite, Sim};
    use proptest::prelude::*;

    proptest! {
        /// Against the blend pixel by pixel, with gaps between.
        #[test]
        fn blends_in_the_order_of_arrival(
            fragments in prop::collection::vec((0..4u32, any::<u32>(), any::<bool>()), 0..40),
        ) {
            let (cfg, begin) = (screen(2, 2), [0x10_20_30, 0, 0xff_ff_ff, 0x80_00_80]);
            let mut sim = Sim::<Compositor>::new(cfg);
            let mut colours = holding(&begin, COLOUR_BITS, ReadDuringWrite::Forbidden);
            let mut offers = vec![];
            for (pixel, rgba, gap) in &fragments {
                let item = PixelFragment { pixel: *pixel, rgba: *rgba, ..PixelFragment::default() };
                offers.push(Stream::offer(Marked::item(item)));
                offers.extend(gap.then_some(Stream::idle()));
            }
            offers.extend([Stream::offer(Marked::end()), Stream::idle()]);
            let mut ends = vec![];
            for fragment in offers {
                ends.push(sim.moore().ended);
                let out = sim.clock(In { fragment, colour: colours.q() }).unwrap().out;
                colours.pass_read(out.colour_read);
                colours.pass_write(out.colour_write);
                edge(&mut colours);
            }
            let mut expected = begin;
            for (pixel, rgba, _) in fragments {
                let [own @ .., alpha] = rgba.to_be_bytes().map(f64::from);
                let below = expected[pixel as usize].to_be_bytes();
                let over = |k: usize| {
                    let mixed = (alpha * own[k] + (255.0 - alpha) * f64::from(below[k + 1])) / 255.0;
                    mixed.round() as u8
                };
                expected[pixel as usize] = rgba_of(over(0), over(1), over(2));
            }
            prop_assert_eq!(contents(&mut colours, 4), expected);
            prop_assert_eq!(ends.iter().filter(|end| **end).count(), 1);
            prop_assert_eq!(ends.last(), Some(&true));
        }
    }

    /// A colour `0xRRGGBB`.
    fn rgba_of(r: u8, g: u8, b: u8) -> u32 {
        rgba(r, g, b, 0) >> 8
    }
}
