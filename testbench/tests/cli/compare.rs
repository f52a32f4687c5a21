//! What a comparison leaves, and that it says what single runs say.

use super::*;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use roxmltree::{Document, ParsingOptions};
use std::io::Cursor;

/// `compare` on the small frame.
fn compare(folder: &Path, args: &[&str]) -> Output {
    pellucid(folder, &[&["compare"], &SMALL[..], args].concat())
}

fn json(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("compare.json")).unwrap()).unwrap()
}

/// Machines, and the same for `run`.
const MACHINES: [(&str, &[&str]); 2] = [
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
const FIGURES: [&str; 14] = [
    "cycles.total",
    "cycles.store",
    "cycles.resolve",
    "accesses.seed",
    "accesses.full",
    "storage.seed_bytes",
    "storage.seed_bytes_used",
    "storage.bits",
    "fragments.stored",
    "fragments.spilled",
    "fragments.dropped",
    "image.mismatched_pixels",
    "image.max_error",
    "image.error_bound",
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
                assert!(value.is_u64(), "{scene} {machine} {figure}");
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
            &["--alpha", "0.5", "--alpha", "pane=0.25", "-q"][..],
        ]
        .concat(),
    ));
    let out = folder.path().join("pellucid-compare");
    let command = json(&out)["command"].as_str().unwrap().to_string();
    assert_eq!(
        command,
        r"pellucid compare --machine tbuffer:fast --scene 'it'\''s.obj' --width 40 --height 30 --camera 0.5,0.25,3:0.5,0.5,0:40 --alpha 0.5 --alpha pane=0.25"
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
fn without_machines_all_presets_are_compared() {
    let folder = folder();
    let output = exact(compare(folder.path(), &["--quiet"]));
    assert_eq!(stdout(&output), "");
    let list = exact(pellucid(folder.path(), &["list", "--json"]));
    let list: Value = serde_json::from_str(stdout(&list)).unwrap();
    let mut presets = vec![];
    for arch in list["architectures"].as_array().unwrap() {
        for preset in arch["presets"].as_array().unwrap() {
            presets.push(format!(
                "{}:{}",
                arch["name"].as_str().unwrap(),
                preset["name"].as_str().unwrap()
            ));
        }
    }
    assert!(presets.contains(&"tbuffer:paper".to_string()), "{presets:?}");
    let json = json(&folder.path().join("pellucid-compare"));
    let scenes = json["scenes"].as_array().unwrap();
    let machines = scenes[0]["machines"].as_array().unwrap().iter();
    let machines: Vec<&str> = machines.map(|m| m["machine"].as_str().unwrap()).collect();
    assert_eq!(machines, presets);
    assert_eq!((scenes.len(), &scenes[0]["scene"]), (1, &Value::from("glass")));
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
            "unknown architecture `tbufer` (did you mean `tbuffer`?); known are `tbuffer`, `rbuffer`, `mbuffer`, `composer`",
        ),
        (
            "tbuffer:fats",
            "unknown preset `fats` of `tbuffer` (did you mean `fast`?); known are `fast`, `paper`",
        ),
        ("tbuffer:", "unknown preset `` of `tbuffer`; known are `fast`, `paper`"),
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
             `outside_sections`, `outside_latency`, `reads_in_flight`",
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

/// The colours of an embedded PNG, three bytes a pixel, and its size.
fn pixels(uri: &str) -> (u32, u32, Vec<u8>) {
    let data = uri.strip_prefix("data:image/png;base64,").unwrap();
    let bytes = STANDARD.decode(data).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

#[test]
fn the_page_is_whole_and_shows_everything() {
    let folder = folder();
    // Three pixels: none, one and two layers.
    let trace = "# pellucid-trace width=3 height=1 background=0,0,0\nx,y,z,r,g,b,a\n\
                 1,0,5,200,0,0,128\n2,0,5,0,200,0,128\n2,0,6,0,0,200,128\n";
    fs::write(folder.path().join("a&b<c>.csv"), trace).unwrap();
    let args = ["--machine", MACHINES[0].0, "--machine", MACHINES[1].0, "--scene", "a&b<c>.csv"];
    exact(pellucid(folder.path(), &[&["compare", "-q"], &args[..]].concat()));
    let page = fs::read_to_string(folder.path().join("pellucid-compare/compare.html")).unwrap();
    assert!(!page.contains("http"), "a page that stands alone");
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let page = Document::parse_with_options(&page, options).unwrap();
    let all = |tag: &'static str| page.descendants().filter(move |node| node.has_tag_name(tag));
    let texts = |tag| all(tag).filter_map(|node| node.text()).collect::<Vec<_>>();

    assert_eq!(texts("title"), ["Pellucid: machines compared"]);
    assert_eq!(
        texts("pre"),
        ["pellucid compare --machine tbuffer:fast,section_capacity=2 --machine tbuffer:paper \
          --scene 'a&b<c>.csv'"]
    );
    assert!(texts("h2").contains(&"Scene a&b<c>.csv"));
    let heads = texts("th");
    for (machine, _) in MACHINES {
        assert!(heads.contains(&machine), "{heads:?}");
    }
    let json = json(&folder.path().join("pellucid-compare"));
    let value = |machine: usize, figure: &str| {
        let (group, name) = figure.split_once('.').unwrap();
        json["scenes"][0]["machines"][machine][group][name].as_u64().unwrap()
    };
    for figure in FIGURES {
        let row = all("tr").find(|tr| tr.first_element_child().unwrap().text() == Some(figure));
        let cells = row.unwrap().children().filter_map(|cell| cell.text());
        let cells: Vec<String> = cells.map(|text| text.replace(',', "")).collect();
        assert_eq!(cells[1..3], [0, 1].map(|machine| value(machine, figure).to_string()));
    }
    // Every figure has a caption; five plots of figures and the histogram.
    assert_eq!(all("figure").count(), all("figcaption").count());
    assert_eq!(all("svg").count(), 6);
    let plotted = [
        "storage.seed_bytes",
        "storage.seed_bytes_used",
        "accesses.seed",
        "accesses.full",
        "cycles.total",
    ];
    let mut plots = all("svg").map(|svg| {
        let bars = svg.descendants().filter(|node| node.has_tag_name("rect"));
        bars.map(|bar| bar.attribute("height").unwrap().parse().unwrap()).collect::<Vec<f64>>()
    });
    for figure in plotted {
        let bars = plots.next().unwrap();
        let [first, second] = [0, 1].map(|machine| value(machine, figure) as f64);
        // Heights are whole pixels; the higher bar has some 240 of them.
        assert!((bars[0] / bars[1] - first / second).abs() < 0.02, "{figure}: {bars:?}");
        assert_eq!(bars.len(), 2);
    }
    // One pixel with a layer, one with two.
    let bars = plots.next().unwrap();
    assert!(bars.len() == 2 && bars[0] == bars[1], "{bars:?}");
    let labels = texts("text");
    assert_eq!(labels.iter().filter(|text| text.trim() == "a&b<c>.csv").count(), 5);
    let images: Vec<_> = all("img").map(|img| pixels(img.attribute("src").unwrap())).collect();
    // (128 * 200 + 127 * 0) / 255 is 100; over it, for the third pixel, blue 127 / 255 * 100 is 50.
    assert_eq!(images[0], (3, 1, vec![0, 0, 0, 100, 0, 0, 0, 100, 50]));
    // White for none, then the two ends of the scale.
    let heat = vec![255, 255, 255, 0x44, 0x01, 0x54, 0xfd, 0xe7, 0x25];
    assert_eq!(images[1..], [(3, 1, heat)]);
}

/// The curves of a page: of each plot that has some its caption, and how many points each line has.
fn curves(page: &str) -> Vec<(String, Vec<usize>)> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(page, options).unwrap();
    let named = |tag| document.descendants().filter(move |node| node.has_tag_name(tag));
    let curve = |figure: roxmltree::Node| {
        let inside = |tag| figure.descendants().filter(move |node| node.has_tag_name(tag));
        // Axes are lines of two points, without circles.
        let colours: Vec<&str> = inside("circle").filter_map(|c| c.attribute("fill")).collect();
        let mut lines: Vec<&str> = colours.clone();
        lines.dedup();
        let points = |line: &&str| colours.iter().filter(|colour| *colour == line).count();
        let caption = inside("figcaption").next()?.text()?.to_string();
        (!lines.is_empty()).then(|| (caption, lines.iter().map(points).collect()))
    };
    named("figure").filter_map(curve).collect()
}

#[test]
fn machines_that_differ_by_a_number_are_drawn_over_it() {
    let folder = folder();
    let machines = ["composer,engines=4", "composer,engines=1", "composer,engines=2"];
    let args: Vec<&str> = machines.iter().flat_map(|machine| ["--machine", machine]).collect();
    exact(compare(folder.path(), &[&args[..], &["--quiet"]].concat()));
    let out = folder.path().join("pellucid-compare");
    let page = fs::read_to_string(out.join("compare.html")).unwrap();
    assert!(page.contains("<h2>Scene glass over engines</h2>"));
    // Total, and what the image composition machine counts: draw, merge, compose.
    assert_eq!(
        curves(&page),
        [
            ("Speed-up: cycles with engines=1, over cycles.".to_string(), vec![3; 4]),
            (
                "Load balance: the mean work of an engine, over that of the busiest one."
                    .to_string(),
                vec![3; 2]
            ),
        ]
    );
    // Figures that only this architecture has are compared too.
    let json = json(&out);
    let draw = |k: usize| json["scenes"][0]["machines"][k]["cycles"]["draw"].as_u64().unwrap();
    assert!(draw(1) > draw(2) && draw(2) > draw(0));
}

/// Figures that not all machines have are left out, and there is nothing to draw over.
#[test]
fn the_merger_with_what_can_stand_behind_it() {
    let folder = folder();
    let machines = ["composer", "composer,transparency=tbuffer"];
    let args: Vec<&str> = machines.iter().flat_map(|machine| ["--machine", machine]).collect();
    exact(compare(folder.path(), &[&args[..], &["--quiet"]].concat()));
    let out = folder.path().join("pellucid-compare");
    let machines = json(&out)["scenes"][0]["machines"].clone();
    for (k, own) in ["scan_line_work", "peak_sections"].iter().enumerate() {
        let single =
            ["--arch", "composer", "-p", &format!("transparency={}", ["scanline", "tbuffer"][k])];
        exact(run(folder.path(), &[&single[..], &["--out", "run", "--no-wave", "-q"]].concat()));
        let single = stats(&folder.path().join("run"));
        assert!(single["composer"][own].is_u64() && machines[k]["composer"][own].is_null());
        assert_eq!(machines[k]["composer"]["engine_work"], single["composer"]["engine_work"]);
    }
    assert_eq!(curves(&fs::read_to_string(out.join("compare.html")).unwrap()), []);
}
