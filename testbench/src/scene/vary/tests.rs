use super::*;
use crate::scene::{Options, Scene, Sequence};
use crate::source::Source;
use pellucid_machine::pixel::Fragment;
use std::convert::Infallible;
use std::fs;
use tempfile::TempDir;

/// Height of the frames; a unit at distance 1 of a camera of 40 degrees has so many pixels.
const SIDE: u32 = 480;

fn per_unit() -> f64 {
    f64::from(SIDE) * 0.5 / 20f64.to_radians().tan()
}

/// Squares that face the viewer, each from -1 to 1 at a depth.
fn squares(depths: &[f64]) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("squares.obj");
    let mut text = String::new();
    for (k, z) in depths.iter().enumerate() {
        let first = 4 * k + 1;
        text += &format!("v -1 -1 {z}\nv 1 -1 {z}\nv 1 1 {z}\nv -1 1 {z}\n");
        text += &format!("f {} {} {} {}\n", first, first + 1, first + 2, first + 3);
    }
    fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap().to_string();
    (folder, path)
}

fn options(camera: Option<&str>, sequence: Option<Varied>) -> Options {
    let camera = camera.map(|camera| camera.parse().unwrap());
    let sequence = sequence.map(Sequence::Varied);
    let (width, height) = (Some(SIDE), Some(SIDE));
    Options { width, height, camera, sequence, ..Options::default() }
}

fn fragments(scene: &Scene) -> Vec<Fragment> {
    let mut fragments = vec![];
    let Ok(()) = scene.play(&mut |fragment| {
        fragments.push(fragment);
        Ok::<(), Infallible>(())
    });
    fragments
}

/// The fragments of every frame of a scene.
fn frames(scene: &str, camera: Option<&str>, vary: Vary, frames: u32) -> Vec<Vec<Fragment>> {
    let first = Scene::open(scene, &options(camera, Some(Varied { vary, frames }))).unwrap();
    let later = (1..frames).map(|k| fragments(&first.later(k).unwrap().unwrap()));
    [fragments(&first)].into_iter().chain(later).collect()
}

fn plain(scene: &str, camera: Option<&str>) -> Vec<Fragment> {
    fragments(&Scene::open(scene, &options(camera, None)).unwrap())
}

/// A block of 2^j numbers in a row, for each binary one of their count, is off by half an interval in all at most.
#[test]
fn the_mean_of_the_points_is_the_middle_to_the_bound_of_their_digits() {
    for points in 1..=1100u32 {
        let all: Vec<DVec2> = (0..points).map(|k| hammersley(k, points)).collect();
        let mean = all.iter().sum::<DVec2>() / f64::from(points) - 0.5;
        let bound = f64::from(points.count_ones()) / f64::from(2 * points);
        assert!(mean.x.abs() < 1e-12, "{points}: {mean}");
        let bound = if points.is_power_of_two() { 0.0 } else { bound };
        assert!(mean.y.abs() <= bound + 1e-12, "{points}: {mean}, {bound}");
        assert!(all.iter().all(|p| p.min_element() > 0.0 && p.max_element() < 1.0), "{points}");
    }
}

/// So it is of a net in base 2: 256 points, and boxes of 2^-k by 2^(k - 8).
#[test]
fn every_box_of_equal_area_has_one_point() {
    let all: Vec<DVec2> = (0..256).map(|k| hammersley(k, 256)).collect();
    for k in 0..=8 {
        let boxes = DVec2::new(f64::from(1 << k), f64::from(256 >> k));
        let mut hit: Vec<(u32, u32)> =
            all.iter().map(|p| ((p.x * boxes.x) as u32, (p.y * boxes.y) as u32)).collect();
        hit.sort_unstable();
        hit.dedup();
        assert_eq!(hit.len(), 256, "{boxes}");
    }
}

#[test]
fn the_disc_has_equal_parts_of_equal_parts_of_the_square() {
    let side = 200;
    let middle = |k: i32| (f64::from(k) + 0.5) / f64::from(side);
    let all: Vec<DVec2> =
        (0..side * side).map(|k| on_disc(DVec2::new(middle(k / side), middle(k % side)))).collect();
    for radius in [0.25, 0.5, 0.9, 1.0] {
        let inside = all.iter().filter(|p| p.length() < radius).count() as f64;
        let share = inside / f64::from(side * side);
        assert!((share - radius * radius).abs() < 0.005, "{radius}: {share}");
    }
    let sector = all.iter().filter(|p| p.y.abs() < p.x * 30f64.to_radians().tan()).count() as f64;
    assert!((sector / f64::from(side * side) - 1.0 / 6.0).abs() < 0.005, "{sector}");
    assert_eq!(on_disc(DVec2::splat(0.5)), DVec2::ZERO);
}

