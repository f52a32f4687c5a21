use super::*;
use crate::colour::Colour;
use crate::test_util::tree;
use pellucid_sim::Sim;

/// Sends two images of constant frames of such levels, as fast as they are taken; gives each pixel of the images that come, and
/// the cycles that it took.
fn images(cfg: Config, levels: &[u32]) -> (Vec<u32>, u64) {
    let mut sim = Sim::<Tree>::new(cfg);
    let mut found = vec![];
    let frames = [levels, levels].concat();
    let mut sent = frames.iter().enumerate().flat_map(|(k, level)| {
        let closes = (k + 1) % levels.len() == 0;
        let fraction = cfg.plane_bits - 8;
        let colour = Colour { r: level << fraction, g: 0, b: 0 };
        (0..cfg.screen.pixels()).map(move |pixel| Pixel { pixel, closes, colour })
    });
    let mut next = sent.next();
    while next.is_some() || sim.moore().busy {
        assert!(sim.cycle() < 10_000, "the images do not end");
        let ready = sim.moore().ready;
        let frame = next.filter(|_| ready).map_or(Stream::idle(), Stream::offer);
        let out = sim.clock(In { frame, image_ready: true }).unwrap().out;
        found.extend(out.image.valid.then_some(out.image.payload.colour.r));
        if ready {
            next = sent.next();
        }
    }
    (found, sim.cycle())
}

#[test]
fn both_schedules_give_the_same() {
    let levels = [3, 250, 17, 18, 99, 100, 255, 0];
    let pixels = 6;
    for inputs in [&[2, 2, 2][..], &[2, 4], &[4, 2]] {
        for weight_bits in [0, 5] {
            let (stream, cycles) = images(tree(inputs, false, weight_bits), &levels);
            let (nodes, more) = images(tree(inputs, true, weight_bits), &levels);
            assert_eq!(stream, nodes, "{inputs:?} {weight_bits}");
            assert_eq!(stream.len(), 12);
            assert!(stream.iter().all(|level| level.abs_diff(stream[0]) == 0));
            // A sweep for each of two times eight frames, and what is under way at the end.
            assert_eq!(cycles, 16 * pixels + inputs.len() as u64);
            // A further sweep for each node, with two cycles until it is through.
            let of_image: u64 = match inputs.len() {
                3 => 4 + 2 + 1,
                _ => {
                    if inputs[0] == 2 {
                        4 + 1
                    } else {
                        2 + 1
                    }
                }
            };
            assert_eq!(more, 16 * pixels + 2 * of_image * (pixels + 2), "{inputs:?}");
        }
    }
}

#[test]
fn the_mean_of_equal_frames_is_that_frame() {
    let (found, _) = images(tree(&[2, 2, 2], true, 0), &[200; 8]);
    assert_eq!(found, [200; 12]);
}
