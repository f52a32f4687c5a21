//! The exported Verilog against the Rust run, every output on every cycle, in Icarus and in Verilator. The netlist itself
//! is compared with the machine in the tests of each architecture, which need no tool.

mod tools;

use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A screen that is small enough for an event-driven simulator.
const SMALL: [&str; 4] = ["--width", "40", "--height", "30"];

/// The four ways in which a T-buffer stores and scans, and the other machines; the architecture's name
/// stands second.
const WAYS: [&[&str]; 17] = [
    &["--arch", "tbuffer", "-p", "append=tail", "-p", "scan=bitmap"],
    &["--arch", "tbuffer", "-p", "append=tail", "-p", "scan=linear"],
    &["--arch", "tbuffer", "-p", "append=walk", "-p", "scan=bitmap"],
    &["--arch", "tbuffer", "-p", "append=walk", "-p", "scan=linear"],
    &["--arch", "tbuffer", "-p", "allocator=bump"],
    &["--arch", "tbuffer", "-p", "allocator=lifo"],
    &["--arch", "tbuffer", "-p", "allocator=threaded"],
    &["--arch", "tbuffer", "-p", "allocator=hierarchical"],
    &["--arch", "tbuffer", "-p", "allocator=cached"],
    &[
        "--arch",
        "tbuffer",
        "-p",
        "allocator=bitmap",
        "-p",
        "sections=4096",
        "-p",
        "outside_sections=4096",
        "-p",
        "section_capacity=8",
    ],
    &["--arch", "rbuffer"],
    &["--arch", "rbuffer", "-p", "overflow=replay"],
    &["--arch", "mbuffer", "-p", "weights=registers"],
    &["--arch", "mbuffer", "-p", "weights=memory"],
    &["--arch", "mbuffer", "-p", "allocator=threaded", "-p", "weights=memory"],
    &["--arch", "composer"],
    &["--arch", "composer", "-p", "scan_line_engines=2", "-p", "distribution=area", "-p", "beta=0"],
];

/// Fragment stores behind the image merger. They are machines of their own above, so that few pixels are enough.
const STORES: [&[&str]; 2] = [
    &["--arch", "composer", "-p", "transparency=tbuffer", "-p", "tbuffer.sections=20"],
    &[
        "--arch",
        "composer",
        "-p",
        "transparency=rbuffer",
        "-p",
        "rbuffer.overflow=replay",
        "-p",
        "rbuffer.queue=40",
    ],
];

/// Those of them that are worth a larger frame: allocators differ where little is free, and the image composition
/// machine has so much in it that Verilator has to play it.
fn worth_a_frame(way: &[&str]) -> bool {
    way[1] != "composer" && !way.iter().any(|arg| arg.starts_with("allocator="))
}

/// What makes a machine work hard on a small screen: too little room on chip, and pixels deeper than the
/// T-buffer's sorter, so that outside memory is used and several passes occur.
fn tight(arch: &str) -> &'static [&'static str] {
    match arch {
        "tbuffer" => &[
            "-p",
            "sections=150",
            "-p",
            "outside_sections=900",
            "-p",
            "sorter_depth=2",
            "-p",
            "section_capacity=2",
        ],
        "mbuffer" => &[
            "-p",
            "overflow_sections=150",
            "-p",
            "outside_sections=900",
            "-p",
            "outside_latency=9",
            "-p",
            "array=2",
        ],
        "composer" => &[
            "-p",
            "engines=3",
            "-p",
            "primitives=4096",
            "-p",
            "line_primitives=512",
            "-p",
            "sorter_depth=3",
        ],
        _ => &["-p", "queue=80", "-p", "outside_queue=3000", "-p", "outside_latency=9"],
    }
}

/// Exports into a new folder.
#[track_caller]
fn export(args: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["export", "--quiet", "--out"])
        .arg(folder.path())
        .args(args)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    folder
}

fn in_folder(folder: &Path, program: &str, args: &[&str]) -> Output {
    Command::new(program).args(args).current_dir(folder).output().unwrap()
}

fn text(output: &Output) -> String {
    let both = [&output.stdout[..], &output.stderr[..]].concat();
    String::from_utf8_lossy(&both).into_owned()
}

