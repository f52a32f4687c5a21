//! A file that is of use as far as it is written: a waveform.
//!
//! Until it is complete it has a name of its own, `wave.partial.vcd` for `wave.vcd`: what stands under the
//! final name is whole. A full disk or a signal leaves it there, cut at the last flush after which it can be
//! opened, with what belongs beside it; only a frame that cannot be read removes it.

use super::{OutputError, reason, target};
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A file that is being written.
struct Growing {
    partial: PathBuf,
    /// Writes what belongs beside it, told where it is.
    beside: Box<dyn Fn(&Path) + Send>,
}

/// The files that are being written.
static GROWING: Mutex<Vec<Growing>> = Mutex::new(Vec::new());

fn growing() -> MutexGuard<'static, Vec<Growing>> {
    GROWING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The files that are left as the process ends now. What belongs beside them is written.
pub fn leave_behind() -> Vec<PathBuf> {
    let left = growing();
    left.iter().for_each(|Growing { partial, beside }| beside(partial));
    left.iter().map(|growing| growing.partial.clone()).collect()
}

/// Where a file of that path grows.
fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(".partial");
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// What the file's writer writes to. It is not buffered.
#[derive(Debug)]
pub struct PartialFile {
    file: File,
    /// How long it was at the last flush.
    flushed: u64,
}

/// The file's name, which its writer does not know.
#[derive(Debug)]
pub struct PartialName {
    path: PathBuf,
    /// Nothing if it is written in its place.
    grows: Option<Grows>,
}

/// A file that grows in another place.
#[derive(Debug)]
struct Grows {
    partial: PathBuf,
    /// What it becomes.
    to: PathBuf,
}

/// Starts the file that will be `path`.
///
/// # Errors
/// The folder is missing or not writable, or `path` is a folder.
pub fn create(path: &Path) -> Result<(PartialFile, PartialName), OutputError> {
    let begun = target(path).and_then(|to| {
        let grows = to.map(|to| Grows { partial: partial(&to), to });
        let file = File::create(grows.as_ref().map_or(path, |grows| &grows.partial))?;
        Ok((file, grows))
    });
    let (file, grows) = begun.map_err(|error| OutputError::write(path, &error))?;
    growing().extend(grows.as_ref().map(|Grows { partial, .. }| {
        let beside = |_: &Path| ();
        Growing { partial: partial.clone(), beside: Box::new(beside) }
    }));
    Ok((PartialFile { file, flushed: 0 }, PartialName { path: path.to_owned(), grows }))
}

impl PartialName {
    /// What is to be written beside the file if it stays as it is: `beside` is told where the file is.
    pub fn set_beside(&self, beside: impl Fn(&Path) + Send + 'static) {
        if let Some(growing) = growing().iter_mut().find(|growing| self.is(growing)) {
            growing.beside = Box::new(beside);
        }
    }

    /// Where the file is until then; nothing if it is written in its place.
    pub fn partial(&self) -> Option<&Path> {
        self.grows.as_ref().map(|grows| &*grows.partial)
    }

    /// The file is complete: it takes its name. Its writer must have been dropped.
    ///
    /// # Errors
    /// The target cannot be replaced.
    pub fn finish(self) -> Result<(), OutputError> {
        match &self.grows {
            None => Ok(()),
            Some(Grows { partial, to }) => {
                // A signal finds it under one name or the other.
                let mut growing = growing();
                growing.retain(|growing| !self.is(growing));
                fs::rename(partial, to).map_err(|e| OutputError::write(&self.path, &e))
            }
        }
    }

    fn is(&self, growing: &Growing) -> bool {
        self.grows.as_ref().is_some_and(|grows| grows.partial == growing.partial)
    }

    /// The file is of no use: it is removed.
    pub fn discard(self) {
        if let Some(Grows { partial, .. }) = &self.grows {
            let _ = fs::remove_file(partial);
        }
    }

    /// The error of writing it, which tells where what was written is. What belongs beside that is written; its writer
    /// must have been dropped.
    pub fn leave(self, error: &io::Error) -> OutputError {
        match &self.grows {
            None => OutputError::write(&self.path, error),
            Some(Grows { partial, .. }) => {
                let growing = growing();
                if let Some(growing) = growing.iter().find(|growing| self.is(growing)) {
                    (growing.beside)(partial);
                }
                drop(growing);
                OutputError::Partial {
                    path: self.path.clone(),
                    reason: reason(error),
                    partial: partial.clone(),
                }
            }
        }
    }
}

impl Drop for PartialName {
    fn drop(&mut self) {
        growing().retain(|growing| !self.is(growing));
    }
}

impl Write for PartialFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()?;
        // A device has no length.
        self.flushed = self.file.metadata()?.len();
        Ok(())
    }
}

impl Seek for PartialFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        // What came after the last flush is not whole.
        if self.file.metadata().is_ok_and(|found| found.is_file() && found.len() > self.flushed) {
            let _ = self.file.set_len(self.flushed);
        }
    }
}
