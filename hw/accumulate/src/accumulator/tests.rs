use super::*;
use crate::test_util::small;
use pellucid_sim::Sim;
use pellucid_test_util::pattern;
use proptest::prelude::*;

proptest! {
    /// Nothing is lost or changed while the display stalls, and no memory is misused.
    #[test]
    fn a_display_that_stalls_changes_nothing(
        frames in prop::collection::vec(prop::collection::vec(0u32..1 << 24, 6), 16),
        way in 0usize..7,
        ready in pattern(),
        comes in pattern(),
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
        let of_image = cfg.frames() as usize;
        let mut sim = Sim::<Accumulator>::new(cfg);
        let mut sent = frames.iter().flatten().peekable();
        let mut image = vec![];
        while image.len() < 6 * 16 / of_image {
            let cycle = sim.cycle();
            prop_assert!(cycle < 20_000, "the images do not end");
            let given = sim.moore();
            let takes = ready.at(cycle);
            image.extend((given.image.valid && takes).then_some(given.image.payload));
            let next = sent.next_if(|_| given.ready && comes.at(cycle));
            let frame = next.map_or(Stream::idle(), |rgb| Stream::offer(*rgb));
            sim.clock(In { frame, image_ready: takes }).unwrap();
        }
        let expected = frames.chunks(of_image).flat_map(|frames| {
            let by = &by;
            (0..6).map(move |pixel| {
                let channel = |shift: u32| {
                    let of: Vec<u8> = frames.iter().map(|frame| (frame[pixel] >> shift) as u8).collect();
                    u32::from(by.as_ref().map_or(of[0], |by| (by.channel)(&of)))
                };
                channel(16) << 16 | channel(8) << 8 | channel(0)
            })
        });
        prop_assert_eq!(image, expected.collect::<Vec<_>>());
    }
}
