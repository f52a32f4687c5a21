//! The contract of a depth sorter, see [`mod@pellucid_blocks::sorter`], as properties.
//!
//! Frames of random pixels are sent, each pixel in as many passes as its visible fragments need, and a
//! stable sort says what must leave. A sequence says for every cycle whether the next fragment is offered,
//! whether the receiver is ready, and whether the sorter is reset; behind it all is sent and taken.

use crate::reference::{Judged, Long, Reference};
use crate::stream::{Step, StreamDriver};
use pellucid_blocks::blender::Sorted;
use pellucid_blocks::sorter::{Config, In, MAX_DEPTH, Moore};
use pellucid_machine::pixel::{Arrived, Marked};
use pellucid_sim::{Block, Fault, Label, Registers, Stream, bits_for};
use proptest::prelude::*;
use std::cmp::Reverse;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

/// What can be tested: a block with the ports of [`pellucid_blocks::sorter::Sorter`].
pub trait Sorts:
    Block<Config = Config, State: Registers<Config = Config>, In = In, Moore = Moore, Out = ()>
    + 'static
{
}

impl<B> Sorts for B where
    B: Block<Config = Config, State: Registers<Config = Config>, In = In, Moore = Moore, Out = ()>
        + 'static
{
}

/// A fragment that is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Its depth.
    pub z: u32,
    /// It is in front of the opaque depth.
    pub visible: bool,
}

/// The fragments of a pixel, from the oldest to the newest, at least one.
pub type Pixel = Vec<Layer>;

/// What is fixed while a sequence is played.
#[derive(Clone, Debug)]
pub struct Setup {
    /// K: fragments sorted in one pass.
    pub depth: u32,
    /// A pixel's fragments are sent from the newest to the oldest.
    pub newest_first: bool,
    /// Frames, each of so many pixels.
    pub frames: Vec<Vec<Pixel>>,
}

/// `K = 2, frame [5 3] [7 hidden], frame`
impl fmt::Display for Setup {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "K = {}", self.depth)?;
        if self.newest_first {
            f.write_str(", newest first")?;
        }
        for frame in &self.frames {
            f.write_str(", frame")?;
            for pixel in frame {
                let layer = |layer: &Layer| {
                    let hidden = if layer.visible { "" } else { " hidden" };
                    format!("{}{hidden}", layer.z)
                };
                let layers: Vec<String> = pixel.iter().map(layer).collect();
                write!(f, " [{}]", layers.join(" "))?;
            }
        }
        Ok(())
    }
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// What leaves is held until it is taken.
    Held,
    /// A pixel's fragments leave far to near.
    Order,
    /// Those of one depth leave from the oldest to the newest.
    Ties,
    /// Each visible fragment leaves once, its pixel's before the next one's, and nothing else does.
    Once,
    /// Nothing leaves before its pass is complete.
    Early,
    /// The nearest of a pixel is marked as its last, and no other.
    Last,
    /// The end of a frame leaves behind all its fragments.
    End,
    /// While the receiver is ready, all goes on.
    Stuck,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Held => "what leaves is held until it is taken",
            Property::Order => "a pixel's fragments leave far to near",
            Property::Ties => "fragments of one depth leave from the oldest to the newest",
            Property::Once => "each visible fragment leaves once, pixel by pixel, and nothing else",
            Property::Early => "nothing leaves before its pass is complete",
            Property::Last => "the nearest of a pixel is marked as its last, and no other",
            Property::End => "the end of a frame leaves behind all its fragments",
            Property::Stuck => "while the receiver is ready, all goes on within K + 2 cycles",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// What leaves, without what has no meaning.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Leaves(Marked<Sorted>);

impl Leaves {
    fn of(sorted: Stream<Marked<Sorted>>) -> Stream<Leaves> {
        let Marked { end, item } = sorted.payload;
        let item = Sorted { label: Label::NONE, ..item };
        let payload = Leaves(if end { Marked::end() } else { Marked::item(item) });
        Stream { valid: sorted.valid, payload }
    }
}

/// In words.
impl fmt::Debug for Leaves {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Marked { end, item } = self.0;
        match (end, item.last) {
            (true, _) => f.write_str("the end"),
            (false, false) => f.write_str(&place(item.rgba)),
            (false, true) => write!(f, "{} (last)", place(item.rgba)),
        }
    }
}

/// What must leave.
struct Due {
    leaves: Leaves,
    z: u32,
}

/// What a sorter is held to.
pub struct Model<S> {
    depth: u32,
    newest_first: bool,
    ends: StreamDriver<Marked<Arrived>, Leaves>,
    /// All that must leave, in order.
    due: Vec<Due>,
    /// How many of them can have left once so many items were taken.
    complete: Vec<usize>,
    sorter: PhantomData<S>,
}

