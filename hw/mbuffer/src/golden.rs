//! The golden model of the M-buffer's weighted sum, in plain software. It shares no line with the hardware.
//!
//! Fragments are not sorted. Each has a weight, an integer in units of 2^-24: its own alpha times what
//! every nearer fragment of the pixel lets through. The rules are these, per pixel, for the fragments that
//! count.
//!
//! 1. What a fragment of alpha `a` lets through is `(255-a) / 255` in units of 2^-16, rounded to nearest.
//!    Its alpha is the rest of 2^16.
//! 2. Fragments come in arrival order. The weight of each starts as its alpha; then it is compared with
//!    each earlier one, in their order. The nearer of the two lessens the other's weight to what it lets
//!    through of it, rounded down; at equal depth the later one is the nearer.
//! 3. The colour is the sum of all colours by their weights, with what is left of 2^24 for the opaque
//!    colour, rounded to nearest.
//!
//! The weights of a pixel never exceed 2^24 together. In real numbers they and what all fragments let
//! through add up to one, whatever the alphas are, if each is one less what its fragment lets through; so
//! the weights alone are one at most, and rounding down only lessens them.
//!
//! A pixel with n fragments takes `n (n-1) / 2` steps.

use pellucid_machine::Arithmetic;
use pellucid_machine::arithmetic::Layer;

/// The weighted sum: close to the exact blend, not equal to it.
pub const WEIGHTED_SUM: Arithmetic =
    Arithmetic { name: "weighted sum", colour: Some(colour), shading: None, error_bound };

/// One, as what is let through: 2^16.
const ALL_THROUGH: u64 = 1 << 16;
/// One, as a weight: 2^24.
const WHOLE: u64 = 1 << 24;

/// What a colour `0xRRGGBBAA` lets through, in units of 2^-16: `x / 255` rounded to nearest, for
/// `x = 255 - a`. That is `257 x + x / 255`, since 2^16 is 257 times 255 and one more.
fn through(rgba: u32) -> u64 {
    let x = u64::from(255 - (rgba & 0xff));
    x * 257 + (x >> 7)
}

/// The weights of a pixel's layers, which are in arrival order.
fn weights(layers: &[Layer]) -> Vec<u64> {
    let mut weights: Vec<u64> = Vec::with_capacity(layers.len());
    for new in layers {
        let mut own = (ALL_THROUGH - through(new.rgba)) << 8;
        for (weight, earlier) in weights.iter_mut().zip(layers) {
            // A weight has 25 bits and what is let through 17: their product is 2^40 at most.
            if new.z <= earlier.z {
                *weight = (*weight * through(new.rgba)) >> 16;
            } else {
                own = (own * through(earlier.rgba)) >> 16;
            }
        }
        weights.push(own);
    }
    weights
}

/// The colour `0xRRGGBB` of a pixel: its layers, in arrival order, over `below`.
pub fn colour(layers: &[Layer], below: u32) -> u32 {
    let weights = weights(layers);
    let rest = WHOLE - weights.iter().sum::<u64>();
    [16, 8, 0].into_iter().fold(0, |colour, shift| {
        let byte = |rgb: u32| u64::from(rgb >> shift & 0xff);
        let terms =
            weights.iter().zip(layers).map(|(weight, layer)| weight * byte(layer.rgba >> 8));
        let sum = terms.sum::<u64>() + rest * byte(below);
        colour << 8 | ((sum + WHOLE / 2) >> 24) as u32
    })
}

/// How far a channel of the weighted sum may be from the exact blend in a pixel with `layers` layers, in
/// levels, 0 to 255.
///
/// With n layers, both are near the blend in real numbers, without any rounding.
///
/// - The exact blend rounds n times. A division by 255 rounds by 127/255 at most, and later layers let
///   through no more than all of that: it is within `n * 127/255`.
/// - What a fragment lets through is rounded by 127/255 of 2^-16 at most. The blend is linear in it, with a
///   slope of 255 levels at most, and stays a blend while one fragment after the other is changed to its
///   rounded value: that makes `n * 127 / 2^16`.
/// - Weights are rounded down once for each pair of fragments, by less than 2^-24. What they lack goes to
///   the opaque colour, which is 255 levels away at most: that makes `n (n-1) / 2 * 255 / 2^24`.
/// - The sum is rounded once, by 1/2.
///
/// The bound is the sum of these, rounded down, since levels are whole: 0 for one layer, 1 for two or
/// three.
pub fn error_bound(layers: u32) -> u32 {
    // With 512 layers it is above 255 already, and it only grows.
    let n = u64::from(layers.min(512));
    // All in units of 1 / (255 * 2^25).
    let blend = (n * 127) << 25;
    let alphas = (n * 127 * 255) << 9;
    let floors = n * n.saturating_sub(1) * 255 * 255;
    let rounding = 255 << 24;
    let bound = (blend + alphas + floors + rounding) / (255 << 25);
    bound.min(255) as u32
}

#[cfg(test)]
mod tests;
