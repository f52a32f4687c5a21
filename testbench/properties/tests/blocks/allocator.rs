use crate::found::{self, fault};
use pellucid_blocks::allocator::{
    Bitmap, Bump, Cached, Config, Contract, FreeList, Hierarchical, In, Lent, Moore, Stack,
    Threaded,
};
use pellucid_properties::allocator::{Model, Property, Step, check, exhaust, report};
use pellucid_properties::allocator_properties;
use pellucid_properties::harness::{Must, Searched};
use pellucid_sim::{Block, Signals, Stream};

allocator_properties!(FreeList, free_list);
allocator_properties!(Stack, stack);
allocator_properties!(Bump, bump);
allocator_properties!(Threaded, threaded);
allocator_properties!(Bitmap, bitmap);
allocator_properties!(Hierarchical, hierarchical);
allocator_properties!(Cached, cached);
allocator_properties!(Bits, bits);

/// What is wrong with [`Bits`].
const TWICE: u32 = 1;
const RANGE: u32 = 2;
const HELD: u32 = 3;
const LOST: u32 = 4;
const LATE: u32 = 5;
const EARLY: u32 = 6;
const UNSAID: u32 = 7;
const RESET: u32 = 8;
const NARROW: u32 = 9;

/// A bit for each section, in a register, and a fault.
struct Bits;

#[derive(Clone, Copy, Signals)]
#[signals(Config)]
struct Free {
    #[width(cfg.sections)]
    bits: u32,
    /// What is offered.
    #[with(cfg.id_bits())]
    offer: Stream<u32>,
    #[width(2)]
    pause: u32,
    #[width(8)]
    takes: u32,
}

impl Contract for Bits {
    const MOST: u32 = 31;
}

impl Block for Bits {
    type Config = Config;
    type State = Free;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> Free {
        let lost = u32::from(fault() == RESET && cfg.sections > 2);
        let bits = (1 << cfg.sections) - 1 - lost;
        Free { bits, offer: offer(bits), pause: 0, takes: 0 }
    }
    fn memories(_: &Config) {}
    fn moore(cfg: &Config, q: &Free, _: &()) -> Moore {
        let mut grant = q.offer;
        if fault() == HELD {
            grant = offer(q.bits);
        }
        let none = q.bits == 0;
        if fault() == RANGE && none && q.takes > 3 {
            grant = Stream::offer(cfg.sections);
        }
        if fault() == LATE && q.pause > 0 {
            grant = Stream::idle();
        }
        let exhausted = match fault() {
            EARLY => q.bits.count_ones() < 2,
            UNSAID => none && q.takes < 5,
            _ => none,
        };
        Moore { grant, exhausted }
    }
    fn next(cfg: &Config, q: &Free, d: &mut Free, m: &mut (), i: In) -> Lent {
        let grant = Self::moore(cfg, q, m).grant;
        let taken = i.take && grant.valid;
        if taken && !(fault() == TWICE && i.release.valid) {
            d.bits &= !(1 << grant.payload);
        }
        if i.release.valid && !(fault() == LOST && taken) {
            d.bits |= 1 << i.release.payload;
        }
        d.takes = (q.takes + u32::from(taken)) & 0xff;
        d.pause = if fault() == NARROW { q.takes } else { u32::from(taken && q.takes % 4 == 3) };
        if i.take || !grant.valid {
            d.offer = offer(d.bits);
        }
        Lent::default()
    }
}

fn offer(bits: u32) -> Stream<u32> {
    if bits == 0 { Stream::idle() } else { Stream::offer(bits.trailing_zeros()) }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Bits>>(fault, property);
}

#[test]
fn a_section_that_is_out_twice_is_found() {
    is_found(TWICE, Property::Twice);
}

#[test]
fn a_section_that_there_is_not_is_found() {
    is_found(RANGE, Property::Range);
}

#[test]
fn an_offer_that_is_replaced_is_found() {
    is_found(HELD, Property::Held);
}

#[test]
fn a_section_that_is_lost_is_found() {
    is_found(LOST, Property::Granted);
    is_found(RESET, Property::Granted);
}

#[test]
fn a_grant_that_comes_late_is_found() {
    is_found(LATE, Property::Granted);
}

#[test]
fn a_wrong_word_about_being_exhausted_is_found() {
    is_found(EARLY, Property::Exhausted);
    is_found(UNSAID, Property::Exhausted);
}

#[test]
#[cfg(debug_assertions)]
fn a_register_that_is_too_narrow_is_found() {
    is_found(NARROW, Property::Fault);
}

/// The shortest sequence for a section that is lost where one is taken in the cycle of its release.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Bits>>(LOST);
    let expected = format!(
        "broken in cycle 2: while a section is free, one is granted within the latency: 1 are free and \
         none is granted for 1 cycles\nits waveform: gtkwave {}\n2 sections, cycle by cycle:\n     0  \
         take\n     1  take, release 0\n     2  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Granted);
    // Taken in two cycles, looked at in the third.
    assert_eq!(found::shown(&folder, "allocator.wires.in.take"), [(0, 1), (2, 0)]);
}

#[test]
fn a_sequence_can_be_played_by_hand() {
    let take = Step { take: true, ..Step::default() };
    let back = Step { release: Some(0), ..take };
    assert_eq!(check::<Bits>(2, &[take, back]), Ok(()));
    assert_eq!(report::<Bits>(2, &[take, back], "".as_ref()), "no property is broken");
    let broken = found::with(LOST, || check::<Bits>(2, &[take, back])).unwrap_err();
    assert_eq!((broken.property, broken.cycle), (Must::Keep(Property::Granted), 2));
}

#[test]
fn the_search_sees_every_state() {
    // Which sections are out, in which order they went, and what is offered; what was taken so far.
    let states = [0, 1, 2].map(|sections| exhaust::<Stack>(sections, 1000).unwrap().states);
    assert_eq!(states[0], 1);
    assert!(states[1] > 2 && states[2] > states[1], "{states:?}");
    assert!(exhaust::<Stack>(2, 1000).unwrap().every);
    let some = exhaust::<Stack>(4, 7).unwrap();
    assert_eq!(some, Searched { states: 7, every: false }, "no more than it is told");
}
