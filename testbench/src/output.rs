//! Output files that are either complete or not there.
//!
//! A long run that is killed, or that fills the disk, must not leave half an image that looks like a
//! result. So every output is written under a temporary name in the folder of its target, which is on
//! the same file system, and renamed when it is complete: a rename within a file system is atomic. A
//! target that is already there keeps its old content until then.
//!
//! A signal ends a process without dropping anything: its handler calls [`abandon`], which removes the
//! temporary files first. Waveforms alone are of use as far as they are written: see [`mod@partial`].
//!
//! Files that belong together must be of one run: an [`OutputFolder`] is of one process at a time.
//!
//! A target that exists and is no regular file (`/dev/null`, a pipe) is written directly: there is
//! nothing to keep whole, and replacing a device by a file would do harm.

use std::error::Error;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

/// An output file or folder that could not be made: its final path and the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutputError {
    /// A file could not be created, written or renamed.
    #[error("cannot write `{}`: {reason}", path.display())]
    Write {
        /// The final path, not the temporary one.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// A file that is of use as far as it is written could not be written to its end.
    #[error(
        "cannot write `{}`: {reason}; what was written until then is `{}`",
        path.display(),
        partial.display()
    )]
    Partial {
        /// The final path.
        path: PathBuf,
        /// What the system said.
        reason: String,
        /// Where it is as far as it goes.
        partial: PathBuf,
    },
    /// A folder could not be made or cannot be used.
    #[error("cannot use `{}` as output folder: {reason}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

impl OutputError {
    /// The error of writing `path`, whose final name the user knows.
    pub fn write(path: &Path, error: &io::Error) -> OutputError {
        OutputError::Write { path: path.to_owned(), reason: reason(error) }
    }

    fn folder(path: &Path, error: &io::Error) -> OutputError {
        OutputError::Folder { path: path.to_owned(), reason: reason(error) }
    }
}

/// What went wrong as a user reads it: the innermost cause (a temporary file's error wraps the cause in
/// the temporary name, which means nothing to a user), without the system's error number.
pub fn reason(error: &io::Error) -> String {
    let mut cause: &dyn Error = error;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    let text = cause.to_string();
    match text.find(" (os error ") {
        Some(end) => text[..end].to_owned(),
        None => text,
    }
}

/// A buffered file that takes its name only when [`AtomicFile::finish`] succeeds.
///
/// Dropped unfinished, it leaves nothing behind. [`Write`] hands on the system's bare errors;
/// [`OutputError::write`] puts the path to them.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    file: BufWriter<File>,
    // Declared after `file`, so that the file is closed before its name is removed.
    rename: Option<Rename>,
}

#[derive(Debug)]
struct Rename {
    from: TempPath,
    to: PathBuf,
    // Declared last: the file is on the list for as long as it has its temporary name.
    listed: Listed,
}

/// The temporary files and folders that there are now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An entry of [`UNFINISHED`], taken off it when dropped.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// Removes all temporary files and folders and ends the process with `status`, while other threads may
/// write; a tool that is at work is ended.
pub fn abandon(status: i32) -> ! {
    // Held to the end, so that no further file is begun.
    let unfinished = unfinished();
    scratch::stop();
    for path in unfinished.iter() {
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    std::process::exit(status)
}

impl AtomicFile {
    /// Starts the file that will be `path`. A symbolic link is followed: what it points to is replaced.
    ///
    /// # Errors
    /// The folder is missing or not writable, or `path` is a folder.
    pub fn create(path: &Path) -> Result<AtomicFile, OutputError> {
        let (file, rename) = open(path).map_err(|error| OutputError::write(path, &error))?;
        Ok(AtomicFile {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 16, file),
            rename,
        })
    }

    /// The final path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes what is buffered and gives the file its name.
    ///
    /// # Errors
    /// The disk is full, or the target cannot be replaced. Nothing is left behind then.
    pub fn finish(self) -> Result<(), OutputError> {
        let AtomicFile { path, file, rename } = self;
        let done = file.into_inner().map_err(io::IntoInnerError::into_error).and_then(|file| {
            drop(file);
            match rename {
                Some(Rename { from, to, listed }) => {
                    let renamed = from.persist(to).map_err(|error| error.error);
                    drop(listed);
                    renamed
                }
                None => Ok(()),
            }
        });
        done.map_err(|error| OutputError::write(&path, &error))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The file that an output replaces, where a symbolic link is followed; nothing for a device or a pipe, which is
/// written directly.
fn target(path: &Path) -> io::Result<Option<PathBuf>> {
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => Ok(None),
        Ok(_) if path.is_symlink() => fs::canonicalize(path).map(Some),
        _ => Ok(Some(path.to_owned())),
    }
}

/// Opens what is written to, and says what is renamed at the end.
fn open(path: &Path) -> io::Result<(File, Option<Rename>)> {
    let Some(to) = target(path)? else {
        return Ok((OpenOptions::new().write(true).open(path)?, None));
    };
    let mut unfinished = unfinished();
    let (file, from) = temporary(&to)?.into_parts();
    unfinished.push(from.to_path_buf());
    let listed = Listed(from.to_path_buf());
    Ok((file, Some(Rename { from, to, listed })))
}

/// A temporary file beside `target`, hidden, with the permissions of any file that a user creates.
fn temporary(target: &Path) -> io::Result<NamedTempFile> {
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pellucid-").suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The umask applies on top, as it does to every new file.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Writes a file.
///
/// # Errors
/// It cannot be written.
pub fn put(path: &Path, content: &(impl AsRef<[u8]> + ?Sized)) -> Result<(), OutputError> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(content.as_ref()).map_err(|e| OutputError::write(path, &e))?;
    file.finish()
}

/// Makes an output folder and the folders above it, and checks that a file can be made in it.
///
/// # Errors
/// `path` is a file, or the folder cannot be made or written to.
pub fn create_dir(path: &Path) -> Result<(), OutputError> {
    if path.exists() && !path.is_dir() {
        return Err(OutputError::folder(path, &io::Error::other("it is a file, not a folder")));
    }
    fs::create_dir_all(path)
        .and_then(|()| tempfile::tempfile_in(path))
        .map_err(|error| OutputError::folder(path, &error))?;
    Ok(())
}

/// An output folder that no other process uses as one meanwhile: so what is in it is of one run.
#[derive(Debug)]
pub struct OutputFolder {
    /// Locked as long as it is open. The system ends that with the process, however it ends.
    _held: Option<File>,
}

impl OutputFolder {
    /// Makes the folder as [`create_dir`] does, and keeps other processes out. A file system without locks keeps
    /// nobody out.
    ///
    /// # Errors
    /// Those of [`create_dir`], or another process has it.
    pub fn claim(path: &Path) -> Result<OutputFolder, OutputError> {
        create_dir(path)?;
        let held = File::open(path).ok();
        match held.as_ref().map(File::try_lock) {
            Some(Err(TryLockError::WouldBlock)) => {
                let taken = io::Error::other("another run is writing into it");
                Err(OutputError::folder(path, &taken))
            }
            _ => Ok(OutputFolder { _held: held }),
        }
    }
}

pub mod partial;
pub mod scratch;

#[cfg(test)]
mod tests;
