//! Who runs the points of a study, if it is not this process: a scheduler that is installed beside, and that runs each share by
//! `pellucid run-point`.

use super::super::quoted;
use anyhow::{Context, bail};
use clap::ValueEnum;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// HyperQueue's Python wheel has no command of its own.
const BY_HYPERQUEUE: &str = include_str!("by_hyperqueue.py");

/// See the module's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Workers {
    /// GNU parallel: on this computer's cores, or where the options in `PARALLEL` say
    Parallel,
    /// HyperQueue, by its Python wheel: on the server of `HQ_SERVER_DIR`, or on this computer's cores
    Hyperqueue,
    /// Slurm: an array job of `sbatch`, whose options are in its variables, as `SBATCH_PARTITION`
    Slurm,
}

impl Workers {
    /// Starts them on all shares of a study.
    ///
    /// What they say of shares that fail is left in the folder `log`.
    ///
    /// # Errors
    /// The scheduler cannot be started.
    pub fn start(
        self,
        study: &Path,
        points: &Path,
        shares: usize,
        log: &Path,
    ) -> anyhow::Result<Child> {
        let program = std::env::current_exe().context("the running program has no path")?;
        let [program, study, points] =
            [&*program, study, points].map(|path| path.display().to_string());
        let one = [&program, "run-point", &study, "--points", &points, "--quiet", "--share"];
        let mut command = match self {
            Workers::Parallel => {
                let mut command = Command::new("parallel");
                command.args(["--will-cite", "--quote", "--joblog"]).arg(log.join("jobs.tsv"));
                command.args(one).arg(format!("{{}}/{shares}")).arg(":::");
                command.args((1..=shares).map(|number| number.to_string()));
                command
            }
            Workers::Hyperqueue => {
                let mut command = Command::new("python3");
                // It would show a bar of its own.
                command.env("TQDM_DISABLE", "1");
                command.args(["-c", BY_HYPERQUEUE]).arg(log).arg(shares.to_string());
                command.args(one).arg(format!("{{}}/{shares}"));
                command
            }
            Workers::Slurm => {
                let mut command = Command::new("sbatch");
                command.args(["--wait", "--job-name=pellucid", "--output=/dev/null"]);
                command.arg(format!("--array=1-{shares}"));
                command.arg(format!("--error={}", log.join("%a.stderr").display()));
                let one = one.map(quoted).join(" ");
                command.arg(format!("--wrap=exec {one} \"$SLURM_ARRAY_TASK_ID/{shares}\""));
                command
            }
        };
        // Standard output is for results.
        let command = command.stdin(Stdio::null()).stdout(Stdio::null());
        match command.spawn() {
            Ok(child) => Ok(child),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let what = self.to_possible_value();
                let what = what.as_ref().map_or("", clap::builder::PossibleValue::get_name);
                let program = command.get_program().display();
                bail!("`--workers {what}` needs the command `{program}`, which is not installed")
            }
            Err(error) => {
                let program = command.get_program().display().to_string();
                Err(error).with_context(|| format!("cannot run `{program}`"))
            }
        }
    }
}
