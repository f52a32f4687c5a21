//! The contract of a section allocator, see [`mod@pellucid_hw::allocator`], as properties.
//!
//! A sequence says for every cycle whether what is offered is taken, which of the sections that are out is
//! given back, if any, and whether the allocator is reset. A plain list of the sections that are out says
//! what must hold; behind the last cycle all sections are taken, so that none can have been lost.

use pellucid_hw::allocator::{Config, Contract, In, Moore};
use pellucid_sim::{Declare, Memory, Signals, Sim, Sink, Stream};
use pellucid_waveforms::{FileFormat, Layout, Marker, View, Wave};
use proptest::prelude::*;
use proptest::test_runner::{Config as Effort, TestError, TestRunner};
use proptest_state_machine::ReferenceStateMachine;
use std::collections::{HashSet, VecDeque};
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::sync::atomic::Ordering;

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// What is offered is taken.
    pub take: bool,
    /// A section is given back: this one of those that are out, counted round from the longest.
    pub release: Option<u8>,
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
            Property::Fault => "no port is misused and no register overflows",
        })
    }
}

/// A broken property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken {
    /// Which.
    pub property: Property,
    /// In which cycle of the sequence; those that take all sections in the end follow it.
    pub cycle: u64,
    /// What was seen.
    pub seen: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "broken in cycle {}: {}: {}", self.cycle, self.property, self.seen)
    }
}

/// What there is to see in a cycle.
struct Seen<'a, A: Contract> {
    cycle: u64,
    q: &'a A::State,
    inputs: In,
    outputs: Moore,
    reset: bool,
}

/// An allocator and the plain list that it is held to.
struct Run<A: Contract> {
    sim: Sim<A>,
    sections: u32,
    latency: u32,
    cycle: u64,
    /// The sections that are out, the one that is out longest first, each since a cycle.
    out: Vec<(u32, u64)>,
    /// What was offered in the cycle before and not taken.
    offered: Option<u32>,
    /// Cycles in a row in which a section was free and none offered.
    without: u32,
    /// Cycles in a row in which none was free and that was not said.
    unsaid: u32,
}

impl<A: Contract> Run<A> {
    fn new(sections: u32) -> Run<A> {
        let cfg = Config { sections };
        Run {
            sim: Sim::new(cfg),
            sections,
            latency: A::latency(&cfg),
            cycle: 0,
            out: vec![],
            offered: None,
            without: 0,
            unsaid: 0,
        }
    }

    fn free(&self) -> u32 {
        self.sections - self.out.len() as u32
    }

    fn broken(&self, property: Property, seen: String) -> Broken {
        Broken { property, cycle: self.cycle, seen }
    }

    /// What is seen before the inputs come.
    fn look(&mut self) -> Result<(), Broken> {
        let seen = self.sim.moore();
        let free = self.free();
        let granted = seen.grant.valid.then_some(seen.grant.payload);
        if let Some(before) = self.offered
            && granted != Some(before)
        {
            let now = granted.map_or("nothing".to_string(), |id| id.to_string());
            return Err(self.broken(Property::Held, format!("{before} was offered, then {now}")));
        }
        if let Some(id) = granted {
            if id >= self.sections {
                let seen = format!("{id} is granted of {} sections", self.sections);
                return Err(self.broken(Property::Range, seen));
            }
            if let Some((_, since)) = self.out.iter().find(|(out, _)| *out == id) {
                let seen = format!("{id} is granted, which is out since cycle {since}");
                return Err(self.broken(Property::Twice, seen));
            }
        }
        self.without = if free > 0 && granted.is_none() { self.without + 1 } else { 0 };
        if self.without >= self.latency.max(1) {
            let seen = format!("{free} are free and none is granted for {} cycles", self.without);
            return Err(self.broken(Property::Granted, seen));
        }
        self.unsaid = if free == 0 && !seen.exhausted { self.unsaid + 1 } else { 0 };
        if seen.exhausted && free > 0 {
            return Err(self.broken(Property::Exhausted, format!("high while {free} are free")));
        }
        if self.unsaid >= self.latency.max(1) {
            return Err(self.broken(Property::Exhausted, "low while none is free".to_string()));
        }
        Ok(())
    }

