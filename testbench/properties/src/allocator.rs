//! The contract of a section allocator, see [`mod@pellucid_blocks::allocator`], as properties.
//!
//! A sequence says for every cycle whether what is offered is taken, which of the sections that are out is
//! given back, if any, and whether the allocator is reset. A plain list of the sections that are out says
//! what must hold; behind the last cycle all sections are taken, so that none can have been lost. Whoever
//! has a section writes into the word that it lends while it is free. Where the contract says what comes of a
//! release of a section that is not out, such releases are among the others.

use crate::harness;
use crate::reference::{Judged, LONG, Long, Reference};
use crate::trials;
use pellucid_blocks::allocator::{Config, Contract, In, InvalidRelease, Lent, Moore, Reuse};
use pellucid_sim::{Block, Fault, Signals, Stream};
use proptest::prelude::*;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// What is offered is taken.
    pub take: bool,
    /// A section is given back: this one of those that are out, counted round from the longest.
    pub release: Option<u8>,
    /// It is one of those that are not out, counted round from the lowest of the numbers that its port can say.
    pub invalid: bool,
    /// The allocator is reset instead.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// A granted section is one of those that there are.
    Range,
    /// No section is out twice.
    Twice,
    /// What is offered is held until it is taken.
    Held,
    /// While a section is free, one is granted within the latency: none is lost, a reset restores all.
    Granted,
    /// `exhausted` is high where no section is free, and only there.
    Exhausted,
    /// Only words of free sections are asked for.
    Lent,
    /// A release of what is not out is flagged, where the contract says so, and nothing else.
    Flagged,
    /// No port of a memory is misused and no register holds more than its bits.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Range => "a granted section is one of those that there are",
            Property::Twice => "no section is out twice",
            Property::Held => "what is offered is held until it is taken",
            Property::Granted => "while a section is free, one is granted within the latency",
            Property::Exhausted => "`exhausted` is high where no section is free, and only there",
            Property::Lent => "only words of free sections are asked for",
            Property::Flagged => "a release of what is not out is flagged, and no other",
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// A broken property.
pub type Broken = harness::Broken<Property>;

/// The plain list that an allocator is held to.
pub struct Model<A> {
    sections: u32,
    latency: u32,
    cycle: u64,
    /// The sections that are out, the one that is out longest first, each since a cycle.
    out: Vec<(u32, u64)>,
    /// How many are not to be had: they are out, or came back and wait for the others.
    spent: u32,
    /// The word of every section, and the one that was asked for.
    words: Vec<u32>,
    word: u32,
    /// What was offered in the cycle before and not taken.
    offered: Option<u32>,
    /// Cycles in a row in which a section was free and none offered.
    without: u32,
    /// Cycles in a row in which none was free and that was not said.
    unsaid: u32,
    /// What was not out was given back in the cycle before.
    invalid: Option<u32>,
    allocator: PhantomData<A>,
}

/// What whoever has a section writes into its word: a number that an allocator might take for another one.
const USED: u32 = 0;

/// An allocator with its flag among what is seen of it.
pub struct Flagging<A>(PhantomData<A>);

/// What is seen of it.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Seen {
    /// What is offered.
    #[with(*cfg)]
    pub moore: Moore,
    /// What was given back in the cycle before was not out.
    pub flagged: bool,
}

impl<A: Contract> Block for Flagging<A> {
    type Config = Config;
    type State = A::State;
    type In = In;
    type Moore = Seen;
    type Out = Lent;
    type Mem = A::Mem;

    fn reset(cfg: &Config) -> A::State {
        A::reset(cfg)
    }
    fn memories(cfg: &Config) -> A::Mem {
        A::memories(cfg)
    }
    fn moore(cfg: &Config, q: &A::State, m: &A::Mem) -> Seen {
        Seen { moore: A::moore(cfg, q, m), flagged: A::flagged(cfg, q) }
    }
    fn next(cfg: &Config, q: &A::State, d: &mut A::State, m: &mut A::Mem, i: In) -> Lent {
        A::next(cfg, q, d, m, i)
    }
}

/// What a waveform shows.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Outputs {
    /// What is seen.
    #[with(*cfg)]
    pub seen: Seen,
    /// What is asked of the lent words.
    #[with(*cfg)]
    pub lent: Lent,
}

