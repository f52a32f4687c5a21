//! A plane of sums: the accumulation buffer, and the frame buffer into which frames are blended with 1/N.
//!
//! ```text
//!                  +------+
//!  frame --------->|      |---> image (pixels, with the last frame)
//!  (pixels)        | Sums |
//!                  +------+
//!                   |    ^
//!                   v    |
//!                  plane
//! ```
//! A pixel a cycle; a pixel of the last frame comes out in the cycle after it came in. The first frame takes the place of what is
//! there, so that nothing has to be cleared. As an accumulation buffer it adds colours as they are, and divides the last sum
//! by N, rounded to nearest. As a frame buffer it adds a Nth of each, rounded down, and the last sum is the image.

use crate::colour::{Colour, Format, Pixel};
use pellucid_machine::pixel::Screen;
use pellucid_sim::{
    Block, Memory, Ram1R1W, Read, ReadDuringWrite, Signals, Stream, check_range, rtl,
};

/// See the module's description.
pub struct Sums;

/// Bits of a fraction by which is multiplied where it would be divided.
const RECIPROCAL_BITS: u32 = 32;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Frames of an image (N), 1 to 1024.
    pub frames: u32,
    /// Bits of a channel in the plane, 8 to 24, and as many as the sum takes.
    pub bits: u32,
    /// Frames are blended with 1/N.
    pub blends: bool,
}

impl Config {
    /// The pixels that come, and those of the image.
    pub fn format(&self) -> Format {
        Format { pixel_bits: self.screen.pixel_bits(), channel_bits: 8, closes: true }
    }
    /// 1 / `divisor`, rounded up: a number of up to 20 bits times this is that number divided, rounded down, for divisors up to
    /// 2048, since 2^20 * 2048 is less than 2^`RECIPROCAL_BITS`.
    fn reciprocal(&self, divisor: u32) -> u64 {
        (1u64 << RECIPROCAL_BITS).div_ceil(u64::from(divisor))
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// The pixel whose sum was asked for.
    #[with(cfg.format())]
    pub stage: Stream<Pixel>,
    /// There is a sum.
    pub has_sum: bool,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A pixel of a frame.
    #[with(cfg.format())]
    pub frame: Stream<Pixel>,
    /// Its frame is the first of its image.
    pub opens: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A pixel of the image.
    #[with(cfg.format())]
    pub image: Stream<Pixel>,
    /// A pixel is under way.
    pub busy: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The sums.
    pub plane: Ram1R1W<Colour>,
}

/// What a frame adds to the sum of a channel.
#[inline(always)]
#[rtl]
fn term(cfg: &Config, level: u32) -> u32 {
    if cfg.blends {
        ((u64::from(level) * cfg.reciprocal(cfg.frames)) >> RECIPROCAL_BITS) as u32
    } else {
        level
    }
}

/// The sum of a channel with one more frame.
#[inline(always)]
#[rtl]
fn plus(cfg: &Config, sum: u32, level: u32) -> u32 {
    sum + term(cfg, level)
}

/// The channel of the image that the last sum gives.
#[inline(always)]
#[rtl]
fn scaled(cfg: &Config, sum: u32) -> u32 {
    if cfg.blends {
        sum
    } else {
        // Half a divisor more rounds to nearest.
        let twice = (u64::from(sum) << 1) + u64::from(cfg.frames);
        ((twice * cfg.reciprocal(2 * cfg.frames)) >> RECIPROCAL_BITS) as u32
    }
}

/// The sum with one more frame.
#[inline(always)]
#[rtl]
pub fn sum(cfg: &Config, below: Colour, frame: Colour) -> Colour {
    Colour {
        r: plus(cfg, below.r, frame.r),
        g: plus(cfg, below.g, frame.g),
        b: plus(cfg, below.b, frame.b),
    }
}

/// The image that the last sum gives.
#[inline(always)]
#[rtl]
pub fn image(cfg: &Config, sum: Colour) -> Colour {
    Colour { r: scaled(cfg, sum.r), g: scaled(cfg, sum.g), b: scaled(cfg, sum.b) }
}

/// The sum of the pixel in the stage.
#[inline(always)]
#[rtl]
fn staged(cfg: &Config, q: State, read: Read<Colour>) -> Colour {
    let below = if q.has_sum { read.data } else { Colour { r: 0, g: 0, b: 0 } };
    sum(cfg, below, q.stage.payload.colour)
}

#[rtl(
    output = (),
    check(Sums, crate::test_util::sums(3, false)),
    check(Sums, crate::test_util::sums(3, true))
)]
impl Block for Sums {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the frames of an image", cfg.frames, 1..=1024);
        check_range("the bits of a sum", cfg.bits, 8..=24);
        State { stage: Stream::idle(), has_sum: false }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { plane: Ram1R1W::new(cfg.screen.pixels(), cfg.bits, 1, ReadDuringWrite::Forbidden) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let colour = image(cfg, staged(cfg, *q, m.plane.q()));
        let Pixel { pixel, closes, .. } = q.stage.payload;
        let payload = Pixel { pixel, closes, colour };
        let image = Stream { valid: q.stage.valid && closes, payload };
        Moore { image, busy: q.stage.valid }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) {
        let Pixel { pixel, closes, .. } = q.stage.payload;
        if q.stage.valid && !closes {
            m.plane.write(pixel, staged(cfg, *q, m.plane.q()));
        }
        d.stage = i.frame;
        if i.frame.valid {
            d.has_sum = !i.opens;
            if !i.opens {
                m.plane.read(i.frame.payload.pixel);
            }
        }
    }
}

#[cfg(test)]
mod tests;
