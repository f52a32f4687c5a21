//! `explore`: studies.

use super::*;
use serde_json::json;
use std::path::PathBuf;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

/// Two architectures on two scenes; some designs are too large, some drop fragments.
pub const STUDY: &str = r#"
[[scene]]
scene = "glass"
width = 40
height = 30
[[scene]]
scene = "quads-3-50"
width = 32
height = 24

[[machine]]
arch = "tbuffer"
section_capacity = [1, 3]
sections = [16, 2048]
outside_sections = "= 2 * sections"

[[machine]]
arch = "dfb"
fragments = [1024, 200000]
outside_fragments = 0
index = ["up", "down"]

[constraints]
"storage.on_chip_bytes" = "<= 1 MiB"

[objectives]
"cycles.total" = { goal = "min", scenes = "sum" }
"storage.on_chip_bytes" = { goal = "min", scenes = "max" }

[technology]
node = 45
"#;

pub fn write(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("study.toml");
    fs::write(&path, text).unwrap();
    path
}

pub fn explore(folder: &Path, args: &[&str]) -> Output {
    pellucid(folder, &[&["explore", "study.toml", "--quiet"], args].concat())
}

/// How many points a folder of points has.
pub fn kept(points: &Path) -> usize {
    let Ok(programs) = fs::read_dir(points) else { return 0 };
    let files = programs.filter_map(|folder| fs::read_dir(folder.unwrap().path()).ok()).flatten();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    // Beside a file that says what figures are.
    names.filter(|name| name.ends_with(".json") && name != "figures.json").count()
}

