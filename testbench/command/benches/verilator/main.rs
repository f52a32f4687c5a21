//! How fast the simulation is beside Verilator: `cargo bench --bench verilator`, with `-- --help` for what can be chosen.
//!
//! Each exported machine is built with Verilator and plays the same frame as the Rust simulation, from reset to the
//! last pixel shown, in turns, so that a busy machine slows both. Cycles and images must agree, and nothing may go
//! outside of the chip. The first round warms up and is not counted. A ratio is the median of those of the rounds.
//!
//! Verilator's machines run on one thread and on two, of which one writes an FST. Where two are slower than one without a
//! waveform they are not tried with a VCD. In the Rust simulation a second thread writes the waveform.
//!
//! Waveforms have the same signals on both sides: the clock, the registers of every block and the machine's outputs,
//! from the first cycle on in which the machine does not clear its memories. What writing takes is the time beyond that of the
//! same run without a waveform. All write below the folder for temporary files.
//!
//! Tables are in Markdown on standard output; what is being done is told on standard error.

mod bare;
mod verilated;

use clap::Parser;
use pellucid_hw::architecture;
use pellucid_machine::Model;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::export::{modules, write};
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::report::grouped;
use pellucid_testbench::scene::{Options, Scene};
use pellucid_testbench::window::Window;
use pellucid_waveforms::FileFormat;
use serde_json::json;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::time::Instant;
use verilated::{Tool, Verilated, flags, version};

/// Times the Rust simulation and Verilator's machines on the same frame.
#[derive(Parser)]
struct Args {
    /// A Verilator, by name or path; several may be given
    #[arg(long, default_value = "verilator", value_name = "PROGRAM")]
    verilator: Vec<String>,
    /// On how many threads its machines run, 1 or 2; both may be given, and so they are by default. Two wait for each other in each
    /// cycle: where other work has the cores, that may take hours
    #[arg(long, default_values_t = [1, 2], value_parser = clap::value_parser!(u32).range(1..=2))]
    threads: Vec<u32>,
    /// An architecture, as its first preset has it; several may be given
    #[arg(long, default_values = ["tbuffer", "rbuffer", "mbuffer", "dfb"], value_name = "ARCH")]
    machine: Vec<String>,
    /// A built-in scene
    #[arg(long, default_value = "glass", value_name = "NAME")]
    scene: String,
    /// Rounds that count; with a waveform there are half as many
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// Cargo says it
    #[arg(long, hide = true)]
    bench: bool,
}

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
fn checksum(pixels: &[u32]) -> u64 {
    let fnv = |sum: u64, pixel: &u32| (sum ^ u64::from(*pixel)).wrapping_mul(0x0100_0000_01b3);
    pixels.iter().fold(0xcbf2_9ce4_8422_2325, fnv)
}

/// Begins to watch a machine.
type Watch = Box<dyn Fn(&mut Bench)>;

/// Plays the frame once from reset, watched from the beginning.
fn play(bench: &mut Bench, frame: &Frame, watch: Option<&Watch>) -> Played {
    let before = bench.cycles();
    let start = Instant::now();
    bench.reset();
    if let Some(watch) = watch {
        watch(bench);
    }
    let send = |fragment: &Fragment, bench: &mut Bench| bench.send(&(*fragment).into());
    bench.frame(|bench| frame.fragments.iter().try_for_each(|f| send(f, bench))).unwrap();
    bench.wait_for(1, |_, _| Ok(())).unwrap();
    assert_eq!(bench.finish_wave().lost, None);
    // What else watched ends its file here.
    drop(bench.observer::<bare::Dump>());
    let seconds = start.elapsed().as_secs_f64();
    let fragments = bench.tally().fragments;
    assert_eq!((fragments.dropped, fragments.spilled), (0, 0), "all fragments are on the chip");
    let image = bench.take_images().pop().unwrap();
    Played { cycles: bench.cycles() - before, seconds, checksum: checksum(&image.pixels) }
}

/// A waveform's size.
#[derive(Clone, Copy, Default)]
struct Size {
    bytes: u64,
    /// Signals of a VCD.
    signals: usize,
}

/// The size of a waveform, which is removed.
fn measure(path: &Path) -> Size {
    let bytes = fs::metadata(path).unwrap().len();
    let mut ids = BTreeSet::new();
    if path.extension().is_some_and(|extension| extension == "vcd") {
        let header = BufReader::new(fs::File::open(path).unwrap()).lines().map(Result::unwrap);
        for line in header.take_while(|line| !line.starts_with("$enddefinitions")) {
            let mut words = line.split_whitespace();
            if words.next() == Some("$var") {
                // Names of one signal share its id, which follows type and width.
                ids.extend(words.nth(2).map(String::from));
            }
        }
    }
    fs::remove_file(path).unwrap();
    Size { bytes, signals: ids.len() }
}

