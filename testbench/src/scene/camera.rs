//! Where the eye is, and how space is mapped to the screen.
//!
//! Space is right-handed with y up. Depth runs from 0 on the near plane to 1 on the far plane; both planes are fitted
//! to the scene, so that the 24 bits of a fragment's depth are spent on what is there.

use glam::{DMat4, DQuat, DVec3, Vec3};
use std::fmt;
use std::str::FromStr;

/// Vertical field of view where none is given, in degrees.
const DEFAULT_FOV: f64 = 40.0;
/// From the mesh towards the automatic eye: the front, from the right and above.
const THREE_QUARTER: DVec3 = DVec3::new(0.55, 0.4, 1.0);
/// Room around a mesh that is fitted into the frame.
const MARGIN: f64 = 1.08;
/// Least ratio of the near plane's distance to the far plane's.
const LEAST_NEAR: f64 = 1e-4;

/// A pinhole camera: `EX,EY,EZ:TX,TY,TZ` or `EX,EY,EZ:TX,TY,TZ:FOV_DEGREES`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    eye: DVec3,
    /// A point in the middle of the picture, not the eye itself.
    target: DVec3,
    /// Vertical field of view in degrees, above 0 and below 180.
    fov: f64,
}

/// A text that is no camera.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
#[error(
    "`{0}` is not a camera: expected EX,EY,EZ:TX,TY,TZ or EX,EY,EZ:TX,TY,TZ:FOV_DEGREES, with finite numbers, \
     a target away from the eye and a field of view between 0 and 180 degrees"
)]
pub struct CameraError(String);

impl fmt::Display for Camera {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Camera { eye, target, fov } = self;
        write!(f, "{},{},{}:{},{},{}:{fov}", eye.x, eye.y, eye.z, target.x, target.y, target.z)
    }
}

impl FromStr for Camera {
    type Err = CameraError;

    fn from_str(text: &str) -> Result<Camera, CameraError> {
        let fields: Vec<&str> = text.split(':').collect();
        let camera = match fields[..] {
            [eye, target] => point(eye).zip(point(target)).zip(Some(DEFAULT_FOV)),
            [eye, target, fov] => point(eye).zip(point(target)).zip(fov.trim().parse().ok()),
            _ => None,
        };
        match camera {
            Some(((eye, target), fov))
                if (target - eye).length() > 0.0 && 0.0 < fov && fov < 180.0 =>
            {
                Ok(Camera { eye, target, fov })
            }
            _ => Err(CameraError(text.into())),
        }
    }
}

/// Three single-precision numbers, the range that a mesh has too.
fn point(text: &str) -> Option<DVec3> {
    let numbers: Vec<f32> =
        text.split(',').map(|number| number.trim().parse().ok()).collect::<Option<_>>()?;
    let point = Vec3::from(<[f32; 3]>::try_from(numbers).ok()?);
    point.is_finite().then(|| point.as_dvec3())
}

