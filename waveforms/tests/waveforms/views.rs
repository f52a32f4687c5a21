//! The set-ups for viewers, line by line.

use crate::machine::layout;
use pellucid_sim::{Declare, Kind};
use pellucid_waveforms::{FileFormat, Found, Layout, Marker, View};
use std::collections::BTreeMap;

fn view(format: FileFormat) -> View {
    let marker = |cycle, name: &str| Marker { cycle, name: name.into() };
    let markers = vec![marker(40, "passed stalls"), marker(7, "#3(1,2) store")];
    View { stem: "wave".into(), format, markers, first: 4, ..View::default() }
}

/// The files of a view by name.
fn files_of(view: &View) -> BTreeMap<String, String> {
    view.files(&layout()).into_iter().map(|file| (file.name, file.text)).collect()
}

fn files(format: FileFormat) -> BTreeMap<String, String> {
    files_of(&view(format))
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
        "[dumpfile] \"wave.vcd\"\n[savefile] \"wave.gtkw\"\n[timestart] 370\n[size] 1600 1000\n\
         [pos] -1 -1\n*-4.965784 400 400 70{none}\n[markername] Apassed stalls\n\
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

/// A block that is tested on its own: its plain registers are there, those in groups too, and none is folded.
#[test]
fn a_block_alone_shows_all_of_its_registers_open() {
    let layout = Layout::new(vec![], |to: &mut dyn Declare| {
        to.open("queue");
        to.open("registers");
        to.signal("head", 3, Kind::Bits(32));
        to.open("offer");
        to.signal("valid", 1, Kind::Flag);
        to.close();
        to.close();
        to.open("wires");
        to.signal("reset", 1, Kind::Flag);
        to.close();
        to.close();
    });
    let view = View { stem: "w".into(), ..View::default() };
    let files = view.files(&layout);
    let save = &files.iter().find(|file| file.name == "w.gtkw").unwrap().text;
    let shown = "@28\ntop.queue.wires.reset\n\
                 @800200\n-queue: registers\n@24\ntop.queue.registers.head[2:0]\n\
                 @1000200\n-queue: registers\n\
                 @800200\n-offer: registers\n@28\ntop.queue.registers.offer.valid\n\
                 @1000200\n-offer: registers\n";
    assert!(save.ends_with(shown), "{save}");
}

/// GTKWave writes a name to both sides of its marker. Here a cycle is as wide as 12 characters.
#[test]
fn a_name_that_the_left_edge_would_cut_begins_at_its_marker() {
    let line = |cycle, name: &str| {
        let markers = vec![Marker { cycle, name: name.into() }];
        let view = View { stem: "w".into(), markers, ..View::default() };
        let files = view.files(&layout());
        let save = &files.iter().find(|file| file.name == "w.gtkw").unwrap().text;
        save.lines().find_map(|line| line.strip_prefix("[markername] A")).unwrap().to_string()
    };
    assert_eq!(line(0, "lost"), "    lost");
    let (fits, cut) = ("x".repeat(24), "x".repeat(25));
    assert_eq!(line(1, &fits), fits);
    assert_eq!(line(1, &cut), format!("{}{cut}", " ".repeat(25)));
    assert_eq!(line(2, &cut), cut);
}

#[test]
fn without_markers_the_view_begins_with_the_first_cycle() {
    let view = View { stem: "w".into(), first: 70, ..View::default() };
    let files = view.files(&layout());
    let save = files.iter().find(|file| file.name == "w.gtkw").unwrap();
    assert!(save.text.contains("[timestart] 700\n"), "{}", save.text);
    assert!(save.text.contains("*-4.965784 700 -1"), "{}", save.text);
}

/// GTKWave's zoom -z shows 2^z units of time on 200 pixels, and a character of its font is 7 pixels wide.
#[test]
fn a_cycle_is_as_wide_as_the_longest_label() {
    for (chars, pixels) in [(0, 64.0), (7, 64.0), (12, 94.0), (24, 178.0)] {
        let view = View { longest_label: chars, ..view(FileFormat::Vcd) };
        let save = &files_of(&view)["wave.gtkw"];
        let zoom = save.lines().find_map(|line| line.strip_prefix("*-")).unwrap();
        let zoom: f64 = zoom.split_once(' ').unwrap().0.parse().unwrap();
        let cycle = 10.0 / zoom.exp2() * 200.0;
        assert!((cycle - pixels).abs() < 0.01, "{chars} characters on {cycle} pixels");
    }
}

/// The lines of a save file that begin a group: its name, and whether it is open.
fn groups(save: &str) -> Vec<(&str, bool)> {
    let lines: Vec<&str> = save.lines().collect();
    let begins = lines.windows(2).filter(|pair| ["@800200", "@c00200"].contains(&pair[0]));
    begins.map(|pair| (&pair[1][1..], pair[0] == "@800200")).collect()
}

#[test]
fn where_something_was_followed_only_its_groups_are_open() {
    // Label 0 is in a stage of the block `store`, label 1 on the stream `passed` that it receives.
    for (labels, open) in [
        (vec![0], vec!["store"]),
        (vec![1], vec!["store", "passed"]),
        (vec![], vec!["events", "store", "passed"]),
    ] {
        let found = Found { labels, values: vec![] };
        let save = &files_of(&View { found, ..view(FileFormat::Vcd) })["wave.gtkw"];
        let all = groups(save);
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["events", "store", "passed", "store: registers", "scan: registers"]);
        let opened: Vec<&str> = all.iter().filter(|group| group.1).map(|group| group.0).collect();
        assert_eq!(opened, open);
    }
}

#[test]
fn what_was_looked_for_stands_at_the_top() {
    let layout = layout();
    let (_, dropped) = layout.events().next().unwrap();
    let (_, stall) = layout.stalls().next().unwrap();
    let found = Found { values: vec![dropped, stall], labels: vec![0] };
    let save = &files_of(&View { found, ..view(FileFormat::Vcd) })["wave.gtkw"];
    let top = "top.cycle[39:0]\n@28\n[color] 1\ntop.machine.wires.events.dropped\n\
               @800200\n-passed\n@820\n[color] 5\n+{passed} top.machine.wires.passed.label\n\
               @28\ntop.machine.wires.passed.valid\n@28\ntop.machine.wires.passed.ready\n\
               @28\n[color] 1\ntop.machine.wires.passed.stall\n@1000200\n-passed\n\
               @2022\n^1 wave.states/phase\ntop.machine.wires.phase[1:0]\n";
    assert!(save.contains(top), "{save}");
}
