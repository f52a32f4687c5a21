use super::*;
use pellucid_machine::pixel::rgba;
use proptest::prelude::*;

fn layer(z: u32, rgba: u32) -> Layer {
    Layer { z, rgba }
}

/// Far to near; at equal depth the earlier arrival lies below.
fn sorted(layers: &[Layer]) -> Vec<&Layer> {
    let mut sorted: Vec<&Layer> = layers.iter().collect();
    sorted.sort_by_key(|layer| std::cmp::Reverse(layer.z));
    sorted
}

/// A colour `0xRRGGBBAA` over a colour `0xRRGGBB`, `(a*s + (255-a)*c) / 255` per channel, rounded to nearest.
fn blend(rgba: u32, below: u32) -> u32 {
    let a = rgba & 0xff;
    [16, 8, 0].into_iter().fold(0, |colour, shift| {
        let (own, under) = (rgba >> 8 >> shift & 0xff, below >> shift & 0xff);
        // 255 is odd: there is no tie.
        (colour << 8) | ((2 * (a * own + (255 - a) * under) + 255) / 510)
    })
}

/// The exact blend.
fn exact(layers: &[Layer], below: u32) -> u32 {
    sorted(layers).into_iter().fold(below, |below, layer| blend(layer.rgba, below))
}

/// The blend of the channel at bit `shift` of `0xRRGGBB`, without rounding.
fn unrounded(layers: &[Layer], below: u32, shift: u32) -> f64 {
    let byte = |rgb: u32| f64::from(rgb >> shift & 0xff);
    sorted(layers).into_iter().fold(byte(below), |below, layer| {
        let alpha = f64::from(layer.rgba & 0xff) / 255.0;
        alpha * byte(layer.rgba >> 8) + (1.0 - alpha) * below
    })
}

/// How far the sum of `n` layers may be from the unrounded blend, in levels.
fn from_unrounded(n: usize) -> f64 {
    let n = n as f64;
    let alphas = n * 127.0 / 65536.0;
    let floors = n * (n - 1.0) / 2.0 * 255.0 / 16_777_216.0;
    0.5 + alphas + floors + 1e-6
}

/// The largest difference of a channel.
fn difference(a: u32, b: u32) -> u32 {
    [16, 8, 0]
        .map(|shift| (a >> shift & 0xff).abs_diff(b >> shift & 0xff))
        .into_iter()
        .max()
        .unwrap()
}

#[test]
fn what_is_let_through_is_rounded_to_nearest() {
    for a in 0..=255 {
        let exact = (255 - a) * 65536;
        // No tie, since 255 is odd.
        assert!((255 * through(a as u32)).abs_diff(exact) <= 127, "alpha {a}");
    }
    assert_eq!([0, 255].map(through), [65536, 0]);
}

#[test]
fn no_layer_leaves_what_is_below() {
    assert_eq!(colour(&[], 0x123456), 0x123456);
}

#[test]
fn one_layer_is_the_exact_blend() {
    for a in 0..=255_u8 {
        for s in 0..=255_u8 {
            let layers = [layer(5, rgba(s, s, s, a))];
            for c in (0..=255_u8).step_by(3) {
                let below = u32::from_be_bytes([0, c, c.saturating_add(1), c.saturating_add(2)]);
                assert_eq!(colour(&layers, below), exact(&layers, below), "a={a} s={s} c={c}");
            }
        }
    }
}

#[test]
fn two_layers_by_hand() {
    // Alpha 128 lets 127 * 257 = 32639 through and keeps 32897; alpha 64 lets 191 * 257 + 1 = 49088 through
    // and keeps 16448. The far one's weight: 32897 * 256 * 49088 / 65536 = 6307999.75.
    let far = layer(20, rgba(200, 0, 0, 128));
    let near = layer(10, rgba(50, 0, 0, 64));
    assert_eq!(weights(&[far, near]), [6_307_999, 16448 * 256]);
    assert_eq!(weights(&[near, far]), [16448 * 256, 6_307_999]);
    // (6307999 * 200 + 4210688 * 50) / 2^24 = 87.75 over black.
    assert_eq!(colour(&[near, far], 0), 88 << 16);
}

#[test]
fn the_sum_rounds_once_where_the_blend_rounds_twice() {
    // Far: 1 at alpha 128 over black is 0.502, rounded 1. Near: black at alpha 2 leaves 253/255 of that:
    // 0.498 of what was not rounded, but 0.992 of 1.
    let layers = [layer(20, rgba(1, 1, 1, 128)), layer(10, rgba(0, 0, 0, 2))];
    assert_eq!(exact(&layers, 0), 0x010101);
    assert_eq!(colour(&layers, 0), 0);
}

