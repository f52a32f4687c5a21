//! The library's queue keeps its contract; faults of every kind are found out.

use crate::found::{self, fault};
use pellucid_properties::fifo::{Alone, Model, Property, Step};
use pellucid_properties::fifo_properties;
use pellucid_properties::harness::{Must, check};
use pellucid_properties::trials::search;
use pellucid_sim::fifo::{Config, In, Moore};
use pellucid_sim::{Block, Fifo, Signals, Stream};

fifo_properties!(Alone<Fifo<u32>>, library);
fifo_properties!(Shift, shift);

/// What is wrong with [`Shift`].
const LOST: u32 = 1;
const TWICE: u32 = 2;
const SWAPPED: u32 = 3;
const LATE: u32 = 4;
const OVERFULL: u32 = 5;
const GREEDY: u32 = 6;
const MISCOUNTED: u32 = 7;
const UNRESET: u32 = 8;
const UNHELD: u32 = 9;
const NARROW: u32 = 10;

/// A queue in registers that shift, and a fault.
struct Shift;

const MOST: usize = 10;

#[derive(Clone, Copy, Signals)]
#[signals(Config<u32>)]
struct Items {
    #[width(cfg.item)]
    #[len(cfg.depth + 1)]
    items: [u32; MOST],
    #[width(4)]
    count: u32,
    /// How many were pushed.
    #[width(3)]
    pushed: u32,
    /// The last push was into an empty queue.
    late: bool,
}

impl Block for Shift {
    type Config = Config<u32>;
    type State = Items;
    type In = In<u32>;
    type Moore = Moore<u32>;
    type Out = ();
    type Mem = ();

    fn reset(_: &Config<u32>) -> Items {
        let count = u32::from(fault() == UNRESET);
        Items { items: [0; MOST], count, pushed: 0, late: false }
    }
    fn memories(_: &Config<u32>) {}
    fn moore(cfg: &Config<u32>, q: &Items, _: &()) -> Moore<u32> {
        let depth = cfg.depth + u32::from(fault() == OVERFULL) - u32::from(fault() == GREEDY);
        let newest = q.items[q.count.saturating_sub(1) as usize];
        let payload = if fault() == UNHELD && q.count > 2 { newest } else { q.items[0] };
        Moore {
            ready: q.count < depth,
            count: if fault() == MISCOUNTED && q.count > 1 { 1 } else { q.count },
            front: Stream { valid: q.count > 0 && !q.late, payload },
        }
    }
    fn next(cfg: &Config<u32>, q: &Items, d: &mut Items, _: &mut (), i: In<u32>) {
        let seen = Self::moore(cfg, q, &());
        let pop = i.pop && seen.front.valid;
        let push = i.push.valid && seen.ready && !(fault() == LOST && pop);
        if pop && !(fault() == TWICE && push) {
            d.items.rotate_left(1);
            d.count -= 1;
        }
        d.late = fault() == LATE && push && d.count == 0;
        if push {
            d.items[d.count as usize] = i.push.payload;
            d.count += 1;
            if fault() == SWAPPED && pop && d.count > 1 {
                d.items.swap(0, 1);
            }
            d.pushed = if fault() == NARROW { q.pushed + 1 } else { (q.pushed + 1) & 7 };
        }
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Shift>>(fault, property);
}

#[test]
fn an_item_that_is_lost_is_found() {
    is_found(LOST, Property::Front);
}

#[test]
fn an_item_that_comes_twice_or_too_early_is_found() {
    is_found(TWICE, Property::Order);
    is_found(SWAPPED, Property::Order);
}

#[test]
fn an_item_that_comes_late_is_found() {
    is_found(LATE, Property::Front);
}

#[test]
fn a_front_that_is_replaced_is_found() {
    is_found(UNHELD, Property::Held);
}

#[test]
fn a_wrong_word_about_room_is_found() {
    is_found(OVERFULL, Property::Ready);
    is_found(GREEDY, Property::Ready);
}

#[test]
fn a_wrong_count_is_found() {
    is_found(MISCOUNTED, Property::Count);
}

#[test]
fn a_reset_that_leaves_something_is_found() {
    is_found(UNRESET, Property::Reset);
}

#[test]
#[cfg(debug_assertions)]
fn a_register_that_is_too_narrow_is_found() {
    is_found(NARROW, Property::Fault);
}

/// The shortest sequence for an item that is lost where another one leaves in the cycle of its push.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Shift>>(LOST);
    let expected = format!(
        "broken in cycle 2: something is at the front while an item is in, and only then: nothing is there \
         while 1 is due\nits waveform: gtkwave {}\ndepth 2, items of 2 bits, cycle by cycle:\n     0  push 0\n     1  push \
         1, pop\n     2  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Front);
    assert_eq!(found::shown(&folder, "queue.wires.in.pop"), [(0, 0), (1, 1), (2, 0)]);
    assert_eq!(found::shown(&folder, "queue.wires.out.front.valid"), [(0, 0), (1, 1), (2, 0)]);
    assert_eq!(found::shown(&folder, "queue.registers.count"), [(0, 0), (1, 1), (2, 0)]);
}

#[test]
fn a_sequence_can_be_played_by_hand() {
    let push = Step { push: true, ..Step::default() };
    let both = Step { pop: true, ..push };
    let cfg = Config { depth: 2, item: 8 };
    assert_eq!(check::<Model<Shift>>(&cfg, &[push, both, both]), Ok(()));
    let broken =
        found::with(LOST, || check::<Model<Shift>>(&cfg, &[push, both, both])).unwrap_err();
    assert_eq!((broken.property, broken.cycle), (Must::Keep(Property::Front), 2));
}

#[test]
fn the_search_leaves_a_waveform_too() {
    let (message, folder) =
        found::with(LOST, || found::said(|folder| search::<Model<Shift>>(folder, 1000)));
    assert!(message.starts_with("broken in cycle 2: "), "{message}");
    assert!(message.ends_with("     0  push 0\n     1  push 1, pop\n     2  nothing"), "{message}");
    found::has_marker(&folder, Property::Front);
}