/// Pixels of the screen, and the most of a frame.
const PIXELS: u32 = 64;
/// Bits of how many fragments a pixel may have.
const LAYER_BITS: u32 = 10;

/// A colour that no other fragment has: its place in the frames.
fn colour(frame: usize, pixel: usize, layer: usize) -> u32 {
    (frame << 24 | pixel << 16 | layer) as u32
}

/// A colour as the place that it stands for.
fn place(rgba: u32) -> String {
    format!("fragment {} of pixel {}", rgba & 0xffff, rgba >> 16 & 0xff)
}

impl<S> Model<S> {
    /// Sends a pixel, in `ceil(visible / K)` passes and at least one.
    fn pixel(
        &mut self,
        frame: usize,
        pixel: usize,
        layers: &Pixel,
        items: &mut Vec<Marked<Arrived>>,
    ) {
        let mut order: Vec<usize> = (0..layers.len()).filter(|k| layers[*k].visible).collect();
        order.sort_by_key(|k| Reverse(layers[*k].z));
        let passes = order.len().div_ceil(self.depth as usize).max(1);
        for pass in 0..passes {
            for at in 0..layers.len() {
                let k = if self.newest_first { layers.len() - 1 - at } else { at };
                let Layer { z, visible } = layers[k];
                self.complete.push(self.due.len());
                items.push(Marked::item(Arrived {
                    pixel: pixel as u32,
                    z,
                    rgba: colour(frame, pixel, k),
                    weight: 0,
                    visible,
                    last: at + 1 == layers.len(),
                    last_pass: pass + 1 == passes,
                    label: Label::new(k as u32, pixel as u16, 0),
                }));
            }
            let first = pass * self.depth as usize;
            let leave = order.iter().enumerate().skip(first).take(self.depth as usize);
            self.due.extend(leave.map(|(at, &k)| {
                let (rgba, last) = (colour(frame, pixel, k), at + 1 == order.len());
                let item = Sorted { pixel: pixel as u32, rgba, last, label: Label::NONE };
                Due { leaves: Leaves(Marked::item(item)), z: layers[k].z }
            }));
        }
    }

    /// What is wrong with what leaves.
    fn wrong(&self, came: Leaves) -> Judged<Property> {
        let given = self.ends.given;
        let due = self.due.get(given);
        let is_complete = given < self.complete[self.ends.sent];
        let Marked { end, item } = came.0;
        let place = |due: &Due| !due.leaves.0.end && !end && due.leaves.0.item.rgba == item.rgba;
        let at = self.due.iter().position(place);
        let property = match (due, at) {
            (Some(due), _) if due.leaves == came && is_complete => return Ok(()),
            _ if end => Property::End,
            (_, None) => Property::Once,
            (_, Some(at)) if at < given => Property::Once,
            (None, _) => Property::Once,
            (Some(due), _) if due.leaves.0.end => Property::End,
            (Some(due), Some(at)) => {
                let due_item = due.leaves.0.item;
                // The upper half of a colour is the pixel that it was sent for.
                let pixel = item.pixel == due_item.pixel && item.rgba >> 16 == due_item.rgba >> 16;
                match (at == given, self.due[at].z == due.z) {
                    _ if !pixel => Property::Once,
                    (true, _) if item.last != due_item.last => Property::Last,
                    (true, _) => Property::Early,
                    (false, true) => Property::Ties,
                    (false, false) => Property::Order,
                }
            }
        };
        let due = due.map_or("nothing".to_string(), |due| format!("{:?}", due.leaves));
        let early = if is_complete { "" } else { ", once all of its pass have come" };
        Err((property, format!("{came:?} came where {due} is due{early}")))
    }
}

/// So many frames of up to seven pixels.
fn frames(number: Range<usize>) -> BoxedStrategy<Setup> {
    let length = prop_oneof![5 => 1usize..6, 2 => 6usize..20, 1 => 20usize..70];
    let layer = (0u32..5, prop::bool::weighted(0.8));
    let layer = layer.prop_map(|(z, visible)| Layer { z, visible });
    let layers = length.prop_flat_map(move |n| proptest::collection::vec(layer.clone(), n));
    let frame = proptest::collection::vec(layers, 0..8);
    let depth = prop_oneof![6 => 1u32..9, 1 => Just(MAX_DEPTH as u32)];
    (depth, any::<bool>(), proptest::collection::vec(frame, number))
        .prop_map(|(depth, newest_first, frames)| Setup { depth, newest_first, frames })
        .boxed()
}

impl<S: Sorts> Reference for Model<S> {
    type Block = S;
    type Config = Config;
    type Setup = Setup;
    type Step = Step;
    type Property = Property;
    type Outputs = Moore;
    const NAME: &'static str = "sorter";

