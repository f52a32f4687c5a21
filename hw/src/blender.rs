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

use crate::pixel::{COLOUR_BITS, Marked, Screen, blend};
use pellucid_sim::Block;
use pellucid_sim::{Label, Read, ReadPort, Signals, Stream, WritePort, rtl};

/// See the module's description.
pub struct Blender;

/// A fragment in blending order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Sorted {
    /// Its pixel.
    #[width(cfg.pixel_bits())]
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
#[signals(Screen)]
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
#[signals(Screen)]
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
#[signals(Screen)]
pub struct Out {
    /// Reads a pixel's opaque colour.
    #[with(cfg.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes a pixel's final colour.
    #[with(cfg.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// A fragment is blended in this cycle.
    pub blended: bool,
    /// The end of the frame has come through.
    pub frame_done: bool,
}

#[rtl(check(Blender, crate::test_util::screen(5, 3)))]
impl Block for Blender {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = ();

    fn reset(_: &Screen) -> State {
        State { fresh: true, stage: Stream::idle(), stage_fresh: false, colour: 0 }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, _: &State, _: &()) {}

    #[inline(always)]
    fn next(_: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
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
    use crate::pixel::{div255, rgba};
    use crate::test_util::{Pattern, Source, contents, edge, holding, pattern, screen};
    use pellucid_sim::{ReadDuringWrite, Sim};
    use proptest::prelude::*;

    const PIXELS: u32 = 6;

    /// A plain loop, channel by channel: `div255(a*s + (255-a)*c)`, far to near.
    fn reference(below: u32, layers: &[[u8; 4]]) -> u32 {
        let mut colour = below.to_be_bytes().map(u32::from);
        for &[r, g, b, a] in layers {
            for (c, s) in colour[1..].iter_mut().zip([r, g, b]) {
                *c = div255(u32::from(a) * u32::from(s) + (255 - u32::from(a)) * *c);
            }
        }
        colour[1] << 16 | colour[2] << 8 | colour[3]
    }

    fn write(pixel: u32, colour: u32) -> WritePort<u32> {
        let mut port = WritePort::default();
        port.write(pixel, colour);
        port
    }

    /// Plays pixels with their layers, far to near, over the opaque colours `below`; gives the
    /// colours after the frame. Each write is held to its cycle and its value.
    fn play(below: &[u32], pixels: &[(u32, Vec<[u8; 4]>)], starts: Pattern) -> Vec<u32> {
        let mut sim = Sim::<Blender>::new(screen(PIXELS, 1));
        let mut colours = holding(below, COLOUR_BITS, ReadDuringWrite::Forbidden);
        let mut frame = vec![];
        for (pixel, layers) in pixels {
            for (k, &[r, g, b, a]) in layers.iter().enumerate() {
                let last = k + 1 == layers.len();
                frame.push(Marked::item(Sorted {
                    pixel: *pixel,
                    rgba: rgba(r, g, b, a),
                    last,
                    ..Sorted::default()
                }));
            }
        }
        frame.push(Marked::end());
        let mut source = Source::new(frame, starts);
        let mut written = 0;
        // What came in in the cycle before.
        let mut before: Stream<Marked<Sorted>> = Stream::idle();
        for cycle in 0.. {
            assert!(cycle < 10_000, "the end of the frame does not come");
            let sorted = source.offer(cycle);
            source.edge(true);
            let out = sim.clock(In { sorted, colour: colours.q() }).unwrap().out;
            colours.pass_read(out.colour_read);
            colours.pass_write(out.colour_write);
            edge(&mut colours);
            let Marked { end, item } = before.payload;
            assert_eq!(out.blended, before.valid && !end);
            if before.valid && !end && item.last {
                let (pixel, layers) = &pixels[written];
                let colour = reference(below[*pixel as usize], layers);
                assert_eq!(out.colour_write, write(*pixel, colour));
                written += 1;
            } else {
                assert_eq!(out.colour_write, WritePort::default());
            }
            assert_eq!(out.frame_done, before.valid && end);
            if out.frame_done {
                break;
            }
            before = sorted;
        }
        contents(&mut colours, PIXELS)
    }

    #[test]
    fn by_hand() {
        // Half white over black is 128; half black over that is (127 * 128) / 255 = 63.7.
        let layers = vec![[255, 255, 255, 128], [0, 0, 0, 128]];
        let colours = play(&[0; 6], &[(2, layers), (3, vec![[1, 2, 3, 255]])], Pattern::always());
        assert_eq!(colours, [0, 0, 0x40_40_40, 0x01_02_03, 0, 0]);
    }

    #[test]
    fn an_empty_frame_is_done_one_cycle_after_its_end() {
        assert_eq!(play(&[7; 6], &[], Pattern::always()), [7; 6]);
    }

    proptest! {
        /// Against a plain blend loop, each pixel written once, in the cycle after its last fragment.
        #[test]
        fn behaves_as_a_plain_blend(
            below in proptest::collection::vec(0..1u32 << 24, PIXELS as usize),
            order in Just((0..PIXELS).collect::<Vec<_>>()).prop_shuffle(),
            layers in proptest::collection::vec(
                proptest::collection::vec(any::<[u8; 4]>(), 1..8), 0..PIXELS as usize),
            starts in pattern(),
        ) {
            let pixels: Vec<(u32, Vec<[u8; 4]>)> = order.into_iter().zip(layers).collect();
            let mut expected = below.clone();
            for (pixel, layers) in &pixels {
                expected[*pixel as usize] = reference(below[*pixel as usize], layers);
            }
            prop_assert_eq!(play(&below, &pixels, starts), expected);
        }
    }
}
