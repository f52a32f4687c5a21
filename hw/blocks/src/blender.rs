//! Blends a pixel's sorted fragments, far to near, over its opaque colour.
//!
//! ```text
//!               +---------+
//!  sorted ----->|         |---> colour read (a pixel's first fragment)
//!  (far first)  | Blender |---> colour write (its last)
//!  colour ----->|         |---> frame_done
//!               +---------+
//! ```
//! One fragment a cycle, always ready. A colour is written in the cycle after its pixel's last
//! fragment came in.

use pellucid_machine::pixel::{COLOUR_BITS, MOST_PIXEL_BITS, Marked, blend};
use pellucid_sim::Block;
use pellucid_sim::{Label, Read, ReadPort, Signals, Stream, WritePort, check_range, rtl};

/// See the module's description.
pub struct Blender;

/// A fragment in blending order. The width of its pixel's number is 0 if its turn tells which it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(u32)]
pub struct Sorted {
    /// Its pixel.
    #[width(*cfg)]
    pub pixel: u32,
    /// Its colour, `0xRRGGBBAA`.
    #[width(32)]
    pub rgba: u32,
    /// The pixel's nearest fragment: nothing follows.
    pub last: bool,
    /// Which fragment it is, in waveforms.
    pub label: Label,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(u32)]
pub struct State {
    /// The next fragment is its pixel's first.
    pub fresh: bool,
    /// The fragment to be blended.
    #[with(*cfg)]
    pub stage: Stream<Marked<Sorted>>,
    /// The fragment to be blended is its pixel's first.
    pub stage_fresh: bool,
    /// The pixel's colour so far, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(u32)]
pub struct In {
    /// Fragments of one pixel after the other, far to near, then the end of the frame.
    #[with(*cfg)]
    pub sorted: Stream<Marked<Sorted>>,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(u32)]
pub struct Out {
    /// Reads a pixel's opaque colour.
    #[with(*cfg)]
    pub colour_read: ReadPort,
    /// Writes a pixel's final colour.
    #[with(*cfg, COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// A fragment is blended in this cycle.
    pub blended: bool,
    /// The end of the frame has come through.
    pub frame_done: bool,
}

#[rtl(check(Blender, 4), check(Blender, 0))]
impl Block for Blender {
    /// Bits of a pixel's number.
    type Config = u32;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &u32) -> State {
        check_range("the bits of a pixel's number", *cfg, ..=MOST_PIXEL_BITS);
        State { fresh: true, stage: Stream::idle(), stage_fresh: false, colour: 0 }
    }

    fn memories(_: &u32) {}

    fn moore(_: &u32, _: &State, _: &()) {}

    fn next(_: &u32, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let (mut colour_read, mut colour_write) = (ReadPort::default(), WritePort::default());

        // Second stage: the colour below is at hand.
        let Marked { end, item } = q.stage.payload;
        let blended = q.stage.valid && !end;
        if blended {
            let below = if q.stage_fresh { i.colour.data } else { q.colour };
            d.colour = blend(item.rgba, below);
            if item.last {
                colour_write.write(item.pixel, d.colour);
            }
        }

        // First stage: a pixel's first fragment asks for the colour below.
        d.stage = i.sorted;
        if i.sorted.valid && !i.sorted.payload.end {
            d.stage_fresh = q.fresh;
            d.fresh = i.sorted.payload.item.last;
            if q.fresh {
                colour_read.read(i.sorted.payload.item.pixel);
            }
        }
        let frame_done = q.stage.valid && end;
        Out { colour_read, colour_write, blended, frame_done }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{contents, edge, holding};
    use pellucid_machine::pixel::rgba;
    use pellucid_sim::{ReadDuringWrite, Sim};

    #[test]
    fn by_hand() {
        // Half white over black is 128; half black over that is (127 * 128) / 255 = 63.7.
        let half_white = (2, rgba(255, 255, 255, 128), false);
        let half_black = (2, rgba(0, 0, 0, 128), true);
        let opaque = (3, rgba(1, 2, 3, 255), true);
        let frame = [half_white, half_black, opaque].map(|(pixel, rgba, last)| {
            Marked::item(Sorted { pixel, rgba, last, ..Sorted::default() })
        });
        let mut sim = Sim::<Blender>::new(3);
        let mut colours = holding(&[0; 6], COLOUR_BITS, ReadDuringWrite::Forbidden);
        let sent = frame.map(Stream::offer).into_iter().chain([Stream::idle()]);
        for sorted in sent {
            let out = sim.clock(In { sorted, colour: colours.q() }).unwrap().out;
            colours.pass_read(out.colour_read);
            colours.pass_write(out.colour_write);
            edge(&mut colours);
        }
        assert_eq!(contents(&mut colours, 6), [0, 0, 0x40_40_40, 0x01_02_03, 0, 0]);
    }
}
