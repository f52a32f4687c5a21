//! GTKWave takes the waveform: its converters from one format to the other keep every value, and GTKWave
//! itself shows what the save file says.

mod tools;

use pellucid_hw::ARCHITECTURES;
use std::path::Path;
use std::process::Command;
use wellen::SignalValueRef;

/// Every signal's full name with all its changes.
fn changes(path: &Path) -> Vec<(String, Vec<(u64, String)>)> {
    let mut wave = wellen::simple::read(path).unwrap();
    let hierarchy = wave.hierarchy();
    let vars = hierarchy.all_vars().map(|v| &hierarchy[v]);
    let named: Vec<_> = vars.map(|v| (v.full_name(hierarchy), v.signal_ref())).collect();
    wave.load_signals(&named.iter().map(|(_, signal)| *signal).collect::<Vec<_>>());
    let times = wave.time_table().to_vec();
    let mut all: Vec<_> = named
        .into_iter()
        .map(|(name, signal)| {
            let changes = wave.get_signal(signal).unwrap().iter_changes();
            let text = |value: SignalValueRef| match value {
                SignalValueRef::String(text) => text.to_string(),
                value => value.to_bit_string().unwrap(),
            };
            (name, changes.map(|(at, value)| (times[at as usize], text(value))).collect())
        })
        .collect();
    all.sort();
    all
}

#[test]
fn converters_keep_every_value() {
    // They come with GTKWave.
    if !tools::have(&["vcd2fst", "fst2vcd"]) {
        return;
    }
    for (format, there, back) in [("vcd", "vcd2fst", "fst2vcd"), ("fst", "fst2vcd", "vcd2fst")] {
        let folder = tempfile::tempdir().unwrap();
        let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(["run", "--scene", "glass", "--width", "40", "--height", "30", "--quiet"])
            .args(["--wave", "0..300,400..500", "--wave-format", format, "--out"])
            .arg(folder.path())
            .status()
            .unwrap();
        assert!(run.success());
        let wave = folder.path().join("wave").with_extension(format);
        let other = folder.path().join("there").with_extension(&there[4..]);
        let again = folder.path().join("back").with_extension(format);
        for (tool, from, to) in [(there, &wave, &other), (back, &other, &again)] {
            let mut command = Command::new(tool);
            let converted = if tool == "vcd2fst" {
                command.arg(from).arg(to).output().unwrap()
            } else {
                command.arg("-f").arg(from).arg("-o").arg(to).output().unwrap()
            };
            let said = String::from_utf8_lossy(&converted.stderr);
            assert!(converted.status.success(), "{tool}: {said}");
        }
        let whole = changes(&wave);
        assert!(whole.len() > 100, "only {} signals", whole.len());
        assert_eq!(whole, changes(&other), "{there}");
        assert_eq!(whole, changes(&again), "{back}");
    }
}

/// The signals that a save file names, in their order.
fn intended(save: &str) -> Vec<String> {
    // Labels have another name before their path.
    let path = |line: &str| match line.split_once("} ") {
        Some((alias, path)) if alias.starts_with("+{") => path.to_string(),
        _ => line.to_string(),
    };
    save.lines().map(path).filter(|line| line.starts_with("top.")).collect()
}

/// What GTKWave shows is what the save file names: it drops a signal that it does not know without a word.
#[test]
fn gtkwave_shows_what_is_intended_of_every_architecture() {
    if !tools::have(&["gtkwave", "xvfb-run"]) {
        return;
    }
    for arch in ARCHITECTURES {
        for (k, (preset, _)) in (arch.presets)().into_iter().enumerate() {
            let format = ["vcd", "fst"][k % 2];
            let folder = tempfile::tempdir().unwrap();
            let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
                .args(["run", "--scene", "glass", "--width", "40", "--height", "30", "--quiet"])
                .args(["--arch", arch.name, "--preset", preset, "--wave", "0..300", "--out", "a"])
                .args(["--wave-format", format])
                .current_dir(folder.path())
                .status()
                .unwrap();
            assert!(run.success());
            // All paths are relative: the files work from another place.
            std::fs::rename(folder.path().join("a"), folder.path().join("b")).unwrap();
            let script = "set f [open shown.txt w]\n\
                          foreach s [gtkwave::getDisplayedSignals] { puts $f $s }\n\
                          close $f\ngtkwave::/File/Quit\n";
            std::fs::write(folder.path().join("shown.tcl"), script).unwrap();
            let shown = Command::new("xvfb-run")
                .args(["-a", "gtkwave", "b/wave.gtkw", "-S", "shown.tcl"])
                .current_dir(folder.path())
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&shown.stderr);
            let list = std::fs::read_to_string(folder.path().join("shown.txt"));
            let list = list.unwrap_or_else(|e| panic!("{e}: {said}"));
            let shown: Vec<&str> = list.lines().filter(|l| l.starts_with("top.")).collect();
            let save = std::fs::read_to_string(folder.path().join("b/wave.gtkw")).unwrap();
            let intended = intended(&save);
            assert!(intended.len() > 100, "only {} signals", intended.len());
            assert_eq!(shown, intended, "{} {preset}: {said}", arch.name);
        }
    }
}
