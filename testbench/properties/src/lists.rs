//! The contract of lists of pages, see [`pellucid_blocks::chains`] where new sections go to the head of a chain
//! ([`Link::Head`](pellucid_blocks::chains::config::Link::Head)), as properties: what is read back is what was stored, the newest first, in as few pages as hold it.
//!
//! Frames are played, each with a limit of its own of pages that may be used. Some are resolved, beside a memory of opaque depths;
//! the others are given up once they are stored, as those are that come again with more pages. A sequence says for every cycle
//! whether the next fragment is offered, whether the receiver is ready, and whether all is reset. Behind it all frames are played.

mod frames;

pub use frames::{Layer, Play, Setup};

use crate::reference::{Judged, LONG, Long, Reference};
use crate::stream::{Step, StreamDriver};
use pellucid_blocks::allocator::Bump;
use pellucid_blocks::chains::config::Config;
use pellucid_blocks::chains::{Chains, Events, In, Moore, Out};
use pellucid_machine::outside;
use pellucid_machine::pixel::{Arrived, Marked, PixelFragment};
use pellucid_sim::{Block, Fault, Label, Read, Registers, Stream};
use proptest::prelude::*;
use std::fmt;
use std::marker::PhantomData;

/// What can be tested: a block with the ports of [`Chains`].
pub trait Lists:
    Block<Config = Config, State: Registers<Config = Config>, In = In, Moore = Moore, Out = Out>
    + 'static
{
    /// The most cycles in a row in which nothing moves, while something is offered or due and the receiver is ready.
    fn latency(cfg: &Config) -> u32;
}

impl Lists for Chains<Bump> {
    /// Pixels without fragments may be looked at one by one.
    fn latency(cfg: &Config) -> u32 {
        cfg.screen.pixels() + 20
    }
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A fragment is dropped where it needs a page beyond the limit, and only there; each is told once, in order.
    Dropped,
    /// A frame is stored once all its fragments are stored or dropped.
    Stored,
    /// As many pages are asked for as the lists need: a new one where all of a pixel's are full.
    Pages,
    /// What is given is held until it is taken.
    Held,
    /// A pixel's fragments come from the newest to the oldest.
    Order,
    /// Each stored fragment comes once in each of its pixel's passes, pixel by pixel, then the end, and nothing else.
    Once,
    /// What is hidden, what is the last of its pass and what of its pixel are marked.
    Marks,
    /// A frame is done once it is written, and its pages are back.
    Done,
    /// While the receiver is ready, all goes on.
    Stuck,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Dropped => {
                "a fragment is dropped that needs a page beyond the limit, and no other"
            }
            Property::Stored => "a frame is stored once each fragment is stored or dropped",
            Property::Pages => "as many pages are asked for as the lists need",
            Property::Held => "what is given is held until it is taken",
            Property::Order => "a pixel's fragments come from the newest to the oldest",
            Property::Once => {
                "each stored fragment comes once in a pass, pixel by pixel, then the end"
            }
            Property::Marks => "what is hidden, last of its pass and of its pixel is marked",
            Property::Done => "a frame is done once it is written",
            Property::Stuck => "while the receiver is ready, all goes on within the latency",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// What comes, without what has no meaning.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Comes(Marked<Arrived>);

impl Comes {
    fn of(Marked { end, item }: Marked<Arrived>) -> Comes {
        if end {
            return Comes(Marked::end());
        }
        let Arrived { pixel, z, rgba, visible, last, last_pass, .. } = item;
        let last_pass = last && last_pass;
        let (z, rgba) = if visible { (z, rgba) } else { (0, 0) };
        let marks = Arrived { visible, last, last_pass, ..Arrived::default() };
        Comes(Marked::item(Arrived { pixel, z, rgba, label: Label::NONE, ..marks }))
    }
}

/// In words.
impl fmt::Debug for Comes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Marked { end, item } = self.0;
        if end {
            return f.write_str("the end");
        }
        if item.visible {
            f.write_str(&place(item.rgba))?;
        } else {
            write!(f, "a hidden one of pixel {}", item.pixel)?;
        }
        f.write_str(match (item.last, item.last_pass) {
            (false, _) => "",
            (true, false) => " (last of its pass)",
            (true, true) => " (last)",
        })
    }
}

