//! What holds for every scene: options and their messages, fragments on the screen, the same ones at every play.

use super::*;
use crate::golden::Golden;
use crate::source::Source;
use pellucid_machine::pixel::Z_FAR;
use std::convert::Infallible;
use std::path::Path;
use std::time::Instant;

fn fragments(scene: &Scene) -> Vec<Fragment> {
    let mut fragments = Vec::new();
    let Ok(()) = scene.play(&mut |fragment| -> Result<(), Infallible> {
        fragments.push(fragment);
        Ok(())
    });
    fragments
}

fn refused(name: &str, options: &Options) -> String {
    Scene::open(name, options).expect_err("the options are bad").to_string()
}

fn sized(width: u32, height: u32) -> Options {
    Options { width: Some(width), height: Some(height), ..Options::default() }
}

#[test]
fn every_built_in_scene_plays_on_its_screen_and_twice_the_same() {
    for scene in built_in() {
        let scene = Scene::open(scene.example, &Options::default()).unwrap();
        let Screen { width, height, background } = scene.info();
        assert_eq!((width, height), (640, 480));
        assert!(background <= 0xff_ffff && scene.primitives() > 0);
        let played = fragments(&scene);
        assert!(played.len() > 30_000);
        assert!(played.iter().all(|f| f.x < width && f.y < height && f.z < Z_FAR));
        assert!(played == fragments(&scene));
    }
}

#[test]
fn scenes_follow_the_size_asked_for() {
    for (width, height) in [(1, 1), (300, 7), (7, 300), (MAX_SIDE, 2)] {
        for name in ["glass", "teapot", "smoke"] {
            let scene = Scene::open(name, &sized(width, height)).unwrap();
            assert_eq!((scene.info().width, scene.info().height), (width, height));
            assert!(fragments(&scene).iter().all(|f| f.x < width && f.y < height && f.z < Z_FAR));
        }
    }
}

#[test]
fn glass_has_opaque_fragments_that_hide_earlier_transparent_ones() {
    let mut nearest_glass = vec![u32::MAX; 640 * 480];
    let mut hiding = 0;
    for fragment in fragments(&Scene::open("glass", &Options::default()).unwrap()) {
        let glass = &mut nearest_glass[(fragment.y * 640 + fragment.x) as usize];
        match fragment.is_opaque() {
            true => hiding += u32::from(*glass != u32::MAX && fragment.z <= *glass),
            false => *glass = fragment.z.min(*glass),
        }
    }
    assert!(hiding > 500, "{hiding}");
}

#[test]
fn smoke_is_deep() {
    let mut layers = vec![0u32; 640 * 480];
    let played = fragments(&Scene::open("smoke", &Options::default()).unwrap());
    played.iter().for_each(|f| layers[(f.y * 640 + f.x) as usize] += 1);
    assert!((1_000_000..2_500_000).contains(&played.len()), "{}", played.len());
    assert!(layers.iter().filter(|&&layers| layers >= 64).count() > 1000);
    assert!(played.iter().all(|f| (1..255).contains(&(f.rgba & 0xff))));
}

#[test]
fn alpha_rules_reach_the_fragments_by_name_and_in_order() {
    let alphas = ["1", "lid=0.4"].map(|rule| rule.parse().unwrap()).to_vec();
    let scene = Scene::open("teapot", &Options { alphas, ..Options::default() }).unwrap();
    let played = fragments(&scene);
    assert!(played.iter().all(|f| matches!(f.rgba & 0xff, 102 | 255)));
    assert!(played.iter().any(|f| f.is_opaque()) && !played.iter().all(|f| f.is_opaque()));
    let default = fragments(&Scene::open("teapot", &Options::default()).unwrap());
    assert!(default.iter().all(|f| f.rgba & 0xff == 128));
}