/// How many cycles were recorded.
fn recorded(folder: &Path) -> u64 {
    let vectors = std::fs::read_to_string(folder.join("vectors.txt")).unwrap();
    let lines = vectors.lines().map(|line| line.split(' ').collect::<Vec<_>>());
    let played = lines.filter(|fields| fields[1] == "0");
    played.map(|fields| fields[0].parse::<u64>().unwrap()).sum()
}

/// Builds and runs the testbench in Icarus.
fn icarus(folder: &Path) -> Output {
    let build =
        in_folder(folder, "iverilog", &["-g2005", "-Wall", "-o", "lockstep", "-f", "files.f"]);
    assert_eq!(text(&build), "", "Icarus takes every file without a warning");
    in_folder(folder, "vvp", &["-N", "lockstep"])
}

/// Builds and runs the testbench in Verilator.
fn verilator(folder: &Path) -> Output {
    let args = ["--binary", "-O3", "--top-module", "lockstep_tb", "-f", "files.f"];
    let build = in_folder(folder, "verilator", &args);
    assert!(build.status.success(), "{}", text(&build));
    in_folder(folder, "obj_dir/Vlockstep_tb", &[])
}

#[track_caller]
fn passes(folder: &Path, run: &Output) {
    let expected = format!("PASS: {} cycles, every output equal", recorded(folder));
    assert!(text(run).contains(&expected), "expected `{expected}`, found:\n{}", text(run));
    assert!(run.status.success());
}

#[test]
fn icarus_agrees_with_frames_resets_and_stalls_in_every_way() {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    for way in WAYS {
        let folder = export(&[&SMALL[..], way, tight(way[1]), &["--stress"]].concat());
        passes(folder.path(), &icarus(folder.path()));
    }
}

#[test]
fn icarus_agrees_with_a_fragment_store_behind_the_merger() {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    for way in STORES {
        let few = ["--scene", "panes", "--width", "16", "--height", "12", "-p", "engines=2"];
        let folder = export(&[&few[..], way, &["-p", "primitives=16", "--stress"]].concat());
        passes(folder.path(), &icarus(folder.path()));
    }
}

#[test]
fn icarus_agrees_over_a_complete_frame() {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    for way in WAYS.iter().filter(|way| worth_a_frame(way)) {
        let screen = ["--width", "160", "--height", "120"];
        let folder = export(&[&screen[..], way].concat());
        passes(folder.path(), &icarus(folder.path()));
    }
}

#[test]
fn verilator_has_no_complaint() {
    if !tools::have(&["verilator"]) {
        return;
    }
    for way in WAYS.into_iter().chain(STORES) {
        let engines: &[&str] = if way[1] == "composer" { &["-p", "engines=2"] } else { &[] };
        let folder = export(&[&["--width", "4", "--height", "3"][..], way, engines].concat());
        let list = std::fs::read_to_string(folder.path().join("files.f")).unwrap();
        let modules = list.lines().filter(|file| !file.starts_with("lockstep"));
        let mut args = vec!["--lint-only", "-Wall", "--top-module", way[1]];
        args.extend(modules);
        let lint = in_folder(folder.path(), "verilator", &args);
        assert_eq!(text(&lint), "", "{way:?}");
        assert!(lint.status.success());
    }
}

#[test]
fn verilator_agrees_over_a_large_frame_and_over_stress() {
    if !tools::have(&["verilator"]) {
        return;
    }
    for arch in ["tbuffer", "rbuffer", "mbuffer"] {
        let folder = export(&["--arch", arch, "--scene", "paper-480"]);
        passes(folder.path(), &verilator(folder.path()));
    }
    let composer = ["--arch", "composer", "--width", "160", "--height", "120", "-p", "engines=4"];
    let folder = export(&[&composer[..], &["-p", "primitives=65536"]].concat());
    passes(folder.path(), &verilator(folder.path()));
    // The same modules for another screen: stalls, a reset and two frames in a row.
    let folder =
        export(&[&SMALL[..], tight("tbuffer"), &["--stress", "--preset", "paper"]].concat());
    passes(folder.path(), &verilator(folder.path()));
}

