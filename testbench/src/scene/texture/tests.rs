use super::*;
use png::{BitDepth, ColorType};
use std::borrow::Cow;

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

/// A PNG of one row, two texels wide.
fn png(kind: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
    sized_png(2, 1, kind, depth, data)
}

fn sized_png(width: u32, height: u32, kind: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(kind);
    encoder.set_depth(depth);
    if kind == ColorType::Indexed {
        encoder.set_palette(Cow::Borrowed(&[9, 8, 7, 255, 0, 0][..]));
        encoder.set_trns(Cow::Borrowed(&[255, 128][..]));
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

fn decoded(bytes: &[u8]) -> Image {
    Encoded::new(bytes).unwrap().expect("a PNG or JPEG").decode().unwrap()
}

fn image(width: u32, height: u32, texels: &[Texel]) -> Image {
    Image::new(Level { width, height, texels: texels.to_vec() })
}

#[test]
fn a_png_of_any_colour_type_is_read() {
    let cases: [(ColorType, BitDepth, &[u8], [Texel; 2]); 7] = [
        (ColorType::Grayscale, BitDepth::Eight, &[3, 4], [[3, 3, 3, 255], [4, 4, 4, 255]]),
        (ColorType::Grayscale, BitDepth::One, &[0x40], [[0, 0, 0, 255], [255; 4]]),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, &[3, 9, 4, 8], [[3, 3, 3, 9], [4, 4, 4, 8]]),
        (ColorType::Rgb, BitDepth::Eight, &[1, 2, 3, 4, 5, 6], [[1, 2, 3, 255], [4, 5, 6, 255]]),
        (ColorType::Rgba, BitDepth::Eight, &[1, 2, 3, 4, 5, 6, 7, 8], [[1, 2, 3, 4], [5, 6, 7, 8]]),
        (
            ColorType::Rgb,
            BitDepth::Sixteen,
            &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0],
            [[1, 2, 3, 255], [4, 5, 6, 255]],
        ),
        (ColorType::Indexed, BitDepth::One, &[0x40], [[9, 8, 7, 255], [255, 0, 0, 128]]),
    ];
    for (kind, depth, data, expected) in cases {
        assert_eq!(decoded(&png(kind, depth, data)).0[0].texels, expected, "{kind:?} {depth:?}");
    }
}

/// Written by Pillow, which reads these values from them.
#[test]
fn a_jpeg_is_read_in_colour_and_grey() {
    let halves = decoded(include_bytes!("halves.jpg"));
    let Level { width, height, texels } = &halves.0[0];
    assert_eq!((*width, *height), (16, 8));
    let near = |texel: Texel, expected: Texel| {
        assert!((0..4).all(|i| texel[i].abs_diff(expected[i]) <= 1), "{texel:?}, {expected:?}");
    };
    near(texels[0], [201, 40, 90, 255]);
    near(texels[8 * 16 - 1], [0, 0, 254, 255]);
    near(decoded(include_bytes!("grey.jpg")).0[0].texels[63], [77, 77, 77, 255]);
}

#[test]
fn what_is_no_image_is_refused() {
    let refused = |bytes: &[u8]| match Encoded::new(bytes) {
        Ok(encoded) => encoded.expect("a PNG or JPEG").decode().unwrap_err(),
        Err(error) => error,
    };
    assert!(Encoded::new(b"RIFF").unwrap().is_none(), "another form");
    let good = png(ColorType::Grayscale, BitDepth::Eight, &[1, 2]);
    let jpeg = include_bytes!("halves.jpg");
    for length in 4..good.len() - 16 {
        assert!(refused(&good[..length]).starts_with("is no valid PNG: "), "{length}");
    }
    for length in 4..jpeg.len() - 2 {
        assert!(refused(&jpeg[..length]).starts_with("is no valid JPEG: "), "{length}");
    }
    let rows = vec![0; 1024 * 8193];
    let large = sized_png(8192, 8193, ColorType::Grayscale, BitDepth::One, &rows);
    assert_eq!(refused(&large), "is 8192 x 8193, expected 1 to 67108864 texels");
}

#[test]
fn an_image_goes_on_as_its_wraps_say() {
    let texels = |wrap: Wrap| [-4, -3, -1, 0, 2, 3, 5, 6].map(|at| wrap.texel(at, 3));
    assert_eq!(
        WRAPS.map(texels),
        [[2, 0, 2, 0, 2, 0, 2, 0], [2, 2, 0, 0, 2, 2, 0, 0], [0, 0, 0, 0, 2, 2, 2, 2]]
    );
}

