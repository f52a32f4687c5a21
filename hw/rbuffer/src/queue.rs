//! The queue of fragments, on chip and outside.
//!
//! ```text
//!            +---------+     room      +---------+
//!  push --+->| outside |-------------->| on chip |---> front
//!         |  +---------+               |         |<--- pop
//!         +--------------------------->+---------+
//!           while nothing is outside
//! ```
//! Order is kept, nothing is lost or doubled. What is pushed goes to the part on chip while nothing is
//! outside and there is room, else outside; what is outside is read back as the part on chip empties. One
//! fragment in and one out a cycle, if the part on chip holds at least `latency + 2`. `ready` is a
//! function of registers; while `full` is low it will rise without a pop.

use pellucid_machine::pixel::{PixelFragment, Screen};
use pellucid_sim::fifo::after;
use pellucid_sim::{Block, bits_for};
use pellucid_sim::{
    Fifo, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, check_range, fifo, rtl,
};

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
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// What is pushed, taken where `ready` is high.
    #[with(cfg.screen)]
    pub push: Stream<PixelFragment>,
    /// The front is taken. Without effect while nothing is at the front.
    pub pop: bool,
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
    /// A fragment goes outside in this cycle.
    pub spilled: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The part on chip.
    pub on_chip: <OnChip as Block>::Mem,
    /// The part outside.
    pub outside: Ram1R1W<PixelFragment>,
}

type OnChip = Fifo<PixelFragment>;

#[rtl(
    output = (),
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
        State { on_chip, head: 0, tail: 0, outside: 0, flying: 0 }
    }

    fn memories(cfg: &Config) -> Mem {
        let outside =
            Ram1R1W::new(cfg.outside, cfg.screen, cfg.latency, ReadDuringWrite::Forbidden);
        Mem { on_chip: OnChip::memories(&cfg.on_chip()), outside: outside.outside() }
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Moore {
        let on_chip = OnChip::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        let direct = q.outside == 0 && q.flying == 0 && on_chip.ready;
        let elsewhere = if cfg.outside > 0 { q.flying + q.outside } else { 0 };
        let count = on_chip.count + elsewhere;
        Moore {
            ready: direct || q.outside < cfg.outside,
            full: count == cfg.on_chip + cfg.outside,
            count,
            front: on_chip.front,
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let on_chip = OnChip::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        let direct = q.outside == 0 && q.flying == 0 && on_chip.ready;
        let mut spilled = false;
        let mut back = Stream::idle();
        if cfg.outside > 0 {
            spilled = i.push.valid && !direct && q.outside < cfg.outside;
            if spilled {
                m.outside.write(q.tail, i.push.payload);
                d.tail = after(cfg.outside, q.tail);
            }
            let read = q.outside > 0 && on_chip.count + q.flying < cfg.on_chip;
            if read {
                m.outside.read(q.head);
                d.head = after(cfg.outside, q.head);
            }
            let read_back = m.outside.q();
            back = Stream { valid: read_back.valid, payload: read_back.data };
            d.outside = q.outside + u32::from(spilled) - u32::from(read);
            m.outside.holds(d.outside);
            d.flying = q.flying + u32::from(read) - u32::from(back.valid);
        }
        let pushed = Stream { valid: i.push.valid && direct, payload: i.push.payload };
        // While something is on its way from outside, nothing is pushed directly.
        let push = if back.valid { back } else { pushed };
        let to_on_chip = fifo::In { push, pop: i.pop };
        OnChip::next(&cfg.on_chip(), &q.on_chip, &mut d.on_chip, &mut m.on_chip, to_on_chip);
        Out { spilled }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{edge, queue};
    use pellucid_sim::Label;
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
    fn compare(cfg: Config, asked: &[(bool, bool)]) -> Result<u32, TestCaseError> {
        let (mut q, mut m) = (Queue::reset(&cfg), Queue::memories(&cfg));
        let mut reference = VecDeque::new();
        let capacity = (cfg.on_chip + cfg.outside) as usize;
        let (mut pushed, mut popped, mut waits) = (0, 0, [0; 2]);
        for (push, pop) in asked {
            let seen = Queue::moore(&cfg, &q, &m);
            prop_assert_eq!(seen.count as usize, reference.len());
            prop_assert_eq!(seen.full, reference.len() == capacity);
            prop_assert!(!(seen.full && seen.ready));
            let front = seen.front.valid.then_some(seen.front.payload);
            prop_assert!(front.is_none() || front == reference.front().copied());
            // What is not full, or not empty, says so after the latency at the latest.
            let late = [!seen.full && !seen.ready, front.is_none() && !reference.is_empty()];
            for (late, waits) in late.into_iter().zip(&mut waits) {
                *waits = if late { *waits + 1 } else { 0 };
                prop_assert!(*waits <= cfg.latency + 2, "it waits for {waits} cycles");
            }
            let offer = fragment(pushed);
            let mut d = q;
            let i =
                In { push: if *push { Stream::offer(offer) } else { Stream::idle() }, pop: *pop };
            Queue::next(&cfg, &q, &mut d, &mut m, i);
            if *pop && front.is_some() {
                reference.pop_front();
                popped += 1;
            }
            if *push && seen.ready {
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
            asked in proptest::collection::vec((any::<bool>(), any::<bool>()), 1..300),
        ) {
            compare(queue(on_chip, outside, latency), &asked)?;
        }
    }

    #[test]
    fn one_in_and_one_out_a_cycle_through_outside_memory() {
        let latency = 5;
        let cfg = queue(latency + 2, 64, latency);
        let mut asked = vec![(true, false); 40];
        asked.extend(vec![(true, true); 500]);
        assert_eq!(compare(cfg, &asked).unwrap(), 500);
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
