//! What a comparison leaves, and that it says what single runs say.

use super::*;

/// `compare` on the small frame.
pub fn compare(folder: &Path, args: &[&str]) -> Output {
    pellucid(folder, &[&["compare"], &SMALL[..], args].concat())
}

pub fn json(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("compare.json")).unwrap()).unwrap()
}

/// Machines, and the same for `run`.
pub const MACHINES: [(&str, &[&str]); 2] = [
    ("tbuffer:fast,section_capacity=2", &["--preset", "fast", "-p", "section_capacity=2"]),
    ("tbuffer:paper", &["--preset", "paper"]),
];
const SCENES: [&str; 2] = ["glass", "smoke"];
const BOTH: [&str; 8] = [
    "--machine",
    MACHINES[0].0,
    "--machine",
    MACHINES[1].0,
    "--scene",
    SCENES[0],
    "--scene",
    SCENES[1],
];

/// What is compared, besides the stalls that a run gives stream by stream.
pub const FIGURES: [&str; 24] = [
    "cycles.total",
    "cycles.store",
    "cycles.resolve",
    "accesses.seed",
    "accesses.full",
    "storage.seed_bytes",
    "storage.seed_bytes_used",
    "storage.bits",
    "storage.on_chip_bytes",
    "storage.outside_bytes",
    "fragments.stored",
    "fragments.spilled",
    "fragments.dropped",
    "image.mismatched_pixels",
    "image.max_error",
    "image.error_bound",
    "energy.total",
    "energy.on_chip",
    "energy.reads",
    "energy.writes",
    "energy.leakage",
    "area.memories",
    "time.clock",
    "time.frame",
];

#[test]
fn the_figures_are_those_of_single_runs() {
    let folder = folder();
    let output = exact(compare(folder.path(), &[&BOTH[..], &["--json"]].concat()));
    let out = folder.path().join("pellucid-compare");
    let json = json(&out);
    assert_eq!(serde_json::from_str::<Value>(stdout(&output)).unwrap(), json);
    let csv = fs::read_to_string(out.join("compare.csv")).unwrap();
    let mut lines = vec!["scene,machine,figure,value,unit,about".to_string()];
    for (s, scene) in SCENES.iter().enumerate() {
        let compared = &json["scenes"][s];
        assert_eq!(compared["scene"], *scene);
        for (m, (machine, args)) in MACHINES.iter().enumerate() {
            let args = [&["--scene", scene, "--out", "run", "--no-wave", "-q"], *args].concat();
            exact(run(folder.path(), &args));
            let single = stats(&folder.path().join("run"));
            let there = &compared["machines"][m];
            assert_eq!(there["machine"], *machine);
            assert_eq!(compared["frame"]["fragments"], single["frame"]["fragments"]);
            assert_eq!(there["config"], single["config"]);
            let stalls = single["streams"].as_array().unwrap().iter();
            let stalls: u64 = stalls.map(|stream| stream["stalls"].as_u64().unwrap()).sum();
            let name = "stalls.streams".to_string();
            let mut figures = vec![(name, Value::from(stalls))];
            // All machines are T-buffers.
            let own = single["tbuffer"].as_object().unwrap().keys();
            let own = own.map(|name| format!("tbuffer.{name}"));
            for figure in FIGURES.map(str::to_string).into_iter().chain(own) {
                let (group, name) = figure.split_once('.').unwrap();
                let value = single[group][name].clone();
                figures.push((figure, value));
            }
            for (figure, value) in figures {
                assert!(value.is_number(), "{scene} {machine} {figure}");
                let (group, name) = figure.split_once('.').unwrap();
                assert_eq!(there[group][name], value, "{scene} {machine} {figure}");
                assert_eq!(json["about"][&figure], single["about"][&figure], "{figure}");
                let about = &json["about"][&figure];
                let [unit, about] = ["unit", "about"].map(|key| about[key].as_str().unwrap());
                lines
                    .push(format!("\"{scene}\",\"{machine}\",{figure},{value},{unit},\"{about}\""));
            }
        }
    }
    let mut found: Vec<&str> = csv.lines().collect();
    assert_eq!(found[0], lines[0]);
    found.sort();
    lines.sort();
    assert_eq!(found, lines);
}

