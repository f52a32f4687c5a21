//! The command line: what is asked, and the exit status.
//!
//! 0: done and exact. 1: the run's result is wrong or lossy. 2: bad input or usage.

mod list;
mod run;
mod trace;

use crate::scene::{AlphaRule, Camera, Options};
use crate::source::{Source, SourceError};
use clap::{Args, Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// The result is wrong or lossy.
const WRONG: u8 = 1;
/// Bad input or usage.
const BAD_INPUT: u8 = 2;

/// Clocked hardware models for order-independent transparency.
///
/// Without a command: runs the default scene through the default architecture.
#[derive(Parser)]
#[command(name = "pellucid", version, arg_required_else_help = false)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Sends one frame through one architecture; leaves image, figures and waveform
    Run(Box<run::RunArgs>),
    /// Writes a scene's fragments to a trace file
    Trace(trace::TraceArgs),
    /// Lists architectures with their parameters, and scenes
    List(list::ListArgs),
}

/// Which frame, and how it is seen.
#[derive(Args)]
struct SceneArgs {
    /// A built-in scene (see `pellucid list`), a mesh (.obj, .ply, .ply.gz, .gltf, .glb) or a trace
    /// (.csv, .ptrace)
    #[arg(long, default_value = "glass", value_name = "NAME|FILE")]
    scene: String,
    /// Columns of the screen, 1 to 8192 [default: 640]
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true)]
    width: Option<u32>,
    /// Rows of the screen, 1 to 8192 [default: 480]
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true)]
    height: Option<u32>,
    /// Eye, point looked at and vertical field of view in degrees: EX,EY,EZ:TX,TY,TZ[:FOV]
    /// [default: fits the mesh]
    #[arg(long, value_name = "EYE:TARGET[:FOV]", allow_hyphen_values = true)]
    camera: Option<Camera>,
    /// Opacity 0 to 1 of all meshes, or of the one of that name; may be given several times
    #[arg(long, value_name = "[NAME=]ALPHA")]
    alpha: Vec<AlphaRule>,
}

impl SceneArgs {
    fn open(&self) -> Result<Source, SourceError> {
        let options = Options {
            width: self.width,
            height: self.height,
            camera: self.camera,
            alphas: self.alpha.clone(),
        };
        Source::open(&self.scene, &options)
    }
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are asked for; anything else is bad usage, which clap words itself.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { BAD_INPUT } else { 0 });
        }
    };
    let done = match cli.command.unwrap_or_else(run::default) {
        Command::Run(args) => run::run(&args),
        Command::Trace(args) => trace::trace(&args),
        Command::List(args) => list::list(&args),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(WRONG),
        Err(error) => {
            complain(&format!("{error:#}"));
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Prints to standard output. A reader that has gone away is no error: it has seen enough.
fn say(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}

/// Prints one sentence to standard error.
fn complain(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "error: {text}");
}
