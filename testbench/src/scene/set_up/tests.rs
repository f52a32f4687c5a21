//! Set-up against perspective in floats; the hardware's walk against the golden model's closed form; the widths.

use super::*;
use crate::golden::primitive::{bound, fragments};
use crate::scene::{MAX_SIDE, Options, Scene, built_in};
use glam::DVec4;
use pellucid_machine::primitive::{
    HEIGHT_BITS, Span, colour as hw_colour, depth, next_row, plus, span, times,
};
use proptest::prelude::*;
use std::convert::Infallible;
use std::path::Path;

const SIDE: u32 = 24;
/// Coordinates of the guard band on the largest screen.
const FAR: std::ops::RangeInclusive<i64> = {
    let side = MAX_SIDE as i64 * PIXEL;
    -3 * side / 2..=5 * side / 2
};

/// The fragments that an engine gives, by the hardware's functions.
fn walked(primitive: &Primitive, width: u32) -> Vec<Fragment> {
    let (mut fragments, mut rows) = (vec![], *primitive);
    loop {
        let Span { empty, first, last } = span(rows.edges, width);
        let mut at = plus(rows.at, times(rows.per_column, first));
        for x in (first..=last).filter(|_| !empty) {
            let rgba = hw_colour(at, rows.opaque);
            fragments.push(Fragment { x, y: rows.row, z: depth(at), rgba, label: Label::NONE });
            at = plus(at, rows.per_column);
        }
        if rows.row == rows.last_row {
            return fragments;
        }
        rows = next_row(rows);
    }
}

/// A corner of a triangle.
fn corner(x: i64, y: i64, z: f64, inv_w: f64, colour: [f64; 4]) -> Corner {
    Corner { x, y, z, inv_w, colour_over_w: DVec4::from(colour) * inv_w }
}

/// Corners on, near and off the screen, many of them on pixel centres and on common lines.
fn corners() -> impl Strategy<Value = [Corner; 3]> {
    let reach = i64::from(SIDE) * PIXEL;
    let coarse = (-4i64..30, -4i64..30).prop_map(|(x, y)| (centre(x), centre(y)));
    let level = (prop::sample::select(vec![centre(2), centre(9), 2000]), -reach..2 * reach);
    let place = prop_oneof![
        2 => coarse,
        4 => (-reach..2 * reach, -reach..2 * reach),
        1 => level.clone(),
        1 => level.prop_map(|(x, y)| (y, x)),
    ];
    prop::array::uniform3(place).prop_flat_map(coloured)
}

/// The same two corners but for a few 1/256 pixel, and any third one.
fn slivers() -> impl Strategy<Value = [Corner; 3]> {
    let reach = i64::from(SIDE) * PIXEL;
    let place = || (-reach..2 * reach, -reach..2 * reach);
    let sliver = (place(), place(), -3..=3i64, -3..=3i64);
    sliver
        .prop_flat_map(|(a, b, x, y)| coloured([a, b, ((a.0 + b.0) / 2 + x, (a.1 + b.1) / 2 + y)]))
}

/// Corners in the guard band of the largest screen, most of them at its rim.
fn far_corners() -> impl Strategy<Value = [Corner; 3]> {
    let (low, high) = FAR.into_inner();
    let coordinate = prop_oneof![
        3 => prop::sample::select(vec![low, low + 1, high - 1, high]),
        1 => FAR,
        1 => 0..=i64::from(MAX_SIDE) * PIXEL,
    ];
    prop::array::uniform3((coordinate.clone(), coordinate)).prop_flat_map(coloured)
}

