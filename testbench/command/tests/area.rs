//! What Yosys counts, against what the netlist's registers and memories say, and what it and OpenSTA find with a library.

mod tools;

use pellucid_blocks::allocator::{self, FreeList};
use pellucid_blocks::chains::config as chains;
use pellucid_blocks::chains::scan::Scan;

use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::Screen;
use pellucid_rbuffer::queue::{self, Queue};
use pellucid_sim::netlist::{Module, Netlist, Register, Type, elaborate};
use pellucid_tbuffer::config::{Config, PRESETS, Params};
use pellucid_testbench::area::standard::DEFAULT_LIBRARY;
use pellucid_testbench::area::{Area, measure};
use pellucid_verilog::files;
use serde_json::Value;
use std::collections::HashMap;
use std::path::Path;
use std::process::{Command, Stdio};

fn area<B: Netlist>(cfg: &B::Config) -> (Module, Area) {
    let netlist = elaborate::<B>(cfg);
    let area = measure(&netlist, &files(&netlist, &[]), true).unwrap();
    assert!(area.unknown.is_empty(), "{:?}", area.unknown);
    (netlist, area)
}

/// Flip-flops of a block's own registers that ever change: one for each bit, and one for each state of
/// a state machine, since Yosys gives each its own.
fn flip_flops(module: &Module) -> u64 {
    let own = |k: &usize| module.owner(*k).is_none() && !module.is_constant(*k);
    let registers = (0..module.registers.len()).filter(own).map(|k| &module.registers[k]);
    let count = |register: &Register| match register.ty {
        Type::State(states) => states.variants.len() as u64,
        _ => u64::from(register.width),
    };
    registers.map(count).sum()
}

const SCREEN: Screen = Screen { width: 64, height: 48, background: 0 };

fn sorter(depth: u32) -> sorter::Config {
    sorter::Config { depth, layer_bits: 8, pixel_bits: SCREEN.pixel_bits(), newest_first: false }
}

fn chains(sections: u32) -> chains::Config {
    let params = Params { sections, outside_sections: 0, ..(PRESETS[0].params)() };
    Config::new(SCREEN, params).unwrap().chains
}

#[test]
fn a_register_is_a_flip_flop_for_each_bit() {
    if !tools::have(&["yosys"]) {
        return;
    }
    let (netlist, counted) = area::<Sorter>(&sorter(4));
    assert_eq!(counted.parts[0].cells.flip_flops, flip_flops(&netlist));

    // Each of the blocks of a hierarchy has its own.
    let (netlist, counted) = area::<Scan>(&chains(64));
    let children: Vec<u64> = netlist.instances.iter().map(|i| flip_flops(&i.module)).collect();
    let counts: Vec<u64> = counted.parts.iter().map(|part| part.cells.flip_flops).collect();
    assert_eq!(counts[1..], children);
    assert_eq!(counts[0], flip_flops(&netlist) + children.iter().sum::<u64>());
}

#[test]
fn a_memory_is_a_ram_block_where_it_is_large() {
    if !tools::have(&["yosys"]) {
        return;
    }
    for (sections, half_rams) in [(16_u32, 0), (1024, 1), (2048, 2)] {
        let (_, counted) = area::<FreeList>(&allocator::Config { sections });
        let [list, queue] = &counted.parts[..] else { panic!("{:?}", counted.parts) };
        assert_eq!((list.path.as_str(), queue.path.as_str()), ("", "queue"));
        // A queue of all sections' numbers. A block RAM has 18 Kbit.
        let bits = sections * sections.ilog2();
        assert_eq!(list.cells.memory_bits, u64::from(bits));
        assert_eq!(queue.cells.half_rams, half_rams, "{sections} sections");
        // The list itself has a register that counts from 0 to `sections`.
        let own = list.cells.flip_flops - queue.cells.flip_flops;
        assert_eq!(own, u64::from(sections.ilog2() + 1));
    }
}

