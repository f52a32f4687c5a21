//! Energy, area and time of a run.

use super::*;

const TABLE: &str = include_str!("../../../sram/src/cacti7.csv");

/// A run's figures.
fn figures(folder: &Path, args: &[&str]) -> Value {
    exact(run(folder, &[&["--no-wave", "-q", "--out", "out"], args].concat()));
    stats(&folder.join("out"))
}

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap_or_else(|| panic!("{of} is no number"))
}

/// Equal but for the rounding to four digits.
#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 2e-3 * expected, "{found} and {expected}");
}

/// The sum of a field of all memories that have it.
fn sum(stats: &Value, field: &str) -> f64 {
    stats["memories"].as_array().unwrap().iter().filter_map(|memory| memory[field].as_f64()).sum()
}

#[test]
fn the_parts_make_up_the_whole() {
    let folder = folder();
    for (outside, more) in [("fixed", "clock_mhz=400"), ("ddr4-3200", "sections=1")] {
        let outside = format!("outside={outside}");
        let stats = figures(folder.path(), &["-p", &outside, "-p", more]);
        let (energy, area, time) = (&stats["energy"], &stats["area"], &stats["time"]);
        near(sum(&stats, "read_energy"), number(&energy["reads"]));
        near(sum(&stats, "write_energy"), number(&energy["writes"]));
        near(sum(&stats, "leakage_energy"), number(&energy["leakage"]));
        near(sum(&stats, "area"), number(&area["memories"]));
        let parts = ["reads", "writes", "leakage"].iter().map(|kind| number(&energy[*kind]));
        near(parts.sum(), number(&energy["on_chip"]));
        let kinds = ["activates", "reads", "writes", "refreshes", "background"];
        let of_outside = kinds.iter().filter_map(|kind| energy[format!("outside_{kind}")].as_f64());
        near(number(&energy["on_chip"]) + of_outside.sum::<f64>(), number(&energy["total"]));
        let frame = number(&stats["cycles"]["total"]) / number(&time["clock"]);
        near(frame, number(&time["frame"]));
        // What is not counted says where it comes from, and how far to trust it.
        let about = stats["about"].as_object().unwrap();
        let groups = ["energy.", "area.", "time."];
        let priced: Vec<_> =
            about.iter().filter(|(name, _)| groups.iter().any(|g| name.starts_with(g))).collect();
        assert!(priced.len() >= 9, "{priced:?}");
        let memories = ["read_energy", "write_energy", "leakage_energy", "area", "access_time"];
        let memories = memories.map(|field| format!("memories[].{field}"));
        for what in
            priced.into_iter().map(|(_, what)| what).chain(memories.iter().map(|name| &about[name]))
        {
            assert!(
                ["unit", "about", "source", "error"].iter().all(|key| what[key].is_string()),
                "{what}"
            );
        }
        for memory in stats["memories"].as_array().unwrap() {
            let outside = memory["name"] == "chains.sections.outside";
            assert_eq!(memory.get("area").is_none(), outside, "{memory}");
        }
    }
}

/// Fragments lie outside, and nobody knows in what.
#[test]
fn what_is_outside_and_not_known_leaves_no_total() {
    let folder = folder();
    for outside in ["fixed", "hbm3-6400"] {
        let outside = format!("outside={outside}");
        let args = ["--no-wave", "-p", "sections=1", "-p", &outside];
        let output = exact(run(folder.path(), &args));
        assert!(
            stdout(&output).contains(" What is outside is not known.\n"),
            "{}",
            stdout(&output)
        );
        let energy = &stats(&folder.path().join("pellucid-out"))["energy"];
        assert!(energy.get("total").is_none() && energy["on_chip"].is_number(), "{energy}");
    }
}

#[test]
fn a_slower_clock_takes_longer_and_leaks_more() {
    let folder = folder();
    let [fast, slow] =
        ["clock_mhz=800", "clock_mhz=200"].map(|clock| figures(folder.path(), &["-p", clock]));
    assert_eq!(fast["cycles"], slow["cycles"]);
    assert_eq!(fast["energy"]["reads"], slow["energy"]["reads"]);
    near(4.0 * number(&fast["time"]["frame"]), number(&slow["time"]["frame"]));
    near(4.0 * number(&fast["energy"]["leakage"]), number(&slow["energy"]["leakage"]));
    let free = figures(folder.path(), &[]);
    assert_eq!(free["time"]["clock"], free["time"]["fastest_clock"]);
    assert_eq!(free["time"]["fastest_clock"], fast["time"]["fastest_clock"]);
}

