//! A finished picture: written as PNG, compared with another.

use std::io::Write;
use std::path::Path;

use crate::output::{AtomicFile, OutputError};

/// A picture in rows from the top, pixels from the left.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` colours `0xRRGGBB`; the pixel `x, y` is at `y * width + x`.
    pub pixels: Vec<u32>,
}

/// How far two images are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Pixels that differ in any channel by more than is allowed, or that only one of the images has.
    pub mismatched_pixels: u64,
    /// Largest absolute difference of a channel among them, 0 to 255; 255 for a pixel that only one image
    /// has.
    pub max_error: u32,
    /// `(x, y)` of the first mismatched pixel, row by row from the top.
    pub first: Option<(u32, u32)>,
}

impl Image {
    /// The colour at `x, y` as `0xRRGGBB`, if the image has that pixel.
    pub fn get(&self, x: u32, y: u32) -> Option<u32> {
        if x >= self.width {
            return None;
        }
        let index = u64::from(y) * u64::from(self.width) + u64::from(x);
        self.pixels.get(usize::try_from(index).ok()?).copied()
    }

    /// Images of one width, one below the other.
    pub fn stacked<'a>(images: impl IntoIterator<Item = &'a Image>) -> Image {
        let mut all = Image::default();
        for image in images {
            all.width = image.width;
            all.height += image.height;
            all.pixels.extend(&image.pixels);
        }
        all
    }

    /// Writes the image as PNG, 8-bit RGB without alpha. The file appears when it is complete.
    ///
    /// # Errors
    /// The file cannot be written, or `pixels` does not hold `width * height` colours.
    pub fn write_png(&self, path: &Path) -> Result<(), OutputError> {
        let mut file = AtomicFile::create(path)?;
        self.encode_png(&mut file).map_err(|error| OutputError::write(path, &error.into()))?;
        file.finish()
    }

    /// The same PNG as bytes.
    ///
    /// # Errors
    /// `pixels` does not hold `width * height` colours.
    pub fn png(&self) -> std::io::Result<Vec<u8>> {
        let mut bytes = vec![];
        self.encode_png(&mut bytes)?;
        Ok(bytes)
    }

    fn encode_png(&self, file: &mut impl Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // The default takes more than ten times as long, for an eighth fewer bytes.
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        let bytes: Vec<u8> = self
            .pixels
            .iter()
            .flat_map(|pixel| {
                let [_, r, g, b] = pixel.to_be_bytes();
                [r, g, b]
            })
            .collect();
        writer.write_image_data(&bytes)?;
        writer.finish()
    }

    /// Compares two images pixel by pixel. Their sizes may differ: a pixel that only one has is a mismatch.
    pub fn compare(&self, other: &Image) -> Difference {
        self.compare_within(other, |_, _| 0)
    }

    /// The same, but that a channel of the pixel `x, y` may differ by `allowed(x, y)`.
    pub fn compare_within(&self, other: &Image, allowed: impl Fn(u32, u32) -> u32) -> Difference {
        let mut difference = Difference::default();
        for y in 0..self.height.max(other.height) {
            for x in 0..self.width.max(other.width) {
                let (error, differs) = match (self.get(x, y), other.get(x, y)) {
                    (Some(a), Some(b)) => {
                        let error = pixel_error(a, b);
                        (error, error > 0 && error > allowed(x, y))
                    }
                    (None, None) => (0, false),
                    _ => (255, true),
                };
                if differs {
                    difference.mismatched_pixels += 1;
                    difference.max_error = difference.max_error.max(error);
                    difference.first.get_or_insert((x, y));
                }
            }
        }
        difference
    }
}

/// Largest absolute channel difference of two colours `0xRRGGBB`.
fn pixel_error(a: u32, b: u32) -> u32 {
    if a == b {
        return 0;
    }
    [16, 8, 0]
        .map(|shift| (a >> shift & 0xff).abs_diff(b >> shift & 0xff))
        .into_iter()
        .fold(0, u32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};
    use std::io::BufReader;

    fn image(width: u32, height: u32, pixels: &[u32]) -> Image {
        Image { width, height, pixels: pixels.to_vec() }
    }

    #[test]
    fn equal_images_do_not_differ() {
        let a = image(2, 1, &[0x010203, 0xffffff]);
        assert_eq!(a.compare(&a), Difference::default());
    }

    #[test]
    fn the_largest_channel_and_the_first_pixel_are_named() {
        let a = image(2, 2, &[0, 0x102030, 0, 0x000000]);
        let b = image(2, 2, &[0, 0x102530, 0, 0x010063]);
        // (1,0): green 0x25 - 0x20 = 5. (1,1): red 1, blue 0x63 = 99.
        assert_eq!(
            a.compare(&b),
            Difference { mismatched_pixels: 2, max_error: 99, first: Some((1, 0)) }
        );
        assert_eq!(a.compare(&b), b.compare(&a));
    }

    #[test]
    fn what_is_allowed_is_no_difference() {
        let a = image(2, 2, &[0x000000, 0x000000, 0x000000, 0x000000]);
        let b = image(2, 2, &[0x000100, 0x020000, 0x000003, 0x000400]);
        // Two are allowed on the left, three on the right: (0,1) and (1,1) differ by more.
        assert_eq!(
            a.compare_within(&b, |x, _| 2 + x),
            Difference { mismatched_pixels: 2, max_error: 4, first: Some((0, 1)) }
        );
    }

    #[test]
    fn pixels_of_only_one_image_are_mismatches() {
        // Common is (0,0) alone; a alone has (1,0), b alone has (0,1), neither has (1,1).
        let a = image(2, 1, &[0, 0]);
        let b = image(1, 2, &[0, 0]);
        assert_eq!(
            a.compare(&b),
            Difference { mismatched_pixels: 2, max_error: 255, first: Some((1, 0)) }
        );
    }

    #[test]
    fn png_reads_back_as_eight_bit_rgb() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.png");
        image(2, 2, &[0x010203, 0xfffefd, 0, 0x808182]).write_png(&path).unwrap();
        let mut reader =
            png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (2, 2));
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        assert_eq!(bytes, [1, 2, 3, 255, 254, 253, 0, 0, 0, 128, 129, 130]);
    }

    #[test]
    fn an_image_without_its_pixels_is_refused_and_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.png");
        assert!(image(2, 2, &[0]).write_png(&path).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_named() {
        let error = image(1, 1, &[0]).write_png(Path::new("/dev/full")).unwrap_err();
        assert_eq!(error.to_string(), "cannot write `/dev/full`: No space left on device");
    }
}
