//! The contract of a blender, see [`mod@pellucid_blocks::blender`], as properties.
//!
//! Frames of random pixels are sent, each pixel's fragments far to near, beside a memory of opaque colours;
//! a plain blend says which colours must be written. A sequence says for every cycle whether the next
//! fragment comes, and whether the blender is reset; behind it all is sent.

use crate::reference::{Judged, LONG, Long, Reference};
use pellucid_blocks::blender::{In, Out, Sorted};
use pellucid_machine::pixel::{COLOUR_BITS, Marked};
use pellucid_sim::{
    Block, Fault, Label, Memory, Ram1R1W, ReadDuringWrite, Registers, Storage, Stream, bits_for,
};
use proptest::prelude::*;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

/// What can be tested: a block with the ports of [`pellucid_blocks::blender::Blender`].
pub trait Blends:
    Block<Config = u32, State: Registers<Config = u32>, In = In, Moore = (), Out = Out> + 'static
{
}

impl<B> Blends for B where
    B: Block<Config = u32, State: Registers<Config = u32>, In = In, Moore = (), Out = Out>
        + 'static
{
}

/// A pixel's number and the colours of its fragments, far to near, at least one, `0xRRGGBBAA`.
pub type Pixel = (u32, Vec<u32>);

/// What is fixed while a sequence is played.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The opaque colour of each pixel, `0xRRGGBB`.
    pub below: Vec<u32>,
    /// Frames of pixels.
    pub frames: Vec<Vec<Pixel>>,
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The next fragment comes.
    pub come: bool,
    /// The blender is reset instead, and all begins anew.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A pixel's colour is read as its first fragment comes, and only then.
    Read,
    /// One is written to the pixel in the cycle after its last fragment came, and only then.
    Write,
    /// It is that of the pixel's fragments, far to near, over the colour that was read.
    Colour,
    /// `blended` is high in the cycle after a fragment came, and only then.
    Blended,
    /// `frame_done` is high in the cycle after the frame's end came, and only then.
    Done,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Read => "a pixel's colour is read as its first fragment comes, and only then",
            Property::Write => {
                "one is written to the pixel in the cycle after its last fragment came"
            }
            Property::Colour => {
                "what is written are the fragments, far to near, over what was read"
            }
            Property::Blended => "`blended` is high in the cycle after a fragment came",
            Property::Done => "`frame_done` is high in the cycle after the frame's end came",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// What must be seen in a cycle for what came in the one before.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    /// A pixel and its colour.
    write: Option<(u32, u32)>,
    blended: bool,
    done: bool,
}

/// What a blender is held to.
pub struct Model<B> {
    cycle: u64,
    /// The memory of colours beside the blender.
    colours: Ram1R1W<u32>,
    items: Vec<Marked<Sorted>>,
    sent: usize,
    /// The colour of the pixel at hand with all that came; none between pixels.
    so_far: Option<u32>,
    /// The pixel whose colour must be read in this cycle.
    read: Option<u32>,
    /// What must be seen in this cycle, and in the next one.
    due: [Due; 2],
    blender: PhantomData<B>,
}

/// `a` parts of 255 of `s` over `c`, rounded to nearest; 255 is odd, so that nothing lies half way.
fn share(a: u32, s: u32, c: u32) -> u32 {
    (2 * (a * s + (255 - a) * c) + 255) / 510
}

/// A fragment `0xRRGGBBAA` over a colour `0xRRGGBB`, each channel rounded to nearest.
fn over(rgba: u32, below: u32) -> u32 {
    let [r, g, b, a] = rgba.to_be_bytes().map(u32::from);
    let [_, below_r, below_g, below_b] = below.to_be_bytes().map(u32::from);
    share(a, r, below_r) << 16 | share(a, g, below_g) << 8 | share(a, b, below_b)
}

/// Pixels of the screen.
const PIXELS: u32 = 6;

/// A small setup: frames of pixels that have so many fragments each.
fn small(frames: &[&[u32]]) -> Setup {
    let pixel = |(pixel, layers): (u32, &u32)| {
        (pixel, (0..*layers).map(|k| 0xff_c0_40_80 ^ (pixel << 28 | k << 20)).collect())
    };
    let frames = frames.iter().map(|frame| (0..).zip(*frame).map(pixel).collect()).collect();
    Setup { below: (0..PIXELS).map(|k| k << 16 | 0x20_80_f0).collect(), frames }
}

