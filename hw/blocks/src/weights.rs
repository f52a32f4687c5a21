//! Weight factors in fixed point: how much of a fragment's colour reaches the eye.
//!
//! The weight of a fragment is its alpha times what every nearer fragment of its pixel lets through, in
//! units of 2^-24. It begins as the alpha and is multiplied once for each nearer fragment, in the order of
//! their arrival; each product is cut off, so that a pixel's weights never add up to more than one. What
//! they leave to one is the background's.

use pellucid_sim::rtl;

/// Bits of a weight.
pub const WEIGHT_BITS: u32 = 24;
/// Weight of all that there is.
pub const ONE: u32 = 1 << WEIGHT_BITS;
/// Bits behind the point of what a fragment lets through.
const THROUGH_BITS: u32 = 16;

/// What a fragment of colour `0xRRGGBBAA` lets through: `(255 - a) / 255` in units of 2^-16, rounded to
/// nearest, 0..=65536.
#[inline(always)]
#[rtl]
fn through(rgba: u32) -> u32 {
    let clear = 255 - (rgba & 0xff);
    // A byte twice is that byte times 257.
    (clear << 8 | clear) + (clear >> 7)
}

/// The weight of a transparent fragment of colour `0xRRGGBBAA` that no other hides: its alpha.
#[inline(always)]
#[rtl]
pub fn own_weight(rgba: u32) -> u32 {
    ((1 << THROUGH_BITS) - through(rgba)) << (WEIGHT_BITS - THROUGH_BITS)
}

/// The weight of the farther one of two fragments of a pixel, once the nearer one is taken into account.
#[inline(always)]
#[rtl]
pub fn behind(weight: u32, nearer: u32) -> u32 {
    ((u64::from(weight) * u64::from(through(nearer))) >> THROUGH_BITS) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_let_through_is_rounded_to_nearest() {
        for alpha in 0..=255 {
            let exact = f64::from(255 - alpha) / 255.0 * 65536.0;
            assert!((f64::from(through(0x1234_5600 | alpha)) - exact).abs() <= 0.5, "{alpha}");
        }
    }

    #[test]
    fn a_fragment_and_what_it_lets_through_are_one() {
        for alpha in 0..=255 {
            let whole = own_weight(alpha) + (through(alpha) << (WEIGHT_BITS - THROUGH_BITS));
            assert_eq!(whole, ONE);
        }
    }

    #[test]
    fn alpha_0_hides_nothing_and_alpha_254_nearly_all() {
        assert_eq!((own_weight(0), behind(12_345, 0)), (0, 12_345));
        // 257 of 65536, cut off.
        assert_eq!(behind(ONE - 1, 254), 257 * 256 - 1);
    }
}