fn coloured(places: [(i64, i64); 3]) -> impl Strategy<Value = [Corner; 3]> {
    let channel = || prop_oneof![4 => 0.0..=255.0, 1 => Just(0.0), 1 => Just(255.0)];
    let depth = prop_oneof![4 => 0.0..=1.0, 1 => Just(0.0), 1 => Just(1.0)];
    let alpha = prop_oneof![2 => channel(), 1 => Just(255.0), 1 => 254.0..=255.0];
    let inv_w = prop_oneof![2 => Just(1.0), 1 => 0.9..1.1, 1 => (-12.0..12.0).prop_map(f64::exp)];
    let values = (depth, inv_w, channel(), channel(), channel(), alpha);
    prop::array::uniform3(values).prop_map(move |values| {
        std::array::from_fn(|i| {
            let ((x, y), (z, inv_w, r, g, b, a)) = (places[i], values[i]);
            corner(x, y, z, inv_w, [r, g, b, a])
        })
    })
}

fn set_up(corners: [Corner; 3], side: u32) -> Vec<Primitive> {
    let set_up = SetUp::new(corners, side, side);
    set_up.map_or(vec![], |set_up| set_up.primitives().to_vec())
}

fn drawn(corners: [Corner; 3], order: Order) -> Vec<Fragment> {
    let mut drawn = vec![];
    if let Some(triangle) = SetUp::new(corners, SIDE, SIDE) {
        let Ok(()) = triangle.draw(order, &mut |fragment| -> Result<(), Infallible> {
            drawn.push(fragment);
            Ok(())
        });
    }
    drawn
}

/// A triangle's fragments are those of its primitives, at the centres that are inside, row by row, as deep as a plane in
/// floats but for 1, and of the colour with perspective but for a level; in any other order they are the same.
fn check_fragments(corners: [Corner; 3]) -> Result<(), TestCaseError> {
    let drawn = drawn(corners, Order::ScanLine);
    let primitives = set_up(corners, SIDE);
    let walked: Vec<Fragment> = primitives.iter().flat_map(|p| walked(p, SIDE)).collect();
    prop_assert_eq!(&drawn, &walked);
    for order in Order::ALL {
        let mut others = self::drawn(corners, order);
        others.sort_by_key(|fragment| (fragment.y, fragment.x));
        prop_assert_eq!(&drawn, &others, "{}", order);
    }

    let opaque = corners.iter().all(|corner| corner.colour_over_w.w / corner.inv_w >= 254.5);
    let expected = oracle(corners);
    let places: Vec<_> = expected.iter().map(|(x, y, ..)| (*x, *y)).collect();
    prop_assert_eq!(drawn.iter().map(|f| (f.x, f.y)).collect::<Vec<_>>(), places);
    for (drawn, (.., z, colour)) in drawn.iter().zip(expected) {
        prop_assert_eq!(drawn.is_opaque(), opaque);
        prop_assert!((f64::from(drawn.z) - z).abs() <= 1.0 && drawn.z < Z_FAR, "{drawn:?} {z}");
        for (drawn, channel) in drawn.rgba.to_be_bytes().into_iter().zip(colour.to_array()) {
            prop_assert!((f64::from(drawn) - channel).abs() <= 1.25, "{drawn:?} {colour}");
        }
    }
    Ok(())
}

/// Column, row, depth and colour of each pixel of a triangle: as sums weighted by the areas on the other sides of its centre,
/// of which none is negative and none is 0 but on an edge that is a left or a top one.
fn oracle(mut corners: [Corner; 3]) -> Vec<(u32, u32, f64, DVec4)> {
    let area = |[a, b, c]: [(i64, i64); 3]| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    if area(corners.map(|corner| (corner.x, corner.y))) < 0 {
        corners.swap(1, 2);
    }
    let places = corners.map(|corner| (corner.x, corner.y));
    let whole = area(places);
    let mut pixels = vec![];
    for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
        let parts = [0, 1, 2].map(|i| {
            let (from, to) = (places[(i + 1) % 3], places[(i + 2) % 3]);
            let part = area([from, to, (centre(x.into()), centre(y.into()))]);
            let owned = to.1 < from.1 || to.1 == from.1 && to.0 > from.0;
            (part > 0 || part == 0 && owned).then_some(part as f64 / whole as f64)
        });
        if let [Some(a), Some(b), Some(c)] = parts
            && whole > 0
        {
            let mix = |of: &dyn Fn(&Corner) -> f64| {
                [a, b, c].into_iter().zip(&corners).map(|(part, corner)| part * of(corner)).sum()
            };
            let inv_w: f64 = mix(&|corner| corner.inv_w);
            let colour = [0, 1, 2, 3].map(|k| mix(&|corner| corner.colour_over_w[k]) / inv_w);
            let z: f64 = mix(&|corner| corner.z);
            pixels.push((x, y, (z * f64::from(Z_FAR)).floor(), colour.into()));
        }
    }
    pixels
}