fn median(figures: impl Iterator<Item = f64>) -> f64 {
    let mut figures: Vec<f64> = figures.collect();
    figures.sort_by(f64::total_cmp);
    figures[figures.len() / 2]
}

/// Something that plays the frame.
struct Player<'a> {
    /// The waveform that it writes.
    wave: Option<PathBuf>,
    play: Box<dyn FnMut() -> Played + 'a>,
    cycles: u64,
    seconds: Vec<f64>,
    size: Size,
}

impl<'a> Player<'a> {
    fn new(wave: Option<PathBuf>, play: impl FnMut() -> Played + 'a) -> Player<'a> {
        Player { wave, play: Box::new(play), cycles: 0, seconds: vec![], size: Size::default() }
    }

    /// The Rust simulation; whoever watches it writes `wave`.
    fn rust(model: &dyn Model, frame: &'a Frame, watch: Option<(PathBuf, Watch)>) -> Player<'a> {
        let mut bench = Bench::new(model);
        let (wave, watch) = watch.unzip();
        Player::new(wave, move || play(&mut bench, frame, watch.as_ref()))
    }

    /// Millions of cycles a second.
    fn speed(&self) -> f64 {
        self.cycles as f64 / median(self.seconds.iter().copied()) / 1e6
    }

    /// How many times as fast it is as another one in the same round.
    fn ratio(&self, other: &Player) -> f64 {
        median(other.seconds.iter().zip(&self.seconds).map(|(other, own)| other / own))
    }
}

/// Lets all play in turns, several rounds, of which the first warms up.
fn take_turns(rounds: usize, players: &mut [Player]) {
    for round in 0..=rounds {
        let mut first = None;
        for player in &mut *players {
            let played = (player.play)();
            let result = (played.cycles, played.checksum);
            assert_eq!(result, *first.get_or_insert(result), "cycles and images are equal");
            player.cycles = played.cycles;
            if round > 0 {
                player.seconds.push(played.seconds);
            }
            if let Some(wave) = &player.wave {
                player.size = measure(wave);
            }
        }
    }
}

/// What only our waveforms have.
const SAME: [&str; 2] = ["!*.label", "!*.stall"];

/// A waveform of the first cycles, by the Rust simulation: its file, and how it is begun.
fn wave(folder: &Path, format: FileFormat, cycles: u64, scopes: &[&str]) -> (PathBuf, Watch) {
    let path = folder.join("rust").with_extension(format.extension());
    let window = Window::Cycles { from: 0, to: cycles };
    let scopes = scopes.iter().map(ToString::to_string).collect();
    let job = WaveJob { format, scopes, ..WaveJob::new(&path, &[window]) };
    (path, Box::new(move |bench| bench.record(&job, "machine").unwrap()))
}

/// One by crate `vcd` alone.
fn bare(folder: &Path) -> (PathBuf, Watch) {
    let path = folder.join("bare.vcd");
    let dump = path.clone();
    let begin = move |bench: &mut Bench| {
        let dump = bare::Dump::new(&dump, bench.dut());
        bench.watch(dump);
    };
    (path, Box::new(begin))
}

/// The waveforms, and what a table calls them.
const WAVES: [(&str, Option<FileFormat>); 3] =
    [("none", None), ("VCD", Some(FileFormat::Vcd)), ("FST", Some(FileFormat::Fst))];

/// A row of a table.
fn row(cells: &[String]) -> String {
    format!("| {} |", cells.join(" | "))
}

/// The rows of a machine: one for each kind of waveform.
fn beside_verilator(args: &Args, tools: &[Tool], frame: &Frame, arch: &str) -> Vec<String> {
    let model = architecture(arch).and_then(|arch| arch.build(frame.screen, None, &[]));
    let model = model.unwrap_or_else(|error| panic!("{error}"));
    let folder = tempfile::tempdir().unwrap();
    let modules = modules(arch, frame.screen, &*model, &model.netlist());
    write(folder.path(), &modules, &[]).unwrap();
    let folder = folder.path();
    let mut rows = vec![];
    // Those that a second thread makes slower.
    let mut slowed = vec![false; tools.len()];
    for (name, format) in WAVES {
        let watch = format.map(|format| wave(folder, format, u64::MAX, &SAME));
        let mut players = vec![Player::rust(&*model, frame, watch)];
        let playing = (0..tools.len()).filter(|k| format != Some(FileFormat::Vcd) || !slowed[*k]);
        let playing: Vec<usize> = playing.collect();
        for k in &playing {
            let tool = tools[*k];
            let mut verilated = Verilated::build(tool, folder, &*model, &modules, format, frame);
            let Tool { program, threads } = tool;
            let took = verilated.built;
            eprintln!("{arch}, waveform {name}, {program}, {threads} threads: built in {took:.1?}");
            let file = folder.join("verilator");
            let file = file.with_extension(format.map_or("", |format| format.extension()));
            players.push(Player::new(format.map(|_| file.clone()), move || verilated.play(&file)));
        }
        let rounds = if format.is_some() { args.rounds.div_ceil(2) } else { args.rounds };
        take_turns(rounds, &mut players);
        let [rust, verilated @ ..] = &players[..] else { unreachable!() };
        if format.is_none() {
            let faster = |k: usize, j: usize| {
                tools[j].program == tools[k].program && verilated[j].speed() > verilated[k].speed()
            };
            let all = 0..tools.len();
            slowed = all
                .clone()
                .map(|k| tools[k].threads == 2 && all.clone().any(|j| faster(k, j)))
                .collect();
        }
        let mut cells = vec![arch.to_string(), name.to_string(), grouped(&json!(rust.cycles))];
        if format == Some(FileFormat::Vcd) {
            // The number of the cycle is not in the Verilog.
            let signals = [rust.size.signals - 1].into_iter();
            let signals = signals.chain(verilated.iter().map(|player| player.size.signals));
            let signals: Vec<String> = signals.map(|signals| signals.to_string()).collect();
            cells[1] += &format!(" of {} signals", signals.join(", "));
        }
        cells.push(format!("{:.2}", rust.speed()));
        let mut speeds = vec!["-".to_string(); tools.len()];
        for (k, player) in playing.iter().zip(verilated) {
            speeds[*k] = format!("{:.2}", player.speed());
        }
        cells.extend(speeds);
        let ratios = verilated.iter().map(|verilated| rust.ratio(verilated));
        cells.push(format!("{:.1}", ratios.fold(f64::INFINITY, f64::min)));
        rows.push(row(&cells));
        eprintln!("{}", rows[rows.len() - 1]);
    }
    rows
}

/// What waveforms take in the Rust simulation of a machine, as a table.
fn waveforms(args: &Args, frame: &Frame, arch: &str) -> String {
    let model = architecture(arch).unwrap().build(frame.screen, None, &[]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let wave = |format, cycles, scopes| wave(folder.path(), format, cycles, scopes);
    let kinds = [
        ("none", None),
        ("the first ten cycles", Some(wave(FileFormat::Vcd, 10, &[]))),
        ("VCD", Some(wave(FileFormat::Vcd, u64::MAX, &SAME))),
        ("VCD with labels and stalls", Some(wave(FileFormat::Vcd, u64::MAX, &[]))),
        ("FST", Some(wave(FileFormat::Fst, u64::MAX, &SAME))),
        ("VCD by crate `vcd` alone", Some(bare(folder.path()))),
    ];
    let names = kinds.each_ref().map(|(name, _)| *name);
    let mut players = kinds.map(|(_, watch)| Player::rust(&*model, frame, watch));
    take_turns(args.rounds.div_ceil(2), &mut players);
    let mut table =
        "| waveform | million cycles a second | writing, ns a cycle | MB |\n|---|---|---|---|\n"
            .to_string();
    let seconds = |player: &Player| median(player.seconds.iter().copied());
    for (name, player) in names.iter().zip(&players) {
        let beyond = (seconds(player) - seconds(&players[0])) / player.cycles as f64 * 1e9;
        let megabytes = player.size.bytes / 1_000_000;
        let cells = [
            (*name).to_string(),
            format!("{:.2}", player.speed()),
            if player.wave.is_some() { format!("{beyond:.0}") } else { "-".to_string() },
            if player.wave.is_some() { megabytes.to_string() } else { "-".to_string() },
        ];
        table += &format!("{}\n", row(&cells));
    }
    table
}

fn main() {
    let args = Args::parse();
    if !args.bench {
        println!("skipped: only `cargo bench` measures");
        return;
    }
    println!("{}\n", flags());
    let mut head = ["machine", "waveform", "cycles", "Rust"].map(String::from).to_vec();
    let mut tools = vec![];
    for (number, program) in (1..).zip(&args.verilator) {
        let Some(version) = version(program) else {
            println!("skipped: `{program}` is not installed");
            return;
        };
        println!("- V{number}: {version} (`{program}`)");
        for threads in args.threads.iter().copied() {
            head.push(if threads == 1 {
                format!("V{number}")
            } else {
                format!("V{number}, 2 threads")
            });
            tools.push(Tool { program, threads });
        }
    }
    head.push("ratio".to_string());
    let frame = open(&args.scene);
    let fragments = grouped(&json!(frame.fragments.len()));
    println!("\n{}, {fragments} fragments; millions of cycles a second:\n", args.scene);
    println!("{}\n|{}", row(&head), "---|".repeat(head.len()));
    let rows = args.machine.iter().map(|arch| beside_verilator(&args, &tools, &frame, arch));
    rows.flatten().for_each(|row| println!("{row}"));
    let arch = &args.machine[0];
    println!("\nWhat a waveform takes in the Rust simulation of {arch}:\n");
    print!("{}", waveforms(&args, &frame, arch));
}
