//! The contract of a prefix sum over counters, see [`pellucid_blocks::array::prefix_sum`], as properties.
//!
//! Frames of counters are summed up, each in as many bands as the buffer's slots ask for. A sequence says for every cycle whether
//! a band begins, and, between bands, which pixel's sum and which place of the list of words is read, by whom. Beside the block
//! stands the memory of the counters; a plain sum says what must come of them, and a closed form when. Behind the last cycle the
//! band is summed up and all of it is read.

mod due;

use crate::reference::{Judged, Long, Reference};
use due::Due;
use pellucid_blocks::array::config::{Band, Config, MAX_LANES, Shape};
use pellucid_blocks::array::counters::Counts;
use pellucid_blocks::array::prefix_sum::{In, Moore, Out, PrefixSum};
use pellucid_machine::pixel::Screen;
use pellucid_sim::{Block, Fault, Read, ReadPort, Registers};
use proptest::prelude::*;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

/// What can be tested: a block with the ports of [`PrefixSum`].
pub trait Sums:
    Block<Config = Config, State: Registers<Config = Config>, In = In, Moore = Moore, Out = Out>
    + 'static
{
    /// Cycles from the start of a band to the one in which it is done: from the band's first word on there are so many `words`,
    /// of which so many are `gone_over`, up to the one in which the band ends.
    fn cycles(cfg: &Config, words: u32, gone_over: u32) -> u32;
}

impl Sums for PrefixSum {
    /// All sweeps but the last go over all words, and each takes one more cycle.
    fn cycles(cfg: &Config, words: u32, gone_over: u32) -> u32 {
        (cfg.sweeps(words) - 1) * (words + 1) + gone_over + 1
    }
}

/// What is fixed while a sequence is played.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The arrays.
    pub cfg: Config,
    /// The counters of each frame, a number for each pixel; after the last comes the first again.
    pub frames: Vec<Vec<u32>>,
}

/// Who reads sums between bands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum User {
    /// What stores fragments.
    Index,
    /// What reads them back.
    Walk,
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The next band is summed up, unless one is.
    pub start: bool,
    /// Between bands, where none begins: the sum of this pixel of the band is read, counted round.
    pub sum: Option<(User, u8)>,
    /// So is this place of the list of words.
    pub place: Option<u8>,
    /// All is reset instead: the next frame comes.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A band is done after the stated cycles.
    Cycles,
    /// A band goes up to the first pixel whose end lies beyond the slots.
    Band,
    /// What the band takes is told.
    Slots,
    /// The sum of a pixel is that of the pixels before it in its band, and of itself where slots are counted down.
    Sum,
    /// The list has the words of the band that have a fragment.
    List,
    /// Counters are cleared that come again or have no slot, and no other.
    Cleared,
    /// Words are asked for that there are.
    Range,
    /// What is read is shown in the next cycle.
    Valid,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Cycles => "a band is done after the stated cycles, and only then",
            Property::Band => "a band goes up to the first pixel whose end lies beyond the slots",
            Property::Slots => "how many slots the band takes is told",
            Property::Sum => "a pixel has the sum of those before it in its band",
            Property::List => "the list has the words of the band that have a fragment, in order",
            Property::Cleared => "counters are cleared that are counted again or have no slot",
            Property::Range => "counters are asked for that there are",
            Property::Valid => "what is read is shown in the cycle after",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// A plain sum, beside the memory of the counters.
pub struct Model<S> {
    setup: Setup,
    /// Which frame is summed up.
    frame: usize,
    counters: Vec<u64>,
    /// The word of counters that was asked for.
    word: Option<u32>,
    /// The band at hand or done; without counters where there is none of the frame yet.
    due: Due,
    /// Cycles since its start, while it is summed up.
    since: Option<u32>,
    /// It is done, to be looked at.
    done: bool,
    /// The slots that were told last.
    slots: u64,
    /// The pixel whose sum, and the place in the list, that were read in the cycle before.
    sum: Option<u32>,
    place: Option<u32>,
    /// Pixels and places that were read one after the other since.
    checked: (u32, u32),
    block: PhantomData<S>,
}

impl<S: Sums> Model<S> {
    /// A band begins: the frame's next, or the next frame's first.
    fn begin(&mut self) {
        let Config { shape, screen, .. } = self.setup.cfg;
        let mut from = self.due.pixels.end;
        if self.is_begun() && (from == screen.pixels() || !shape.bands) {
            self.next_frame();
            from = 0;
        }
        self.due = Due::of(&self.setup.cfg, &self.counters, from);
        (self.since, self.done, self.slots, self.checked) = (Some(0), false, 0, (0, 0));
    }

