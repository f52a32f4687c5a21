//! A machine with the memory outside of its chip.
//!
//! The words are kept here; when a request is taken and when a read is answered is the [`Timing`]'s to say.

use crate::machine::Machine;
use crate::outside::{self, In, Outside, Table, Wires, Word};
use pellucid_sim::{Block, Figure, Memory, Ram1RW, Storage, Stream};
use std::collections::VecDeque;
use std::marker::PhantomData;

/// When an outside memory takes requests and answers them.
pub trait Timing {
    /// A request is taken in the coming cycle, whatever it is.
    fn ready(&self) -> bool;
    /// The oldest read that was not answered is answered in the coming cycle, or is on offer already.
    fn answers(&self) -> bool;
    /// Nothing is under way, and nothing changes until something is asked: cycles in which nothing is need not be told.
    fn idle(&self) -> bool;
    /// Cycles in which nothing may be taken or answered while something is under way, at most: how long the oldest read may wait while
    /// nothing else is asked.
    fn longest(&self) -> u64;
    /// A cycle: which request was taken, if one was, and whether an answer was.
    fn cycle(&mut self, asked: Option<Asked>, answered: bool);
    /// Forgets all that is under way.
    fn reset(&mut self);
    /// What it has counted.
    fn figures(&self) -> Vec<Figure> {
        vec![]
    }
    /// Counts from here on.
    fn count_anew(&mut self) {}
}

/// A request as far as its time depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// It writes.
    pub write: bool,
    /// The word's number.
    pub address: u32,
}

/// A request a cycle, each read answered after a fixed number of cycles.
#[derive(Clone, Debug)]
pub struct Fixed {
    latency: u32,
    now: u64,
    /// When the reads under way are answered.
    due: VecDeque<u64>,
}

impl Fixed {
    /// Reads are answered after `latency` cycles, at least 1.
    pub fn new(latency: u32) -> Fixed {
        Fixed { latency, now: 0, due: VecDeque::new() }
    }
}

impl Timing for Fixed {
    fn ready(&self) -> bool {
        true
    }
    fn answers(&self) -> bool {
        self.due.front().is_some_and(|due| *due <= self.now)
    }
    fn idle(&self) -> bool {
        self.due.is_empty()
    }
    fn longest(&self) -> u64 {
        self.latency.into()
    }
    fn cycle(&mut self, asked: Option<Asked>, answered: bool) {
        if answered {
            self.due.pop_front();
        }
        if asked.is_some_and(|asked| !asked.write) {
            self.due.push_back(self.now + u64::from(self.latency));
        }
        self.now += 1;
    }
    fn reset(&mut self) {
        self.due.clear();
    }
}

/// A table in outside memory.
struct Region {
    path: String,
    size: u32,
    words: Ram1RW<Word>,
}

/// An outside memory.
struct OutsideMemory {
    regions: Vec<Region>,
    timing: Box<dyn Timing>,
    /// Words that were read and not answered.
    answers: VecDeque<Word>,
    shows: In,
    /// What was done at the port, in cycles in which it works.
    wires: Wires,
    works: bool,
    idle: bool,
}

impl OutsideMemory {
    fn new(Outside { tables, latency }: Outside) -> OutsideMemory {
        let region = |Table { path, words, bits }| {
            let port = outside::Config { words, bits };
            Region { path, size: words, words: Ram1RW::new(words, port, 1).outside() }
        };
        let mut memory = OutsideMemory {
            regions: tables.into_iter().map(region).collect(),
            timing: Box::new(Fixed::new(latency)),
            answers: VecDeque::new(),
            shows: In::default(),
            wires: Wires::default(),
            works: false,
            idle: false,
        };
        memory.show();
        memory
    }

    /// What is done at the port in this cycle.
    #[inline(always)]
    fn port(&mut self, wires: Wires) {
        self.works = !self.idle || wires.request.valid;
        if self.works {
            self.wires = wires;
        }
    }