#[test]
fn outside_memory_takes_no_area() {
    if !tools::have(&["yosys"]) {
        return;
    }
    let queue = |outside| queue::Config { on_chip: 512, outside, latency: 9, screen: SCREEN };
    let (_, without) = area::<Queue>(&queue(0));
    let (_, with) = area::<Queue>(&queue(16384));
    let [without, with] = [without, with].map(|area| area.parts[0].cells);
    assert_eq!(with.half_rams, without.half_rams);
    // A pixel's number of 12 bits, 24 bits of depth and 32 of colour.
    assert_eq!([with.memory_bits, without.memory_bits], [512 * 68; 2]);
}

#[test]
fn a_longer_sorter_has_a_longer_path() {
    if !tools::have(&["yosys"]) {
        return;
    }
    let path = |depth| area::<Sorter>(&sorter(depth)).1.longest_path;
    let [short, long] = [1, 4].map(path);
    assert!(0 < short && short < long, "{short} and {long} cells");
}

/// The flow with a library of standard cells needs these, and Debian's library.
fn have_cells() -> bool {
    let library = Path::new(DEFAULT_LIBRARY);
    tools::have(&["yosys", "sta", library.parent().unwrap().to_str().unwrap()])
}

/// `pellucid area --liberty` with nothing kept from before.
fn by_liberty(cache: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    command.args(["area", "--json", "--quiet"]).args(args).env("XDG_CACHE_HOME", cache);
    command
}

fn json(command: &mut Command) -> Value {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Areas of cells as the library's text has them, read without the code that is tested: `cell (NAME) {` and the next `area : X;`.
fn areas() -> HashMap<String, f64> {
    let text = std::fs::read_to_string(DEFAULT_LIBRARY).unwrap();
    let cells = text.split("cell (").skip(1);
    let area = |cell: &str| {
        let (_, rest) = cell.split_once("area :").unwrap();
        rest.split(';').next().unwrap().trim().parse().unwrap()
    };
    cells.map(|cell| (cell.split(')').next().unwrap().trim().to_string(), area(cell))).collect()
}

/// A machine of 8x6 pixels in standard cells, beside what a run says of it; with its logic where it asks for a library, too.
fn a_small_machine_in_standard_cells(machine: &[&str], run_asks: bool) {
    if !have_cells() {
        return;
    }
    let cache = tempfile::tempdir().unwrap();
    let areas = areas();
    let args = [&["--width", "8", "--height", "6", "-p", "sorter_depth=1"], machine].concat();
    let first = json(by_liberty(cache.path(), &["--liberty"]).args(&args));
    let whole = &first["blocks"][0];
    let number = |of: &Value| of.as_f64().unwrap();
    // By hand: each cell by its area.
    let cells = first["cells"].as_object().unwrap();
    let by_hand: f64 = cells.iter().map(|(kind, n)| areas[kind] * number(n)).sum::<f64>() / 1e6;
    assert!((number(&whole["logic_mm2"]) / by_hand - 1.0).abs() < 1e-9, "{whole} and {by_hand}");
    assert_eq!(number(&whole["cells"]), cells.values().map(number).sum::<f64>());
    // A gate takes some 0.2 ns: tens of them are far from either end, and unbuffered ones would be beyond it.
    let period = number(&first["longest_path"]["period_ns"]);
    assert!((1.0..25.0).contains(&period), "{period}");
    assert!(!first["longest_path"]["through"].as_array().unwrap().is_empty());
    // Its memories are those of a run.
    let liberty: &[&str] = if run_asks { &["--liberty"] } else { &[] };
    let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["run", "--no-wave", "--json", "--allow-drops", "--out"])
        .arg(cache.path().join("run"))
        .args(args.iter().chain(liberty))
        .env("XDG_CACHE_HOME", cache.path())
        .output()
        .unwrap();
    let run: Value = serde_json::from_slice(&run.stdout).unwrap();
    let near = |found: &Value, expected: f64, share: f64| {
        assert!((number(found) / expected - 1.0).abs() < share, "{found} and {expected}");
    };
    near(&run["area"]["memories"], number(&whole["memories_mm2"]), 1e-3);
    if run_asks {
        // And so is its logic, but for the background's colour. It limits the clock: cells of 180 nm are slower than memories
        // of 22 nm.
        near(&run["area"]["logic"], number(&whole["logic_mm2"]), 0.02);
        near(&run["time"]["logic_period"], period, 0.1);
        near(&run["time"]["fastest_clock"], 1000.0 / number(&run["time"]["logic_period"]), 1e-3);
    }
    // Again, with tools that know their version and nothing else: what was found out is kept.
    let folder = tempfile::tempdir().unwrap();
    for tool in ["yosys", "sta"] {
        known_by_version(folder.path(), tool);
    }
    let again =
        json(by_liberty(cache.path(), &["--liberty"]).args(&args).env("PATH", folder.path()));
    assert_eq!(again, first);
}

