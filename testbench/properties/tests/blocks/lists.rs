//! The library's lists of pages keep their contract; faults of every kind are found out.

use crate::found::{self, fault};
use pellucid_blocks::allocator::Bump;
use pellucid_blocks::chains::config::Config;
use pellucid_blocks::chains::{Chains, In, Mem, Moore, Out, State};
use pellucid_properties::lists::{Lists, Model, Property};
use pellucid_properties::lists_properties;
use pellucid_sim::Block;
use std::ops::Range;

type Library = Chains<Bump>;

lists_properties!(Library);

/// What is wrong with [`Wrong`].
const MORE: u32 = 1;
const FEWER: u32 = 2;
const EARLY: u32 = 3;
const WASTED: u32 = 4;
const UNHELD: u32 = 5;
const OLDER: u32 = 6;
const CHANGED: u32 = 7;
const UNMARKED: u32 = 8;
const SEEN: u32 = 9;
const UNDONE: u32 = 10;
const FULL: u32 = 11;
const TWICE: u32 = 12;
const KEPT: u32 = 13;

/// The library's lists, and a fault.
struct Wrong;

impl Block for Wrong {
    type Config = Config;
    type State = State<Bump>;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem<Bump>;

    fn reset(cfg: &Config) -> State<Bump> {
        Library::reset(cfg)
    }
    fn memories(cfg: &Config) -> Mem<Bump> {
        Library::memories(cfg)
    }
    fn moore(cfg: &Config, q: &State<Bump>, m: &Mem<Bump>) -> Moore {
        let mut seen = Library::moore(cfg, q, m);
        let arrived = &mut seen.arrived;
        match fault() {
            WASTED => seen.asked += u32::from(seen.asked == 1),
            UNHELD => arrived.valid &= q.read_back.reader.arrived.count != 2,
            UNMARKED => arrived.payload.item.last &= arrived.payload.item.rgba != 0,
            SEEN => arrived.payload.item.visible = true,
            FULL => seen.ready &= q.count.count < 2,
            _ => {}
        }
        seen
    }
    fn next(
        cfg: &Config,
        q: &State<Bump>,
        d: &mut State<Bump>,
        m: &mut Mem<Bump>,
        mut i: In,
    ) -> Out {
        let came = &mut i.fragment.payload.item;
        let ends = i.fragment.valid && i.fragment.payload.end;
        i.fragment.valid &= Self::moore(cfg, q, m).ready;
        match fault() {
            MORE => i.limit = cfg.null.min(i.limit + 1),
            FEWER => i.limit = i.limit.saturating_sub(1),
            // The second fragment of a pixel comes in the place of its first.
            OLDER if came.rgba & 0xffff > 0 => came.rgba -= 1,
            CHANGED if came.rgba & 0xffff > 0 => came.rgba += 100,
            TWICE if i.start => {
                m.ssa.table.read(0);
                m.ssa.table.read(0);
            }
            _ => {}
        }
        let before = q.count.count;
        let mut out = Library::next(cfg, q, d, m, i);
        match fault() {
            EARLY => out.stored |= ends,
            UNDONE => out.done &= before < 2,
            KEPT if i.clear.valid => d.count.count = before,
            _ => {}
        }
        out
    }
}

impl Lists for Wrong {
    fn latency(cfg: &Config) -> u32 {
        Library::latency(cfg)
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Wrong>>(fault, property);
}

#[test]
fn a_page_beyond_the_limit_or_one_too_few_is_found() {
    is_found(MORE, Property::Dropped);
    is_found(FEWER, Property::Dropped);
}

#[test]
fn pages_that_are_not_given_back_are_found() {
    is_found(KEPT, Property::Dropped);
}

#[test]
fn a_frame_that_is_said_to_be_stored_too_early_is_found() {
    is_found(EARLY, Property::Stored);
}

#[test]
fn a_page_too_many_is_found() {
    is_found(WASTED, Property::Pages);
}

#[test]
fn a_fragment_that_is_not_held_is_found() {
    is_found(UNHELD, Property::Held);
}

#[test]
fn a_wrong_order_is_found() {
    is_found(OLDER, Property::Order);
}

#[test]
fn a_fragment_that_was_not_stored_is_found() {
    is_found(CHANGED, Property::Once);
}

#[test]
fn a_mark_that_is_missing_is_found() {
    is_found(UNMARKED, Property::Marks);
    is_found(SEEN, Property::Marks);
}

#[test]
fn a_frame_that_is_not_said_to_be_done_is_found() {
    is_found(UNDONE, Property::Done);
}

#[test]
fn lists_that_take_no_more_are_found() {
    is_found(FULL, Property::Stuck);
}

#[test]
fn a_port_that_is_used_twice_is_found() {
    is_found(TWICE, Property::Fault);
}

/// The shortest sequence for a list that is read in the wrong order.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Wrong>>(OLDER);
    let nothing = |cycles: Range<u32>| -> String {
        cycles.map(|cycle| format!("\n    {cycle:2}  nothing")).collect()
    };
    let expected = format!(
        "broken in cycle 14: a pixel's fragments come from the newest to the oldest: fragment 0 of pixel 0 \
         came where fragment 1 of pixel 0 is due\n\
         its waveform: gtkwave {}\n\
         2 pixels, 3 pages of 1, K = 2, depths [1, 1], resolved of 3 pages: 0@0 0@0, cycle by cycle:\n     \
         0  clear 0\n     1  clear 1\n     \
         2  fragment 0 of pixel 0 (depth 0) is offered\n     \
         3  fragment 1 of pixel 0 (depth 0) is offered\n     \
         4  the end is offered{}\n     7  start{}",
        folder.path().join("wave.gtkw").display(),
        nothing(5..7),
        nothing(8..15)
    );
    assert_eq!(message, expected);
    assert_eq!(found::shown(&folder, "lists.wires.out.asked"), [(0, 0), (5, 1), (6, 2)]);
    found::has_marker(&folder, Property::Order);
}