/// A colour that no other fragment of the frame has: its pixel, and how many that had before.
fn colour(pixel: u32, before: usize) -> u32 {
    pixel << 16 | before as u32
}

/// A colour as the place that it stands for.
fn place(rgba: u32) -> String {
    format!("fragment {} of pixel {}", rgba & 0xffff, rgba >> 16)
}

/// What is at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Heads are cleared, of which this one is next: after reset, and of a frame that is given up.
    Clear(u32),
    /// Fragments come.
    Store,
    /// They begin to be read back.
    Begin,
    /// They are read back.
    Resolve,
    /// The end has come, and the last pixel is written in a while.
    Write,
    /// All frames are played.
    Over,
}

/// A plain list for each pixel.
pub struct Model<L> {
    setup: Setup,
    latency: u32,
    /// The frame at hand.
    play: usize,
    phase: Phase,
    ends: StreamDriver<Marked<PixelFragment>, Comes>,
    /// Each fragment of the frame: whether it is dropped, and how many pages are asked for after it.
    stored: Vec<(bool, u32)>,
    /// How many of them are told to be stored or dropped.
    told: usize,
    /// All that must come.
    due: Vec<Comes>,
    /// The depth that was asked for last.
    depth: Read<u32>,
    /// What is cleared is taken in this cycle, or the last pixel written.
    goes_on: bool,
    /// What is offered, and whether the receiver is ready.
    told_of: (Stream<Marked<PixelFragment>>, bool),
    block: PhantomData<L>,
}

impl<L: Lists> Model<L> {
    /// The next frame comes, if there is one.
    fn begin(&mut self) {
        (self.stored, self.due, self.told) = (vec![], vec![], 0);
        self.ends = StreamDriver::new(vec![]);
        let Some(Play { limit, layers, .. }) = self.setup.plays.get(self.play) else {
            self.phase = Phase::Over;
            return;
        };
        self.phase = Phase::Store;
        let cfg = &self.setup.cfg;
        let pixels = cfg.screen.pixels() as usize;
        let (mut lists, mut had) = (vec![vec![]; pixels], vec![0; pixels]);
        let (mut taken, mut asked, mut items) = (0, 0, vec![]);
        for Layer { pixel, z } in layers {
            let list = &mut lists[*pixel as usize];
            let rgba = colour(*pixel, had[*pixel as usize]);
            had[*pixel as usize] += 1;
            let full = list.len().is_multiple_of(cfg.shape.capacity as usize);
            let dropped = full && taken == *limit;
            asked += u32::from(full);
            taken += u32::from(full && !dropped);
            if !dropped {
                list.push((*z, rgba));
            }
            self.stored.push((dropped, asked.min(cfg.null)));
            let item = PixelFragment { pixel: *pixel, z: *z, rgba, label: Label::NONE };
            items.push(Marked::item(item));
        }
        items.push(Marked::end());
        for ((pixel, list), depth) in (0..).zip(&lists).zip(&self.setup.depths) {
            let visible = list.iter().filter(|(z, _)| z < depth).count() as u32;
            let passes =
                if list.is_empty() { 0 } else { visible.div_ceil(cfg.pass_depth()).max(1) };
            for pass in 1..=passes {
                self.due.extend(list.iter().enumerate().rev().map(|(at, (z, rgba))| {
                    Comes::of(Marked::item(Arrived {
                        pixel,
                        z: *z,
                        rgba: *rgba,
                        visible: z < depth,
                        last: at == 0,
                        last_pass: pass == passes,
                        ..Arrived::default()
                    }))
                }));
            }
        }
        self.due.push(Comes(Marked::end()));
        self.ends = StreamDriver::new(items);
    }

    /// Pages that were asked for, where that is known: all fragments are stored, or none are there.
    fn asked(&self) -> Option<u32> {
        match self.phase {
            Phase::Clear(_) => None,
            Phase::Store if self.told < self.stored.len() => None,
            _ => Some(self.stored.last().map_or(0, |(_, asked)| *asked)),
        }
    }

