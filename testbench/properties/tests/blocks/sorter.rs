use crate::found::{self, fault};
use pellucid_blocks::sorter::{Config, In, Moore, Sorter, State};
use pellucid_properties::sorter::{Model, Property};
use pellucid_properties::sorter_properties;
use pellucid_sim::Block;

sorter_properties!(Sorter);

/// What is wrong with [`Wrong`].
const REVERSED: u32 = 1;
const TIES: u32 = 2;
const TWICE: u32 = 3;
const HIDDEN: u32 = 4;
const EARLY: u32 = 5;
const UNMARKED: u32 = 6;
const ENDS: u32 = 7;
const FULL: u32 = 8;
const UNHELD: u32 = 9;
const NARROW: u32 = 10;

/// The library's sorter, and a fault.
struct Wrong;

impl Block for Wrong {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        Sorter::reset(cfg)
    }
    fn memories(_: &Config) {}
    fn moore(cfg: &Config, q: &State, m: &()) -> Moore {
        let mut seen = Sorter::moore(cfg, q, m);
        let sorted = &mut seen.sorted;
        match fault() {
            EARLY => sorted.valid |= q.count > 0,
            UNMARKED => sorted.payload.item.last &= sorted.payload.item.rgba & 0xff != 1,
            FULL => seen.ready &= q.count < cfg.depth,
            _ => {}
        }
        seen
    }
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut (), mut i: In) {
        i.arrived.valid &= Self::moore(cfg, q, m).ready;
        let came = &mut i.arrived.payload.item;
        match fault() {
            REVERSED => came.z = 0xff_ffff - came.z,
            HIDDEN => came.visible = true,
            TWICE => i.sorted_ready &= !(i.arrived.valid && q.closed > 0),
            _ => {}
        }
        let pop = i.sorted_ready && q.closed > 0;
        Sorter::next(cfg, q, d, m, i);
        match fault() {
            TIES => {
                // The newest goes in front of those that are as far.
                let mut k = d.count.saturating_sub(1) as usize;
                while k > (q.closed - u32::from(pop)) as usize
                    && d.entries[k].z == d.entries[k - 1].z
                {
                    d.entries.swap(k, k - 1);
                    k -= 1;
                }
            }
            UNHELD if !i.sorted_ready && q.closed > 1 => d.entries.swap(0, 1),
            ENDS if i.sorted_ready && q.end && q.count == 0 && q.came == 0 => {
                (d.end, d.came) = (true, 1);
            }
            NARROW if q.again => d.left = 1 << cfg.layer_bits,
            _ => {}
        }
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Wrong>>(fault, property);
}

#[test]
fn a_wrong_order_is_found() {
    is_found(REVERSED, Property::Order);
}

#[test]
fn equal_depths_that_do_not_leave_as_they_came_are_found() {
    is_found(TIES, Property::Ties);
}

#[test]
fn a_fragment_that_leaves_twice_or_is_hidden_is_found() {
    is_found(TWICE, Property::Once);
    is_found(HIDDEN, Property::Once);
}

#[test]
fn a_fragment_that_leaves_too_early_is_found() {
    is_found(EARLY, Property::Early);
}

#[test]
fn a_mark_that_is_missing_is_found() {
    is_found(UNMARKED, Property::Last);
}

#[test]
fn an_end_that_comes_twice_is_found() {
    is_found(ENDS, Property::End);
}

#[test]
fn a_sorter_that_does_not_go_on_when_it_is_full_is_found() {
    is_found(FULL, Property::Stuck);
}

#[test]
fn a_fragment_that_is_not_held_is_found() {
    is_found(UNHELD, Property::Held);
}

#[test]
#[cfg(debug_assertions)]
fn a_register_that_is_too_narrow_is_found() {
    is_found(NARROW, Property::Fault);
}

/// The smallest frame of which equal depths leave in the wrong order.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Wrong>>(TIES);
    let expected = format!(
        "broken in cycle 2: fragments of one depth leave from the oldest to the newest: fragment 1 of \
         pixel 0 (last) came where fragment 0 of pixel 0 is due\n\
         its waveform: gtkwave {}\n\
         K = 2, frame [0 0], cycle by cycle:\n     \
         0  fragment 0 of pixel 0 (depth 0) is offered\n     \
         1  fragment 1 of pixel 0 (depth 0, last of its pass) is offered\n     \
         2  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Ties);
    assert_eq!(found::shown(&folder, "sorter.wires.out.sorted.valid"), [(0, 0), (2, 1)]);
    assert_eq!(found::shown(&folder, "sorter.registers.count"), [(0, 0), (1, 1), (2, 2)]);
}