    fn set_timing(&mut self, timing: Box<dyn Timing>) {
        self.timing = timing;
        self.show();
    }

    /// What the coming cycle shows.
    fn show(&mut self) {
        let word = self.answers.front().copied().unwrap_or_default();
        let response = Stream { valid: self.timing.answers(), payload: word };
        self.shows = In { ready: self.timing.ready(), response };
        self.idle = self.timing.idle();
    }

    #[inline(never)]
    fn work(&mut self) -> bool {
        let Wires { request, response } = self.wires;
        if response.fires() {
            self.answers.pop_front();
        }
        let asked = request.payload;
        let mut fault = false;
        if request.fires() {
            let (address, words) = region(&mut self.regions, asked.address);
            if asked.write {
                words.write(address, asked.word);
            } else {
                words.read(address);
            }
            fault = words.clock();
            if !asked.write {
                self.answers.push_back(words.q().data);
            }
        }
        let what = Asked { write: asked.write, address: asked.address };
        self.timing.cycle(request.fires().then_some(what), response.fires());
        self.show();
        fault
    }
}

/// The table that has the word of that number, and the word's number in it. What lies behind all of them is the last one's.
#[inline]
fn region(regions: &mut [Region], mut address: u32) -> (u32, &mut Ram1RW<Word>) {
    let (last, others) = regions.split_last_mut().expect("a table in outside memory");
    for Region { size, words, .. } in others {
        if address < *size {
            return (address, words);
        }
        address -= *size;
    }
    (address, &mut last.words)
}

impl Memory for OutsideMemory {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        self.works && self.work()
    }
    fn reset(&mut self) {
        for region in &mut self.regions {
            region.words.reset();
        }
        self.timing.reset();
        self.answers.clear();
        self.works = false;
        self.show();
    }
    fn visit(&mut self, _: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        for Region { path, words, .. } in &mut self.regions {
            to(path, words);
        }
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        for region in &mut self.regions {
            to(&mut region.words);
        }
    }
}

/// All memories: the machine's own, and the one outside if there is one.
pub struct Memories<M: Machine> {
    machine: M::Mem,
    outside: Option<OutsideMemory>,
}

impl<M: Machine> Memories<M> {
    /// What the outside memory shows in the coming cycle.
    #[inline(always)]
    pub fn outside(&self) -> In {
        self.outside.as_ref().map_or(In::default(), |memory| memory.shows)
    }
    /// Nothing is under way outside.
    pub fn idle(&self) -> bool {
        self.outside.as_ref().is_none_or(|memory| memory.idle)
    }
    /// Those of the machine.
    pub fn machine(&mut self) -> &mut M::Mem {
        &mut self.machine
    }
    /// What the outside memory's timing has counted.
    pub fn figures(&self) -> Vec<Figure> {
        self.outside.as_ref().map_or(vec![], |memory| memory.timing.figures())
    }
    /// [`Timing::longest`] of the outside memory; 0 if there is none.
    pub fn longest(&self) -> u64 {
        self.outside.as_ref().map_or(0, |memory| memory.timing.longest())
    }
    /// Counts that from here on.
    pub fn count_anew(&mut self) {
        if let Some(memory) = &mut self.outside {
            memory.timing.count_anew();
        }
    }
    /// Another timing for the outside memory, at power-up.
    pub fn set_timing(&mut self, timing: Box<dyn Timing>) {
        if let Some(memory) = &mut self.outside {
            memory.set_timing(timing);
        }
    }
}

impl<M: Machine> Memory for Memories<M> {
    #[inline(always)]
    fn clock(&mut self) -> bool {
        let fault = self.machine.clock();
        let outside = self.outside.as_mut().is_some_and(|memory| memory.clock());
        fault | outside
    }
    fn reset(&mut self) {
        self.machine.reset();
        if let Some(memory) = &mut self.outside {
            memory.reset();
        }
    }
    fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
        self.machine.visit(path, to);
        if let Some(memory) = &mut self.outside {
            memory.visit(path, to);
        }
    }
    fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
        self.machine.each(to);
        if let Some(memory) = &mut self.outside {
            memory.each(to);
        }
    }
}

