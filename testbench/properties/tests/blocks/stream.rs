use crate::found::{self, fault};
use pellucid_properties::fifo::Alone;
use pellucid_properties::stream::{Model, Property, Stage};
use pellucid_properties::stream_properties;
use pellucid_sim::{Block, Fifo, Signals, Stream};

stream_properties!(Alone<Fifo<u32>>, fifo);
stream_properties!(Adder, adder);

/// What is wrong with [`Adder`].
const LOST: u32 = 1;
const TWICE: u32 = 2;
const UNHELD: u32 = 3;
const REPLACED: u32 = 4;
const EARLY: u32 = 5;
const STUCK: u32 = 6;
const WRONG: u32 = 7;
const NARROW: u32 = 8;

/// Gives the sum of each two items, from a register, and a fault.
struct Adder;

#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
struct State {
    #[with(8)]
    first: Stream<u32>,
    #[with(8)]
    sum: Stream<u32>,
    #[width(2)]
    sums: u32,
}

#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
struct In {
    #[with(8)]
    item: Stream<u32>,
    ready: bool,
}

#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
struct Moore {
    ready: bool,
    #[with(8)]
    sum: Stream<u32>,
}

impl Block for Adder {
    type Config = ();
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset((): &()) -> State {
        State { first: Stream::idle(), sum: Stream::idle(), sums: 0 }
    }
    fn memories((): &()) {}
    fn moore((): &(), q: &State, (): &()) -> Moore {
        let stuck = fault() == STUCK && q.sums == 1;
        Moore { ready: !q.sum.valid && !stuck, sum: q.sum }
    }
    fn next((): &(), q: &State, d: &mut State, (): &mut (), i: In) {
        let given = q.sum.valid && i.ready;
        let refused = q.sum.valid && !i.ready;
        if given && !(fault() == TWICE && q.sums == 1) || fault() == UNHELD && refused {
            d.sum = Stream::idle();
        }
        if given {
            d.sums = if fault() == NARROW { q.sums + 3 } else { (q.sums + 1) & 1 };
        }
        if fault() == REPLACED && refused {
            d.sum.payload = 0;
        }
        let lost = fault() == LOST && q.sums == 1 && q.first.valid;
        let taken = Self::moore(&(), q, &()).ready || fault() == EARLY && given;
        if !i.item.valid || !taken || lost {
            return;
        }
        if q.first.valid {
            d.first = Stream::idle();
            let wrong = u32::from(fault() == WRONG && q.sums == 1);
            d.sum = Stream::offer(q.first.payload + i.item.payload + wrong);
        } else {
            d.first = i.item;
        }
    }
}

impl Stage for Adder {
    type Item = u32;
    type Gives = u32;
    fn configs() -> Vec<()> {
        vec![()]
    }
    fn item((): &(), number: u32) -> u32 {
        2 * (number % 64)
    }
    fn gives((): &(), items: &[u32]) -> Vec<u32> {
        items.chunks_exact(2).map(|two| two[0] + two[1]).collect()
    }
    fn latency((): &()) -> u32 {
        0
    }
    fn inputs(item: Stream<u32>, ready: bool) -> In {
        In { item, ready }
    }
    fn ready(seen: &Moore) -> bool {
        seen.ready
    }
    fn given(seen: &Moore) -> Stream<u32> {
        seen.sum
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Adder>>(fault, property);
}

#[test]
fn an_item_that_is_lost_is_found() {
    is_found(LOST, Property::Stuck);
}

#[test]
fn a_stage_that_stands_still_is_found() {
    is_found(STUCK, Property::Stuck);
}

#[test]
fn what_is_given_twice_is_found() {
    is_found(TWICE, Property::Early);
}

#[test]
fn what_is_used_before_it_is_taken_is_found() {
    is_found(EARLY, Property::Early);
}

#[test]
fn an_offer_that_is_not_held_is_found() {
    is_found(UNHELD, Property::Held);
    is_found(REPLACED, Property::Held);
}

#[test]
fn a_wrong_item_is_found() {
    is_found(WRONG, Property::Order);
}

#[test]
#[cfg(debug_assertions)]
fn a_register_that_is_too_narrow_is_found() {
    is_found(NARROW, Property::Fault);
}

/// The shortest sequence for an offer that is withdrawn where the receiver is not ready.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Adder>>(UNHELD);
    let expected = format!(
        "broken in cycle 3: what is given is held until it is taken: 2 was given, then nothing\n\
         its waveform: gtkwave {}\n\
         (), 4 items, cycle by cycle:\n     0  item 0 is offered\n     1  item 1 is offered\n     \
         2  nothing\n     3  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Held);
    assert_eq!(found::shown(&folder, "stage.wires.out.sum.valid"), [(0, 0), (2, 1), (3, 0)]);
    assert_eq!(found::shown(&folder, "stage.wires.in.item.valid"), [(0, 1), (2, 0)]);
}