    /// The inputs of a step, when `seen` is seen.
    fn inputs(&mut self, step: Step, seen: &Moore) -> In {
        let back = step.release.filter(|_| !self.out.is_empty());
        let back = back.map(|k| self.out.remove(usize::from(k) % self.out.len()).0);
        let taken = (step.take && seen.grant.valid).then_some(seen.grant.payload);
        self.offered = if step.take || !seen.grant.valid { None } else { Some(seen.grant.payload) };
        self.out.extend(taken.map(|id| (id, self.cycle)));
        In { take: step.take, release: back.map_or(Stream::idle(), Stream::offer) }
    }

    /// One cycle; `show` is told of it before the edge.
    fn step(&mut self, step: Step, show: &mut dyn FnMut(Seen<A>)) -> Result<(), Broken> {
        let looked = self.look();
        let (cycle, outputs) = (self.cycle, self.sim.moore());
        let mut inputs = In { take: false, release: Stream::idle() };
        if looked.is_ok() && !step.reset {
            inputs = self.inputs(step, &outputs);
        }
        show(Seen { cycle, q: self.sim.state(), inputs, outputs, reset: step.reset });
        looked?;
        if step.reset {
            self.sim.reset();
            self.out.clear();
            (self.offered, self.without, self.unsaid) = (None, 0, 0);
        } else if let Err(fault) = self.sim.clock(inputs) {
            return Err(self.broken(Property::Fault, fault.to_string()));
        }
        self.cycle += 1;
        Ok(())
    }

    /// The sequence, then a take in every cycle until no section is left.
    fn play(
        &mut self,
        steps: impl IntoIterator<Item = Step>,
        show: &mut dyn FnMut(Seen<A>),
    ) -> Result<(), Broken> {
        for step in steps {
            self.step(step, show)?;
        }
        while self.free() > 0 {
            self.step(Step { take: true, ..Step::default() }, show)?;
        }
        self.look()
    }
}

/// Plays a sequence to an allocator of so many sections.
///
/// # Errors
/// The first property that is broken.
pub fn check<A: Contract>(sections: u32, steps: &[Step]) -> Result<(), Broken> {
    Run::<A>::new(sections).play(steps.iter().copied(), &mut |_| {})
}

/// All that is known of an allocator and of the sections that are out.
type Known = (Vec<u64>, Vec<u32>);

/// Looks at every state that an allocator of so many sections can come to, by every input in each: a plain
/// search, from reset on, of `most` states at most. Gives how many states it has seen.
///
/// # Errors
/// The first property that is broken, with the shortest sequence that breaks it.
pub fn exhaust<A: Contract>(sections: u32, most: usize) -> Result<usize, (Broken, Vec<Step>)> {
    let known = |run: &mut Run<A>| -> Known {
        let mut values = vec![];
        run.sim.state().sample(&Config { sections }, &mut values);
        run.sim.memories().visit("", &mut |_, storage| {
            (0..storage.info().words).for_each(|k| storage.peek(k as u32, &mut values));
            storage.under_way(&mut values);
        });
        // What the properties remember belongs to the state.
        let offered = run.offered.map_or(0, |id| u64::from(id) + 1);
        values.extend([offered, u64::from(run.without), u64::from(run.unsaid)]);
        (values, run.out.iter().map(|(id, _)| *id).collect())
    };
    let mut seen: HashSet<Known> = HashSet::new();
    let mut next = VecDeque::from([vec![]]);
    while let Some(steps) = next.pop_front().filter(|_| seen.len() < most) {
        // An allocator cannot be copied: the way to the state is gone again.
        let mut run = Run::<A>::new(sections);
        let mut way = steps.iter().copied();
        let played = way.try_for_each(|step| run.step(step, &mut |_| {}));
        if let Err(broken) = played.and_then(|()| run.look()) {
            return Err((broken, steps));
        }
        if !seen.insert(known(&mut run)) {
            continue;
        }
        let releases = (0..run.out.len()).map(|k| Some(k as u8)).chain([None]);
        let inputs = releases
            .flat_map(|release| [false, true].map(|take| Step { take, release, reset: false }));
        let reset = Step { reset: true, ..Step::default() };
        next.extend(inputs.chain([reset]).map(|step| {
            let mut longer = steps.clone();
            longer.push(step);
            longer
        }));
    }
    Ok(seen.len())
}

