//! Several frames in one run.

use super::*;

const FIVE: [&str; 2] = ["--frames", "5"];

#[test]
fn each_frame_has_an_image_and_figures_are_of_all() {
    let folder = folder();
    for arch in ["tbuffer", "rbuffer", "mbuffer"] {
        let args = ["--arch", arch, "--out", arch, "--no-wave"];
        let output = exact(run(folder.path(), &[&FIVE[..], &args].concat()));
        let text = stdout(&output);
        assert!(text.starts_with("Each of the 5 images equals the golden model"), "{text}");
        assert!(text.contains("image-000.png") && text.contains("image-004.png"), "{text}");
        let out = folder.path().join(arch);
        let images: Vec<String> = (0..5).map(|frame| format!("image-00{frame}.png")).collect();
        assert_eq!(names(&out)[..5], images);
        assert_eq!(names(&out)[5..], ["stats.csv", "stats.json"]);
        let one = ["--arch", arch, "--out", "one", "--no-wave", "--quiet"];
        exact(run(folder.path(), &one));
        let image = |path: &str| fs::read(folder.path().join(path)).unwrap();
        assert!(image("one/image.png") == image(&format!("{arch}/image-000.png")));
        assert!(image("one/image.png") != image(&format!("{arch}/image-001.png")));
        let (all, first) = (stats(&out), stats(&folder.path().join("one")));
        assert_eq!((&all["frame"]["frames"], &first["frame"]["frames"]), (&5.into(), &1.into()));
        for (group, figure) in [("frame", "fragments"), ("cycles", "store"), ("accesses", "seed")] {
            let [all, first] = [&all, &first].map(|stats| stats[group][figure].as_u64().unwrap());
            assert!((4 * first..6 * first).contains(&all), "{arch} {figure}: {first}, then {all}");
        }
        let pixels = |stats: &Value| -> u64 {
            let histogram = stats["frame"]["layer_histogram"].as_array().unwrap();
            histogram.iter().map(|pixels| pixels.as_u64().unwrap()).sum()
        };
        assert_eq!((pixels(&all), pixels(&first)), (5 * 1200, 1200));
    }
}

/// What is counted of each frame is what is counted of the run, if it is added up: for every architecture, and one with several
/// frames under way.
#[test]
fn figures_of_frames_add_up_to_those_of_the_run() {
    let folder = folder();
    for arch in ["tbuffer", "rbuffer", "mbuffer", "composer"] {
        let args = ["--arch", arch, "--no-wave", "--json"];
        let output = exact(run(folder.path(), &[&FIVE[..], &args].concat()));
        let all: Value = serde_json::from_str(stdout(&output)).unwrap();
        let frames = all["frames"].as_array().unwrap();
        assert_eq!(frames.len(), 5);
        let number = |value: &Value| value.as_u64().unwrap();
        let sum = |of: &dyn Fn(&Value) -> u64| -> u64 { frames.iter().map(of).sum() };
        for name in ["fragments", "opaque", "transparent", "culled", "transparent_pixels"] {
            assert_eq!(sum(&|f| number(&f[name])), number(&all["frame"][name]), "{arch}, {name}");
        }
        assert_eq!(sum(&|f| number(&f["stored"])), number(&all["fragments"]["stored"]), "{arch}");
        let cycles = frames[0]["cycles"].as_object().unwrap();
        assert!(cycles.contains_key("total") && cycles.len() > 2, "{arch}: {cycles:?}");
        for phase in cycles.keys() {
            let of_frames = sum(&|f| number(&f["cycles"][phase]));
            assert_eq!(of_frames, number(&all["cycles"][phase]), "{arch}, {phase}");
        }
        for frame in frames {
            assert!(
                number(&frame["cycles"]["store"]) >= number(&frame["fragments"])
                    || arch == "composer"
            );
        }
        let csv = fs::read_to_string(folder.path().join("pellucid-out/stats.csv")).unwrap();
        let line = format!("\nframes.4.cycles.total,{},cycles,", frames[4]["cycles"]["total"]);
        assert!(csv.contains(&line), "{arch}: {line}");
    }
}

