//! How wall time and memory grow with what is simulated: `cargo bench --bench scale`, with `-- --help` for what can be chosen.
//!
//! Each row is a run of the command `pellucid` in a process of its own, with the golden model and without a waveform: the wall
//! time from its start to its end, the median of several runs where one is short, and the most memory that the process had at once.
//! The CPU time says what the run itself took where other work has the cores. What is linear and what is not is said in the book.
//!
//! Tables are in Markdown on standard output.

use clap::{Parser, ValueEnum};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeVal;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_sim::Label;
use pellucid_testbench::report::grouped;
use pellucid_testbench::trace::TraceWriter;
use serde_json::{Value as Json, json};
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Times the command on ever larger work.
#[derive(Parser)]
struct Args {
    /// A table; several may be given [default: all]
    #[arg(long, value_enum)]
    table: Vec<Table>,
    /// The largest rows, too
    #[arg(long)]
    full: bool,
    /// Cargo says it
    #[arg(long, hide = true)]
    bench: bool,
    /// Run `pellucid` with these arguments, and tell what it took
    #[arg(long, hide = true, num_args = 1.., allow_hyphen_values = true)]
    alone: Vec<String>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Table {
    Fragments,
    Screens,
    Layers,
    Engines,
    Machines,
}

/// Rows are run up to three times as long as they have not taken so many seconds.
const LONG_SECONDS: f64 = 10.0;

/// What a run took.
#[derive(Clone, Copy)]
struct Usage {
    /// Wall time.
    seconds: f64,
    /// Time of all cores together.
    cpu_seconds: f64,
    /// The most memory that it had at once, in KiB.
    peak_kib: u64,
}

/// Runs the command and tells what it took. The process that does so has no other child, so that all that is known of its children
/// is the command's.
fn alone(arguments: &[String]) -> ExitCode {
    let start = Instant::now();
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    let status = command.args(arguments).stdout(Stdio::null()).status().unwrap();
    let seconds = start.elapsed().as_secs_f64();
    assert!(status.success(), "{arguments:?}: {status}");
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).unwrap();
    let of = |time: TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 / 1e6;
    let cpu_seconds = of(usage.user_time()) + of(usage.system_time());
    println!("{seconds} {cpu_seconds} {}", usage.max_rss());
    ExitCode::SUCCESS
}

/// Runs the command on so many threads, all cores if nothing is said; what it took.
fn run(arguments: &[String], threads: Option<u32>) -> Usage {
    let once = || {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.arg("--alone").args(arguments).stderr(Stdio::inherit());
        if let Some(threads) = threads {
            command.env("RAYON_NUM_THREADS", threads.to_string());
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{arguments:?} failed");
        let said = String::from_utf8(output.stdout).unwrap();
        let words: Vec<&str> = said.split_whitespace().collect();
        let [seconds, cpu_seconds, peak_kib] = words[..] else { panic!("{said}") };
        Usage {
            seconds: seconds.parse().unwrap(),
            cpu_seconds: cpu_seconds.parse().unwrap(),
            peak_kib: peak_kib.parse().unwrap(),
        }
    };
    let mut runs = vec![once()];
    while runs.len() < 3 && runs.iter().map(|run| run.seconds).sum::<f64>() < LONG_SECONDS {
        runs.push(once());
    }
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    runs[runs.len() / 2]
}

/// The words of a command line, and where its results go.
fn words(text: &str, out: &Path) -> Vec<String> {
    let out = ["--quiet".to_string(), "--out".to_string(), out.display().to_string()];
    text.split_whitespace().map(str::to_string).chain(out).collect()
}

/// A row of a table.
fn row(cells: &[String]) -> String {
    format!("| {} |", cells.join(" | "))
}

/// The head of a table.
fn head(title: &str, columns: &[&str]) {
    let columns: Vec<String> = columns.iter().map(ToString::to_string).collect();
    println!("\n{title}\n\n{}\n|{}", row(&columns), "---|".repeat(columns.len()));
}

/// The head of a table of runs, of which each row begins with `what`.
fn head_of_runs(title: &str, what: &str) {
    let speed = "million cycles a second";
    let columns = [what, "fragments", "cycles", "wall time, s", "CPU time, s", speed];
    head(title, &[&columns[..], &["peak memory, MiB"]].concat());
}

/// A row of a table of runs.
fn row_of_run(what: &str, arguments: &str) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let usage = run(&words(&format!("run --no-wave {arguments}"), &out), None);
    let stats = fs::read_to_string(out.join("stats.json")).unwrap();
    let stats: Json = serde_json::from_str(&stats).unwrap();
    let cycles = &stats["cycles"]["total"];
    println!(
        "{}",
        row(&[
            what.to_string(),
            grouped(&stats["frame"]["fragments"]),
            grouped(cycles),
            format!("{:.2}", usage.seconds),
            format!("{:.2}", usage.cpu_seconds),
            format!("{:.3}", cycles.as_f64().unwrap() / usage.seconds / 1e6),
            grouped(&json!(usage.peak_kib >> 10)),
        ])
    );
}

