use super::*;
use crate::merging_unit::STAGES;
use crate::object_engine::ObjectEngine;
use crate::test_util::{Pattern, merger, pattern, point, screen};
use pellucid_machine::pixel::Fragment;
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;

/// The image of each engine.
type Images = Vec<Vec<Opaque>>;

/// What a merge came to.
#[derive(Debug, Default, PartialEq)]
struct Merged {
    pixels: Vec<Opaque>,
    /// Cycles in which it was busy.
    cycles: u64,
    /// When each line was complete: the first cycle in which that can be known.
    lines: Vec<u64>,
}

/// A line of engines with their units, all frame buffers wiped.
struct Bench {
    sim: Sim<Merger<ObjectEngine>>,
    cycle: u64,
}

fn nothing() -> In {
    In {
        primitive: Stream::idle(),
        engine: 0,
        swap: false,
        clear: Stream::idle(),
        merged_ready: false,
    }
}

impl Bench {
    fn new(cfg: Config<object_engine::Config>) -> Bench {
        let mut sim = Sim::<Merger<ObjectEngine>>::new(cfg);
        for pixel in 0..cfg.shape.screen().pixels() {
            sim.clock(In { clear: Stream::offer(pixel), ..nothing() }).unwrap();
        }
        Bench { sim, cycle: 0 }
    }

    /// Draws the image of each engine, point by point.
    fn draw(&mut self, images: &Images) {
        let width = self.sim.config().shape.screen().width;
        let points = images.iter().zip(0u32..).flat_map(|(image, engine)| {
            let drawn = image.iter().zip(0u32..).filter(|(pixel, _)| pixel.z < Z_FAR);
            let point = move |(pixel, p): (&Opaque, u32)| {
                let fragment = Fragment {
                    x: p % width,
                    y: p / width,
                    z: pixel.z,
                    rgba: pixel.colour << 8 | 0xff,
                    ..Fragment::default()
                };
                (Marked::item(point(fragment)), engine)
            };
            drawn.map(point)
        });
        for (primitive, engine) in
            points.collect::<Vec<_>>().into_iter().chain([(Marked::end(), 0)])
        {
            let offer = In { primitive: Stream::offer(primitive), engine, ..nothing() };
            while !self.sim.clock(offer).unwrap().out.taken {}
        }
        while !self.sim.moore().done {
            self.sim.clock(nothing()).unwrap();
        }
    }

    /// Merges what was drawn.
    fn merge(&mut self, ready: &Pattern) -> Merged {
        let mut monitor = StreamMonitor::new("merged", "Merger", "test");
        let mut merged = Merged::default();
        self.sim.clock(In { swap: true, ..nothing() }).unwrap();
        let began = self.cycle + 1;
        loop {
            self.cycle += 1;
            assert!(self.cycle < began + 100_000, "the image does not end");
            if !self.sim.moore().busy {
                return merged;
            }
            merged.cycles += 1;
            let i = In { merged_ready: ready.at(self.cycle), ..nothing() };
            let out = self.sim.clock(i).unwrap().out;
            monitor.observe(out.merged).unwrap();
            if out.merged.fires() {
                merged.pixels.push(out.merged.payload);
            }
            if out.line_done {
                merged.lines.push(self.cycle + 1 - began);
            }
        }
    }
}

fn config(engines: u32, width: u32, height: u32, beta: u32) -> Config<object_engine::Config> {
    let screen = screen(width, height);
    let mut cfg = merger(engines, beta);
    cfg.shape.raster.screen = screen;
    cfg.engine.walker.screen = screen;
    cfg
}

/// What must come: the nearest pixel of each place, the first engine's of equal ones.
fn nearest(images: &Images, background: u32) -> Vec<Opaque> {
    let far = Opaque { z: Z_FAR, colour: background };
    let nearest = |p: usize| {
        let candidates = std::iter::once(far).chain(images.iter().map(|image| image[p]));
        candidates.reduce(|a, b| if b.z < a.z { b } else { a }).unwrap()
    };
    (0..images[0].len()).map(nearest).collect()
}

/// Few depths, so that equal ones are frequent; colours tell engines and places apart.
fn images(engines: u32, pixels: u32, seed: u32) -> Images {
    let z = |k: u32, p: u32| match (k * 7919 + p * 104_729 + seed).wrapping_mul(0x9e37_79b9) >> 29 {
        0 => Z_FAR,
        z => z,
    };
    let pixel = |k, p| Opaque { z: z(k, p), colour: k << 12 | p };
    (0..engines).map(|k| (0..pixels).map(|p| pixel(k, p)).collect()).collect()
}

#[test]
fn by_hand() {
    let far = Opaque { z: Z_FAR, colour: 1 };
    let at = |z, colour| Opaque { z, colour };
    let images = vec![vec![at(5, 2), far, at(9, 3)], vec![at(5, 4), far, at(8, 5)]];
    let mut bench = Bench::new(config(2, 3, 1, 0));
    bench.draw(&images);
    let merged = bench.merge(&Pattern::always());
    let background = at(Z_FAR, screen(3, 1).background);
    assert_eq!(merged.pixels, [at(5, 2), background, at(8, 5)]);
}

#[test]
fn a_line_of_1024_engines() {
    let images = images(1024, 12, 3);
    let cfg = config(1024, 4, 3, 5);
    let mut bench = Bench::new(cfg);
    bench.draw(&images);
    let merged = bench.merge(&Pattern::always());
    assert_eq!(merged.pixels, nearest(&images, cfg.shape.screen().background));
    assert_eq!(merged.cycles, (4 + 5) * 3 + 4 * 1024);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// The nearest pixels come in `(v + beta) * w + 4 * n` cycles, and line y is complete after
    /// `4 * n + (y + 1) * (v + beta)`; one image after the other.
    #[test]
    fn the_closed_form_holds(
        engines in 1u32..=8,
        width in 1u32..9,
        height in 1u32..6,
        beta in 0u32..5,
        seed: u32,
    ) {
        let cfg = config(engines, width, height, beta);
        let mut bench = Bench::new(cfg);
        for frame in 0..2 {
            let images = images(engines, width * height, seed.wrapping_add(frame) >> 8);
            bench.draw(&images);
            let merged = bench.merge(&Pattern::always());
            let (n, v, w) = (u64::from(engines), u64::from(width), u64::from(height));
            let line = v + u64::from(beta);
            prop_assert_eq!(merged.pixels, nearest(&images, cfg.shape.screen().background));
            prop_assert_eq!(merged.cycles, line * w + u64::from(STAGES) * n);
            let lines: Vec<u64> = (1..=w).map(|y| u64::from(STAGES) * n + y * line).collect();
            prop_assert_eq!(merged.lines, lines);
        }
    }

    /// A receiver that stalls loses nothing.
    #[test]
    fn stalls_lose_nothing(
        engines in 1u32..=8,
        width in 1u32..9,
        height in 1u32..6,
        beta in 0u32..3,
        seed: u32,
        ready in pattern(),
    ) {
        let cfg = config(engines, width, height, beta);
        let images = images(engines, width * height, seed >> 8);
        let mut bench = Bench::new(cfg);
        bench.draw(&images);
        let merged = bench.merge(&ready);
        prop_assert_eq!(merged.pixels, nearest(&images, cfg.shape.screen().background));
    }
}

#[test]
#[should_panic(expected = "the number of engines of a merger is 0: expected at least 1")]
fn there_is_an_engine() {
    Merger::<ObjectEngine>::reset(&merger(0, 1));
}
