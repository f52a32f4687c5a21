use super::*;
use pellucid_machine::pixel::rgba;
use pellucid_mbuffer::golden::{WEIGHTED_SUM, colour as weighted};
use pellucid_sim::Label;
use proptest::prelude::*;

const BLACK: Screen = Screen { width: 2, height: 1, background: 0 };

fn at(x: u32, z: u32, rgba: u32) -> Fragment {
    Fragment { x, y: 0, z, rgba, label: Label::NONE }
}

fn run(info: Screen, fragments: &[Fragment]) -> Reference {
    Golden::new(info).of(fragments).unwrap()
}

#[test]
fn division_rounds_exactly_everywhere() {
    for t in 0..=65025_u32 {
        // round(t / 255) is the q with |t - 255 q| <= 127; 255 is odd, so it is unique.
        let q = divide_by_255(t);
        assert!((255 * q).abs_diff(t) <= 127, "{t} / 255 gave {q}");
    }
}

#[test]
fn blending_rounds_exactly_for_every_alpha_source_and_destination() {
    for a in 0..=255_u8 {
        for s in 0..=255_u8 {
            for c in 0..=255_u8 {
                let exact = u32::from(a) * u32::from(s) + (255 - u32::from(a)) * u32::from(c);
                // The same values go through each channel in turn, beside a channel that must not leak.
                let below = u32::from_be_bytes([0, c, 255, c]);
                let [_, r, g, b] = blend(rgba(s, 255, s, a), below).to_be_bytes();
                assert!((255 * u32::from(r)).abs_diff(exact) <= 127, "a={a} s={s} c={c}: {r}");
                assert_eq!((g, b), (255, r), "a={a} s={s} c={c}");
            }
        }
    }
}

#[test]
fn an_empty_frame_is_background() {
    let info = Screen { width: 2, height: 2, background: 0x123456 };
    let reference = run(info, &[]);
    assert_eq!(reference.image.pixels, [0x123456; 4]);
    assert_eq!(reference.layer_histogram, [4]);
    assert_eq!(reference.stored_histogram, [4]);
    assert_eq!(reference.max_layers, 0);
}

#[test]
fn layers_are_counted_at_each_pixel() {
    let info = Screen { width: 2, height: 2, background: 0 };
    let thin = |x, y, z| Fragment { x, y, z, rgba: rgba(9, 9, 9, 9), label: Label::NONE };
    // The opaque fragment hides one of the three at (1, 0), and comes after it.
    let wall = Fragment { x: 1, y: 0, z: 7, rgba: rgba(0, 0, 0, 255), label: Label::NONE };
    let fragments =
        [thin(1, 0, 5), thin(1, 0, 6), thin(1, 0, 7), wall, thin(0, 1, 3), thin(1, 1, 3)];
    let reference = run(info, &fragments);
    assert_eq!(reference.layers, [0, 2, 1, 1]);
    assert_eq!(reference.layer_histogram, [1, 2, 1]);
}

#[test]
fn two_layers_by_hand() {
    // Nearer arrives first. Far: red 200, alpha 128, over black:
    //   128*200 + 127*0 = 25600; / 255 = 100.39 -> 100.
    // Near: red 50, alpha 64, over 100: 64*50 + 191*100 = 22300; / 255 = 87.45 -> 87.
    let fragments = [at(0, 10, rgba(50, 0, 0, 64)), at(0, 20, rgba(200, 0, 0, 128))];
    let reference = run(BLACK, &fragments);
    assert_eq!(reference.image.pixels, [87 << 16, 0]);
    assert_eq!((reference.blended, reference.culled), (2, 0));
    assert_eq!(reference.transparent_pixels, 1);
    assert_eq!(reference.max_layers, 2);
    assert_eq!(reference.layer_histogram, [1, 0, 1]);
}

#[test]
fn equal_depth_blends_the_earlier_arrival_first() {
    // White at alpha 128 over black: 128*255 / 255 = 128. Then black at alpha 128: 127*128 = 16256; / 255 = 63.75 -> 64.
    let white = at(0, 5, rgba(255, 255, 255, 128));
    let black = at(0, 5, rgba(0, 0, 0, 128));
    assert_eq!(run(BLACK, &[white, black]).image.pixels[0], 0x404040);
    // Black over black is 0. Then white at alpha 128: 128*255 / 255 = 128.
    assert_eq!(run(BLACK, &[black, white]).image.pixels[0], 0x808080);
}

