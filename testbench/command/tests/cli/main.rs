//! The command `pellucid` as its users meet it: messages, exit status and files.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

mod accumulate;
mod area;
mod bad_input;
mod check;
mod cluster;
mod compare;
mod composer;
mod energy;
mod explain;
mod explore;
mod explore_page;
mod explore_python;
mod export;
mod frames;
mod page;
mod partial;
mod reproduce;
mod results;
mod size;
#[path = "../tools/mod.rs"]
mod tools;
mod view;
mod wave;

/// A small frame.
const SMALL: [&str; 4] = ["--width", "40", "--height", "30"];

/// Runs `pellucid` in `folder`.
fn pellucid(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pellucid")).args(args).current_dir(folder).output().unwrap()
}

/// `run` on the small frame.
fn run(folder: &Path, args: &[&str]) -> Output {
    pellucid(folder, &[&["run"], &SMALL[..], args].concat())
}

/// What was said on standard error, but for how far a slow machine has come.
fn stderr(output: &Output) -> String {
    let text = std::str::from_utf8(&output.stderr).unwrap();
    text.split_inclusive('\n').filter(|line| !line.starts_with("progress: ")).collect()
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

/// The run is refused with exactly this sentence, and nothing is left.
#[track_caller]
fn refused(folder: &Path, args: &[&str], message: &str) {
    let output = pellucid(folder, args);
    // Where bad usage is found, the parser adds a line that points to the help.
    let text = stderr(&output).replace("\n\nFor more information, try '--help'.", "");
    assert_eq!(text, format!("error: {message}\n"), "{args:?}");
    assert_eq!(output.status.code(), Some(2), "{args:?}");
    assert_eq!(stdout(&output), "", "{args:?}");
}

#[track_caller]
fn exact(output: Output) -> Output {
    assert_eq!(stderr(&output), "");
    assert_eq!(output.status.code(), Some(0));
    output
}

fn stats(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("stats.json")).unwrap()).unwrap()
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// Names of the files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