/// See the module's description. Its inputs are the machine's: what [`Memories::outside`] shows is among them.
pub struct Board<M>(PhantomData<M>);

impl<M: Machine> Block for Board<M> {
    type Config = M::Config;
    type State = M::State;
    type In = M::In;
    type Moore = M::Moore;
    type Out = M::Out;
    type Mem = Memories<M>;

    fn reset(cfg: &M::Config) -> M::State {
        M::reset(cfg)
    }

    fn memories(cfg: &M::Config) -> Memories<M> {
        let outside = M::outside(cfg).map(OutsideMemory::new);
        Memories { machine: M::memories(cfg), outside }
    }

    #[inline(always)]
    fn moore(cfg: &M::Config, q: &M::State, m: &Memories<M>) -> M::Moore {
        M::moore(cfg, q, &m.machine)
    }

    #[inline(always)]
    fn next(
        cfg: &M::Config,
        q: &M::State,
        d: &mut M::State,
        m: &mut Memories<M>,
        i: M::In,
    ) -> M::Out {
        let out = M::next(cfg, q, d, &mut m.machine, i);
        if let Some(memory) = &mut m.outside {
            memory.port(M::ports(cfg, &out).outside);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outside::Request;
    use pellucid_sim::{FaultKind, Label};
    use proptest::prelude::*;

    fn memory(latency: u32) -> OutsideMemory {
        let table = |path: &str, words| Table { path: path.to_string(), words, bits: 80 };
        OutsideMemory::new(Outside { tables: vec![table("low", 3), table("high", 5)], latency })
    }

    fn word(number: u64) -> Word {
        Word { low: number, high: number & 0xffff, label: Label::NONE }
    }

    fn write(address: u32, number: u64) -> Option<Request> {
        Some(Request { write: true, address, word: word(number) })
    }

    fn read(address: u32) -> Option<Request> {
        Some(Request { write: false, address, word: Word::default() })
    }

    /// A cycle: what is offered, and whether an answer is taken; gives whether there was a fault.
    fn cycle(memory: &mut OutsideMemory, offer: Option<Request>, takes: bool) -> bool {
        let shown = memory.shows;
        let offer = offer.map_or(Stream::idle(), Stream::offer);
        memory
            .port(Wires { request: offer.with(shown.ready), response: shown.response.with(takes) });
        memory.clock()
    }

    #[test]
    fn a_read_is_answered_after_the_latency_and_reads_are_pipelined() {
        for latency in [1, 2, 7] {
            let mut memory = memory(latency);
            for address in 0..8 {
                cycle(&mut memory, write(address, 100 + u64::from(address)), true);
            }
            let mut seen = vec![];
            for at in 0..8 + latency {
                let response = memory.shows.response;
                seen.extend(response.valid.then_some((at, response.payload)));
                cycle(&mut memory, if at < 8 { read(at) } else { None }, true);
            }
            let expected: Vec<_> =
                (0..8).map(|k| (k + latency, word(100 + u64::from(k)))).collect();
            assert_eq!(seen, expected, "latency {latency}");
        }
    }

    #[test]
    fn an_address_beyond_the_last_word_is_a_fault() {
        let mut memory = memory(3);
        assert!(!cycle(&mut memory, write(7, 1), true));
        assert!(cycle(&mut memory, read(8), true));
        let mut found = vec![];
        memory.visit("", &mut |path, storage| found.push((path.to_string(), storage.take_fault())));
        let fault = FaultKind::Address { addr: 5, words: 5 };
        assert_eq!(found, [("low".to_string(), None), ("high".to_string(), Some(fault))]);
    }

    #[test]
    fn the_traffic_of_each_table_is_counted() {
        let mut memory = memory(1);
        for address in 0..8 {
            cycle(&mut memory, write(address, 7), true);
        }
        for address in [0, 7, 6] {
            cycle(&mut memory, read(address), true);
        }
        let mut found = vec![];
        memory.visit("", &mut |path, storage| {
            let info = storage.info();
            found.push((path.to_string(), info.reads, info.writes));
        });
        assert_eq!(found, [("low".to_string(), 1, 3), ("high".to_string(), 2, 5)]);
    }

    #[test]
    fn a_reset_forgets_answers_and_keeps_words() {
        let mut memory = memory(2);
        cycle(&mut memory, write(3, 9), true);
        cycle(&mut memory, read(3), true);
        memory.reset();
        for _ in 0..5 {
            assert!(!memory.shows.response.valid);
            cycle(&mut memory, None, true);
        }
        cycle(&mut memory, read(3), true);
        cycle(&mut memory, None, true);
        assert_eq!(memory.shows.response, Stream::offer(word(9)));
    }

    /// Takes requests in some cycles, and answers each read after a time of its own.
    struct Moody {
        ready: Vec<bool>,
        delays: Vec<u64>,
        now: u64,
        reads: usize,
        due: VecDeque<u64>,
    }

    impl Timing for Moody {
        fn ready(&self) -> bool {
            self.ready[self.now as usize % self.ready.len()]
        }
        fn answers(&self) -> bool {
            self.due.front().is_some_and(|due| *due <= self.now)
        }
        fn idle(&self) -> bool {
            false
        }
        fn longest(&self) -> u64 {
            self.delays.iter().copied().max().unwrap_or(0)
        }
        fn cycle(&mut self, asked: Option<Asked>, answered: bool) {
            if answered {
                self.due.pop_front();
            }
            if asked.is_some_and(|asked| !asked.write) {
                self.due.push_back(self.now + self.delays[self.reads % self.delays.len()]);
                self.reads += 1;
            }
            self.now += 1;
        }
        fn reset(&mut self) {
            self.due.clear();
        }
    }

    proptest! {
        /// Whatever the timing, reads give what was written before them, in their order, each until it is taken.
        #[test]
        fn behaves_as_a_plain_array(
            mut ready in proptest::collection::vec(any::<bool>(), 0..6),
            delays in proptest::collection::vec(1u64..9, 1..6),
            takes in proptest::collection::vec(any::<bool>(), 1..6),
            accesses in proptest::collection::vec((any::<bool>(), 0u32..8), 0..60),
        ) {
            ready.push(true);
            let mut memory = memory(1);
            memory.set_timing(Box::new(Moody { ready, delays, now: 0, reads: 0, due: VecDeque::new() }));
            // Every word holds something from the start.
            let start = (0..8).map(|address| (true, address));
            let accesses: Vec<(bool, u32)> = start.chain(accesses).collect();
            let (mut array, mut expected, mut seen) = ([0; 8], vec![], vec![]);
            let (mut next, mut held) = (0, None);
            for at in 0.. {
                let shown = memory.shows;
                let taken = *takes.get(at % takes.len()).unwrap() || at > 500;
                let answer = shown.response.valid.then_some(shown.response.payload);
                prop_assert!(held.is_none() || held == answer, "an answer is withdrawn");
                held = if taken { None } else { answer };
                seen.extend(answer.filter(|_| taken));
                let offer = accesses.get(next).and_then(|(writes, address)| {
                    if *writes { write(*address, next as u64) } else { read(*address) }
                });
                if let Some(request) = offer && shown.ready {
                    let word = &mut array[request.address as usize];
                    if request.write {
                        *word = next as u64;
                    } else {
                        expected.push(*word);
                    }
                    next += 1;
                }
                prop_assert!(!cycle(&mut memory, offer, taken));
                if next == accesses.len() && seen.len() == expected.len() {
                    break;
                }
                prop_assert!(at < 5000, "not all is answered");
            }
            let expected: Vec<Word> = expected.into_iter().map(word).collect();
            prop_assert_eq!(seen, expected);
        }
    }
}
