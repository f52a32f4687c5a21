//! What tools have found out, kept so that the same is not asked twice: files in the user's folder for such.

use crate::output::{create_dir, put as write};
use pellucid_verilog::File;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::PathBuf;

/// What stands between the two parts of a file.
const BETWEEN: &str = "\n--- timing ---\n";

/// The folder: none where the system names none.
fn folder() -> Option<PathBuf> {
    let named =
        |name: &str| std::env::var_os(name).filter(|path| !path.is_empty()).map(PathBuf::from);
    let caches = named("XDG_CACHE_HOME").or_else(|| Some(named("HOME")?.join(".cache")))?;
    Some(caches.join("pellucid"))
}

/// A number for all that the answer depends on: the tools' versions, and what they are told.
pub(super) fn key(versions: &[&str], files: &[File]) -> u64 {
    let mut hasher = DefaultHasher::new();
    versions.hash(&mut hasher);
    files.iter().for_each(|File { name, text }| (name, text).hash(&mut hasher));
    hasher.finish()
}

fn path(key: u64) -> Option<PathBuf> {
    Some(folder()?.join(format!("area-{key:016x}.txt")))
}

/// The cells and the timing that were kept.
pub(super) fn get(key: u64) -> Option<(String, String)> {
    let text = std::fs::read_to_string(path(key)?).ok()?;
    let (cells, timing) = text.split_once(BETWEEN)?;
    Some((cells.to_string(), timing.to_string()))
}

/// Keeps them. Where that is not possible it costs time when they are asked for again, and nothing else.
pub(super) fn put(key: u64, cells: &str, timing: &str) {
    if let (Some(folder), Some(path)) = (folder(), path(key)) {
        let _ =
            create_dir(&folder).and_then(|()| write(&path, &format!("{cells}{BETWEEN}{timing}")));
    }
}
