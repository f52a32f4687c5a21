use super::config::{Distribution, Params};
use super::monitor::ComposerMonitor;
use super::scan_lines::ScanLines;
use super::store::Store;
use super::*;
use crate::test_util::{Pattern, Source, Triangle, composer, pattern, screen, triangle};
use pellucid_blocks::allocator::FreeList;
use pellucid_machine::board::Board;
use pellucid_machine::pixel::{Fragment, Z_FAR, blend};
use pellucid_machine::{Census, Fragments, Machine, Monitor, Tally};
use pellucid_rbuffer::{RBuffer, config as rbuffer};
use pellucid_sim::Sim;
use pellucid_sim::block::Cycle;
use pellucid_tbuffer::{TBuffer, config as tbuffer};
use proptest::prelude::*;

/// Plays frames one right after the other; gives the images, and what was counted.
fn play<T: Transparency>(
    cfg: Config<T::Config>,
    frames: &[Vec<Triangle>],
    starts: &Pattern,
    ready: &Pattern,
) -> (Vec<Vec<u32>>, Tally) {
    let screen = *cfg.screen();
    let items = frames.iter().flat_map(|frame| {
        let primitives = frame.iter().filter_map(move |t| triangle(screen, t));
        primitives.map(Marked::item).chain([Marked::end()])
    });
    let mut source = Source::new(items.collect::<Vec<_>>(), starts.clone());
    let mut sim = Sim::<Board<Composer<T>>>::new(cfg);
    let mut monitor = ComposerMonitor::<T>::new(&cfg);
    let mut shown = vec![];
    for cycle in 0.. {
        assert!(cycle < 200_000, "the images do not end");
        let i = pellucid_machine::PrimitiveIn {
            primitive: source.offer(cycle),
            image_ready: ready.at(cycle),
            outside: sim.memories().outside(),
        };
        let Cycle { cfg, q, out } = sim.clock(i).unwrap();
        monitor.observe(cfg, q, &out).unwrap();
        source.edge(out.primitive.ready);
        shown.extend(out.image.fires().then_some(out.image.payload));
        if shown.len() == frames.len() * screen.pixels() as usize {
            break;
        }
    }
    let images = shown.chunks(screen.pixels() as usize).map(<[u32]>::to_vec).collect();
    let mut memories = vec![];
    sim.memories()
        .visit("", &mut |path, storage| memories.push((path.to_string(), storage.info())));
    (images, monitor.tally(&cfg, &memories))
}

/// The image of a frame by definition: opaque fragments engine by engine, the nearest first one stays;
/// transparent ones in front of it far to near, of equal ones the first first. How many of these there are,
/// and are hidden, is added to `counts`; also gives what is known of the frame.
fn image<C>(cfg: &Config<C>, frame: &[Triangle], counts: &mut Fragments) -> (Vec<u32>, Census) {
    let screen = *cfg.screen();
    let mut engines = cfg.distributor.distribution.engines(cfg.engines());
    let (mut opaque, mut transparent) = (vec![vec![]; cfg.engines() as usize], vec![]);
    for t in frame {
        let Some(primitive) = triangle(screen, t) else { continue };
        if primitive.opaque {
            opaque[engines.engine(&primitive) as usize].extend(t.fragments(screen));
        } else {
            transparent.extend(t.fragments(screen));
        }
    }
    counts.arrived += (opaque.iter().flatten().count() + transparent.len()) as u64;
    let mut histogram = vec![0; transparent.len() + 1];
    let mut at = |(x, y): (u32, u32)| {
        let here = |f: &&Fragment| (f.x, f.y) == (x, y);
        let below =
            opaque.iter().flatten().filter(here).fold((Z_FAR, screen.background), |below, f| {
                if f.z < below.0 { (f.z, f.rgba >> 8) } else { below }
            });
        let mut above: Vec<&Fragment> =
            transparent.iter().filter(here).filter(|f| f.z < below.0).collect();
        counts.blended += above.len() as u64;
        histogram[above.len()] += 1;
        counts.culled += (transparent.iter().filter(here).count() - above.len()) as u64;
        above.sort_by_key(|f| std::cmp::Reverse(f.z));
        above.iter().fold(below.1, |colour, f| blend(f.rgba, colour))
    };
    let image = (0..screen.pixels()).map(|p| at((p % screen.width, p / screen.width))).collect();
    let stored = histogram.iter().zip(0..).map(|(pixels, layers)| pixels * layers).sum();
    let transparent = counts.blended + counts.culled;
    (image, Census { transparent, stored, visible: histogram.clone(), histogram })
}

