//! The T-buffer against the golden model, frame by frame.

use std::path::Path;

use pellucid_hw::allocator::FreeList;
use pellucid_hw::machine::{Census, Check, Machine, Tally};
use pellucid_hw::pixel::{Fragment, Marked, Screen, Z_FAR};
use pellucid_hw::tbuffer::TBuffer;
use pellucid_hw::tbuffer::config::{Append, Config, Params, Scan};
use pellucid_sim::Stream;
use pellucid_testbench::arch::{Architecture, Job, Outcome};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::{Golden, GoldenError, Reference};
use pellucid_testbench::image::Image;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::scene::{Options, built_in};
use pellucid_testbench::scoreboard::Verdict;
use pellucid_testbench::source::{Source, SourceError};
use pellucid_testbench::stimulus::chosen;
use proptest::prelude::*;

type Buffer = TBuffer<FreeList>;

/// Most fragments of a random frame.
const FRAGMENTS: usize = 400;
/// Most fragments that are added to one.
const ADDED: usize = 30;
/// Sections that hold every fragment of a frame, however they are spread.
const ENOUGH: u32 = (FRAGMENTS + ADDED) as u32;

/// A machine and what surrounds it.
#[derive(Clone, Copy, Debug)]
struct Setup {
    screen: Screen,
    params: Params,
    /// Of eight cycles, how many the display is not ready in; below 8.
    display_busy: u64,
    /// Of eight chances to send, how many the source lets pass; below 8.
    source_idle: u64,
}

/// What a machine gave for some frames.
struct Run {
    images: Vec<Image>,
    tally: Tally,
}

impl Setup {
    /// A machine that is never held up.
    fn free(screen: Screen, params: Params) -> Setup {
        Setup { screen, params, display_busy: 0, source_idle: 0 }
    }

    fn config(&self) -> Config {
        Config::new(self.screen, self.params).unwrap()
    }

    /// Plays the frames on one machine, each next one as soon as the machine takes it.
    fn run(&self, frames: &[Vec<Fragment>]) -> Result<Run, BenchError> {
        let mut bench = Bench::<Buffer>::new(self.config());
        let (busy, idle) = (self.display_busy, self.source_idle);
        bench.set_display(move |cycle| !chosen(cycle, busy));
        let mut chance = 0;
        for frame in frames {
            let items = frame.iter().map(|f| Marked::item(*f));
            for item in items.chain([Marked::end()]) {
                chance += 1;
                while chosen(chance, idle) {
                    bench.step(Stream::idle())?;
                    chance += 1;
                }
                bench.send(item)?;
            }
        }
        let mut images = bench.take_images();
        while images.len() < frames.len() {
            bench.step(Stream::idle())?;
            images.extend(bench.take_images());
        }
        Ok(Run { images, tally: bench.tally() })
    }

    /// The image of one frame, or why there is none.
    fn image(&self, frame: &[Fragment]) -> Result<Image, TestCaseError> {
        Ok(tried(self.run(&[frame.to_vec()]))?.images.remove(0))
    }

    /// What the closed forms say of several frames: sums, but for the sections in use at once.
    fn closed_forms(&self, tally: &Tally, references: &[Reference]) -> Vec<Check> {
        let cfg = self.config();
        let each: Vec<Vec<Check>> =
            references.iter().map(|r| Buffer::closed_forms(&cfg, tally, &census(r))).collect();
        let mut checks = Buffer::closed_forms(&cfg, tally, &census(&stacked(references)));
        for (k, check) in checks.iter_mut().enumerate() {
            if check.what.starts_with("sections in use") {
                check.expected = each.iter().map(|checks| checks[k].expected).max().unwrap_or(0);
            }
        }
        checks
    }
}

/// A run's error as a failed case, so that it shrinks.
fn tried<T>(result: Result<T, BenchError>) -> Result<T, TestCaseError> {
    result.map_err(|error| TestCaseError::fail(error.to_string()))
}

fn golden(screen: Screen, frame: &[Fragment]) -> Reference {
    let mut golden = Golden::new(screen);
    for fragment in frame {
        golden.push(*fragment).unwrap();
    }
    golden.finish()
}

fn census(reference: &Reference) -> Census {
    Census { stored: reference.stored, histogram: reference.stored_histogram.clone() }
}

/// Images one below the other.
fn stack<'a>(images: impl IntoIterator<Item = &'a Image>) -> Image {
    let mut all = Image { width: 0, height: 0, pixels: vec![] };
    for image in images {
        all.width = image.width;
        all.height += image.height;
        all.pixels.extend(&image.pixels);
    }
    all
}

