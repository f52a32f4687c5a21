use super::*;
use crate::test_util::{Pattern, Source, Triangle, pattern, primitive, screen, triangle};
use pellucid_machine::pixel::Z_FAR;
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;

const WIDTH: u32 = 9;
const HEIGHT: u32 = 7;

fn config(set_up_cycles: u32, fragment_cycles: u32) -> Config {
    Config { screen: screen(WIDTH, HEIGHT), set_up_cycles, fragment_cycles }
}

/// Walks primitives; gives the fragments with the cycles in which they were given, and the end's.
fn walk(cfg: Config, primitives: &[Primitive], ready: &Pattern) -> (Vec<(u64, Fragment)>, u64) {
    let items = primitives.iter().copied().map(Marked::item).chain([Marked::end()]);
    let mut source = Source::new(items, Pattern::always());
    let mut sim = Sim::<Walker>::new(cfg);
    let mut monitor = StreamMonitor::new("fragment", "Walker", "test");
    let mut given = vec![];
    for cycle in 0.. {
        assert!(cycle < 100_000, "the end of the frame does not come");
        let fragment = sim.moore().fragment.with(ready.at(cycle));
        monitor.observe(fragment).unwrap();
        if fragment.fires() && fragment.payload.end {
            return (given, cycle);
        }
        given.extend(fragment.fires().then_some((cycle, fragment.payload.item)));
        let i = In { primitive: source.offer(cycle), fragment_ready: fragment.ready };
        let taken = sim.clock(i).unwrap().out.taken;
        source.edge(taken);
    }
    unreachable!()
}

/// A triangle of three pixels in the first row and one in the second.
fn small() -> Triangle {
    Triangle { corners: [(0, 0), (3 * 256 + 200, 0), (0, 2 * 256)], ..Triangle::default() }
}

#[test]
fn by_hand() {
    let places = |t: &Triangle| {
        let (given, _) =
            walk(config(1, 1), &[primitive(screen(WIDTH, HEIGHT), t)], &Pattern::always());
        given.iter().map(|(_, f)| (f.x, f.y)).collect::<Vec<_>>()
    };
    // The hypotenuse crosses the rows' middles at 2.84 and at 0.95.
    assert_eq!(places(&small()), [(0, 0), (1, 0), (2, 0), (0, 1)]);
    // Half a pixel further down and right, its upper and left edges go through centres: they are its own.
    let moved = small().corners.map(|(x, y)| (x + 128, y + 128));
    assert_eq!(
        places(&Triangle { corners: moved, ..Triangle::default() }),
        [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1)]
    );
}

#[test]
fn a_fragment_a_cycle_without_a_break() {
    let one = primitive(screen(WIDTH, HEIGHT), &small());
    let (given, end) = walk(config(1, 1), &[one; 3], &Pattern::always());
    // Taken, set up, then walked: the first fragment is there two cycles after the primitive.
    let cycles: Vec<u64> = given.iter().map(|(cycle, _)| *cycle).collect();
    assert_eq!(cycles, (2..14).collect::<Vec<_>>());
    assert_eq!(end, 14);
}

#[test]
fn set_up_and_fragments_take_their_time() {
    let one = primitive(screen(WIDTH, HEIGHT), &small());
    let cycles = |cfg| {
        let (given, _) = walk(cfg, &[one; 2], &Pattern::always());
        given.iter().map(|(cycle, _)| *cycle).collect::<Vec<_>>()
    };
    // The set-up of ten cycles goes on beside the walk of four.
    assert_eq!(cycles(config(10, 1)), [11, 12, 13, 14, 21, 22, 23, 24]);
    assert_eq!(cycles(config(1, 3)), [2, 5, 8, 11, 14, 17, 20, 23]);
}

fn some_triangle() -> impl Strategy<Value = Triangle> {
    let corner = (-1500i64..4000, -1500i64..3500);
    let channel = || (-300i64..300, -4_000_000i64..4_000_000, -4_000_000i64..4_000_000);
    let plane = prop_oneof![
        3 => channel().prop_map(|(at, dx, dy)| [at << 16, dx, dy]),
        1 => channel().prop_map(|(at, _, _)| [at << 16, 0, 0]),
    ];
    let depth = (-10i64..1 << 24, -(1i64 << 37)..1 << 37, -(1i64 << 37)..1 << 37);
    (
        proptest::array::uniform3(corner),
        depth.prop_map(|(at, dx, dy)| [at << 16, dx, dy]),
        proptest::array::uniform4(plane),
        any::<bool>(),
    )
        .prop_map(|(corners, z, colour, opaque)| Triangle { corners, z, colour, opaque })
}

proptest! {
    /// Coverage by edge functions, depth and colour as planes, whatever stalls.
    #[test]
    fn a_triangle_is_its_pixels(
        triangles in proptest::collection::vec(some_triangle(), 0..6),
        set_up_cycles in 1u32..4,
        fragment_cycles in 1u32..3,
        ready in pattern(),
    ) {
        let cfg = config(set_up_cycles, fragment_cycles);
        let primitives: Vec<Primitive> =
            triangles.iter().filter_map(|t| triangle(cfg.screen, t)).collect();
        let (given, _) = walk(cfg, &primitives, &ready);
        let given: Vec<Fragment> = given.into_iter().map(|(_, fragment)| fragment).collect();
        let expected: Vec<Fragment> =
            triangles.iter().flat_map(|t| t.fragments(cfg.screen)).collect();
        prop_assert_eq!(given, expected);
    }
}

#[test]
fn depth_and_colour_stay_in_their_range() {
    let far = Triangle {
        z: [i64::from(Z_FAR + 1) << 16, 0, 0],
        colour: [[300 << 16, 0, 0], [-1, 0, 0], [0, 0, 0], [255 << 16, 0, 0]],
        ..small()
    };
    let at =
        |t| walk(config(1, 1), &[primitive(screen(WIDTH, HEIGHT), &t)], &Pattern::always()).0[0].1;
    assert_eq!((at(far.clone()).z, at(far.clone()).rgba), (Z_FAR, 0xff_00_00_fe));
    assert_eq!(at(Triangle { z: [-1, 0, 0], opaque: true, ..far }).z, 0);
}

#[test]
#[should_panic(expected = "the number of cycles of a set-up is 0: expected at least 1")]
fn a_set_up_takes_a_cycle() {
    Walker::reset(&config(0, 1));
}

#[test]
#[should_panic(expected = "the number of cycles of a fragment is 0: expected at least 1")]
fn a_fragment_takes_a_cycle() {
    Walker::reset(&config(1, 0));
}
