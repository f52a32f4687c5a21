//! Schedulers from outside run the points of a study: their jobs share a folder.

use super::explore::{STUDY, kept, write};
use super::tools::have;
use super::*;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::{Child, Stdio};
use std::time::Duration;

/// `explore` by workers, in 4 shares.
fn by(folder: &Path, workers: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    command
        .args([
            "explore",
            "study.toml",
            "--points",
            "shared",
            "--workers",
            workers,
            "--shares",
            "4",
        ])
        .current_dir(folder)
        .env("HOME", folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// It ended well; schedulers may have said something beside.
#[track_caller]
fn well(output: Output) -> Output {
    assert!(output.status.success(), "{}", stderr(&output));
    output
}

/// What workers have left is what this process alone leaves.
#[track_caller]
fn as_alone(folder: &Path, text: &str) {
    let of = |out: &str, file| fs::read_to_string(folder.join(out).join(file)).unwrap();
    let [workers, columns] =
        ["points.csv", "columns.json"].map(|file| of("pellucid-explore", file));
    write(folder, text);
    let args = ["explore", "study.toml", "--out", "alone", "--points", "other", "--quiet"];
    exact(pellucid(folder, &args));
    assert_eq!(workers.replace("shared/", "other/"), of("alone", "points.csv"));
    assert_eq!(columns, of("alone", "columns.json"));
    let kept = exact(pellucid(folder, &["explore", "study.toml", "--points", "shared"]));
    assert!(stdout(&kept).contains(" 0 points were run, "), "{}", stdout(&kept));
}

#[test]
fn gnu_parallel_runs_a_study() {
    if !have(&["parallel"]) {
        return;
    }
    let folder = folder();
    // By generations, each of which waits for the one before.
    let text = STUDY
        .replace("[1, 3]", "[1, 2, 3, 4, 5, 8]")
        .replace("[16, 2048]", "{ from = 16, to = 2048, steps = 8, scale = \"log2\" }")
        + "[search]\nmethod = \"genetic\"\ndesigns = 36\nseed = 3\n";
    write(folder.path(), &text);
    let all = well(by(folder.path(), "parallel").output().unwrap());
    assert!(stdout(&all).contains(" points were run, 0 were kept"), "{}", stdout(&all));
    // The log is that of the last generation.
    let jobs = fs::read_to_string(folder.path().join("pellucid-explore/shares/jobs.tsv")).unwrap();
    assert_eq!(jobs.lines().count(), 5, "{jobs}");
    as_alone(folder.path(), &text);
}

/// Ends a process, and all that it has started.
fn kill(mut process: Child) {
    let group = format!("-{}", process.id());
    assert!(Command::new("kill").args(["-KILL", "--", &group]).status().unwrap().success());
    process.wait().unwrap();
}

/// A server and its workers are killed while they are at it, and started again.
#[test]
fn hyperqueue_runs_a_study() {
    let there = Command::new("python3").args(["-c", "import hyperqueue"]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        println!("skipped: python3 with hyperqueue is not installed");
        return;
    }
    let folder = folder();
    write(folder.path(), STUDY);
    let mut first = by(folder.path(), "hyperqueue").process_group(0).spawn().unwrap();
    while kept(&folder.path().join("shared")) == 0 {
        assert!(first.try_wait().unwrap().is_none(), "it ended without a point");
        std::thread::sleep(Duration::from_millis(20));
    }
    kill(first);
    well(by(folder.path(), "hyperqueue").output().unwrap());
    as_alone(folder.path(), STUDY);
}

/// A stand-in for `sbatch` runs the tasks of an array job, all but one; then that one, too.
#[test]
fn an_array_job_runs_a_study() {
    let folder = folder();
    write(folder.path(), STUDY);
    let sbatch = folder.path().join("sbatch");
    let script = r#"#!/bin/sh
echo "$@" >> sbatch.args
for word in "$@"; do
  case "$word" in
    --array=1-*) last=${word#--array=1-} ;;
    --wrap=*) line=${word#--wrap=} ;;
  esac
done
for SLURM_ARRAY_TASK_ID in $(seq "$last"); do
  export SLURM_ARRAY_TASK_ID
  [ "$SLURM_ARRAY_TASK_ID" = "$OUT" ] || sh -c "$line" || exit 1
done
[ -z "$OUT" ]
"#;
    fs::write(&sbatch, script).unwrap();
    fs::set_permissions(&sbatch, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    let run = |out: &str| by(folder.path(), "slurm").env("PATH", &path).env("OUT", out).output();
    let lacking = run("2").unwrap();
    assert_eq!(lacking.status.code(), Some(1));
    let error = stderr(&lacking);
    assert!(error.contains("points were not run") && error.contains("shares"), "{error}");
    exact(run("").unwrap());
    let asked = fs::read_to_string(folder.path().join("sbatch.args")).unwrap();
    assert_eq!(asked.matches("--wait --job-name=pellucid").count(), 2, "{asked}");
    as_alone(folder.path(), STUDY);
}

#[test]
fn workers_that_are_not_there_are_named() {
    let folder = folder();
    write(folder.path(), STUDY);
    let output = by(folder.path(), "slurm").env("PATH", folder.path()).output().unwrap();
    let error = stderr(&output);
    assert!(error.contains("needs the command `sbatch`, which is not installed"), "{error}");
}
