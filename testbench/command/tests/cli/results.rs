//! What a run leaves, and that it holds together.

use super::*;

#[test]
fn an_exact_run_leaves_its_files_and_says_so() {
    let folder = folder();
    let output = exact(run(folder.path(), &[]));
    let text = stdout(&output);
    // The verdict first, then the time; every figure on request, as people read them.
    let verdict = "The image equals the golden model's, bit for bit, and every count its closed form.\n\
                   tbuffer on glass: ";
    assert!(text.starts_with(verdict), "{text}");
    assert!(text.lines().count() < 20 && text.ends_with("`--details` prints them.\n"), "{text}");
    let details = exact(run(folder.path(), &["--details"]));
    let details = stdout(&details);
    assert!(details.starts_with(verdict), "{details}");
    for expected in ["\nFRAME\n", "\nSTREAMS ", "\n  as the paper counts, in use "] {
        assert!(details.contains(expected), "{expected}: {details}");
    }
    assert!(!details.contains("seed"), "{details}");
    let out = folder.path().join("pellucid-out");
    assert_eq!(
        names(&out),
        [
            ".surfer",
            "image.png",
            "stats.csv",
            "stats.json",
            "wave.gtkw",
            "wave.states",
            "wave.sucl",
            "wave.vcd"
        ]
    );
    let quiet = exact(run(folder.path(), &["--quiet", "--no-wave", "--out", "q"]));
    assert_eq!(stdout(&quiet), "");
    assert_eq!(names(&folder.path().join("q")), ["image.png", "stats.csv", "stats.json"]);
    let json = exact(run(folder.path(), &["--json", "--out", "j"]));
    assert_eq!(stdout(&json), fs::read_to_string(folder.path().join("j/stats.json")).unwrap());
}

#[test]
fn run_is_what_is_done_without_a_command() {
    let folder = folder();
    let [named, bare] = [&["run"][..], &[]].map(|command| {
        let output = exact(pellucid(folder.path(), &[command, &SMALL[..]].concat()));
        stdout(&output).to_string()
    });
    assert_eq!(named, bare);
    refused(
        folder.path(),
        &["rum"],
        "unrecognized subcommand 'rum'\n\n  tip: a similar subcommand exists: 'run'\n\nUsage: \
         pellucid [OPTIONS]\n       pellucid <COMMAND>",
    );
}

