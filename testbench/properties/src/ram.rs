//! The contract of a memory, see [`mod@pellucid_sim::ram`], as properties.
//!
//! A sequence says for every cycle what is read, what is written, whether a port is used twice, and whether
//! the memory is reset. What is written is numbered, so that a plain array says what a read must give.

use crate::reference::{Judged, LONG, Long, Reference};
use pellucid_sim::{
    Block, Fault, FaultKind, Memory, Ports, Ram1R1W, Ram1RW, Read, ReadDuringWrite, Signals,
    Stream, bits_for,
};
use proptest::prelude::*;
use std::collections::VecDeque;
use std::fmt;
use std::marker::PhantomData;

/// What a memory is made from.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// How many words it has, at least 1.
    pub words: u32,
    /// Bits of a word, 1..=32.
    pub bits: u32,
    /// Cycles from a read request to its data, at least 1.
    pub latency: u32,
    /// What a read gives that meets a write of its word; with one port they do not meet.
    pub read_during_write: ReadDuringWrite,
}

impl Config {
    fn address_bits(&self) -> u32 {
        bits_for(u64::from(self.words - 1))
    }
}

/// What can be tested: a memory of numbers.
pub trait Ram: Memory + 'static {
    /// Its ports.
    const PORTS: Ports;
    /// The memory at power-up.
    fn new(cfg: &Config) -> Self;
    /// What it shows in this cycle.
    fn q(&self) -> Read<u32>;
    /// Asks for the word at `addr`.
    fn read(&mut self, addr: u32);
    /// Asks for `data` to be put at `addr`.
    fn write(&mut self, addr: u32, data: u32);
}

impl Ram for Ram1R1W<u32> {
    const PORTS: Ports = Ports::OneReadOneWrite;
    fn new(cfg: &Config) -> Self {
        Ram1R1W::new(cfg.words, cfg.bits, cfg.latency, cfg.read_during_write)
    }
    fn q(&self) -> Read<u32> {
        self.q()
    }
    fn read(&mut self, addr: u32) {
        self.read(addr);
    }
    fn write(&mut self, addr: u32, data: u32) {
        self.write(addr, data);
    }
}

impl Ram for Ram1RW<u32> {
    const PORTS: Ports = Ports::One;
    fn new(cfg: &Config) -> Self {
        Ram1RW::new(cfg.words, cfg.bits, cfg.latency)
    }
    fn q(&self) -> Read<u32> {
        self.q()
    }
    fn read(&mut self, addr: u32) {
        self.read(addr);
    }
    fn write(&mut self, addr: u32, data: u32) {
        self.write(addr, data);
    }
}

/// A memory on its own, as a block.
pub struct Alone<R>(PhantomData<R>);

/// It has no registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct State {}

/// What a memory is asked in a cycle.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// The word that is read.
    #[with(cfg.address_bits())]
    pub read: Stream<u32>,
    /// The word that is written.
    #[with(cfg.address_bits())]
    pub write: Stream<u32>,
    /// What is written.
    #[width(cfg.bits)]
    pub data: u32,
    /// The word is read twice, or written twice if none is read.
    pub twice: bool,
}

/// What a memory shows.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A word that was read.
    #[with(cfg.bits)]
    pub q: Read<u32>,
}

impl<R: Ram> Block for Alone<R> {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = R;

    fn reset(_: &Config) -> State {
        State {}
    }
    fn memories(cfg: &Config) -> R {
        R::new(cfg)
    }
    fn moore(_: &Config, _: &State, m: &R) -> Moore {
        Moore { q: m.q() }
    }
    fn next(_: &Config, _: &State, _: &mut State, m: &mut R, i: In) {
        for _ in 0..if i.twice { 2 } else { 1 } {
            if i.read.valid {
                m.read(i.read.payload);
            }
        }
        for _ in 0..if i.twice && !i.read.valid { 2 } else { 1 } {
            if i.write.valid {
                m.write(i.write.payload, i.data);
            }
        }
    }
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// A word is read: this one of those that were written, counted round from the lowest.
    pub read: Option<u8>,
    /// A word is written: this one, counted round.
    pub write: Option<u8>,
    /// A port is used twice, which is the end of the sequence.
    pub misuse: bool,
    /// The memory is reset instead.
    pub reset: bool,
}

/// What can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// `valid` is high `latency` cycles after each read, and only then.
    Valid,
    /// A read gives what was last written before it; a reset changes no word.
    Data,
    /// A read that meets a write of its word gives the old or the new one, as is stated.
    Meets,
    /// With latency 1 the data stays until the next read.
    Held,
    /// A port that is used twice in a cycle is reported.
    Misuse,
    /// Nothing else is a fault.
    Fault,
}

