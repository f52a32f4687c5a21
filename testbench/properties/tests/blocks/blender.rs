use crate::found::{self, fault};
use pellucid_blocks::blender::{Blender, In, Out, State};
use pellucid_properties::blender::{Model, Property};
use pellucid_properties::blender_properties;
use pellucid_sim::{Block, ReadPort, Stream, WritePort};

blender_properties!(Blender);

/// What is wrong with [`Wrong`].
const ROUNDED: u32 = 1;
const SWAPPED: u32 = 2;
const BELOW: u32 = 3;
const PLACE: u32 = 4;
const UNWRITTEN: u32 = 5;
const GREEDY: u32 = 6;
const UNTOLD: u32 = 7;
const UNDONE: u32 = 8;
const TWICE: u32 = 9;
const NARROW: u32 = 10;
const FAR: u32 = 11;

/// The library's blender, and a fault.
struct Wrong;

impl Block for Wrong {
    type Config = u32;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &u32) -> State {
        Blender::reset(cfg)
    }
    fn memories(_: &u32) {}
    fn moore(_: &u32, _: &State, _: &()) {}
    fn next(cfg: &u32, q: &State, d: &mut State, m: &mut (), mut i: In) -> Out {
        let Stream { valid, payload: came } = i.sorted;
        let fragment = valid && !came.end;
        if fault() == SWAPPED && fragment {
            i.sorted.payload.item.rgba = came.item.rgba.rotate_right(8).swap_bytes();
        }
        let mut out = Blender::next(cfg, q, d, m, i);
        match fault() {
            BELOW if q.stage_fresh => d.colour = 0,
            NARROW if q.stage.valid && !q.stage.payload.end && !q.stage.payload.item.last => {
                d.colour |= 1 << 24;
            }
            GREEDY if fragment => {
                out.colour_read = ReadPort::default();
                out.colour_read.read(came.item.pixel);
            }
            UNTOLD => out.blended &= q.stage_fresh,
            UNDONE => out.frame_done &= q.fresh && q.colour != 0,
            _ => {}
        }
        if let Some((pixel, colour)) = out.colour_write.asked() {
            let mut write = |pixel, colour| {
                out.colour_write = WritePort::default();
                out.colour_write.write(pixel, colour);
            };
            match fault() {
                // One step of red too few, for some colours.
                ROUNDED if colour >> 16 & 7 == 7 => write(pixel, colour - (1 << 16)),
                PLACE => write(pixel ^ 1, colour),
                FAR if pixel > 3 => write(3, colour),
                UNWRITTEN if valid => out.colour_write = WritePort::default(),
                TWICE => out.colour_write.write(pixel, colour),
                _ => {}
            }
        }
        out
    }
}

fn is_found(fault: u32, property: Property) {
    found::is_found::<Model<Wrong>>(fault, property);
}

#[test]
fn a_wrong_colour_is_found() {
    is_found(ROUNDED, Property::Colour);
    is_found(SWAPPED, Property::Colour);
    is_found(BELOW, Property::Colour);
}

#[test]
fn a_colour_in_the_wrong_place_or_not_written_is_found() {
    is_found(PLACE, Property::Write);
    is_found(UNWRITTEN, Property::Write);
}

#[test]
fn a_colour_that_is_read_again_is_found() {
    is_found(GREEDY, Property::Read);
}

#[test]
fn what_is_not_told_is_found() {
    is_found(UNTOLD, Property::Blended);
    is_found(UNDONE, Property::Done);
}

#[test]
fn a_port_that_is_used_twice_is_found() {
    is_found(TWICE, Property::Fault);
}

#[test]
#[cfg(debug_assertions)]
fn a_register_that_is_too_narrow_is_found() {
    is_found(NARROW, Property::Fault);
}

/// The smallest frame of which a colour goes to the wrong place.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Wrong>>(PLACE);
    let expected = format!(
        "broken in cycle 1: one is written to the pixel in the cycle after its last fragment came: pixel 1 \
         is written where pixel 0 is due\n\
         its waveform: gtkwave {}\n\
         opaque colours 2080f0 2180f0 2280f0 2380f0 2480f0 2580f0, cycle by cycle:\n     \
         0  ffc04080 of pixel 0 comes, the last\n     \
         1  the end comes",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Write);
    assert_eq!(found::shown(&folder, "blender.wires.out.colour_write.en"), [(0, 0), (1, 1)]);
    assert_eq!(found::shown(&folder, "blender.wires.out.colour_write.addr"), [(0, 0), (1, 1)]);
}

/// Small frames have few pixels: the fault is found in larger ones only, and its sequence has no pause.
#[test]
fn a_fault_beyond_the_search_is_short_too() {
    let (message, folder) = found::found::<Model<Wrong>>(FAR);
    assert!(message.contains(&format!(": {}: ", Property::Write)), "{message}");
    assert!(message.lines().count() < 12 && !message.contains("nothing\n"), "{message}");
    found::has_marker(&folder, Property::Write);
}