#[test]
fn a_sample_mixes_the_light_of_four_texels() {
    let [black, white] = [[0, 0, 0, 0], [255; 4]];
    let two = image(2, 1, &[black, white]);
    let at = |u: f32, wrap: Wrap| two.light(Vec2::new(u, 0.7), Vec2::ZERO, [wrap; 2]);
    for wrap in WRAPS {
        assert_eq!(at(0.25, wrap), Vec4::ZERO, "the middle of a texel");
        assert_eq!(at(0.5, wrap), Vec4::splat(0.5), "half of each");
        assert_eq!(at(0.75, wrap), Vec4::ONE);
    }
    // At the left edge the neighbour is the last texel, or the first again.
    assert_eq!(WRAPS.map(|wrap| at(0.0, wrap).x), [0.5, 0.0, 0.0]);
    let four = image(2, 2, &[black, white, white, white]);
    assert_eq!(four.light(Vec2::splat(0.5), Vec2::ZERO, [Wrap::Clamp; 2]), Vec4::splat(0.75));
}

#[test]
fn levels_are_light_and_values_are_as_they_are() {
    let one = image(1, 1, &[[255, 188, 0, 51]]);
    let place = (Vec2::splat(0.3), Vec2::ZERO, [Wrap::Repeat; 2]);
    // 188 is the level of half the light, to the precision of levels.
    assert!(one.light(place.0, place.1, place.2).abs_diff_eq(Vec4::new(1.0, 0.5, 0.0, 0.2), 3e-3));
    assert_eq!(
        one.values(place.0, place.1, place.2),
        Vec4::new(1.0, 188.0 / 255.0, 0.0, 51.0 / 255.0)
    );
}

#[test]
fn a_far_image_is_seen_at_the_level_of_its_footprint() {
    let checker: Vec<Texel> =
        (0..16).map(|i| [[0, 0, 0, 255], [255; 4]][(i + i / 4) % 2]).collect();
    let image = image(4, 4, &checker);
    let at = |footprint: Vec2| image.light(Vec2::splat(0.125), footprint, [Wrap::Repeat; 2]).x;
    assert_eq!(at(Vec2::splat(0.25)), 0.0, "a texel for a pixel: the black one");
    // Two texels for a pixel: the mean of black and white, as near as 8-bit levels have it.
    let grey = decoded_byte(188);
    for footprint in [Vec2::new(0.5, 0.0), Vec2::new(0.1, 0.5), Vec2::splat(9.0), Vec2::INFINITY] {
        assert_eq!(at(footprint), grey, "{footprint}");
    }
    assert_eq!(at(Vec2::NAN), grey);
    let between = at(Vec2::splat(0.25 * 2f32.sqrt()));
    assert!((between - grey / 2.0).abs() < 1e-6, "half-way between two levels: {between}");
}

/// As the coordinates of a texture are that are repeated more often than a number can tell.
#[test]
fn a_sample_at_any_place_is_of_the_texels() {
    let two = image(2, 1, &[[40, 40, 40, 40], [240, 240, 240, 240]]);
    for at in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e20, -3e9] {
        for (place, wrap) in WRAPS.iter().flat_map(|wrap| {
            [Vec2::new(at, 0.5), Vec2::new(0.5, at), Vec2::splat(at)].map(|place| (place, *wrap))
        }) {
            let value = two.values(place, Vec2::splat(at.abs()), [wrap; 2]).x * 255.0;
            assert!((39.9..240.1).contains(&value), "{place} {wrap:?}: {value}");
        }
    }
}

#[test]
fn no_cut_or_changed_byte_makes_a_decoder_panic() {
    let tried = |bytes: &[u8]| {
        let encoded = Encoded::new(bytes).ok().flatten();
        encoded.is_some_and(|encoded| encoded.decode().is_ok())
    };
    let palette = png(ColorType::Indexed, BitDepth::One, &[0x40]);
    let files = [&include_bytes!("halves.jpg")[..], include_bytes!("grey.jpg"), &palette];
    for file in files {
        assert!(tried(file), "as it is");
        for at in 0..file.len() {
            for byte in [0, 1, 0x7f, 0x80, 0xff, file[at] ^ 1, file[at] ^ 0x10] {
                let mut file = file.to_vec();
                file[at] = byte;
                tried(&file);
            }
            tried(&file[..at]);
        }
    }
}