/// As a sentence.
impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Property::Valid => "`valid` is high `latency` cycles after each read, and only then",
            Property::Data => "a read gives what was last written before it",
            Property::Meets => "a read that meets a write of its word gives what is stated",
            Property::Held => "with latency 1 the data stays until the next read",
            Property::Misuse => "a port that is used twice in a cycle is reported",
            Property::Fault => "nothing but a port that is used twice is a fault",
        })
    }
}

/// What a read must give, and when.
struct Due {
    cycle: u64,
    data: u32,
    /// What it must not give: the old word or the new one, if it is written in the cycle of the read.
    other: Option<u32>,
}

/// The plain array that a memory is held to.
pub struct Model<R> {
    cfg: Config,
    cycle: u64,
    words: Vec<Option<u32>>,
    /// What is written next, as many bits of it as a word has.
    next: u32,
    /// Reads under way.
    due: VecDeque<Due>,
    /// What was read last and must stay.
    held: Option<u32>,
    /// A port is used twice in this cycle.
    misuse: bool,
    ram: PhantomData<R>,
}

impl<R: Ram> Reference for Model<R> {
    type Block = Alone<R>;
    type Config = Config;
    type Setup = Config;
    type Step = Step;
    type Property = Property;
    type Outputs = Moore;
    const NAME: &'static str = "memory";

    fn setups() -> BoxedStrategy<Config> {
        let policy = prop::sample::select(policies(R::PORTS));
        // Words of few bits are packed.
        let bits = prop_oneof![Just(8u32), Just(2)];
        (1..=5u32, bits, 1..=5u32, policy)
            .prop_map(|(words, bits, latency, read_during_write)| Config {
                words,
                bits,
                latency,
                read_during_write,
            })
            .boxed()
    }
    fn steps(_: &Config) -> BoxedStrategy<Step> {
        let rare = || prop::bool::weighted(0.01);
        let step = (any::<Option<u8>>(), any::<Option<u8>>(), rare(), rare());
        step.prop_map(|(read, write, misuse, reset)| Step { read, write, misuse, reset }).boxed()
    }
    fn long() -> Vec<Long<Self>> {
        let step = (any::<Option<u8>>(), any::<Option<u8>>());
        let step = step.prop_map(|(read, write)| Step { read, write, misuse: false, reset: false });
        vec![Long { setup: Self::setups(), step: step.boxed(), steps: LONG }]
    }
    fn small() -> Vec<Config> {
        let mut setups = vec![];
        for (words, bits, latency) in [(1, 1, 1), (1, 2, 2), (1, 2, 3), (2, 2, 1), (2, 2, 2)] {
            setups.extend(policies(R::PORTS).into_iter().map(|read_during_write| Config {
                words,
                bits,
                latency,
                read_during_write,
            }));
        }
        setups
    }
    fn told(cfg: &Config) -> String {
        let Config { words, bits, latency, read_during_write } = cfg;
        let meets = match R::PORTS {
            Ports::One => String::new(),
            Ports::OneReadOneWrite => format!(", read during write {read_during_write:?}"),
        };
        format!("{words} words of {bits} bits, latency {latency}{meets}")
    }
    fn config(cfg: &Config) -> Config {
        *cfg
    }
    fn new(cfg: &Config) -> Model<R> {
        Model {
            cfg: *cfg,
            cycle: 0,
            words: vec![None; cfg.words as usize],
            next: 0,
            due: VecDeque::new(),
            held: None,
            misuse: false,
            ram: PhantomData,
        }
    }

    fn look(&mut self, cycle: u64, seen: &Moore) -> Judged<Property> {
        self.cycle = cycle;
        let Read { valid, data } = seen.q;
        let due = self.due.pop_front_if(|due| due.cycle == cycle);
        match due {
            Some(_) if !valid => {
                return Err((Property::Valid, "low where a read's data is due".to_string()));
            }
            Some(due) if data != due.data => {
                let meets = due.other == Some(data);
                let property = if meets { Property::Meets } else { Property::Data };
                return Err((property, format!("{data} came where {} is due", due.data)));
            }
            None if valid => {
                return Err((Property::Valid, "high where nothing is due".to_string()));
            }
            _ => {}
        }
        if let Some(before) = self.held
            && due.is_none()
            && data != before
        {
            return Err((Property::Held, format!("{before} was there, then {data}")));
        }
        if self.cfg.latency == 1 {
            self.held = due.map(|due| due.data).or(self.held);
        }
        Ok(())
    }