#[test]
fn a_table_of_ones_own_is_taken() {
    let folder = folder();
    // Reads at 22 nm take three times as much; all else is as it was.
    let rows = TABLE.lines().map(|line| match line.strip_prefix("22,") {
        None => line.to_string(),
        Some(_) => {
            let mut fields: Vec<String> = line.split(',').map(String::from).collect();
            fields[6] = (3.0 * fields[6].parse::<f64>().unwrap()).to_string();
            fields.join(",")
        }
    });
    let text = rows.collect::<Vec<_>>().join("\n");
    fs::write(folder.path().join("my.csv"), text).unwrap();
    let shipped = figures(folder.path(), &[]);
    let own = figures(folder.path(), &["--sram", "my.csv"]);
    near(number(&own["energy"]["reads"]), 3.0 * number(&shipped["energy"]["reads"]));
    assert_eq!(own["energy"]["writes"], shipped["energy"]["writes"]);
    assert_eq!(own["area"], shipped["area"]);
    assert_eq!(own["about"]["energy.reads"]["source"], "my.csv, 22 nm");
    let old = figures(folder.path(), &["--node", "45"]);
    assert!(number(&old["area"]["memories"]) > 3.0 * number(&shipped["area"]["memories"]));
    assert_eq!(old["about"]["area.memories"]["source"], "CACTI 7, 45 nm");
}

#[test]
fn a_comparison_has_them_side_by_side() {
    let folder = folder();
    let machines = ["--machine", "tbuffer", "--machine", "tbuffer:fast,clock_mhz=100"];
    let args = [&["compare", "--node", "32", "--json"], &SMALL[..], &machines].concat();
    let output = exact(pellucid(folder.path(), &args));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    let [free, slow] = [0, 1].map(|k| &json["scenes"][0]["machines"][k]);
    assert_eq!(free["area"], slow["area"]);
    assert_eq!(slow["time"]["clock"], 100);
    assert!(number(&free["time"]["frame"]) < number(&slow["time"]["frame"]));
    assert!(json["command"].as_str().unwrap().ends_with("--node 32"), "{}", json["command"]);
    assert_eq!(json["about"]["area.memories"]["source"], "CACTI 7, 32 nm");
    let page = fs::read_to_string(folder.path().join("pellucid-compare/compare.html")).unwrap();
    for caption in
        ["time.frame, in us.", "energy.total, in nJ per frame.", "area.memories, in mm2."]
    {
        assert!(page.contains(caption), "{caption}");
    }
}

#[test]
fn what_is_wrong_with_the_table_is_named() {
    let folder = folder();
    refused(
        folder.path(),
        &["run", "--node", "28"],
        "--node 28: unknown node `28`; known are `22`, `32`, `45` (nm, of CACTI 7)",
    );
    refused(
        folder.path(),
        &["compare", "--sram", "none.csv"],
        "none.csv: No such file or directory (os error 2)",
    );
    let hole: Vec<&str> =
        TABLE.lines().filter(|line| !line.starts_with("22,1rw,64,4096,")).collect();
    fs::write(folder.path().join("hole.csv"), hole.join("\n")).unwrap();
    refused(
        folder.path(),
        &["run", "--sram", "hole.csv"],
        "hole.csv: node 22, 1rw: no row with 64 word_bits and 4096 bytes: expected every size with every width",
    );
    fs::write(folder.path().join("word.csv"), TABLE.replace("0.0902126", "fast")).unwrap();
    let line = 1 + TABLE.lines().position(|line| line.contains("0.0902126")).unwrap();
    refused(
        folder.path(),
        &["run", "--sram", "word.csv"],
        &format!("word.csv: line {line}: column access_ns is `fast`: expected a number above 0"),
    );
    assert_eq!(names(folder.path()), ["hole.csv", "word.csv"]);
}

#[test]
fn what_commands_take_may_be_said_by_a_file() {
    let folder = folder();
    let file = "[energy]\nactivate_pj = 1000\nread_pj = 20\nwrite_pj = 30\nrefresh_pj = 0\nbackground_mw = 0\n";
    fs::write(folder.path().join("my.toml"), file).unwrap();
    // A part that says nothing of it.
    let part = ["-p", "sections=1", "-p", "outside=hbm3-6400"];
    let own = figures(folder.path(), &[&part[..], &["--energy", "my.toml"]].concat());
    let outside = |name: &str| number(&own["outside"][name]);
    let energy = |name: &str| number(&own["energy"][name]);
    near(energy("outside_activates"), outside("row_misses") + outside("row_conflicts"));
    // Bursts of 32 bytes.
    let bursts = energy("outside_reads") / 0.02 + energy("outside_writes") / 0.03;
    near(bursts, outside("bytes_moved") / 32.0);
    assert_eq!(own["energy"]["outside_background"], 0);
    assert_eq!(own["config"]["dram_energy"], "my.toml");
    let same = figures(folder.path(), &[&part[..], &["-p", "dram_energy=my.toml"]].concat());
    assert_eq!(same["energy"], own["energy"]);

    fs::write(folder.path().join("hole.toml"), file.replace("read_pj = 20\n", "")).unwrap();
    let run = |args: &[&'static str]| [&["run"], &part[..], args].concat();
    refused(
        folder.path(),
        &run(&["--energy", "hole.toml"]),
        "--energy hole.toml: hole.toml: `energy.read_pj` is missing: expected a whole number from 0 to 1000000000",
    );
    refused(
        folder.path(),
        &["run", "--energy", "my.toml"],
        "--energy my.toml: `dram_energy` needs a DRAM: expected `outside=` and a part",
    );
}
