//! How fast the simulation is beside Verilator: `cargo bench --bench verilator -- [SCENE]...`.
//!
//! The exported T-buffer is built with Verilator and plays the same frame as the Rust simulation, from
//! reset to the last pixel shown, in turns, so that a busy machine slows both. Each runs on one thread; a
//! second one writes the waveform of the Rust simulation. Cycles and images must agree. The first round warms
//! up and is not counted.
//!
//! Waveforms are compared twice. *Same signals*: Verilator dumps what the Rust simulation dumps, the
//! clock, the registers of every block and the machine's outputs; so does crate `vcd` alone. What writing
//! takes is the time beyond that of the same run without a waveform. *By itself*: Verilator dumps everything
//! that is in the Verilog, as `--trace` does unless told otherwise; inner wires and the memories' read
//! pipelines are in that file alone. All write below the folder for temporary files.
//!
//! What building takes is shown for Verilator alone: its program is built for a machine and a screen, the
//! Rust simulation takes both when it runs.

mod bare;
mod verilated;

use pellucid_blocks::allocator::Chosen;
use pellucid_hw::architecture;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_sim::netlist::elaborate_alone;
use pellucid_tbuffer::TBuffer;
use pellucid_tbuffer::config::{Config, Params};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::export::write;
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::scene::{Options, Scene};
use pellucid_testbench::window::Window;
use pellucid_verilog::{File, files};
use pellucid_waveforms::FileFormat;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::time::Instant;
use verilated::{Trace, Verilated, flags, version};

const ROUNDS: usize = 9;
/// Waveforms are large and slow.
const TRACED_ROUNDS: usize = 5;

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

/// The machine without its bench.
type Machine = TBuffer<Chosen>;

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

/// FNV-1a over whole words.
pub fn checksum(pixels: &[u32]) -> u64 {
    let fnv = |sum: u64, pixel: &u32| (sum ^ u64::from(*pixel)).wrapping_mul(0x0100_0000_01b3);
    pixels.iter().fold(0xcbf2_9ce4_8422_2325, fnv)
}

/// Plays the frame once from reset; where `wave` is given, it is written.
fn play(bench: &mut Bench, frame: &Frame, wave: Option<&WaveJob>) -> Played {
    let before = bench.cycles();
    let start = Instant::now();
    bench.reset();
    if let Some(wave) = wave {
        bench.record(wave, "machine").unwrap();
    }
    for fragment in &frame.fragments {
        bench.send(&(*fragment).into()).unwrap();
    }
    bench.end_frame().unwrap();
    assert_eq!(bench.finish_wave().lost, None);
    let seconds = start.elapsed().as_secs_f64();
    let image = bench.take_images().pop().unwrap();
    Played { cycles: bench.cycles() - before, seconds, checksum: checksum(&image.pixels) }
}

/// The size of a waveform, which is removed, and of a VCD the number of its signals.
fn measure(path: &Path) -> String {
    let bytes = fs::metadata(path).unwrap().len();
    let mut signals = String::new();
    if path.extension().is_some_and(|extension| extension == "vcd") {
        let header = BufReader::new(fs::File::open(path).unwrap()).lines().map(Result::unwrap);
        let mut ids = BTreeSet::new();
        for line in header.take_while(|line| !line.starts_with("$enddefinitions")) {
            let mut words = line.split_whitespace();
            if words.next() == Some("$var") {
                // Names of one signal share its id, which follows type and width.
                ids.extend(words.nth(2).map(String::from));
            }
        }
        signals = format!("{} signals, ", ids.len());
    }
    fs::remove_file(path).unwrap();
    format!("{signals}{} MB", bytes / 1_000_000)
}

fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures[figures.len() / 2]
}

/// Something that plays the frame.
struct Player<'a> {
    name: &'static str,
    /// The waveform that it writes.
    wave: Option<PathBuf>,
    /// The player that does the same without it, by its place in the list.
    without: Option<usize>,
    play: Box<dyn FnMut() -> Played + 'a>,
    seconds: Vec<f64>,
    size: String,
}

impl<'a> Player<'a> {
    fn new(
        name: &'static str,
        wave: Option<PathBuf>,
        play: impl FnMut() -> Played + 'a,
    ) -> Player<'a> {
        let (play, seconds, size) = (Box::new(play), vec![], String::new());
        Player { name, wave, without: None, play, seconds, size }
    }
}

