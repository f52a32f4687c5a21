//! Several frames as one image.

use super::*;

/// A trace of one pixel, opaque.
fn trace(folder: &Path, name: &str, rgb: &str) {
    let text = format!(
        "# pellucid-trace width=1 height=1 background=0,0,0\nx,y,z,r,g,b,a\n0,0,5,{rgb},255\n"
    );
    fs::write(folder.join(name), text).unwrap();
}

/// The figures of a run.
fn figures(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("pellucid-out/stats.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn accumulate(folder: &Path, args: &[&str]) -> Output {
    pellucid(folder, &[&["run", "--arch", "accumulate", "--no-wave"], args].concat())
}

/// Blended into 8 bits, white is what the paper says it is.
#[test]
fn white_that_is_blended_turns_black() {
    let folder = folder();
    trace(folder.path(), "white.csv", "255,255,255");
    for (frames, left) in [(32, 224), (64, 192), (128, 128), (256, 0)] {
        let frames = frames.to_string();
        let args = ["--scene", "white.csv", "--frames", &frames, "-p", "method=blend", "--quiet"];
        exact(accumulate(folder.path(), &args));
        let image = &figures(folder.path())["image"];
        assert_eq!(image["max_error"], 255 - left);
        assert!(image["error_bound"].as_u64() >= image["max_error"].as_u64());
    }
    assert!(folder.path().join("pellucid-out/image.png").is_file());
    assert!(!folder.path().join("pellucid-out/image-000.png").exists());
}

#[test]
fn passes_sweeps_and_planes_are_those_of_the_paper() {
    let folder = folder();
    trace(folder.path(), "one.csv", "9,9,9");
    for (branching, schedule, counts) in [
        ("2", "nodes", [2047, 2047, 11]),
        ("4", "nodes", [1365, 1365, 16]),
        ("2", "stream", [2047, 1024, 10]),
        ("4", "stream", [1365, 1024, 15]),
    ] {
        let [branching, schedule] =
            [format!("branching={branching}"), format!("schedule={schedule}")];
        let args = ["--scene", "one.csv", "--frames", "1024", "-p", &branching, "-p", &schedule];
        let output = accumulate(folder.path(), &args);
        let said = "The image equals the golden model of its accumulation tree, bit for bit";
        assert!(output.status.success() && stdout(&output).starts_with(said), "{output:?}");
        let figures = figures(folder.path());
        let own = &figures["accumulate"];
        assert_eq!((&own["frames"], &figures["frame"]["frames"]), (&1024.into(), &1024.into()));
        let found = ["passes", "sweeps", "peak_planes"].map(|name| own[name].as_u64().unwrap());
        assert_eq!(found, counts);
    }
}

/// By the parameter as by the run; in a comparison by the parameter alone.
#[test]
fn frames_are_as_many_as_the_machine_makes_an_image_of() {
    let folder = folder();
    let scene = [&SMALL[..], &["--scene", "glass"]].concat();
    exact(accumulate(folder.path(), &[&scene[..], &["--frames", "4", "--quiet"]].concat()));
    let by_run = figures(folder.path());
    exact(accumulate(folder.path(), &[&scene[..], &["-p", "frames=4", "--quiet"]].concat()));
    assert_eq!(figures(folder.path()), by_run);
    assert_eq!(by_run["frame"]["frames"], 4);
    let machines = ["tbuffer", "accumulate,branching=2,4,frames=8", "accumulate:paper,frames=2"];
    let machines = machines.iter().flat_map(|machine| ["--machine", machine]);
    let compare: Vec<&str> = ["compare"].into_iter().chain(scene).chain(machines).collect();
    let output = pellucid(folder.path(), &compare);
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn weights_come_from_a_file() {
    let folder = folder();
    trace(folder.path(), "one.csv", "9,9,9");
    fs::write(folder.path().join("window.txt"), "0.125\n0.75\n0.125\n").unwrap();
    let args = ["--scene", "one.csv", "--frames", "3", "-p", "weights=@window.txt", "--quiet"];
    exact(accumulate(folder.path(), &args));
    assert_eq!(figures(folder.path())["config"]["weights"], "0.125,0.75,0.125");
}

#[test]
fn what_cannot_be_accumulated_is_refused() {
    let folder = folder();
    fs::write(folder.path().join("w.txt"), "0.5 0.25").unwrap();
    let too_many = "parameter `sum_bits` is 16, which is enough for 257 frames: expected 17 for the 300 of `frames`";
    for (args, message) in [
        (
            &["--frames", "6"][..],
            "parameter `frames` is 6: expected as many as a tree of this `branching` has leaves, 4 or 8, or `weights` \
             for the frames",
        ),
        (
            &["--frames", "2", "-p", "weights=@w.txt"],
            "parameter `weights` is a list of numbers whose sum is 0.75: expected numbers that sum to one",
        ),
        (
            &["--frames", "3", "-p", "weights=@w.txt"],
            "parameter `weights` is a list of 2 numbers: expected 3, one for each of `frames`",
        ),
        (
            &["-p", "weights=0.5,x"],
            "-p weights=0.5,x: parameter `weights` is `0.5,x`: expected `none`, `box`, `triangle`, `gaussian`, or a \
             number from 0 to 1 for each frame, as in `0.1,0.4,0.4,0.1`",
        ),
        (&["-p", "weights=@no.txt"], "cannot read `no.txt`: No such file or directory"),
        (&["--frames", "300", "-p", "method=buffer"], too_many),
        (
            &["-p", "frames=0"],
            "-p frames=0: parameter `frames` is `0`: expected a whole number from 1 to 1024",
        ),
        (
            &["--frames", "4", "-p", "frames=8"],
            "--frames 4 and parameter `frames` 8 are both given: expected one of them",
        ),
        (
            &["-p", "branching=3"],
            "-p branching=3: parameter `branching` is `3`: expected 2, 4, or up to 10 of these level by level, as in \
             `2,4`",
        ),
    ] {
        refused(folder.path(), &[&["run", "--arch", "accumulate"], args].concat(), message);
    }
}
