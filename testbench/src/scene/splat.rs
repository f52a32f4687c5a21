//! Gaussian splats: ellipsoids that fade from their centre, as they come from photographs of a place.
//!
//! On the screen each is an ellipse whose alpha falls off as a Gaussian, after Zwicker et al. (EWA volume splatting, 2001)
//! in the form of Kerbl et al. (3D Gaussian splatting, 2023): the ellipsoid's covariance goes through the projection's
//! derivative at its centre, and 0.3 pixels squared are added so that none falls between pixels. All of a splat has the
//! depth of its centre. Nothing is sorted: that is the hardware's work.

use super::camera::View;
use super::order::Order;
use super::raster::{depth, packed};
use glam::{DMat3, DVec2, DVec3, Mat3, Quat, Vec3, Vec4};
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_sim::Label;

/// Variance that is added along both axes of the screen, in pixels squared.
const LOW_PASS: f64 = 0.3;
/// The most alpha of a fragment: a splat hides nothing.
const MOST_ALPHA: f64 = 0.99;
/// The least alpha of a fragment.
const LEAST_ALPHA: f64 = 1.0 / 255.0;
/// How far beside the screen, in its half-widths, the derivative of the projection is taken at most.
const MOST_ASIDE: f64 = 1.3;

/// The covariance of an ellipsoid with these standard deviations along axes that are turned so.
pub(super) fn covariance(deviations: Vec3, rotation: Quat) -> Mat3 {
    let axes = Mat3::from_quat(rotation) * Mat3::from_diagonal(deviations);
    axes * axes.transpose()
}

/// A splat on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Column and row of the centre in pixels; the centre of the first pixel is at 0.5.
    centre: DVec2,
    /// Inverse of the covariance: of the columns, of both, of the rows.
    inverse: [f64; 3],
    /// Half of the columns and rows that it has fragments in.
    reach: DVec2,
    /// Red, green, blue, 0..=255, and the alpha of the centre, 0..=1.
    colour: Vec4,
    z: u32,
}

impl Ellipse {
    /// The splat with its centre at `position`, of that covariance and colour, 0..=1, as it is seen; nothing if it is not.
    pub fn new(
        position: Vec3,
        covariance: Mat3,
        colour: Vec4,
        view: &View,
        screen: Screen,
    ) -> Option<Ellipse> {
        let (width, height) = (f64::from(screen.width), f64::from(screen.height));
        let clip = view.clip * position.as_dvec3().extend(1.0);
        let ndc = clip / clip.w;
        let alpha = f64::from(colour.w).min(MOST_ALPHA);
        if !(clip.w > 0.0 && (0.0..=1.0).contains(&ndc.z) && alpha >= LEAST_ALPHA) {
            return None;
        }
        let [right, up, back] = view.axes;
        let to_camera = DMat3::from_cols(right, up, -back).transpose();
        let DVec3 { x, y, z: away } = to_camera * (position.as_dvec3() - view.eye);
        let focal = view.focal * height;
        let aside = |slope: f64, side: f64| {
            let most = MOST_ASIDE * side / 2.0 / focal;
            slope.clamp(-most, most)
        };
        let (slope_x, slope_y) = (aside(x / away, width), aside(y / away, height));
        // How column and row change with the way to the right, up and away.
        let per_column = DVec3::new(focal / away, 0.0, -focal / away * slope_x);
        let per_row = DVec3::new(0.0, -focal / away, focal / away * slope_y);
        let in_camera = to_camera * covariance.as_dmat3() * to_camera.transpose();
        let columns = per_column.dot(in_camera * per_column) + LOW_PASS;
        let both = per_column.dot(in_camera * per_row);
        let rows = per_row.dot(in_camera * per_row) + LOW_PASS;
        let determinant = columns * rows - both * both;
        let inverse = [rows, -both, columns].map(|value| value / determinant);
        // Where alpha is the least that counts.
        let farthest = 2.0 * (alpha / LEAST_ALPHA).ln();
        let centre = DVec2::new((ndc.x + 1.0) / 2.0 * width, (1.0 - ndc.y) / 2.0 * height);
        let reach = DVec2::new((farthest * columns).sqrt(), (farthest * rows).sqrt());
        let is_finite = inverse.iter().all(|value| value.is_finite()) && reach.is_finite();
        let colour = (255.0 * colour.truncate()).extend(alpha as f32);
        (is_finite && centre.is_finite()).then_some(Ellipse {
            centre,
            inverse,
            reach,
            colour,
            z: depth(ndc.z),
        })
    }

    /// Sends the fragments.
    pub fn draw<E>(
        &self,
        screen: Screen,
        order: Order,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let span = |centre: f64, reach: f64, pixels: u32| {
            // Saturating: what lies outside of the screen has no pixel.
            let first = (centre - reach - 0.5).ceil().max(0.0) as u32;
            first..((centre + reach - 0.5).floor() + 1.0).clamp(0.0, f64::from(pixels)) as u32
        };
        let [of_columns, of_both, of_rows] = self.inverse;
        let rows = span(self.centre.y, self.reach.y, screen.height);
        let columns = span(self.centre.x, self.reach.x, screen.width);
        order.runs(rows, |_| columns.clone(), &mut |y, run| {
            for x in run {
                let away = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - self.centre;
                let distance = of_columns * away.x * away.x
                    + 2.0 * of_both * away.x * away.y
                    + of_rows * away.y * away.y;
                let alpha = f64::from(self.colour.w) * (-distance / 2.0).exp();
                if alpha >= LEAST_ALPHA {
                    let rgba = packed(self.colour.truncate().extend(255.0 * alpha as f32));
                    sink(Fragment { x, y, z: self.z, rgba, label: Label::NONE })?;
                }
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests;