/// One of `aa`, `focus` and `light` is the scene without them, pixel by pixel.
#[test]
fn a_frame_alone_is_the_plain_one() {
    for (scene, vary) in [
        ("teapot", Vary::Aa),
        ("teapot", Vary::Focus),
        ("teapot", Vary::Light),
        ("smoke", Vary::Focus),
        ("rainbow", Vary::Aa),
        ("paper-0", Vary::None),
    ] {
        let size = if scene == "paper-0" { None } else { Some(SIDE) };
        let of = |sequence| {
            let options = Options { width: size, height: size, ..options(None, sequence) };
            fragments(&Scene::open(scene, &options).unwrap())
        };
        assert!(of(Some(Varied { vary, frames: 1 })) == of(None), "{scene}, {vary}");
    }
}

/// Their sides are no whole pixels from the middle: 131.88 from it.
const EYE: &str = "0,0,5:0,0,0";

#[test]
fn sub_pixels_change_edges_alone_and_cover_what_the_shape_does() {
    let (_folder, path) = squares(&[0.0]);
    let count = 64;
    let all = frames(&path, Some(EYE), Vary::Aa, count);
    let half = per_unit() / 5.0;
    let middle = f64::from(SIDE) / 2.0;
    let colour = all[0][0].rgba;
    let mut seen = vec![0u32; (SIDE * SIDE) as usize];
    for frame in &all {
        for f in frame {
            assert_eq!((f.rgba, f.z), (colour, all[0][0].z));
            seen[(f.y * SIDE + f.x) as usize] += 1;
        }
    }
    for (k, seen) in (0..).zip(seen) {
        let away = |at: u32| (f64::from(at) + 0.5 - middle).abs() - half;
        let outside = away(k % SIDE).max(away(k / SIDE));
        // A corner is rounded to 1/256 pixel.
        let edge = 0.5 + 1.0 / 128.0;
        if outside < -edge {
            assert_eq!(seen, count, "pixel {k} is inside");
        } else if outside > edge {
            assert_eq!(seen, 0, "pixel {k} is outside");
        }
    }
    // Each edge is placed to one part in as many as there are frames.
    for axis in [|f: &Fragment| f.x, |f: &Fragment| f.y] {
        let sides = all.iter().map(|frame| {
            let (low, high) = (frame.iter().map(axis).min(), frame.iter().map(axis).max());
            f64::from(high.unwrap() - low.unwrap() + 1)
        });
        let mean = sides.sum::<f64>() / f64::from(count);
        let most = 2.0 / f64::from(count) + 2.0 / 256.0;
        assert!((mean - 2.0 * half).abs() <= most, "{mean}, expected {}", 2.0 * half);
    }
}

/// By e to the right on the lens, what is at w moves by e (1/d - 1/w), in units at distance 1.
#[test]
fn what_is_in_focus_stays_and_the_rest_moves_by_its_distance() {
    let (_folder, path) = squares(&[0.0, -5.0]);
    let count = 16;
    let varied = Varied { vary: Vary::Focus, frames: count };
    let all = frames(&path, Some(EYE), Vary::Focus, count);
    let [near, far] = [0, 1].map(|k| {
        let depth = |frame: &[Fragment]| if k == 0 { frame[0].z } else { frame.last().unwrap().z };
        let of = |frame: &Vec<Fragment>| -> Vec<Fragment> {
            let z = depth(frame);
            frame.iter().copied().filter(|f| f.z == z).collect()
        };
        all.iter().map(of).collect::<Vec<_>>()
    });
    assert!(near.iter().all(|frame| *frame == near[0]) && !near[0].is_empty());
    let half = per_unit() / 10.0;
    let mut places = vec![];
    for (k, frame) in (0..).zip(&far) {
        let lens = varied.sample(k).lens * 5.0 / 40.0;
        let moved = lens * (1.0 / 5.0 - 1.0 / 10.0) * per_unit();
        let left = frame.iter().map(|f| f.x).min().unwrap();
        let top = frame.iter().map(|f| f.y).min().unwrap();
        let middle = f64::from(SIDE) / 2.0;
        // The first centre of a pixel that is not before the edge, whose corners are rounded to 1/256.
        let after = |first: u32, edge: f64| f64::from(first) + 0.5 - edge;
        for (first, edge) in [(left, moved.x), (top, -moved.y)] {
            let after = after(first, middle - half + edge);
            assert!((-0.01..=1.01).contains(&after), "{k}: {first} is {after} after the edge");
        }
        places.push((left, top));
    }
    places.sort_unstable();
    places.dedup();
    assert!(places.len() > 8, "{places:?}");
}

