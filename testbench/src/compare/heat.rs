//! A heat map: how many layers lie at each pixel.

use crate::golden::Reference;
use crate::image::Image;

/// Colours from one layer to the most of them, of ever greater lightness: those of matplotlib's map
/// `viridis`, a quarter of it apart.
const SCALE: [[u8; 3]; 5] = [
    [0x44, 0x01, 0x54],
    [0x3b, 0x52, 0x8b],
    [0x21, 0x91, 0x8c],
    [0x5e, 0xc9, 0x62],
    [0xfd, 0xe7, 0x25],
];
/// Where there is no layer.
const NOTHING: u32 = 0xffffff;
/// The most samples of the scale.
const SAMPLES: u32 = 9;

/// The colour `0xRRGGBB` of a pixel with `layers` of at most `most`.
fn colour(layers: u32, most: u32) -> u32 {
    if layers == 0 {
        return NOTHING;
    }
    let position = f64::from(layers - 1) / f64::from(most.max(2) - 1) * 4.0;
    let (k, part) = ((position as usize).min(3), position - f64::from((position as u32).min(3)));
    let mix = |from: u8, to: u8| (f64::from(from) * (1.0 - part) + f64::from(to) * part).round();
    let [r, g, b] = [0, 1, 2].map(|c| mix(SCALE[k][c], SCALE[k + 1][c]) as u32);
    r << 16 | g << 8 | b
}

/// The map.
pub(super) fn map(reference: &Reference) -> Image {
    let most = reference.max_layers;
    let pixels = reference.layers.iter().map(|layers| colour(*layers, most)).collect();
    Image { width: reference.image.width, height: reference.image.height, pixels }
}

/// What some colours of the map mean: layers and colour, from none to the most.
pub(super) fn legend(most: u32) -> Vec<(u32, u32)> {
    let step = most.div_ceil(SAMPLES - 1).max(1) as usize;
    let mut layers: Vec<u32> = (0..=most).step_by(step).collect();
    if layers.last() != Some(&most) {
        layers.push(most);
    }
    layers.into_iter().map(|layers| (layers, colour(layers, most))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_end_to_end_of_the_scale() {
        assert_eq!([0, 1, 3, 5].map(|n| colour(n, 5)), [0xffffff, 0x440154, 0x21918c, 0xfde725]);
        assert_eq!([1, 2].map(|n| colour(n, 2)), [0x440154, 0xfde725]);
        assert_eq!(colour(1, 1), 0x440154);
        // Half way from the first to the second: (0x44 + 0x3b) / 2 is 63.5, and so on.
        assert_eq!(colour(2, 9), 0x402a70);
    }

    #[test]
    fn a_legend_has_both_ends_and_few_lines() {
        let layers = |most| legend(most).into_iter().map(|(layers, _)| layers).collect::<Vec<_>>();
        assert_eq!(layers(0), [0]);
        assert_eq!(layers(3), [0, 1, 2, 3]);
        assert_eq!(layers(17), [0, 3, 6, 9, 12, 15, 17]);
        assert!((0..500).all(|most| layers(most).len() <= 10));
    }
}
