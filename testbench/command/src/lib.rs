//! The command `pellucid`: what is asked, and the exit status.
//!
//! 0: done and right. 1: the run's result is wrong or lossy. 2: bad input or usage, or a file that cannot be written.
//! 130: stopped by a signal; what was not complete has been removed, but for a waveform, which is kept as far as it goes.

mod amount;
mod area;
mod check;
mod compare;
mod explain;
mod explore;
mod export;
mod list;
mod machine;
mod reproduce;
mod run;
mod sequence;
mod size;
mod technology;
mod trace;
mod wave;

use clap::error::{ContextKind, ContextValue};
use clap::{Args, Parser, Subcommand};
use pellucid_machine::pixel::MAX_SIDE;
use pellucid_machine::{Kind, Model};
use pellucid_testbench::bench::BenchError;
use pellucid_testbench::output::partial::leave_behind;
use pellucid_testbench::output::{OutputError, abandon};
use pellucid_testbench::room::Limit;
use pellucid_testbench::scene::{
    AlphaRule, Camera, MOST_INSTANCES, Options, Order, Sequence, is_built_in,
};
use pellucid_testbench::scoreboard::Verdict;
use pellucid_testbench::source::{Source, SourceError};
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// The result is wrong or lossy.
const WRONG: u8 = 1;
/// Bad input or usage.
const BAD_INPUT: u8 = 2;
/// A signal came.
const STOPPED: i32 = 130;

/// What the help says of the exit status.
const STATUS: &str = "Exit status: 0 done and right, 1 the run's result is wrong or lossy, 2 bad input \
                      or usage, 130 stopped by a signal";

/// Clocked hardware models for order-independent transparency.
///
/// Without a command: `run`.
#[derive(Parser)]
#[command(name = "pellucid", version, args_conflicts_with_subcommands = true, after_help = STATUS)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::RunArgs,
}

#[derive(Subcommand)]
enum Command {
    /// Sends one frame through one architecture; leaves image, figures and waveform
    Run(Box<run::RunArgs>),
    /// Sends scenes through several machines; leaves their figures side by side, with plots
    Compare(compare::CompareArgs),
    /// Sends scenes through every design of a study, and shows which are worth building
    Explore(explore::ExploreArgs),
    /// Shows what differs most between two runs: cycles, stalls, traffic
    Explain(explain::ExplainArgs),
    /// Runs a share of the points of a study, for many computers that share a folder
    RunPoint(explore::RunPointArgs),
    /// Finds the smallest machine that loses nothing of some scenes, as a file that --config takes
    Size(size::SizeArgs),
    /// Writes an architecture as Verilog, with a testbench that compares it with this simulation
    Export(export::ExportArgs),
    /// Counts what an architecture takes as hardware, by Yosys: cells of an FPGA, or square millimetres of a library of cells
    Area(area::AreaArgs),
    /// Makes a paper's comparison again, with its printed figures beside what is counted
    Reproduce(reproduce::ReproduceArgs),
    /// Writes a scene's fragments to a trace file
    Trace(trace::TraceArgs),
    /// Lists architectures with their parameters, and scenes
    List(list::ListArgs),
}

/// What is said of a result that is not right, whether it passes for all that or not.
fn not_right(passes: bool) -> &'static str {
    if passes {
        "The result is lossy, which is allowed: see what is said on standard error."
    } else {
        "The result is wrong or lossy: see what is said on standard error."
    }
}

/// The scene where none is named.
const DEFAULT_SCENE: &str = "glass";

/// Which frame, and how it is seen.
#[derive(Args)]
struct SceneArgs {
    /// A built-in scene (see `pellucid list`), a mesh (.obj, .ply, .ply.gz, .gltf, .glb) or a trace
    /// (.csv, .ptrace)
    #[arg(long, default_value = DEFAULT_SCENE, value_name = "NAME|FILE")]
    scene: String,
    #[command(flatten)]
    view: ViewArgs,
}

impl SceneArgs {
    /// Opens it, for one frame.
    fn open(&self) -> Result<Source, SourceError> {
        self.view.open_one(&self.scene)
    }
}