impl<A: Contract + 'static> Reference for Model<A> {
    type Block = Flagging<A>;
    type Config = Config;
    /// How many sections there are.
    type Setup = u32;
    type Step = Step;
    type Property = Property;
    type Outputs = Outputs;
    const NAME: &'static str = "allocator";

    fn setups() -> BoxedStrategy<u32> {
        // Seldom so many that they fill several words of bits.
        let many = A::MOST.min(MANY);
        prop_oneof![3 => 0..=FEW.min(many), 1 => 0..=many].boxed()
    }
    fn steps(sections: &u32) -> BoxedStrategy<Step> {
        // Of many, many shall be out.
        step::<A>(if *sections > FEW { [0.9, 0.4, 0.001] } else { [0.5, 0.5, 0.02] })
    }
    fn long() -> Vec<Long<Self>> {
        let long = |(sections, rates): (u32, [f64; 3])| {
            let setup = Just(sections.min(A::MOST)).boxed();
            Long { setup, step: step::<A>(rates), steps: LONG }
        };
        // Few, of which some or all are out; many, of which few are not.
        [(FEW, [0.95, 0.95, 0.0]), (MANY, [0.95, 0.9, 0.0])].map(long).into()
    }
    fn small() -> Vec<u32> {
        (0..=SMALL).collect()
    }
    fn told(sections: &u32) -> String {
        format!("{sections} sections")
    }
    fn config(sections: &u32) -> Config {
        Config { sections: *sections }
    }
    fn new(sections: &u32) -> Model<A> {
        Model {
            sections: *sections,
            latency: A::latency(&Config { sections: *sections }),
            cycle: 0,
            out: vec![],
            spent: 0,
            words: vec![USED; *sections as usize],
            word: USED,
            offered: None,
            without: 0,
            unsaid: 0,
            invalid: None,
            allocator: PhantomData,
        }
    }

    fn look(&mut self, cycle: u64, Seen { moore: seen, flagged }: &Seen) -> Judged<Property> {
        self.cycle = cycle;
        if A::INVALID_RELEASE == InvalidRelease::Flagged && *flagged != self.invalid.is_some() {
            let seen = match self.invalid {
                Some(id) => format!("{id} was given back, which was not out, and is not flagged"),
                None => "one is flagged and was none".to_string(),
            };
            return Err((Property::Flagged, seen));
        }
        let free = self.free();
        let granted = seen.grant.valid.then_some(seen.grant.payload);
        if let Some(before) = self.offered
            && granted != Some(before)
        {
            let now = granted.map_or("nothing".to_string(), |id| id.to_string());
            return Err((Property::Held, format!("{before} was offered, then {now}")));
        }
        if let Some(id) = granted {
            if id >= self.sections {
                let seen = format!("{id} is granted of {} sections", self.sections);
                return Err((Property::Range, seen));
            }
            if let Some((_, since)) = self.out.iter().find(|(out, _)| *out == id) {
                let seen = format!("{id} is granted, which is out since cycle {since}");
                return Err((Property::Twice, seen));
            }
        }
        self.without = if free > 0 && granted.is_none() { self.without + 1 } else { 0 };
        if self.without >= self.latency.max(1) {
            let seen = format!("{free} are free and none is granted for {} cycles", self.without);
            return Err((Property::Granted, seen));
        }
        self.unsaid = if free == 0 && !seen.exhausted { self.unsaid + 1 } else { 0 };
        if seen.exhausted && free > 0 {
            return Err((Property::Exhausted, format!("high while {free} are free")));
        }
        if self.unsaid >= self.latency.max(1) {
            return Err((Property::Exhausted, "low while none is free".to_string()));
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, Seen { moore: seen, .. }: &Seen) -> Option<In> {
        self.invalid = None;
        if step.reset {
            self.out.clear();
            (self.spent, self.offered, self.without, self.unsaid) = (0, None, 0, 0);
            return None;
        }
        let back = if step.invalid {
            let others = self.not_out();
            self.invalid = step
                .release
                .zip(others.len().checked_sub(1))
                .map(|(k, last)| others[usize::from(k) % (last + 1)]);
            self.invalid
        } else {
            let back = step.release.filter(|_| !self.out.is_empty());
            back.map(|k| self.out.remove(usize::from(k) % self.out.len()).0)
        };
        let taken = (step.take && seen.grant.valid).then_some(seen.grant.payload);
        self.offered = if step.take || !seen.grant.valid { None } else { Some(seen.grant.payload) };
        self.out.extend(taken.map(|id| (id, self.cycle)));
        self.spent = match A::REUSE {
            Reuse::Each => self.out.len() as u32,
            Reuse::Together if self.out.is_empty() => 0,
            Reuse::Together => self.spent + u32::from(taken.is_some()),
        };
        if A::REUSE == Reuse::Together && self.spent == 0 {
            // All are back, and the next offer is of all.
            self.offered = None;
        }
        let release = back.map_or(Stream::idle(), Stream::offer);
        Some(In { take: step.take, release, word: self.word })
    }

    fn judge(&mut self, lent: &Lent) -> Judged<Property> {
        for (asked, what) in [(lent.read, "read"), (lent.write, "written")] {
            let id = asked.payload;
            if asked.valid && id >= self.sections {
                let seen = format!("{id} is {what} of {} sections", self.sections);
                return Err((Property::Lent, seen));
            }
            if asked.valid && self.out.iter().any(|(out, _)| *out == id) {
                return Err((Property::Lent, format!("{id} is {what}, which is out")));
            }
        }
        if lent.read.valid {
            self.word = self.words[lent.read.payload as usize];
        }
        if lent.write.valid {
            self.words[lent.write.payload as usize] = lent.word;
        }
        for (id, _) in &self.out {
            self.words[*id as usize] = USED;
        }
        Ok(())
    }

    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        Err((Property::Fault, fault.to_string()))
    }
    fn rest(&self) -> Option<Step> {
        (self.free() > 0).then_some(Step { take: true, ..Step::default() })
    }
    fn choices(&self) -> Vec<Step> {
        let back = |many, invalid| (0..many).map(move |k| (Some(k as u8), invalid));
        let undefined = A::INVALID_RELEASE == InvalidRelease::Undefined;
        let invalid = if undefined { 0 } else { self.not_out().len() };
        let releases =
            back(self.out.len(), false).chain(back(invalid, true)).chain([(None, false)]);
        let inputs = releases.flat_map(|(release, invalid)| {
            [false, true].map(|take| Step { take, release, invalid, reset: false })
        });
        inputs.chain([Step { reset: true, ..Step::default() }]).collect()
    }
    fn known(&self, to: &mut Vec<u64>) {
        let offered = self.offered.map_or(0, |id| u64::from(id) + 1);
        to.extend([offered, u64::from(self.without), u64::from(self.unsaid)]);
        to.extend([self.spent, self.word, u32::from(self.invalid.is_some())].map(u64::from));
        to.extend(self.words.iter().map(|word| u64::from(*word)));
        to.extend(self.out.iter().map(|(id, _)| u64::from(*id)));
    }
    fn outputs(seen: &Seen, lent: Option<&Lent>) -> Outputs {
        Outputs { seen: *seen, lent: lent.copied().unwrap_or_default() }
    }
    fn tell(&self, inputs: &In) -> Vec<String> {
        let mut what = vec![];
        what.extend(inputs.take.then(|| "take".to_string()));
        let back = inputs.release;
        let invalid = if self.invalid.is_some() { ", which is not out" } else { "" };
        what.extend(back.valid.then(|| format!("release {}{invalid}", back.payload)));
        what
    }
}