    fn next_frame(&mut self) {
        self.frame = (self.frame + 1) % self.setup.frames.len();
        self.counters = self.setup.frames[self.frame].iter().map(|n| u64::from(*n)).collect();
    }

    /// Cycles until the band is done.
    fn cycles(&self) -> u32 {
        let cfg = &self.setup.cfg;
        let words = cfg.words() - self.due.pixels.start / cfg.shape.lanes;
        S::cycles(cfg, words, self.due.gone_over)
    }

    /// No band is summed up.
    fn is_idle(&self) -> bool {
        self.since.is_none()
    }
    /// One was of this frame, or is.
    fn is_begun(&self) -> bool {
        !self.due.counters.is_empty()
    }

    /// What is wrong with what is shown of what was read.
    fn shown(&self, seen: &Moore) -> Judged<Property> {
        let cfg = &self.setup.cfg;
        if let Some(pixel) = self.sum {
            let Read { valid, data } = seen.sums;
            let due = self.due.sums[(pixel - self.due.pixels.start) as usize];
            let is = u64::from(data.of[cfg.lane_of(pixel) as usize]);
            if !valid {
                return Err((Property::Valid, format!("the sum of pixel {pixel} is not shown")));
            }
            if is != due {
                let seen = format!("pixel {pixel} has {is} where {due} is due");
                return Err((Property::Sum, seen));
            }
        }
        if let Some(place) = self.place {
            let due = self.due.listed[place as usize];
            let Read { valid, data } = seen.word;
            if !valid {
                return Err((Property::Valid, format!("place {place} is not shown")));
            }
            if data != due {
                let seen = format!("word {data} is in place {place} where {due} is due");
                return Err((Property::List, seen));
            }
        }
        Ok(())
    }

    /// What is wrong with a band that is just done.
    fn wrong(&self, seen: &Moore) -> Judged<Property> {
        let Band { from, to } = seen.band;
        let Range { start, end } = self.due.pixels;
        if (from, to) != (start, end) {
            let seen = format!("it is that from {from} to {to} where {start} to {end} is due");
            return Err((Property::Band, seen));
        }
        if self.slots != self.due.slots {
            let seen = format!("{} are told where {} are due", self.slots, self.due.slots);
            return Err((Property::Slots, seen));
        }
        let listed = self.due.listed.len();
        if seen.occupied as usize != listed {
            let seen = format!("{} are listed where {listed} are due", seen.occupied);
            return Err((Property::List, seen));
        }
        let differs = |pixel: &usize| self.counters[*pixel] != self.due.counters[*pixel];
        if let Some(pixel) = (0..self.counters.len()).find(differs) {
            let (is, due) = (self.counters[pixel], self.due.counters[pixel]);
            let seen = format!("that of pixel {pixel} is {is} where {due} is due");
            return Err((Property::Cleared, seen));
        }
        Ok(())
    }
}

/// Arrays on a screen of so many pixels in a row, with so many slots.
fn config(pixels: u32, lanes: u32, [down, sweeps, bands]: [bool; 3], slots: u32) -> Config {
    let screen = Screen { width: pixels, height: 1, background: 0 };
    let shape = Shape {
        lanes,
        count_bits: 3,
        down,
        sweeps,
        bands,
        on_chip: slots,
        outside: 0,
        outside_latency: 1,
        reads_in_flight: 2,
        depth: 1,
        fixed: 0,
        cached: None,
        pixels_ahead: false,
    };
    Config::new(screen, shape)
}

/// Frames of such arrays, their counters up to their limit.
fn setups(pixels: Range<u32>, slots: Range<u32>) -> BoxedStrategy<Setup> {
    let lanes = (0..=MAX_LANES.ilog2()).prop_map(|bits| 1 << bits);
    let cfg = (pixels, lanes, any::<[bool; 3]>(), slots);
    let cfg = cfg.prop_map(|(pixels, lanes, flags, slots)| config(pixels, lanes, flags, slots));
    cfg.prop_flat_map(|cfg| {
        let count = prop_oneof![Just(0), 0..=cfg.limit()];
        let frame = proptest::collection::vec(count, cfg.screen.pixels() as usize);
        proptest::collection::vec(frame, 1..3).prop_map(move |frames| Setup { cfg, frames })
    })
    .boxed()
}

