//! A machine as a folder of Verilog with its lock-step testbench.

use crate::bench::{Bench, BenchError};
use crate::output::{OutputError, put};
use crate::source::Source;
use crate::stimulus::Stimulus;
use pellucid_machine::Model;
use pellucid_machine::params::Value;
use pellucid_machine::pixel::Screen;
use pellucid_sim::netlist::Module;
use pellucid_verilog::lockstep::testbench;
use pellucid_verilog::outside::{OUTSIDE_MEMORY, OutsideMemory, TEXT};
use pellucid_verilog::{File, files};
use std::path::Path;

/// The testbench's module.
pub const TESTBENCH: &str = "lockstep_tb";
/// The recorded run.
pub const VECTORS: &str = "vectors.txt";
/// The list of source files, as simulators take it.
pub const LIST: &str = "files.f";

/// What an export came to.
pub struct Exported {
    /// Files of modules.
    pub modules: usize,
    /// Cycles that were recorded.
    pub cycles: u64,
}

/// The first lines of every file: what was exported.
fn about(arch: &str, screen: Screen, values: &[(String, Value)]) -> Vec<String> {
    let mut lines = vec![
        format!("Exported by pellucid {}.", env!("CARGO_PKG_VERSION")),
        format!("--arch {arch} --width {} --height {}", screen.width, screen.height),
    ];
    lines.extend(values.iter().map(|(name, value)| format!("-p {name}={value}")));
    lines
}

/// The machine's modules; the last one is the machine itself.
pub fn modules(arch: &str, screen: Screen, machine: &dyn Model, netlist: &Module) -> Vec<File> {
    files(netlist, &about(arch, screen, &machine.values()))
}

/// Writes the modules into `folder`, and the list of them and of `more`.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Path, modules: &[File], more: &[&str]) -> Result<(), OutputError> {
    let mut list = String::new();
    for File { name, text } in modules {
        put(&folder.join(name), text)?;
        list += &format!("{name}\n");
    }
    for name in more {
        list += &format!("{name}\n");
    }
    put(&folder.join(LIST), &list)
}

/// Writes the machine, its testbench and the recording of a run into `folder`.
///
/// # Errors
/// A file cannot be written, or the run ends early.
pub fn export(
    arch: &str,
    machine: &dyn Model,
    source: &Source,
    stimulus: Stimulus,
    folder: &Path,
) -> Result<Exported, BenchError> {
    let netlist = machine.netlist();
    let modules = modules(arch, source.screen(), machine, &netlist);
    let bench = format!("{TESTBENCH}.v");
    let mut beside = vec![];
    let file = format!("{OUTSIDE_MEMORY}.v");
    if machine.port().exists() {
        put(&folder.join(&file), TEXT)?;
        beside.push(file.as_str());
    }
    beside.push(&bench);
    write(folder, &modules, &beside)?;
    // One that pauses is not that of the export, nor is one with a timing of its own.
    let latency = machine.latency().filter(|_| stimulus == Stimulus::Plain);
    let memory = latency.map(|latency| OutsideMemory { words: machine.port().words, latency });
    put(&folder.join(&bench), &testbench(&netlist, netlist.name, VECTORS, memory))?;
    let mut played = Bench::new(machine);
    played.reserve()?;
    played.record_ports(&folder.join(VECTORS), &netlist)?;
    stimulus.play(&mut played, source, machine)?;
    played.finish_ports()?;
    Ok(Exported { modules: modules.len(), cycles: played.cycles() })
}
