//! The sRGB curve between the light of a colour and the levels that files and screens hold (IEC 61966-2-1).
//!
//! The levels of a frame are sRGB, as those of the images that it is written to: light on a surface and blending work on the
//! levels as they are, as in hardware whose frame buffer knows no curve.

use std::sync::LazyLock;

/// Light of every 8-bit level.
static LIGHT: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|level| decoded(level as f32 / 255.0)));

/// The light of a level, both 0..=1.
pub(super) fn decoded(level: f32) -> f32 {
    if level <= 0.04045 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) }
}

/// The light of an 8-bit level, 0..=1.
pub(super) fn decoded_byte(level: u8) -> f32 {
    LIGHT[usize::from(level)]
}

/// The level of a light, both 0..=1.
pub(super) fn encoded(light: f32) -> f32 {
    match light <= 0.003_130_8 {
        true => light * 12.92,
        // In f64, so that 1 gives 1.
        false => (1.055 * f64::from(light.powf(1.0 / 2.4)) - 0.055) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_light_is_188_and_every_level_comes_back() {
        assert_eq!((encoded(0.0), encoded(1.0), (255.0 * encoded(0.5)).round()), (0.0, 1.0, 188.0));
        assert!((decoded_byte(128) - 0.215_861).abs() < 1e-6);
        for level in 0..=255 {
            assert_eq!((255.0 * encoded(decoded_byte(level))).round(), f32::from(level));
        }
    }
}