/// Triangles, particles and splats, each in another order: the same fragments, and the same image.
#[test]
fn an_order_of_fragments_changes_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let splats = folder.path().join("splats.ply");
    let properties =
        "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
    let properties = properties.split(' ').map(|name| format!("property float {name}\n"));
    let header = "ply\nformat ascii 1.0\nelement vertex 2\n".to_string();
    let text = header
        + &properties.collect::<String>()
        + "end_header\n0 0 0 1 0 0 3 -1 -1 -1 1 0 0 0\n1 1 0 0 1 0 1 0 -1 -2 1 0.3 0 0\n";
    std::fs::write(&splats, text).unwrap();
    for name in ["glass", "smoke", "panes", splats.to_str().unwrap()] {
        let in_order = |order| {
            let options = Options { order: Some(order), ..sized(120, 90) };
            fragments(&Scene::open(name, &options).unwrap())
        };
        let default = fragments(&Scene::open(name, &sized(120, 90)).unwrap());
        let sorted = |fragments: &[Fragment]| {
            let mut fragments: Vec<_> = fragments.iter().map(|f| (f.y, f.x, f.z, f.rgba)).collect();
            fragments.sort_unstable();
            fragments
        };
        let image = |fragments: &[Fragment]| {
            let screen = Screen { width: 120, height: 90, background: 0 };
            Golden::new(screen).of(fragments).unwrap().image
        };
        assert_eq!(in_order(Order::ScanLine), default);
        for order in [Order::Tile8x8, Order::Morton, Order::Quad] {
            let others = in_order(order);
            assert_ne!(others, default, "{name}, {order}");
            assert!(sorted(&others) == sorted(&default), "{name}, {order}");
            assert!(image(&others) == image(&default), "{name}, {order}");
        }
    }
    let options = Options { order: Some(Order::Morton), ..sized(64, 48) };
    let turned = |options| {
        let scene = Scene::open("teapot", options).unwrap();
        fragments(&scene.later(1).unwrap().unwrap())
    };
    assert_ne!(turned(&options), turned(&sized(64, 48)));
}

#[test]
fn scenes_of_triangles_are_seen_from_all_sides() {
    for name in ["glass", "teapot"] {
        let scene = Scene::open(name, &sized(64, 48)).unwrap();
        let turned = |frames| scene.later(frames).unwrap().unwrap();
        assert_ne!(fragments(&turned(1)), fragments(&scene));
        assert!(fragments(&turned(30)).len() > 500);
    }
    for name in ["smoke", "paper-0"] {
        assert!(Scene::open(name, &Options::default()).unwrap().later(1).unwrap().is_none());
    }
}

/// All of them are on the screen, with as many triangles each, and one alone is the scene itself.
#[test]
fn instances_stand_side_by_side_in_view() {
    for name in ["glass", "teapot"] {
        let open = |instances| {
            Scene::open(name, &Options { instances: Some(instances), ..sized(320, 80) }).unwrap()
        };
        let one = Scene::open(name, &sized(320, 80)).unwrap();
        assert!(fragments(&open(1)) == fragments(&one), "{name}");
        let three = open(3);
        assert_eq!(three.primitives(), 3 * one.primitives(), "{name}");
        let [low, high] = one.contents().unwrap().bounds().unwrap();
        let wide = 3.0 * (high[0] - low[0]);
        let [left, right] = three.contents().unwrap().bounds().unwrap();
        assert!((right[0] - left[0] - wide).abs() < 1e-4 * wide, "{name}");
        assert_eq!((left, &right[1..]), (low, &high[1..]), "{name}");
        let columns = |scene: &Scene| {
            let columns: Vec<u32> = fragments(scene).iter().map(|f| f.x).collect();
            (*columns.iter().min().unwrap(), *columns.iter().max().unwrap())
        };
        let (first, last) = columns(&three);
        assert!(0 < first && last < 319 && last - first > 100, "{name}: {first} to {last}");
    }
}

/// The first frame and those after it, each as its camera alone sees it.
#[test]
fn a_walk_goes_its_way_from_the_view_of_the_scene() {
    for path in CameraPath::ALL {
        let walk = Walk { path, frames: 4 };
        let with_walk = Options { sequence: Some(Sequence::Walk(walk)), ..sized(64, 48) };
        let scene = Scene::open("teapot", &with_walk).unwrap();
        let view = Scene::open("teapot", &sized(64, 48)).unwrap().contents().unwrap().camera;
        let source = Source::open("teapot", &with_walk).unwrap();
        let mut seen = vec![];
        for frame in 0..4 {
            let camera = Some(walk.camera(view, frame));
            let alone = Scene::open("teapot", &Options { camera, ..sized(64, 48) }).unwrap();
            let played = match frame {
                0 => fragments(&scene),
                _ => match source.later(frame).unwrap() {
                    Some(Source::Scene(later)) => fragments(&later),
                    _ => panic!("a scene has later frames"),
                },
            };
            assert!(played == fragments(&alone), "{path}, {frame}");
            assert!(!seen.contains(&played), "{path}, {frame}");
            seen.push(played);
        }
    }
}