/// Plays frames, and holds images and counts to what is known without the machine.
fn check<T: Transparency>(
    cfg: Config<T::Config>,
    frames: &[Vec<Triangle>],
    starts: &Pattern,
    ready: &Pattern,
) -> Result<(), TestCaseError> {
    let (images, tally) = play::<T>(cfg, frames, starts, ready);
    let mut counts = Fragments::default();
    let (expected, census): (Vec<Vec<u32>>, Vec<Census>) =
        frames.iter().map(|frame| image(&cfg, frame, &mut counts)).unzip();
    prop_assert_eq!(images, expected);
    let found = tally.fragments;
    prop_assert_eq!(found.arrived, counts.arrived);
    prop_assert_eq!(
        [found.blended, found.stored, found.culled, found.dropped],
        [counts.blended, counts.blended, counts.culled, 0]
    );
    prop_assert_eq!(found.drawn + found.hidden + found.blended + found.culled, counts.arrived);
    for check in Composer::<T>::closed_forms(&cfg, &tally, &census) {
        prop_assert_eq!(check.found, check.expected, "{}", check.what);
    }
    Ok(())
}

/// What stands behind the merger.
#[derive(Clone, Copy, Debug)]
enum Behind {
    ScanLines(u32),
    TBuffer,
    RBuffer(rbuffer::Params),
}

fn behind() -> impl Strategy<Value = Behind> {
    let rbuffer = (2u32..40, any::<bool>()).prop_map(|(queue, replay)| rbuffer::Params {
        queue,
        overflow: if replay { rbuffer::Overflow::Replay } else { rbuffer::Overflow::Outside },
        outside_queue: 400,
        outside_latency: 3,
        ..rbuffer::Params::default()
    });
    prop_oneof![
        2 => (1u32..=5).prop_map(Behind::ScanLines),
        1 => Just(Behind::TBuffer),
        1 => rbuffer.prop_map(Behind::RBuffer),
    ]
}

fn some_triangle() -> impl Strategy<Value = Triangle> {
    let channel = || (0i64..256, -300_000i64..300_000, -300_000i64..300_000);
    (
        proptest::array::uniform3((-400i64..2200, -400i64..1700)),
        (0i64..5, -70_000i64..70_000),
        proptest::array::uniform4(channel()),
        any::<bool>(),
    )
        .prop_map(|(corners, (z, dz), colour, opaque)| Triangle {
            corners,
            z: [z << 16, dz, 0],
            colour: colour.map(|(at, dx, dy)| [at << 16, dx, dy]),
            opaque,
        })
}

/// Any screen of few pixels, the least among them.
fn some_screen() -> impl Strategy<Value = Screen> {
    let sides = prop_oneof![2 => Just((7, 5)), 1 => Just((1, 1)), 3 => (1u32..=8, 1u32..=6)];
    sides.prop_map(|(width, height)| screen(width, height))
}

/// Primitives that a machine must have room for so that it loses none of these frames: at least one.
fn transparent_primitives(screen: Screen, frames: &[Vec<Triangle>]) -> u32 {
    let there = |t: &&Triangle| !t.opaque && triangle(screen, t).is_some();
    let most = frames.iter().map(|frame| frame.iter().filter(there).count()).max();
    most.unwrap_or(0).max(1) as u32
}

