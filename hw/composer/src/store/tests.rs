use super::*;
use crate::merging_unit::Opaque;
use crate::test_util::{Clocked, point, rbuffer_store, screen};
use pellucid_machine::outside;
use pellucid_rbuffer::RBuffer;

/// What went into the store, with the cycle counted from the first merged pixel, and what was lost.
type Seen = (Vec<(u64, Marked<Fragment>)>, u32);

/// A frame: points at these places of the top row, behind an image of which each pixel has this depth. There is
/// no overhead after its lines.
fn frame(queue: u32, outside: Option<u32>, points: &[Fragment], depths: &[u32]) -> Seen {
    frame_with(0, queue, outside, points, depths)
}

/// The same with so many cycles of overhead after the last line.
fn frame_with(
    beta: usize,
    queue: u32,
    outside: Option<u32>,
    points: &[Fragment],
    depths: &[u32],
) -> Seen {
    let cfg = rbuffer_store(queue, outside);
    let pixels = cfg.screen().pixels();
    assert_eq!(depths.len(), pixels as usize);
    let mut sim = Clocked::<Store<RBuffer>>::new(cfg);
    let nothing = In {
        primitive: Stream::idle(),
        swap: false,
        merged: Stream::idle(),
        line_merged: false,
        image_ready: true,
        clear: Stream::idle(),
        outside: outside::In::default(),
    };
    while !sim.moore().merged_ready {
        sim.clock(nothing).unwrap();
    }
    let mut lost = 0;
    let primitives = points.iter().map(|f| Marked::item(point(*f))).chain([Marked::end()]);
    for primitive in primitives {
        let out = sim.clock(In { primitive: Stream::offer(primitive), ..nothing }).unwrap();
        lost += u32::from(out.lost.valid);
    }
    assert!(sim.moore().sorted);
    sim.clock(In { swap: true, ..nothing }).unwrap();
    let (mut seen, mut depths) = (vec![], depths.iter());
    // Cycles until the last line is complete, once its last pixel came.
    let mut overhead = beta;
    for cycle in 0..10_000 {
        if !sim.moore().busy {
            return (seen, lost);
        }
        let mut i = nothing;
        if sim.moore().merged_ready
            && let Some(z) = depths.next()
        {
            i.merged = Stream::offer(Opaque { z: *z, colour: 0x11_22_33 });
            i.line_merged = depths.len() == 0 && beta == 0;
        } else if depths.len() == 0 && overhead > 0 {
            overhead -= 1;
            i.line_merged = overhead == 0;
        }
        let fragment = sim.clock(i).unwrap().store.fragment;
        if fragment.fires() {
            let Marked { end, item } = fragment.payload;
            seen.push((cycle, if end { Marked::end() } else { Marked::item(item) }));
        }
    }
    panic!("the frame does not end");
}

fn transparent(x: u32, z: u32) -> Fragment {
    Fragment { x, y: 0, z, rgba: 0x10_20_30_40, label: Label::NONE }
}

#[test]
fn the_merged_image_then_a_transparent_fragment_a_cycle() {
    let screen = screen(7, 3);
    // One pixel in three was not drawn.
    let depths: Vec<u32> = (0..21).map(|k| if k % 3 == 1 { Z_FAR } else { 100 + k }).collect();
    let points = [transparent(4, 9), transparent(2, 8), transparent(2, 7)];
    let (seen, lost) = frame(4, Some(7), &points, &depths);
    let opaque = depths.iter().zip(0u32..).filter(|(z, _)| **z < Z_FAR).map(|(z, k)| {
        let (x, y) = (k % screen.width, k / screen.width);
        let item = Fragment { x, y, z: *z, rgba: 0x11_22_33_ff, label: Label::NONE };
        (u64::from(k), Marked::item(item))
    });
    let then = points.into_iter().map(Marked::item).chain([Marked::end()]);
    let expected: Vec<_> = opaque.chain((21..).zip(then)).collect();
    assert_eq!((seen, lost), (expected, 0));
}

/// The last of 21 pixels comes in cycle 20, and the line is complete `beta` cycles later.
#[test]
fn the_end_of_a_frame_waits_for_the_overhead_of_its_last_line() {
    for points in [&[][..], &[transparent(4, 9), transparent(2, 8)]] {
        for beta in [0, 1, 2, 3, 50] {
            let (seen, _) = frame_with(beta, 4, Some(7), points, &[Z_FAR; 21]);
            let cycles: Vec<u64> = seen.iter().map(|(cycle, _)| *cycle).collect();
            let fragments = points.len() as u64;
            let end = (21 + fragments).max(21 + beta as u64);
            let expected: Vec<u64> = (21..21 + fragments).chain([end]).collect();
            assert_eq!(cycles, expected, "beta = {beta}");
        }
    }
}

#[test]
fn what_is_asked_for_again_are_the_transparent_fragments() {
    // Of six fragments in two pixels the queue has room for three.
    let points: Vec<Fragment> = (0..6).map(|k| transparent(k % 2, k)).collect();
    let (seen, _) = frame(3, None, &points, &[Z_FAR; 21]);
    let round = points.into_iter().map(Marked::item).chain([Marked::end()]);
    let seen: Vec<_> = seen.into_iter().map(|(_, item)| item).collect();
    let rounds = seen.len() / 7;
    assert_eq!(seen, round.collect::<Vec<_>>().repeat(rounds));
    // Half of the frame at a time at most.
    assert!(rounds >= 2);
}

#[test]
fn primitives_without_a_place_are_lost() {
    let points = [transparent(0, 1); 15];
    let (seen, lost) = frame(20, Some(0), &points, &[5; 21]);
    assert_eq!((seen.len(), lost), (21 + 12 + 1, 3));
}