/// The rows that a study has left.
pub fn rows(out: &Path) -> Vec<Value> {
    let text = fs::read_to_string(out.join("points.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Each point is what `run` gives for its command, and the front is what its definition says.
#[test]
fn points_are_runs_and_the_front_is_what_nothing_beats() {
    let folder = folder();
    write(folder.path(), STUDY);
    exact(explore(folder.path(), &[]));
    let out = folder.path().join("pellucid-explore");
    let rows = rows(&out);
    let mut sums: BTreeMap<u64, (Vec<f64>, bool)> = BTreeMap::new();
    let mut statuses: BTreeMap<String, u32> = BTreeMap::new();
    for row in &rows {
        *statuses.entry(row["status"].as_str().unwrap().to_string()).or_default() += 1;
        let words = row["command"].as_str().unwrap().strip_prefix("pellucid ").unwrap();
        let words: Vec<&str> = words.split(' ').collect();
        let output = pellucid(folder.path(), &[&words[..], &["--no-wave", "--quiet"]].concat());
        match row["status"].as_str().unwrap() {
            "right" => assert_eq!(output.status.code(), Some(0), "{row}"),
            "lossy" => assert_eq!(output.status.code(), Some(1), "{row}"),
            "excluded" => {
                let stats = stats(&folder.path().join("pellucid-out"));
                assert!(stats["storage"]["on_chip_bytes"].as_u64().unwrap() > 1 << 20, "{row}");
                continue;
            }
            other => panic!("{other}: {row}"),
        }
        let stats = stats(&folder.path().join("pellucid-out"));
        for (name, value) in row.as_object().unwrap() {
            let Some((group, figure)) = name.split_once('.') else { continue };
            let expected = match group {
                "parameter" if figure == "preset" => continue,
                "parameter" => &stats["config"][figure],
                _ => &stats[group][figure],
            };
            assert_eq!(value.as_f64(), expected.as_f64(), "{name} of {row}");
        }
        let (sum, right) =
            sums.entry(row["design"].as_u64().unwrap()).or_insert((vec![0.0; 2], true));
        sum[0] += stats["cycles"]["total"].as_f64().unwrap();
        sum[1] = sum[1].max(stats["storage"]["on_chip_bytes"].as_f64().unwrap());
        *right &= row["status"] == "right" && sum[1] <= 1_048_576.0;
    }
    assert!(statuses.contains_key("lossy") && statuses.contains_key("excluded"), "{statuses:?}");
    let inside: Vec<(&u64, &Vec<f64>)> = sums
        .iter()
        .filter(|(_, (_, right))| *right)
        .map(|(design, (sum, _))| (design, sum))
        .collect();
    assert!(inside.len() > 2, "{sums:?}");
    for row in &rows {
        let design = row["design"].as_u64().unwrap();
        let on = inside.iter().find(|(other, _)| **other == design).is_some_and(|(_, own)| {
            !inside.iter().any(|(_, sum)| sum.iter().zip(*own).all(|(a, b)| a <= b) && sum != own)
        });
        assert_eq!(row["front"], on, "{row}");
    }
    // Every column is said what it is.
    let columns: Value =
        serde_json::from_slice(&fs::read(out.join("columns.json")).unwrap()).unwrap();
    let head = fs::read_to_string(out.join("points.csv")).unwrap();
    for column in head.lines().next().unwrap().split(',') {
        let about = columns[column]["about"].as_str().unwrap();
        assert!(about.ends_with('.'), "{column}: {about}");
    }
    let mut files = vec!["columns.json", "explore.html", "points", "points.csv", "points.jsonl"];
    if cfg!(feature = "parquet") {
        files.push("points.parquet");
    }
    assert_eq!(names(&out), files);
}

/// What was done is not done again: by the same study, by another one, or after it was killed.
#[test]
fn points_are_kept() {
    let folder = folder();
    write(folder.path(), STUDY);
    let out = |name: &str| folder.path().join(name);
    exact(explore(folder.path(), &["--points", "kept", "--out", "a"]));
    let count = kept(&out("kept"));
    let say = |study: &str, args: &[&str]| {
        write(folder.path(), study);
        let output = pellucid(folder.path(), &[&["explore", "study.toml"], args].concat());
        stdout(&exact(output)).to_string()
    };
    let again = say(STUDY, &["--points", "kept", "--out", "b"]);
    assert!(again.contains(&format!("0 points were run, {count} were kept")), "{again}");
    for name in ["points.csv", "points.jsonl", "columns.json"] {
        assert_eq!(fs::read(out("a").join(name)).unwrap(), fs::read(out("b").join(name)).unwrap());
    }
    // Another study over some of the same points, and one new design.
    let other = STUDY.replace("sections = [16, 2048]", "sections = [2048, 4096]");
    let more = say(&other, &["--points", "kept", "--out", "c"]);
    assert!(more.contains(" 4 points were run, "), "{more}");
    // Whatever is there when the process is killed is whole, and is not done again.
    let args = ["explore", "study.toml", "--points", "killed", "--out", "d", "--quiet"];
    write(folder.path(), STUDY);
    let mut child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(args)
        .current_dir(folder.path())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while kept(&out("killed")) == 0 && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let rest = say(STUDY, &["--points", "killed", "--out", "d"]);
    assert!(!rest.contains(" 0 were kept"), "{rest}");
    let csv = |name: &str| fs::read_to_string(out(name).join("points.csv")).unwrap();
    assert!(csv("a") == csv("d").replace("killed/", "kept/"), "{}\n{}", csv("a"), csv("d"));
    // Nothing is run, and what is kept is shown.
    let front = say(&other, &["--points", "killed", "--out", "e", "--front"]);
    assert!(
        front.contains(" 0 points were run, ") && front.contains(", 4 are left to run."),
        "{front}"
    );
}

#[test]
fn the_example_runs() {
    let folder = folder();
    let example = exact(pellucid(folder.path(), &["explore", "--example"]));
    let example = stdout(&example).replace("160\nheight = 120", "24\nheight = 18");
    write(folder.path(), &example);
    exact(explore(folder.path(), &[]));
    let scenes: Vec<Value> =
        rows(&folder.path().join("pellucid-explore")).iter().map(|r| r["scene"].clone()).collect();
    assert!(scenes.contains(&json!("--scene smoke --width 24 --height 18")), "{scenes:?}");
}

/// The studies that come with the book, on small frames.
#[test]
fn the_studies_of_the_book_run() {
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/studies");
    let all: Vec<String> =
        names(&studies).into_iter().filter(|name| name.ends_with(".toml")).collect();
    assert!(all.len() > 2, "{all:?}");
    for name in all {
        let folder = folder();
        let text = fs::read_to_string(studies.join(&name)).unwrap();
        let small = text.replace("width = 160\nheight = 120", "width = 40\nheight = 30");
        assert_ne!(text, small, "{name}");
        write(folder.path(), &small);
        exact(explore(folder.path(), &[]));
        let rows = rows(&folder.path().join("pellucid-explore"));
        let right = rows.iter().filter(|row| row["status"] == "right").count();
        assert!(2 * right > rows.len(), "{name}: {right} of {} are right", rows.len());
    }
}

#[test]
fn what_is_wrong_with_a_study_is_said_with_its_line() {
    let folder = folder();
    let machine = "[[machine]]\narch = \"tbuffer\"\n";
    let scene = "[[scene]]\nscene = \"glass\"\nwidth = 8\nheight = 8\n";
    for (study, message) in [
        ("", "`study.toml`, line 1: no scene is given: expected at least one `[[scene]]`"),
        (scene, "`study.toml`, line 1: no machine is given: expected at least one `[[machine]]`"),
        (
            &format!("[[scene]]\nscene = \"glass\"\nwidth = 0\n{machine}"),
            "`study.toml`, line 3: `scene.width` is `0`: expected a whole number from 1 to 8192",
        ),
        (
            "[[scene]]\nscene = \"glas\"\n[[machine]]\narch = \"tbuffer\"\n",
            "`study.toml`, line 1: unknown scene `glas` (did you mean `glass`?)",
        ),
        (
            &format!("{scene}[[machine]]\narch = \"t\"\n"),
            "`study.toml`, line 6: `machine.arch` is `t`: unknown architecture `t`",
        ),
        (
            &format!("{scene}{machine}preset = \"fst\"\n"),
            "`study.toml`, line 7: unknown preset `fst` of `tbuffer` (did you mean `fast`?)",
        ),
        (
            &format!("{scene}{machine}section = 1\n"),
            "`study.toml`, line 7: unknown parameter `section` (did you mean `sections`?)",
        ),
        (
            &format!("{scene}{machine}section_capacity = [3, 0]\n"),
            "`study.toml`, line 7: parameter `section_capacity` is `0`: expected ",
        ),
        (
            &format!("{scene}{machine}sections = {{ from = 1, to = 9 }}\n"),
            "`study.toml`, line 7: the range of `sections` has no `steps`, which a grid needs",
        ),
        (
            &format!("{scene}{machine}sections = \"= 2 * capacity\"\n"),
            "`study.toml`, line 7: the formula of `sections` stands on `capacity`: expected ",
        ),
        (
            &format!("{scene}{machine}[constraints]\n\"cycles.all\" = \"< 1\"\n"),
            "`study.toml`, line 8: unknown figure `cycles.all`",
        ),
        (
            &format!("{scene}{machine}[objectives]\n\"cycles.total\" = \"least\"\n"),
            "`study.toml`, line 8: `cycles.total` is `least`: expected `min` or `max`",
        ),
        (
            &format!("{scene}{machine}[search]\nmethod = \"random\"\n"),
            "`study.toml`, line 7: expected `designs`, how many are looked at",
        ),
        (&format!("{scene}{scene}{machine}"), "`study.toml`, line 5: the scene is given twice"),
        (
            &format!("{scene}path = \"orbit\"\nvary = \"aa\"\n{machine}"),
            "`study.toml`, line 1: path `orbit` and vary `aa` exclude each other",
        ),
        (
            &format!("{scene}vary = \"blur\"\n{machine}"),
            "`study.toml`, line 5: `scene.vary` is `blur`: `blur` does not vary a scene",
        ),
        (
            &format!("[[scene]]\nscene = \"smoke\"\nframes = 2\n{machine}"),
            "`study.toml`, line 1: `smoke` is one frame alone, 2 are asked for",
        ),
        (
            &format!("{scene}{machine}[technology]\nnode = 33\n"),
            "`study.toml`, line 7: unknown node `33`; known are `22`, `32`, `45` (nm, of CACTI 7)",
        ),
        (
            &format!("{scene}{machine}[technology]\nnod = 32\n"),
            "`study.toml`, line 8: unknown key `technology.nod` (did you mean `node`?)",
        ),
    ] {
        write(folder.path(), study);
        let output = explore(folder.path(), &[]);
        let said = stderr(&output);
        assert!(said.starts_with(&format!("error: {message}")), "{study}\n{said}");
        assert_eq!(output.status.code(), Some(2), "{said}");
    }
    assert_eq!(names(folder.path()), ["study.toml"]);
    let missing = pellucid(folder.path(), &["explore", "no.toml"]);
    assert!(stderr(&missing).starts_with("error: cannot read `no.toml`: "), "{}", stderr(&missing));
}

/// Parameters that do not go together are a result, too; where nothing else is left, that is said.
#[test]
fn a_study_without_a_design_left_fails() {
    let folder = folder();
    write(
        folder.path(),
        "[[scene]]\nscene = \"glass\"\nwidth = 8\nheight = 8\n[[machine]]\narch = \"tbuffer\"\nsections = 1\noutside_sections = 0\n",
    );
    let output = explore(folder.path(), &[]);
    assert_eq!(stderr(&output), "error: no design is left: see `reason` in points.csv\n");
    assert_eq!(output.status.code(), Some(1));
    let rows = rows(&folder.path().join("pellucid-explore"));
    assert_eq!(rows[0]["status"], "lossy");
}

/// Shares in any order, by several processes at once, one of them killed and run again: together they are the study.
#[test]
fn shares_are_the_whole() {
    let folder = folder();
    write(folder.path(), STUDY);
    let share = |share: &str| {
        let args = ["run-point", "study.toml", "--points", "shared", "--quiet", "--share", share];
        let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
        command.args(args).current_dir(folder.path()).stderr(Stdio::piped()).stdout(Stdio::piped());
        command.spawn().unwrap()
    };
    let mut killed = share("2/3");
    let others = [share("3/3"), share("1/3")];
    killed.kill().unwrap();
    killed.wait().unwrap();
    for other in others {
        exact(other.wait_with_output().unwrap());
    }
    let open = pellucid(folder.path(), &["explore", "study.toml", "--points", "shared", "--front"]);
    assert!(!stdout(&open).contains(", 0 are left to run."), "{}", stdout(&open));
    exact(share("2/3").wait_with_output().unwrap());
    let args = ["explore", "study.toml", "--points", "shared"];
    let all = exact(pellucid(folder.path(), &args));
    assert!(stdout(&all).contains(" 0 points were run, "), "{}", stdout(&all));
    for bad in ["0/3", "4/3", "3", "a/b"] {
        let args = ["run-point", "study.toml", "--points", "shared", "--share", bad];
        let output = pellucid(folder.path(), &args);
        assert!(stderr(&output).contains("expected NUMBER/SHARES"), "{}", stderr(&output));
    }
}

/// Of a machine that makes one image of the frames of a scene each method has its own, as the command beside it makes it.
#[test]
fn an_image_of_several_frames_is_what_its_command_makes() {
    let folder = folder();
    let scene = "[[scene]]\nscene = \"cube\"\nwidth = 16\nheight = 12\nframes = 4\nvary = \"aa\"\n";
    let machine =
        "[[machine]]\narch = \"accumulate\"\nmethod = [\"tree\", \"buffer\", \"blend\"]\n";
    write(folder.path(), &format!("{scene}{machine}[[machine]]\narch = \"tbuffer\"\n"));
    exact(explore(folder.path(), &[]));
    let rows = rows(&folder.path().join("pellucid-explore"));
    assert_eq!(rows.len(), 4);
    for row in rows {
        assert_eq!(row["status"], "right", "{row}");
        let command = row["command"].as_str().unwrap();
        exact(pellucid(folder.path(), &command.split(' ').skip(1).collect::<Vec<_>>()));
        let stats = stats(&folder.path().join("pellucid-out"));
        assert_eq!(row["cycles.total"], stats["cycles"]["total"], "{command}");
        assert_eq!(row["image.max_error"], stats["image"]["max_error"], "{command}");
    }
}

/// A search by NSGA-II finds the best of a space that is small enough to be looked through.
#[test]
fn a_genetic_search_finds_the_front() {
    let folder = folder();
    let study = |method: &str| {
        format!(
            "[[scene]]\nscene = \"quads-3-50\"\nwidth = 16\nheight = 12\n[[machine]]\narch = \"tbuffer\"\nsections = [8, 16, 32, 64, \
             128, 256, 512]\nsection_capacity = {{ from = 1, to = 8, steps = 8 }}\noutside_sections = 600\n[search]\n{method}\n"
        )
    };
    let front = |method: &str| {
        write(folder.path(), &study(method));
        exact(explore(folder.path(), &["--points", "kept"]));
        let rows = rows(&folder.path().join("pellucid-explore"));
        let on = rows.iter().filter(|row| row["front"] == true);
        let on: Vec<[u64; 2]> = on
            .map(|row| {
                ["cycles.total", "storage.on_chip_bytes"].map(|name| row[name].as_u64().unwrap())
            })
            .collect();
        (on, rows.len())
    };
    let (all, count) = front("method = \"grid\"");
    assert_eq!(count, 56);
    let (found, count) = front("method = \"genetic\"\ndesigns = 36\nseed = 3");
    assert_eq!(count, 36);
    let best = |front: &[[u64; 2]], k: usize| front.iter().map(|values| values[k]).min();
    assert_eq!([best(&found, 0), best(&found, 1)], [best(&all, 0), best(&all, 1)]);
    assert!(found.iter().filter(|values| all.contains(values)).count() * 10 >= found.len() * 8);
}

/// Another program asks, a line at a time.
#[test]
fn a_program_that_asks_is_told() {
    let folder = folder();
    write(folder.path(), STUDY);
    let mut child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["explore", "study.toml", "--ask-tell", "--quiet"])
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let asked = "{\"machine\": 1, \"parameters\": {\"fragments\": 1024, \"index\": \"up\"}}\n\
                 [{\"machine\": 0, \"parameters\": {\"section_capacity\": 3, \"sections\": 2048}}, {\"machine\": 0}]\n\
                 {\"machine\": 1, \"parameters\": {\"fragments\": 1, \"index\": \"up\"}}\n{\"machine\": 1, \"parameters\": {\"idx\": 1}}\nx\n";
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), asked.as_bytes()).unwrap();
    let output = exact(child.wait_with_output().unwrap());
    let said: Vec<Value> =
        stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let [space, first, pair, wrong, unknown, no_json] = &said[..] else { panic!("{said:?}") };
    assert_eq!(
        space["machines"][1]["parameters"][1],
        json!({ "name": "fragments", "values": ["1024", "200000"] })
    );
    assert_eq!(space["objectives"][0], json!({ "figure": "cycles.total", "goal": "min" }));
    // What the study itself finds of these designs.
    exact(explore(folder.path(), &["--out", "all"]));
    let rows = rows(&folder.path().join("all"));
    for told in [first, &pair[0]] {
        let of: Vec<&Value> = rows.iter().filter(|row| row["machine"] == told["name"]).collect();
        assert_eq!(of.len(), 2, "{told}");
        let cycles = of.iter().map(|row| row["cycles.total"].as_f64().unwrap()).sum::<f64>();
        match told["objectives"][0].as_f64() {
            Some(told) => assert_eq!(told, cycles),
            None => assert!(of.iter().any(|row| row["status"] != "right"), "{told}"),
        }
    }
    let errors = [&pair[1], wrong, unknown, no_json].map(|told| told["error"].as_str().unwrap());
    assert_eq!(errors[0], "`section_capacity` is missing: expected one of `1`, `3`");
    assert_eq!(errors[1], "`fragments` is `1`: expected one of `1024`, `200000`");
    assert!(
        errors[2].starts_with("unknown parameter `idx`") && errors[3].starts_with("no JSON: "),
        "{errors:?}"
    );
}
