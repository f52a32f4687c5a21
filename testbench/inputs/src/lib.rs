//! What must hold of any input from outside, whatever its bytes: it is read as it stands, or refused with its place.
//!
//! Each module has a `check` that takes any bytes and panics where they break a rule. Two things call them: the fuzz
//! targets in `fuzz/`, with bytes that they make up, and the test of this crate, with every file of `fuzz/corpus/`.

pub mod mesh;
pub mod settings;
pub mod trace;

use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

thread_local! {
    /// A folder of this thread's own.
    static FOLDER: TempDir = tempfile::tempdir().expect("a temporary folder");
}

/// The path of a file of that name in the thread's folder.
fn path(name: &str) -> PathBuf {
    FOLDER.with(|folder| folder.path().join(name))
}

/// Writes a file into the thread's folder.
fn write(name: &str, bytes: &[u8]) -> PathBuf {
    let path = path(name);
    fs::write(&path, bytes).expect("a temporary file");
    path
}

/// How many lines a text has; an unfinished last one counts, and so does the end of an empty text.
fn lines(bytes: &[u8]) -> usize {
    bytes.split(|&byte| byte == b'\n').count()
}