/// A camera with its planes: what the pipeline needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// From space to clip coordinates, depth in `0..=w`.
    pub clip: DMat4,
    /// Position of the eye.
    pub eye: DVec3,
    /// Unit vectors to the right, up, and back towards the eye.
    pub axes: [DVec3; 3],
    /// Length of a unit at distance 1 from the eye, in screen heights.
    pub focal: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target` with a vertical field of view of `fov` degrees.
    pub(super) fn new(eye: Vec3, target: Vec3, fov: f64) -> Camera {
        Camera { eye: eye.as_dvec3(), target: target.as_dvec3(), fov }
    }

    /// The camera after going round its target by so many degrees, counter-clockwise as seen from above.
    pub(super) fn turned(self, degrees: f64) -> Camera {
        let turn = DQuat::from_rotation_y(degrees.to_radians());
        Camera { eye: self.target + turn * self.offset(), ..self }
    }

    /// The camera after going so many degrees round its target on a level ellipse, which begins here at an end of its long axis;
    /// the short axis is `across` times as long.
    pub(super) fn on_ellipse(self, degrees: f64, across: f64) -> Camera {
        let (offset, aside) = (self.offset(), self.turned(90.0).offset());
        let (sin, cos) = degrees.to_radians().sin_cos();
        let level = |offset: DVec3| DVec3::new(offset.x, 0.0, offset.z);
        let gone = cos * level(offset) + across * sin * level(aside);
        Camera { eye: self.target + gone.with_y(offset.y), ..self }
    }

    /// The camera at so many times its distance from its target.
    pub(super) fn at_distance(self, factor: f64) -> Camera {
        Camera { eye: self.target + factor * self.offset(), ..self }
    }

    /// The way from the target to the eye.
    pub(super) fn offset(self) -> DVec3 {
        self.eye - self.target
    }

    /// A camera that sees all points with a small margin, in a frame of `aspect` = width / height.
    pub(super) fn framing(points: &[Vec3], aspect: f64) -> Camera {
        let low = points.iter().copied().reduce(Vec3::min).unwrap_or_default().as_dvec3();
        let high = points.iter().copied().reduce(Vec3::max).unwrap_or_default().as_dvec3();
        let target = (low + high) / 2.0;
        let [right, up, back] = axes(THREE_QUARTER);
        let tan = (DEFAULT_FOV / 2.0).to_radians().tan();
        let radius = (high - low).length() / 2.0;
        let distance = points.iter().fold(1.1 * radius, |distance: f64, point| {
            let p = point.as_dvec3() - target;
            let aside = (p.dot(right) / aspect).abs().max(p.dot(up).abs());
            distance.max(p.dot(back) + aside / tan * MARGIN)
        });
        // A single point may be seen from anywhere, but not from nearer than its coordinates can tell apart.
        let distance = if distance > 0.0 { distance } else { target.length().max(1.0) };
        Camera { eye: target + distance * back, target, fov: DEFAULT_FOV }
    }

    /// Fits the near and far plane to the points, in a frame of `aspect` = width / height.
    pub(super) fn view(&self, points: &[Vec3], aspect: f64) -> View {
        let axes = axes(self.eye - self.target);
        let depths = points.iter().map(|point| (self.eye - point.as_dvec3()).dot(axes[2]));
        let (low, high) =
            depths.fold((f64::MAX, 0.0), |(low, high): (f64, f64), d| (low.min(d), high.max(d)));
        let far = if high > 0.0 { high * 1.001 } else { 1.0 };
        let near = (low * 0.999).clamp(far * LEAST_NEAR, far * 0.999);
        let fov = self.fov.to_radians();
        let clip = DMat4::perspective_rh(fov, aspect, near, far)
            * DMat4::look_to_rh(self.eye, -axes[2], axes[1]);
        View { clip, eye: self.eye, axes, focal: 0.5 / (fov / 2.0).tan() }
    }
}

/// The right, up and back unit vectors of an eye in direction `back` from its target, up as near to y as can be.
fn axes(back: DVec3) -> [DVec3; 3] {
    let back = back.normalize();
    let up = if back.y.abs() < 0.9999 { DVec3::Y } else { DVec3::NEG_Z };
    let right = up.cross(back).normalize();
    [right, back.cross(right), back]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn text_names_eye_target_and_field_of_view() {
        let camera =
            Camera { eye: DVec3::new(1.0, 2.0, 3.0), target: DVec3::ZERO, fov: DEFAULT_FOV };
        assert_eq!("1,2, 3:0,0,0".parse(), Ok(camera));
        assert_eq!("1,2,3:0,0,0:60".parse(), Ok(Camera { fov: 60.0, ..camera }));
        assert_eq!(camera.to_string(), "1,2,3:0,0,0:40");
    }

    #[test]
    fn a_bad_text_is_refused_with_what_was_expected() {
        for bad in [
            "",
            "1,2,3",
            "1,2:0,0,0",
            "1,2,3:1,2,3",
            "1,2,3:0,0,nan",
            "1,2,3:0,0,0:180",
            "1,2,3:0,0,0:0",
        ] {
            let error = bad.parse::<Camera>().unwrap_err().to_string();
            assert_eq!(
                error,
                format!(
                    "`{bad}` is not a camera: expected EX,EY,EZ:TX,TY,TZ or EX,EY,EZ:TX,TY,TZ:FOV_DEGREES, with finite \
                     numbers, a target away from the eye and a field of view between 0 and 180 degrees"
                )
            );
        }
    }

    #[test]
    fn a_camera_goes_round_its_target_at_the_same_height() {
        let camera = Camera::new(Vec3::new(5.0, 7.0, 4.0), Vec3::new(2.0, 1.0, 4.0), 30.0);
        let Camera { eye, target, fov } = camera.turned(90.0);
        assert!((eye - DVec3::new(2.0, 7.0, 1.0)).length() < 1e-12, "{eye}");
        assert_eq!((target, fov), (camera.target, camera.fov));
        assert!((camera.turned(360.0).eye - camera.eye).length() < 1e-12);
    }

    proptest! {
        #[test]
        fn framing_sees_every_point(
            points in prop::collection::vec(prop::array::uniform3(-1f32..1.0), 1..9),
            flat in prop::array::uniform3(prop::bool::ANY),
            exponent in -30i32..30,
            aspect in 0.01..100.0,
        ) {
            let scale = 10f32.powi(exponent);
            let squash = Vec3::from(flat.map(|flat| if flat { 0.0 } else { scale }));
            let points: Vec<Vec3> = points.into_iter().map(|p| Vec3::from(p) * squash).collect();
            let view = Camera::framing(&points, aspect).view(&points, aspect);
            for point in points {
                let clip = view.clip * point.as_dvec3().extend(1.0);
                let ndc = clip.truncate() / clip.w;
                prop_assert!(ndc.x.abs() < 0.95 && ndc.y.abs() < 0.95 && 0.0 < ndc.z && ndc.z < 1.0, "{}", ndc);
            }
        }
    }
}
