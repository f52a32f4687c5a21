//! The set-ups for viewers, line by line.

use crate::machine::layout;
use pellucid_waveforms::{FileFormat, Marker, View};
use std::collections::BTreeMap;

/// The files by name.
fn files(format: FileFormat) -> BTreeMap<String, String> {
    let marker = |cycle, name: &str| Marker { cycle, name: name.into() };
    let markers = vec![marker(40, "passed stalls"), marker(7, "#3(1,2) store")];
    let view = View { stem: "wave".into(), format, markers, first: 4 };
    view.files(&layout()).into_iter().map(|file| (file.name, file.text)).collect()
}

#[test]
fn there_is_a_file_for_every_viewer_and_table() {
    let names: Vec<String> = files(FileFormat::Vcd).into_keys().collect();
    let expected = [
        ".surfer/mappings/phase.txt",
        ".surfer/mappings/scan_fsm.txt",
        "wave.gtkw",
        "wave.states/phase",
        "wave.states/scan_fsm",
        "wave.sucl",
    ];
    assert_eq!(names, expected);
}

#[test]
fn gtkwave_shows_blocks_in_order_with_their_streams_and_states() {
    let files = files(FileFormat::Vcd);
    let states = "0 ?DarkSlateGray?Idle\n1 ?DarkGreen?Run\n2 ?DarkBlue?Stall\n";
    assert_eq!(files["wave.states/phase"], states);
    let none = " -1".repeat(24);
    let expected = format!(
        "[dumpfile] \"wave.vcd\"\n[savefile] \"wave.gtkw\"\n[timestart] 340\n[size] 1600 1000\n\
         [pos] -1 -1\n*-5.000000 400 400 70{none}\n[markername] Apassed stalls\n\
         [markername] B#3(1,2) store\n[sst_width] 220\n[signals_width] 260\n[sst_expanded] 0\n\
         @28\ntop.clk\n@24\ntop.cycle[39:0]\n\
         @2022\n^1 wave.states/phase\ntop.machine.wires.phase[1:0]\n\
         @800200\n-events\n@28\n[color] 1\ntop.machine.wires.events.dropped\n@1000200\n-events\n\
         @800200\n-store\n@800200\n-passed\n\
         @820\n[color] 5\n+{{passed}} top.machine.wires.passed.label\n\
         @28\ntop.machine.wires.passed.valid\n@28\ntop.machine.wires.passed.ready\n\
         @28\n[color] 1\ntop.machine.wires.passed.stall\n\
         @22\ntop.machine.wires.passed.payload.z[23:0]\n@1000200\n-passed\n\
         @820\n[color] 5\n+{{stage}} top.machine.registers.store.stage.label\n\
         @c00200\n-store: registers\n\
         @2022\n^1 wave.states/phase\ntop.machine.registers.store.fsm[1:0]\n\
         @28\ntop.machine.registers.store.stage.valid\n\
         @24\ntop.machine.registers.store.stage.payload.pixel[11:0]\n\
         @8024\ntop.machine.registers.store.queue.count[2:0]\n@20000\n-\n\
         @1401200\n-store: registers\n@1000200\n-store\n\
         @c00200\n-scan: registers\n\
         @2022\n^2 wave.states/scan_fsm\ntop.machine.registers.scan.fsm[1:0]\n\
         @22\ntop.machine.registers.scan.entries[3][63:0]\n\
         @1401200\n-scan: registers\n"
    );
    assert_eq!(files["wave.gtkw"], expected);
}

#[test]
fn labels_are_characters_in_an_fst() {
    let files = files(FileFormat::Fst);
    let save = &files["wave.gtkw"];
    assert!(save.starts_with("[dumpfile] \"wave.fst\"\n"), "{save}");
    assert!(save.contains("+{passed} top.machine.wires.passed.label[191:0]\n"), "{save}");
    let label = "variable_add top.machine.wires.passed.label\nitem_set_format ASCII\n";
    assert!(files["wave.sucl"].contains(label), "{}", files["wave.sucl"]);
}

#[test]
fn surfer_shows_the_same_list() {
    let files = files(FileFormat::Vcd);
    let mapping = "Name = scan_fsm\nBits = 2\n0[#2f4f4f] Idle\n1[#006400] Load\n2[#00008b] Drain\n\
                   3[#551a8b] Stall\n";
    assert_eq!(files[".surfer/mappings/scan_fsm.txt"], mapping);
    let commands = &files["wave.sucl"];
    let variables = |text: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|line| line.strip_prefix("variable_add "));
        lines.map(str::to_string).collect()
    };
    // The same signals as in GTKWave, without ranges and aliases.
    let save = files["wave.gtkw"].lines().filter_map(|line| line.split_once("top.").map(|l| l.1));
    let shown: Vec<String> = save
        .map(|path| {
            let path = match path.rsplit_once('[') {
                Some((path, range)) if range.contains(':') => path,
                _ => path,
            };
            format!("top.{path}")
        })
        .collect();
    assert_eq!(variables(commands), shown);
    let fsm = "variable_add top.machine.registers.scan.fsm\nitem_set_format scan_fsm\n";
    assert!(commands.contains(fsm), "{commands}");
    let end =
        "cursor_set 400\nmarker_set passed_stalls 400\nmarker_set 3(1,2)_store 70\ngoto_cursor\n";
    assert!(commands.ends_with(end), "{commands}");
}

#[test]
fn without_markers_the_view_begins_with_the_first_cycle() {
    let view = View { stem: "w".into(), format: FileFormat::Vcd, markers: vec![], first: 70 };
    let files = view.files(&layout());
    let save = files.iter().find(|file| file.name == "w.gtkw").unwrap();
    assert!(save.text.contains("[timestart] 700\n"), "{}", save.text);
    assert!(save.text.contains("*-5.000000 700 -1"), "{}", save.text);
}
