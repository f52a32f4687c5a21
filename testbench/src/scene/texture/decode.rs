//! Images as files hold them: PNG and JPEG.

use super::{Image, Level, Texel};
use std::fmt;
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Most texels of an image.
const MOST_TEXELS: usize = 1 << 26;
/// Bytes that a texel takes while it is decoded: coefficients and samples of a JPEG, and what becomes of them.
const TEXEL_BYTES: usize = 16;

/// An image that is not decoded yet.
pub(in super::super) struct Encoded<'a> {
    texels: usize,
    form: Form<'a>,
}

enum Form<'a> {
    Png(Box<png::Reader<Cursor<&'a [u8]>>>),
    Jpeg(Box<JpegDecoder<Cursor<&'a [u8]>>>),
}

impl Encoded<'_> {
    /// The PNG or JPEG that these bytes hold, or nothing if they hold neither. The error says what is wrong with it.
    pub fn new(bytes: &[u8]) -> Result<Option<Encoded<'_>>, String> {
        let (width, height, form) = match bytes {
            [0x89, b'P', b'N', b'G', ..] => {
                let mut decoder = png::Decoder::new(Cursor::new(bytes));
                decoder.set_transformations(png::Transformations::normalize_to_color8());
                let reader = decoder.read_info().map_err(no_png)?;
                let (width, height) = reader.info().size();
                (width as usize, height as usize, Form::Png(Box::new(reader)))
            }
            [0xff, 0xd8, ..] => {
                let options = DecoderOptions::default()
                    .set_strict_mode(true)
                    .jpeg_set_out_colorspace(ColorSpace::RGB);
                let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
                decoder.decode_headers().map_err(no_jpeg)?;
                let (width, height) = decoder.dimensions().ok_or("is a JPEG without a size")?;
                (width, height, Form::Jpeg(Box::new(decoder)))
            }
            _ => return Ok(None),
        };
        match width.checked_mul(height) {
            Some(texels @ 1..=MOST_TEXELS) => Ok(Some(Encoded { texels, form })),
            _ => Err(format!("is {width} x {height}, expected 1 to {MOST_TEXELS} texels")),
        }
    }

    /// Bytes that decoding it takes.
    pub fn bytes(&self) -> usize {
        TEXEL_BYTES * self.texels
    }

    /// Decodes it. The error says what is wrong with it.
    pub fn decode(self) -> Result<Image, String> {
        let level = match self.form {
            Form::Png(mut reader) => {
                let size = reader.output_buffer_size().ok_or("is too large")?;
                let mut data = vec![0; size];
                let info = reader.next_frame(&mut data).map_err(no_png)?;
                let texels = texels(&data, info.color_type.samples());
                Level { width: info.width, height: info.height, texels }
            }
            Form::Jpeg(mut decoder) => {
                let data = decoder.decode().map_err(no_jpeg)?;
                let (width, height) = decoder.dimensions().unwrap_or_default();
                Level { width: width as u32, height: height as u32, texels: texels(&data, 3) }
            }
        };
        match level.texels.len() == self.texels {
            true => Ok(Image::new(level)),
            false => Err(format!("has {} texels, expected {}", level.texels.len(), self.texels)),
        }
    }
}

fn no_png(error: png::DecodingError) -> String {
    format!("is no valid PNG: {error}")
}

fn no_jpeg(error: impl fmt::Display) -> String {
    // The library breaks some of its sentences over lines.
    let what = error.to_string();
    format!("is no valid JPEG: {}", what.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Grey, grey with alpha, colour, or colour with alpha as all four.
fn texels(data: &[u8], channels: usize) -> Vec<Texel> {
    let texel = |texel: &[u8]| match *texel {
        [grey] => [grey, grey, grey, 255],
        [grey, alpha] => [grey, grey, grey, alpha],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    };
    data.chunks_exact(channels).map(texel).collect()
}