    fn setups() -> BoxedStrategy<Setup> {
        frames(1..3)
    }
    fn long() -> Vec<Long<Self>> {
        // Each fragment that leaves is looked for among all, which is why there are no more.
        vec![Long { setup: frames(200..256), step: Step::often(), steps: 20_000 }]
    }
    fn steps(_: &Setup) -> BoxedStrategy<Step> {
        Step::any()
    }
    /// Frames of up to three fragments of two depths, and two frames of one.
    fn small() -> Vec<Setup> {
        let layer = |code: u32| Layer { z: code & 1, visible: code & 2 == 0 };
        let mut setups = vec![];
        for (layers, depth) in [(0, 1), (1, 1), (2, 1), (2, 2), (3, 1), (3, 2)] {
            for code in 0..1u32 << (2 * layers) {
                let all: Pixel = (0..layers).map(|k| layer(code >> (2 * k) & 3)).collect();
                if layers == 3 && all.iter().any(|layer| !layer.visible) {
                    continue;
                }
                for cuts in 0..1u32 << (layers.max(1) - 1) {
                    let mut frame: Vec<Pixel> = vec![];
                    for (k, layer) in all.iter().enumerate() {
                        match frame.last_mut() {
                            Some(pixel) if cuts >> (k - 1) & 1 == 0 => pixel.push(*layer),
                            _ => frame.push(vec![*layer]),
                        }
                    }
                    let frames = vec![frame];
                    for newest_first in [false, true] {
                        let frames = frames.clone();
                        setups.push(Setup { depth, newest_first, frames });
                    }
                }
            }
        }
        let one = vec![vec![layer(0)]];
        setups.push(Setup { depth: 1, newest_first: false, frames: vec![one.clone(), one] });
        setups
    }
    fn told(setup: &Setup) -> String {
        setup.to_string()
    }
    fn config(setup: &Setup) -> Config {
        let pixel_bits = bits_for(u64::from(PIXELS - 1));
        let Setup { depth, newest_first, .. } = *setup;
        Config { depth, pixel_bits, layer_bits: LAYER_BITS, newest_first }
    }
    fn new(setup: &Setup) -> Model<S> {
        let (due, complete, sorter) = (vec![], vec![], PhantomData);
        let ends = StreamDriver::new(vec![]);
        let Setup { depth, newest_first, .. } = *setup;
        let mut model = Model { depth, newest_first, ends, due, complete, sorter };
        let mut items = vec![];
        for (number, frame) in setup.frames.iter().enumerate() {
            for (pixel, layers) in frame.iter().enumerate() {
                model.pixel(number, pixel, layers, &mut items);
            }
            model.complete.push(model.due.len());
            model.due.push(Due { leaves: Leaves(Marked::end()), z: 0 });
            items.push(Marked::end());
        }
        model.complete.push(model.due.len());
        model.ends = StreamDriver::new(items);
        model
    }

    fn look(&mut self, _: u64, seen: &Moore) -> Judged<Property> {
        let given = Leaves::of(seen.sorted);
        self.ends.held(given).map_err(|seen| (Property::Held, seen))?;
        if given.valid {
            self.wrong(given.payload)?;
        }
        if self.ends.still > self.depth + 2 {
            return Err((Property::Stuck, format!("nothing moves for {} cycles", self.ends.still)));
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, seen: &Moore) -> Option<In> {
        if step.reset {
            self.ends.reset();
            return None;
        }
        let more = self.ends.given < self.complete[self.ends.sent];
        let arrived = self.ends.cycle(*step, seen.ready, Leaves::of(seen.sorted), more);
        Some(In { arrived, sorted_ready: step.ready })
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        (self.ends.given < self.due.len()).then_some(Step::MOVES)
    }
    fn choices(&self) -> Vec<Step> {
        Step::all()
    }
    fn known(&self, to: &mut Vec<u64>) {
        self.ends.known(to);
    }
    fn outputs(seen: &Moore, _: Option<&()>) -> Moore {
        *seen
    }
    fn tell(&self, inputs: &In) -> Vec<String> {
        let Stream { valid, payload: Marked { end, item } } = inputs.arrived;
        let mut what = vec![];
        if valid && end {
            what.push("the end is offered".to_string());
        } else if valid {
            let hidden = if item.visible { "" } else { ", hidden" };
            let last = if item.last { ", last of its pass" } else { "" };
            what.push(format!("{} (depth {}{hidden}{last}) is offered", place(item.rgba), item.z));
        }
        what.extend(inputs.sorted_ready.then(|| "ready".to_string()));
        what
    }
}

/// Tests of everything that the contract of a sorter asks for: `sorter_properties!(MySorter)`, or with a name
/// for the module that they stand in, `sorter_properties!(MySorter, mine)`.
#[macro_export]
macro_rules! sorter_properties {
    ($sorter:ty) => {
        $crate::sorter_properties!($sorter, sorter_properties);
    };
    ($sorter:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::sorter::Model<$sorter>, $name $(, $states)?);
    };
}