#[test]
fn the_first_opaque_fragment_wins_a_tie() {
    let fragments = [at(0, 5, 0x112233ff), at(0, 5, 0x445566ff)];
    let reference = run(BLACK, &fragments);
    assert_eq!(reference.image.pixels[0], 0x112233);
    assert_eq!((reference.fragments, reference.opaque), (2, 2));
}

#[test]
fn an_opaque_fragment_culls_what_came_before_behind_it() {
    let fragments = [
        at(0, 20, rgba(255, 0, 0, 128)), // stored, then hidden
        at(0, 10, 0x0000ffff),
        at(0, 10, rgba(255, 0, 0, 128)), // equal to the opaque depth: not in front
        at(0, 30, rgba(255, 0, 0, 128)), // behind at arrival
    ];
    let reference = run(BLACK, &fragments);
    assert_eq!(reference.image.pixels[0], 0x0000ff);
    assert_eq!((reference.transparent, reference.culled), (3, 3));
    assert_eq!((reference.blended, reference.transparent_pixels), (0, 0));
    assert_eq!((reference.stored, reference.stored_pixels), (1, 1));
    assert_eq!(reference.stored_histogram, [1, 1]);
    assert_eq!(reference.layer_histogram, [2]);
}

#[test]
fn nothing_at_the_far_plane_is_visible() {
    let fragments = [at(0, Z_FAR, 0xffffffff), at(1, Z_FAR, 0xffffff80)];
    let reference = run(BLACK, &fragments);
    assert_eq!(reference.image.pixels, [0, 0]);
    assert_eq!((reference.opaque, reference.culled), (1, 1));
    assert_eq!(reference.stored, 0);
}

#[test]
fn alpha_zero_counts_as_a_layer_and_changes_no_colour() {
    let info = Screen { background: 0x336699, ..BLACK };
    let reference = run(info, &[at(0, 1, 0xffffff00)]);
    assert_eq!(reference.image.pixels, [0x336699; 2]);
    assert_eq!((reference.blended, reference.stored), (1, 1));
}

#[test]
fn many_layers_come_out_in_depth_order() {
    // 3 * 65536 layers, so that the chain crosses blocks; all but the nearest are invisible (alpha 0).
    // The nearest is white at alpha 51 over black: 51*255 / 255 = 51.
    let mut fragments: Vec<Fragment> =
        (1..=3 * BLOCK as u32).map(|z| at(1, z, 0xffffff00)).collect();
    fragments.push(at(1, 0, rgba(255, 255, 255, 51)));
    let reference = run(BLACK, &fragments);
    assert_eq!(reference.image.pixels, [0, 0x333333]);
    assert_eq!(reference.max_layers, 3 * 65536 + 1);
    assert_eq!(reference.layer_histogram.len(), 3 * 65536 + 2);
}

#[test]
fn a_fragment_outside_is_refused() {
    let refused = |last| {
        let done = Golden::new(BLACK).of(&[at(0, 1, 0xff), last]);
        done.unwrap_err().to_string()
    };
    assert_eq!(
        refused(at(2, 1, 0xff)),
        "fragment 2 at x=2 y=0 z=1 is outside the frame of 2x1 pixels and 24 bits of depth"
    );
    assert!(refused(at(0, Z_FAR + 1, 0xff)).contains(" z=16777216 "));
}

#[test]
fn more_records_than_indices_are_refused() {
    let limited = || Golden { limit: 2, ..Golden::new(BLACK) };
    let full = [at(0, 1, 0), at(0, 1, 0), at(1, 1, 0), at(0, 0, 0xff)];
    assert_eq!(limited().of(&full).unwrap().fragments, 4);
    assert_eq!(
        limited().of(&[at(0, 1, 0); 3]).unwrap_err().to_string(),
        "fragment 3 does not fit: the golden model holds 2 transparent fragments of a pixel"
    );
}

/// Bytes of all records that are held.
fn held_bytes(golden: &Golden) -> usize {
    golden.blocks.iter().map(|block| block.capacity() * size_of::<Record>()).sum()
}