/// How a frame is seen.
#[derive(Args)]
struct ViewArgs {
    /// Columns of the screen, 1 to 8192 [default: 640]
    #[arg(long, value_name = "PIXELS", value_parser = side, allow_hyphen_values = true)]
    width: Option<u32>,
    /// Rows of the screen, 1 to 8192 [default: 480]
    #[arg(long, value_name = "PIXELS", value_parser = side, allow_hyphen_values = true)]
    height: Option<u32>,
    /// Eye, point looked at and vertical field of view in degrees: `EX,EY,EZ:TX,TY,TZ[:FOV]`
    /// [default: fits the mesh]
    #[arg(long, value_name = "EYE:TARGET[:FOV]", allow_hyphen_values = true)]
    camera: Option<Camera>,
    /// Opacity 0 to 1 of all meshes, or of the one of that name; may be given several times
    /// [default: what the file states, 0.5 where it states none]
    #[arg(long, value_name = "[NAME=]ALPHA")]
    alpha: Vec<AlphaRule>,
    /// How often a mesh, `glass`, `teapot` or `plant` is there, side by side along x, 1 to 1000; with several and no --camera the
    /// view fits all of them [default: 1]
    #[arg(long, value_name = "INSTANCES", value_parser = instances, allow_hyphen_values = true)]
    instances: Option<u32>,
    /// How the rasteriser goes through a triangle, a splat or a particle: `scan-line`, row by row, `tile-8x8`, tiles of 8x8
    /// pixels, `morton`, along the Z-order curve, or `quad`, quads of 2x2 pixels. Machines that take triangles go through
    /// these row by row themselves [default: scan-line]
    #[arg(long, value_name = "ORDER")]
    order: Option<Order>,
    /// All that is opaque in a frame comes before all that is transparent, each in its order; the frame, or trace, is read twice
    /// for it, and takes no more memory [default: as the scene has it]
    #[arg(long)]
    opaque_first: bool,
    /// Most memory that a mesh may take while it is read, as `4G` [default: half of what the computer has left]
    #[arg(long, value_name = "BYTES")]
    memory_limit: Option<Limit>,
}

impl ViewArgs {
    /// Opens a scene for one frame, which is repeated where one image is made of several; of a trace with several it is the first.
    fn open_one(&self, scene: &str) -> Result<Source, SourceError> {
        let source = self.open(scene, None)?;
        if let Some(frames @ 2..) = source.recorded() {
            tell(&format!("note: {scene}: of its {frames} frames the first is taken"));
        }
        Ok(source.repeated())
    }

    /// Opens a scene at the first frame of a sequence, if it is for one.
    fn open(&self, scene: &str, sequence: Option<Sequence>) -> Result<Source, SourceError> {
        let options = Options {
            instances: self.instances,
            sequence,
            width: self.width,
            height: self.height,
            camera: self.camera,
            alphas: self.alpha.clone(),
            order: self.order,
            memory_limit: self.memory_limit,
        };
        let source = Source::open(scene, &options)?;
        source.notes().iter().for_each(|note| tell(&format!("note: {note}")));
        Ok(if self.opaque_first { source.opaque_first() } else { source })
    }

    /// Says where an order of fragments is asked for that a machine does not follow.
    fn tell_of_order(&self, name: &str, machine: &dyn Model) {
        let order = self.order.filter(|order| *order != Order::default());
        if let (Some(order), Kind::Primitives) = (order, machine.kind()) {
            tell(&format!(
                "note: {name} goes through triangles itself, row by row: --order {order} is for other machines"
            ));
        }
    }

    /// Says once that a trace has no vertices, if one of the machines counts some.
    fn tell_of_points(scene: &str, source: &Source, machines: &[&dyn Model]) {
        let counts = |machine: &&dyn Model| {
            machine.values().iter().any(|(name, _)| *name == "vertex_cycles")
        };
        if source.is_trace() && machines.iter().any(counts) {
            tell(&format!(
                "note: `{scene}` is a trace and has no vertices: each of its fragments counts as a point of three"
            ));
        }
    }

    /// What is given of it, as a shell takes it.
    fn given(&self) -> Vec<String> {
        let given = |name: &str, value: String| format!("{name} {}", quoted(&value));
        let width = self.width.map(|width| given("--width", width.to_string()));
        let height = self.height.map(|height| given("--height", height.to_string()));
        let camera = self.camera.map(|camera| given("--camera", camera.to_string()));
        let instances = self.instances.map(|n| given("--instances", n.to_string()));
        let order = self.order.map(|order| given("--order", order.to_string()));
        let opaque_first = self.opaque_first.then(|| "--opaque-first".to_string());
        let mut words: Vec<String> = [width, height, camera].into_iter().flatten().collect();
        words.extend(self.alpha.iter().map(|alpha| given("--alpha", alpha.to_string())));
        words.extend([instances, order, opaque_first].into_iter().flatten());
        words
    }
}

