//! A folder for a tool from outside, and the tool at work in it.

use super::{Listed, OutputError, unfinished};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tempfile::TempDir;

/// How often a tool is asked whether it is done.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// The tools that are at work now.
static AT_WORK: Mutex<Vec<Child>> = Mutex::new(Vec::new());

fn at_work() -> MutexGuard<'static, Vec<Child>> {
    AT_WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the tools that are at work.
pub(super) fn stop() {
    for tool in at_work().iter_mut() {
        let _ = tool.kill();
        // It must not write into its folder any more when that is removed.
        let _ = tool.wait();
    }
}

/// A folder that is gone when this is dropped.
pub struct Scratch {
    // Declared first: the folder is on the list for as long as it is there.
    folder: TempDir,
    _listed: Listed,
}

impl Scratch {
    /// Makes it where the system has its temporary files.
    ///
    /// # Errors
    /// There is no room for it.
    pub fn new() -> Result<Scratch, OutputError> {
        let mut unfinished = unfinished();
        let folder = tempfile::Builder::new().prefix("pellucid-").tempdir();
        let folder = folder.map_err(|e| OutputError::folder(&std::env::temp_dir(), &e))?;
        unfinished.push(folder.path().to_path_buf());
        let listed = Listed(folder.path().to_path_buf());
        Ok(Scratch { folder, _listed: listed })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Runs `tool` in the folder to its end.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn run(&self, tool: &mut Command) -> io::Result<ExitStatus> {
        let mut tools = at_work();
        let child = tool.current_dir(self.path()).spawn()?;
        let id = child.id();
        tools.push(child);
        drop(tools);
        loop {
            let mut tools = at_work();
            // Once it is waited for, its number may be that of another.
            if let Some(k) = tools.iter().position(|tool| tool.id() == id)
                && tools[k].try_wait()?.is_some()
            {
                return tools.remove(k).wait();
            }
            drop(tools);
            std::thread::sleep(LOOK_EVERY);
        }
    }
}