/// So many frames of up to five pixels.
fn frames(number: Range<usize>) -> BoxedStrategy<Setup> {
    let below = proptest::collection::vec(0..1u32 << COLOUR_BITS, PIXELS as usize);
    let layers = proptest::collection::vec(any::<u32>(), 1..8);
    let order = Just((0..PIXELS).collect::<Vec<_>>()).prop_shuffle();
    let frame = (order, proptest::collection::vec(layers, 0..PIXELS as usize))
        .prop_map(|(order, layers)| order.into_iter().zip(layers).collect());
    (below, proptest::collection::vec(frame, number))
        .prop_map(|(below, frames)| Setup { below, frames })
        .boxed()
}

impl<B: Blends> Reference for Model<B> {
    type Block = B;
    type Config = u32;
    type Setup = Setup;
    type Step = Step;
    type Property = Property;
    type Outputs = Out;
    const NAME: &'static str = "blender";

    fn setups() -> BoxedStrategy<Setup> {
        frames(1..4)
    }
    fn long() -> Vec<Long<Self>> {
        let come = prop::bool::weighted(0.9);
        let step = come.prop_map(|come| Step { come, reset: false }).boxed();
        vec![Long { setup: frames(9000..9001), step, steps: LONG }]
    }
    fn steps(_: &Setup) -> BoxedStrategy<Step> {
        let bits = (prop::bool::weighted(0.7), prop::bool::weighted(0.01));
        bits.prop_map(|(come, reset)| Step { come, reset }).boxed()
    }
    fn small() -> Vec<Setup> {
        let frames: [&[&[u32]]; 8] =
            [&[&[]], &[&[1]], &[&[2]], &[&[1, 1]], &[&[3]], &[&[1, 2]], &[&[2, 1]], &[&[1], &[2]]];
        frames.map(small).to_vec()
    }
    fn told(setup: &Setup) -> String {
        let below: Vec<String> = setup.below.iter().map(|colour| format!("{colour:06x}")).collect();
        format!("opaque colours {}", below.join(" "))
    }
    fn config(_: &Setup) -> u32 {
        bits_for(u64::from(PIXELS - 1))
    }
    fn new(Setup { below, frames }: &Setup) -> Model<B> {
        let mut colours = Ram1R1W::new(PIXELS, COLOUR_BITS, 1, ReadDuringWrite::Forbidden);
        for (pixel, colour) in (0..).zip(below) {
            colours.write(pixel, *colour);
            colours.clock();
        }
        Model {
            cycle: 0,
            colours,
            items: frames.iter().flat_map(|frame| sent(frame)).collect(),
            sent: 0,
            so_far: None,
            read: None,
            due: [Due::default(); 2],
            blender: PhantomData,
        }
    }

    fn look(&mut self, cycle: u64, (): &()) -> Judged<Property> {
        self.cycle = cycle;
        Ok(())
    }

    fn inputs(&mut self, step: &Step, (): &()) -> Option<In> {
        self.read = None;
        if step.reset {
            self.colours.reset();
            (self.sent, self.so_far, self.due) = (0, None, [Due::default(); 2]);
            return None;
        }
        let mut next = Due::default();
        let came = self.items.get(self.sent).filter(|_| step.come).copied();
        if let Some(Marked { end, item }) = came {
            self.sent += 1;
            (next.blended, next.done) = (!end, end);
            if !end {
                let below = self.so_far.unwrap_or_else(|| {
                    self.read = Some(item.pixel);
                    self.colour(item.pixel)
                });
                let colour = over(item.rgba, below);
                self.so_far = (!item.last).then_some(colour);
                next.write = item.last.then_some((item.pixel, colour));
            }
        }
        self.due = [self.due[1], next];
        let sorted = came.map_or(Stream::idle(), Stream::offer);
        Some(In { sorted, colour: self.colours.q() })
    }

