//! The exported Verilog against the Rust run, every output on every cycle, in Icarus and in Verilator. The netlist itself
//! is compared with the machine in the tests of each architecture, which need no tool.

mod flips;
mod text;
#[path = "../tools/mod.rs"]
mod tools;
mod triangles;

use pellucid_hw::{ARCHITECTURES, architecture};
use pellucid_machine::Architecture;
use pellucid_machine::architecture::Set;
use rayon::prelude::*;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A screen that is small enough for an event-driven simulator.
const SMALL: [&str; 4] = ["--width", "24", "--height", "18"];

/// A machine that is hardware of its own: an architecture, and what makes it.
type Way = (&'static Architecture, Set);

/// All of them.
fn ways() -> Vec<Way> {
    let of = |arch: &'static Architecture| arch.ways.iter().map(move |way| (arch, *way));
    ARCHITECTURES.iter().copied().flat_map(of).collect()
}

/// The first one of an architecture.
fn first(arch: &str) -> Way {
    let arch = architecture(arch).unwrap();
    (arch, arch.ways[0])
}

/// The options that choose an architecture with these settings, later ones over earlier ones.
fn options(arch: &Architecture, settings: &[Set]) -> Vec<String> {
    let settings = settings.iter().copied().flatten();
    let settings = settings.flat_map(|(name, value)| ["-p".to_string(), format!("{name}={value}")]);
    ["--arch".to_string(), arch.name.to_string()].into_iter().chain(settings).collect()
}

/// Exports into a new folder.
#[track_caller]
fn export(machine: &[String], args: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["export", "--quiet", "--out"])
        .arg(folder.path())
        .args(machine)
        .args(args)
        .output()
        .unwrap();
    assert!(done.status.success(), "{machine:?}: {}", String::from_utf8_lossy(&done.stderr));
    folder
}