/// Machines of one architecture are compared by its own figures too. After a frame the queue has the sections in
/// another order, and the pointer begins at the first again: it leaves a row of 64 when all of it is taken.
#[test]
fn a_machine_that_has_run_takes_its_sections_in_another_order() {
    let folder = folder();
    let machines = ["bump", "fifo"].map(|name| format!("tbuffer,allocator={name}"));
    let machines = ["--machine", &machines[0], "--machine", &machines[1]];
    let [cold, warm] = [&[][..], &["--warm-up", "2"]].map(|more| {
        exact(compare(folder.path(), &[&machines[..], &["--quiet"], more].concat()));
        let json = json(&folder.path().join("pellucid-compare"));
        json["scenes"][0]["machines"].as_array().unwrap().clone()
    });
    let switches = |run: &Value| run["tbuffer"]["row_switches"].as_u64().unwrap();
    let in_order = (cold[0]["tbuffer"]["peak_sections"].as_u64().unwrap() - 1) / 64;
    assert_eq!(cold.iter().map(switches).collect::<Vec<_>>(), [in_order; 2]);
    assert_eq!(warm[0]["tbuffer"], cold[0]["tbuffer"]);
    assert!(switches(&warm[1]) > in_order);
    assert_eq!(warm[1]["cycles"], cold[1]["cycles"]);
}