/// What the sequences are made from.
#[derive(Clone, Debug)]
pub struct Model {
    /// How many sections the allocator has.
    pub sections: u32,
}

/// Makes sequences, and shorter ones of those that break something.
struct Sequences;

impl ReferenceStateMachine for Sequences {
    type State = Model;
    type Transition = Step;

    fn init_state() -> BoxedStrategy<Model> {
        (0..=9u32).prop_map(|sections| Model { sections }).boxed()
    }

    fn transitions(_: &Model) -> BoxedStrategy<Step> {
        let release = prop_oneof![1 => Just(None), 1 => any::<u8>().prop_map(Some)];
        let reset = prop::bool::weighted(0.02);
        (any::<bool>(), release, reset)
            .prop_map(|(take, release, reset)| Step { take, release, reset })
            .boxed()
    }

    fn apply(model: Model, _: &Step) -> Model {
        model
    }
}

/// The longest sequence.
const STEPS: usize = 300;
/// States that are searched for a shorter sequence than the one that was found.
const SEARCHED: usize = 20_000;
/// The most sections of which a test searches every state, and the most states.
pub const SMALL: u32 = 4;
/// See [`SMALL`].
pub const MOST_STATES: usize = 500_000;

/// The shortest sequence that breaks a property, with how many sections: by a search, if one of few sections
/// does, else the one that was found.
fn shortest<A: Contract>(sections: u32, steps: Vec<Step>) -> (u32, Vec<Step>) {
    let searched = (0..=sections.min(SMALL)).find_map(|sections| {
        let (_, steps) = exhaust::<A>(sections, SEARCHED).err()?;
        Some((sections, steps))
    });
    searched.unwrap_or((sections, steps))
}

/// Tries random sequences on an allocator. `source` is the test's file, beside which regressions are kept;
/// the waveform of a failure goes into the folder `folder`.
///
/// # Panics
/// A property is broken: the message has the shortest sequence and the command that opens its waveform.
pub fn test<A: Contract>(source: &'static str, folder: &Path) {
    let effort = Effort { source_file: Some(source), ..Effort::default() };
    let sequences = Sequences::sequential_strategy(1..STEPS);
    let tried = TestRunner::new(effort).run(&sequences, |(model, steps, seen)| {
        let counted = steps.iter().inspect(|_| {
            if let Some(seen) = &seen {
                seen.fetch_add(1, Ordering::SeqCst);
            }
        });
        let played = Run::<A>::new(model.sections).play(counted.copied(), &mut |_| {});
        played.map_err(|broken| TestCaseError::fail(broken.to_string()))
    });
    match tried {
        Ok(()) => {}
        Err(TestError::Fail(_, (model, steps, _))) => {
            let (sections, steps) = shortest::<A>(model.sections, steps);
            panic!("{}", report::<A>(sections, &steps, folder))
        }
        Err(error) => panic!("{error}"),
    }
}

