use super::*;
use crate::test_util::{behind::Behind, config, outside, small};
use pellucid_machine::accumulation::Accumulation;
use pellucid_sim::Sim;
use pellucid_test_util::{Pattern, pattern};
use proptest::prelude::*;

/// Pixels of a frame.
const PIXELS: usize = 6;

/// The images that come of the frames, and the cycles that they took. Frames come and pixels are taken in such cycles.
fn images(cfg: Config, frames: &[Vec<u32>], comes: &Pattern, ready: &Pattern) -> (Vec<u32>, u64) {
    let memory = Behind::new(cfg.plane_port().words, Pattern::always(), vec![1]);
    images_by(cfg, frames, comes, ready, memory)
}

/// The same beside such a memory.
fn images_by(
    cfg: Config,
    frames: &[Vec<u32>],
    comes: &Pattern,
    ready: &Pattern,
    mut memory: Behind,
) -> (Vec<u32>, u64) {
    let mut sim = Sim::<Accumulator>::new(cfg);
    let mut sent = frames.iter().flatten().peekable();
    let mut image = vec![];
    while image.len() < PIXELS * frames.len() / cfg.frames() as usize {
        let cycle = sim.cycle();
        assert!(cycle < 50_000, "the images do not end");
        let given = sim.moore();
        let takes = ready.at(cycle);
        image.extend((given.image.valid && takes).then_some(given.image.payload));
        let next = sent.next_if(|_| given.ready && comes.at(cycle));
        let frame = next.map_or(Stream::idle(), |rgb| Stream::offer(*rgb));
        let shows = memory.shows(cycle);
        let out = sim.clock(In { frame, image_ready: takes, memory: shows }).unwrap().out;
        memory.edge(cycle, out.request);
    }
    assert!(!sim.moore().busy, "something is left");
    (image, sim.cycle())
}

/// Each pixel of the image of some frames.
fn of_each(frames: &[Vec<u32>], channel: impl Fn(&[u8]) -> u8) -> Vec<u32> {
    let pixel = |pixel: usize| {
        [16, 8, 0].iter().fold(0, |rgb, shift| {
            let of: Vec<u8> = frames.iter().map(|frame| (frame[pixel] >> shift) as u8).collect();
            rgb << 8 | u32::from(channel(&of))
        })
    };
    (0..PIXELS).map(pixel).collect()
}

fn frames(count: usize) -> impl Strategy<Value = Vec<Vec<u32>>> {
    prop::collection::vec(prop::collection::vec(0u32..1 << 24, PIXELS), count)
}

proptest! {
    /// Nothing is lost or changed while the display stalls, and no memory is misused.
    #[test]
    fn a_display_that_stalls_changes_nothing(
        frames in frames(16),
        way in 0usize..7,
        ready in pattern(),
        comes in pattern(),
        takes in pattern(),
        latencies in prop::collection::vec(1u64..20, 1..4),
    ) {
        let ways: [&[(&str, &str)]; 7] = [
            &[("frames", "8")],
            &[("frames", "8"), ("schedule", "nodes")],
            &[("frames", "8"), ("branching", "4"), ("weights", "box")],
            &[("frames", "8"), ("method", "buffer")],
            &[("frames", "8"), ("method", "blend")],
            &[("frames", "2"), ("schedule", "nodes")],
            &[("frames", "1")],
        ];
        let cfg = small(ways[way]);
        let by = cfg.accumulation();
        let channel = |of: &[u8]| by.as_ref().map_or(of[0], |by| (by.channel)(of));
        let expected = frames.chunks(cfg.frames() as usize).flat_map(|of| of_each(of, channel));
        let expected: Vec<_> = expected.collect();
        prop_assert_eq!(&images(cfg, &frames, &comes, &ready).0, &expected);
        // With planes outside, however that memory takes and answers.
        let cfg = outside(ways[way]);
        let memory = Behind::new(cfg.plane_port().words, takes, latencies);
        prop_assert_eq!(images_by(cfg, &frames, &comes, &ready, memory).0, expected);
    }

    /// Whatever the tree: both schedules give its golden model's image, which is no farther from the exact mean than its bound;
    /// the stack has no more planes than it is built with, and the stream takes a sweep for each frame.
    #[test]
    fn any_tree_gives_its_golden_image(
        (frames, weights) in (1usize..=40, 0usize..4).prop_flat_map(|(count, weights)| {
            // Plain trees are complete.
            let count = if weights == 0 { count.next_power_of_two().min(32) } else { count };
            (frames(count), Just(weights))
        }),
        branching in 0usize..4,
        bits in (8u32..=24, 8u32..=16, 1u32..=16),
    ) {
        let count = frames.len() as u32;
        let weights = ["none", "box", "triangle", "gaussian"][weights];
        let branching = ["2", "4", "2,4", "4,2"][branching];
        let (node_bits, plane_bits, weight_bits) = bits;
        let [frame_count, node_bits, plane_bits, weight_bits] =
            [count, node_bits, plane_bits, weight_bits].map(|number| number.to_string());
        let settings = [
            ("frames", &*frame_count),
            ("weights", weights),
            ("branching", branching),
            ("node_bits", &node_bits),
            ("plane_bits", &plane_bits),
            ("weight_bits", &weight_bits),
        ];
        let with = |schedule| config(&[&settings[..], &[("schedule", schedule)]].concat());
        // Of a complete tree with nodes of four inputs there are not as many leaves.
        let (Ok(stream), Ok(nodes)) = (with("stream"), with("nodes")) else {
            prop_assert_eq!(weights, "none");
            return Ok(());
        };
        let by = stream.accumulation();
        let exact = |of: &[u8]| by.as_ref().map_or(of[0], |by: &Accumulation| by.exact(of));
        let golden = |of: &[u8]| by.as_ref().map_or(of[0], |by| (by.channel)(of));
        let expected = of_each(&frames, golden);
        let always = Pattern::always();
        let (image, cycles) = images(stream, &frames, &always, &always);
        prop_assert_eq!(&image, &expected);
        prop_assert_eq!(cycles, u64::from(count) * PIXELS as u64 + u64::from(stream.levels()) + 1);
        prop_assert_eq!(&images(nodes, &frames, &always, &always).0, &image);
        for schedule in ["stream", "nodes"] {
            let outside = [&settings[..], &[("schedule", schedule), ("planes", "outside")]];
            let outside = config(&outside.concat()).unwrap();
            prop_assert_eq!(&images(outside, &frames, &always, &always).0, &image);
        }
        let bound = by.as_ref().map_or(0, |by| by.error_bound);
        for (found, exact) in expected.iter().zip(of_each(&frames, exact)) {
            for shift in [16, 8, 0] {
                let error = (found >> shift & 0xff).abs_diff(exact >> shift & 0xff);
                prop_assert!(error <= bound, "{error} levels, and {bound} allowed");
            }
        }
    }
}
