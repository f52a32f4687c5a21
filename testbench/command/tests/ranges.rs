//! Exported machines at the ends of every parameter's range, and on the smallest screens: there a comparison may be
//! constant, a number have no bit more than it needs, a memory a single word.

mod tools;

use pellucid_hw::ARCHITECTURES;
use pellucid_machine::Architecture;
use pellucid_machine::architecture::settings;
use pellucid_machine::params::Param;
use pellucid_machine::pixel::Screen;
use pellucid_sim::join;
use pellucid_sim::netlist::{Module, without_effect};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::process::Command;

/// A machine: architecture, sides of the screen, settings.
type Machine = (&'static Architecture, [u32; 2], Vec<String>);

const NUMBER: &str = "a whole number from ";

fn is_number(param: &Param) -> bool {
    param.range.starts_with(NUMBER)
}

/// Both ends of a parameter's range, or each of its choices.
fn ends(param: &Param) -> Vec<String> {
    match param.range.strip_prefix(NUMBER) {
        Some(numbers) => numbers.split(" to ").map(String::from).collect(),
        None => param.range.split('`').skip(1).step_by(2).map(String::from).collect(),
    }
}

/// What an end of a range needs beside it, and what makes a machine smaller.
fn beside(arch: &str, name: &str, end: &str) -> &'static [&'static str] {
    match (arch, name, end) {
        ("tbuffer", "allocator", "bitmap") => &["sections=64", "outside_sections=64"],
        ("mbuffer", "allocator", "bitmap") => &["overflow_sections=64", "outside_sections=64"],
        ("rbuffer", "queue", _) => &["outside_queue=0"],
        ("rbuffer", "outside_queue", _) => &["overflow=replay"],
        ("b3d", "layers", "65536") => &["most_layers=65536"],
        ("b3d", "most_layers", "1") => &["layers=1"],
        ("ppll", "pages", "134217728") => &["page=1", "most_pages=134217728"],
        ("ppll", "most_pages", "134217728") => &["page=1"],
        ("ppll", "most_pages", "1") => &["pages=1", "page=64"],
        ("composer", "engines", _) => &[],
        ("composer", ..) => &["engines=2"],
        ("accumulate", "frames", _) => &["branching=4"],
        ("accumulate", "sum_bits", "8") => &["method=buffer"],
        ("accumulate", "sum_bits", _) => &["method=buffer", "frames=3"],
        ("accumulate", "weight_bits", _) => &["frames=3", "weights=gaussian"],
        ("accumulate", "branching", _) => &["frames=8"],
        ("accumulate", "reads_in_flight", _) => &["frames=4", "planes=outside"],
        ("accumulate", ..) => &["frames=4"],
        _ => &[],
    }
}

/// The smallest screens, and the lower end of every parameter's range.
fn small() -> Vec<Machine> {
    let screens = [[1, 1], [1, 5], [5, 1]];
    let screens = ARCHITECTURES.iter().flat_map(|arch| screens.map(|sides| (*arch, sides, vec![])));
    screens.chain(at(|_, ends| ends.into_iter().take(1).collect())).collect()
}

/// Every choice but those that [`small`] has.
fn choices() -> Vec<Machine> {
    at(|param, ends| ends.into_iter().skip(1).filter(|_| !is_number(param)).collect())
}

/// The upper end of every parameter's range, and its other choices.
fn large() -> Vec<Machine> {
    at(|_, ends| ends.into_iter().skip(1).collect())
}

/// Machines with a parameter at one of the ends of its range that `chosen` leaves of them.
fn at(chosen: fn(&Param, Vec<String>) -> Vec<String>) -> Vec<Machine> {
    let mut all = vec![];
    for arch in ARCHITECTURES.iter().copied() {
        // A fragment store's parameters are those of a machine of its own.
        for param in (arch.parameters)().iter().filter(|param| !param.name.contains('.')) {
            for end in chosen(param, ends(param)) {
                // Verilator reads a module of which there are so many for more than ten minutes.
                if (arch.name, &param.name[..], &end[..]) == ("composer", "engines", "1024") {
                    continue;
                }
                let beside = beside(arch.name, &param.name, &end).iter().map(|set| set.to_string());
                let settings = beside.chain([format!("{}={end}", param.name)]).collect();
                all.push((arch, [3, 64], settings));
            }
        }
    }
    all
}

