//! What a run leaves, and that it holds together.

use super::*;

#[test]
fn an_exact_run_leaves_its_files_and_says_so() {
    let folder = folder();
    let output = exact(run(folder.path(), &[]));
    let text = stdout(&output);
    assert!(text.starts_with("FRAME\n"), "{text}");
    assert!(
        text.contains(
            "\nThe image equals the golden model's, bit for bit, and every count its closed form.\n"
        ),
        "{text}"
    );
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
    assert!(said.starts_with(&format!("error: {start}")), "{said}");
    assert_eq!(said.lines().count(), 1);
    assert_eq!(output.status.code(), Some(1));
    assert!(out.join("image.png").is_file());

    let output = run(folder.path(), &[&few[..], &["--allow-drops", "--quiet"]].concat());
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
    let phase = var("top.machine.registers.course.phase");
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
