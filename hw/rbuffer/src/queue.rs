//! The queue of fragments, on chip and outside.
//!
//! ```text
//!            +---------+               +---------+
//!  push --+->| outside |-------------->| on chip |---> front
//!         |  +---------+               |         |<--- pop
//!         +--------------------------->+---------+
//!           while nothing is outside
//! ```
//! Order is kept, nothing is lost or doubled. What is pushed goes to the part on chip while nothing is
//! outside and there is room, else outside; what is outside is read back as the part on chip empties. On chip one
//! fragment in and one out a cycle. Through outside memory one in and one out in two cycles, since its port takes a
//! request a cycle, if the part on chip holds what is under way: writes and reads take turns where both wait. `ready`
//! is a function of registers; while `full` is low it will rise without a pop.

use pellucid_blocks::skid::{self, Skid};
use pellucid_machine::outside::{self, Outside, Request, Table};
use pellucid_machine::pixel::{PixelFragment, RGBA_BITS, Screen, Z_BITS};
use pellucid_sim::fifo::after;
use pellucid_sim::{Block, bits_for};
use pellucid_sim::{Fifo, Memory, Signals, Stream, check_range, fifo, rtl};

/// See the module's description.
pub struct Queue;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Fragments on chip, at least 2.
    pub on_chip: u32,
    /// Fragments outside; may be 0.
    pub outside: u32,
    /// Cycles from a read request to outside memory to its data, at least 1.
    pub latency: u32,
    /// The screen.
    pub screen: Screen,
}

impl Config {
    fn on_chip(&self) -> fifo::Config<Screen> {
        fifo::Config { depth: self.on_chip, item: self.screen }
    }
    fn address_bits(&self) -> u32 {
        bits_for(u64::from(self.outside.max(1) - 1))
    }
    /// The port to the part outside, a fragment a word.
    pub fn port(&self) -> outside::Config {
        if self.outside == 0 {
            return outside::Config::NONE;
        }
        let bits = self.screen.pixel_bits() + Z_BITS + RGBA_BITS;
        outside::Config { words: self.outside, bits }
    }
    /// The memory behind it.
    pub fn outside_memory(&self) -> Option<Outside> {
        let outside::Config { words, bits } = self.port();
        let table = || Table { path: "queue.outside".to_string(), words, bits };
        (words > 0).then(|| Outside { tables: vec![table()], latency: self.latency })
    }
    /// Bits of how many fragments are in.
    pub fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.on_chip) + u64::from(self.outside))
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The part on chip.
    #[with(cfg.on_chip)]
    pub on_chip: fifo::State,
    /// The oldest fragment outside.
    #[exists(cfg.outside > 0)]
    #[width(cfg.address_bits())]
    pub head: u32,
    /// Where the next one goes.
    #[exists(cfg.outside > 0)]
    #[width(cfg.address_bits())]
    pub tail: u32,
    /// How many are outside.
    #[exists(cfg.outside > 0)]
    #[width(bits_for(u64::from(cfg.outside)))]
    pub outside: u32,
    /// How many are on their way from there.
    #[exists(cfg.outside > 0)]
    #[width(bits_for(u64::from(cfg.on_chip)))]
    pub flying: u32,
    /// The last request was a write: a read that waits has its turn.
    #[exists(cfg.outside > 0)]
    pub wrote: bool,
    /// A request that the outside memory did not take yet.
    #[with(cfg.port())]
    #[exists(cfg.outside > 0)]
    pub requests: skid::State<Request>,
}

type Requests = Skid<Request>;

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// What is pushed, taken where `ready` is high.
    #[with(cfg.screen)]
    pub push: Stream<PixelFragment>,
    /// The front is taken. Without effect while nothing is at the front.
    pub pop: bool,
    /// What the outside memory shows.
    #[with(cfg.port())]
    #[exists(cfg.outside > 0)]
    pub outside: outside::In,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// There is room now.
    pub ready: bool,
    /// There is no room until something is popped.
    pub full: bool,
    /// How many are in.
    #[width(cfg.count_bits())]
    pub count: u32,
    /// The oldest fragment. It may come in late if it was outside.
    #[with(cfg.screen)]
    pub front: Stream<PixelFragment>,
}

/// Outputs. The default is what the queue shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// What is asked of the outside memory.
    #[with(cfg.port())]
    #[exists(cfg.outside > 0)]
    pub request: Stream<Request>,
    /// A fragment goes outside in this cycle.
    pub spilled: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The part on chip.
    pub on_chip: <OnChip as Block>::Mem,
}

