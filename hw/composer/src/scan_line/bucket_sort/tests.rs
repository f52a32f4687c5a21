use super::*;
use crate::test_util::{Pattern, Source, Triangle, pattern, screen, triangle};
use pellucid_machine::primitive::next_row;
use pellucid_sim::Sim;
use proptest::prelude::*;

const WIDTH: u32 = 5;

/// What is sorted, with the cycles that took.
fn sort(cfg: Config, primitives: &[Primitive], starts: Pattern) -> (Vec<Insert<Primitive>>, u64) {
    let items = primitives.iter().copied().map(Marked::item).chain([Marked::end()]);
    let mut source = Source::new(items, starts);
    let mut sim = Sim::<BucketSort>::new(cfg);
    let mut sorted = vec![];
    for cycle in 0.. {
        assert!(cycle < 10_000, "the end of the frame does not come");
        let seen = sim.moore();
        if seen.done {
            return (sorted, cycle);
        }
        sorted.extend(seen.insert.valid.then_some(seen.insert.payload));
        sim.clock(In { primitive: source.offer(cycle), restart: false }).unwrap();
        source.edge(seen.ready);
    }
    unreachable!()
}

/// The rows of one engine that a primitive has, each with its edges and values, by going through all rows.
fn rows(cfg: &Config, primitive: &Primitive) -> Vec<(u32, Primitive)> {
    let mut at = *primitive;
    let mut rows = vec![];
    for row in primitive.row..=primitive.last_row {
        if row % cfg.engines == cfg.index {
            rows.push((row / cfg.engines, at));
        }
        at = next_row(at);
    }
    rows
}

fn some_triangle() -> impl Strategy<Value = Triangle> {
    let step = -5_000_000i64..5_000_000;
    (proptest::array::uniform3((-300i64..1500, -300i64..5000)), step.clone(), step).prop_map(
        |(corners, dx, dy)| Triangle {
            corners,
            z: [dx, dx, dy],
            colour: [[dx, dy, dx]; 4],
            opaque: false,
        },
    )
}

proptest! {
    /// From line to line a primitive is what it is when it goes row by row, and it takes a cycle for each
    /// engine.
    #[test]
    fn lines_are_every_so_many_rows(
        triangles in proptest::collection::vec(some_triangle(), 0..6),
        height in 1u32..19,
        engines in 1u32..6,
        index in 0u32..6,
        starts in pattern(),
    ) {
        prop_assume!(engines <= height && index < engines);
        let cfg = Config { screen: screen(WIDTH, height), engines, index, capacity: 9 };
        let primitives: Vec<Primitive> =
            triangles.iter().filter_map(|t| triangle(cfg.screen, t)).collect();
        let (sorted, _) = sort(cfg, &primitives, starts);
        let expected: Vec<_> =
            primitives.iter().map(|p| rows(&cfg, p)).filter(|rows| !rows.is_empty()).collect();
        prop_assert_eq!(sorted.len(), expected.len());
        for (insert, rows) in sorted.iter().zip(expected) {
            let mut item = insert.item;
            prop_assert_eq!(insert.position, rows[0].0);
            prop_assert_eq!(item.last_row, rows[rows.len() - 1].0);
            for (line, row) in rows {
                prop_assert_eq!(item.row, line);
                prop_assert_eq!(item.at, row.at);
                for k in 0..3 {
                    prop_assert_eq!(item.edges[k].bound, row.edges[k].bound);
                    prop_assert_eq!(item.edges[k].rest, row.edges[k].rest);
                }
                item = next_row(item);
            }
        }
        let (_, cycles) = sort(cfg, &primitives, Pattern::always());
        prop_assert_eq!(cycles, primitives.len() as u64 * u64::from(engines) + 1);
    }

    /// The quotient is exact, whatever the row.
    #[test]
    fn rows_are_divided_exactly(row in 0..pellucid_machine::pixel::MAX_SIDE, engines in 1u32..4096) {
        let cfg = Config { screen: screen(1, 8192), engines, index: 0, capacity: 1 };
        prop_assert_eq!(quotient(row, cfg.reciprocal()), row / engines);
    }
}

#[test]
#[should_panic(expected = "the number of scan-line engines is 4: expected 1 to 3")]
fn an_engine_has_a_line() {
    BucketSort::reset(&Config { screen: screen(5, 3), engines: 4, index: 0, capacity: 9 });
}

#[test]
#[should_panic(expected = "the index of a scan-line engine is 2: expected at most 1")]
fn an_engine_is_one_of_them() {
    BucketSort::reset(&Config { screen: screen(5, 3), engines: 2, index: 2, capacity: 9 });
}