fn add(sum: &mut Vec<u64>, histogram: &[u64]) {
    sum.resize(sum.len().max(histogram.len()), 0);
    for (sum, count) in sum.iter_mut().zip(histogram) {
        *sum += count;
    }
}

/// Several frames as if they were one, with their images one below the other.
fn stacked(references: &[Reference]) -> Reference {
    let mut sum = references[0].clone();
    for r in &references[1..] {
        sum.fragments += r.fragments;
        sum.opaque += r.opaque;
        sum.transparent += r.transparent;
        sum.culled += r.culled;
        sum.blended += r.blended;
        sum.transparent_pixels += r.transparent_pixels;
        sum.max_layers = sum.max_layers.max(r.max_layers);
        sum.stored += r.stored;
        sum.stored_pixels += r.stored_pixels;
        sum.layers.extend(&r.layers);
        add(&mut sum.layer_histogram, &r.layer_histogram);
        add(&mut sum.stored_histogram, &r.stored_histogram);
    }
    sum.image = stack(references.iter().map(|r| &r.image));
    sum
}

/// Small screens, and one with several words of occupancy of which the last is not full.
fn screens() -> impl Strategy<Value = Screen> {
    let size = prop_oneof![8 => (1..=12u32, 1..=9u32), 1 => Just((67, 5))];
    (size, 0..=0xff_ffffu32).prop_map(|((width, height), background)| Screen {
        width,
        height,
        background,
    })
}

fn fragments(screen: Screen) -> impl Strategy<Value = Vec<Fragment>> {
    let depths = prop_oneof![Just(3), Just(40), Just(Z_FAR + 1)];
    depths.prop_flat_map(move |depths| {
        let z = (0..depths).prop_map(move |k| k * (Z_FAR / (depths - 1)));
        let alpha = prop_oneof![
            2 => Just(0), 2 => Just(254), 2 => Just(255), 3 => 1..=253u32
        ];
        let fragment = (0..screen.width, 0..screen.height, z, 0..1u32 << 24, alpha);
        let fragment =
            fragment.prop_map(|(x, y, z, rgb, a)| Fragment { x, y, z, rgba: rgb << 8 | a });
        prop::collection::vec(fragment, 0..=FRAGMENTS)
    })
}

/// Parameters with which no fragment of a random frame is dropped.
fn params() -> impl Strategy<Value = Params> {
    let flags = (any::<bool>(), any::<bool>());
    let depths = (1..=5u32, prop_oneof![1..=9u32, Just(64)]);
    let sections = prop_oneof![
        3 => (1..=30u32).prop_map(|s| (s, ENOUGH)),
        1 => Just((ENOUGH, 0)),
    ];
    (flags, depths, sections, (1..=20u32, 2..=9u32)).prop_map(
        |((tail, bitmap), (section_capacity, sorter_depth), sections, outside)| Params {
            append: if tail { Append::Tail } else { Append::Walk },
            scan: if bitmap { Scan::Bitmap } else { Scan::Linear },
            section_capacity,
            sorter_depth,
            sections: sections.0,
            outside_sections: sections.1,
            outside_latency: outside.0,
            reads_in_flight: outside.1,
            ..Params::default()
        },
    )
}

fn setups() -> impl Strategy<Value = Setup> {
    (screens(), params(), 0..=7u64, 0..=4u64).prop_map(
        |(screen, params, display_busy, source_idle)| Setup {
            screen,
            params,
            display_busy,
            source_idle,
        },
    )
}

/// A machine with one frame.
fn one_frame() -> impl Strategy<Value = (Setup, Vec<Fragment>)> {
    setups().prop_flat_map(|setup| (Just(setup), fragments(setup.screen)))
}

/// A machine with one to three frames.
fn some_frames() -> impl Strategy<Value = (Setup, Vec<Vec<Fragment>>)> {
    setups()
        .prop_flat_map(|setup| (Just(setup), prop::collection::vec(fragments(setup.screen), 1..=3)))
}

/// The nearest opaque depth at the pixel of `fragment`.
fn opaque_depth(frame: &[Fragment], fragment: &Fragment) -> u32 {
    let same = frame.iter().filter(|f| (f.x, f.y) == (fragment.x, fragment.y));
    same.filter(|f| f.is_opaque()).map(|f| f.z).min().unwrap_or(Z_FAR)
}

