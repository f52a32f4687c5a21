use super::*;
use crate::test_util::{Pattern, Source, Triangle, pattern, scan_line, triangle};
use pellucid_machine::pixel::{Fragment, Z_FAR, blend};
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;

/// An engine with its lists emptied.
fn engine(cfg: Config) -> Sim<ScanLine> {
    let mut sim = Sim::<ScanLine>::new(cfg);
    for position in 0..cfg.screen().pixels() {
        sim.clock(In { clear: Stream::offer(position), ..nothing() }).unwrap();
    }
    sim
}

fn nothing() -> In {
    In {
        primitive: Stream::idle(),
        swap: false,
        merged: Stream::idle(),
        line_merged: false,
        result_ready: false,
        clear: Stream::idle(),
    }
}

/// What came of a frame.
#[derive(Debug, Default)]
struct Rendered {
    /// The colours of its pixels.
    colours: Vec<u32>,
    /// Transparent fragments that were given, and how many of them were hidden.
    fragments: u64,
    hidden: u64,
    /// Fragments for which there was no place.
    lost: u64,
    /// Primitives for which there was none.
    lost_primitives: u64,
    cycles: u64,
}

/// Renders the frame whose primitives were sorted before over `opaque`, while `next` is sorted.
fn frame(
    sim: &mut Sim<ScanLine>,
    opaque: &[Opaque],
    next: &[Primitive],
    merges: &Pattern,
    ready: &Pattern,
) -> Rendered {
    let width = sim.config().screen().width as usize;
    sim.clock(In { swap: true, ..nothing() }).unwrap();
    let items = next.iter().copied().map(Marked::item).chain([Marked::end()]);
    let mut source = Source::new(items, Pattern::always());
    let mut monitor = StreamMonitor::new("result", "ScanLine", "test");
    let mut merged = 0;
    let mut r = Rendered::default();
    while r.colours.len() < opaque.len() || !sim.moore().sorted {
        r.cycles += 1;
        assert!(r.cycles < 100_000, "the frame does not end");
        let seen = sim.moore();
        let mut i = In { primitive: source.offer(r.cycles), ..nothing() };
        if merged < opaque.len() && merges.at(r.cycles) {
            i.merged = Stream::offer(opaque[merged]);
            merged += 1;
            i.line_merged = merged % width == 0;
        }
        i.result_ready = ready.at(r.cycles);
        let result = seen.result.with(i.result_ready);
        monitor.observe(result).unwrap();
        r.colours.extend(result.fires().then_some(result.payload));
        r.lost_primitives += u64::from(lost(sim.config(), sim.state()).is_some());
        let out = sim.clock(i).unwrap().out;
        source.edge(seen.ready);
        r.fragments += u64::from(out.fragment);
        r.hidden += u64::from(out.hidden);
        r.lost += u64::from(out.lost);
    }
    r
}

/// The engine's part of an image, by definition: fragments in front of the opaque pixel, far to near, of
/// equal ones the first first; and how many fragments there are, and are hidden.
fn blended(cfg: &Config, opaque: &[Opaque], triangles: &[Triangle]) -> (Vec<u32>, u64, u64) {
    let sort = &cfg.bucket_sort;
    let own = |f: &Fragment| f.y % sort.engines == sort.index;
    let fragments: Vec<Fragment> =
        triangles.iter().flat_map(|t| t.fragments(sort.screen)).filter(own).collect();
    let mut hidden = 0;
    let pixel = |(p, below): (usize, &Opaque)| {
        let (line, x) = (p as u32 / sort.screen.width, p as u32 % sort.screen.width);
        let y = line * sort.engines + sort.index;
        let here = fragments.iter().filter(|f| (f.x, f.y) == (x, y));
        let (mut visible, behind): (Vec<Fragment>, Vec<Fragment>) =
            here.partition(|f| f.z < below.z);
        hidden += behind.len() as u64;
        visible.sort_by_key(|f| std::cmp::Reverse(f.z));
        visible.iter().fold(below.colour, |colour, f| blend(f.rgba, colour))
    };
    let image = opaque.iter().enumerate().map(pixel).collect();
    (image, fragments.len() as u64, hidden)
}

fn some_triangle() -> impl Strategy<Value = Triangle> {
    let channel = || (0i64..256, -300_000i64..300_000, -300_000i64..300_000);
    (
        proptest::array::uniform3((-400i64..2200, -400i64..1700)),
        (0i64..6, -70_000i64..70_000),
        proptest::array::uniform4(channel()),
    )
        .prop_map(|(corners, (z, dz), colour)| Triangle {
            corners,
            z: [z << 16, dz, 0],
            colour: colour.map(|(at, dx, dy)| [at << 16, dx, dy]),
            opaque: false,
        })
}

fn opaque(cfg: &Config, seed: u32) -> Vec<Opaque> {
    let pixel = |p: u32| {
        let number = (p + seed).wrapping_mul(0x9e37_79b9);
        let z = if number >> 30 == 0 { Z_FAR } else { number >> 29 };
        Opaque { z, colour: number >> 8 }
    };
    (0..cfg.pixels()).map(pixel).collect()
}

