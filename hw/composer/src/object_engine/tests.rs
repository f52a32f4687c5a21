use super::*;
use crate::test_util::{Pattern, Source, Triangle, object_engine, pattern, screen, triangle};
use pellucid_machine::pixel::Z_FAR;
use pellucid_sim::Sim;
use proptest::prelude::*;

/// An engine with both banks wiped.
fn engine() -> Sim<ObjectEngine> {
    let cfg = object_engine(2);
    let mut sim = Sim::<ObjectEngine>::new(cfg);
    for pixel in 0..cfg.screen().pixels() {
        sim.clock(In { clear: Stream::offer(pixel), ..nothing() }).unwrap();
    }
    sim
}

fn nothing() -> In {
    In {
        primitive: Stream::idle(),
        read: ReadPort::default(),
        wipe: Stream::idle(),
        clear: Stream::idle(),
        swap: false,
    }
}

/// Draws a frame while the one before is read and wiped: that one, and how many fragments were drawn and
/// hidden.
fn draw(
    sim: &mut Sim<ObjectEngine>,
    primitives: &[Primitive],
    starts: &Pattern,
) -> (Vec<Opaque>, [u64; 2]) {
    let items = primitives.iter().copied().map(Marked::item).chain([Marked::end()]);
    let mut source = Source::new(items, starts.clone());
    let (mut before, mut counts) = (vec![], [0; 2]);
    let pixels = sim.config().screen().pixels();
    for cycle in 0u32.. {
        assert!(cycle < 100_000, "the frame does not end");
        let seen = sim.moore();
        if seen.done && cycle > pixels {
            break;
        }
        let mut i = In { primitive: source.offer(cycle.into()), ..nothing() };
        if cycle < pixels {
            i.read.read(cycle);
        }
        if (1..=pixels).contains(&cycle) {
            before.push(seen.local);
            i.wipe = Stream::offer(cycle - 1);
        }
        let out = sim.clock(i).unwrap().out;
        source.edge(seen.ready);
        counts[0] += u64::from(out.drawn);
        counts[1] += u64::from(out.hidden);
    }
    sim.clock(In { swap: true, ..nothing() }).unwrap();
    assert!(!sim.moore().done);
    (before, counts)
}

/// What must be drawn: the nearest fragment of each pixel, of equal ones the first; and how many must be
/// drawn and hidden.
fn nearest(screen: Screen, triangles: &[Triangle]) -> (Vec<Opaque>, [u64; 2]) {
    let wiped = Opaque { z: Z_FAR, colour: screen.background };
    let (mut image, mut counts) = (vec![wiped; screen.pixels() as usize], [0; 2]);
    for f in triangles.iter().flat_map(|t| t.fragments(screen)) {
        let pixel = &mut image[(f.y * screen.width + f.x) as usize];
        counts[usize::from(f.z >= pixel.z)] += 1;
        if f.z < pixel.z {
            *pixel = Opaque { z: f.z, colour: f.rgba >> 8 };
        }
    }
    (image, counts)
}

fn some_triangle() -> impl Strategy<Value = Triangle> {
    (proptest::array::uniform3((-300i64..2000, -300i64..1500)), 0i64..5, 0i64..256).prop_map(
        |(corners, z, red)| Triangle {
            corners,
            z: [z << 16, 1 << 15, 0],
            colour: [[red << 16, 0, 0], [0; 3], [0; 3], [0; 3]],
            opaque: true,
        },
    )
}

proptest! {
    /// A frame is drawn while the one before is read: two frames, and an empty one that shows the second.
    #[test]
    fn frames_are_drawn_one_after_the_other(
        frames in proptest::array::uniform2(proptest::collection::vec(some_triangle(), 0..5)),
        starts in pattern(),
    ) {
        let screen = screen(7, 5);
        let mut sim = engine();
        let mut before = nearest(screen, &[]).0;
        for triangles in frames.iter().chain([&vec![]]) {
            let primitives: Vec<Primitive> =
                triangles.iter().filter_map(|t| triangle(screen, t)).collect();
            let (image, counts) = draw(&mut sim, &primitives, &starts);
            let (expected, expected_counts) = nearest(screen, triangles);
            prop_assert_eq!(image, before);
            prop_assert_eq!(counts, expected_counts);
            before = expected;
        }
    }
}

#[test]
#[should_panic(expected = "the depth of a FIFO is 0: expected at least 1")]
fn a_primitive_can_wait() {
    ObjectEngine::reset(&crate::test_util::object_engine(0));
}