/// Which fragments of a frame find no place in `sections` sections of `capacity` fragments.
fn without_place(screen: Screen, frame: &[Fragment], sections: u32, capacity: u32) -> Vec<bool> {
    let pixels = screen.pixels() as usize;
    let (mut nearest, mut stored) = (vec![Z_FAR; pixels], vec![0; pixels]);
    let mut free = sections;
    let mut dropped = vec![];
    for f in frame {
        let pixel = (f.y * screen.width + f.x) as usize;
        let visible = f.z < nearest[pixel];
        let mut place = true;
        if visible && f.is_opaque() {
            nearest[pixel] = f.z;
        } else if visible {
            let full = stored[pixel] % capacity == 0;
            place = !full || free > 0;
            free -= u32::from(full && place);
            stored[pixel] += u32::from(place);
        }
        dropped.push(!place);
    }
    dropped
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn random_frames_are_exact((setup, frames) in some_frames()) {
        let references: Vec<Reference> = frames.iter().map(|f| golden(setup.screen, f)).collect();
        let run = tried(setup.run(&frames))?;
        let forms = setup.closed_forms(&run.tally, &references);
        let verdict = Verdict::new(&stacked(&references), &stack(&run.images), &run.tally, forms);
        prop_assert!(verdict.is_exact(), "{:?}", verdict.faults());
    }

    /// In the middle of storing, resolving or showing: nothing of that frame is left.
    #[test]
    fn a_reset_at_any_time_leaves_a_clean_machine((setup, frame) in one_frame(), cut in 0u64..1500) {
        let mut bench = Bench::<Buffer>::new(setup.config());
        let mut items = frame.iter().map(|f| Marked::item(*f)).chain([Marked::end()]).peekable();
        for _ in 0..cut {
            let offer = items.peek().map_or(Stream::idle(), |item| Stream::offer(*item));
            if tried(bench.step(offer))? && offer.valid {
                items.next();
            }
        }
        bench.reset().unwrap();
        bench.take_images();
        for fragment in &frame {
            tried(bench.send(Marked::item(*fragment)))?;
        }
        tried(bench.end_frame())?;
        prop_assert_eq!(&bench.take_images()[..], &[golden(setup.screen, &frame).image]);
    }

    #[test]
    fn the_order_between_pixels_does_not_matter((setup, frame) in one_frame(), seed: u64) {
        let mut permuted = frame.clone();
        // A stable sort keeps the order within each pixel.
        permuted.sort_by_key(|f| {
            (u64::from(f.y) << 32 | u64::from(f.x)).wrapping_add(seed).wrapping_mul(seed | 1)
        });
        prop_assert_eq!(setup.image(&frame)?, setup.image(&permuted)?);
    }

    #[test]
    fn a_frame_twice_is_the_same_twice((setup, frame) in one_frame()) {
        let once = tried(setup.run(std::slice::from_ref(&frame)))?;
        let twice = tried(setup.run(&[frame.clone(), frame]))?;
        prop_assert_eq!(&twice.images[0], &once.images[0]);
        prop_assert_eq!(&twice.images[1], &once.images[0]);
        prop_assert_eq!(twice.tally.seed_accesses, 2 * once.tally.seed_accesses);
    }

    #[test]
    fn what_lies_behind_opaque_depth_changes_nothing(
        (setup, frame) in one_frame(),
        hidden in prop::collection::vec((any::<prop::sample::Index>(), 0..=Z_FAR, any::<u32>()), 0..=ADDED),
    ) {
        let mut with_hidden = frame.clone();
        for (place, behind, rgba) in hidden {
            let at = place.index(with_hidden.len() + 1);
            let Some(model) = with_hidden.get(at).copied() else { continue };
            let z = opaque_depth(&frame, &model).saturating_add(behind).min(Z_FAR);
            // An opaque fragment as deep as the nearest one is hidden only if it comes later.
            let z = if rgba & 0xff == 0xff { (z + 1).min(Z_FAR) } else { z };
            with_hidden.insert(at, Fragment { z, rgba, ..model });
        }
        prop_assert_eq!(setup.image(&frame)?, setup.image(&with_hidden)?);
    }

    #[test]
    fn a_full_machine_drops_what_finds_no_section(
        (mut setup, frame) in one_frame(), sections in 1..20u32, outside in 0..20u32,
    ) {
        setup.params.sections = sections;
        setup.params.outside_sections = outside;
        let capacity = setup.params.section_capacity;
        let dropped = without_place(setup.screen, &frame, sections + outside, capacity);
        let kept = frame.iter().zip(&dropped).filter(|(_, dropped)| !**dropped);
        let kept: Vec<Fragment> = kept.map(|(fragment, _)| *fragment).collect();
        let count = (frame.len() - kept.len()) as u64;
        let run = tried(setup.run(std::slice::from_ref(&frame)))?;
        let (kept, all) = (golden(setup.screen, &kept), golden(setup.screen, &frame));
        prop_assert_eq!(run.tally.fragments.dropped, count);
        prop_assert_eq!(run.tally.fragments.stored, kept.stored);
        prop_assert_eq!(&run.images[0], &kept.image);
        let forms = setup.closed_forms(&run.tally, std::slice::from_ref(&all));
        let verdict = Verdict::new(&all, &run.images[0], &run.tally, forms);
        prop_assert_eq!(verdict.is_exact(), count == 0);
        prop_assert!(verdict.is_exact_but_for_drops(), "{:?}", verdict.faults());
    }
}

