//! How viewers show a run's waveform.

use super::wave::{Wave, places};
use super::*;
use pellucid_hw::ARCHITECTURES;
use std::collections::BTreeSet;

/// The bundle of a run is whole in either format, whatever the architecture, and made of these files.
#[test]
fn the_bundle_has_a_set_up_for_either_viewer() {
    let formats = [("vcd", "wave.vcd"), ("fst", "wave.fst")];
    for (arch, (format, file)) in ARCHITECTURES.iter().zip(formats.into_iter().cycle()) {
        let folder = folder();
        exact(run(folder.path(), &["--arch", arch.name, "--wave-format", format, "-q"]));
        let out = folder.path().join("pellucid-out");
        let expected = [
            ".surfer",
            "image.png",
            "stats.csv",
            "stats.json",
            file,
            "wave.gtkw",
            "wave.states",
            "wave.sucl",
        ];
        let mut expected = expected.map(str::to_string);
        expected.sort();
        assert_eq!(names(&out), expected);
        let save = fs::read_to_string(out.join("wave.gtkw")).unwrap();
        assert!(save.starts_with(&format!("[dumpfile] \"{file}\"\n")));
        for line in save.lines().filter_map(|line| line.strip_prefix('^')) {
            let filter = line.split_once(' ').unwrap().1;
            assert!(out.join(filter).is_file(), "{filter}");
        }
        let commands = fs::read_to_string(out.join("wave.sucl")).unwrap();
        let wave = Wave::read(&out.join(file));
        let variables = commands.lines().filter_map(|line| line.strip_prefix("variable_add "));
        let known: BTreeSet<String> =
            wave.signals.keys().map(|name| name.replace(".[", "[")).collect();
        for variable in variables {
            assert!(known.contains(variable), "{variable}");
        }
        let mappings = names(&out.join(".surfer/mappings"));
        for name in mappings.iter().map(|name| name.strip_suffix(".txt").unwrap()) {
            assert!(commands.contains(&format!("item_set_format {name}\n")), "{name}");
        }
    }
}

/// The lines of a save file that begin a group: its name, and whether it is open.
fn groups(save: &str) -> BTreeMap<&str, bool> {
    let lines: Vec<&str> = save.lines().collect();
    let begins = lines.windows(2).filter(|pair| ["@800200", "@c00200"].contains(&pair[0]));
    begins.map(|pair| (&pair[1][1..], pair[0] == "@800200")).collect()
}

/// The zoom of a save file: cycles are as wide in pixels.
fn cycle_pixels(save: &str) -> f64 {
    let zoom = save.lines().find_map(|line| line.strip_prefix("*-")).unwrap();
    10.0 * 200.0 / zoom.split_once(' ').unwrap().0.parse::<f64>().unwrap().exp2()
}

#[test]
fn the_groups_of_a_followed_fragment_are_open_and_no_others() {
    let folder = folder();
    let words = "chains.nsa.table:0..2";
    exact(run(folder.path(), &["--follow-fragment", "1000", "--wave-memory", words, "-q"]));
    let out = folder.path().join("pellucid-out");
    let save = fs::read_to_string(out.join("wave.gtkw")).unwrap();
    let wave = Wave::read(&out.join("wave.vcd"));
    let first = wave.changes("top.machine.wires.fragment.label");
    let (_, label) = first.iter().find(|(_, label)| label.starts_with("#1000(")).unwrap();
    let groups = groups(&save);
    let open = |name: &str| groups[name];
    // Streams by their paths; blocks by their names.
    for stream in ["fragment", "passed", "sorted", "chains.arrived"] {
        assert!(open(stream), "{stream} is folded: {groups:?}");
    }
    for block in ["front.depth_test", "chains.store", "sorter", "blender"] {
        assert!(open(block), "{block} is folded: {groups:?}");
    }
    // Words are there because they are asked for.
    assert!(open("chains.nsa.table.word[1]: words"), "{groups:?}");
    let was = places(&wave, label);
    let streams = groups
        .iter()
        .filter(|(name, _)| wave.signals.contains_key(&format!("top.machine.wires.{name}.label")));
    for (name, open) in streams {
        assert_eq!(*open, was.contains_key(&format!("wires.{name}.label")), "{name}");
    }
    for other in ["events", "chains.events", "image", "front: registers", "sorter: registers"] {
        assert!(!open(other), "{other} is open: {groups:?}");
    }
    // Seven pixels a character.
    assert!(cycle_pixels(&save) > 7.0 * label.len() as f64, "{label} is cut");
}

#[test]
fn what_was_waited_for_stands_at_the_top() {
    let folder = folder();
    let few =
        ["-p", "sections=100", "-p", "outside_sections=4000", "--wave", "event:spilled", "-q"];
    exact(run(folder.path(), &few));
    let save = fs::read_to_string(folder.path().join("pellucid-out/wave.gtkw")).unwrap();
    let shown: Vec<&str> = save.lines().filter(|line| line.starts_with("top.")).collect();
    assert_eq!(shown[2], "top.machine.wires.chains.events.spilled");
}
