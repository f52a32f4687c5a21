//! The contract of what counts fragments, [`pellucid_blocks::array::index`] beside [`pellucid_blocks::array::counters`], as
//! properties: one fragment a cycle, same pixel or not, and counters that stay at their limit.
//!
//! Frames come, each after the one before is counted. A sequence says for every cycle which pixel's fragment comes, whether the
//! frame ends, and, between frames, which word of counters is read and which is cleared, by whom. A plain list of how many
//! fragments each pixel had says what must be read. Behind the last cycle the frame ends and every word is read. After reset all
//! words are cleared, before anything else comes.

mod counted;

pub use counted::{Counted, Counting, In, Mem, Moore, Out, Outputs, Words};

use crate::reference::{Judged, LONG, Long, Reference};
use pellucid_blocks::array::config::{Config, MAX_LANES, Shape};
use pellucid_blocks::array::counters::{self, Counts};
use pellucid_machine::pixel::{Marked, PixelFragment, Screen};
use pellucid_sim::{Fault, ReadPort, Stream, WritePort};
use proptest::prelude::*;
use std::fmt;
use std::marker::PhantomData;

/// Who asks for words between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum User {
    /// What sums them up.
    Sum,
    /// What reads fragments back.
    Walk,
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// A fragment of this pixel comes, counted round.
    pub fragment: Option<u8>,
    /// The frame ends instead.
    pub end: bool,
    /// Between frames, where no fragment comes: this word is read, counted round.
    pub read: Option<(User, u8)>,
    /// So is this one cleared.
    pub clear: Option<(User, u8)>,
    /// All is reset instead.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A fragment is taken in every cycle.
    Ready,
    /// A frame is counted when its end was taken as many cycles ago as is stated, and only then.
    End,
    /// Each fragment that finds its counter below the limit is told as counted, and no other. Looked at where counters are right.
    Counted,
    /// A read shows its word in the next cycle, and only then is one shown.
    Valid,
    /// A counter has how many fragments its pixel had since it was cleared.
    Counts,
    /// A counter that has come to its limit stays there.
    Limit,
    /// A read that meets a write of its word shows what is written.
    Meets,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Ready => "a fragment is taken in every cycle",
            Property::End => "a frame is counted the stated cycles after its end, and only then",
            Property::Counted => "each fragment below the limit is told as counted, and no other",
            Property::Valid => "a word is shown in the cycle after its read, and only then",
            Property::Counts => "a counter has how many fragments its pixel had",
            Property::Limit => "a counter that has come to its limit stays there",
            Property::Meets => "a read that meets a write of its word shows what is written",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// What is at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// After reset: clearing words, of which this one is next.
    Clear(u32),
    /// Between frames.
    Idle,
    /// In a frame.
    Frame,
    /// The frame's end was taken so many cycles ago.
    Ends(u32),
}

/// How many fragments each pixel had.
pub struct Model<B> {
    cfg: Config,
    latency: u32,
    had: Vec<u64>,
    phase: Phase,
    /// Fragments of the frame that must be told as counted, and those that are.
    due: u64,
    told: u64,
    /// What was told in a frame before and should not have been, or the other way round, unless its counters are wrong too.
    wrong: Option<String>,
    /// The word that was read, and whether it was cleared in the same cycle.
    read: Option<(u32, bool)>,
    /// Words that were read one after the other since anything changed.
    checked: u32,
    block: PhantomData<B>,
}

impl<B> Model<B> {
    fn limit(&self) -> u64 {
        self.cfg.limit().into()
    }
    fn pixel(&self, k: u8) -> usize {
        usize::from(k) % self.had.len()
    }
    fn word(&self, k: u8) -> u32 {
        u32::from(k) % self.cfg.words()
    }
    /// Every word was read since anything changed.
    fn is_checked(&self) -> bool {
        self.checked == self.cfg.words()
    }
    /// The pixels of a word.
    fn pixels(&self, word: u32) -> std::ops::Range<usize> {
        let lanes = self.cfg.shape.lanes as usize;
        let first = word as usize * lanes;
        first..self.had.len().min(first + lanes)
    }
    /// What is wrong with a word that is shown.
    fn shown(&self, word: u32, meets: bool, counts: &Counts) -> Judged<Property> {
        for (pixel, count) in self.pixels(word).zip(counts.of) {
            let had = self.had[pixel];
            let due = had.min(self.limit());
            if u64::from(count) != due {
                let property = match (meets, had > self.limit()) {
                    (true, _) => Property::Meets,
                    (false, true) => Property::Limit,
                    (false, false) => Property::Counts,
                };
                let seen = format!("pixel {pixel} has {count} where {due} is due");
                return Err((property, seen));
            }
        }
        Ok(())
    }
}

/// A step of a frame, with its end this often, and of what is between frames.
fn step(often: f64, end: f64, reset: f64) -> BoxedStrategy<Step> {
    let user = || prop::sample::select(vec![User::Sum, User::Walk]);
    let asked = move |often| prop::option::weighted(often, (user(), any::<u8>()));
    let fragment = prop::option::weighted(often, prop_oneof![0..3u8, any::<u8>()]);
    let rare = prop::bool::weighted;
    (fragment, rare(end), asked(0.5), asked(0.1), rare(reset))
        .prop_map(|(fragment, end, read, clear, reset)| Step { fragment, end, read, clear, reset })
        .boxed()
}

