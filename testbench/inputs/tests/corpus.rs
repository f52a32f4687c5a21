//! Every file of the fuzz targets' corpus passes its target's check.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Hands every file of a target's corpus to its check and names the ones that do not pass.
#[track_caller]
fn all_pass(target: &str, check: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let mut files = 0;
    let mut broken = vec![];
    for entry in fs::read_dir(&folder).expect("a folder for each target") {
        let path = entry.unwrap().path();
        let bytes = fs::read(&path).unwrap();
        files += 1;
        if catch_unwind(AssertUnwindSafe(|| check(&bytes))).is_err() {
            broken.push(path);
        }
    }
    assert!(files > 0, "no file in {}", folder.display());
    assert!(broken.is_empty(), "these do not pass: {broken:?}");
}

#[test]
fn traces() {
    all_pass("trace", pellucid_inputs::trace::check);
}

#[test]
fn meshes() {
    all_pass("mesh", pellucid_inputs::mesh::check);
}

#[test]
fn settings() {
    all_pass("settings", pellucid_inputs::settings::check);
}