#[test]
fn a_path_and_instances_are_played() {
    let folder = folder();
    for path in ["orbit", "ellipse", "zoom"] {
        let args = ["--path", path, "--frames", "3", "--scene", "teapot", "--instances", "2"];
        let output =
            exact(run(folder.path(), &[&args[..], &["--no-wave", "--out", path]].concat()));
        assert!(stdout(&output).starts_with("Each of the 3 images equals the golden model"));
        let image =
            |k: u32| fs::read(folder.path().join(format!("{path}/image-00{k}.png"))).unwrap();
        assert!(image(0) != image(1) && image(1) != image(2), "{path}");
    }
    exact(run(folder.path(), &["--scene", "teapot", "--instances", "2", "--no-wave", "--quiet"]));
    let image = |path: &str| fs::read(folder.path().join(path)).unwrap();
    assert!(image("orbit/image-000.png") == image("pellucid-out/image.png"));
    // From far away to near.
    let frames = stats(&folder.path().join("zoom"))["frames"].clone();
    let pixels: Vec<u64> = frames
        .as_array()
        .unwrap()
        .iter()
        .map(|frame| frame["transparent_pixels"].as_u64().unwrap())
        .collect();
    assert!(pixels[0] < pixels[1] && pixels[1] < pixels[2], "{pixels:?}");
}

#[test]
fn paths_and_instances_are_checked() {
    let folder = folder();
    exact(pellucid(folder.path(), &[&["trace", "--out", "t.csv"], &SMALL[..]].concat()));
    let trace = |what: &str| {
        format!("`t.csv` is a trace: {what} cannot be set, a trace has its own pixels")
    };
    let cases: &[(&[&str], String)] = &[
        (&["--scene", "t.csv", "--path", "orbit"], trace("a path")),
        (&["--scene", "t.csv", "--instances", "2"], trace("a number of instances")),
        (
            &["--scene", "smoke", "--path", "zoom"],
            "scene `smoke` has no meshes: a path cannot be set".into(),
        ),
        (
            &["--path", "spiral"],
            "invalid value 'spiral' for '--path <PATH>': `spiral` is not a path: expected orbit, ellipse or zoom"
                .into(),
        ),
        (
            &["--instances", "0"],
            "invalid value '0' for '--instances <INSTANCES>': expected a whole number from 1 to 1000".into(),
        ),
    ];
    for (args, message) in cases {
        refused(folder.path(), &[&["run", "--frames", "2"], *args].concat(), message);
    }
    assert_eq!(names(folder.path()), ["t.csv"]);
}

/// As a scene and as a trace, for machines of every kind: the image stays, and an early depth test lets nothing through that does
/// not count.
#[test]
fn with_what_is_opaque_first_the_image_stays() {
    let folder = folder();
    exact(pellucid(folder.path(), &[&["trace", "--out", "t.ptrace"], &SMALL[..]].concat()));
    let image = |out: &str| fs::read(folder.path().join(out).join("image.png")).unwrap();
    for arch in ["tbuffer", "rbuffer", "mbuffer", "composer"] {
        let run = |scene: &str, out: &str, more: &[&str]| {
            let size: &[&str] = if scene == "glass" { &SMALL } else { &[] };
            let args =
                ["run", "--arch", arch, "--scene", scene, "--out", out, "--no-wave", "--quiet"];
            exact(pellucid(folder.path(), &[&args, size, more].concat()));
            stats(&folder.path().join(out))["fragments"].clone()
        };
        for scene in ["glass", "t.ptrace"] {
            let mixed = run(scene, "mixed", &[]);
            let first = run(scene, "first", &["--opaque-first"]);
            assert!(image("mixed") == image("first"), "{arch}, {scene}");
            assert_eq!(mixed["blended"], first["blended"], "{arch}, {scene}");
            assert_eq!(first["stored"], first["blended"], "{arch}, {scene}");
            // The composer merges what is opaque before it stores what is transparent, in any case.
            let stored = mixed["stored"].as_u64() > mixed["blended"].as_u64();
            assert!(stored == (arch != "composer"), "{arch}, {scene}");
        }
    }
}