/// Counters of so many pixels, `lanes` of them in a word: their bits, and slots, which a counter does not go beyond.
fn config(pixels: u32, lanes: u32, count_bits: u32, slots: u32) -> Config {
    let screen = Screen { width: pixels, height: 1, background: 0 };
    let shape = Shape {
        lanes,
        count_bits,
        down: true,
        sweeps: false,
        bands: false,
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

impl<I: Counting, C: Words> Reference for Model<Counted<I, C>> {
    type Block = Counted<I, C>;
    type Config = Config;
    type Setup = Config;
    type Step = Step;
    type Property = Property;
    type Outputs = Outputs;
    const NAME: &'static str = "counters";

    fn setups() -> BoxedStrategy<Config> {
        let lanes = (0..=MAX_LANES.ilog2()).prop_map(|bits| 1 << bits);
        (1..=40u32, lanes, 1..=4u32, 1..=20u32)
            .prop_map(|(pixels, lanes, bits, slots)| config(pixels, lanes, bits, slots))
            .boxed()
    }
    fn steps(_: &Config) -> BoxedStrategy<Step> {
        step(0.7, 0.05, 0.005)
    }
    fn long() -> Vec<Long<Self>> {
        // One of which every counter comes to its limit, and one of which none does.
        let long = |(cfg, clear)| {
            let step = step(0.9, clear, 0.0);
            Long { setup: Just(cfg).boxed(), step, steps: LONG }
        };
        vec![long((config(6, 4, 8, 1000), 0.001)), long((config(40, 1, 32, 1 << 20), 0.001))]
    }
    fn small() -> Vec<Config> {
        let shapes = [(1, 1, 2, 2), (2, 2, 2, 2), (2, 1, 1, 9), (3, 2, 1, 9)];
        shapes.map(|(pixels, lanes, bits, slots)| config(pixels, lanes, bits, slots)).to_vec()
    }
    fn told(cfg: &Config) -> String {
        let pixels = cfg.screen.pixels();
        format!("{pixels} pixels, {} in a word, counted to {}", cfg.shape.lanes, cfg.limit())
    }
    fn config(cfg: &Config) -> Config {
        *cfg
    }
    fn new(cfg: &Config) -> Self {
        Model {
            cfg: *cfg,
            latency: I::latency(cfg),
            had: vec![0; cfg.screen.pixels() as usize],
            phase: Phase::Clear(0),
            due: 0,
            told: 0,
            wrong: None,
            read: None,
            checked: 0,
            block: PhantomData,
        }
    }

    fn look(&mut self, _: u64, seen: &Moore) -> Judged<Property> {
        if !seen.ready && !matches!(self.phase, Phase::Clear(_)) {
            return Err((Property::Ready, "none is taken".to_string()));
        }
        let between = self.phase == Phase::Idle;
        match self.read {
            Some((word, _)) if !seen.counts.valid => {
                Err((Property::Valid, format!("word {word} was read, and none is shown")))
            }
            Some((word, meets)) => {
                self.shown(word, meets, &seen.counts.data)?;
                match &self.wrong {
                    Some(seen) if self.is_checked() => Err((Property::Counted, seen.clone())),
                    _ => Ok(()),
                }
            }
            None if seen.counts.valid && between => {
                Err((Property::Valid, "one is shown and none was read".to_string()))
            }
            None => Ok(()),
        }
    }

    fn inputs(&mut self, step: &Step, _: &Moore) -> Option<In> {
        self.read = None;
        if step.reset {
            *self = Model::new(&self.cfg);
            return None;
        }
        let (mut fragment, mut others) = (Stream::idle(), counters::In::default());
        match self.phase {
            Phase::Clear(next) => {
                others.clear = Stream::offer(next);
                let last = next + 1 == self.cfg.screen.pixels();
                self.phase = if last { Phase::Idle } else { Phase::Clear(next + 1) };
            }
            Phase::Ends(cycles) => self.phase = Phase::Ends(cycles + 1),
            Phase::Idle | Phase::Frame if step.end => {
                fragment = Stream::offer(Marked::end());
                self.phase = Phase::Ends(0);
            }
            Phase::Idle | Phase::Frame if step.fragment.is_some() => {
                let pixel = self.pixel(step.fragment.unwrap_or_default());
                let item = PixelFragment { pixel: pixel as u32, ..PixelFragment::default() };
                fragment = Stream::offer(Marked::item(item));
                self.due += u64::from(self.had[pixel] < self.limit());
                self.had[pixel] += 1;
                (self.phase, self.checked) = (Phase::Frame, 0);
            }
            Phase::Frame => {}
            Phase::Idle => {
                let cleared = step.clear.map(|(user, k)| (user, self.word(k)));
                let read = step.read.map(|(user, k)| (user, self.word(k)));
                self.read = read.map(|(_, word)| (word, cleared.is_some_and(|(_, at)| at == word)));
                self.checked += u32::from(read.is_some_and(|(_, word)| word == self.checked));
                if let Some((user, word)) = read {
                    let mut port = ReadPort::default();
                    port.read(word);
                    match user {
                        User::Sum => others.sum_read = port,
                        User::Walk => others.walk_read = port,
                    }
                }
                if let Some((user, word)) = cleared {
                    let mut port = WritePort::default();
                    port.write(word, Counts::default());
                    match user {
                        User::Sum => others.sum_write = port,
                        User::Walk => others.walk_write = port,
                    }
                    let pixels = self.pixels(word);
                    self.had[pixels].fill(0);
                    (self.checked, self.wrong) = (0, None);
                }
            }
        }
        Some(In { fragment, others })
    }

    fn judge(&mut self, out: &Out) -> Judged<Property> {
        self.told += u64::from(out.counted);
        let ends = matches!(self.phase, Phase::Ends(cycles) if cycles == self.latency);
        match (out.ended, ends) {
            (true, false) => {
                return Err((Property::End, "it is said to be counted and is not".to_string()));
            }
            (false, true) => return Err((Property::End, "it is not said".to_string())),
            _ => {}
        }
        if ends {
            let (due, told) = (self.due, self.told);
            if told != due && self.wrong.is_none() {
                self.wrong = Some(format!("{told} are told where {due} are due"));
            }
            (self.phase, self.due, self.told) = (Phase::Idle, 0, 0);
        }
        Ok(())
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        match self.phase {
            Phase::Clear(_) | Phase::Ends(_) => Some(Step::default()),
            Phase::Frame => Some(Step { end: true, ..Step::default() }),
            Phase::Idle if self.is_checked() => None,
            Phase::Idle => {
                let read = Some((User::Walk, self.checked as u8));
                Some(Step { read, ..Step::default() })
            }
        }
    }
    fn choices(&self) -> Vec<Step> {
        let reset = Step { reset: true, ..Step::default() };
        let mut steps = vec![Step::default(), reset];
        if matches!(self.phase, Phase::Idle | Phase::Frame) {
            let fragments = (0..self.had.len()).map(|k| Some(k as u8));
            steps.extend(fragments.map(|fragment| Step { fragment, ..Step::default() }));
            steps.push(Step { end: true, ..Step::default() });
        }
        if self.phase == Phase::Idle {
            let words = || (0..self.cfg.words()).map(|k| k as u8);
            for user in [User::Sum, User::Walk] {
                let asks = |k| Some((user, k));
                steps.extend(words().map(|k| Step { read: asks(k), ..Step::default() }));
                let both = |k| Step { read: asks(k), clear: asks(k), ..Step::default() };
                steps.extend(words().map(both));
            }
        }
        steps
    }
    fn known(&self, to: &mut Vec<u64>) {
        // More than beyond its limit a counter cannot be.
        to.extend(self.had.iter().map(|had| *had.min(&(self.limit() + 1))));
        let phase = match self.phase {
            Phase::Clear(next) => [0, next],
            Phase::Idle => [1, 0],
            Phase::Frame => [2, 0],
            Phase::Ends(cycles) => [3, cycles],
        };
        to.extend(phase.map(u64::from));
        let read = self.read.map_or(0, |(word, meets)| 1 + 2 * word + u32::from(meets));
        let wrong = u64::from(self.wrong.is_some());
        to.extend([self.due, self.told, wrong, read.into(), self.checked.into()]);
    }
    fn outputs(seen: &Moore, out: Option<&Out>) -> Outputs {
        Outputs { seen: *seen, out: out.copied().unwrap_or_default() }
    }
    fn tell(&self, In { fragment, others }: &In) -> Vec<String> {
        let mut what = vec![];
        let Stream { valid, payload: Marked { end, item } } = *fragment;
        what.extend((valid && end).then(|| "the frame ends".to_string()));
        what.extend((valid && !end).then(|| format!("a fragment of pixel {}", item.pixel)));
        let reads = [("the sum", others.sum_read), ("the walk", others.walk_read)];
        let words = reads.into_iter().filter_map(|(user, port)| Some((user, port.asked()?)));
        what.extend(words.map(|(user, word)| format!("{user} reads word {word}")));
        let writes = [("the sum", others.sum_write), ("the walk", others.walk_write)];
        let words = writes.into_iter().filter_map(|(user, port)| Some((user, port.asked()?.0)));
        what.extend(words.map(|(user, word)| format!("{user} clears word {word}")));
        what.extend(others.clear.valid.then(|| format!("clear {}", others.clear.payload)));
        what
    }
}

/// Tests of everything that the contract of counters asks for: `counters_properties!(Counted<MyIndex, MyCounters>)`, or with a
/// name for the module that they stand in, `counters_properties!(Counted<MyIndex>, mine)`.
#[macro_export]
macro_rules! counters_properties {
    ($counted:ty) => {
        $crate::counters_properties!($counted, counters_properties);
    };
    ($counted:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::counters::Model<$counted>, $name $(, $states)?);
    };
}