#[test]
fn a_small_tbuffer_in_standard_cells() {
    let machine = ["--arch", "tbuffer", "-p", "sections=16", "-p", "outside_sections=0"];
    a_small_machine_in_standard_cells(&machine, false);
}

#[test]
fn a_small_b3d_in_standard_cells() {
    a_small_machine_in_standard_cells(&["--arch", "b3d"], true);
}

/// A library in three files, of 7 nm: a cell takes some tenths of a square micrometre.
#[test]
fn a_library_may_be_in_several_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/liberty");
    let kinds =
        ["INVBUF_RVT_SS_nldm_220122", "SEQ_RVT_SS_nldm_220123", "SIMPLE_RVT_SS_nldm_211120"];
    let files = kinds.map(|kind| folder.join(format!("asap7sc7p5t_{kind}.lib.gz")));
    if let Some(missing) = files.iter().find(|file| !file.exists()) {
        println!("skipped: there is no {}", missing.display());
        return;
    }
    if !have_cells() {
        return;
    }
    let cache = tempfile::tempdir().unwrap();
    let args = "--arch b3d --width 8 --height 6 -p sorter_depth=1";
    let mut command = by_liberty(cache.path(), &args.split(' ').collect::<Vec<_>>());
    let new = json(command.arg("--liberty").args(files));
    let whole = &new["blocks"][0];
    let of_cell = 1e6 * whole["logic_mm2"].as_f64().unwrap() / whole["cells"].as_f64().unwrap();
    assert!((0.05..0.5).contains(&of_cell), "{of_cell}");
    assert!(new["cells"].as_object().unwrap().keys().all(|cell| cell.ends_with("_ASAP7_75t_R")));
    let period = new["longest_path"]["period_ns"].as_f64().unwrap();
    assert!((0.1..5.0).contains(&period), "{period}");
}

/// A tool that says what the one of that name says of its version, and fails else.
fn known_by_version(folder: &Path, tool: &str) {
    use std::os::unix::fs::PermissionsExt;
    let ask = if tool == "sta" { "-version" } else { "-V" };
    let said = Command::new(tool).arg(ask).stdin(Stdio::null()).output().unwrap().stdout;
    let said = String::from_utf8(said).unwrap();
    let path = folder.join(tool);
    std::fs::write(
        &path,
        format!("#!/bin/sh\n[ \"$1\" = {ask} ] || exit 1\necho '{}'\n", said.trim()),
    )
    .unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn what_is_wrong_with_a_library_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.lib");
    std::fs::write(&broken, "library (x) {\n  cell INV {\n}\n").unwrap();
    for (path, expected) in [
        (folder.path().join("none.lib"), "No such file or directory (os error 2)"),
        (broken, "line 2: `INV` behind `cell`: expected `:` or `(`"),
    ] {
        let output = by_liberty(folder.path(), &["--liberty"]).arg(&path).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said, format!("error: {}: {expected}\n", path.display()));
        assert_eq!(output.status.code(), Some(2));
    }
}