type OnChip = Fifo<PixelFragment>;

/// A fragment as a word of outside memory.
#[inline(always)]
#[rtl]
fn packed(PixelFragment { pixel, z, rgba, label }: PixelFragment) -> outside::Word {
    outside::packed(z, rgba, pixel, label)
}

/// The fragment that a word of outside memory holds.
#[inline(always)]
#[rtl]
fn unpacked(word: outside::Word) -> PixelFragment {
    let (z, rgba) = (outside::depth(word), outside::colour(word));
    PixelFragment { pixel: outside::beside(word), z, rgba, label: word.label }
}

/// What the part outside may do in a cycle.
#[derive(Clone, Copy, Debug, Signals)]
struct Turn {
    /// A push goes on chip.
    direct: bool,
    /// A push goes outside.
    writes: bool,
    /// A fragment is read back, unless one is pushed there.
    reads: bool,
}

#[rtl]
impl Config {
    #[inline(always)]
    fn turn(&self, outside: u32, flying: u32, on_chip: u32, room: bool, wrote: bool) -> Turn {
        let direct = outside == 0 && flying == 0 && on_chip < self.on_chip;
        let reads = room && outside > 0 && on_chip + flying < self.on_chip;
        let writes = room && !direct && outside < self.outside && !(reads && wrote);
        Turn { direct, writes, reads }
    }
}