/// What is said of a sequence that breaks a property; its waveform is written into the folder.
pub fn report<A: Contract>(sections: u32, steps: &[Step], folder: &Path) -> String {
    let mut told = vec![];
    let mut run = Run::<A>::new(sections);
    let played = run.play(steps.iter().copied(), &mut |Seen { cycle, inputs, reset, .. }| {
        let mut what = vec![];
        what.extend(reset.then(|| "reset".to_string()));
        what.extend(inputs.take.then(|| "take".to_string()));
        let back = inputs.release;
        what.extend(back.valid.then(|| format!("release {}", back.payload)));
        let what = if what.is_empty() { "nothing".to_string() } else { what.join(", ") };
        told.push(format!("  {cycle:4}  {what}"));
    });
    let Err(broken) = played else { return "no property is broken".to_string() };
    let wave = record::<A>(sections, steps, &broken, folder);
    let wave = match wave {
        Ok(()) => format!("its waveform: gtkwave {}", folder.join("wave.gtkw").display()),
        Err(error) => format!("its waveform cannot be written to `{}`: {error}", folder.display()),
    };
    let sequence = told.join("\n");
    format!("{broken}\n{wave}\n{sections} sections, cycle by cycle:\n{sequence}")
}

/// Writes the waveform of a sequence, with a marker where it breaks a property.
fn record<A: Contract>(
    sections: u32,
    steps: &[Step],
    broken: &Broken,
    folder: &Path,
) -> io::Result<()> {
    let cfg = Config { sections };
    let layout = Layout::new(vec![], |to: &mut dyn Declare| {
        to.open("allocator");
        A::State::declare(&cfg, "registers", to);
        to.open("wires");
        In::declare(&cfg, "in", to);
        Moore::declare(&cfg, "out", to);
        bool::declare(&(), "reset", to);
        to.close();
        to.close();
    });
    fs::create_dir_all(folder)?;
    let file = File::create(folder.join("wave.vcd"))?;
    let mut wave = Wave::new(FileFormat::Vcd, file, layout.clone(), 0)?;
    let mut written = Ok(());
    let mut run = Run::<A>::new(sections);
    let _ = run.play(steps.iter().copied(), &mut |Seen { cycle, q, inputs, outputs, reset }| {
        wave.sample(|to| {
            q.sample(&cfg, to);
            inputs.sample(&cfg, to);
            outputs.sample(&cfg, to);
            to.push(u64::from(reset));
        });
        if written.is_ok() {
            written = wave.show(cycle);
        }
    });
    written?;
    wave.finish(broken.cycle + 1)?;
    let view = View {
        stem: "wave".to_string(),
        format: FileFormat::Vcd,
        markers: vec![Marker { cycle: broken.cycle, name: broken.property.to_string() }],
        first: 0,
    };
    for file in view.files(&layout) {
        let path = folder.join(file.name);
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::write(path, file.text)?;
    }
    Ok(())
}

/// Tests of everything that the contract of an allocator asks for: `allocator_properties!(MyAllocator)`, or
/// with a name for the module that they stand in, `allocator_properties!(MyAllocator, mine)`.
#[macro_export]
macro_rules! allocator_properties {
    ($allocator:ty) => {
        $crate::allocator_properties!($allocator, allocator_properties);
    };
    ($allocator:ty, $name:ident) => {
        mod $name {
            #[allow(unused_imports)]
            use super::*;

            /// Any interleaving of takes, releases, pauses and resets.
            #[test]
            fn any_sequence_keeps_the_contract() {
                let folder = match option_env!("CARGO_TARGET_TMPDIR") {
                    Some(folder) => ::std::path::PathBuf::from(folder),
                    None => ::std::env::temp_dir(),
                };
                let folder = folder.join("failures").join(module_path!().replace("::", "-"));
                $crate::allocator::test::<$allocator>(file!(), &folder);
            }

            /// Every state of a small one.
            #[test]
            fn every_state_keeps_the_contract() {
                use $crate::allocator::{MOST_STATES, SMALL, exhaust};
                for sections in 0..=SMALL {
                    match exhaust::<$allocator>(sections, MOST_STATES) {
                        Err((broken, steps)) => {
                            panic!("{sections} sections: {broken}, after {steps:?}")
                        }
                        Ok(MOST_STATES) => {
                            println!(
                                "{sections} sections: only {MOST_STATES} states were looked at"
                            );
                        }
                        Ok(_) => {}
                    }
                }
            }
        }
    };
}