fn check_walk(primitives: Vec<Primitive>) -> Result<(), TestCaseError> {
    for primitive in primitives {
        let expected: Vec<Fragment> = fragments(&primitive, SIDE).collect();
        prop_assert_eq!(walked(&primitive, SIDE), expected);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn a_triangle_has_the_fragments_of_its_primitives(corners in corners()) {
        check_fragments(corners)?;
    }

    #[test]
    fn a_sliver_has_the_fragments_of_its_primitives(corners in slivers()) {
        check_fragments(corners)?;
    }

    #[test]
    fn a_huge_triangle_has_the_fragments_of_its_primitives(corners in far_corners()) {
        check_fragments(corners)?;
    }

    #[test]
    fn a_walk_gives_what_the_closed_form_does(corners in prop_oneof![corners(), slivers()]) {
        check_walk(set_up(corners, SIDE))?;
    }

    #[test]
    fn a_huge_triangle_is_walked_on_a_small_screen(corners in far_corners()) {
        check_walk(set_up(corners, SIDE))?;
    }

    /// On the largest screen, from the first row to the last: columns by the edge functions, and no bound that
    /// is out of its bits.
    #[test]
    fn the_guard_band_of_the_largest_screen_fits_the_widths(corners in far_corners()) {
        let corners = corners.map(|corner| {
            let colour_over_w = corner.colour_over_w / corner.inv_w;
            Corner { inv_w: 1.0, colour_over_w, ..corner }
        });
        let [primitive] = set_up(corners, MAX_SIDE)[..] else { return Ok(()) };
        let Placed { edges, .. } = Placed::new(corners, MAX_SIDE, MAX_SIDE).unwrap();
        let has = |x: u32, y: u32| edges.iter().all(|&(from, to)| {
            let [x, y] = [x, y].map(|pixel| centre(pixel.into()));
            cross(from, to, x, y) >= i64::from(!owns_its_points(from, to))
        });
        let mut rows = primitive;
        for y in primitive.row..=primitive.last_row {
            let Span { empty, first, last } = span(rows.edges, MAX_SIDE);
            let expected = columns(&primitive, y, MAX_SIDE);
            prop_assert_eq!(if empty { 0..0 } else { first..last + 1 }, expected, "row {}", y);
            if !empty {
                prop_assert!(has(first, y) && has(last, y));
                prop_assert!(first == 0 || !has(first - 1, y));
                prop_assert!(last + 1 == MAX_SIDE || !has(last + 1, y));
                for x in [first, last] {
                    let at = plus(rows.at, times(rows.per_column, x));
                    let Fragment { z, rgba, .. } = fragment(&primitive, x, y);
                    prop_assert_eq!((depth(at), hw_colour(at, rows.opaque)), (z, rgba));
                    prop_assert!(z < Z_FAR, "it can be seen");
                }
            }
            for edge in primitive.edges.iter().filter(|edge| edge.side != Side::Level) {
                let range = 1i64 << (BOUND_BITS - 1);
                prop_assert!((-range..range).contains(&bound(edge, y - primitive.row)));
                prop_assert!(edge.rest < edge.height && edge.rest_step < edge.height);
                prop_assert!(edge.height < 1 << (HEIGHT_BITS - 1), "two rests have room");
            }
            rows = next_row(rows);
        }
    }

    #[test]
    fn a_point_is_its_fragment(
        x in 0..SIDE,
        y in 0..SIDE,
        z in prop_oneof![0..Z_FAR, Just(0), Just(Z_FAR - 1), Just(Z_FAR)],
        rgba: u32,
        opaque: bool,
    ) {
        let rgba = if opaque { rgba | 255 } else { rgba };
        let fragment = Fragment { x, y, z, rgba, label: Label::NONE };
        let point = point(fragment);
        prop_assert_eq!(point.opaque, rgba & 255 == 255);
        prop_assert_eq!(fragments(&point, SIDE).collect::<Vec<_>>(), [fragment]);
        prop_assert_eq!(walked(&point, SIDE), [fragment]);
    }
}

#[test]
fn a_point_has_every_alpha() {
    for alpha in 0..=255 {
        let rgba = 0x0180_ff00 | alpha;
        let fragment = Fragment { x: 3, y: 5, z: 7, rgba, label: Label::NONE };
        assert_eq!(walked(&point(fragment), SIDE), [fragment]);
    }
}

/// By hand: 4 pixels wide, 2 high, cut by its diagonal from the lower left; depth grows to the right, and the
/// corners lie on pixel centres.
#[test]
fn a_triangle_by_hand() {
    let at = |x, y, z, alpha| corner(centre(x), centre(y), z, 1.0, [10.0, 20.0, 30.0, alpha]);
    let z = 4.0 / f64::from(Z_FAR);
    let corners = [at(1, 1, 0.0, 255.0), at(5, 1, z, 255.0), at(1, 3, 0.0, 200.0)];
    let [primitive] = set_up(corners, SIDE)[..] else { panic!("it has no perspective") };
    let given: Vec<_> =
        fragments(&primitive, SIDE).map(|f| (f.x, f.y, f.z, f.rgba & 255)).collect();
    assert!(!primitive.opaque);
    assert_eq!((primitive.row, primitive.last_row, primitive.area), (1, 3, 4));
    // The diagonal is a right edge, and no pixel on it is the triangle's: row 3 is empty.
    let expected = [
        (1, 1, 0, 254),
        (2, 1, 1, 254),
        (3, 1, 2, 254),
        (4, 1, 3, 254),
        (1, 2, 0, 228),
        (2, 2, 1, 228),
    ];
    assert_eq!(given, expected);
}

/// What a scene plays in fragments and what it plays in primitives: the same.
fn check_scene(scene: &Scene) {
    let width = scene.info().width;
    let mut drawn = vec![];
    let Ok(()) = scene.play(&mut |fragment| -> Result<(), Infallible> {
        drawn.push(fragment);
        Ok(())
    });
    let mut drawn = drawn.into_iter();
    let Ok(()) = scene.play_primitives(&mut |primitive| -> Result<(), Infallible> {
        for given in walked(&primitive, width) {
            assert_eq!(Some(given), drawn.next());
        }
        Ok(())
    });
    assert_eq!(drawn.len(), 0, "all that are drawn");
}

#[test]
fn every_built_in_scene_has_its_fragments_as_primitives() {
    for scene in built_in() {
        check_scene(&Scene::open(scene.example, &Options::default()).unwrap());
    }
}

#[test]
fn meshes_have_their_fragments_as_primitives() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/meshes"));
    for file in ["dragon_vrip_res4.ply.gz", "dragon_vrip.ply.gz"] {
        let path = folder.join(file);
        if !path.exists() {
            println!("skipped: {file} is not there");
            continue;
        }
        check_scene(&Scene::open(path.to_str().unwrap(), &Options::default()).unwrap());
        // From within, so that triangles are cut.
        let camera = Some("0,0.12,0.01:0,0.12,-1:90".parse().unwrap());
        let options = Options { camera, ..Options::default() };
        check_scene(&Scene::open(path.to_str().unwrap(), &options).unwrap());
    }
}