#[test]
fn one_core_and_several_give_the_same_bytes() {
    let folder = folder();
    for (out, threads) in [("a", "1"), ("b", "4")] {
        let output = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .arg("compare")
            .args(SMALL)
            .args(BOTH)
            .args(["--out", out])
            .env("RAYON_NUM_THREADS", threads)
            .current_dir(&folder)
            .output();
        exact(output.unwrap());
    }
    let files = names(&folder.path().join("a"));
    assert_eq!(files, ["compare.csv", "compare.html", "compare.json"]);
    for name in files {
        let [a, b] = ["a", "b"].map(|out| fs::read(folder.path().join(out).join(&name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

#[test]
fn the_command_in_the_files_gives_the_files_again() {
    let folder = folder();
    fs::write(
        folder.path().join("it's.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\ng pane\nf 1 2 3\ng wall\nf 2 3 4\n",
    )
    .unwrap();
    exact(compare(
        folder.path(),
        &[
            &["--machine", "tbuffer", "--scene", "it's.obj", "--camera", "0.5,0.25,3:0.5,0.5,0"],
            &["--alpha", "0.5", "--alpha", "pane=0.25", "--order", "quad", "-q"][..],
            &["--instances", "2", "--opaque-first"],
        ]
        .concat(),
    ));
    let out = folder.path().join("pellucid-compare");
    let command = json(&out)["command"].as_str().unwrap().to_string();
    assert_eq!(
        command,
        r"pellucid compare --machine tbuffer:fast --scene 'it'\''s.obj' --width 40 --height 30 --camera 0.5,0.25,3:0.5,0.5,0:40 --alpha 0.5 --alpha pane=0.25 --instances 2 --order quad --opaque-first"
    );
    let before = fs::read(out.join("compare.html")).unwrap();
    fs::remove_dir_all(&out).unwrap();
    let bin = Path::new(env!("CARGO_BIN_EXE_pellucid")).parent().unwrap();
    let again = Command::new("sh")
        .args(["-c", &format!("PATH={}:$PATH; {command} -q", bin.display())])
        .current_dir(&folder)
        .output();
    exact(again.unwrap());
    assert!(fs::read(out.join("compare.html")).unwrap() == before);
}

#[test]
fn without_machines_the_first_preset_of_each_architecture_is_compared() {
    let folder = folder();
    let quiet = exact(compare(folder.path(), &["--quiet", "--out", "quiet"]));
    assert_eq!(stdout(&quiet), "");
    let output = exact(compare(folder.path(), &[]));
    let list = exact(pellucid(folder.path(), &["list", "--json"]));
    let list: Value = serde_json::from_str(stdout(&list)).unwrap();
    let (mut first, mut others) = (vec![], vec![]);
    for arch in list["architectures"].as_array().unwrap() {
        for (k, preset) in arch["presets"].as_array().unwrap().iter().enumerate() {
            let [arch, preset] = [arch, preset].map(|named| named["name"].as_str().unwrap());
            let names = if k == 0 { &mut first } else { &mut others };
            names.push(format!("{arch}:{preset}"));
        }
    }
    assert!(others.contains(&"tbuffer:paper".to_string()), "{others:?}");
    let (_, left_out) =
        stdout(&output).split_once("\nLeft out, unless --machine names them:\n").unwrap();
    assert_eq!(left_out.lines().map(str::trim).collect::<Vec<_>>(), others);
    let json = json(&folder.path().join("pellucid-compare"));
    let scenes = json["scenes"].as_array().unwrap();
    let machines = scenes[0]["machines"].as_array().unwrap().iter();
    let machines: Vec<&str> = machines.map(|m| m["machine"].as_str().unwrap()).collect();
    assert_eq!(machines, first);
    assert_eq!((scenes.len(), &scenes[0]["scene"]), (1, &Value::from("glass")));
}

/// 3000 layers at one pixel are 4,501,500 pops of an R-buffer: more than a machine may take that nobody asked for. They are
/// more than B3D has slots for, too.
#[test]
fn a_machine_that_takes_long_is_left_out_unless_it_is_asked_for() {
    let folder = folder();
    let mut trace =
        String::from("# pellucid-trace width=1 height=1 background=0,0,0\nx,y,z,r,g,b,a\n");
    (0..3000).for_each(|z| trace += &format!("0,0,{z},9,9,9,9\n"));
    fs::write(folder.path().join("deep.csv"), trace).unwrap();
    let deep = |args: &[&str]| {
        let common = ["compare", "--scene", "deep.csv", "--allow-drops"];
        let output = pellucid(folder.path(), &[&common, args].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        output
    };
    let machines = || {
        let json = json(&folder.path().join("pellucid-compare"));
        let machines = json["scenes"][0]["machines"].as_array().unwrap().clone();
        machines.iter().map(|m| m["machine"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    let said = "rbuffer:on-chip on deep.csv, which takes more than 4,012,000 cycles";
    let text = stdout(&deep(&[])).to_string();
    assert!(text.contains(&format!("  {said}\n")), "{text}");
    let found = machines();
    assert!(found.contains(&"tbuffer:fast".to_string()), "{found:?}");
    assert!(!found.contains(&"rbuffer:on-chip".to_string()), "{found:?}");
    deep(&["--machine", "rbuffer", "--quiet"]);
    assert_eq!(machines(), ["rbuffer:on-chip"]);

    let args = ["compare", "--scene", "deep.csv", "--allow-drops", "--json"];
    let output = pellucid(folder.path(), &args);
    assert!(stderr(&output).contains(&format!("note: left out is {said}\n")), "{output:?}");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn the_table_has_a_column_a_machine_and_a_group_a_scene() {
    let folder = folder();
    let output = exact(compare(folder.path(), &BOTH));
    let text = stdout(&output);
    let json = json(&folder.path().join("pellucid-compare"));
    let (head, groups) = text.split_once("\n\nSCENE glass\n").unwrap();
    let head: Vec<Vec<&str>> = head.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(head, [vec!["tbuffer:fast,", "tbuffer:paper"], vec!["section_capacity=2"]]);
    let (glass, rest) = groups.split_once("\n\nSCENE smoke\n").unwrap();
    let (smoke, rest) = rest.split_once("\n\n").unwrap();
    for (k, group) in [glass, smoke].into_iter().enumerate() {
        let line = group.lines().find(|line| line.starts_with("  cycles.total "));
        let words: Vec<String> =
            line.unwrap().split_whitespace().map(|word| word.replace(',', "")).collect();
        let [fast, paper] =
            [0, 1].map(|m| json["scenes"][k]["machines"][m]["cycles"]["total"].to_string());
        assert_eq!(words, ["cycles.total", "cycles", &fast, &paper]);
        let own = json["scenes"][k]["machines"][0]["tbuffer"].as_object().unwrap();
        assert_eq!(group.lines().count(), FIGURES.len() + 1 + own.len());
    }
    let end = "Every image equals the golden model's, bit for bit, and every count its closed form.\n\n\
               \x20 pellucid-compare/compare.html    the figures with plots and images, for a browser\n";
    assert!(rest.starts_with(end), "{rest}");
}

#[test]
fn drops_name_machine_and_scene() {
    let folder = folder();
    let few = "tbuffer:paper,sections=10,outside_sections=0";
    let args = ["--machine", "tbuffer", "--machine", few];
    let output = compare(folder.path(), &args);
    let out = folder.path().join("pellucid-compare");
    let json = json(&out);
    let machines = &json["scenes"][0]["machines"];
    let dropped = machines[1]["fragments"]["dropped"].as_u64().unwrap();
    assert!(dropped > 0);
    let fault = machines[1]["faults"][0].as_str().unwrap();
    assert!(fault.starts_with(&format!("{dropped} fragments were dropped, ")), "{fault}");
    assert_eq!(machines[0]["faults"], Value::Array(vec![]));
    assert_eq!(stderr(&output), format!("error: {few} on glass: {fault}\n"));
    assert_eq!(output.status.code(), Some(1));
    let page = fs::read_to_string(out.join("compare.html")).unwrap();
    assert!(page.contains(&format!("<li>{few} on glass: {fault}</li>")));
    let pixels = &machines[1]["image"]["mismatched_pixels"];
    assert!(page.contains(&format!("The image by {few}: {pixels} pixels differ.")));
    assert!(page.contains("The same image, bit for bit, came from: tbuffer:fast.<"));

    let output = compare(folder.path(), &[&args[..], &["--allow-drops", "--quiet"]].concat());
    assert_eq!(stderr(&output), format!("warning: {few} on glass: {fault}\n"));
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn bad_machines_and_scenes_are_refused() {
    let folder = folder();
    for (machine, message) in [
        (
            "tbufer:fast",
            "unknown architecture `tbufer` (did you mean `tbuffer`?); known are `tbuffer`, `rbuffer`, `mbuffer`, `composer`, `dfb`, `b3d`, `ppll`, `fbuffer`, `accumulate`",
        ),
        (
            "tbuffer:fats",
            "unknown preset `fats` of `tbuffer` (did you mean `fast`?); known are `fast`, `paper`",
        ),
        ("tbuffer:", "unknown preset `` of `tbuffer`; known are `fast`, `paper`"),
        (
            "tbuffer:scan=linear",
            "`scan=linear` is no preset; a parameter comes behind a comma: `tbuffer,scan=linear`",
        ),
        ("tbuffer:fast,sections", "expected NAME=VALUE"),
        ("tbuffer,", "expected NAME=VALUE"),
        (
            "tbuffer,section_capacity=65",
            "parameter `section_capacity` is `65`: expected a whole number from 1 to 64",
        ),
        (
            "tbuffer:paper,scna=bitmap",
            "unknown parameter `scna` (did you mean `scan`?); known are `sections`, \
             `section_capacity`, `append`, `scan`, `allocator`, `sorter_depth`, \
             `outside_sections`, `outside_latency`, `reads_in_flight`, `ssa`, `ssa_sets`, `ssa_ways`, `ssa_line`, \
             `framebuffer`, `framebuffer_sets`, `framebuffer_ways`, `framebuffer_line`",
        ),
        (
            "tbuffer,sections=16777216,section_capacity=16",
            "parameters `sections` + `outside_sections` times `section_capacity` hold 285212672 \
             fragments: expected at most 268435456",
        ),
    ] {
        let message = format!("--machine {machine}: {message}");
        refused(folder.path(), &["compare", "--machine", machine], &message);
    }
    refused(
        folder.path(),
        &["compare", "--machine", "tbuffer", "--machine", "tbuffer:fast"],
        "--machine tbuffer:fast: is given twice",
    );
    refused(
        folder.path(),
        &["compare", "--scene", "glass", "--scene", "glass"],
        "--scene glass: is given twice",
    );
    refused(folder.path(), &["compare", "--scene", "no.ply"], "no.ply: no such file");
    assert_eq!(names(folder.path()), [""; 0]);
    fs::write(folder.path().join("file"), "").unwrap();
    refused(
        folder.path(),
        &["compare", "--out", "file"],
        "cannot use `file` as output folder: it is a file, not a folder",
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_of_every_file() {
    for name in ["compare.html", "compare.json", "compare.csv"] {
        let out = folder();
        std::os::unix::fs::symlink("/dev/full", out.path().join(name)).unwrap();
        let output = compare(out.path(), &["--out", "."]);
        let message = format!("error: cannot write `./{name}`: No space left on device\n");
        assert_eq!(stderr(&output), message);
        assert_eq!(output.status.code(), Some(2));
    }
}

/// One with a DRAM has settings and figures that the other does not have, whichever comes first: they are no sweep.
#[test]
fn a_machine_with_a_dram_stands_beside_one_without() {
    let folder = folder();
    let machines = ["tbuffer,sections=9,outside=ddr4-3200", "tbuffer,sections=9"];
    for [first, second] in [machines, [machines[1], machines[0]]] {
        let output = compare(
            folder.path(),
            &["--machine", first, "--machine", second, "--scene", "glass", "--out", "."],
        );
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(stderr(&output), "");
        let table = String::from_utf8(output.stdout).unwrap();
        let row = table.lines().find(|line| line.contains("outside.bytes_moved")).expect(&table);
        let [.., left, right] = *row.split_whitespace().collect::<Vec<_>>() else {
            panic!("{row}")
        };
        let (with, without) = if first == machines[0] { (left, right) } else { (right, left) };
        assert!(with.replace(',', "").parse::<u64>().is_ok_and(|bytes| bytes > 0), "{row}");
        assert_eq!(without, "-", "{row}");
        let csv = std::fs::read_to_string(folder.path().join("compare.csv")).unwrap();
        let moved: Vec<&str> =
            csv.lines().filter(|line| line.contains("outside.bytes_moved")).collect();
        assert!(matches!(moved[..], [line] if line.contains("outside=ddr4-3200")), "{moved:?}");
    }
}
