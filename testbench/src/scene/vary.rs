//! Ways in which the frames of a scene differ, so that an image of all of them shows more than each: edges without steps, a lens that
//! is not in focus everywhere, motion, and a light of some size.
//!
//! What varies is sampled by the Hammersley set of as many points as there are frames: frame `k` of `N` is the same whatever plays it,
//! and a single frame is at the middle. Disturbances of a disc are its image by the concentric map of Shirley and Chiu (1997), which
//! keeps areas.

use super::camera::{Camera, View};
use glam::{DMat4, DVec2, DVec3};
use pellucid_machine::pixel::Screen;
use std::f64::consts::FRAC_PI_4;
use std::fmt;
use std::str::FromStr;

/// Radius of the lens, in distances from the eye to the point looked at, where it is in focus.
const LENS_RADIUS: f64 = 1.0 / 40.0;
/// How long the shutter is open, in the time from frame to frame that [`crate::source::Source::later`] has.
const SHUTTER: f64 = 0.5;

/// What varies from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vary {
    /// Nothing: the frame is repeated.
    None,
    /// Where in its pixel a sample is.
    Aa,
    /// Where on the lens a ray goes through; what is as far as the point looked at stays where it is.
    Focus,
    /// When, while the shutter is open: the animation goes on, or the scene turns.
    Motion,
    /// Where on a round light it is lit from.
    Light,
}

impl Vary {
    /// All of them.
    pub const ALL: [Vary; 5] = [Vary::None, Vary::Aa, Vary::Focus, Vary::Motion, Vary::Light];

    fn name(self) -> &'static str {
        match self {
            Vary::None => "none",
            Vary::Aa => "aa",
            Vary::Focus => "focus",
            Vary::Motion => "motion",
            Vary::Light => "light",
        }
    }
}

impl fmt::Display for Vary {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no way of varying.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
#[error("`{0}` does not vary a scene: expected none, aa, focus, motion or light")]
pub struct VaryError(String);

impl FromStr for Vary {
    type Err = VaryError;

    fn from_str(text: &str) -> Result<Vary, VaryError> {
        let vary = Vary::ALL.into_iter().find(|vary| vary.name() == text);
        vary.ok_or_else(|| VaryError(text.into()))
    }
}

/// What varies, and over how many frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Varied {
    /// What varies.
    pub vary: Vary,
    /// Frames, at least one.
    pub frames: u32,
}

impl Varied {
    /// Where frame `number`, from 0, is in what varies.
    pub(super) fn sample(self, number: u32) -> Sample {
        let point = hammersley(number, self.frames);
        let middle = Sample::default();
        match self.vary {
            Vary::None => middle,
            Vary::Aa => Sample { pixel: point - 0.5, ..middle },
            Vary::Focus => Sample { lens: on_disc(point), ..middle },
            Vary::Motion => Sample { gone: SHUTTER * point.x, ..middle },
            Vary::Light => Sample { light: on_disc(point), ..middle },
        }
    }
}

/// Where a frame is in what varies; by default as a scene is alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sample {
    /// How far the scene is moved on the screen, in pixels to the right and down, within half a pixel.
    pub pixel: DVec2,
    /// Where on the lens, in its radii to the right and up.
    pub lens: DVec2,
    /// Time that has gone by, in that from frame to frame.
    pub gone: f64,
    /// Where on the light, in its radii.
    pub light: DVec2,
}

impl Sample {
    /// What the camera sees through this place of its lens, moved by this part of a pixel. What is as far away as the point looked at
    /// is not moved by the lens, nor is any depth.
    pub fn seen(&self, camera: &Camera, view: View, screen: Screen) -> View {
        let distance = camera.offset().length();
        let [right, up, _] = view.axes;
        let lens = LENS_RADIUS * distance * self.lens;
        let aside = lens.x * right + lens.y * up;
        // A unit at the distance of focus, in clip coordinates over w.
        let unit = 2.0 * view.focal / distance * DVec2::new(1.0 / aspect(screen), 1.0);
        let moved = shift(self.pixel, screen) + lens * unit;
        let clip = sheared(moved) * view.clip * DMat4::from_translation(-aside);
        View { clip, eye: view.eye + aside, ..view }
    }
}

/// Width over height.
pub(super) fn aspect(screen: Screen) -> f64 {
    f64::from(screen.width) / f64::from(screen.height)
}

/// So many pixels to the right and down, in clip coordinates over w.
pub(super) fn shift(pixels: DVec2, screen: Screen) -> DVec2 {
    2.0 * pixels * DVec2::new(1.0 / f64::from(screen.width), -1.0 / f64::from(screen.height))
}

/// Moves clip coordinates over w.
pub(super) fn sheared(moved: DVec2) -> DMat4 {
    DMat4 { w_axis: DVec3::new(moved.x, moved.y, 0.0).extend(1.0), ..DMat4::IDENTITY }
}

/// Point `number` of the Hammersley set of so many points in the unit square: the middle of an interval of as many equal ones, and of
/// one of the next power of two of them, by the digits in reverse. Over a power of two points the mean is the middle of the square, over
/// others it is off by at most as many binary ones as their number has, over twice their number.
fn hammersley(number: u32, points: u32) -> DVec2 {
    let bits = points.next_power_of_two().ilog2();
    let reversed = u64::from(number.reverse_bits()) << bits >> u32::BITS;
    let middle = |interval: f64, intervals: f64| (interval + 0.5) / intervals;
    DVec2::new(
        middle(number.into(), points.into()),
        middle(reversed as f64, 2f64.powi(bits as i32)),
    )
}

/// The point of the unit disc for one of the unit square: squares around the middle become circles, in equal parts.
fn on_disc(point: DVec2) -> DVec2 {
    let DVec2 { x, y } = 2.0 * point - 1.0;
    let (radius, angle) = match x.abs() > y.abs() {
        true => (x, FRAC_PI_4 * y / x),
        false if y == 0.0 => return DVec2::ZERO,
        false => (y, FRAC_PI_4 * (2.0 - x / y)),
    };
    radius * DVec2::from_angle(angle)
}

#[cfg(test)]
mod tests;