/// Does what the process's arguments ask for; its exit status.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(mut error) => {
            hint_at_scene(&mut error);
            // Help and version are asked for; anything else is bad usage, which clap words itself.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { BAD_INPUT } else { 0 });
        }
    };
    // Where no handler can be set, a signal ends the process as it does any other.
    let _ = ctrlc::set_handler(stop);
    let done = match cli.command.unwrap_or(Command::Run(Box::new(cli.run))) {
        Command::Run(args) => run::run(&args),
        Command::Compare(args) => compare::compare(&args),
        Command::Explore(args) => explore::explore(&args),
        Command::Explain(args) => explain::explain(&args),
        Command::RunPoint(args) => explore::run_point(&args),
        Command::Size(args) => size::size(&args),
        Command::Export(args) => export::export(&args),
        Command::Area(args) => area::area(&args),
        Command::Reproduce(args) => reproduce::reproduce(&args),
        Command::Trace(args) => trace::trace(&args),
        Command::List(args) => list::list(&args),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(WRONG),
        Err(error) => {
            complain(&error.to_string());
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Adds to an error over a command that there is not, if it looks like a scene, how a scene is given.
fn hint_at_scene(error: &mut clap::Error) {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return;
    };
    if !is_built_in(word) && Path::new(word).extension().is_none() {
        return;
    }
    let tip = format!("a scene is given as '--scene {}'", quoted(word));
    error.remove(ContextKind::SuggestedSubcommand);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
}

/// A side of the screen in pixels.
fn side(text: &str) -> Result<u32, String> {
    let side = text.parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    side.ok_or_else(|| format!("expected a whole number from 1 to {MAX_SIDE}"))
}

/// A number of instances.
fn instances(text: &str) -> Result<u32, String> {
    let instances = text.parse().ok().filter(|n| (1..=MOST_INSTANCES).contains(n));
    instances.ok_or_else(|| format!("expected a whole number from 1 to {MOST_INSTANCES}"))
}

/// What a run gave. A model at fault is told of, with `about` before it, and gives nothing.
fn finished<T>(done: Result<T, BenchError>, about: &str) -> anyhow::Result<Option<T>> {
    match done {
        Ok(done) => Ok(Some(done)),
        Err(BenchError::Source(error)) => Err(error.into()),
        Err(BenchError::Output(error)) => Err(error.into()),
        Err(BenchError::Wave(error)) => Err(error.into()),
        Err(BenchError::Room(error)) => Err(error.into()),
        Err(wrong) => {
            complain(&format!("{about}{wrong}"));
            Ok(None)
        }
    }
}

/// Tells what is wrong with a run, with `about` before each fault; whether it passes.
fn passes(verdict: &Verdict, allow_drops: bool, about: &str) -> bool {
    let passes = verdict.passes(allow_drops);
    for fault in verdict.faults() {
        tell(&format!("{}: {about}{fault}", if passes { "warning" } else { "error" }));
    }
    passes
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:,=".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Ends the process on a signal, whatever it is at.
fn stop() {
    // A progress bar may stand in the line.
    let line = if std::io::stderr().is_terminal() { "\n" } else { "" };
    let kept = leave_behind().into_iter().map(|path| {
        format!("; the waveform is kept as far as it was written: `{}`", path.display())
    });
    tell(&format!(
        "{line}error: stopped by a signal, the files that were not complete are removed{}",
        kept.collect::<String>()
    ));
    abandon(STOPPED)
}

/// Prints to standard output. A reader that has gone away is no error: it has seen enough.
fn say(text: &str) -> Result<(), OutputError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(OutputError::write(Path::new("standard output"), &error))
        }
        _ => Ok(()),
    }
}

/// Prints to standard error what is wrong, as one sentence.
fn complain(text: &str) {
    tell(&format!("error: {text}"));
}

/// Prints a line to standard error, as far as there is one.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