impl<A> Model<A> {
    /// How many are to be had.
    fn free(&self) -> u32 {
        self.sections - self.spent
    }
    /// Every number that can be given back and is not out.
    fn not_out(&self) -> Vec<u32> {
        let numbers = 0..1 << Config { sections: self.sections }.id_bits();
        numbers.filter(|id| self.out.iter().all(|(out, _)| out != id)).collect()
    }
}

/// Steps in which an offer is taken, a section is given back and the allocator is reset this often.
fn step<A: Contract>([take, release, reset]: [f64; 3]) -> BoxedStrategy<Step> {
    let release = prop::option::weighted(release, any::<u8>());
    let undefined = A::INVALID_RELEASE == InvalidRelease::Undefined;
    let invalid = prop::bool::weighted(if undefined { 0.0 } else { 0.1 });
    (prop::bool::weighted(take), release, invalid, prop::bool::weighted(reset))
        .prop_map(|(take, release, invalid, reset)| Step { take, release, invalid, reset })
        .boxed()
}

/// In most random sequences there are no more sections than this.
const FEW: u32 = 9;
/// In none there are more.
const MANY: u32 = 300;
/// The most sections of which a test looks at every state.
pub const SMALL: u32 = 4;
pub use crate::trials::MOST_STATES;

/// Plays a sequence to an allocator of so many sections.
///
/// # Errors
/// The first property that is broken.
pub fn check<A: Contract + 'static>(sections: u32, steps: &[Step]) -> Result<(), Broken> {
    harness::check::<Model<A>>(&sections, steps)
}

/// Looks at every state that an allocator of so many sections can come to, see [`harness::exhaust`].
///
/// # Errors
/// The first property that is broken, with the shortest sequence that breaks it.
pub fn exhaust<A: Contract + 'static>(
    sections: u32,
    most: usize,
) -> Result<harness::Searched, (Broken, Vec<Step>)> {
    harness::exhaust::<Model<A>>(&sections, most)
}

/// Tries random sequences on an allocator, see [`trials::test`].
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn test<A: Contract + 'static>(source: &'static str, folder: &Path) {
    trials::test::<Model<A>>(source, folder);
}

/// What is said of a sequence that breaks a property; its waveform is written into the folder.
pub fn report<A: Contract + 'static>(sections: u32, steps: &[Step], folder: &Path) -> String {
    crate::report::report::<Model<A>>(&sections, steps, folder)
}

/// Tests of everything that the contract of an allocator asks for: `allocator_properties!(MyAllocator)`, or
/// with a name for the module that they stand in, `allocator_properties!(MyAllocator, mine)`.
#[macro_export]
macro_rules! allocator_properties {
    ($allocator:ty) => {
        $crate::allocator_properties!($allocator, allocator_properties);
    };
    ($allocator:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::allocator::Model<$allocator>, $name $(, $states)?);
    };
}