#[test]
fn verilator_has_no_complaint_about_small_machines() {
    lint(small());
}

#[test]
#[ignore = "takes minutes"]
fn verilator_has_no_complaint_about_large_machines() {
    lint(large());
}

fn lint(machines: Vec<Machine>) {
    if !tools::have(&["verilator"]) {
        return;
    }
    machines.par_iter().for_each(|(arch, [width, height], settings)| {
        let folder = tempfile::tempdir().unwrap();
        let mut export = Command::new(env!("CARGO_BIN_EXE_pellucid"));
        export.args(["export", "--quiet", "--arch", arch.name, "--scene", "panes"]);
        export.args(["--width", &width.to_string(), "--height", &height.to_string()]);
        export.args(settings.iter().flat_map(|setting| ["-p", setting])).arg("--out");
        let done = export.arg(folder.path()).output().unwrap();
        let text = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{}, {settings:?}: {text}", arch.name);

        let list = std::fs::read_to_string(folder.path().join("files.f")).unwrap();
        let mut lint = Command::new("verilator");
        lint.args(["--lint-only", "-Wall", "--top-module", arch.name]);
        lint.args(list.lines().filter(|file| !file.starts_with("lockstep")));
        let lint = lint.current_dir(folder.path()).output().unwrap();
        let text = [lint.stdout, lint.stderr].concat();
        let text = String::from_utf8_lossy(&text);
        assert_eq!(text, "", "{}, {width}x{height}, {settings:?}", arch.name);
    });
}

/// Registers of a machine that its Verilog has: those that ever change.
fn exported(module: &Module) -> BTreeSet<String> {
    let own = (0..module.registers.len())
        .filter(|k| module.owner(*k).is_none() && !module.is_constant(*k))
        .map(|k| module.registers[k].path.clone());
    let of_children = module
        .instances
        .iter()
        .flat_map(|child| exported(&child.module).into_iter().map(|path| join(&child.path, &path)));
    own.chain(of_children).collect()
}

/// What `of` finds in the netlists of small machines, each in a line.
fn found(of: impl Fn(&Module) -> Vec<String> + Sync) -> String {
    let found = |(arch, [width, height], set): &Machine| {
        let screen = Screen { width: *width, height: *height, background: 0 };
        let set: Vec<_> = set.iter().map(|setting| setting.split_once('=').unwrap()).collect();
        let set: Vec<_> = set.iter().map(|(name, value)| (*name, value.to_string())).collect();
        let found = of(&arch.build(screen, None, &settings(&set)).unwrap().netlist());
        let machine = || format!("{}, {width}x{height}, {set:?}: {found:?}", arch.name);
        (!found.is_empty()).then(machine)
    };
    let machines = [small(), choices()].concat();
    machines.par_iter().filter_map(found).collect::<Vec<_>>().join("\n")
}

/// A waveform has no register that the Verilog has not.
#[test]
fn what_a_waveform_shows_is_in_the_verilog() {
    let missing = found(|netlist| {
        let exported = exported(netlist);
        let shown = netlist.registers.iter().map(|register| register.path.clone());
        shown.filter(|path| !exported.contains(path)).collect()
    });
    assert_eq!(missing, "");
}

/// Every register and every field of a memory's word has an effect on what a machine gives; but for what the F-buffer's shader carries
/// along, and synthesis takes out: both scratch registers through every stage, also where no instruction reads them any more.
#[test]
fn nothing_is_kept_that_has_no_effect() {
    let carried = |path: &str| path.starts_with("shader.stages[") && path.contains(".registers[");
    let idle = found(|netlist| {
        let found = without_effect(netlist).into_iter();
        found.filter(|path| netlist.name != "fbuffer" || !carried(path)).collect()
    });
    assert_eq!(idle, "");
}
