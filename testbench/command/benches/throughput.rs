//! How fast the simulation is: `cargo bench`.
//!
//! The item of `cycles_*` is a simulated clock cycle of the whole machine, from reset to the last
//! pixel shown; that of `play_*` a frame, with everything that a run does but writing files. The image composition machine and accumulation
//! have benches of their own.

use divan::{Bencher, counter::ItemsCount};
use pellucid_hw::{ARCHITECTURES, architecture};
use pellucid_machine::architecture::{Setting, settings};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Item, Kind, Model};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::Golden;
use pellucid_testbench::outside::board;
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::scene::{Options, Scene};
use pellucid_testbench::trial::CaseError;
use pellucid_testbench::window::Window;
use std::fmt;
use std::path::Path;

const DRAGON: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/meshes/dragon_vrip.ply.gz");

fn main() {
    divan::main();
}

fn open(name: &str, width: Option<u32>, height: Option<u32>) -> Scene {
    Scene::open(name, &Options { width, height, ..Options::default() }).unwrap()
}

fn build((arch, preset): (&str, &str), screen: Screen) -> Box<dyn Model> {
    architecture(arch).unwrap().build(screen, Some(preset), &[]).unwrap()
}

/// A machine and the scene that it plays.
#[derive(Clone, Copy)]
struct Run {
    /// Architecture and preset.
    machine: (&'static str, &'static str),
    scene: &'static str,
}

/// `dfb fast paper-480`
impl fmt::Display for Run {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Run { machine: (arch, preset), scene } = self;
        write!(f, "{arch} {preset} {scene}")
    }
}

/// Every architecture that takes fragments, with those of its presets whose places are `chosen`, on each of the scenes.
fn on(scenes: &[&'static str], chosen: fn(usize) -> bool) -> Vec<Run> {
    let screen = Screen { width: 640, height: 480, background: 0 };
    let mut runs = vec![];
    for arch in ARCHITECTURES {
        for (place, (preset, _)) in (arch.presets)().into_iter().enumerate() {
            let machine = (arch.name, preset);
            if chosen(place) && build(machine, screen).kind() == Kind::Fragments {
                runs.extend(scenes.iter().map(|scene| Run { machine, scene }));
            }
        }
    }
    runs
}

/// One frame through a new machine, as often as it asks for it; the cycles that it took.
fn cycles(model: &dyn Model, frame: &[Item], wave: Option<&WaveJob>) -> u64 {
    let mut bench = Bench::new(model);
    if let Some(wave) = wave {
        bench.record(wave, "machine").unwrap();
    }
    bench.frame(|bench| frame.iter().try_for_each(|item| bench.send(item))).unwrap();
    bench.wait_for(1, |_, _| Ok(())).unwrap();
    assert_eq!(bench.finish_wave().lost, None);
    bench.cycles()
}

fn bench_cycles(bencher: Bencher, scene: &str, machine: (&str, &str), wave: Option<&WaveJob>) {
    let scene = open(scene, None, None);
    let model = build(machine, scene.info());
    bench_model(bencher, &scene, &*model, wave);
}

fn bench_model(bencher: Bencher, scene: &Scene, model: &dyn Model, wave: Option<&WaveJob>) {
    let mut frame: Vec<Item> = vec![];
    let mut keep = |item| {
        frame.push(item);
        Ok(())
    };
    let played: Result<(), BenchError> = match model.kind() {
        Kind::Fragments => scene.play(&mut |fragment| keep(fragment.into())),
        Kind::Primitives => scene.play_primitives(&mut |primitive| keep(primitive.into())),
    };
    played.unwrap();
    let count = cycles(model, &frame, None);
    bencher.counter(ItemsCount::new(count)).bench_local(|| cycles(model, &frame, wave));
}

/// The default of every architecture, on each of these scenes.
#[divan::bench(args = on(&["paper-480", "glass", "teapot"], |preset| preset == 0), sample_count = 10)]
fn cycles_untraced(bencher: Bencher, Run { machine, scene }: Run) {
    bench_cycles(bencher, scene, machine, None);
}

/// The other presets.
#[divan::bench(args = on(&["paper-480"], |preset| preset > 0), sample_count = 5)]
fn cycles_untraced_presets(bencher: Bencher, Run { machine, scene }: Run) {
    bench_cycles(bencher, scene, machine, None);
}

/// All sections in a DRAM.
#[divan::bench(args = ["ddr4-3200", "hbm3-6400"], sample_count = 10)]
fn cycles_untraced_dram(bencher: Bencher, part: &str) {
    let scene = open("glass", None, None);
    let setting = |(name, value): (&str, &str)| Setting {
        name: name.to_string(),
        value: value.to_string(),
        origin: String::new(),
    };
    let model = architecture("tbuffer").unwrap();
    let model = model.build(scene.info(), None, &[setting(("sections", "1"))]).unwrap();
    let model = board::behind(model, &[setting(("outside", part))]).unwrap();
    bench_model(bencher, &scene, &*model, None);
}

/// The F-buffer, whose frames come again for each pass of each window, in each of its ways.
#[divan::bench(args = ["x800", "r9800", "x800 program=sieve kill=keep", "x800 program=sieve kill=compact", "x800 program=tint mode=sort"], sample_count = 5)]
fn cycles_untraced_fbuffer(bencher: Bencher, way: &str) {
    let scene = open("sphere-12288", Some(128), Some(128));
    let mut words = way.split(' ');
    let preset = words.next();
    let set = words.filter_map(|word| word.split_once('='));
    let set: Vec<(&str, String)> = set.map(|(name, value)| (name, value.to_string())).collect();
    let set = [&[("size", "64".to_string())], &set[..]].concat();
    let model = architecture("fbuffer").unwrap().build(scene.info(), preset, &settings(&set));
    bench_model(bencher, &scene, &*model.unwrap(), None);
}

/// With a waveform of these cycles.
fn bench_traced(bencher: Bencher, scene: &str, window: Window) {
    let folder = tempfile::tempdir().unwrap();
    let wave = WaveJob::new(&folder.path().join("wave.vcd"), &[window]);
    bench_cycles(bencher, scene, ("tbuffer", "fast"), Some(&wave));
}

#[divan::bench(args = ["paper-480"], sample_count = 3)]
fn cycles_traced(bencher: Bencher, scene: &str) {
    bench_traced(bencher, scene, Window::Cycles { from: 0, to: u64::MAX });
}

/// Nearly all of it is outside of the window: as fast as `cycles_untraced`.
#[divan::bench(args = ["paper-480"], sample_count = 10)]
fn cycles_outside_a_window(bencher: Bencher, scene: &str) {
    bench_traced(bencher, scene, Window::Cycles { from: 0, to: 10 });
}

fn play(scene: &Scene) -> u64 {
    let golden = Golden::new(scene.info());
    let (reference, ()) = golden.judge::<_, CaseError>(|sink| scene.play(sink)).unwrap();
    let mut bench = Bench::new(&*build(("tbuffer", "fast"), scene.info()));
    scene.play::<BenchError>(&mut |fragment| bench.send(&fragment.into())).unwrap();
    bench.end_frame().unwrap();
    assert_eq!(bench.take_images(), [reference.image]);
    bench.cycles()
}

#[divan::bench(sample_count = 10)]
fn play_paper_480() -> u64 {
    play(&open("paper-480", None, None))
}

#[divan::bench(sample_count = 3)]
fn play_dragon(bencher: Bencher) {
    if !Path::new(DRAGON).exists() {
        println!("skipped: {DRAGON} is missing");
        return;
    }
    bencher.bench(|| play(&open(DRAGON, Some(1280), Some(720))));
}
