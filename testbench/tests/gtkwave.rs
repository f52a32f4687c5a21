//! GTKWave's own reader takes the waveform: `vcd2fst` converts it, and every value survives.

mod tools;

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
