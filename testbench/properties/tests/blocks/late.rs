//! Faults that show only after many grants: what finds them, and what is said where nothing can.

use crate::found::{self, fault};
use pellucid_blocks::allocator::{Config, Contract, In, Lent, Moore};
use pellucid_properties::allocator::{Model, Property};
use pellucid_properties::trials::{search, search_first};
use pellucid_sim::{Block, Signals, Stream};

/// A bit for each section; after as many grants as the fault says one that is taken stays among the free ones.
struct Late;

/// More grants than there ever are.
const NEVER: u32 = u32::MAX;

#[derive(Clone, Copy, Signals)]
#[signals(Config)]
struct State {
    #[width(cfg.sections)]
    free: u32,
    #[with(cfg.id_bits())]
    offer: Stream<u32>,
    #[width(20)]
    grants: u32,
}

impl Contract for Late {
    const MOST: u32 = 20;
}

fn lowest(free: u32) -> Stream<u32> {
    if free == 0 { Stream::idle() } else { Stream::offer(free.trailing_zeros()) }
}

impl Block for Late {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        let free = (1 << cfg.sections) - 1;
        State { free, offer: lowest(free), grants: 0 }
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &State, _: &()) -> Moore {
        Moore { grant: q.offer, exhausted: q.free == 0 }
    }
    fn next(_: &Config, q: &State, d: &mut State, _: &mut (), i: In) -> Lent {
        if i.take && q.offer.valid {
            d.grants = q.grants + 1;
            if q.grants < fault() {
                d.free &= !(1 << q.offer.payload);
            }
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

/// Cycles that are told of a failure.
fn told(message: &str) -> usize {
    message.lines().skip_while(|line| !line.ends_with("cycle by cycle:")).count() - 1
}

#[test]
fn a_section_that_is_out_twice_after_150_grants_is_found() {
    let (message, folder) = found::found_long::<Model<Late>>(150);
    assert!(message.contains(&format!(": {}: ", Property::Twice)), "{message}");
    found::has_marker(&folder, Property::Twice);
}

#[test]
fn a_section_that_is_out_twice_after_65536_grants_is_found() {
    let (message, folder) = found::found_long::<Model<Late>>(65_536);
    assert!(message.contains(&format!(": {}: ", Property::Twice)), "{message}");
    // The waveform has all of it, the message its end.
    assert_eq!(told(&message), 101, "{message}");
    assert!(message.contains(" cycles, see the waveform\n"), "{message}");
    let (cycle, _) = *found::shown(&folder, "allocator.registers.grants").last().unwrap();
    assert!(message.starts_with(&format!("broken in cycle {cycle}: ")), "{message}");
    found::has_marker(&folder, Property::Twice);
}

#[test]
fn a_search_that_is_not_complete_fails_unless_that_is_said() {
    let (message, _) =
        found::with(NEVER, || found::said(|folder| search::<Model<Late>>(folder, 1000)));
    assert!(message.starts_with("not every state was looked at, "), "{message}");
    assert!(message.contains(" of 1 sections, the first "), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let more = found::with(NEVER, || search_first::<Model<Late>>(folder.path(), 1000));
    // Without any section there is nothing to count.
    assert_eq!(more.len(), 4, "{more:?}");
}