/// Lets all play in turns, several rounds, of which the first warms up. The last is what the others are
/// compared with.
fn compare(what: &str, rounds: usize, players: &mut [Player]) {
    let mut cycles = 0;
    for round in 0..=rounds {
        let mut first = None;
        for player in &mut *players {
            let played = (player.play)();
            cycles = played.cycles;
            let result = (played.cycles, played.checksum);
            assert_eq!(result, *first.get_or_insert(result), "cycles and images are equal");
            if round > 0 {
                player.seconds.push(played.seconds);
            }
            if let Some(wave) = &player.wave {
                player.size = measure(wave);
            }
        }
    }
    println!("  {what}: {cycles} cycles each, equal images, median of {rounds}");
    let seconds: Vec<f64> = players.iter().map(|p| median(p.seconds.clone())).collect();
    let yardstick = seconds[seconds.len() - 1];
    for (player, own) in players.iter().zip(&seconds) {
        let Player { name, without, size, .. } = player;
        let speed = cycles as f64 / own / 1e6;
        print!("    {name:34} {speed:7.3} Mcycles/s   ratio {:5.2}", yardstick / own);
        if let Some(without) = without {
            let writing = (own - seconds[*without]) / cycles as f64 * 1e9;
            print!("   writing {writing:6.0} ns/cycle   {size}");
        }
        println!();
    }
}

/// A waveform of so many cycles in a format, of all signals or of those that patterns leave.
fn wave(folder: &Path, format: FileFormat, cycles: u64, scopes: &[&str]) -> Option<WaveJob> {
    let path = folder.join("rust").with_extension(format.extension());
    let window = Window::Cycles { from: 0, to: cycles };
    let scopes = scopes.iter().map(ToString::to_string).collect();
    Some(WaveJob { format, scopes, ..WaveJob::new(&path, &[window]) })
}

/// A player of the Rust simulation.
fn rust<'a>(name: &'static str, frame: &'a Frame, job: Option<WaveJob>) -> Player<'a> {
    let model = architecture("tbuffer").unwrap().build(frame.screen, None, &[]).unwrap();
    let mut bench = Bench::new(&*model);
    let wave = job.as_ref().map(|job| job.path.clone());
    Player::new(name, wave, move || play(&mut bench, frame, job.as_ref()))
}

/// A player of the model that Verilator builds.
fn verilator<'a>(
    name: &'static str,
    folder: &Path,
    modules: &[File],
    trace: Trace,
    frame: &Frame,
) -> Player<'a> {
    let mut verilated = Verilated::build(folder, modules, trace, frame);
    println!(
        "  {name}: built in {:.1?} (Verilog to C++) + {:.1?} (C++ to program)",
        verilated.translated, verilated.compiled
    );
    let wave = folder.join("verilator.vcd");
    let written = (trace != Trace::Off).then(|| wave.clone());
    Player::new(name, written, move || verilated.play(&wave))
}

/// A player of the Rust simulation, without its bench, whose waveform is written by crate `vcd` alone.
fn bare<'a>(name: &'static str, folder: &Path, frame: &'a Frame, traced: bool) -> Player<'a> {
    let wave = traced.then(|| folder.join("bare.vcd"));
    Player::new(name, wave.clone(), move || bare::play(frame, wave.as_deref()))
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
        let modules = files(&elaborate_alone::<Machine>(&cfg), &[]);
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &modules, &[]).unwrap();
        let (folder, frame) = (folder.path(), &frame);
        let build = |name, trace| verilator(name, folder, &modules, trace, frame);
        let (vcd, fst) = (FileFormat::Vcd, FileFormat::Fst);
        let outside = wave(folder, vcd, 10, &[]);
        let mut players = [
            rust("Rust", frame, None),
            rust("Rust, outside of a window", frame, outside),
            build("Verilator", Trace::Off),
        ];
        compare("no waveform", ROUNDS, &mut players);

        let [_, _, untraced] = players;
        // What only our waveforms have.
        let same = ["!*.label", "!*.stall"];
        let after = |without, player| Player { without: Some(without), ..player };
        let mut players = [
            rust("Rust", frame, None),
            after(0, rust("Rust, VCD", frame, wave(folder, vcd, u64::MAX, &same))),
            after(
                0,
                rust("Rust, VCD with labels and stalls", frame, wave(folder, vcd, u64::MAX, &[])),
            ),
            after(0, rust("Rust, FST", frame, wave(folder, fst, u64::MAX, &same))),
            bare("Rust without its bench", folder, frame, false),
            after(4, bare("Rust without its bench, crate vcd", folder, frame, true)),
            untraced,
            after(6, build("Verilator, VCD", Trace::Same)),
        ];
        compare("waveforms of the same signals", TRACED_ROUNDS, &mut players);

        let mut players = [
            rust("Rust, VCD", frame, wave(folder, vcd, u64::MAX, &[])),
            build("Verilator, VCD", Trace::All),
        ];
        compare("waveforms as either writes them by itself", TRACED_ROUNDS, &mut players);
    }
}