/// Its diffuse part lies between what the light gives from its nearest and its farthest place; 0.3 of its distance is 16.7 degrees.
#[test]
fn a_round_light_changes_colours_alone_by_its_size() {
    let (_folder, path) = squares(&[0.0]);
    let all = frames(&path, Some(EYE), Vary::Light, 64);
    let place = |f: &Fragment| (f.x, f.y, f.z, f.rgba & 0xff);
    let mut greens = vec![];
    for frame in &all {
        assert!(frame.iter().map(place).eq(all[0].iter().map(place)));
        assert!(frame.iter().all(|f| f.rgba == frame[0].rgba));
        greens.push(f64::from(frame[0].rgba >> 16 & 0xff));
    }
    // The light is at (-0.45, 0.75, 0.6) from the square, whose normal is z; it has a green of 0.66.
    let slope = (0.6 / (0.45f64.powi(2) + 0.75f64.powi(2) + 0.36).sqrt()).acos();
    let green = |angle: f64| 255.0 * 0.66 * (0.46 + 0.14 * 0.5 + 0.5 * angle.cos());
    let [most, least] = [-1.0, 1.0].map(|sign| green(slope + sign * 0.3f64.atan()));
    let seen = [f64::min, f64::max].map(|of| greens.iter().copied().reduce(of).unwrap());
    assert!(seen[0] >= least - 0.5 && seen[1] <= most + 0.5, "{seen:?}, {least} to {most}");
    assert!(seen[1] - seen[0] > 0.8 * (most - least), "{seen:?}, {least} to {most}");
}

/// Through half of 3 degrees, each frame in the middle of its part.
#[test]
fn while_the_shutter_is_open_a_scene_turns() {
    let camera: Camera = "3,1,4:0,0.5,0".parse().unwrap();
    let all = frames("teapot", Some("3,1,4:0,0.5,0"), Vary::Motion, 5);
    for (k, frame) in (0..).zip(&all) {
        let turned = camera.turned(1.5 * (f64::from(k) + 0.5) / 5.0);
        let alone = Scene::open("teapot", &Options { camera: Some(turned), ..options(None, None) });
        assert!(*frame == fragments(&alone.unwrap()), "{k}");
    }
    assert!(all[0] != all[4]);
}

#[test]
fn what_does_not_vary_is_refused_and_what_is_repeated_has_no_later_frame() {
    for (scene, vary, expected) in [
        ("paper-0", Vary::Aa, "`paper-0` has nothing that `aa` varies: expected none"),
        (
            "quads-2-9",
            Vary::Focus,
            "`quads-2-9` has nothing that `focus` varies: expected none or aa",
        ),
        (
            "smoke",
            Vary::Light,
            "`smoke` has nothing that `light` varies: expected none, aa or focus",
        ),
        (
            "smoke",
            Vary::Motion,
            "`smoke` has nothing that `motion` varies: expected none, aa or focus",
        ),
    ] {
        let sequence = Some(Sequence::Varied(Varied { vary, frames: 2 }));
        let error = Scene::open(scene, &Options { sequence, ..Options::default() }).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
    for scene in ["paper-0", "smoke", "glass", "panes"] {
        let sequence = Some(Sequence::Varied(Varied { vary: Vary::None, frames: 2 }));
        let opened = Source::open(scene, &Options { sequence, ..Options::default() }).unwrap();
        assert!(opened.later(1).unwrap().is_none(), "{scene}");
    }
}

#[test]
fn flat_scenes_and_smoke_are_sampled_from_where_they_are_alone() {
    for (scene, vary) in [("rainbow", Vary::Aa), ("smoke", Vary::Aa), ("smoke", Vary::Focus)] {
        let all = frames(scene, None, vary, 4);
        assert!(all.iter().all(|frame| *frame != plain(scene, None)), "{scene}, {vary}");
        assert!((1..4).all(|k| all[k] != all[k - 1]), "{scene}, {vary}");
    }
    // Whole pixels stay whole, less than half a pixel aside.
    let pixels = |frame: &Vec<Fragment>| {
        let mut pixels: Vec<_> = frame.iter().map(|f| (f.y, f.x, f.z, f.rgba)).collect();
        pixels.sort_unstable();
        pixels
    };
    let quad = pixels(&plain("quads-1-25", None));
    assert!(frames("quads-1-25", None, Vary::Aa, 8).iter().all(|frame| pixels(frame) == quad));
}

#[test]
fn texts_name_ways_of_varying() {
    for vary in Vary::ALL {
        assert_eq!(vary.to_string().parse(), Ok(vary));
    }
    let error = "blur".parse::<Vary>().unwrap_err().to_string();
    assert_eq!(error, "`blur` does not vary a scene: expected none, aa, focus, motion or light");
}
