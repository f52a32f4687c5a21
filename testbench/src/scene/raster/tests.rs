//! Coverage against a brute-force oracle, shared edges, depth, perspective and clipping.

use super::*;
use crate::golden::primitive::fragments;
use glam::Vec3;
use proptest::prelude::*;
use std::convert::Infallible;

const SIDE: u32 = 24;

fn raster() -> Raster {
    Raster { width: SIDE, height: SIDE, order: Order::ScanLine, sends_all: false }
}

fn corner((x, y): (i64, i64)) -> Corner {
    Corner { x, y, z: 0.5, inv_w: 1.0, colour_over_w: DVec4::splat(9.0) }
}

/// How often each pixel is covered, row by row.
fn coverage(triangles: &[[(i64, i64); 3]]) -> Vec<u32> {
    let mut counts = vec![0; (SIDE * SIDE) as usize];
    for triangle in triangles {
        let mut sink = |f: Fragment| -> Result<(), Infallible> {
            counts[(f.y * SIDE + f.x) as usize] += 1;
            Ok(())
        };
        if let Some(triangle) = SetUp::new(triangle.map(corner), SIDE, SIDE) {
            let Ok(()) = triangle.draw(Order::ScanLine, &mut sink);
        }
    }
    counts
}

/// Whether the centre of a pixel is inside. Instead of a rule for edges, the centre is moved by an infinitesimal
/// step right and a smaller one down: it is inside where the moved point, never on an edge, is.
fn oracle(triangle: [(i64, i64); 3], pixel: (i64, i64)) -> bool {
    let (px, py) = (i128::from(pixel.0 * 256 + 128), i128::from(pixel.1 * 256 + 128));
    let sides = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
        let [(ax, ay), (bx, by)] =
            [triangle[i], triangle[j]].map(|(x, y)| (i128::from(x), i128::from(y)));
        let at = (bx - ax) * (py - ay) - (by - ay) * (px - ax);
        // The side that the point is on, then the change of it when moving right, then when moving down.
        [at, ay - by, bx - ax].into_iter().map(i128::signum).find(|&sign| sign != 0).unwrap_or(0)
    });
    sides == [1; 3] || sides == [-1; 3]
}