/// A triangle that covers the screen, at a depth.
fn sheet(z: i64) -> Triangle {
    Triangle {
        corners: [(-100, -100), (6000, -100), (-100, 6000)],
        z: [z << 16, 0, 0],
        colour: [[z << 20, 0, 0], [90 << 16, 0, 0], [7 << 16, 0, 0], [100 << 16, 0, 0]],
        opaque: false,
    }
}

/// Renders one frame on an engine of its own.
fn render(cfg: Config, opaque: &[Opaque], triangles: &[Triangle]) -> Rendered {
    let mut sim = engine(cfg);
    let always = Pattern::always();
    let primitives: Vec<Primitive> =
        triangles.iter().filter_map(|t| triangle(*cfg.screen(), t)).collect();
    frame(&mut sim, opaque, &primitives, &always, &always);
    frame(&mut sim, opaque, &[], &always, &always)
}

#[test]
fn sheets_are_sorted_in_as_many_passes_as_it_takes() {
    let cfg = scan_line(1, 0);
    let far = vec![Opaque { z: Z_FAR, colour: 0x12_34_56 }; cfg.pixels() as usize];
    let behind = vec![Opaque { z: 4, colour: 0x12_34_56 }; cfg.pixels() as usize];
    // Equal depths among them; the sorter takes three fragments in a pass, one of them opaque.
    for sheets in 0..=9 {
        let triangles: Vec<Triangle> = (0..sheets).map(|k| sheet(k * 5 % 8)).collect();
        for opaque in [&far, &behind] {
            let rendered = render(cfg, opaque, &triangles);
            let (colours, fragments, hidden) = blended(&cfg, opaque, &triangles);
            assert_eq!(rendered.colours, colours, "{sheets} sheets");
            assert_eq!((rendered.fragments, rendered.hidden), (fragments, hidden));
        }
    }
}

#[test]
fn what_has_no_place_is_counted() {
    let cfg = scan_line(1, 0);
    let far = vec![Opaque { z: Z_FAR, colour: 0 }; cfg.pixels() as usize];
    // A line may have 9 primitives, the buckets 12.
    let triangles: Vec<Triangle> = (0..14).map(sheet).collect();
    let mut sim = engine(cfg);
    let always = Pattern::always();
    let primitives: Vec<Primitive> =
        triangles.iter().filter_map(|t| triangle(*cfg.screen(), t)).collect();
    let first = frame(&mut sim, &far, &primitives, &always, &always);
    let second = frame(&mut sim, &far, &[], &always, &always);
    assert_eq!((first.lost_primitives, second.lost), (2, u64::from(cfg.pixels() * 3)));
    assert_eq!(second.colours, blended(&cfg, &far, &triangles[..9]).0);
}

#[test]
fn a_pixel_takes_a_cycle_for_each_fragment() {
    let cfg = Config { sorter_depth: 8, ..scan_line(1, 0) };
    let far = vec![Opaque { z: Z_FAR, colour: 0 }; cfg.pixels() as usize];
    let cycles = |sheets: i64| {
        let triangles: Vec<Triangle> = (0..sheets).map(sheet).collect();
        render(cfg, &far, &triangles).cycles
    };
    // The fragments of the last pixel leave the sorter once they are all in.
    let more = u64::from(cfg.pixels()) + 1;
    for sheets in 1..5 {
        assert_eq!(cycles(sheets) - cycles(sheets - 1), more, "{sheets} sheets");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// Frames with other primitives and other opaque pixels, whatever stalls; the lines of one of several
    /// engines.
    #[test]
    fn its_lines_are_those_of_the_image(
        frames in proptest::collection::vec(
            (proptest::collection::vec(some_triangle(), 0..9), any::<u32>()), 1..3,
        ),
        engines in 1u32..=5,
        index in 0u32..5,
        merges in pattern(),
        ready in pattern(),
    ) {
        prop_assume!(index < engines);
        let cfg = scan_line(engines, index);
        let mut sim = engine(cfg);
        let mut before: Vec<Triangle> = vec![];
        for (triangles, seed) in frames.iter().chain([&(vec![], 7)]) {
            let primitives: Vec<Primitive> =
                triangles.iter().filter_map(|t| triangle(*cfg.screen(), t)).collect();
            let opaque = opaque(&cfg, seed >> 8);
            let rendered = frame(&mut sim, &opaque, &primitives, &merges, &ready);
            let (colours, fragments, hidden) = blended(&cfg, &opaque, &before);
            prop_assert_eq!(rendered.colours, colours);
            prop_assert_eq!((rendered.fragments, rendered.hidden), (fragments, hidden));
            prop_assert_eq!((rendered.lost, rendered.lost_primitives), (0, 0));
            before = triangles.clone();
        }
    }
}
