//! How fast accumulation is simulated: `cargo bench --bench accumulate`.
//!
//! The item is a simulated clock cycle. `machine` makes one image of eight frames, from reset to the last pixel shown; `sweeps` sends
//! eight frames of 640x480 pixels through the accumulator alone, whose planes are on the chip.

use divan::{Bencher, counter::ItemsCount};
use pellucid_accumulate::accumulator::{self, Accumulator};
use pellucid_accumulate::config::{Config, Params};
use pellucid_hw::architecture;
use pellucid_machine::architecture::settings;
use pellucid_machine::params::Parameters;
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Item, Model, outside};
use pellucid_sim::{Sim, Stream};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::scene::{Options, Scene};

fn main() {
    divan::main();
}

const FRAMES: u32 = 8;

/// The parameters of a way, as in `schedule=nodes planes=outside`.
fn parameters(way: &str) -> Vec<(&str, String)> {
    let set = way.split(' ').filter_map(|word| word.split_once('='));
    let set = set.map(|(name, value)| (name, value.to_string()));
    [("frames", FRAMES.to_string())].into_iter().chain(set).collect()
}

fn cycles(model: &dyn Model, frame: &[Item]) -> u64 {
    let mut bench = Bench::new(model);
    for _ in 0..FRAMES {
        bench.frame(|bench| frame.iter().try_for_each(|item| bench.send(item))).unwrap();
    }
    bench.wait_for(1, |_, _| Ok(())).unwrap();
    bench.cycles()
}

#[divan::bench(args = ["schedule=stream", "schedule=nodes", "method=buffer", "schedule=stream planes=outside", "schedule=nodes planes=outside"], sample_count = 5)]
fn machine(bencher: Bencher, way: &str) {
    let options = Options { width: Some(160), height: Some(120), ..Options::default() };
    let scene = Scene::open("glass", &options).unwrap();
    let set = settings(&parameters(way));
    let model = architecture("accumulate").unwrap().build(scene.info(), None, &set).unwrap();
    let mut frame: Vec<Item> = vec![];
    scene
        .play::<BenchError>(&mut |fragment| {
            frame.push(fragment.into());
            Ok(())
        })
        .unwrap();
    let count = cycles(&*model, &frame);
    bencher.counter(ItemsCount::new(count)).bench_local(|| cycles(&*model, &frame));
}

const SCREEN: Screen = Screen { width: 640, height: 480, background: 0 };

#[divan::bench(args = ["schedule=stream", "schedule=stream branching=2,4", "schedule=nodes", "method=buffer", "method=blend"], sample_count = 5)]
fn sweeps(bencher: Bencher, way: &str) {
    let mut params = Params::default();
    for (name, value) in parameters(way) {
        params.set(name, &value).unwrap();
    }
    let cfg = Config::new(SCREEN, params).unwrap();
    let image = || {
        let mut sim = Sim::<Accumulator>::new(cfg);
        let mut left = FRAMES * SCREEN.pixels();
        while left > 0 || sim.moore().busy {
            let comes = left > 0 && sim.moore().ready;
            left -= u32::from(comes);
            let frame = if comes { Stream::offer(left & 0xff_ffff) } else { Stream::idle() };
            let i = accumulator::In { frame, image_ready: true, memory: outside::In::default() };
            sim.clock(i).unwrap();
        }
        sim.cycle()
    };
    bencher.counter(ItemsCount::new(image())).bench_local(image);
}