fn fragments(full: bool) {
    let title = "T-buffer, screen of 3840x2160, 12 layers over a part of it (`quads-12-P`)";
    head_of_runs(title, "percent");
    let percents: &[u32] = if full { &[0, 1, 3, 10, 30, 100] } else { &[0, 1, 3, 10] };
    for percent in percents {
        let arguments = format!("--scene quads-12-{percent} --width 3840 --height 2160");
        row_of_run(&percent.to_string(), &arguments);
    }
}

fn screens(full: bool) {
    head_of_runs("T-buffer, scene `glass`", "screen");
    let mut screens = vec![(640, 480), (1280, 720), (1920, 1080), (3840, 2160)];
    screens.extend(full.then_some((7680, 4320)));
    for (width, height) in screens {
        row_of_run(&format!("{width}x{height}"), &format!("--width {width} --height {height}"));
    }
}

/// As many fragments as pixels, in so many layers over a part of them, in no order of depth.
fn deep(path: &Path, layers: u32) {
    let screen = Screen { width: 1200, height: 800, background: 0 };
    let mut trace = TraceWriter::create(path, screen, 1).unwrap();
    for layer in 0..layers {
        for pixel in 0..screen.pixels() / layers {
            let (x, y) = (pixel % screen.width, pixel / screen.width);
            // An odd number steps through all depths before one comes again.
            let z = layer.wrapping_mul(0x9e_3779) & 0xff_ffff;
            trace.push(Fragment { x, y, z, rgba: 0x8040_2040, label: Label::NONE }).unwrap();
        }
    }
    trace.finish().unwrap();
}

fn layers() {
    let title =
        "T-buffer, screen of 1200x800, as many fragments as pixels, in layers over a part of it";
    head_of_runs(title, "layers");
    let folder = tempfile::tempdir().unwrap();
    for layers in [1, 10, 30, 100, 300, 1000] {
        let path = folder.path().join("deep.ptrace");
        deep(&path, layers);
        // All of them are on the chip.
        let arguments = format!("-p sections=960000 --scene {}", path.display());
        row_of_run(&layers.to_string(), &arguments);
    }
}

fn engines() {
    head_of_runs("Image composition machine, screen of 160x120, scene `panes`", "engines");
    for engines in [1, 4, 16, 64, 256, 1024] {
        let arguments = "--arch composer --scene panes --width 160 --height 120";
        let arguments = format!("{arguments} -p engines={engines}");
        row_of_run(&engines.to_string(), &arguments);
    }
}

fn machines() {
    let columns = ["machines", "one thread, s", "all cores, s", "cores busy", "peak memory, MiB"];
    head("`compare`, scene `glass`", &columns);
    let alike = |count: u32| {
        let machines = (1..=count).map(|k| format!("--machine tbuffer:fast,section_capacity={k}"));
        (format!("{count} times `tbuffer`"), machines.collect::<Vec<_>>().join(" "))
    };
    let mut all: Vec<(String, String)> = [1, 2, 3, 4, 8].map(alike).to_vec();
    let kinds = ["rbuffer", "tbuffer", "tbuffer:paper", "mbuffer", "dfb", "b3d", "ppll"];
    let kinds: Vec<String> = kinds.iter().map(|kind| format!("--machine {kind}")).collect();
    all.push((format!("{} of several kinds", kinds.len()), kinds.join(" ")));
    for (name, machines) in all {
        let folder = tempfile::tempdir().unwrap();
        let words = words(&format!("compare {machines}"), folder.path());
        let [one, cores] = [Some(1), None].map(|threads| run(&words, threads));
        println!(
            "{}",
            row(&[
                name,
                format!("{:.2}", one.seconds),
                format!("{:.2}", cores.seconds),
                format!("{:.2}", cores.cpu_seconds / cores.seconds),
                grouped(&json!(cores.peak_kib >> 10)),
            ])
        );
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    if !args.alone.is_empty() {
        return alone(&args.alone);
    }
    if !args.bench {
        println!("skipped: only `cargo bench` measures");
        return ExitCode::SUCCESS;
    }
    for table in Table::value_variants() {
        if args.table.is_empty() || args.table.contains(table) {
            match table {
                Table::Fragments => fragments(args.full),
                Table::Screens => screens(args.full),
                Table::Layers => layers(),
                Table::Engines => engines(),
                Table::Machines => machines(),
            }
        }
    }
    ExitCode::SUCCESS
}
