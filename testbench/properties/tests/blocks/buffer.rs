//! The library's buffers keep their contract; faults of every kind are found out.

use crate::found::{self, fault};
use pellucid_blocks::buffer::Buffer;
use pellucid_blocks::cache::Cache;
use pellucid_blocks::combiner::Combiner;
use pellucid_machine::outside::{self, Config, Request};
use pellucid_properties::buffer::{Model, Property, Step, Tried};
use pellucid_properties::buffer_properties;
use pellucid_properties::harness::{Must, check};
use pellucid_sim::{Block, Signals, Stream};

buffer_properties!(Cache, cache);
buffer_properties!(Combiner, combiner);
buffer_properties!(Register, register);

/// What is wrong with [`Register`].
const LOST: u32 = 1;
const WRONG: u32 = 2;
const TWICE: u32 = 3;
const UNHELD: u32 = 4;
const FAR: u32 = 5;
const UNFLUSHED: u32 = 6;
const GREEDY: u32 = 7;
const STUCK: u32 = 8;
const NARROW: u32 = 9;

/// A register for one request, and a fault.
struct Register;

#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
struct State {
    #[with(*cfg)]
    asked: Stream<Request>,
    flush: bool,
    answered: bool,
    #[width(1)]
    taken: u32,
}

#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
struct In {
    #[with(*cfg)]
    request: Stream<Request>,
    #[with(*cfg)]
    memory: outside::In,
    flush: bool,
}

#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
struct Moore {
    ready: bool,
    idle: bool,
    answered: bool,
}

#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Config)]
struct Out {
    #[with(*cfg)]
    request: Stream<Request>,
}

impl Block for Register {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(_: &Config) -> State {
        State { asked: Stream::idle(), flush: false, answered: false, taken: 0 }
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        let idle = !q.asked.valid && !q.flush;
        Moore {
            ready: if fault() == GREEDY { !q.asked.valid } else { idle },
            idle: idle || fault() == UNFLUSHED,
            answered: q.answered,
        }
    }
    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let takes = i.request.valid && Self::moore(cfg, q, &()).ready;
        let stuck = fault() == STUCK && q.asked.payload.address == 1;
        let goes = q.asked.valid && i.memory.ready && !stuck;
        if goes || fault() == UNHELD {
            d.asked.valid = false;
        }
        if takes && !(fault() == LOST && i.request.payload.write) {
            d.asked = i.request;
        }
        if takes && fault() == NARROW {
            d.taken = q.taken + 1;
        }
        d.flush = i.flush || (q.flush && q.asked.valid);
        d.answered = i.memory.response.valid;
        let mut request = Stream { valid: q.asked.valid && !stuck, ..q.asked };
        request.payload.address += if fault() == FAR { q.asked.payload.address } else { 0 };
        Out { request }
    }
}

impl Buffer for Register {
    fn port(cfg: &Config) -> Config {
        *cfg
    }
    fn inputs(request: Stream<Request>, memory: outside::In, flush: bool) -> In {
        In { request, memory, flush }
    }
    fn client(seen: &Moore, memory: outside::In) -> outside::In {
        let mut response = memory.response;
        response.valid |= fault() == TWICE && seen.answered;
        response.payload.low ^= u64::from(fault() == WRONG);
        outside::In { ready: seen.ready, response }
    }
    fn idle(seen: &Moore) -> bool {
        seen.idle
    }
    fn asks(out: &Out) -> Stream<Request> {
        out.request
    }
}

impl Tried for Register {
    fn configs() -> Vec<Config> {
        vec![Config { words: 2, bits: 1 }, Config { words: 3, bits: 1 }]
    }
    fn latency(_: &Config) -> u32 {
        1
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Register>>(fault, property);
}

#[test]
fn a_write_that_is_lost_is_found() {
    is_found(LOST, Property::Flush);
}

#[test]
fn a_flush_that_does_not_wait_is_found() {
    is_found(UNFLUSHED, Property::Flush);
    is_found(GREEDY, Property::Flush);
}

#[test]
fn a_wrong_answer_is_found() {
    is_found(WRONG, Property::Read);
}

#[test]
fn an_answer_that_comes_twice_is_found() {
    is_found(TWICE, Property::Early);
}

#[test]
fn a_request_that_is_not_held_is_found() {
    is_found(UNHELD, Property::Held);
}

#[test]
fn a_word_that_there_is_not_is_found() {
    is_found(FAR, Property::Range);
}

#[test]
fn a_buffer_that_stands_still_is_found() {
    is_found(STUCK, Property::Stuck);
}

#[test]
#[cfg(debug_assertions)]
fn a_register_that_is_too_narrow_is_found() {
    is_found(NARROW, Property::Fault);
}

/// The shortest sequence for an answer that comes twice.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Register>>(TWICE);
    assert!(
        message.starts_with(
            "broken in cycle 3: nothing is answered but what was read: 0 comes where nothing is due"
        ),
        "{message}"
    );
    found::has_marker(&folder, Property::Early);
}

#[test]
fn a_sequence_can_be_played_by_hand() {
    let moves = Step { ready: true, answer: true, ..Step::default() };
    let steps = [Step { ask: Some((true, 1)), ..moves }, Step { ask: Some((false, 1)), ..moves }];
    let cfg = Config { words: 2, bits: 1 };
    assert_eq!(check::<Model<Register>>(&cfg, &steps), Ok(()));
    let broken = found::with(LOST, || check::<Model<Register>>(&cfg, &steps)).unwrap_err();
    assert_eq!(broken.property, Must::Keep(Property::Read));
}