/// All the way round, the scene looks as it did.
#[test]
fn the_camera_goes_three_degrees_round_from_frame_to_frame() {
    let folder = folder();
    let args = ["--frames", "121", "--scene", "teapot", "--no-wave", "--quiet"];
    exact(pellucid(
        folder.path(),
        &[&["run", "--width", "16", "--height", "12"], &args[..]].concat(),
    ));
    let image = |frame: u32| {
        fs::read(folder.path().join(format!("pellucid-out/image-{frame:03}.png"))).unwrap()
    };
    assert!(image(0) == image(120) && image(0) != image(60));
}

#[test]
fn a_run_of_frames_has_a_waveform() {
    let folder = folder();
    exact(run(folder.path(), &[&FIVE[..], &["--wave", "resolve"]].concat()));
    assert!(folder.path().join("pellucid-out/wave.vcd").is_file());
}

#[test]
fn a_number_of_frames_and_what_can_have_it_are_checked() {
    let folder = folder();
    let expected = "expected a whole number from 1 to 1024";
    for frames in ["0", "1025", "-1", "many"] {
        let message = format!("invalid value '{frames}' for '--frames <FRAMES>': {expected}");
        refused(folder.path(), &["run", "--frames", frames], &message);
    }
    exact(pellucid(folder.path(), &[&["trace", "--out", "t.csv"], &SMALL[..]].concat()));
    for scene in ["smoke", "paper-0", "t.csv"] {
        let message = format!(
            "`{scene}` is one frame alone, 2 are asked for: expected a scene whose camera can go round it, `glass`, \
             `teapot`, `plant` or a mesh, or vary `none`, which repeats the frame"
        );
        refused(folder.path(), &["run", "--frames", "2", "--scene", scene], &message);
    }
    assert_eq!(names(folder.path()), ["t.csv"]);
}

/// What is recorded plays as it did: images, and what was counted, of each frame and of all.
#[test]
fn a_recorded_sequence_plays_as_the_live_one() {
    let folder = folder();
    let run = |out: &str, args: &[&str]| {
        exact(pellucid(
            folder.path(),
            &[&["run", "--no-wave", "--quiet", "--out", out], args].concat(),
        ));
        stats(&folder.path().join(out))
    };
    let image = |out: &str, k: u32| {
        fs::read(folder.path().join(out).join(format!("image-00{k}.png"))).unwrap()
    };
    for sequence in [&["--vary", "aa"], &["--vary", "focus"], &["--path", "orbit"]] {
        let sequence = [&SMALL[..], &["--frames", "3"], sequence].concat();
        for trace in ["t.csv", "t.ptrace"] {
            let out = ["trace", "--quiet", "--out", trace];
            exact(pellucid(folder.path(), &[&out[..], &sequence].concat()));
        }
        for arch in ["tbuffer", "ppll"] {
            let live = run("live", &[&["--arch", arch][..], &sequence].concat());
            for trace in ["t.csv", "t.ptrace"] {
                let played = run("played", &["--arch", arch, "--scene", trace]);
                for group in ["frame", "cycles", "fragments", "accesses", "memories", "frames"] {
                    assert_eq!(played[group], live[group], "{arch}, {trace}, {group}");
                }
                assert_eq!(played["frames"].as_array().unwrap().len(), 3);
                assert!((0..3).all(|k| image("played", k) == image("live", k)), "{arch}, {trace}");
            }
            assert!(image("live", 0) != image("live", 1));
        }
    }
    // From one form to the other and back, all frames.
    for (from, to) in [("t.csv", "u.ptrace"), ("u.ptrace", "u.csv")] {
        let output = exact(pellucid(folder.path(), &["trace", "--scene", from, "--out", to]));
        assert!(stdout(&output).ends_with(&format!(" fragments of 3 frames in {to}\n")));
    }
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("u.ptrace") == bytes("t.ptrace") && bytes("u.csv") == bytes("t.csv"));
    // As many of them as are asked for, or the first one again.
    run("two", &["--scene", "t.csv", "--frames", "2"]);
    assert!((0..2).all(|k| image("two", k) == image("live", k)));
    run("again", &["--scene", "t.csv", "--frames", "4", "--vary", "none"]);
    assert!((0..4).all(|k| image("again", k) == image("live", 0)));
    let output = exact(pellucid(folder.path(), &["run", "--check", "--scene", "t.csv"]));
    assert!(stdout(&output).starts_with("t.csv: 3 frames of 40 x 30 pixels, "), "{output:?}");
    refused(
        folder.path(),
        &["run", "--scene", "t.csv", "--frames", "4"],
        "`t.csv` has 3 frames, 4 are asked for: expected 1 to 3, or vary `none`, which repeats the first",
    );
}