    fn judge(&mut self, out: &Out) -> Judged<Property> {
        let Due { write, blended, done } = self.due[0];
        let (read, written) = (out.colour_read.asked(), out.colour_write.asked());
        if read != self.read {
            let seen = format!("{} is read where {} is due", pixel(read), pixel(self.read));
            return Err((Property::Read, seen));
        }
        let place = |write: Option<(u32, u32)>| write.map(|(pixel, _)| pixel);
        if place(written) != place(write) {
            let (is, due) = (pixel(place(written)), pixel(place(write)));
            return Err((Property::Write, format!("{is} is written where {due} is due")));
        }
        if let (Some((_, is)), Some((at, due))) = (written, write)
            && is != due
        {
            let seen = format!("{is:06x} is written to pixel {at} where {due:06x} is due");
            return Err((Property::Colour, seen));
        }
        let level = |high| if high { "high" } else { "low" };
        if out.blended != blended {
            return Err((Property::Blended, format!("it is {}", level(out.blended))));
        }
        if out.frame_done != done {
            return Err((Property::Done, format!("it is {}", level(out.frame_done))));
        }
        self.colours.pass_read(out.colour_read);
        self.colours.pass_write(out.colour_write);
        self.colours.clock();
        match self.colours.take_fault() {
            Some(kind) => {
                let fault = Fault { path: "colours".to_string(), cycle: self.cycle, kind };
                self.fault(&fault)
            }
            None => Ok(()),
        }
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        let Due { write, blended, done } = self.due[1];
        let all = self.sent == self.items.len() && write.is_none() && !blended && !done;
        (!all).then_some(Step { come: true, reset: false })
    }
    fn choices(&self) -> Vec<Step> {
        let step = |(come, reset)| Step { come, reset };
        [(false, false), (true, false), (false, true)].map(step).to_vec()
    }
    fn known(&self, to: &mut Vec<u64>) {
        to.push(self.sent as u64);
        (0..PIXELS).for_each(|k| self.colours.peek(k, to));
        self.colours.under_way(to);
        let Due { blended, done, .. } = self.due[1];
        to.extend([
            u64::from(self.so_far.unwrap_or(u32::MAX)),
            u64::from(blended),
            u64::from(done),
        ]);
    }
    fn outputs((): &(), out: Option<&Out>) -> Out {
        out.copied().unwrap_or_default()
    }
    fn tell(&self, inputs: &In) -> Vec<String> {
        let Stream { valid, payload: Marked { end, item } } = inputs.sorted;
        let last = if item.last { ", the last" } else { "" };
        match (valid, end) {
            (false, _) => vec![],
            (true, true) => vec!["the end comes".to_string()],
            (true, false) => vec![format!("{:08x} of pixel {} comes{last}", item.rgba, item.pixel)],
        }
    }
}

/// A pixel in words.
fn pixel(pixel: Option<u32>) -> String {
    pixel.map_or("nothing".to_string(), |pixel| format!("pixel {pixel}"))
}

impl<B> Model<B> {
    /// The colour that the memory has of a pixel.
    fn colour(&self, pixel: u32) -> u32 {
        let mut values = vec![];
        self.colours.peek(pixel, &mut values);
        values[0] as u32
    }
}

/// A frame as it is sent.
fn sent(frame: &[Pixel]) -> impl Iterator<Item = Marked<Sorted>> {
    let fragments = frame.iter().flat_map(|(pixel, layers)| {
        layers.iter().enumerate().map(move |(k, rgba)| {
            let last = k + 1 == layers.len();
            let label = Label::new(k as u32, *pixel as u16, 0);
            Marked::item(Sorted { pixel: *pixel, rgba: *rgba, last, label })
        })
    });
    fragments.chain([Marked::end()])
}

/// Tests of everything that the contract of a blender asks for: `blender_properties!(MyBlender)`, or with a
/// name for the module that they stand in, `blender_properties!(MyBlender, mine)`.
#[macro_export]
macro_rules! blender_properties {
    ($blender:ty) => {
        $crate::blender_properties!($blender, blender_properties);
    };
    ($blender:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::blender::Model<$blender>, $name $(, $states)?);
    };
}
