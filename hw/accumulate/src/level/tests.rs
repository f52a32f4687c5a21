use super::*;
use crate::test_util::{level, small};
use pellucid_sim::Sim;

const PIXELS: u32 = 6;

/// Sends the inputs of nodes, each a channel of every pixel; gives the pixels of results with the cycle of each.
fn results(cfg: Config, inputs: &[[u32; PIXELS as usize]], closes: bool) -> Vec<(u64, Pixel)> {
    let mut sim = Sim::<Level>::new(cfg);
    let mut results = vec![];
    let sent = inputs.iter().enumerate().flat_map(|(k, input)| {
        let closes = closes && k + 1 == inputs.len();
        let colour = |r| Colour { r, g: 2, b: 4 };
        let pixel = move |(pixel, r): (u32, &u32)| Pixel { pixel, closes, colour: colour(*r) };
        (0..PIXELS).zip(input).map(pixel)
    });
    for value in sent.map(Stream::offer).chain([Stream::idle(), Stream::idle()]) {
        let result = sim.moore().result;
        results.extend(result.valid.then_some((sim.cycle(), result.payload)));
        sim.clock(In { value }).unwrap();
    }
    results
}

#[test]
fn the_last_input_of_a_node_brings_the_result() {
    let first = [10, 20, 30, 40, 50, 60];
    let second = [20, 30, 40, 50, 60, 71];
    let found = results(level(2, 0), &[first, second, first, first], true);
    let of = |sweep: u64, closes: bool, r: [u32; 6]| {
        (0..6).zip(r).map(move |(pixel, r)| {
            let colour = Colour { r, g: 2, b: 4 };
            // A cycle after the pixel of the second of two sweeps.
            (sweep * 6 + u64::from(pixel) + 1, Pixel { pixel, closes, colour })
        })
    };
    let expected: Vec<_> =
        of(1, false, [15, 25, 35, 45, 55, 65]).chain(of(3, true, first)).collect();
    assert_eq!(found, expected);
}

#[test]
fn an_image_that_ends_closes_a_node() {
    let settings =
        [("frames", "6"), ("branching", "4"), ("weights", "triangle"), ("weight_bits", "3")];
    let cfg = *small(&[&settings[..], &[("node_bits", "24")]].concat()).tree.level(0);
    // The fifth and the sixth frame weigh 2 and 1: of 8 parts two thirds are 5.
    assert_eq!([0, 1, 2, 3].map(|k| cfg.edge(1, k)), [5, 3, 0, 0]);
    let found = results(cfg, &[[8; 6], [8; 6], [8; 6], [8; 6], [80; 6], [160; 6]], true);
    let of_node = |found: &[(u64, Pixel)], closes, r| {
        assert!(found.iter().all(|(_, p)| p.closes == closes && p.colour.r == r), "{found:?}");
    };
    assert_eq!(found.len(), 12);
    of_node(&found[..6], false, 8);
    of_node(&found[6..], true, 50 + 60);
}