#[rtl(
    check(Queue, crate::test_util::queue(2, 5, 3)),
    check(Queue, crate::test_util::queue(4, 0, 1))
)]
impl Block for Queue {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the number of fragments on chip", cfg.on_chip, 2..);
        check_range("the latency of outside memory", cfg.latency, 1..);
        let on_chip = OnChip::reset(&cfg.on_chip());
        let requests = Requests::reset(&cfg.port());
        State { on_chip, head: 0, tail: 0, outside: 0, flying: 0, wrote: false, requests }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { on_chip: OnChip::memories(&cfg.on_chip()) }
    }

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let on_chip = OnChip::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        let mut ready = on_chip.ready;
        let mut count = on_chip.count;
        if cfg.outside > 0 {
            let room = Requests::moore(&cfg.port(), &q.requests, &()).ready;
            let turn = cfg.turn(q.outside, q.flying, on_chip.count, room, q.wrote);
            ready = turn.direct || turn.writes;
            count = on_chip.count + q.flying + q.outside;
        }
        let full = count == cfg.on_chip + cfg.outside;
        Moore { ready, full, count, front: on_chip.front }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let mut push = i.push;
        let mut request = Stream::idle();
        let mut spilled = false;
        if cfg.outside > 0 {
            let on_chip = OnChip::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip).count;
            let room = Requests::moore(&cfg.port(), &q.requests, &()).ready;
            let turn = cfg.turn(q.outside, q.flying, on_chip, room, q.wrote);
            spilled = i.push.valid && turn.writes;
            let read = turn.reads && !spilled;
            let mut asked = Stream::idle();
            if spilled {
                let word = packed(i.push.payload);
                asked = Stream::offer(Request { write: true, address: q.tail, word });
                d.tail = after(cfg.outside, q.tail);
                d.wrote = true;
            } else if read {
                let word = outside::Word::default();
                asked = Stream::offer(Request { write: false, address: q.head, word });
                d.head = after(cfg.outside, q.head);
                d.wrote = false;
            }
            let to_requests = skid::In { push: asked, taken: i.outside.ready };
            request =
                Requests::next(&cfg.port(), &q.requests, &mut d.requests, &mut (), to_requests);
            let back = i.outside.response;
            d.outside = q.outside + u32::from(spilled) - u32::from(read);
            d.flying = q.flying + u32::from(read) - u32::from(back.valid);
            // While something is on its way from outside, nothing is pushed directly.
            push.valid = i.push.valid && turn.direct;
            if back.valid {
                push = Stream::offer(unpacked(back.payload));
            }
        }
        let to_on_chip = fifo::In { push, pop: i.pop };
        OnChip::next(&cfg.on_chip(), &q.on_chip, &mut d.on_chip, &mut m.on_chip, to_on_chip);
        Out { request, spilled }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::behind::Behind;
    use crate::test_util::{Pattern, edge, pattern, queue};
    use pellucid_machine::pixel::MOST_PIXEL_BITS;
    use pellucid_sim::{Label, StreamMonitor};
    use proptest::prelude::*;
    use std::collections::VecDeque;

    fn fragment(number: u32) -> PixelFragment {
        PixelFragment {
            pixel: number % 15,
            z: number,
            rgba: number << 3,
            label: Label::new(number, 0, 0),
        }
    }

    /// Pushes and pops as `asked`, against a plain queue; gives how many fragments came out.
    fn compare(cfg: Config, ready: &Pattern, asked: &[(bool, bool)]) -> Result<u32, TestCaseError> {
        let (mut q, mut m) = (Queue::reset(&cfg), Queue::memories(&cfg));
        let mut memory = Behind::new(cfg.outside, ready.clone(), vec![cfg.latency.into()]);
        let mut requests = StreamMonitor::new("request", "queue", "test");
        let mut fronts = StreamMonitor::new("front", "queue", "test");
        let mut reference = VecDeque::new();
        let capacity = (cfg.on_chip + cfg.outside) as usize;
        let (mut pushed, mut popped, mut waits) = (0, 0, [0; 2]);
        for (cycle, (push, pop)) in (0..).zip(asked) {
            let seen = Queue::moore(&cfg, &q, &m);
            prop_assert_eq!(seen.count as usize, reference.len());
            prop_assert_eq!(seen.full, reference.len() == capacity);
            prop_assert!(!(seen.full && seen.ready));
            let front = seen.front.valid.then_some(seen.front.payload);
            prop_assert!(front.is_none() || front == reference.front().copied());
            // What is not full, or not empty, says so after the latency at the latest, in a memory that takes requests.
            let late = [!seen.full && !seen.ready, front.is_none() && !reference.is_empty()];
            for (late, waits) in late.into_iter().zip(&mut waits) {
                *waits = if late && ready.at(cycle) { *waits + 1 } else { 0 };
                prop_assert!(*waits <= cfg.latency + 3, "it waits for {waits} cycles");
            }
            let offer = fragment(pushed);
            let mut d = q;
            let shown = memory.shows(cycle);
            let push = if *push { Stream::offer(offer) } else { Stream::idle() };
            let i = In { push, pop: *pop, outside: shown };
            let out = Queue::next(&cfg, &q, &mut d, &mut m, i);
            requests.observe(out.request.with(shown.ready)).unwrap();
            fronts.observe(seen.front.with(*pop)).unwrap();
            memory.edge(cycle, out.request);
            if *pop && front.is_some() {
                reference.pop_front();
                popped += 1;
            }
            if push.valid && seen.ready {
                reference.push_back(offer);
                pushed += 1;
            }
            q = d;
            edge(&mut m);
        }
        Ok(popped)
    }

    proptest! {
        #[test]
        fn behaves_as_a_queue(
            on_chip in 2..9_u32,
            outside in prop_oneof![Just(0), 1..12_u32],
            latency in 1..6_u32,
            ready in prop_oneof![Just(Pattern::always()), pattern()],
            asked in proptest::collection::vec((any::<bool>(), any::<bool>()), 1..300),
        ) {
            compare(queue(on_chip, outside, latency), &ready, &asked)?;
        }

        #[test]
        fn a_fragment_comes_back_from_outside_as_it_was(
            pixel in 0u32..1 << MOST_PIXEL_BITS,
            z in 0u32..1 << Z_BITS,
            rgba: u32,
        ) {
            let fragment = PixelFragment { pixel, z, rgba, label: Label::new(1, 2, 3) };
            prop_assert_eq!(unpacked(packed(fragment)), fragment);
        }
    }

    /// Each way has every other cycle of the port.
    #[test]
    fn one_in_and_one_out_in_two_cycles_through_outside_memory() {
        let latency = 5;
        let cfg = queue(latency + 2, 64, latency);
        let mut asked = vec![(true, false); 60];
        asked.extend(vec![(true, true); 500]);
        let popped = compare(cfg, &Pattern::always(), &asked).unwrap();
        // What is on chip when it begins goes first.
        let first = cfg.on_chip;
        assert!((250..=250 + first).contains(&popped), "{popped}");
    }

    #[test]
    fn one_in_and_one_out_a_cycle_on_chip() {
        let mut asked = vec![(true, false); 3];
        asked.extend(vec![(true, true); 500]);
        assert_eq!(compare(queue(8, 64, 5), &Pattern::always(), &asked).unwrap(), 500);
    }

    #[test]
    #[should_panic(expected = "the number of fragments on chip is 1: expected at least 2")]
    fn both_ends_are_on_chip() {
        Queue::reset(&queue(1, 5, 3));
    }

    #[test]
    #[should_panic(expected = "the latency of outside memory is 0: expected at least 1")]
    fn outside_memory_answers_later() {
        Queue::reset(&queue(2, 5, 0));
    }
}
