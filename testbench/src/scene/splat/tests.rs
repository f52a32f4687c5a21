//! Splats against the closed form of their ellipse.

use super::*;
use crate::scene::camera::Camera;
use std::convert::Infallible;

/// A screen whose middle is the centre of a pixel.
const SCREEN: Screen = Screen { width: 101, height: 101, background: 0 };
/// Distance of the eye.
const AWAY: f64 = 10.0;

/// The fragments of a splat at the origin with these deviations, turned so, seen from +z at half a screen height
/// for each unit of slope.
fn seen(deviations: Vec3, rotation: Quat, alpha: f32) -> Vec<Fragment> {
    let camera = Camera::new(Vec3::Z * AWAY as f32, Vec3::ZERO, 90.0);
    let view = camera.view(&[Vec3::Z, -Vec3::Z], 1.0);
    let colour = Vec3::new(1.0, 0.2, 0.0).extend(alpha);
    let shape = covariance(deviations, rotation);
    let mut fragments = vec![];
    if let Some(ellipse) = Ellipse::new(Vec3::ZERO, shape, colour, &view, SCREEN) {
        let Ok(()) =
            ellipse.draw(SCREEN, Order::ScanLine, &mut |fragment| -> Result<(), Infallible> {
                fragments.push(fragment);
                Ok(())
            });
    }
    fragments
}

/// The alpha at so many columns and rows from the middle, if there is a fragment.
fn alpha(fragments: &[Fragment], (x, y): (i32, i32)) -> Option<u32> {
    let there = |f: &&Fragment| (f.x as i32 - 50, f.y as i32 - 50) == (x, y);
    fragments.iter().find(there).map(|fragment| fragment.rgba & 0xff)
}

/// Alpha of 255 at a distance, for an opacity and a variance.
fn gaussian(opacity: f64, distance: f64, variance: f64) -> u32 {
    (255.0 * opacity * (-distance * distance / 2.0 / variance).exp()).round() as u32
}

#[test]
fn a_ball_fades_as_a_gaussian_in_all_directions() {
    let fragments = seen(Vec3::splat(0.6), Quat::IDENTITY, 0.8);
    // 50.5 pixels for a slope of 1, the deviation at a slope of 0.06.
    let variance = (0.6 / AWAY * 50.5f64).powi(2) + LOW_PASS;
    for distance in 0..8 {
        let expected = gaussian(0.8, distance.into(), variance);
        for place in [(distance, 0), (-distance, 0), (0, distance), (0, -distance)] {
            assert_eq!(alpha(&fragments, place), Some(expected), "{place:?}");
        }
    }
    assert!(fragments.iter().all(|f| f.rgba >> 8 == 0xff_33_00 && f.z == fragments[0].z));
    // An ellipse ends where alpha is 1/255: 204 = exp(r^2 / 2 / variance).
    let radius = (2.0 * variance * 204f64.ln()).sqrt();
    let inside = |(x, y): (i32, i32)| f64::from(x * x + y * y) <= radius * radius;
    let places = (-50..=50).flat_map(|y| (-50..=50).map(move |x| (x, y)));
    assert_eq!(fragments.len(), places.filter(|place| inside(*place)).count());
}

#[test]
fn an_ellipsoid_is_as_long_as_its_deviations_along_its_turned_axes() {
    let (long, short) = (1.2 / AWAY * 50.5, 0.3 / AWAY * 50.5);
    let along = gaussian(0.5, 3.0, long * long + LOW_PASS);
    let across = gaussian(0.5, 3.0, short * short + LOW_PASS);
    let quarter = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    for (rotation, x, y) in [(Quat::IDENTITY, along, across), (quarter, across, along)] {
        let fragments = seen(Vec3::new(1.2, 0.3, 0.7), rotation, 0.5);
        assert_eq!((alpha(&fragments, (3, 0)), alpha(&fragments, (0, 3))), (Some(x), Some(y)));
    }
    // Turned by an eighth, counter-clockwise: long from the lower left to the upper right.
    let eighth = Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
    let fragments = seen(Vec3::new(1.2, 0.3, 0.7), eighth, 0.5);
    let [up, down] = [(3, -3), (3, 3)].map(|place| alpha(&fragments, place));
    let distance = 18f64.sqrt();
    assert_eq!(up, Some(gaussian(0.5, distance, long * long + LOW_PASS)));
    assert_eq!(down, Some(gaussian(0.5, distance, short * short + LOW_PASS)));
}

#[test]
fn a_splat_hides_nothing_and_one_that_is_all_but_clear_is_not_seen() {
    let fragments = seen(Vec3::splat(0.6), Quat::IDENTITY, 1.0);
    assert_eq!(alpha(&fragments, (0, 0)), Some(252), "0.99 of 255");
    assert!(seen(Vec3::splat(0.6), Quat::IDENTITY, 0.003).is_empty());
    assert_eq!(
        seen(Vec3::ZERO, Quat::IDENTITY, 0.5).len(),
        9,
        "a point is 0.3 pixels squared wide"
    );
}
