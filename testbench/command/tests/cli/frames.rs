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
    let expected = "expected a whole number from 1 to 1000";
    for frames in ["0", "1001", "-1", "many"] {
        let message = format!("invalid value '{frames}' for '--frames <FRAMES>': {expected}");
        refused(folder.path(), &["run", "--frames", frames], &message);
    }
    exact(pellucid(folder.path(), &[&["trace", "--out", "t.csv"], &SMALL[..]].concat()));
    for scene in ["smoke", "paper-0", "t.csv"] {
        let message = format!(
            "--frames 2: `{scene}` is one frame alone, expected a scene whose camera can go round it: `glass`, \
             `teapot` or a mesh"
        );
        refused(folder.path(), &["run", "--frames", "2", "--scene", scene], &message);
    }
    assert_eq!(names(folder.path()), ["t.csv"]);
}
