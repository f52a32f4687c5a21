//! The library's prefix sum keeps its contract; faults of every kind are found out.

use crate::found::{self, fault};
use pellucid_blocks::array::config::Config;
use pellucid_blocks::array::prefix_sum::{Fsm, In, Mem, Moore, Out, PrefixSum, State};
use pellucid_properties::prefix_sum::{Model, Property, Sums};
use pellucid_properties::prefix_sum_properties;
use pellucid_sim::{Block, ReadPort, Stream, WritePort};

prefix_sum_properties!(PrefixSum);

/// What is wrong with [`Wrong`].
const UNSAID: u32 = 1;
const EARLY: u32 = 2;
const LONG: u32 = 3;
const UNTOLD: u32 = 4;
const OFF: u32 = 5;
const UNLISTED: u32 = 6;
const MISPLACED: u32 = 7;
const KEPT: u32 = 8;
const FAR: u32 = 9;
const SILENT: u32 = 10;
const TWICE: u32 = 11;

/// The library's prefix sum, and a fault.
struct Wrong;

impl Block for Wrong {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        PrefixSum::reset(cfg)
    }
    fn memories(cfg: &Config) -> Mem {
        PrefixSum::memories(cfg)
    }
    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let mut seen = PrefixSum::moore(cfg, q, m);
        match fault() {
            // A sum that is more than one is one too few.
            OFF => seen.sums.data.of[0] -= u32::from(seen.sums.data.of[0] > 1),
            MISPLACED if seen.occupied > 1 => seen.word.data ^= 1,
            SILENT => seen.sums.valid &= seen.sums.data.of[0] != 2,
            _ => {}
        }
        seen
    }
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, mut i: In) -> Out {
        let sweeps = q.fsm == Fsm::Sweep;
        if fault() == TWICE && i.start {
            i.index_read.read(0);
            i.walk_read.read(0);
        }
        let mut out = PrefixSum::next(cfg, q, d, m, i);
        match fault() {
            UNSAID => out.done &= q.band.from == 0 && d.band.to == cfg.screen.pixels(),
            EARLY => out.done |= sweeps && q.asked.valid && q.asked.payload == 0,
            LONG if out.done && d.band.to < cfg.screen.pixels() => d.band.to += 1,
            UNTOLD if out.slots.payload > 2 => out.slots = Stream::idle(),
            UNLISTED if q.asked.valid && q.asked.payload == 1 => d.occupied = q.occupied,
            KEPT => out.write = WritePort::default(),
            FAR if sweeps && q.next == cfg.words() => {
                out.read = ReadPort::default();
                out.read.read(q.next);
            }
            _ => {}
        }
        out
    }
}

impl Sums for Wrong {
    fn cycles(cfg: &Config, words: u32, gone_over: u32) -> u32 {
        PrefixSum::cycles(cfg, words, gone_over)
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Wrong>>(fault, property);
}

#[test]
fn an_end_that_is_not_said_or_said_too_early_is_found() {
    is_found(UNSAID, Property::Cycles);
    is_found(EARLY, Property::Cycles);
}

#[test]
fn a_band_that_is_too_long_is_found() {
    is_found(LONG, Property::Band);
}

#[test]
fn slots_that_are_not_told_are_found() {
    is_found(UNTOLD, Property::Slots);
}

#[test]
fn a_wrong_sum_is_found() {
    is_found(OFF, Property::Sum);
}

#[test]
fn a_word_that_is_not_listed_or_in_the_wrong_place_is_found() {
    is_found(UNLISTED, Property::List);
    is_found(MISPLACED, Property::List);
}

#[test]
fn counters_that_are_not_cleared_are_found() {
    is_found(KEPT, Property::Cleared);
}

#[test]
fn a_word_that_there_is_not_is_found() {
    is_found(FAR, Property::Range);
}

#[test]
fn a_sum_that_is_not_shown_is_found() {
    is_found(SILENT, Property::Valid);
}

#[test]
fn a_port_that_is_used_twice_is_found() {
    is_found(TWICE, Property::Fault);
}

/// The shortest sequence for a sum that is one too few.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Wrong>>(OFF);
    let expected = format!(
        "broken in cycle 6: a pixel has the sum of those before it in its band: pixel 1 has 1 where 2 is due\n\
         its waveform: gtkwave {}\n\
         1 in a word, 3 slots, frames [[2, 1, 1]], cycle by cycle:\n     \
         0  start\n     1  nothing\n     2  nothing\n     3  nothing\n     4  nothing\n     \
         5  read the sum of pixel 1\n     6  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Sum);
    let fsm = found::shown(&folder, "prefix_sum.registers.fsm");
    assert_eq!(fsm, [(0, 0), (1, 1), (5, 0)]);
}
