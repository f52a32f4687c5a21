use super::*;
use crate::golden;
use crate::test_util::sums;
use pellucid_sim::Sim;

/// Every sum that so many frames can have is divided as the exact one, and every level by any number of frames.
#[test]
fn what_is_multiplied_by_a_reciprocal_is_divided() {
    for frames in 1..=1024u32 {
        let cfg = Config { frames, bits: 24, ..sums(3, false) };
        let step = 1 + frames as usize / 7;
        for sum in (0..=255 * frames).step_by(step) {
            assert_eq!(scaled(&cfg, sum), (2 * sum + frames) / (2 * frames), "{sum} / {frames}");
        }
        let cfg = Config { blends: true, ..cfg };
        for level in 0..=255 {
            assert_eq!(term(&cfg, level), level / frames, "{level} / {frames}");
        }
    }
}

#[test]
fn images_follow_each_other() {
    for (blends, by) in [(false, golden::buffer as fn(&[u8]) -> u8), (true, golden::blend)] {
        let cfg = sums(3, blends);
        let mut sim = Sim::<Sums>::new(cfg);
        let level =
            |image: u32, frame: u32, pixel: u32| (image * 71 + frame * 37 + pixel * 11) % 256;
        let mut found = vec![];
        for image in 0..2 {
            for frame in 0..3 {
                for pixel in 0..cfg.screen.pixels() {
                    let colour = Colour { r: level(image, frame, pixel), g: 255, b: 0 };
                    let pixel = Pixel { pixel, closes: frame == 2, colour };
                    let out = sim.moore().image;
                    found.extend(out.valid.then_some(out.payload.colour));
                    sim.clock(In { frame: Stream::offer(pixel), opens: frame == 0 }).unwrap();
                }
            }
            // The last pixel comes a cycle later.
            let out = sim.moore().image;
            found.extend(out.valid.then_some(out.payload.colour));
            sim.clock(In { frame: Stream::idle(), opens: false }).unwrap();
        }
        let expected = (0..2).flat_map(|image| (0..cfg.screen.pixels()).map(move |p| (image, p)));
        let expected: Vec<Colour> = expected
            .map(|(image, p)| {
                let channel = |levels: [u32; 3]| u32::from(by(&levels.map(|level| level as u8)));
                let levels = [0, 1, 2].map(|frame| level(image, frame, p));
                Colour { r: channel(levels), g: channel([255; 3]), b: 0 }
            })
            .collect();
        assert_eq!(found, expected);
    }
}
