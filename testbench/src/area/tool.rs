//! Tools from outside.

use super::AreaError;
use crate::output::scratch::Scratch;
use crate::output::{OutputError, put, reason};
use crate::progress::waiting;
use pellucid_verilog::File;
use std::fs;
use std::process::{Command, Stdio};

/// A tool that is here.
pub(super) struct Tool {
    pub name: &'static str,
    /// What it says of its version.
    pub version: String,
}

/// The first of these that is here, asked for its version by `ask`.
pub(super) fn find(names: &[&'static str], ask: &str) -> Option<Tool> {
    names.iter().find_map(|&name| {
        let output = Command::new(name).arg(ask).stdin(Stdio::null()).output().ok()?;
        let version = String::from_utf8_lossy(&output.stdout).trim().to_string();
        Some(Tool { name, version })
    })
}

/// A folder with the files, for tools to work in.
pub(super) fn folder(files: &[File]) -> Result<Scratch, OutputError> {
    let scratch = Scratch::new()?;
    for File { name, text } in files {
        put(&scratch.path().join(name), text)?;
    }
    Ok(scratch)
}

impl Tool {
    pub fn failed(&self, said: String) -> AreaError {
        AreaError::Failed { tool: self.name, said }
    }

    /// Runs it in the folder, `doing` something; what it says goes to the file `log`.
    pub fn run(
        &self,
        scratch: &Scratch,
        (arguments, log): (&[&str], &str),
        doing: &str,
        quiet: bool,
    ) -> Result<(), AreaError> {
        let path = scratch.path().join(log);
        let log = || fs::File::options().create(true).append(true).open(&path);
        let both = log().and_then(|out| Ok((out, log()?)));
        let (out, err) = both.map_err(|e| OutputError::write(&path, &e))?;
        let spinner = waiting(format!("{} {doing}", self.name), quiet);
        let mut command = Command::new(self.name);
        command.args(arguments).stdin(Stdio::null()).stdout(out).stderr(err);
        let status = scratch.run(&mut command).map_err(|e| self.failed(reason(&e)))?;
        spinner.finish_and_clear();
        if !status.success() {
            let said = fs::read_to_string(&path).unwrap_or_default();
            let last = said.lines().rfind(|line| !line.trim().is_empty());
            return Err(self.failed(last.map_or_else(|| status.to_string(), String::from)));
        }
        Ok(())
    }

    /// What it has left in a file.
    pub fn left(&self, scratch: &Scratch, name: &str) -> Result<String, AreaError> {
        let path = scratch.path().join(name);
        fs::read_to_string(path)
            .map_err(|e| self.failed(format!("it left no {name}: {}", reason(&e))))
    }
}
