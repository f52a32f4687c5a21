//! A block that panics breaks a property, and the failure is shown as any other.

use crate::found::{self, fault};
use pellucid_blocks::allocator::{Config, Contract, In, Lent, Moore};
use pellucid_properties::allocator::Model;
use pellucid_properties::harness::{Must, exhaust};
use pellucid_properties::trials::search;
use pellucid_sim::{Block, Signals, Stream};

/// Where [`Panics`] does.
const IN_NEXT: u32 = 1;
const IN_MOORE: u32 = 2;
const IN_RESET: u32 = 3;
const IN_LATENCY: u32 = 4;

/// A bit for each section, and a panic.
struct Panics;

#[derive(Clone, Copy, Signals)]
#[signals(Config)]
struct State {
    #[width(cfg.sections)]
    free: u32,
    #[with(cfg.id_bits())]
    offer: Stream<u32>,
}

impl Contract for Panics {
    const MOST: u32 = 20;
    fn latency(cfg: &Config) -> u32 {
        assert!(fault() != IN_LATENCY || cfg.sections > 0, "the logarithm of 0");
        1
    }
}

fn lowest(free: u32) -> Stream<u32> {
    if free == 0 { Stream::idle() } else { Stream::offer(free.trailing_zeros()) }
}

impl Block for Panics {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let none = if fault() == IN_RESET { None } else { Some(0) };
        let free = u32::MAX.checked_shr(u32::BITS - cfg.sections).or(none);
        let free = free.expect("a shift by all bits");
        State { free, offer: lowest(free) }
    }
    fn memories(_: &Config) {}
    fn moore(cfg: &Config, q: &State, _: &()) -> Moore {
        let all_out = cfg.sections == 2 && q.free == 0;
        assert!(fault() != IN_MOORE || !all_out, "both are out");
        Moore { grant: q.offer, exhausted: q.free == 0 }
    }
    fn next(_: &Config, q: &State, d: &mut State, _: &mut (), i: In) -> Lent {
        assert!(fault() != IN_NEXT || !(i.take && i.release.valid), "both at once");
        if i.take && q.offer.valid {
            d.free &= !(1 << q.offer.payload);
        }
        if i.release.valid {
            d.free |= 1 << i.release.payload;
        }
        if i.take || !q.offer.valid {
            d.offer = lowest(d.free);
        }
        Lent::default()
    }
}

/// What comes before the file's name and the line, and what behind it.
fn is_said(message: &str, begin: &str, end: &str) {
    let place = "testbench/properties/tests/blocks/panics.rs:";
    let (before, behind) = message.split_once(place).unwrap_or_else(|| panic!("{message}"));
    assert_eq!(before, format!("broken in {begin}, at "), "{message}");
    let (line, behind) = behind.split_once('\n').unwrap_or_else(|| panic!("{message}"));
    assert!(line.parse::<u32>().is_ok(), "{message}");
    assert_eq!(behind, end, "{message}");
}

#[test]
fn a_panic_is_shrunk_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Panics>>(IN_NEXT);
    let save = folder.path().join("wave.gtkw");
    let end = format!(
        "its waveform: gtkwave {}\n1 sections, cycle by cycle:\n     0  take\n     1  take, release 0",
        save.display()
    );
    is_said(&message, "cycle 1: nothing panics: both at once", &end);
    found::has_marker(&folder, "nothing panics");
    // What came in is there, and what the block had in that cycle.
    let shown = |signal| found::shown(&folder, &format!("allocator.{signal}"));
    assert_eq!(shown("wires.in.release.valid"), [(0, 0), (1, 1)]);
    assert_eq!(shown("registers.free"), [(0, 1), (1, 0)]);
}

#[test]
fn a_panic_of_what_is_seen_is_one_too() {
    let (message, _) =
        found::with(IN_MOORE, || found::said(|folder| search::<Model<Panics>>(folder, 1000)));
    let (head, steps) = message.split_once("\n2 sections, cycle by cycle:\n").unwrap();
    assert!(head.starts_with("broken in cycle 2: nothing panics: both are out, at "), "{message}");
    assert_eq!(steps, "     0  take\n     1  take\n     2  nothing");
}

#[test]
fn a_panic_before_the_first_cycle_names_the_configuration() {
    let end = "0 sections, before the first cycle, so that there is no waveform";
    let (message, _) = found::found::<Model<Panics>>(IN_RESET);
    is_said(&message, "cycle 0: nothing panics: a shift by all bits", end);
    let (message, _) = found::found::<Model<Panics>>(IN_LATENCY);
    is_said(&message, "cycle 0: nothing panics: the logarithm of 0", end);
}

#[test]
fn a_panic_can_be_told_from_a_property_of_the_contract() {
    let found = found::with(IN_NEXT, || exhaust::<Model<Panics>>(&1, 1000));
    let (broken, steps) = found.expect_err("it is not found");
    assert_eq!((broken.property, steps.len()), (Must::NotPanic, 2));
}