/// Where a command takes one frame it says so.
#[test]
fn of_several_frames_the_first_is_taken_where_one_is_needed() {
    let folder = folder();
    let sequence = [&SMALL[..], &["--frames", "2", "--out", "t.csv"]].concat();
    exact(pellucid(folder.path(), &[&["trace"], &sequence[..]].concat()));
    let args = ["compare", "--quiet", "--machine", "tbuffer", "--scene", "t.csv"];
    let output = pellucid(folder.path(), &args);
    assert_eq!(stderr(&output), "note: t.csv: of its 2 frames the first is taken\n");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn scenes_vary_in_the_ways_that_they_have() {
    let folder = folder();
    for scene in ["smoke", "panes"] {
        let args = ["--scene", scene, "--frames", "2", "--no-wave"];
        let vary = |way: &'static str| {
            exact(run(folder.path(), &[&args[..], &["--vary", way, "--out", way]].concat()));
            [0, 1].map(|k| {
                fs::read(folder.path().join(way).join(format!("image-00{k}.png"))).unwrap()
            })
        };
        let [first, second] = vary("none");
        assert!(first == second, "{scene}");
        let [first, second] = vary("aa");
        assert!(first != second, "{scene}");
    }
    exact(pellucid(folder.path(), &[&["trace", "--out", "t.csv"], &SMALL[..]].concat()));
    for (args, message) in [
        (
            ["--path", "orbit", "--vary", "aa"],
            "path `orbit` and vary `aa` exclude each other: the camera goes a way, or one view is sampled anew",
        ),
        (
            ["--scene", "t.csv", "--vary", "aa"],
            "`t.csv` has nothing that `aa` varies: expected none",
        ),
        (
            ["--scene", "smoke", "--vary", "light"],
            "`smoke` has nothing that `light` varies: expected none, aa or focus",
        ),
        (
            ["--scene", "glass", "--vary", "blur"],
            "invalid value 'blur' for '--vary <WAY>': `blur` does not vary a scene: expected none, aa, focus, motion or \
             light",
        ),
    ] {
        refused(folder.path(), &[&["run", "--frames", "2"], &args[..]].concat(), message);
    }
}

/// Without a word on how frames differ each is the first: the tree then gives that one, as a machine of one frame has it.
#[test]
fn frames_that_make_one_image_are_repeated_unless_they_differ() {
    let folder = folder();
    let image = |out: &str, args: &[&str]| {
        exact(run(folder.path(), &[&["--no-wave", "--quiet", "--out", out], args].concat()));
        fs::read(folder.path().join(out).join("image.png")).unwrap()
    };
    let four = ["--arch", "accumulate", "--frames", "4"];
    for scene in ["glass", "smoke"] {
        let scene = ["--scene", scene];
        let one = image("one", &scene);
        assert!(image("four", &[&four[..], &scene].concat()) == one);
        let by_parameter = ["--arch", "accumulate", "-p", "frames=4"];
        assert!(image("four", &[&by_parameter[..], &scene].concat()) == one);
        let varied = image("varied", &[&four[..], &scene, &["--vary", "aa"]].concat());
        assert!(varied != one);
        let args = [&by_parameter[..], &scene, &["--vary", "aa"]].concat();
        assert!(image("varied", &args) == varied);
        // Recorded, they are what they were.
        let record = ["trace", "--quiet", "--out", "t.ptrace", "--frames", "4", "--vary", "aa"];
        exact(pellucid(folder.path(), &[&record[..], &SMALL, &scene].concat()));
        let args = ["run", "--no-wave", "--quiet", "--out", "recorded", "--scene", "t.ptrace"];
        exact(pellucid(folder.path(), &[&args[..], &["--arch", "accumulate"]].concat()));
        let recorded = fs::read(folder.path().join("recorded/image.png")).unwrap();
        assert!(recorded == varied);
    }
    let args = ["compare", "--quiet", "--machine", "tbuffer", "--machine", "accumulate,frames=4"];
    exact(pellucid(folder.path(), &[&args[..], &SMALL].concat()));
}
