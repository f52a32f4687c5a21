//! GTKWave takes the waveform: `vcd2fst` converts it and every value survives, and GTKWave itself shows
//! what the save file says.

mod tools;

use pellucid_testbench::arch::ARCHITECTURES;
use std::path::Path;
use std::process::Command;

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
            let bits = changes.map(|(at, v)| (times[at as usize], v.to_bit_string().unwrap()));
            (name, bits.collect())
        })
        .collect();
    all.sort();
    all
}

#[test]
fn gtkwave_reads_the_same_values() {
    // It comes with GTKWave.
    if !tools::have(&["vcd2fst"]) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["run", "--scene", "glass", "--width", "40", "--height", "30", "--quiet"])
        .args(["--wave", "0..300", "--out"])
        .arg(folder.path())
        .status()
        .unwrap();
    assert!(run.success());
    let (vcd, fst) = (folder.path().join("wave.vcd"), folder.path().join("wave.fst"));
    let converted = Command::new("vcd2fst").arg(&vcd).arg(&fst).output().unwrap();
    assert!(converted.status.success(), "{}", String::from_utf8_lossy(&converted.stderr));
    let (before, after) = (changes(&vcd), changes(&fst));
    assert!(before.len() > 100, "only {} signals", before.len());
    assert_eq!(before, after);
}

/// The signals that a save file names, in their order.
fn intended(save: &str) -> Vec<String> {
    save.lines().filter(|line| line.starts_with("top.")).map(str::to_string).collect()
}

/// What GTKWave shows is what the save file names: it drops a signal that it does not know without a word.
#[test]
fn gtkwave_shows_what_is_intended_of_every_architecture() {
    if !tools::have(&["gtkwave", "xvfb-run"]) {
        return;
    }
    for arch in ARCHITECTURES {
        for (preset, _) in (arch.presets)() {
            let folder = tempfile::tempdir().unwrap();
            let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
                .args(["run", "--scene", "glass", "--width", "40", "--height", "30", "--quiet"])
                .args(["--arch", arch.name, "--preset", preset, "--wave", "0..300", "--out", "a"])
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
