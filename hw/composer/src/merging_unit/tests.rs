use super::*;
use crate::test_util::{Pattern, Source, contents, edge, holding, pattern, screen};
use pellucid_machine::pixel::Z_FAR;
use pellucid_sim::{ReadDuringWrite, Sim, StreamMonitor};
use proptest::prelude::*;

const WIPED: Opaque = Opaque { z: Z_FAR, colour: 0 };

/// Merges a frame with what the local frame buffer holds; gives the pixels with the cycles in which they were
/// taken.
fn merge(
    sim: &mut Sim<MergingUnit>,
    upstream: &[Opaque],
    local: &[Opaque],
    starts: &Pattern,
    ready: &Pattern,
) -> Vec<(u64, Opaque)> {
    let mut bank = holding(local, (), ReadDuringWrite::Forbidden);
    let mut source = Source::new(upstream.iter().copied(), starts.clone());
    let mut monitor = StreamMonitor::new("merged", "MergingUnit", "test");
    let (mut merged, mut read, mut wiped) = (vec![], vec![], vec![]);
    let mut cycle = 0;
    while merged.len() < upstream.len() {
        assert!(cycle < 10_000, "the frame does not end: {merged:?}");
        let moore = sim.moore();
        let now = moore.merged.with(ready.at(cycle));
        monitor.observe(now).unwrap();
        merged.extend(now.fires().then_some((cycle, now.payload)));
        let i = In { upstream: source.offer(cycle), local: bank.q().data, merged_ready: now.ready };
        source.edge(moore.ready);
        let out = sim.clock(i).unwrap().out;
        read.extend(out.read.asked());
        bank.pass_read(out.read);
        if out.wipe.valid {
            assert!(read.contains(&out.wipe.payload), "a pixel is wiped before it was read");
            bank.write(out.wipe.payload, WIPED);
            wiped.push(out.wipe.payload);
        }
        edge(&mut bank);
        cycle += 1;
    }
    // Every pixel of the local buffer is read once and wiped once, in raster order.
    let pixels: Vec<u32> = (0..local.len() as u32).collect();
    assert_eq!((&read, &wiped), (&pixels, &pixels));
    assert_eq!(contents(&mut bank, local.len() as u32), vec![WIPED; local.len()]);
    merged
}

fn pixel(z: u32, colour: u32) -> Opaque {
    Opaque { z, colour }
}

#[test]
fn the_nearer_pixel_comes_out_and_of_equal_depths_the_one_from_upstream() {
    let mut sim = Sim::new(screen(4, 1));
    let upstream = [pixel(5, 1), pixel(5, 2), pixel(5, 3), pixel(Z_FAR, 4)];
    let local = [pixel(4, 11), pixel(5, 12), pixel(6, 13), pixel(Z_FAR, 14)];
    let always = Pattern::always();
    let merged = merge(&mut sim, &upstream, &local, &always, &always);
    let expected = [(4, local[0]), (5, upstream[1]), (6, upstream[2]), (7, upstream[3])];
    assert_eq!(merged, expected, "one a cycle, each four cycles after it came in");
}

#[test]
fn a_receiver_that_is_not_ready_stops_it_after_one_pixel_more() {
    let mut sim = Sim::<MergingUnit>::new(screen(9, 1));
    // Four pixels fill its stages, the fifth waits in a register of its own; each is taken while it runs.
    let mut taken = vec![];
    for cycle in 0..12 {
        taken.push(sim.moore().ready);
        let i = In {
            upstream: Stream::offer(pixel(1, cycle)),
            local: pixel(2, 0),
            merged_ready: false,
        };
        sim.clock(i).unwrap();
    }
    assert_eq!(taken.iter().position(|taken| !taken), Some(5));
    assert!(!taken[5..].contains(&true));
    // Once the receiver is ready, they come out without a gap, in order.
    for colour in 0..5 {
        assert_eq!(sim.moore().merged, Stream::offer(pixel(1, colour)));
        let i = In { upstream: Stream::idle(), local: pixel(2, 0), merged_ready: true };
        sim.clock(i).unwrap();
    }
    assert!(!sim.moore().merged.valid && sim.moore().ready);
}

fn pixels(count: usize) -> impl Strategy<Value = Vec<Opaque>> {
    let one = (prop_oneof![0..4_u32, Just(Z_FAR)], 0..1_u32 << 24);
    proptest::collection::vec(one.prop_map(|(z, colour)| pixel(z, colour)), count)
}

proptest! {
    /// Frame after frame, whatever sender and receiver do: each pixel once, in order.
    #[test]
    fn merges_every_pixel(
        (width, height, frames) in (1..5_u32, 1..5_u32).prop_flat_map(|(width, height)| {
            let count = (width * height) as usize;
            let frame = (pixels(count), pixels(count), pattern(), pattern());
            (Just(width), Just(height), proptest::collection::vec(frame, 1..4))
        }),
    ) {
        let mut sim = Sim::new(screen(width, height));
        for (upstream, local, starts, ready) in frames {
            let merged = merge(&mut sim, &upstream, &local, &starts, &ready);
            let expected: Vec<Opaque> = upstream
                .iter()
                .zip(&local)
                .map(|(upstream, local)| *[upstream, local].into_iter().min_by_key(|p| p.z).unwrap())
                .collect();
            let merged: Vec<Opaque> = merged.into_iter().map(|(_, pixel)| pixel).collect();
            prop_assert_eq!(merged, expected);
        }
    }
}

#[test]
#[should_panic(expected = "the width of a screen is 0: expected 1 to 8192")]
fn a_screen_without_columns_is_none() {
    MergingUnit::reset(&screen(0, 3));
}