    /// A fragment is told to be stored or dropped.
    fn tell_stored(&mut self, events: Events) -> Judged<Property> {
        let told = [events.stored, events.dropped];
        if told == [false; 2] {
            return Ok(());
        }
        let k = self.told;
        let due = self.stored.get(k).filter(|_| k < self.ends.sent);
        if due.map(|(dropped, _)| [!dropped, *dropped]) != Some(told) {
            let seen = match told {
                [true, true] => "stored and dropped",
                [true, false] => "stored",
                _ => "dropped",
            };
            return Err((Property::Dropped, format!("fragment {k} of the frame is {seen}")));
        }
        self.told += 1;
        Ok(())
    }

    /// What is wrong with what comes.
    fn wrong(&self, came: Comes) -> Judged<Property> {
        let due = if self.phase == Phase::Resolve { self.due.get(self.ends.given) } else { None };
        let item = came.0.item;
        let is = |due: &Comes| due.0.item.rgba == item.rgba;
        let property = match due {
            Some(due) if *due == came => return Ok(()),
            Some(due) if due.0.end || came.0.end => Property::Once,
            Some(due) if item.pixel != due.0.item.pixel => Property::Once,
            Some(due) if !item.visible || !due.0.item.visible || is(due) => Property::Marks,
            Some(_) if self.due.iter().any(is) => Property::Order,
            _ => Property::Once,
        };
        let due = due.map_or("nothing".to_string(), |due| format!("{due:?}"));
        Err((property, format!("{came:?} came where {due} is due")))
    }
}

/// What is given.
fn given(seen: &Moore) -> Stream<Comes> {
    Stream { valid: seen.arrived.valid, payload: Comes::of(seen.arrived.payload) }
}

impl<L: Lists> Reference for Model<L> {
    type Block = L;
    type Config = Config;
    type Setup = Setup;
    type Step = Step;
    type Property = Property;
    type Outputs = Moore;
    const NAME: &'static str = "lists";

    fn setups() -> BoxedStrategy<Setup> {
        frames::setups(1..4, 0..40)
    }
    fn steps(_: &Setup) -> BoxedStrategy<Step> {
        Step::any()
    }
    fn long() -> Vec<Long<Self>> {
        vec![Long { setup: frames::setups(400..500, 0..100), step: Step::often(), steps: LONG }]
    }
    fn small() -> Vec<Setup> {
        frames::small()
    }
    fn told(setup: &Setup) -> String {
        setup.to_string()
    }
    fn config(setup: &Setup) -> Config {
        setup.cfg
    }
    fn new(setup: &Setup) -> Self {
        Model {
            setup: setup.clone(),
            latency: L::latency(&setup.cfg),
            play: 0,
            phase: Phase::Clear(0),
            ends: StreamDriver::new(vec![]),
            stored: vec![],
            told: 0,
            due: vec![],
            depth: Read::default(),
            goes_on: false,
            told_of: (Stream::idle(), false),
            block: PhantomData,
        }
    }