/// A square over the screen's middle.
fn sheet(z: i64, colour: [i64; 3], alpha: i64) -> [Triangle; 2] {
    let [a, b, c, d] = [(256, 256), (1280, 256), (256, 1024), (1280, 1024)];
    let colour = [colour[0], colour[1], colour[2], alpha].map(|c| [c << 16, 0, 0]);
    [[a, b, c], [b, d, c]].map(|corners| Triangle {
        corners,
        z: [z << 16, 0, 0],
        colour,
        opaque: alpha == 255,
    })
}

/// Seed 001, figure 7: of the primitives A to G, nearest first, A, C and G are transparent, the others
/// opaque. C and G lie behind B, so that A's yellow is blended with B's blue.
#[test]
fn yellow_over_blue_is_green() {
    let (yellow, blue, red, black, green) =
        ([255, 255, 0], [0, 0, 255], [255, 0, 0], [0, 0, 0], [0, 255, 0]);
    let a = sheet(1, yellow, 128);
    let b = sheet(2, blue, 255);
    let c = sheet(3, red, 128);
    let d = sheet(4, blue, 255);
    let e = sheet(5, yellow, 255);
    let f = sheet(6, black, 255);
    let g = sheet(7, green, 128);
    // Whatever the order in which they come.
    let forward = [&a, &b, &c, &d, &e, &f, &g].map(|s| s.to_vec()).concat();
    let others = [&c, &g, &a, &f, &b, &e, &d].map(|s| s.to_vec()).concat();
    let always = Pattern::always();
    let (images, _) = play::<ScanLines>(composer(3, 2), &[forward, others], &always, &always);
    for image in images {
        // 128 of 255 of yellow, 127 of 255 of blue: as much red as green, and as much of blue but one.
        assert_eq!(image[3 * 7 + 3], 0x80_80_7f);
        assert_eq!(image[0], composer(3, 2).screen().background);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    /// Any number of engines, whatever is behind them, either distribution, any overhead, no more room than is needed,
    /// frames in a row, whatever stalls.
    #[test]
    fn images_are_what_the_golden_model_says(
        screen in some_screen(),
        frames in proptest::collection::vec(proptest::collection::vec(some_triangle(), 0..8), 1..4),
        engines in 1u32..=8,
        behind in behind(),
        beta in prop_oneof![3 => 0u32..=3, 1 => Just(1023)],
        by_area: bool,
        starts in pattern(),
        ready in pattern(),
    ) {
        let params = Params {
            engines,
            distribution: if by_area { Distribution::Area } else { Distribution::RoundRobin },
            beta,
            primitives: transparent_primitives(screen, &frames),
            sorter_depth: 3,
            tbuffer: tbuffer::Params { sections: 7, outside_sections: 400, ..tbuffer::Params::default() },
            ..Params::default()
        };
        match behind {
            Behind::ScanLines(scan_line_engines) => {
                let scan_line_engines = scan_line_engines.min(screen.height);
                let cfg = config::scan_lines(screen, &Params { scan_line_engines, ..params }).unwrap();
                check::<ScanLines>(cfg, &frames, &starts, &ready)?;
            }
            Behind::TBuffer => {
                let store = tbuffer::Config::new(screen, params.tbuffer).unwrap();
                let cfg = config::store(screen, &params, store, "tbuffer").unwrap();
                check::<Store<TBuffer<FreeList>>>(cfg, &frames, &starts, &ready)?;
            }
            Behind::RBuffer(rbuffer) => {
                // Sent again pixel by pixel, the frame still needs room for the fragments of one.
                let queue = rbuffer.queue.max(params.primitives);
                let rbuffer = rbuffer::Params { queue, ..rbuffer };
                let store = rbuffer::Config::new(screen, rbuffer).unwrap();
                let cfg = config::store(screen, &params, store, "rbuffer").unwrap();
                check::<Store<RBuffer>>(cfg, &frames, &starts, &ready)?;
            }
        }
    }
}