#[test]
fn drops_are_said_and_fail_unless_allowed() {
    let folder = folder();
    let out = folder.path().join("pellucid-out");
    let few = ["-p", "sections=10", "-p", "outside_sections=0"];
    let output = run(folder.path(), &few);
    let dropped = stats(&out)["fragments"]["dropped"].as_u64().unwrap();
    let mismatched = stats(&out)["image"]["mismatched_pixels"].as_u64().unwrap();
    assert!(dropped > 0);
    let start = format!(
        "{dropped} fragments were dropped, no section was free (see `sections` and \
         `outside_sections`); {mismatched} pixels differ from the golden model, by "
    );
    let said = stderr(&output);
    let lossy = "The result is wrong or lossy: see what is said on standard error.\n";
    assert!(stdout(&output).starts_with(lossy), "{}", stdout(&output));
    assert!(said.starts_with(&format!("error: {start}")), "{said}");
    let hint = "hint: `pellucid size --scene glass --width 40 --height 30` finds the smallest machine that drops nothing";
    assert_eq!(said.lines().skip(1).collect::<Vec<_>>(), [hint]);
    assert_eq!(output.status.code(), Some(1));
    assert!(out.join("image.png").is_file());

    let output = run(folder.path(), &[&few[..], &["--allow-drops"]].concat());
    let allowed = "The result is lossy, which is allowed: see what is said on standard error.\n";
    assert!(stdout(&output).starts_with(allowed), "{}", stdout(&output));
    let said = stderr(&output);
    assert!(said.starts_with(&format!("warning: {start}")), "{said}");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn two_runs_give_the_same_bytes() {
    let folder = folder();
    for out in ["a", "b"] {
        exact(run(folder.path(), &["--out", out]));
    }
    for name in ["image.png", "stats.json", "stats.csv", "wave.vcd"] {
        let [a, b] = ["a", "b"].map(|out| fs::read(folder.path().join(out).join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

#[test]
fn a_trace_gives_what_its_scene_gives() {
    let folder = folder();
    let result = |out: &str| {
        let out = folder.path().join(out);
        let mut stats = stats(&out);
        stats.as_object_mut().unwrap().remove("scene");
        (stats, fs::read(out.join("image.png")).unwrap(), fs::read(out.join("wave.vcd")).unwrap())
    };
    exact(run(folder.path(), &["--out", "scene"]));
    for name in ["t.csv", "t.ptrace"] {
        let written =
            exact(pellucid(folder.path(), &[&["trace", "--out", name], &SMALL[..]].concat()));
        let fragments = stats(&folder.path().join("scene"))["frame"]["fragments"].clone();
        assert_eq!(stdout(&written), format!("{fragments} fragments in {name}\n"));
        exact(pellucid(folder.path(), &["run", "--scene", name, "--out", "trace"]));
        assert!(result("trace") == result("scene"), "{name}");
    }
}

#[test]
fn the_figures_have_their_keys_and_add_up() {
    let folder = folder();
    let output = exact(run(folder.path(), &["--json"]));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    assert_eq!(json["arch"], "tbuffer");
    // What figures mean stands behind all of them.
    let keys: Vec<&String> = json.as_object().unwrap().keys().collect();
    assert_eq!((keys.first().unwrap().as_str(), keys.last().unwrap().as_str()), ("arch", "about"));
    for path in [
        "/frame/width",
        "/frame/height",
        "/frame/fragments",
        "/frame/opaque",
        "/frame/transparent",
        "/frame/culled",
        "/frame/transparent_pixels",
        "/frame/max_layers",
        "/cycles/total",
        "/cycles/store",
        "/cycles/resolve",
        "/accesses/seed",
        "/accesses/full",
        "/storage/seed_bytes",
        "/storage/bits",
        "/storage/on_chip_bytes",
        "/storage/outside_bytes",
        "/image/mismatched_pixels",
        "/image/max_error",
        "/image/error_bound",
    ] {
        let number = json.pointer(path).and_then(Value::as_u64);
        assert!(number.is_some(), "{path} is no whole number");
    }
    for rate in ["accepted", "stored", "resolved"] {
        assert!(json["rates"][rate].is_f64(), "rates.{rate}");
    }
    let memories = json["memories"].as_array().unwrap();
    let field = |memory: &Value, name: &str| memory[name].as_u64().unwrap();
    for memory in memories {
        assert!(memory["name"].is_string());
        assert!(field(memory, "peak_words") <= field(memory, "words"), "{memory}");
    }
    let sum = |of: &dyn Fn(&Value) -> u64| memories.iter().map(of).sum::<u64>();
    assert_eq!(json["accesses"]["full"], sum(&|m| field(m, "reads") + field(m, "writes")));
    assert_eq!(json["storage"]["bits"], sum(&|m| field(m, "words") * field(m, "bits_per_word")));
    assert_eq!(json["config"]["section_capacity"], 3);
    assert_eq!(json["config"]["append"], "tail");
}

#[test]
fn preset_file_and_parameters_are_layered() {
    let folder = folder();
    let file = "section_capacity = 5\nsorter_depth = \"7\"\nscan = \"bitmap\"\n";
    fs::write(folder.path().join("c.toml"), file).unwrap();
    let layers = ["--preset", "paper", "--config", "c.toml", "-p", "sorter_depth=9"];
    exact(run(folder.path(), &layers));
    let config = stats(&folder.path().join("pellucid-out"))["config"].clone();
    assert_eq!(config["append"], "walk", "from the preset");
    assert_eq!(config["section_capacity"], 5, "from the file");
    assert_eq!(config["scan"], "bitmap", "the file's over the preset's");
    assert_eq!(config["sorter_depth"], 9, "the parameter over the file's");
    exact(run(folder.path(), &["-p", "sections=500", "-p", "sections=600"]));
    let config = stats(&folder.path().join("pellucid-out"))["config"].clone();
    assert_eq!(config["sections"], 600, "the last one counts");
}

#[test]
fn a_file_can_name_architecture_and_preset() {
    let folder = folder();
    let write = |text: &str| fs::write(folder.path().join("c.toml"), text).unwrap();
    let told = |more: &[&str]| {
        let args = ["--config", "c.toml", "--no-wave", "--quiet"];
        exact(run(folder.path(), &[&args[..], more].concat()));
        let stats = stats(&folder.path().join("pellucid-out"));
        (stats["arch"].as_str().unwrap().to_string(), stats["config"].clone())
    };
    write("preset = \"outside\"\narch = \"rbuffer\"\noutside_latency = 9\n");
    let (arch, config) = told(&[]);
    assert_eq!((&*arch, &config["queue"]), ("rbuffer", &128.into()));
    assert_eq!(config["outside_latency"], 9);
    assert_eq!(told(&["--preset", "replay"]).1["queue"], 65_536);
    write("arch = \"rbuffer\"\n");
    assert_eq!(told(&["--arch", "mbuffer"]).0, "mbuffer");

    let wrong = |text: &str, message: &str| {
        write(text);
        refused(folder.path(), &["run", "--config", "c.toml"], message);
    };
    wrong(
        "arch = \"tbufer\"\n",
        "`c.toml`, key `arch`: unknown architecture `tbufer` (did you mean `tbuffer`?); known are `tbuffer`, \
         `rbuffer`, `mbuffer`, `composer`, `dfb`, `b3d`, `ppll`, `fbuffer`, `accumulate`",
    );
    wrong(
        "preset = \"fats\"\n",
        "`c.toml`, key `preset`: unknown preset `fats` of `tbuffer` (did you mean `fast`?); known are `fast`, `paper`",
    );
}

#[test]
fn the_waveform_is_read_back() {
    let folder = folder();
    exact(run(folder.path(), &["--wave", "all", "-q"]));
    let path = folder.path().join("pellucid-out/wave.vcd");
    let mut wave = wellen::simple::read(path).unwrap();
    let hierarchy = wave.hierarchy();
    let vars: Vec<&wellen::Var> = hierarchy.all_vars().map(|var| &hierarchy[var]).collect();
    let var = |name| vars.iter().find(|var| var.full_name(hierarchy) == name).unwrap();
    let store = "top.machine.registers.chains.store.fsm";
    for name in ["top.clk", "top.machine.wires.image.valid", store] {
        var(name);
    }
    let phase = var("top.machine.registers.front.sequencer.phase");
    let (_, names) = phase.enum_type(hierarchy).unwrap();
    let names: BTreeMap<String, String> =
        names.into_iter().map(|(bits, name)| (bits.to_string(), name.to_string())).collect();
    let signal = phase.signal_ref();
    wave.load_signals(&[signal]);
    let seen: Vec<String> = wave
        .get_signal(signal)
        .unwrap()
        .iter_changes()
        .map(|(_, value)| names[&value.to_bit_string().unwrap()].clone())
        .collect();
    assert_eq!(seen, ["Idle", "Store", "Resolve", "Idle"]);
}

#[test]
fn the_list_names_what_can_be_chosen() {
    let folder = folder();
    let text = exact(pellucid(folder.path(), &["list"]));
    let json = exact(pellucid(folder.path(), &["list", "--json"]));
    let json: Value = serde_json::from_str(stdout(&json)).unwrap();
    let architecture = &json["architectures"][0];
    for group in [&architecture["presets"], &architecture["parameters"], &json["scenes"]] {
        for entry in group.as_array().unwrap() {
            assert!(stdout(&text).contains(entry["name"].as_str().unwrap()), "{entry}");
            assert!(stdout(&text).contains(entry["about"].as_str().unwrap()), "{entry}");
        }
    }
}

#[test]
fn the_list_of_one_architecture_has_no_other() {
    let folder = folder();
    let text = exact(pellucid(folder.path(), &["list", "rbuffer"]));
    let text = stdout(&text);
    assert!(text.contains("\n  rbuffer  ") && text.contains("outside_queue"), "{text}");
    assert!(!text.contains("tbuffer") && !text.contains("SCENES"), "{text}");
    let json = exact(pellucid(folder.path(), &["list", "rbuffer", "--json"]));
    let json: Value = serde_json::from_str(stdout(&json)).unwrap();
    assert_eq!(json["architectures"].as_array().unwrap().len(), 1);
    assert_eq!(json["architectures"][0]["name"], "rbuffer");
    refused(
        folder.path(),
        &["list", "tbufer"],
        "unknown architecture `tbufer` (did you mean `tbuffer`?); known are `tbuffer`, `rbuffer`, `mbuffer`, `composer`, `dfb`, `b3d`, `ppll`, `fbuffer`, `accumulate`",
    );
}

#[test]
fn a_scene_where_a_command_should_be_gets_a_hint() {
    let folder = folder();
    for (scene, option) in [
        ("model.glb", "--scene model.glb"),
        ("glass", "--scene glass"),
        ("quads-5-50", "--scene quads-5-50"),
        ("my frame.csv", "--scene 'my frame.csv'"),
    ] {
        let output = pellucid(folder.path(), &[scene]);
        let text = stderr(&output);
        let tip = format!("\n\n  tip: a scene is given as '{option}'\n");
        assert!(text.starts_with(&format!("error: unrecognized subcommand '{scene}'")), "{text}");
        assert!(text.contains(&tip) && text.matches("tip").count() == 1, "{text}");
        assert_eq!(output.status.code(), Some(2));
    }
}

/// Once where the machine keeps all of it, else as often as it asked for it.
#[test]
fn it_is_told_how_often_a_frame_came() {
    let folder = folder();
    let stats = |args: &[&str]| {
        exact(run(folder.path(), &[&["--out", "out", "--no-wave"], args].concat()));
        stats(&folder.path().join("out"))
    };
    let plays = |stats: &Value| {
        let frames = stats["frames"].as_array().unwrap().iter();
        let each: u64 = frames.map(|frame| frame["plays"].as_u64().unwrap()).sum();
        assert_eq!(stats["frame"]["plays"], each);
        each
    };
    assert_eq!(plays(&stats(&["--frames", "2"])), 2);
    let rounds = stats(&["--arch", "rbuffer", "-p", "overflow=replay", "-p", "queue=300"]);
    assert!(plays(&rounds) > 1);
    assert_eq!(rounds["rbuffer"]["rounds"], plays(&rounds));
    let bands = stats(&["--arch", "dfb", "-p", "fragments=300", "-p", "outside_fragments=0"]);
    assert!(plays(&bands) > 2);
    assert_eq!(bands["dfb"]["bands"], plays(&bands) - 1);
    for (arch, few) in [("b3d", "layers=1"), ("ppll", "pages=9")] {
        let rebuilt = stats(&["--arch", arch, "-p", few]);
        assert!(plays(&rebuilt) > 1, "{arch}");
        assert_eq!(rebuilt[arch]["rebuilds"], plays(&rebuilt) - 1, "{arch}");
        // Of what was in front when it first came some is hidden in the end: it is stored, and never resolved.
        let fragments = |name: &str| rebuilt["fragments"][name].as_f64().unwrap();
        assert!(fragments("blended") < fragments("stored"), "{arch}");
        let expected = fragments("blended") / rebuilt["cycles"]["resolve"].as_f64().unwrap();
        let rate = rebuilt["rates"]["resolved"].as_f64().unwrap();
        assert!((rate - expected).abs() < 0.0001 && rate <= 1.0, "{arch}: {rate}");
    }
}