/// Every fault, a file with what stands there and what is put in its place, makes the comparison fail.
fn faults_are_seen(args: &[&str], faults: &[(&str, &str, &str)]) {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    let folder = export(&[&SMALL[..], args].concat());
    passes(folder.path(), &icarus(folder.path()));
    for (file, right, wrong) in faults {
        let path = folder.path().join(file);
        let good = std::fs::read_to_string(&path).unwrap();
        assert!(good.contains(right), "`{file}` has no `{right}`:\n{good}");
        std::fs::write(&path, good.replacen(right, wrong, 1)).unwrap();
        let run = icarus(folder.path());
        let said = text(&run);
        assert!(said.contains("FAIL: ") && said.contains(", expected "), "{file}: {said}");
        assert!(!run.status.success(), "{file}: the run must fail");
        std::fs::write(&path, good).unwrap();
    }
}

/// One operator each, in blocks of every kind.
#[test]
fn a_fault_in_the_text_of_the_tbuffer_is_seen() {
    let small = ["--preset", "paper", "-p", "sections=150", "-p", "outside_sections=900"];
    faults_are_seen(
        &small,
        &[
            ("blender.v", "8'd255 - ", "8'd254 - "),
            ("chain_reader.v", "position_q + ", "position_q - "),
            ("sequencer.v", " + ", " - "),
            ("depth_test.v", " < depth_data_i", " > depth_data_i"),
            ("fifo_pending.v", " - ", " + "),
            ("free_list_on_chip.v", "fresh_q + ", "fresh_q ^ "),
            ("lookup.v", "ssa_data_head_i == ", "ssa_data_head_i != "),
            ("ram_1r1w.v", "write_addr_i == read_addr_i", "write_addr_i != read_addr_i"),
            ("release_queue.v", " + ", " - "),
            ("scan.v", "next_q + ", "next_q - "),
            ("sorter.v", " < arrived_payload_item_z_i))", " > arrived_payload_item_z_i))"),
            ("store.v", "nsa_data_next_i == ", "nsa_data_next_i != "),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_the_rbuffer_is_seen() {
    faults_are_seen(
        &[&["--arch", "rbuffer"], tight("rbuffer")].concat(),
        &[
            ("passes.v", "left_q - ", "left_q + "),
            ("queue.v", " + ", " - "),
            ("selector.v", "farthest_data < ", "farthest_data > "),
            ("selector.v", "pixels_data[0] ^ ", "pixels_data[1] ^ "),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_the_mbuffer_is_seen() {
    faults_are_seen(
        &[&["--arch", "mbuffer"], tight("mbuffer")].concat(),
        &[
            ("array.v", "_z_q == cells_0_z_q", "_z_q != cells_0_z_q"),
            ("array.v", "count_q < from_q", "count_q > from_q"),
            ("store.v", "owns || ", "owns && "),
            ("sum.v", "so_far_r_q + ", "so_far_g_q + "),
        ],
    );
    let in_memory = ["--arch", "mbuffer", "-p", "weights=memory"];
    faults_are_seen(
        &[&in_memory, tight("mbuffer")].concat(),
        &[("weigh.v", "word_data_z_i < ", "word_data_z_i > ")],
    );
}

#[test]
fn a_fault_in_the_text_of_the_composer_is_seen() {
    faults_are_seen(
        &[&["--arch", "composer"], tight("composer")].concat(),
        &[
            ("bucket_sort.v", "item_row_i} - line", "item_row_i} + line"),
            ("buckets_buckets_0.v", "filled_q + ", "filled_q - "),
            ("distributor.v", "turn_q} + ", "turn_q} - "),
            ("layers.v", "z_2 < ", "z_2 > "),
            ("merging_unit.v", "both_local_z_q < ", "both_local_z_q > "),
            ("raster.v", "row_q} + ", "row_q} - "),
            ("scan_line.v", "merged_q + ", "merged_q - "),
            ("sweep_along.v", "(before_q - ", "(before_q + "),
            ("walker.v", "walk_payload_item_at_z_q + ", "walk_payload_item_at_z_q - "),
        ],
    );
}