/// Eight blocks of fragments, eight at each pixel, of which two blocks may be held. After the play that finds it out,
/// the frame comes four times again.
#[test]
fn a_frame_of_more_than_is_held_is_played_again_within_the_same_memory() {
    let info = Screen { width: BLOCK as u32, height: 1, background: 0x336699 };
    let mut golden = Golden { most_held: 2 * BLOCK as u64, ..Golden::new(info) };
    let fragments: Vec<Fragment> = (0..8 * BLOCK as u32)
        .map(|n| at(n % info.width, n.wrapping_mul(0x9e37_79b9) >> 9, n.wrapping_mul(0x9e37_79b9)))
        .collect();
    let (mut plays, mut most) = (1, 0);
    for fragment in &fragments {
        golden.push(*fragment).unwrap();
        most = most.max(held_bytes(&golden));
    }
    while golden.is_left() {
        plays += 1;
        for fragment in &fragments {
            golden.push_again(*fragment);
            most = most.max(held_bytes(&golden));
        }
    }
    assert_eq!(most, 2 * BLOCK * 12);
    assert_eq!(plays, 5);
    assert!(golden.known == run(info, &fragments));
}

#[test]
fn what_is_held_is_bounded_unless_a_pixel_has_more() {
    assert_eq!(HELD * size_of::<Record>() as u64, 96 << 20);
    assert_eq!(size_of::<Pixel>(), 16);
    let fragments = [at(0, 3, 0x80), at(0, 2, 0x80), at(0, 1, 0x80), at(1, 1, 0x80)];
    let golden = Golden { most_held: 1, ..Golden::new(BLACK) };
    assert_eq!(golden.of(&fragments), Ok(run(BLACK, &fragments)));
}

/// The rules read literally: for each pixel, search the whole frame for the next fragment to blend.
fn oracle(info: Screen, fragments: &[Fragment]) -> (Vec<u32>, Vec<usize>) {
    let mut colours = Vec::new();
    let mut layers = Vec::new();
    for y in 0..info.height {
        for x in 0..info.width {
            let here = |f: &&Fragment| f.x == x && f.y == y;
            let opaque = fragments.iter().filter(here).filter(|f| f.is_opaque());
            let (mut depth, mut colour) = (Z_FAR, info.background);
            for fragment in opaque {
                if fragment.z < depth {
                    (depth, colour) = (fragment.z, fragment.rgba >> 8);
                }
            }
            let mut left: Vec<&Fragment> =
                fragments.iter().filter(here).filter(|f| !f.is_opaque() && f.z < depth).collect();
            layers.push(left.len());
            while let Some(z) = left.iter().map(|f| f.z).max() {
                let first = left.iter().position(|f| f.z == z).unwrap();
                colour = rounded_over(left.remove(first).rgba, colour);
            }
            colours.push(colour);
        }
    }
    (colours, layers)
}

/// The blend in floating point: a double holds every value exactly, and its error is far below 1/510.
fn rounded_over(rgba: u32, below: u32) -> u32 {
    let a = f64::from(rgba & 0xff);
    [24, 16, 8].iter().fold(0, |colour, shift| {
        let s = f64::from(rgba >> shift & 0xff);
        let c = f64::from(below >> (shift - 8) & 0xff);
        colour << 8 | ((a * s + (255.0 - a) * c) / 255.0).round() as u32
    })
}

prop_compose! {
    fn any_fragment()(
        x in 0..3_u32,
        y in 0..2_u32,
        // Few depths, so that ties and the far plane are common.
        z in prop_oneof![0..4_u32, Z_FAR - 1..=Z_FAR, 0..=Z_FAR],
        colour in 0..1_u32 << 24,
        a in prop_oneof![4 => 0..=254_u32, 1 => Just(0_u32), 1 => Just(255_u32)],
    ) -> Fragment {
        Fragment { x, y, z, rgba: colour << 8 | a, label: Label::NONE }
    }
}