/// Corners on, near and off the screen, many of them on pixel centres and on common lines.
fn point() -> impl Strategy<Value = (i64, i64)> {
    let reach = i64::from(SIDE) * 256;
    let coarse = (-4i64..30, -4i64..30).prop_map(|(x, y)| (x * 256 + 128, y * 256 + 128));
    prop_oneof![coarse, (-reach..2 * reach, -reach..2 * reach)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn coverage_is_that_of_the_oracle(a in point(), b in point(), c in point()) {
        let counts = coverage(&[[a, b, c]]);
        for (at, count) in counts.into_iter().enumerate() {
            let pixel = (at as i64 % i64::from(SIDE), at as i64 / i64::from(SIDE));
            prop_assert_eq!(count, u32::from(oracle([a, b, c], pixel)), "pixel {:?}", pixel);
        }
    }

    #[test]
    fn a_shared_edge_is_drawn_once(a in point(), b in point(), c in point(), d in point()) {
        let side = |p: (i64, i64)| ((b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)).signum();
        // On the other side of the edge: d itself, or its image through the middle of the edge.
        let d = if side(c) * side(d) > 0 { (a.0 + b.0 - d.0, a.1 + b.1 - d.1) } else { d };
        let counts = coverage(&[[a, b, c], [b, a, d]]);
        prop_assert!(counts.iter().all(|&count| count <= 1));
    }

    #[test]
    fn a_fan_around_any_point_covers_the_screen_once(
        x in 0..i64::from(SIDE) * 256,
        y in 0..i64::from(SIDE) * 256,
        on_centre in prop::bool::ANY,
        cuts in prop::collection::vec((0usize..4, 0..i64::from(SIDE) * 256), 0..8),
    ) {
        let hub = if on_centre { (x & !255 | 128, y & !255 | 128) } else { (x, y) };
        let end = i64::from(SIDE) * 256;
        let mut rim: Vec<(usize, i64)> = (0..4).map(|side| (side, 0)).chain(cuts).collect();
        rim.sort_unstable();
        rim.dedup();
        let rim: Vec<(i64, i64)> = rim
            .into_iter()
            .map(|(side, t)| [(t, 0), (end, t), (end - t, end), (0, end - t)][side])
            .collect();
        let fan: Vec<_> = (0..rim.len()).map(|i| [hub, rim[i], rim[(i + 1) % rim.len()]]).collect();
        prop_assert_eq!(coverage(&fan), vec![1; (SIDE * SIDE) as usize]);
    }
}

proptest! {
    #[test]
    fn astronomical_triangles_stay_on_the_screen(
        corners in prop::array::uniform3((prop::array::uniform4(-1.0..1.0), prop::array::uniform4(-80i32..80))),
    ) {
        let triangle = corners.map(|(c, exponents): ([f64; 4], [i32; 4])| {
            std::array::from_fn(|i| c[i] * 10f64.powi(exponents[i]))
        });
        for fragment in drawn(raster(), triangle, [Vec4::splat(99.0); 3]) {
            prop_assert!(fragment.x < SIDE && fragment.y < SIDE && fragment.z < Z_FAR, "{:?}", fragment);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// Most of them are cut by a plane or two.
    #[test]
    fn fragments_are_the_walk_of_the_primitives(
        clips in prop::array::uniform3(prop::array::uniform4(-6.0..6.0)),
        colours in prop::array::uniform3((prop::array::uniform3(0f32..=255.0), prop_oneof![0f32..=255.0, Just(255.0)])),
    ) {
        let colours = colours.map(|(rgb, alpha)| Vec3::from(rgb).extend(alpha));
        let vertices = [0, 1, 2].map(|i| Vertex { clip: clips[i].into(), colour: colours[i] });
        let mut walked = vec![];
        let Ok(()) = raster().set_up(vertices, &mut |primitive| -> Result<(), Infallible> {
            walked.extend(fragments(&primitive, SIDE));
            Ok(())
        });
        let drawn = drawn(raster(), clips, colours);
        prop_assert_eq!(&drawn, &walked);
        if colours.iter().all(|colour| colour.w >= 254.5) {
            prop_assert!(drawn.iter().all(|fragment| fragment.is_opaque()));
        }
        let [low, high] = [Vec4::min, Vec4::max].map(|end| colours.into_iter().reduce(end).unwrap());
        for (channel, shift) in [24, 16, 8].into_iter().enumerate() {
            let range = low[channel] - 1.0..=high[channel] + 1.0;
            let value = |fragment: &Fragment| (fragment.rgba >> shift & 0xff) as f32;
            prop_assert!(drawn.iter().all(|fragment| range.contains(&value(fragment))));
        }
    }
}

fn drawn(raster: Raster, triangle: [[f64; 4]; 3], colours: [Vec4; 3]) -> Vec<Fragment> {
    let mut fragments = Vec::new();
    let mut sink = |fragment| -> Result<(), Infallible> {
        fragments.push(fragment);
        Ok(())
    };
    let vertex = |i: usize| Vertex { clip: DVec4::from(triangle[i]), colour: colours[i] };
    let Ok(()) = raster.draw([vertex(0), vertex(1), vertex(2)], &mut sink);
    fragments
}

#[test]
fn a_triangle_over_the_whole_screen_gives_every_pixel_once() {
    let triangle = [[-1.0, -1.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0]];
    for (width, height) in [(1, 1), (640, 480), (8192, 3)] {
        let fragments =
            drawn(Raster { width, height, ..raster() }, triangle, [Vec4::splat(128.0); 3]);
        assert_eq!(fragments.len() as u32, width * height);
        assert!(fragments.iter().all(|f| f.rgba == 0x80808080 && f.z == Z_FAR / 2));
    }
}

#[test]
fn huge_triangles_cover_the_screen_once_between_them() {
    let far = 1e9;
    let [a, b, c, d] =
        [[-far, -far], [far, -far], [far, far], [-far, far]].map(|[x, y]| [x, y, 0.5, 1.0]);
    let count = |triangle| drawn(raster(), triangle, [Vec4::ZERO; 3]).len() as u32;
    assert_eq!(count([a, b, c]) + count([a, c, d]), SIDE * SIDE);
}

#[test]
fn a_triangle_through_the_eye_is_cut_at_the_near_plane() {
    // A floor that runs from behind the eye to the horizon fills the lower half of the screen.
    let triangle =
        [[-100.0, -1.0, 10.0, 11.0], [100.0, -1.0, 10.0, 11.0], [0.0, -1.0, -20.0, -19.0]];
    let fragments = drawn(raster(), triangle, [Vec4::ZERO; 3]);
    assert!(fragments.len() as u32 > SIDE * SIDE / 4, "{}", fragments.len());
    assert!(fragments.iter().all(|f| f.y >= SIDE / 2 && f.z < Z_FAR));
}

#[test]
fn depth_is_floored_and_the_far_plane_is_nearer_than_a_cleared_buffer() {
    assert_eq!(depth(0.0), 0);
    assert_eq!(depth(-1e-12), 0);
    assert_eq!(depth(1.999 / f64::from(Z_FAR)), 1);
    assert_eq!(depth(1.0), Z_FAR - 1);
    let triangle = |z| [[-1.0, -1.0, z, 1.0], [3.0, -1.0, z, 1.0], [-1.0, 3.0, z, 1.0]];
    assert_eq!(drawn(raster(), triangle(1.0), [Vec4::ZERO; 3]).len() as u32, SIDE * SIDE);
    assert!(drawn(raster(), triangle(1.0 + 1e-9), [Vec4::ZERO; 3]).is_empty());
    assert!(drawn(raster(), triangle(-1e-9), [Vec4::ZERO; 3]).is_empty());
}

/// 1 / w is below what an `f32` holds with all its bits.
#[test]
fn a_mesh_of_any_size_keeps_its_colour() {
    for w in [1e-38, 1.0, 1e38] {
        let triangle = [[-1.0, -1.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0]]
            .map(|v| v.map(|c| c * w));
        let fragments = drawn(raster(), triangle, [Vec4::new(1.0, 102.0, 254.0, 77.0); 3]);
        assert_eq!(fragments.len() as u32, SIDE * SIDE);
        assert!(fragments.iter().all(|f| f.rgba == rgba(1, 102, 254, 77)), "w = {w}");
    }
}

#[test]
fn colour_follows_perspective() {
    // Left edge at w = 1, right edge at w = 3. Half-way across the screen is a quarter of the way in space:
    // (1/2 * 200/3) / (1/2 * 1 + 1/2 * 1/3) = 50.
    let vertices = [
        [-1.0, -1.0, 0.5, 1.0],
        [3.0, -3.0, 1.5, 3.0],
        [-1.0, 1.0, 0.5, 1.0],
        [3.0, 3.0, 1.5, 3.0],
    ];
    let red = |i: usize| {
        if i % 2 == 1 { Vec4::new(200.0, 0.0, 0.0, 255.0) } else { Vec4::W * 255.0 }
    };
    let screen = Raster { width: 101, height: 101, ..raster() };
    let mut middle = Vec::new();
    for corners in [[0, 1, 2], [2, 1, 3]] {
        let fragments = drawn(screen, corners.map(|i| vertices[i]), corners.map(red));
        middle.extend(fragments.into_iter().filter(|f| f.x == 50 && f.y == 50));
    }
    let [fragment] = middle[..] else { panic!("{middle:?}") };
    assert_eq!((fragment.z, fragment.rgba & 0xff_ffff), (depth(0.5), 0xff));
    // A level aside at most: from there on it is straight.
    assert!((49..=51).contains(&(fragment.rgba >> 24)), "{fragment:?}");
}

#[test]
fn a_refusing_receiver_stops_the_triangle() {
    let mut left = 3;
    let mut sink = |_| {
        left -= 1;
        if left == 0 { Err("full") } else { Ok(()) }
    };
    let triangle = [[-1.0, -1.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0]]
        .map(|clip| Vertex { clip: clip.into(), colour: Vec4::ZERO });
    assert_eq!(raster().draw(triangle, &mut sink), Err("full"));
    assert_eq!(left, 0);
}