#[test]
fn at_equal_depth_the_later_one_is_nearer() {
    // Alpha 128 keeps 32897 of 65536 for itself and lets 32639 of the earlier one through:
    // 32897 * 256 * 32639 / 65536 = 4194238.996.
    let white = layer(5, rgba(255, 255, 255, 128));
    let black = layer(5, rgba(0, 0, 0, 128));
    assert_eq!(weights(&[white, black]), [4_194_238, 32897 * 256]);
    // 4194238 * 255 / 2^24 = 63.75 and 32897 * 256 * 255 / 2^24 = 128.00.
    assert_eq!(colour(&[white, black], 0), 0x404040);
    assert_eq!(colour(&[black, white], 0), 0x808080);
}

#[test]
fn alpha_zero_changes_nothing() {
    let seen = layer(7, rgba(10, 200, 30, 77));
    let clear = |z| layer(z, rgba(255, 255, 255, 0));
    let alone = colour(&[seen], 0x336699);
    assert_eq!(colour(&[clear(3), seen, clear(9)], 0x336699), alone);
    assert_eq!(weights(&[clear(3), seen, clear(9)])[1], weights(&[seen])[0]);
}

#[test]
fn a_thousand_thin_layers_keep_to_the_bound() {
    // Arrivals near and far in turn.
    let z = |k: u32| if k.is_multiple_of(2) { k } else { 2000 - k };
    let layers: Vec<Layer> = (0..1000).map(|k| layer(z(k), rgba(255, 128, 0, 1))).collect();
    assert!(weights(&layers).iter().sum::<u64>() <= WHOLE);
    for below in [0, 0xffffff] {
        let sum = colour(&layers, below);
        for shift in [16, 8, 0] {
            let difference = f64::from(sum >> shift & 0xff) - unrounded(&layers, below, shift);
            assert!(difference.abs() <= from_unrounded(1000), "bit {shift}: {difference}");
        }
    }
}

#[test]
fn bounds_by_hand() {
    // A layer adds 127/255 + 127/65536 = 1/2 - 0.0000229, and floors n (n-1) * 0.0000076; the sum's own
    // rounding is 1/2. So 4 layers have 2.5 and 5 have 3.00004.
    assert_eq!([0, 1, 2, 3, 4, 5, 6].map(error_bound), [0, 0, 1, 1, 2, 3, 3]);
    // 300 layers: 150.5 - 0.007 + 0.682.
    assert_eq!(error_bound(300), 151);
    assert_eq!([508, 512, u32::MAX].map(error_bound), [255; 3]);
    assert!((0..600).all(|n| error_bound(n) <= error_bound(n + 1)));
}

/// Layers of a pixel, in arrival order: few depths, so that ties are common, or many; thin ones among them,
/// so that many are seen.
fn any_layers() -> impl Strategy<Value = Vec<Layer>> {
    let depths = prop_oneof![Just(3_u32), Just(1000)];
    let thin = prop_oneof![Just(8_u32), Just(255)];
    (depths, thin, prop_oneof![Just(6_usize), Just(60)]).prop_flat_map(|(depths, thin, most)| {
        let layer = (0..depths, 0..1_u32 << 24, 0..thin)
            .prop_map(|(z, colour, a)| layer(z, colour << 8 | a));
        prop::collection::vec(layer, 0..=most)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn it_is_near_the_blend_in_real_numbers(layers in any_layers(), below in 0..1_u32 << 24) {
        prop_assert!(weights(&layers).iter().sum::<u64>() <= WHOLE);
        let sum = colour(&layers, below);
        for shift in [16, 8, 0] {
            let difference = f64::from(sum >> shift & 0xff) - unrounded(&layers, below, shift);
            prop_assert!(difference.abs() <= from_unrounded(layers.len()), "bit {}: {}", shift, difference);
        }
    }

    #[test]
    fn it_is_within_the_bound_of_the_exact_blend(layers in any_layers(), below in 0..1_u32 << 24) {
        let difference = difference(colour(&layers, below), exact(&layers, below));
        prop_assert!(difference <= error_bound(layers.len() as u32), "{}", difference);
    }

    #[test]
    fn the_order_of_arrival_matters_to_floors_alone(
        layers in any_layers(), below in 0..1_u32 << 24, seed: u64,
    ) {
        let mut shuffled = layers.clone();
        // Equal depths keep their order: which of them is nearer depends on it.
        shuffled.sort_by_key(|layer| u64::from(layer.z).wrapping_add(seed).wrapping_mul(seed | 1));
        let n = layers.len() as u64;
        let floors = n * n.saturating_sub(1) / 2;
        let sum = |layers: &[Layer]| weights(layers).iter().sum::<u64>();
        prop_assert!(sum(&layers).abs_diff(sum(&shuffled)) <= floors);
        let apart = difference(colour(&layers, below), colour(&shuffled, below));
        prop_assert!(f64::from(apart) <= 1.0 + floors as f64 * 255.0 / WHOLE as f64);
    }
}
