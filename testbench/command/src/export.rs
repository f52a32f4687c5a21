//! `pellucid export`: an architecture as Verilog, with a testbench that holds it to this simulation.

use super::machine::MachineArgs;
use super::{SceneArgs, ViewArgs, finished, quoted, say};
use clap::Args;
use pellucid_testbench::export::{LIST, TESTBENCH, VECTORS, export as write};
use pellucid_testbench::output::OutputFolder;
use pellucid_testbench::stimulus::Stimulus;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct ExportArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// The folder for the modules, the testbench and the recorded run
    #[arg(long, default_value = "pellucid-rtl", value_name = "DIR")]
    out: PathBuf,
    /// Record half a frame, a reset, the frame and three times less and less of it, with pauses of the
    /// source and stalls of the display, instead of the frame alone
    #[arg(long)]
    stress: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// Exports; whether the run could be recorded to its end.
pub(super) fn export(args: &ExportArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let source = args.scene.open()?;
    let machine = args.machine.build(source.screen(), 1)?;
    args.scene.view.tell_of_order(arch.name, &*machine);
    ViewArgs::tell_of_points(&args.scene.scene, &source, &[&*machine]);
    let _folder = OutputFolder::claim(&args.out)?;
    let stimulus = if args.stress { Stimulus::Stress } else { Stimulus::Plain };
    let done = write(arch.name, &*machine, &source, stimulus, &args.out);
    let Some(done) = finished(done, "")? else { return Ok(false) };
    if !args.quiet {
        let (folder, name) = (args.out.display(), arch.name);
        let cd = quoted(&folder.to_string());
        say(&format!(
            "\
{} files of Verilog in {folder}/, a module each; {name}.v is the machine
{} cycles of scene `{}` recorded in {folder}/{VECTORS}

Compare every output on every cycle with Icarus Verilog:
  (cd {cd} && iverilog -g2005 -o lockstep.vvp -f {LIST} && vvp -N lockstep.vvp)

or with Verilator:
  (cd {cd} && verilator --binary -O3 --top-module {TESTBENCH} -f {LIST} && obj_dir/V{TESTBENCH})
",
            done.modules, done.cycles, args.scene.scene,
        ))?;
    }
    Ok(true)
}