/// A band begins this often, while none is summed up.
fn step(start: f64, reset: f64) -> BoxedStrategy<Step> {
    let user = prop::sample::select(vec![User::Index, User::Walk]);
    let sum = prop::option::weighted(0.7, (user, any::<u8>()));
    let rare = prop::bool::weighted;
    (rare(start), sum, any::<Option<u8>>(), rare(reset))
        .prop_map(|(start, sum, place, reset)| Step { start, sum, place, reset })
        .boxed()
}

impl<S: Sums> Reference for Model<S> {
    type Block = S;
    type Config = Config;
    type Setup = Setup;
    type Step = Step;
    type Property = Property;
    type Outputs = Moore;
    const NAME: &'static str = "prefix_sum";

    fn setups() -> BoxedStrategy<Setup> {
        setups(1..60, 1..40)
    }
    fn steps(_: &Setup) -> BoxedStrategy<Step> {
        step(0.2, 0.005)
    }
    fn long() -> Vec<Long<Self>> {
        vec![Long { setup: setups(50..70, 20..200), step: step(0.1, 0.0), steps: 20_000 }]
    }
    /// Of three pixels, with counters up to 2, in every way to sum them up.
    fn small() -> Vec<Setup> {
        let mut setups = vec![];
        for flags in 0..8u32 {
            for (lanes, slots) in [(1, 3), (2, 3), (2, 9)] {
                let cfg = config(3, lanes, [0, 1, 2].map(|k| flags >> k & 1 == 1), slots);
                let frames = [[2, 1, 1], [0, 2, 2], [1, 0, 0]].map(|frame| frame.to_vec());
                setups.extend(frames.map(|frame| Setup { cfg, frames: vec![frame] }));
            }
        }
        setups
    }
    fn told(Setup { cfg, frames }: &Setup) -> String {
        let Shape { lanes, down, sweeps, bands, .. } = cfg.shape;
        let said = |is: bool, what| if is { what } else { "" };
        let ways =
            [said(down, ", counted down"), said(sweeps, ", in sweeps"), said(bands, ", in bands")];
        format!("{lanes} in a word, {} slots{}, frames {frames:?}", cfg.slots(), ways.concat())
    }
    fn config(setup: &Setup) -> Config {
        setup.cfg
    }
    fn new(setup: &Setup) -> Self {
        Model {
            setup: setup.clone(),
            frame: 0,
            counters: setup.frames[0].iter().map(|n| u64::from(*n)).collect(),
            word: None,
            due: Due::default(),
            since: None,
            done: false,
            slots: 0,
            sum: None,
            place: None,
            checked: (0, 0),
            block: PhantomData,
        }
    }

    fn look(&mut self, _: u64, seen: &Moore) -> Judged<Property> {
        if std::mem::take(&mut self.done) {
            self.wrong(seen)?;
        }
        self.shown(seen)
    }

    fn inputs(&mut self, step: &Step, _: &Moore) -> Option<In> {
        (self.sum, self.place) = (None, None);
        if step.reset {
            self.next_frame();
            (self.due, self.since, self.word) = (Due::default(), None, None);
            return None;
        }
        let lanes = self.setup.cfg.shape.lanes;
        let mut counts = Read::default();
        if let Some(word) = self.word {
            let first = (word * lanes) as usize;
            let mut of = [0; MAX_LANES];
            let held = self.counters[first..].iter().take(lanes as usize);
            of.iter_mut().zip(held).for_each(|(lane, count)| *lane = *count as u32);
            counts = Read { valid: true, data: Counts { of } };
        }
        let [mut index_read, mut walk_read, mut occupied_read] = [ReadPort::default(); 3];
        let start = self.is_idle() && step.start;
        if let Some(cycles) = &mut self.since {
            *cycles += 1;
        } else if start {
            self.begin();
        } else if self.is_begun() {
            let pixels = self.due.pixels.len() as u32;
            if let Some((user, k)) = step.sum.filter(|_| pixels > 0) {
                let pixel = self.due.pixels.start + u32::from(k) % pixels;
                self.sum = Some(pixel);
                let port = if user == User::Index { &mut index_read } else { &mut walk_read };
                port.read(self.setup.cfg.word_of(pixel));
                let next = self.due.pixels.start + self.checked.0;
                self.checked.0 += u32::from(pixel == next);
            }
            let listed = self.due.listed.len() as u32;
            if let Some(k) = step.place.filter(|_| listed > 0) {
                let place = u32::from(k) % listed;
                self.place = Some(place);
                occupied_read.read(place);
                self.checked.1 += u32::from(place == self.checked.1);
            }
        }
        let (sums, ready) = (Read::default(), true);
        Some(In { start, counts, sums, ready, index_read, walk_read, occupied_read })
    }

