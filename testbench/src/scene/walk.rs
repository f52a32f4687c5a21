//! The way of the camera through the frames of a walk-through.

use super::camera::Camera;
use std::fmt;
use std::str::FromStr;

/// How many times farther away than the first view a [`CameraPath::Zoom`] begins, and how many times nearer it ends.
const ZOOM: f64 = 4.0;
/// The short half axis of a [`CameraPath::Ellipse`] over the long one.
const ACROSS: f64 = 0.5;

/// A way of the camera. It looks at the same point from all of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraPath {
    /// A horizontal circle around what it looks at, through the first view, counter-clockwise as seen from above.
    Orbit,
    /// An ellipse instead, of which the first view is at an end of the long axis; the short one is half as long.
    Ellipse,
    /// Straight ahead, from four times the distance of the first view to a quarter of it, by the same factor at each step.
    Zoom,
}

impl CameraPath {
    /// All of them.
    pub const ALL: [CameraPath; 3] = [CameraPath::Orbit, CameraPath::Ellipse, CameraPath::Zoom];

    fn name(self) -> &'static str {
        match self {
            CameraPath::Orbit => "orbit",
            CameraPath::Ellipse => "ellipse",
            CameraPath::Zoom => "zoom",
        }
    }
}

impl fmt::Display for CameraPath {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no path.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
#[error("`{0}` is not a path: expected orbit, ellipse or zoom")]
pub struct CameraPathError(String);

impl FromStr for CameraPath {
    type Err = CameraPathError;

    fn from_str(text: &str) -> Result<CameraPath, CameraPathError> {
        let path = CameraPath::ALL.into_iter().find(|path| path.name() == text);
        path.ok_or_else(|| CameraPathError(text.into()))
    }
}

/// A path, and how many frames see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Walk {
    /// The way.
    pub path: CameraPath,
    /// Frames, at least one. They go once round, so that one more would be the first again; a zoom has both ends.
    pub frames: u32,
}

impl Walk {
    /// The camera of frame `number`, from 0, where `view` is the one that is given or fitted.
    pub(super) fn camera(self, view: Camera, number: u32) -> Camera {
        let [number, frames] = [number, self.frames].map(f64::from);
        let degrees = 360.0 * number / frames;
        match self.path {
            CameraPath::Orbit => view.turned(degrees),
            CameraPath::Ellipse => view.on_ellipse(degrees, ACROSS),
            CameraPath::Zoom => {
                let gone = number / (frames - 1.0).max(1.0);
                view.at_distance(ZOOM.powf(1.0 - 2.0 * gone))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn view() -> Camera {
        "5,7,4:2,1,0:30".parse().unwrap()
    }

    /// Where the eyes are from what is looked at.
    fn offsets(path: CameraPath, frames: u32) -> Vec<DVec3> {
        let walk = Walk { path, frames };
        let offset = |number| walk.camera(view(), number).offset();
        (0..frames).map(offset).collect()
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn an_orbit_is_a_level_circle_in_equal_steps() {
        let eyes = offsets(CameraPath::Orbit, 8);
        assert!((eyes[0] - DVec3::new(3.0, 6.0, 4.0)).length() < 1e-12);
        for (k, eye) in eyes.iter().enumerate() {
            assert!(close(eye.y, 6.0) && close(eye.x.hypot(eye.z), 5.0), "{eye}");
            let step = (eyes[(k + 1) % 8] - *eye).length();
            assert!(close(step, 10.0 * (std::f64::consts::PI / 8.0).sin()), "{step}");
        }
        // Counter-clockwise from above: x goes to where -z was.
        assert!((eyes[2] - DVec3::new(4.0, 6.0, -3.0)).length() < 1e-9, "{}", eyes[2]);
    }

    /// In the axes of the first view, (u / 5)^2 + (v / 2.5)^2 = 1.
    #[test]
    fn an_ellipse_is_half_as_wide_as_long() {
        let eyes = offsets(CameraPath::Ellipse, 12);
        assert!((eyes[0] - DVec3::new(3.0, 6.0, 4.0)).length() < 1e-12);
        for eye in &eyes {
            let (u, v) = (0.6 * eye.x + 0.8 * eye.z, 0.8 * eye.x - 0.6 * eye.z);
            assert!(
                close(eye.y, 6.0) && close((u / 5.0).powi(2) + (v / 2.5).powi(2), 1.0),
                "{eye}"
            );
        }
        assert!((eyes[3] - DVec3::new(2.0, 6.0, -1.5)).length() < 1e-9, "{}", eyes[3]);
        assert!((eyes[6] - DVec3::new(-3.0, 6.0, -4.0)).length() < 1e-9, "{}", eyes[6]);
    }

    #[test]
    fn a_zoom_goes_from_four_times_the_distance_to_a_quarter() {
        let first = DVec3::new(3.0, 6.0, 4.0);
        let eyes = offsets(CameraPath::Zoom, 5);
        for (eye, factor) in eyes.iter().zip([4.0, 2.0, 1.0, 0.5, 0.25]) {
            assert!((*eye - factor * first).length() < 1e-9, "{eye}");
        }
        assert!((offsets(CameraPath::Zoom, 1)[0] - 4.0 * first).length() < 1e-9);
    }

    #[test]
    fn texts_name_paths() {
        for path in CameraPath::ALL {
            assert_eq!(path.to_string().parse(), Ok(path));
        }
        let error = "spiral".parse::<CameraPath>().unwrap_err().to_string();
        assert_eq!(error, "`spiral` is not a path: expected orbit, ellipse or zoom");
    }
}