/// Exports a machine that has little room, with a frame of so many triangles that exercises it: pauses, stalls and a reset are in it.
#[track_caller]
fn exercised((arch, way): Way, triangles: u32) -> TempDir {
    let scene = triangles::scene(triangles);
    let scene = ["--scene", scene.path().to_str().unwrap(), "--camera", triangles::CAMERA];
    export(&options(arch, &[arch.tight, way]), &[&SMALL[..], &scene, &["--stress"]].concat())
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

/// Builds the testbench in Verilator, in a folder that may have built others before, and runs it.
fn verilator(folder: &Path, built: &Path) -> Output {
    // It runs for seconds, so that an optimising compiler would take longer than it saves. For each file Verilator's headers
    // would be read again, so that all go into one.
    let mut make = "OPT_FAST=-O0 OPT_GLOBAL=-O0 VM_PARALLEL_BUILDS=0".to_string();
    // What is of Verilator itself is compiled the first time: an old file is taken as it is.
    let files = std::fs::read_dir(built).unwrap().map(|file| file.unwrap().file_name());
    let files = files.map(|file| file.into_string().unwrap());
    let runtime = files.filter(|file| file.starts_with("verilated") && file.ends_with(".o"));
    make.extend(runtime.map(|file| format!(" --old-file={file}")));
    let mut args =
        vec!["--binary", "-j", "2", "-MAKEFLAGS", &make, "--no-skip-identical", "--Mdir"];
    args.extend([built.to_str().unwrap(), "--top-module", "lockstep_tb", "-f", "files.f"]);
    let build = in_folder(folder, "verilator", &args);
    assert!(build.status.success(), "{}", text(&build));
    in_folder(folder, built.join("Vlockstep_tb").to_str().unwrap(), &[])
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
    ways().into_par_iter().for_each(|way| {
        let folder = exercised(way, triangles::FEW);
        passes(folder.path(), &icarus(folder.path()));
    });
}

#[test]
fn verilator_has_no_complaint() {
    if !tools::have(&["verilator"]) {
        return;
    }
    ways().into_par_iter().for_each(|(arch, way)| {
        let folder = export(&options(arch, &[arch.tight, way]), &["--width", "4", "--height", "3"]);
        let list = std::fs::read_to_string(folder.path().join("files.f")).unwrap();
        let modules = list.lines().filter(|file| !file.starts_with("lockstep"));
        let mut args = vec!["--lint-only", "-Wall", "--top-module", arch.name];
        args.extend(modules);
        let lint = in_folder(folder.path(), "verilator", &args);
        assert_eq!(text(&lint), "", "{}, {way:?}", arch.name);
        assert!(lint.status.success());
    });
}

#[test]
fn verilator_agrees_over_a_large_frame() {
    if !tools::have(&["verilator"]) {
        return;
    }
    let built = tempfile::tempdir().unwrap();
    for arch in ARCHITECTURES {
        // A frame is sent once for each band, or each pass of a window: a few of these are enough.
        let plays: Set = match arch.name {
            "dfb" => &[("fragments", "4000")],
            "fbuffer" => &[("size", "1024")],
            _ => &[],
        };
        let machine = options(arch, &[arch.tight, arch.ways[0], plays]);
        let folder = export(&machine, &["--width", "160", "--height", "120"]);
        passes(folder.path(), &verilator(folder.path(), built.path()));
    }
}

/// Every fault, a file with what stands there and what is put in its place, makes the comparison fail.
fn faults_are_seen(way: Way, faults: &[(&str, &str, &str)]) {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    let folder = exercised(way, triangles::FEW);
    // Without a fault it passes; those of `ways` are held to that in a test of their own.
    if !ways().iter().any(|(arch, set)| (arch.name, *set) == (way.0.name, way.1)) {
        passes(folder.path(), &icarus(folder.path()));
    }
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

/// What a DRAM answered is replayed; the memory of the export is not that.
#[test]
fn icarus_agrees_with_a_dram_behind_the_port() {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    let (arch, way) = first("tbuffer");
    for stress in [&[][..], &["--stress"]] {
        let args = [&SMALL[..], &["-p", "outside=ddr4-3200"], stress].concat();
        let folder = export(&options(arch, &[arch.tight, way]), &args);
        passes(folder.path(), &icarus(folder.path()));
    }
}

/// The memory that comes with an export does as that of the run, with which it is compared.
#[test]
fn a_fault_in_the_text_of_the_outside_memory_is_seen() {
    if !tools::have(&["iverilog", "vvp"]) {
        return;
    }
    let (arch, way) = first("tbuffer");
    let folder = export(&options(arch, &[arch.tight, way]), &SMALL);
    passes(folder.path(), &icarus(folder.path()));
    let path = folder.path().join("outside_memory.v");
    let good = std::fs::read_to_string(&path).unwrap();
    for (right, wrong) in [
        ("now_q + LATENCY", "now_q + LATENCY + 1"),
        ("words[request_address_i] <= request_word_i", "words[request_address_i] <= 0"),
        ("first_q == LATENCY ? 0", "first_q == LATENCY ? 1"),
    ] {
        assert!(good.contains(right), "no `{right}`:\n{good}");
        std::fs::write(&path, good.replacen(right, wrong, 1)).unwrap();
        let run = icarus(folder.path());
        assert!(text(&run).contains("the outside memory answers otherwise"), "{}", text(&run));
        assert!(!run.status.success(), "the run must fail");
    }
}

/// One operator each, in blocks of every kind.
#[test]
fn a_fault_in_the_text_of_the_tbuffer_is_seen() {
    let paper = (first("tbuffer").0, &[("append", "walk"), ("scan", "linear")][..]);
    faults_are_seen(
        paper,
        &[
            ("blender.v", "8'd255 - ", "8'd254 - "),
            ("answers.v", "oldest_valid_i && ", "oldest_valid_i || "),
            ("chain_reader.v", "position_q + ", "position_q - "),
            ("sequencer.v", " + ", " - "),
            ("depth_test.v", " < depth_data_i", " > depth_data_i"),
            ("fifo_pending.v", " - ", " + "),
            ("free_list_on_chip.v", "fresh_q + ", "fresh_q ^ "),
            ("lookup.v", "ssa_data_head_i == ", "ssa_data_head_i != "),
            ("ram_1r1w.v", "write_addr_i == read_addr_i", "write_addr_i != read_addr_i"),
            ("release_queue.v", " + ", " - "),
            ("scan.v", "next_q + ", "next_q - "),
            ("skid.v", "!taken_i", "taken_i"),
            ("sorter.v", " < arrived_payload_item_z_i;", " > arrived_payload_item_z_i;"),
            ("store.v", "nsa_data_next_i == ", "nsa_data_next_i != "),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_the_rbuffer_is_seen() {
    faults_are_seen(
        first("rbuffer"),
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
        first("mbuffer"),
        &[
            ("array.v", "_z_q == cells_0_z_q", "_z_q != cells_0_z_q"),
            ("array.v", "count_q < from_q", "count_q > from_q"),
            ("store.v", "owns || ", "owns && "),
            ("sum.v", "so_far_r_q + ", "so_far_g_q + "),
        ],
    );
    let in_memory = (first("mbuffer").0, &[("weights", "memory")][..]);
    faults_are_seen(in_memory, &[("weigh.v", "word_data_z_i < ", "word_data_z_i > ")]);
}

#[test]
fn a_fault_in_the_text_of_the_composer_is_seen() {
    let composer = (first("composer").0, &[("scan_line_engines", "1")][..]);
    faults_are_seen(
        composer,
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

#[test]
fn a_fault_in_the_text_of_the_dfb_is_seen() {
    faults_are_seen(
        first("dfb"),
        &[
            ("index.v", "base} - count", "base} + count"),
            ("prefix_sum.v", "lanes_2} + ", "lanes_2} - "),
            ("prefix_sum.v", "occupied_q + ", "occupied_q - "),
            ("reader.v", "left_q - ", "left_q + "),
            ("steps.v", "summed_i ? STEP_STORE", "summed_i ? STEP_RESOLVE"),
            ("walk.v", "sums_data_of_0_i - before_q", "sums_data_of_0_i + before_q"),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_b3d_is_seen() {
    let few = (first("b3d").0, &[("layers", "1"), ("most_layers", "9"), ("sorter_depth", "2")][..]);
    faults_are_seen(
        few,
        &[
            ("index.v", "base} + ", "base} - "),
            ("reader.v", "word_data_z_i < ", "word_data_z_i > "),
            ("rebuild.v", "limit_q << 1'd1", "limit_q << 2'd2"),
            ("rebuild.v", "(entry_q + ", "(entry_q - "),
            ("word_list.v", "count_q + ", "count_q - "),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_the_ppll_is_seen() {
    let few = (first("ppll").0, &[("page", "3"), ("pages", "3"), ("sorter_depth", "2")][..]);
    faults_are_seen(
        few,
        &[
            ("count.v", "count_q + ", "count_q - "),
            ("rebuild.v", "limit_q << 1'd1", "limit_q << 2'd2"),
            ("rebuild.v", "n ? STEP_CLEAR", "n ? STEP_RESOLVE"),
            ("sorter.v", "fell_q + ", "fell_q - "),
            ("store.v", "place_payload_slot + ", "place_payload_slot - "),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_the_fbuffer_is_seen() {
    faults_are_seen(
        first("fbuffer"),
        &[
            ("plays.v", "window_q + ", "window_q - "),
            ("shader.v", "32'hff000000 - stages_0", "32'hff000000 + stages_0"),
            (
                "shader.v",
                "{1'd0, entered_payload_item_registers_5} + ",
                "{1'd0, entered_payload_item_registers_5} - ",
            ),
            ("walker.v", "walk_payload_item_at_z_q + ", "walk_payload_item_at_z_q - "),
            ("window.v", "counted_q + ", "counted_q - "),
        ],
    );
    // Outside, and with words of two parts.
    let (arch, _) = first("fbuffer");
    let outside =
        |way: &&Set| ["buffer", "kill"].iter().all(|name| way.iter().any(|(n, _)| n == name));
    let way = arch.ways.iter().find(outside).unwrap();
    faults_are_seen(
        (arch, *way),
        &[
            ("ahead.v", "asked_q + ", "asked_q - "),
            ("ahead.v", "(written_q + ", "(written_q - "),
            ("ahead.v", ", begins}) - ", ", begins}) + "),
            ("window.v", "asks && !there_i", "asks && there_i"),
        ],
    );
}

#[test]
fn a_fault_in_the_text_of_the_accumulation_is_seen() {
    let arch = first("accumulate").0;
    let levels = (arch, &[("frames", "8"), ("branching", "2,4")][..]);
    faults_are_seen(
        levels,
        &[
            ("accumulator.v", "frame_q + ", "frame_q - "),
            ("level_levels_0.v", "planes_0_data[7:0]} + ", "planes_0_data[7:0]} - "),
            ("level_levels_1.v", "filled_q + ", "filled_q - "),
        ],
    );
    let nodes = (arch, &[("frames", "4"), ("schedule", "nodes")][..]);
    faults_are_seen(nodes, &[("tree.v", "sweep_payload_pixel_q + ", "sweep_payload_pixel_q - ")]);
    let buffer = (arch, &[("frames", "2"), ("method", "buffer")][..]);
    faults_are_seen(buffer, &[("sums.v", "below_r} + ", "below_r} - ")]);
    let outside = (arch, &[("frames", "4"), ("planes", "outside")][..]);
    faults_are_seen(
        outside,
        &[
            ("planes.v", "asked_payload_q + ", "asked_payload_q - "),
            ("planes.v", "of_0_r_2} + ", "of_0_r_2} - "),
            ("planes.v", "frame_q + ", "frame_q - "),
        ],
    );
}