    fn judge(&mut self, out: &Out) -> Judged<Property> {
        let words = self.setup.cfg.words();
        let written = out.write.asked();
        let asked = [out.read.asked(), written.map(|(word, _)| word)];
        if let Some(word) = asked.into_iter().flatten().find(|word| *word >= words) {
            return Err((Property::Range, format!("word {word} of {words}")));
        }
        self.word = out.read.asked();
        if let Some((word, Counts { of })) = written {
            let lanes = self.setup.cfg.shape.lanes as usize;
            let held = self.counters[word as usize * lanes..].iter_mut().take(lanes);
            held.zip(of).for_each(|(count, lane)| *count = lane.into());
        }
        if out.slots.valid {
            self.slots = out.slots.payload.into();
        }
        match self.since {
            Some(cycles) if cycles == self.cycles() => {
                if !out.done {
                    return Err((Property::Cycles, format!("not after {cycles}")));
                }
                (self.since, self.done) = (None, true);
            }
            Some(cycles) if out.done => {
                let seen = format!("after {cycles} where {} are due", self.cycles());
                return Err((Property::Cycles, seen));
            }
            None if out.done => {
                return Err((Property::Cycles, "none is summed up".to_string()));
            }
            _ => {}
        }
        Ok(())
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        let (pixels, places) = (self.due.pixels.len() as u32, self.due.listed.len() as u32);
        if !self.is_idle() {
            return Some(Step::default());
        }
        let (pixel, place) = self.checked;
        let sum = (pixel < pixels).then_some((User::Index, pixel as u8));
        let place = (place < places).then_some(place as u8);
        (sum.is_some() || place.is_some()).then_some(Step { sum, place, ..Step::default() })
    }
    fn choices(&self) -> Vec<Step> {
        let reset = Step { reset: true, ..Step::default() };
        if !self.is_idle() {
            return vec![Step::default(), reset];
        }
        let pixels = (0..self.due.pixels.len()).map(|k| Some((User::Walk, k as u8)));
        let places = (0..self.due.listed.len()).map(|k| Some(k as u8));
        let sums = pixels.map(|sum| Step { sum, ..Step::default() });
        let places = places.map(|place| Step { place, ..Step::default() });
        let start = Step { start: true, ..Step::default() };
        sums.chain(places).chain([Step::default(), start, reset]).collect()
    }
    fn known(&self, to: &mut Vec<u64>) {
        to.extend(self.counters.iter().copied());
        to.extend([self.due.pixels.start, self.due.pixels.end].map(u64::from));
        let numbers = [self.since, self.word, self.sum, self.place];
        to.extend(numbers.map(|number| number.map_or(0, |number| u64::from(number) + 1)));
        let (pixel, place) = self.checked;
        let flags = u64::from(self.done) | u64::from(self.is_begun()) << 1;
        to.extend([self.frame as u64, self.slots, pixel.into(), place.into(), flags]);
    }
    fn outputs(seen: &Moore, _: Option<&Out>) -> Moore {
        *seen
    }
    fn tell(&self, i: &In) -> Vec<String> {
        let mut what = vec![];
        what.extend(i.start.then(|| "start".to_string()));
        what.extend(self.sum.map(|pixel| format!("read the sum of pixel {pixel}")));
        what.extend(self.place.map(|place| format!("read place {place}")));
        what
    }
}

/// Tests of everything that the contract of a prefix sum asks for: `prefix_sum_properties!(MyPrefixSum)`, or with a name for the
/// module that they stand in, `prefix_sum_properties!(MyPrefixSum, mine)`.
#[macro_export]
macro_rules! prefix_sum_properties {
    ($sum:ty) => {
        $crate::prefix_sum_properties!($sum, prefix_sum_properties);
    };
    ($sum:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::prefix_sum::Model<$sum>, $name $(, $states)?);
    };
}