    fn inputs(&mut self, step: &Step, _: &Moore) -> Option<In> {
        if step.reset {
            self.due.clear();
            self.held = None;
            return None;
        }
        let write = step.write.map(|k| u32::from(k) % self.cfg.words);
        let written: Vec<u32> =
            (0..self.cfg.words).filter(|k| self.words[*k as usize].is_some()).collect();
        let one_port = R::PORTS == Ports::One;
        // One port reads or writes, unless it is to be misused.
        let read = step.read.filter(|_| !written.is_empty());
        let read = read.filter(|_| !one_port || write.is_none() || step.misuse);
        let mut read = read.map(|k| written[usize::from(k) % written.len()]);
        if self.cfg.read_during_write == ReadDuringWrite::Forbidden && read == write {
            read = None;
        }
        let both = one_port && read.is_some() && write.is_some();
        self.misuse = step.misuse && (read.is_some() || write.is_some());
        let old = read.and_then(|addr| self.words[addr as usize]);
        if let Some(addr) = write {
            self.words[addr as usize] = Some(self.next);
        }
        if let (Some(addr), Some(old)) = (read, old) {
            let new = self.words[addr as usize].unwrap_or(old);
            let sees_new = self.cfg.read_during_write == ReadDuringWrite::New;
            let (data, other) = if sees_new { (new, old) } else { (old, new) };
            let other = (read == write).then_some(other);
            let cycle = self.cycle + u64::from(self.cfg.latency);
            self.due.push_back(Due { cycle, data, other });
        }
        let data = if write.is_some() { self.next } else { 0 };
        self.next = (self.next + u32::from(write.is_some())) & ((1 << self.cfg.bits) - 1);
        let stream = |addr: Option<u32>| addr.map_or(Stream::idle(), Stream::offer);
        let twice = self.misuse && !both;
        Some(In { read: stream(read), write: stream(write), data, twice })
    }

    fn judge(&mut self, (): &()) -> Judged<Property> {
        if self.misuse {
            return Err((Property::Misuse, "nothing is reported".to_string()));
        }
        Ok(())
    }
    fn fault(&mut self, fault: &Fault) -> Judged<Property> {
        match fault.kind {
            FaultKind::PortUsedTwice(_) if self.misuse => Ok(()),
            _ if self.misuse => Err((Property::Misuse, fault.to_string())),
            _ => Err((Property::Fault, fault.to_string())),
        }
    }
    fn rest(&self) -> Option<Step> {
        (!self.due.is_empty()).then(Step::default)
    }
    fn choices(&self) -> Vec<Step> {
        let words = || [None].into_iter().chain((0..self.cfg.words).map(|k| Some(k as u8)));
        let inputs = words().flat_map(|read| {
            words().map(move |write| Step { read, write, misuse: false, reset: false })
        });
        let misuse = |read, write| Step { read, write, misuse: true, reset: false };
        let misuses = [misuse(Some(0), None), misuse(None, Some(0)), misuse(Some(0), Some(0))];
        let reset = Step { reset: true, ..Step::default() };
        inputs.chain(misuses).chain([reset]).collect()
    }
    fn known(&self, to: &mut Vec<u64>) {
        let number = |word: Option<u32>| word.map_or(0, |word| u64::from(word) + 1);
        to.extend([u64::from(self.next), number(self.held)]);
        to.extend(self.words.iter().map(|word| number(*word)));
        let due = self.due.iter();
        to.extend(due.flat_map(|due| [due.cycle - self.cycle, u64::from(due.data)]));
    }
    fn outputs(seen: &Moore, _: Option<&()>) -> Moore {
        *seen
    }
    fn tell(&self, inputs: &In) -> Vec<String> {
        let twice = if inputs.twice { " twice" } else { "" };
        let twice_written = if inputs.read.valid { "" } else { twice };
        let mut what = vec![];
        what.extend(inputs.read.valid.then(|| format!("read {}{twice}", inputs.read.payload)));
        what.extend(
            inputs.write.valid.then(|| {
                format!("write {} to {}{twice_written}", inputs.data, inputs.write.payload)
            }),
        );
        what
    }
}

/// What can be stated of a read that meets a write.
fn policies(ports: Ports) -> Vec<ReadDuringWrite> {
    use ReadDuringWrite::{Forbidden, New, Old};
    if ports == Ports::One { vec![Forbidden] } else { vec![Old, New, Forbidden] }
}

/// Tests of everything that the contract of a memory asks for: `ram_properties!(MyRam)`, or with a name for
/// the module that they stand in, `ram_properties!(MyRam, mine)`.
#[macro_export]
macro_rules! ram_properties {
    ($ram:ty) => {
        $crate::ram_properties!($ram, ram_properties);
    };
    ($ram:ty, $name:ident $(, $states:ident)?) => {
        $crate::properties!($crate::ram::Model<$ram>, $name $(, $states)?);
    };
}
