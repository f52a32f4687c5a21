//! How fast the simulation is: `cargo bench`.
//!
//! The item of `cycles_*` is a simulated clock cycle of the whole pipeline, from reset to the last
//! pixel shown; that of `play_*` a frame, with everything that a run does but writing files.

use divan::{Bencher, counter::ItemsCount};
use pellucid_hw::allocator::FreeList;
use pellucid_hw::pixel::{Fragment, Marked, Screen};
use pellucid_hw::tbuffer::TBuffer;
use pellucid_hw::tbuffer::config::{Config, PRESETS};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::Golden;
use pellucid_testbench::scene::{Options, Scene};
use pellucid_testbench::window::Window;
use std::path::Path;

const DRAGON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/meshes/dragon_vrip.ply.gz");

fn main() {
    divan::main();
}

fn open(name: &str, width: Option<u32>, height: Option<u32>) -> Scene {
    Scene::open(name, &Options { width, height, ..Options::default() }).unwrap()
}

fn machine(screen: Screen, preset: &str) -> Bench<TBuffer<FreeList>> {
    let preset = PRESETS.iter().find(|p| p.name == preset).unwrap();
    Bench::new(Config::new(screen, (preset.params)()).unwrap())
}

/// One frame through a new machine; the cycles that it took.
fn cycles(screen: Screen, frame: &[Fragment], preset: &str, wave: Option<&Path>) -> u64 {
    let mut bench = machine(screen, preset);
    if let Some(path) = wave {
        bench.record(path, "machine", &[Window::Cycles { from: 0, to: u64::MAX }]).unwrap();
    }
    for fragment in frame {
        bench.send(Marked::item(*fragment)).unwrap();
    }
    bench.end_frame().unwrap();
    bench.finish_wave().unwrap();
    bench.cycles()
}

fn bench_cycles(bencher: Bencher, scene: &str, preset: &str, wave: Option<&Path>) {
    let scene = open(scene, None, None);
    let mut frame = vec![];
    scene
        .play::<BenchError>(&mut |fragment| {
            frame.push(fragment);
            Ok(())
        })
        .unwrap();
    let count = cycles(scene.info(), &frame, preset, None);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| cycles(scene.info(), &frame, preset, wave));
}

#[divan::bench(args = ["paper-480", "glass", "teapot"], sample_count = 10)]
fn cycles_untraced(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, "fast", None);
}

#[divan::bench(args = ["paper-480"], sample_count = 5)]
fn cycles_untraced_paper(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, "paper", None);
}

#[divan::bench(args = ["paper-480"], sample_count = 3)]
fn cycles_traced(bencher: Bencher, scene: &str) {
    let folder = tempfile::tempdir().unwrap();
    bench_cycles(bencher, scene, "fast", Some(&folder.path().join("wave.vcd")));
}

fn play(scene: &Scene) -> u64 {
    let mut golden = Golden::new(scene.info());
    scene
        .play::<BenchError>(&mut |fragment| {
            golden.push(fragment).unwrap();
            Ok(())
        })
        .unwrap();
    let reference = golden.finish();
    let mut bench = machine(scene.info(), "fast");
    scene.play::<BenchError>(&mut |fragment| bench.send(Marked::item(fragment))).unwrap();
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