proptest! {
    #[test]
    fn it_agrees_with_the_rules_read_literally(
        fragments in prop::collection::vec(any_fragment(), 0..80),
        background in 0..1_u32 << 24,
    ) {
        let info = Screen { width: 3, height: 2, background };
        let reference = run(info, &fragments);
        let (colours, layers) = oracle(info, &fragments);
        prop_assert_eq!(&reference.image.pixels, &colours);
        prop_assert_eq!(reference.blended, layers.iter().sum::<usize>() as u64);
        prop_assert_eq!(reference.max_layers as usize, *layers.iter().max().unwrap());
        let covered = layers.iter().filter(|&&n| n > 0).count() as u64;
        prop_assert_eq!(reference.transparent_pixels, covered);
        for (n, &pixels) in reference.layer_histogram.iter().enumerate() {
            prop_assert_eq!(pixels, layers.iter().filter(|&&m| m == n).count() as u64);
        }
        prop_assert_eq!(reference.culled + reference.blended, reference.transparent);
        prop_assert_eq!(reference.opaque + reference.transparent, fragments.len() as u64);
    }

    #[test]
    fn how_much_is_held_does_not_matter(
        fragments in prop::collection::vec(any_fragment(), 0..80),
        most_held in 0..60_u64,
    ) {
        let info = Screen { width: 3, height: 2, background: 0x336699 };
        let all = Golden::new(info).with(WEIGHTED_SUM);
        let few = Golden { most_held, ..Golden::new(info).with(WEIGHTED_SUM) };
        prop_assert_eq!(few.of(&fragments), all.of(&fragments));
    }

    #[test]
    fn what_is_stored_is_what_an_early_test_lets_through(
        fragments in prop::collection::vec(any_fragment(), 0..80),
    ) {
        let reference = run(Screen { width: 3, height: 2, background: 0 }, &fragments);
        let mut stored = [0_usize; 6];
        for (i, f) in fragments.iter().enumerate() {
            let depth = fragments[..i]
                .iter()
                .filter(|g| g.is_opaque() && (g.x, g.y) == (f.x, f.y))
                .map(|g| g.z)
                .fold(Z_FAR, u32::min);
            if !f.is_opaque() && f.z < depth {
                stored[(f.y * 3 + f.x) as usize] += 1;
            }
        }
        prop_assert_eq!(reference.stored, stored.iter().sum::<usize>() as u64);
        prop_assert_eq!(reference.stored_pixels, stored.iter().filter(|&&n| n > 0).count() as u64);
        prop_assert_eq!(reference.stored_histogram.len(), stored.iter().max().unwrap() + 1);
        for (n, &pixels) in reference.stored_histogram.iter().enumerate() {
            prop_assert_eq!(pixels, stored.iter().filter(|&&m| m == n).count() as u64);
        }
    }

    #[test]
    fn the_order_across_pixels_does_not_matter(
        fragments in prop::collection::vec(any_fragment(), 0..80),
    ) {
        let info = Screen { width: 3, height: 2, background: 0x808080 };
        let mut by_pixel = fragments.clone();
        by_pixel.sort_by_key(|f| (f.y, f.x)); // stable: the order within a pixel stays
        prop_assert_eq!(run(info, &fragments), run(info, &by_pixel));
    }

    #[test]
    fn the_weighted_image_is_of_the_layers_that_count_in_arrival_order(
        fragments in prop::collection::vec(any_fragment(), 0..80),
        background in 0..1_u32 << 24,
    ) {
        let info = Screen { width: 3, height: 2, background };
        let reference = Golden::new(info).with(WEIGHTED_SUM).of(&fragments).unwrap();
        let plain = run(info, &fragments);
        prop_assert_eq!(reference.image_by(Arithmetic::BLEND), plain.image_by(Arithmetic::BLEND));
        prop_assert_eq!(&Reference { further: vec![], ..reference.clone() }, &plain);
        let image = reference.image_by(WEIGHTED_SUM);
        for (pixel, &colour) in image.pixels.iter().enumerate() {
            let (x, y) = (pixel as u32 % 3, pixel as u32 / 3);
            let here: Vec<&Fragment> = fragments.iter().filter(|f| (f.x, f.y) == (x, y)).collect();
            let opaque = here.iter().filter(|f| f.is_opaque()).min_by_key(|f| f.z);
            let opaque = opaque.filter(|f| f.z < Z_FAR);
            let (depth, below) = opaque.map_or((Z_FAR, background), |f| (f.z, f.rgba >> 8));
            let layers: Vec<Layer> = here
                .iter()
                .filter(|f| !f.is_opaque() && f.z < depth)
                .map(|f| Layer { z: f.z, rgba: f.rgba })
                .collect();
            prop_assert_eq!(colour, weighted(&layers, below));
        }
    }
}

#[test]
#[should_panic = "without Arithmetic(weighted sum)"]
fn a_weighted_image_that_was_not_asked_for_is_not_there() {
    run(BLACK, &[]).image_by(WEIGHTED_SUM);
}
