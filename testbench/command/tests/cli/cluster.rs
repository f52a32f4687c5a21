//! Schedulers from outside run the points of a study: their jobs share a folder.

use super::explore::{STUDY, write};
use super::tools::have;
use super::*;
use std::process::Stdio;
use std::time::Duration;

/// Every point of the study is in the folder `shared`.
#[track_caller]
fn all_are_kept(folder: &Path) {
    let args = ["explore", "study.toml", "--points", "shared"];
    let all = exact(pellucid(folder, &args));
    assert!(stdout(&all).contains(" 0 points were run, "), "{}", stdout(&all));
}

#[test]
fn gnu_parallel_runs_a_study() {
    if !have(&["parallel"]) {
        return;
    }
    let folder = folder();
    write(folder.path(), STUDY);
    let output = Command::new("parallel")
        .args(["--will-cite", "--joblog", "jobs", env!("CARGO_BIN_EXE_pellucid"), "run-point"])
        .args(["study.toml", "--points", "shared", "--share", "{}/4", ":::", "1", "2", "3", "4"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let jobs = fs::read_to_string(folder.path().join("jobs")).unwrap();
    assert_eq!(jobs.lines().count(), 5, "{jobs}");
    all_are_kept(folder.path());
}

/// How many points are kept.
fn kept(folder: &Path) -> usize {
    let Ok(programs) = fs::read_dir(folder.join("shared")) else { return 0 };
    let files = programs.filter_map(|folder| fs::read_dir(folder.unwrap().path()).ok()).flatten();
    files
        .filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|e| e == "json"))
        .count()
}

/// A server and two workers are killed while they are at it, and started again.
#[test]
fn hyperqueue_runs_a_study() {
    let there = Command::new("python3").args(["-c", "import hyperqueue"]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        println!("skipped: python3 with hyperqueue is not installed");
        return;
    }
    let folder = folder();
    write(folder.path(), STUDY);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/studies/by_hyperqueue.py");
    let start = || {
        Command::new("python3")
            .arg(&script)
            .args(["study.toml", "shared", "--workers", "2", "--shares", "8"])
            .args(["--pellucid", env!("CARGO_BIN_EXE_pellucid")])
            .current_dir(folder.path())
            .env("HOME", folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let mut first = start();
    while kept(folder.path()) == 0 {
        assert!(first.try_wait().unwrap().is_none(), "it ended without a point");
        std::thread::sleep(Duration::from_millis(20));
    }
    first.kill().unwrap();
    first.wait().unwrap();
    let output = start().wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    all_are_kept(folder.path());
}
