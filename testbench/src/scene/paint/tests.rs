use super::*;
use glam::DVec4;
use proptest::prelude::*;

/// A screen of one pixel, whose centre is in the middle of an edge from w = 1 to w = 3.
#[test]
fn a_place_is_interpolated_with_perspective() {
    let screen = Screen { width: 1, height: 1, background: 0 };
    let corner = |x: f64, y: f64, w: f64| Vertex {
        clip: DVec4::new(x * w, y * w, 0.5 * w, w),
        colour: Vec4::ONE,
    };
    let triangle = [corner(-1.0, 0.0, 1.0), corner(1.0, 0.0, 3.0), corner(0.0, 1.0, 1.0)];
    let Place { weights, right, .. } = Plane::new(&triangle, screen).at(0, 0);
    // Half-way along the edge on the screen the far corner has 1/6 of 1/2 + 1/6.
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!(Vec3::from(found).abs_diff_eq(expected.into(), 1e-6), "{found:?}");
    };
    near(weights, [0.75, 0.25, 0.0]);
    // With t along the edge its weight is t / (3 - 2 t), which changes by 3 / (3 - 2 t)^2.
    near(right, [-0.75, 0.75, 0.0]);
}

#[test]
fn a_triangle_without_area_has_a_place_all_the_same() {
    let screen = Screen { width: 4, height: 4, background: 0 };
    let place = Plane::new(&[Vertex::default(); 3], screen).at(1, 2);
    assert_eq!(place.weights, [1.0, 0.0, 0.0]);
}

#[test]
fn equal_corners_give_exactly_their_value() {
    let third = 1.0 / 3.0;
    assert_eq!(mix([0.1f32; 3], [third, third, third]), 0.1);
    assert_eq!(mix([1.0, 2.0, 4.0], [0.5, 0.25, 0.25]), 2.0);
}

#[test]
fn alpha_counts_as_cutoff_solidity_veil_and_rule_say() {
    let veil = |plain| Some(Veil { plain, image: None });
    let plain = Paint::default();
    let cases = [
        (0.3, plain.clone(), Some(0.3)),
        (0.48, Paint { cutoff: Some(0.5), ..plain.clone() }, None),
        (0.5, Paint { cutoff: Some(0.5), ..plain.clone() }, Some(0.5)),
        (0.5, Paint { cutoff: Some(0.5), is_solid: true, ..plain.clone() }, Some(1.0)),
        (0.48, Paint { cutoff: Some(0.5), alpha: Some(0.9), ..plain.clone() }, None),
        (0.5, Paint { veil: veil(0.5), ..plain.clone() }, Some(0.25)),
        (0.5, Paint { veil: veil(0.5), is_solid: true, ..plain.clone() }, Some(0.5)),
        (0.5, Paint { veil: veil(0.5), alpha: Some(0.9), ..plain }, Some(0.9)),
    ];
    for (alpha, paint, expected) in cases {
        let base = Vec4::new(0.1, 0.2, 0.3, alpha);
        let found = paint.colour(base, (Vec4::ZERO, Vec4::ZERO));
        assert_eq!(found, expected.map(|alpha| base.truncate().extend(alpha)), "{paint:?}");
    }
}

proptest! {
    /// The third corner is where it puts the mean in the middle of the screen; corners may lie behind the eye.
    #[test]
    fn the_mean_of_the_corners_by_their_weights_is_what_the_pixel_shows(
        corners in prop::array::uniform2(prop::array::uniform3(-5.0..5.0)),
        weights in prop::array::uniform3(0.05..1.0),
        w in 0.5..5.0,
    ) {
        let sum: f64 = weights.iter().sum();
        let [of_a, of_b, of_c] = weights.map(|weight: f64| weight / sum);
        let [a, b] = corners.map(|[x, y, w]: [f64; 3]| DVec3::new(x, y, w));
        // Its x and y are 0, its w as drawn.
        let c = (DVec3::new(0.0, 0.0, w) - of_a * a - of_b * b) / of_c;
        prop_assume!(a.cross(b).dot(c).abs() > 0.1);
        let vertex = |at: DVec3| Vertex {
            clip: DVec4::new(at.x, at.y, 0.0, at.z),
            colour: Vec4::ONE,
        };
        let screen = Screen { width: 1, height: 1, background: 0 };
        let found = Plane::new(&[a, b, c].map(vertex), screen).at(0, 0).weights;
        let expected = Vec3::new(of_a as f32, of_b as f32, of_c as f32);
        prop_assert!(Vec3::from(found).abs_diff_eq(expected, 1e-5), "{found:?} {expected}");
    }
}
