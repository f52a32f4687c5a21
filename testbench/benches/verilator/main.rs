//! How fast the simulation is beside Verilator: `cargo bench --bench verilator -- [SCENE]...`.
//!
//! The exported T-buffer is built with Verilator and plays the same frame as the Rust simulation, from
//! reset to the last pixel shown, on one thread each and in turns, so that a busy machine slows both.
//! Cycles and images must agree. The first round warms up and is not counted.
//!
//! Waveforms are compared twice. *Same signals*: Verilator dumps what the Rust simulation dumps, the
//! clock, the registers of every block and the machine's outputs. *All signals*: it dumps everything
//! that is in the Verilog, as `--trace` does unless told otherwise; inner wires and the memories' read
//! pipelines are in that file alone. Either writes a VCD file below the folder for temporary files.
//!
//! What building takes is shown for Verilator alone: its program is built for a machine and a screen, the
//! Rust simulation takes both when it runs.

mod verilated;

use pellucid_hw::allocator::FreeList;
use pellucid_hw::pixel::{Fragment, Marked, Screen};
use pellucid_hw::tbuffer::TBuffer;
use pellucid_hw::tbuffer::config::{Config, Params};
use pellucid_sim::netlist::elaborate;
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::export::write;
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::scene::{Options, Scene};
use pellucid_testbench::window::Window;
use pellucid_verilog::{File, files};
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::time::Instant;
use verilated::{Trace, Verilated, flags, version};

const ROUNDS: usize = 9;
/// Waveforms are large and slow.
const TRACED_ROUNDS: usize = 3;

/// What is played.
pub struct Frame {
    /// The screen.
    pub screen: Screen,
    /// The fragments in their order.
    pub fragments: Vec<Fragment>,
}

/// What playing a frame came to.
#[derive(Clone, Copy)]
pub struct Played {
    /// From the first cycle after reset to that of the last pixel.
    pub cycles: u64,
    /// What they took.
    pub seconds: f64,
    /// FNV-1a over the pixels of the image.
    pub checksum: u64,
}

type Machine = TBuffer<FreeList>;

fn open(scene: &str) -> Frame {
    let scene = Scene::open(scene, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut fragments = vec![];
    scene
        .play::<BenchError>(&mut |fragment| {
            fragments.push(fragment);
            Ok(())
        })
        .unwrap();
    Frame { screen: scene.info(), fragments }
}

/// Plays the frame once from reset; where `wave` is given, every cycle is written to it.
fn play(bench: &mut Bench<Machine>, frame: &Frame, wave: Option<&Path>) -> Played {
    let before = bench.cycles();
    let start = Instant::now();
    bench.reset().unwrap();
    if let Some(path) = wave {
        let all = Window::Cycles { from: 0, to: u64::MAX };
        bench.record(&WaveJob::new(path, &[all]), "machine").unwrap();
    }
    for fragment in &frame.fragments {
        bench.send(Marked::item(*fragment)).unwrap();
    }
    bench.end_frame().unwrap();
    bench.finish_wave().unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let image = bench.take_images().pop().unwrap();
    let fnv = |sum: u64, pixel: &u32| (sum ^ u64::from(*pixel)).wrapping_mul(0x0100_0000_01b3);
    let checksum = image.pixels.iter().fold(0xcbf2_9ce4_8422_2325, fnv);
    Played { cycles: bench.cycles() - before, seconds, checksum }
}

/// The signals and the size of a waveform, which is removed.
fn measure(path: &Path) -> String {
    let header = BufReader::new(fs::File::open(path).unwrap()).lines().map(Result::unwrap);
    let mut signals = BTreeSet::new();
    for line in header.take_while(|line| !line.starts_with("$enddefinitions")) {
        let mut words = line.split_whitespace();
        if words.next() == Some("$var") {
            // Names of one signal share its id, which follows type and width.
            signals.extend(words.nth(2).map(String::from));
        }
    }
    let bytes = fs::metadata(path).unwrap().len();
    fs::remove_file(path).unwrap();
    format!("{} signals, {} MB", signals.len(), bytes / 1_000_000)
}

fn median(mut speeds: Vec<f64>) -> f64 {
    speeds.sort_by(f64::total_cmp);
    speeds[speeds.len() / 2]
}

/// Builds one model, plays the frame to it and to the Rust simulation in turns, and reports.
fn compare(what: &str, folder: &Path, modules: &[File], trace: Trace, frame: &Frame) {
    let mut verilated = Verilated::build(folder, modules, trace, frame);
    let mut bench = Bench::<Machine>::new(Config::new(frame.screen, Params::default()).unwrap());
    let waves = [folder.join("rust.vcd"), folder.join("verilator.vcd")];
    let traced = trace != Trace::Off;
    let rounds = if traced { TRACED_ROUNDS } else { ROUNDS };
    let (mut speeds, mut dumps) = ([vec![], vec![]], [String::new(), String::new()]);
    let mut cycles = 0;
    for round in 0..=rounds {
        let rust = play(&mut bench, frame, traced.then_some(&waves[0]));
        let other = verilated.play(&waves[1]);
        assert_eq!(rust.cycles, other.cycles, "both take as many cycles");
        assert_eq!(rust.checksum, other.checksum, "both show the same image");
        cycles = rust.cycles;
        for (k, played) in [rust, other].iter().enumerate() {
            if round > 0 {
                speeds[k].push(played.cycles as f64 / played.seconds / 1e6);
            }
            if traced {
                dumps[k] = format!("   {}", measure(&waves[k]));
            }
        }
    }
    let [rust, other] = speeds.map(median);
    let (translated, compiled) = (verilated.translated, verilated.compiled);
    verilated.finish().unwrap();
    println!("  {what}: {cycles} cycles each, equal images, median of {rounds}");
    println!("    Rust       {rust:7.3} Mcycles/s{}", dumps[0]);
    println!("    Verilator  {other:7.3} Mcycles/s{}", dumps[1]);
    println!("    ratio      {:7.2}", rust / other);
    println!("    built in {translated:.1?} (Verilog to C++) + {compiled:.1?} (C++ to program)");
}

fn main() {
    let (options, mut scenes): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument.starts_with("--"));
    if !options.iter().any(|option| option == "--bench") {
        println!("skipped: only `cargo bench` measures");
        return;
    }
    let Some(version) = version() else {
        println!("skipped: `verilator` is not installed");
        return;
    };
    println!("{version}\n{}", flags());
    if scenes.is_empty() {
        scenes.push("paper-480".to_string());
    }
    for scene in scenes {
        let frame = open(&scene);
        println!("{scene}, {} fragments", frame.fragments.len());
        let cfg = Config::new(frame.screen, Params::default()).unwrap();
        let modules = files(&elaborate::<Machine>(&cfg), &[]);
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &modules, &[]).unwrap();
        for (what, trace) in [
            ("no waveform", Trace::Off),
            ("VCD, same signals", Trace::Same),
            ("VCD, all signals", Trace::All),
        ] {
            compare(what, folder.path(), &modules, trace, &frame);
        }
    }
}