    fn look(&mut self, _: u64, seen: &Moore) -> Judged<Property> {
        let given = given(seen);
        self.ends.held(given).map_err(|seen| (Property::Held, seen))?;
        if given.valid {
            self.wrong(given.payload)?;
        }
        if let Some(due) = self.asked().filter(|due| *due != seen.asked) {
            let seen = format!("{} are asked for where {due} are due", seen.asked);
            return Err((Property::Pages, seen));
        }
        if self.ends.still > self.latency {
            return Err((Property::Stuck, format!("nothing moves for {} cycles", self.ends.still)));
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, seen: &Moore) -> Option<In> {
        if step.reset {
            *self = Model::new(&self.setup);
            return None;
        }
        let more = match self.phase {
            Phase::Store => self.ends.all_taken(),
            Phase::Begin | Phase::Resolve => true,
            Phase::Clear(_) | Phase::Write | Phase::Over => false,
        };
        let fragment = self.ends.cycle(*step, seen.ready, given(seen), more);
        let mut clear = Stream::idle();
        if let Phase::Clear(next) = self.phase {
            clear = Stream::offer(next);
        }
        self.goes_on = match self.phase {
            Phase::Clear(_) => seen.clear_ready,
            Phase::Write => step.offer,
            _ => true,
        };
        self.told_of = (fragment, step.ready);
        Some(In {
            depth_ready: true,
            storing: self.phase == Phase::Store,
            resolving: matches!(self.phase, Phase::Begin | Phase::Resolve | Phase::Write),
            start: self.phase == Phase::Begin,
            limit: self.setup.plays.get(self.play).map_or(0, |play| play.limit),
            fragment,
            depth: self.depth,
            arrived_ready: step.ready,
            written: self.phase == Phase::Write && self.goes_on,
            clear,
            outside: outside::In::default(),
        })
    }

    fn judge(&mut self, out: &Out) -> Judged<Property> {
        self.depth.valid = false;
        if let Some(pixel) = out.depth_read.asked() {
            self.depth = Read { valid: true, data: self.setup.depths[pixel as usize] };
        }
        self.tell_stored(out.wires.events)?;
        let all_told = self.told == self.stored.len() && self.ends.all_taken();
        if out.stored && !(self.phase == Phase::Store && all_told) {
            return Err((Property::Stored, "it is said to be and is not".to_string()));
        }
        let written = self.phase == Phase::Write && self.goes_on;
        if out.done != written {
            let seen = if written { "it is not said" } else { "it is said to be and is not" };
            return Err((Property::Done, seen.to_string()));
        }
        match self.phase {
            Phase::Clear(last) if self.goes_on && last + 1 == self.setup.cfg.screen.pixels() => {
                self.begin();
            }
            Phase::Clear(next) if self.goes_on => self.phase = Phase::Clear(next + 1),
            Phase::Store if out.stored && self.setup.plays[self.play].resolved => {
                self.phase = Phase::Begin;
            }
            Phase::Store if out.stored => {
                self.play += 1;
                self.phase = Phase::Clear(0);
            }
            Phase::Begin => self.phase = Phase::Resolve,
            Phase::Resolve if self.ends.given == self.due.len() => self.phase = Phase::Write,
            Phase::Write if written => {
                self.play += 1;
                self.begin();
            }
            _ => {}
        }
        Ok(())
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        (self.phase != Phase::Over).then_some(Step::MOVES)
    }
    fn choices(&self) -> Vec<Step> {
        Step::all()
    }
    fn known(&self, to: &mut Vec<u64>) {
        self.ends.known(to);
        let phase = match self.phase {
            Phase::Clear(next) => [0, next],
            Phase::Store => [1, 0],
            Phase::Begin => [2, 0],
            Phase::Resolve => [3, 0],
            Phase::Write => [4, 0],
            Phase::Over => [5, 0],
        };
        to.extend(phase.map(u64::from));
        let depth = u64::from(self.depth.data) << 1 | u64::from(self.depth.valid);
        to.extend([self.play as u64, self.told as u64, depth]);
    }
    fn outputs(seen: &Moore, _: Option<&Out>) -> Moore {
        *seen
    }
    fn tell(&self, i: &In) -> Vec<String> {
        let (Stream { valid, payload: Marked { end, item } }, ready) = self.told_of;
        let mut what = vec![];
        what.extend((valid && end).then(|| "the end is offered".to_string()));
        what.extend(
            (valid && !end).then(|| format!("{} (depth {}) is offered", place(item.rgba), item.z)),
        );
        what.extend(ready.then(|| "ready".to_string()));
        what.extend(i.start.then(|| "start".to_string()));
        what.extend(i.written.then(|| "the last pixel is written".to_string()));
        what.extend(i.clear.valid.then(|| format!("clear {}", i.clear.payload)));
        what
    }
}

/// Tests of everything that the contract of lists of pages asks for: `lists_properties!(MyChains)`, or with a name for the module
/// that they stand in, `lists_properties!(MyChains, mine)`.
#[macro_export]
macro_rules! lists_properties {
    ($lists:ty) => {
        $crate::lists_properties!($lists, lists_properties);
    };
    ($lists:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::lists::Model<$lists>, $name $(, $states)?);
    };
}