#[test]
fn bad_options_are_refused_with_a_sentence() {
    let none = Options::default();
    let camera = Options { camera: Some("0,0,1:0,0,0".parse().unwrap()), ..none.clone() };
    let alphas = |rule: &str| Options { alphas: vec![rule.parse().unwrap()], ..Options::default() };
    let instances = |instances| Options { instances: Some(instances), ..Options::default() };
    let walk = Sequence::Walk(Walk { path: CameraPath::Orbit, frames: 3 });
    let walk = Options { sequence: Some(walk), ..Options::default() };
    let cases = [
        (
            "glas",
            none.clone(),
            "unknown scene `glas` (did you mean `glass`?); known are glass, teapot, smoke, plant, panes, triangles, rainbow, \
             sphere-12288, sphere-196608, cube, quads-N-P, paper-0, paper-120, \
             paper-180, paper-240, paper-300, paper-360, paper-420, paper-480, or a file: a mesh \
             (.obj, .ply, .ply.gz, .gltf or .glb) or a trace (.csv or .ptrace)",
        ),
        ("no/such.ply", none, "no/such.ply: no such file"),
        (
            "quads-5-50",
            camera.clone(),
            "scene `quads-5-50` is a list of pixels: a camera cannot be set",
        ),
        ("quads-5-50", alphas("0.5"), "scene `quads-5-50` has no meshes: an alpha cannot be set"),
        ("smoke", instances(2), "scene `smoke` has no meshes: a number of instances cannot be set"),
        ("quads-1-1", walk.clone(), "scene `quads-1-1` has no meshes: a path cannot be set"),
        ("paper-0", walk, "scene `paper-0` has no meshes: a path cannot be set"),
        ("teapot", instances(0), "0 instances are out of range: expected 1..=1000"),
        ("glass", sized(0, 480), "width 0 is out of range: expected 1..=8192"),
        ("glass", sized(640, 8193), "height 8193 is out of range: expected 1..=8192"),
        ("paper-0", sized(800, 480), "scene `paper-0` is always 640x480: width 800 cannot be had"),
        ("paper-0", sized(640, 600), "scene `paper-0` is always 640x480: height 600 cannot be had"),
        (
            "paper-480",
            Options { order: Some(Order::Quad), ..Options::default() },
            "scene `paper-480` is a list of pixels: an order of fragments cannot be set",
        ),
        ("paper-480", camera, "scene `paper-480` is a list of pixels: a camera cannot be set"),
        ("paper-0", alphas("0.5"), "scene `paper-0` has no meshes: an alpha cannot be set"),
        ("smoke", alphas("0.5"), "scene `smoke` has no meshes: an alpha cannot be set"),
        (
            "glass",
            alphas("pane=0.5"),
            "glass: no mesh, group or material is named `pane` (did you mean `panes`?); known are body, bottom, boxes, \
             floor, handle, lid, panes, rim, spheres, spout, teapot",
        ),
    ];
    for (name, options, expected) in cases {
        assert_eq!(refused(name, &options), expected);
    }
    assert!(Scene::open("paper-0", &sized(640, 480)).is_ok());
}

#[test]
fn a_receiver_that_has_enough_stops_every_kind_of_scene() {
    for name in ["glass", "smoke", "paper-0"] {
        let mut left = 10;
        let result = Scene::open(name, &Options::default()).unwrap().play(&mut |_| {
            left -= 1;
            if left == 0 { Err("enough") } else { Ok(()) }
        });
        assert_eq!((result, left), (Err("enough"), 0), "{name}");
    }
}

#[test]
fn the_dragon_is_read_whole() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/meshes"));
    for (file, triangles) in [("dragon_vrip_res4.ply.gz", 11_102), ("dragon_vrip.ply.gz", 871_414)]
    {
        let path = folder.join(file);
        if !path.exists() {
            println!("skipped: {file} is not there");
            continue;
        }
        let start = Instant::now();
        let scene = Scene::open(path.to_str().unwrap(), &Options::default()).unwrap();
        assert_eq!(scene.primitives(), triangles);
        let count = fragments(&scene).len();
        println!("{file}: {count} fragments after {:.2} s", start.elapsed().as_secs_f64());
        assert!(count > 100_000);
    }
}
