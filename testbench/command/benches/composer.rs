//! How fast the image composition machine is simulated: `cargo bench --bench composer`.
//!
//! The item is a simulated clock cycle. `machine` plays one frame, from reset to the last pixel shown; `merger` sends
//! one image of 640x480 pixels through the image merger alone, whose engines draw nothing.

use divan::{Bencher, counter::ItemsCount};
use pellucid_composer::merger::{self, Merger};
use pellucid_composer::merging_unit::Opaque;
use pellucid_composer::object_engine::{self, Engine};
use pellucid_composer::raster;
use pellucid_hw::architecture;
use pellucid_machine::Item;
use pellucid_machine::architecture::settings;
use pellucid_machine::pixel::Screen;
use pellucid_sim::{Block, Signals, Sim, Stream, rtl};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::scene::{Options, Scene};

fn main() {
    divan::main();
}

fn cycles(screen: Screen, engines: u32, frame: &[Item]) -> u64 {
    let settings = settings(&[("engines", engines.to_string())]);
    let model = architecture("composer").unwrap().build(screen, None, &settings).unwrap();
    let mut bench = Bench::new(&*model);
    frame.iter().try_for_each(|primitive| bench.send(primitive)).unwrap();
    bench.end_frame().unwrap();
    bench.cycles()
}

#[divan::bench(args = [1, 4, 16, 64], sample_count = 3)]
fn machine(bencher: Bencher, engines: u32) {
    let scene = Scene::open("glass", &Options::default()).unwrap();
    let mut frame = vec![];
    scene
        .play_primitives::<BenchError>(&mut |primitive| {
            frame.push(primitive.into());
            Ok(())
        })
        .unwrap();
    let count = cycles(scene.info(), engines, &frame);
    bencher.counter(ItemsCount::new(count)).bench_local(|| cycles(scene.info(), engines, &frame));
}

/// An engine that draws nothing: its pixels are numbered from the back to the front.
#[derive(Clone, Copy)]
struct Still;

#[derive(Clone, Copy, Signals)]
#[signals(())]
struct Shown {
    #[width(24)]
    z: u32,
}

#[rtl(input = SCREEN, moore = (), output = (), check(Still, ()))]
impl Block for Still {
    type Config = ();
    type State = Shown;
    type In = object_engine::In;
    type Moore = object_engine::Moore;
    type Out = object_engine::Out;
    type Mem = ();

    fn reset(_: &()) -> Shown {
        Shown { z: 0 }
    }

    fn memories(_: &()) {}

    fn moore(_: &(), q: &Shown, _: &()) -> object_engine::Moore {
        object_engine::Moore { ready: true, done: true, local: Opaque { z: q.z, colour: q.z } }
    }

    fn next(
        _: &(),
        q: &Shown,
        d: &mut Shown,
        _: &mut (),
        i: object_engine::In,
    ) -> object_engine::Out {
        if i.wipe.valid {
            d.z = (q.z + 7) & 0xff_ffff;
        }
        object_engine::Out { drawn: false, hidden: false }
    }
}

impl Engine for Still {}

const SCREEN: Screen = Screen { width: 640, height: 480, background: 0 };

#[divan::bench(args = [16, 128, 1024], sample_count = 3)]
fn merger(bencher: Bencher, engines: u32) {
    let raster = raster::Config { screen: SCREEN, beta: 20 };
    let cfg = merger::Config { shape: merger::Shape { engines, raster }, engine: () };
    let clock = |sim: &mut Sim<Merger<Still>>, swap| {
        let i = merger::In {
            primitive: Stream::idle(),
            engine: 0,
            swap,
            clear: Stream::idle(),
            merged_ready: true,
        };
        sim.clock(i).unwrap();
    };
    let merge = || {
        let mut sim = Sim::<Merger<Still>>::new(cfg);
        clock(&mut sim, true);
        while sim.moore().busy {
            clock(&mut sim, false);
        }
        sim.cycle()
    };
    bencher.counter(ItemsCount::new(merge())).bench_local(merge);
}
