//! How fast the simulation is: `cargo bench`.
//!
//! The item of `cycles_*` is a simulated clock cycle of the whole pipeline, from reset to the last
//! pixel shown; that of `play_*` a frame, with everything that a run does but writing files.

use divan::{Bencher, counter::ItemsCount};
use pellucid_hw::allocator::FreeList;
use pellucid_hw::machine::Machine;
use pellucid_hw::mbuffer::{self, MBuffer};
use pellucid_hw::params::Preset;
use pellucid_hw::pixel::{Fragment, Marked, Screen};
use pellucid_hw::rbuffer::{self, RBuffer};
use pellucid_hw::tbuffer::{self, TBuffer};
use pellucid_sim::{Registers, Signals};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::Golden;
use pellucid_testbench::recorder::WaveJob;
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

/// The parameters of a preset.
fn params<P>(presets: &[Preset<P>], name: &str) -> P {
    (presets.iter().find(|p| p.name == name).unwrap().params)()
}

fn tbuffer(screen: Screen, preset: &str) -> Bench<TBuffer<FreeList>> {
    let params = params(tbuffer::config::PRESETS, preset);
    Bench::new(tbuffer::config::Config::new(screen, params).unwrap())
}

fn rbuffer(screen: Screen, preset: &str) -> Bench<RBuffer> {
    let params = params(rbuffer::config::PRESETS, preset);
    Bench::new(rbuffer::config::Config::new(screen, params).unwrap())
}

fn mbuffer(screen: Screen, preset: &str) -> Bench<MBuffer<FreeList>> {
    let params = params(mbuffer::config::PRESETS, preset);
    Bench::new(mbuffer::config::Config::new(screen, params).unwrap())
}

/// One frame through a new machine; the cycles that it took.
fn cycles<M: Machine<Item = Fragment>>(
    mut bench: Bench<M>,
    frame: &[Fragment],
    wave: Option<&WaveJob>,
) -> u64
where
    M::State: Registers<Config = M::Config>,
    M::Out: Signals<Config = M::Config>,
{
    if let Some(wave) = wave {
        bench.record(wave, "machine").unwrap();
    }
    for fragment in frame {
        bench.send(Marked::item(*fragment)).unwrap();
    }
    bench.end_frame().unwrap();
    bench.finish_wave().unwrap();
    bench.cycles()
}

fn bench_cycles<M: Machine<Item = Fragment>>(
    bencher: Bencher,
    scene: &str,
    machine: impl Fn(Screen) -> Bench<M>,
    wave: Option<&WaveJob>,
) where
    M::State: Registers<Config = M::Config>,
    M::Out: Signals<Config = M::Config>,
{
    let scene = open(scene, None, None);
    let mut frame = vec![];
    scene
        .play::<BenchError>(&mut |fragment| {
            frame.push(fragment);
            Ok(())
        })
        .unwrap();
    let count = cycles(machine(scene.info()), &frame, None);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| cycles(machine(scene.info()), &frame, wave));
}

#[divan::bench(args = ["paper-480", "glass", "teapot"], sample_count = 10)]
fn cycles_untraced(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, |screen| tbuffer(screen, "fast"), None);
}

#[divan::bench(args = ["paper-480"], sample_count = 5)]
fn cycles_untraced_paper(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, |screen| tbuffer(screen, "paper"), None);
}

#[divan::bench(args = ["paper-480", "glass", "teapot"], sample_count = 10)]
fn cycles_untraced_rbuffer(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, |screen| rbuffer(screen, "on-chip"), None);
}

#[divan::bench(args = ["paper-480", "glass", "teapot"], sample_count = 10)]
fn cycles_untraced_mbuffer(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, |screen| mbuffer(screen, "registers"), None);
}

#[divan::bench(args = ["paper-480"], sample_count = 5)]
fn cycles_untraced_mbuffer_memory(bencher: Bencher, scene: &str) {
    bench_cycles(bencher, scene, |screen| mbuffer(screen, "memory"), None);
}

/// With a waveform of these cycles.
fn bench_traced(bencher: Bencher, scene: &str, window: Window) {
    let folder = tempfile::tempdir().unwrap();
    let wave = WaveJob::new(&folder.path().join("wave.vcd"), &[window]);
    bench_cycles(bencher, scene, |screen| tbuffer(screen, "fast"), Some(&wave));
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
    let mut golden = Golden::new(scene.info());
    scene
        .play::<BenchError>(&mut |fragment| {
            golden.push(fragment).unwrap();
            Ok(())
        })
        .unwrap();
    let reference = golden.finish();
    let mut bench = tbuffer(scene.info(), "fast");
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
