//! What is left of a run that cannot be finished, and of one that is kept out.

use super::wave::Wave;
use super::*;

/// What is beside a waveform that is not complete, and itself.
fn beside(partial: &str) -> [&str; 5] {
    [".surfer", partial, "wave.partial.gtkw", "wave.partial.states", "wave.partial.sucl"]
}

fn sorted(names: &[&str]) -> Vec<String> {
    let mut names: Vec<String> = names.iter().map(ToString::to_string).collect();
    names.sort();
    names
}

/// A disk that is full, or a limit on a file's size: what was written can be opened, and the run goes on without.
#[cfg(target_os = "linux")]
#[test]
fn a_waveform_that_does_not_fit_is_kept_as_far_as_it_goes() {
    for (format, blocks) in [("vcd", "2000"), ("fst", "300")] {
        let folder = folder();
        let command = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec '{}' run --width 160 --height 120 --wave all --quiet \
             --wave-format {format}",
            env!("CARGO_BIN_EXE_pellucid")
        );
        let output =
            Command::new("sh").args(["-c", &command]).current_dir(folder.path()).output().unwrap();
        let out = Path::new("pellucid-out");
        let (path, partial) = (format!("wave.{format}"), format!("wave.partial.{format}"));
        assert_eq!(
            stderr(&output),
            format!(
                "error: cannot write `{}`: File too large; what was written until then is `{}`\n",
                out.join(path).display(),
                out.join(&partial).display()
            )
        );
        assert_eq!(output.status.code(), Some(2));
        let out = folder.path().join(out);
        let results = ["image.png", "stats.csv", "stats.json"];
        assert_eq!(names(&out), sorted(&[&results[..], &beside(&partial)].concat()));
        assert_eq!(stats(&out)["image"]["mismatched_pixels"], 0);
        let save = fs::read_to_string(out.join("wave.partial.gtkw")).unwrap();
        assert!(save.starts_with(&format!("[dumpfile] \"{partial}\"\n")), "{save}");
        let wave = Wave::read(&out.join(partial));
        let cycles = wave.cycles();
        assert!(cycles.len() > 500, "{} cycles", cycles.len());
        assert_eq!(cycles, (0..cycles.len() as u64).collect::<Vec<_>>());
    }
}

/// A process that is killed leaves what it wrote; one that is told to stop says where.
#[cfg(unix)]
#[test]
fn a_waveform_of_a_run_that_is_stopped_can_be_opened() {
    use std::process::Stdio;
    for (format, signal) in [("vcd", "-TERM"), ("vcd", "-KILL"), ("fst", "-TERM"), ("fst", "-KILL")]
    {
        let folder = folder();
        let args = ["run", "--scene", "smoke", "--wave", "all", "--wave-format", format];
        let child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(args)
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let partial = folder.path().join("pellucid-out").join(format!("wave.partial.{format}"));
        // Several flushes of either format.
        while fs::metadata(&partial).map_or(0, |found| found.len()) < 2_000_000 {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        let output = child.wait_with_output().unwrap();
        if signal == "-TERM" {
            let said = format!(
                "error: stopped by a signal, the files that were not complete are removed; the waveform is kept \
                 as far as it was written: `pellucid-out/wave.partial.{format}`\n"
            );
            assert_eq!(stderr(&output), said);
            assert_eq!(output.status.code(), Some(130));
        }
        let (out, name) = (folder.path().join("pellucid-out"), format!("wave.partial.{format}"));
        if signal == "-TERM" {
            assert_eq!(names(&out), sorted(&beside(&name)));
            let save = fs::read_to_string(out.join("wave.partial.gtkw")).unwrap();
            assert!(save.starts_with(&format!("[dumpfile] \"{name}\"\n")), "{save}");
            assert!(save.contains("[timestart] 0\n"), "{save}");
        } else {
            assert_eq!(names(&out), [name]);
        }
        let cycles = Wave::read(&partial).cycles();
        assert!(cycles.len() > 500, "{} cycles", cycles.len());
        assert_eq!(cycles, (0..cycles.len() as u64).collect::<Vec<_>>());
    }
}

/// What is written into a folder is of one run: the others are refused, and write again once that is over, however it
/// ends.
#[cfg(unix)]
#[test]
fn a_folder_that_is_written_into_is_refused() {
    let folder = folder();
    let mut child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["run", "--scene", "smoke", "--wave", "all", "--out", "out", "-q"])
        .current_dir(folder.path())
        .spawn()
        .unwrap();
    let out = folder.path().join("out");
    while !out.join("wave.partial.vcd").exists() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    for command in ["run", "compare", "export"] {
        refused(
            folder.path(),
            &[command, "--width", "4", "--height", "4", "--out", "./out/", "-q"],
            "cannot use `./out/` as output folder: another run is writing into it",
        );
    }
    assert_eq!(names(&out), ["wave.partial.vcd"]);
    child.kill().unwrap();
    child.wait().unwrap();
    exact(run(folder.path(), &["--out", "out", "-q"]));
    assert!(!out.join("wave.partial.vcd").exists(), "it was replaced");
}
