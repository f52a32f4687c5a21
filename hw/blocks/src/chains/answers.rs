//! Brings the answers of sections on chip and outside into the order in which they were asked for.
//!
//! ```text
//!                +---------+
//!  oldest ------>|         |
//!  on_chip ----->| Answers |---> word (Read)
//!  outside ----->|         |
//!                +---------+
//! ```
//! Each side answers in order, at its own pace. What comes before its turn waits in a queue of its side; what
//! comes in its turn is passed on in the same cycle. One answer a cycle. The queues hold as many as may be under way, so that
//! both sides can always answer. Where there are sections on one side alone there is no queue; but where weights are kept in
//! memory one for those on chip, as a fragment that is put to its place holds up the answers.

use super::config::Config;
use super::tables::{Word, unpacked};
use pellucid_machine::outside;
use pellucid_sim::{Block, Fifo, Memory, Read, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Answers;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Answers of sections on chip.
    #[with(cfg.shape.reads_in_flight)]
    #[exists(cfg.holds_answers())]
    pub on_chip: fifo::State,
    /// Answers of sections outside.
    #[with(cfg.shape.reads_in_flight)]
    #[exists(cfg.mixes())]
    pub outside: fifo::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Answers of sections on chip.
    pub on_chip: <Queue as Block>::Mem,
    /// Answers of sections outside.
    pub outside: <Queue as Block>::Mem,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A read is under way; whether the oldest one went outside.
    pub oldest: Stream<bool>,
    /// What sections on chip and outside answer.
    #[with(*cfg)]
    pub words: Words,
}

/// What the section memories show in a cycle.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Words {
    /// Those on chip.
    #[with(*cfg)]
    pub on_chip: Read<Word>,
    /// Those outside.
    #[with(*cfg)]
    pub outside: Read<Word>,
}

#[rtl]
impl Words {
    /// What they show, where the memory outside answers so.
    #[inline(always)]
    pub fn of(on_chip: Read<Word>, response: Stream<outside::Word>) -> Words {
        let outside = Read { valid: response.valid, data: unpacked(response.payload) };
        Words { on_chip, outside }
    }
}

type Queue = Fifo<Word>;

#[inline(always)]
fn queue(cfg: &Config) -> fifo::Config<Config> {
    fifo::Config { depth: cfg.shape.reads_in_flight, item: *cfg }
}

impl Config {
    /// Whether there are sections on chip and outside.
    #[inline]
    pub fn mixes(&self) -> bool {
        self.shape.outside > 0 && self.first_outside() > 0
    }
    /// Whether answers of sections on chip may have to wait for their turn.
    #[inline]
    pub fn holds_answers(&self) -> bool {
        self.mixes() || self.weighs()
    }
}

/// What the queue of a side is told: an answer that came waits if others do, or if it is not the side's turn.
#[inline(always)]
#[rtl]
fn to_queue(came: Read<Word>, others_wait: bool, turn: bool) -> fifo::In<Word> {
    let waits = came.valid && (others_wait || !turn);
    fifo::In { push: Stream { valid: waits, payload: came.data }, pop: turn }
}

#[rtl(
    check(Answers, crate::test_util::small(true)),
    check(Answers, crate::test_util::small_of(13, 0))
)]
impl Block for Answers {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Read<Word>;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State { on_chip: Queue::reset(&queue(cfg)), outside: Queue::reset(&queue(cfg)) }
    }

    fn memories(cfg: &Config) -> Mem {
        let queue = |exists| {
            let depth = if exists { cfg.shape.reads_in_flight } else { 0 };
            Queue::memories(&fifo::Config { depth, item: *cfg })
        };
        Mem { on_chip: queue(cfg.holds_answers()), outside: queue(cfg.mixes()) }
    }

    fn moore(_: &Config, _: &State, _: &Mem) {}

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Read<Word> {
        let mut word = if i.words.outside.valid { i.words.outside } else { i.words.on_chip };
        if cfg.holds_answers() {
            let queue = queue(cfg);
            let on_chip = Queue::moore(&queue, &q.on_chip, &m.on_chip).front;
            let turn_of_chip = i.oldest.valid && !i.oldest.payload;
            let to_on_chip = to_queue(i.words.on_chip, on_chip.valid, turn_of_chip);
            Queue::next(&queue, &q.on_chip, &mut d.on_chip, &mut m.on_chip, to_on_chip);
            let (mut waited, mut came) = (on_chip, i.words.on_chip);
            if cfg.mixes() {
                let outside = Queue::moore(&queue, &q.outside, &m.outside).front;
                let turn_of_outside = i.oldest.valid && i.oldest.payload;
                let to_outside = to_queue(i.words.outside, outside.valid, turn_of_outside);
                Queue::next(&queue, &q.outside, &mut d.outside, &mut m.outside, to_outside);
                if i.oldest.payload {
                    waited = outside;
                    came = i.words.outside;
                }
            }
            word = Read {
                valid: i.oldest.valid && (waited.valid || came.valid),
                data: if waited.valid { waited.payload } else { came.data },
            };
        }
        word
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::small;
    use pellucid_sim::Sim;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    fn word(number: u32) -> Word {
        Word { z: number, ..Word::default() }
    }

    fn answer(at: &mut VecDeque<(usize, u32)>, cycle: usize) -> Read<Word> {
        match at.front() {
            Some((due, number)) if *due <= cycle => {
                let data = word(*number);
                at.pop_front();
                Read { valid: true, data }
            }
            _ => Read::default(),
        }
    }

    proptest! {
        /// Answers come in the order of the questions, each in the first cycle in which it is there, all before it have
        /// gone, and none went in that cycle.
        #[test]
        fn each_answer_goes_in_its_turn(
            asked in proptest::collection::vec((any::<bool>(), 0usize..3), 0..60),
            latency in 1usize..20,
        ) {
            let cfg = small(true);
            let mut sim = Sim::<Answers>::new(cfg);
            let latencies = [1, latency];
            let mut sides = [VecDeque::new(), VecDeque::new()];
            // What is under way: the side, and when it answers.
            let mut pending: VecDeque<(bool, usize)> = VecDeque::new();
            let (mut next, mut pause, mut gone) = (0, 0, 0);
            for cycle in 0.. {
                if gone == asked.len() {
                    break;
                }
                let expected = pending.front().filter(|(_, due)| *due <= cycle).map(|_| gone as u32);
                let [on_chip, outside] = sides.each_mut().map(|side| answer(side, cycle));
                let oldest = match pending.front() {
                    Some((outside, _)) => Stream::offer(*outside),
                    None => Stream::idle(),
                };
                let seen = sim.clock(In { oldest, words: Words { on_chip, outside } }).unwrap().out;
                prop_assert_eq!(seen.valid.then_some(seen.data), expected.map(word), "cycle {}", cycle);
                if expected.is_some() {
                    pending.pop_front();
                    gone += 1;
                }
                // The next question, once it has room.
                let (outside, wait) = asked.get(next).copied().unwrap_or_default();
                let room = pending.len() < cfg.shape.reads_in_flight as usize;
                if next < asked.len() && room && pause >= wait {
                    let due = cycle + latencies[usize::from(outside)];
                    sides[usize::from(outside)].push_back((due, next as u32));
                    pending.push_back((outside, due));
                    next += 1;
                    pause = 0;
                } else {
                    pause += 1;
                }
            }
        }
    }
}
