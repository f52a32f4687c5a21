//! The exported machine, built with Verilator and played by a process of its own.

use crate::{Frame, Played};
use pellucid_machine::Model;
use pellucid_verilog::File;
use pellucid_waveforms::FileFormat;
use std::fmt::Write;
use std::fs;
use std::io::{BufRead, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

const MAIN: &str = include_str!("main.cpp");
/// What makes the model fast: no checks, no random start values.
const VERILATOR: &[&str] = &["-O3", "--x-assign", "fast", "--x-initial", "fast", "--noassert"];
/// What g++ does with code that runs every cycle; `OPT_SLOW` is left for code that runs once.
const CXX: &str = "-O3 -march=native";

/// A Verilator, and on how many threads its machines run.
#[derive(Clone, Copy)]
pub struct Tool<'a> {
    /// The program, by name or path.
    pub program: &'a str,
    /// The threads, 1 or 2.
    pub threads: u32,
}

impl Tool<'_> {
    /// What makes the machine run on those threads. Verilator writes FST on a thread of its own only if told to.
    fn flags(self, wave: Option<FileFormat>) -> &'static [&'static str] {
        match (self.threads, wave) {
            (1, _) => &[],
            (_, Some(FileFormat::Fst)) => &["--trace-threads", "1"],
            (_, None | Some(FileFormat::Vcd)) => &["--threads", "2"],
        }
    }
}

/// The first line that a Verilator says about itself, if it is there.
pub fn version(program: &str) -> Option<String> {
    let output = Command::new(program).arg("--version").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}

/// The flags, for a report.
pub fn flags() -> String {
    format!("{}, OPT_FAST=OPT_GLOBAL=\"{CXX}\"", VERILATOR.join(" "))
}

/// Orders to Verilator that leave of the signals those of the Rust simulation: the clock, every block's registers and
/// the machine's outputs. The last module is the machine.
fn same_signals(modules: &[File]) -> String {
    let mut orders = "`verilator_config\n".to_string();
    for (k, File { name, text }) in modules.iter().enumerate() {
        if name.starts_with("ram_") {
            writeln!(orders, "tracing_off -file \"*/{name}\"").unwrap();
            continue;
        }
        let machine = k + 1 == modules.len();
        for (line, declaration) in (1..).zip(text.lines()) {
            let hidden = match declaration.split_whitespace().next() {
                Some("input") => !(machine && declaration.contains(" clk")),
                Some("output") => !machine,
                Some("wire" | "localparam") => true,
                _ => false,
            };
            if hidden {
                writeln!(orders, "tracing_off -file \"*/{name}\" -lines {line}").unwrap();
            }
        }
    }
    orders
}

/// Runs a tool; what it says is shown only where it fails.
fn run(command: &mut Command) {
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{command:?} failed:\n{}", String::from_utf8_lossy(&said));
}

/// A built model, waiting for frames.
pub struct Verilated {
    process: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// What building took.
    pub built: Duration,
}

impl Verilated {
    /// Builds the machine below `folder`, in which its modules lie, and starts it on `frame`. `wave` says which
    /// waveform it writes.
    pub fn build(
        tool: Tool,
        folder: &Path,
        machine: &dyn Model,
        modules: &[File],
        wave: Option<FileFormat>,
        frame: &Frame,
    ) -> Verilated {
        let start = Instant::now();
        let main = folder.join("main.cpp");
        fs::write(&main, MAIN).unwrap();
        let built = tempfile::tempdir_in(folder).unwrap().keep();
        let mut verilator = Command::new(tool.program);
        verilator.args(["--cc", "--exe", "-Wno-fatal", "--prefix", "Vmachine"]).args(VERILATOR);
        verilator.args(tool.flags(wave)).arg("--Mdir").arg(&built).arg(&main);
        verilator.arg("-CFLAGS").arg(format!("-DREPLAYS={}", u32::from(machine.replays())));
        if let Some(format) = wave {
            verilator.arg(match format {
                FileFormat::Vcd => "--trace",
                FileFormat::Fst => "--trace-fst",
            });
            let orders = folder.join("same.vlt");
            fs::write(&orders, same_signals(modules)).unwrap();
            verilator.arg(orders);
        }
        run(verilator.args(modules.iter().map(|module| folder.join(&module.name))));
        let mut make = Command::new("make");
        make.args(["-j2", "-f", "Vmachine.mk", "Vmachine"]).current_dir(&built);
        run(make.arg(format!("OPT_FAST={CXX}")).arg(format!("OPT_GLOBAL={CXX}")));
        let took = start.elapsed();

        let file = folder.join("frame.bin");
        let words = frame.fragments.iter().flat_map(|f| [f.x, f.y, f.z, f.rgba]);
        fs::write(&file, words.flat_map(u32::to_ne_bytes).collect::<Vec<u8>>()).unwrap();
        let mut process = Command::new(built.join("Vmachine"))
            .arg(file)
            .arg(frame.screen.pixels().to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let orders = process.stdin.take().unwrap();
        let answers = BufReader::new(process.stdout.take().unwrap());
        Verilated { process, orders, answers, built: took }
    }

    /// Plays the frame once; a model with a waveform writes it to `wave`.
    pub fn play(&mut self, wave: &Path) -> Played {
        let mut answer = String::new();
        let asked = writeln!(self.orders, "{}", wave.display());
        asked.and_then(|()| self.answers.read_line(&mut answer)).unwrap();
        let words: Vec<&str> = answer.split_whitespace().collect();
        let [cycles, seconds, checksum] = words[..] else {
            panic!("the verilated machine ended early and said {answer:?}");
        };
        Played {
            cycles: cycles.parse().unwrap(),
            seconds: seconds.parse().unwrap(),
            checksum: checksum.parse().unwrap(),
        }
    }
}

impl Drop for Verilated {
    fn drop(&mut self) {
        // It waits for an order that does not come.
        let _ = self.process.kill().and_then(|()| self.process.wait());
    }
}