#[test]
fn a_display_that_takes_nothing_is_named() {
    let screen = Screen { width: 4, height: 4, background: 0 };
    let mut bench = Bench::<Buffer>::new(Config::new(screen, Params::default()).unwrap());
    bench.set_display(|_| false);
    bench.send(Marked::item(Fragment { x: 1, y: 2, z: 3, rgba: 0x80 })).unwrap();
    let error = bench.end_frame().unwrap_err();
    assert!(matches!(error, BenchError::Deadlock(_)), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("the simulation stands still, cycle "), "{text}");
    assert!(
        text.ends_with("\n  scanout (state Run) waits for display to take from `image`"),
        "{text}"
    );
}

/// A rate of which the targets speak: `part` per `whole`.
fn assert_rate(what: &str, part: u64, whole: u64, least: f64) {
    let rate = part as f64 / whole as f64;
    assert!(rate >= least, "{what}: {rate:.4} fragments per cycle, expected at least {least}");
}

/// The frame through the machine of a preset; the run must be exact.
fn preset(scene: &str, options: &Options, preset: &str) -> Outcome {
    let source = Source::open(scene, options).unwrap();
    let mut golden = Golden::new(source.screen());
    source.play::<PlayError>(&mut |fragment| Ok(golden.push(fragment)?)).unwrap();
    let reference = golden.finish();
    let arch = Architecture::named("tbuffer").unwrap();
    let machine = arch.build(source.screen(), Some(preset), &[]).unwrap();
    let mut progress = Progress::new("", None, true);
    let outcome =
        machine.run(Job { source: &source, wave: None, progress: &mut progress }).unwrap();
    let forms = machine.closed_forms(&outcome.tally, &census(&reference));
    let verdict = Verdict::new(&reference, &outcome.image, &outcome.tally, forms);
    assert!(verdict.is_exact(), "{scene}, {preset}: {:?}", verdict.faults());
    outcome
}

#[derive(Debug, thiserror::Error)]
enum PlayError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
}

#[test]
fn long_runs_of_one_pixel_are_stored_one_a_cycle() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let frame: Vec<Fragment> = (0..screen.pixels())
        .flat_map(|pixel| {
            let (x, y) = (pixel % screen.width, pixel / screen.width);
            (0..32).map(move |k| Fragment { x, y, z: k * 7919 % 32, rgba: k << 8 | 0x7f })
        })
        .collect();
    let run = Setup::free(screen, Params::default()).run(std::slice::from_ref(&frame)).unwrap();
    assert_eq!(run.images[0], golden(screen, &frame).image);
    assert_rate("stored", run.tally.fragments.stored, run.tally.cycles.store, 0.98);
}

#[test]
fn the_papers_frames_are_resolved_at_the_target_rate() {
    for scene in built_in().iter().filter(|scene| scene.name.starts_with("paper-")) {
        let Tally { fragments, cycles, .. } = preset(scene.name, &Options::default(), "fast").tally;
        assert_rate(&format!("{}, stored", scene.name), fragments.stored, cycles.store, 0.98);
        assert_rate(&format!("{}, resolved", scene.name), fragments.stored, cycles.resolve, 0.9);
    }
}

/// A small view of a scene through every preset.
fn all_presets(scene: &str) {
    let options = Options { width: Some(160), height: Some(120), ..Options::default() };
    for (name, _) in (Architecture::named("tbuffer").unwrap().presets)() {
        preset(scene, &options, name);
    }
}

#[test]
fn presets_are_exact_on_glass() {
    all_presets("glass");
}

#[test]
fn presets_are_exact_on_the_teapot() {
    all_presets("teapot");
}

#[test]
fn presets_are_exact_on_a_scanned_mesh() {
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/meshes/dragon_vrip_res4.ply.gz");
    if Path::new(mesh).exists() {
        all_presets(mesh);
    } else {
        println!("skipped: there is no file {mesh}");
    }
}
